// SPDX-License-Identifier: MIT
#include "grid/parallel.hpp"

#include <thread>

#if defined(_OPENMP)
#include <omp.h>
#endif

namespace dqa {
namespace {

constexpr int kSpins = 2000;  // some 50 microseconds: longer than the gaps between loops, shorter than a time slice

inline void relax() {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#else
    std::this_thread::yield();
#endif
}

}  // namespace

void WorkCrew::take_chunks() {
    for (int k = next_.fetch_add(1); k < count_; k = next_.fetch_add(1)) {
        try {
            (*job_)(k);
        } catch (...) {
            const std::lock_guard<std::mutex> lock(error_mutex_);
            if (!error_) error_ = std::current_exception();
            next_.store(count_);  // the rest need not run
        }
    }
}

void WorkCrew::help() {
    std::uint32_t seen = 0;
    while (true) {
        for (int spin = 0; spin < kSpins && epoch_.load() == seen; ++spin) relax();
        epoch_.wait(seen);
        ++inside_;
        seen = epoch_.load();
        if (seen & 1u) take_chunks();
        --inside_;
        // After `seen`: stop_ is set before the last change of the epoch, so that who has seen that change sees stop_
        // too. Looked at before, the end could come in between, and the helper would wait for a change after the last.
        if (stop_.load()) return;
    }
}

void WorkCrew::for_chunks(int count, const std::function<void(int)>& f) {
    count_ = count;
    job_ = &f;
    next_.store(0);
    ++epoch_;
    epoch_.notify_all();
    take_chunks();
    ++epoch_;
    while (inside_.load() != 0) relax();
    if (error_) {
        const std::exception_ptr error = error_;
        error_ = nullptr;
        std::rethrow_exception(error);
    }
}

void WorkCrew::run(const std::function<void()>& work) {
    std::exception_ptr error;
    const auto lead = [&] {
        try {
            work();
        } catch (...) {
            error = std::current_exception();
        }
        stop_.store(true);
        epoch_ += 2;
        epoch_.notify_all();
    };
#if defined(_OPENMP)
#pragma omp parallel num_threads(threads_)
    {
        if (omp_get_thread_num() == 0)
            lead();
        else
            help();
    }
#else
    std::vector<std::thread> helpers;
    for (int k = 1; k < threads_; ++k) helpers.emplace_back([this] { help(); });
    lead();
    for (std::thread& t : helpers) t.join();
#endif
    if (error) std::rethrow_exception(error);
}

}  // namespace dqa
