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

int WorkCrew::Share::take_first() {
    std::uint64_t now = left.load();
    do
        if (now >> 32 >= (now & 0xffffffffu)) return -1;
    while (!left.compare_exchange_weak(now, now + (std::uint64_t{1} << 32)));
    return static_cast<int>(now >> 32);
}

int WorkCrew::Share::take_last() {
    std::uint64_t now = left.load();
    do
        if (now >> 32 >= (now & 0xffffffffu)) return -1;
    while (!left.compare_exchange_weak(now, now - 1));
    return static_cast<int>(now & 0xffffffffu) - 1;
}

void WorkCrew::run_chunk(int chunk) {
    try {
        (*job_)(chunk);
    } catch (...) {
        const std::lock_guard<std::mutex> lock(error_mutex_);
        if (!error_) error_ = std::current_exception();
        for (int k = 0; k < threads_; ++k) shares_[static_cast<std::size_t>(k)].left.store(0);  // need not run
    }
}

void WorkCrew::take_chunks(int self) {
    Share& own = shares_[static_cast<std::size_t>(self)];
    for (int k = own.take_first(); k >= 0; k = own.take_first()) run_chunk(k);
    for (int other = 1; other < threads_; ++other) {
        Share& share = shares_[static_cast<std::size_t>((self + other) % threads_)];
        for (int k = share.take_last(); k >= 0; k = share.take_last()) run_chunk(k);
    }
}

void WorkCrew::help(int self) {
    std::uint32_t seen = 0;
    while (true) {
        for (int spin = 0; spin < kSpins && epoch_.load() == seen; ++spin) relax();
        epoch_.wait(seen);
        ++inside_;
        seen = epoch_.load();
        if (seen & 1u) take_chunks(self);
        --inside_;
        // After `seen`: stop_ is set before the last change of the epoch, so that who has seen that change sees stop_
        // too. Looked at before, the end could come in between, and the helper would wait for a change after the last.
        if (stop_.load()) return;
    }
}

void WorkCrew::for_chunks(int count, const std::function<void(int)>& f) {
    job_ = &f;
    const auto bound = [&](int k) {
        return static_cast<std::uint64_t>(count) * static_cast<std::uint64_t>(k) / static_cast<std::uint64_t>(threads_);
    };
    for (int k = 0; k < threads_; ++k) shares_[static_cast<std::size_t>(k)].left.store(bound(k) << 32 | bound(k + 1));
    ++epoch_;
    epoch_.notify_all();
    take_chunks(0);
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
            help(omp_get_thread_num());
    }
#else
    std::vector<std::thread> helpers;
    for (int k = 1; k < threads_; ++k) helpers.emplace_back([this, k] { help(k); });
    lead();
    for (std::thread& t : helpers) t.join();
#endif
    if (error) std::rethrow_exception(error);
}

}  // namespace dqa
