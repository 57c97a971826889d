// SPDX-License-Identifier: MIT
#include "grid/parallel.hpp"

#include <unistd.h>

#include <latch>
#include <system_error>
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

#if defined(_OPENMP)
// Of the process that has loaded the library. In a child of it by fork, OpenMP's pool of threads is not there any more,
// and a parallel region waits for it for ever.
const pid_t loaded_by = ::getpid();

// Where OpenMP cannot have the threads that it wants it ends the process. So they are asked for first, all at a time,
// whenever there are more than ever before.
bool openmp_can(int threads) {
    static std::atomic<int> proven{1};
    if (::getpid() != loaded_by) return false;
    if (threads <= proven.load()) return true;
    std::latch enough(1);
    std::vector<std::thread> probes;
    bool all = true;
    try {
        for (int k = 1; k < threads; ++k) probes.emplace_back([&enough] { enough.wait(); });
    } catch (const std::system_error&) {
        all = false;
    } catch (...) {
        enough.count_down();
        for (std::thread& t : probes) t.join();
        throw;
    }
    enough.count_down();
    for (std::thread& t : probes) t.join();
    for (int before = proven.load(); all && before < threads && !proven.compare_exchange_weak(before, threads);) {
    }
    return all;
}
#endif

}  // namespace

int WorkCrew::take(int k, std::uint32_t epoch, int count, bool last) {
    std::atomic<std::uint64_t>& left = shares_[static_cast<std::size_t>(k)].left;
    std::uint64_t now = left.load(std::memory_order_acquire);
    while (true) {
        const std::uint32_t age = epoch - static_cast<std::uint32_t>(now >> 32);
        if (age > 1u << 31) return -1;  // a newer loop than ours
        std::uint64_t first = now >> 16 & 0xffff, end = now & 0xffff;
        if (age > 0)
            first = static_cast<std::uint64_t>(share_begin(k, threads_, count)),
            end = static_cast<std::uint64_t>(share_begin(k + 1, threads_, count));
        const bool none = first >= end;
        if (none && age == 0) return -1;
        const int chunk = none ? -1 : static_cast<int>(last ? --end : first++);
        if (left.compare_exchange_weak(now, static_cast<std::uint64_t>(epoch) << 32 | first << 16 | end,
                                       std::memory_order_acq_rel, std::memory_order_acquire))
            return chunk;
    }
}

void WorkCrew::run_chunk(Job job, const void* context, int chunk) {
    if (failed_.load(std::memory_order_relaxed)) return;  // need not run
    try {
        job(context, chunk);
    } catch (...) {
        const std::lock_guard<std::mutex> lock(error_mutex_);
        if (!error_) error_ = std::current_exception();
        failed_.store(true, std::memory_order_relaxed);
    }
}

void WorkCrew::take_chunks(int self, std::uint32_t epoch) {
    // Acquired one after the other: who sees a newer loop's numbers sees the shares that the older one left.
    const int count = loop_.count.load(std::memory_order_acquire);
    const Job job = loop_.job.load(std::memory_order_acquire);
    const void* context = loop_.context.load(std::memory_order_acquire);
    for (int other = 0; other < threads_; ++other) {
        const int k = (self + other) % threads_;
        std::uint32_t taken = 0;
        for (int chunk = take(k, epoch, count, other > 0); chunk >= 0; chunk = take(k, epoch, count, other > 0)) {
            run_chunk(job, context, chunk);
            ++taken;
        }
        if (taken > 0) shares_[static_cast<std::size_t>(k)].finished.fetch_add(taken, std::memory_order_release);
    }
}

void WorkCrew::help(int self) {
    std::uint32_t seen = 0;
    while (true) {
        for (int spin = 0; spin < kSpins && loop_.epoch.load(std::memory_order_relaxed) == seen; ++spin) relax();
        loop_.epoch.wait(seen);
        seen = loop_.epoch.load(std::memory_order_acquire);
        if (!loop_.job.load(std::memory_order_acquire)) return;
        take_chunks(self, seen);
    }
}

void WorkCrew::for_chunks(int count, Job job, const void* context) {
    if (count > kMost) {  // as few calls of more chunks each
        const int group = count / kMost + 1;
        for_chunks((count + group - 1) / group, [&](int k) {
            for (int chunk = k * group; chunk < std::min(count, (k + 1) * group); ++chunk) job(context, chunk);
        });
        return;
    }
    loop_.count.store(count, std::memory_order_release);
    loop_.job.store(job, std::memory_order_release);
    loop_.context.store(context, std::memory_order_release);
    const std::uint32_t epoch = loop_.epoch.load(std::memory_order_relaxed) + 1;
    loop_.epoch.store(epoch);
    loop_.epoch.notify_all();
    take_chunks(0, epoch);
    for (int k = 0; k < threads_; ++k) {
        Share& share = shares_[static_cast<std::size_t>(k)];
        share.begun +=
            static_cast<std::uint32_t>(share_begin(k + 1, threads_, count) - share_begin(k, threads_, count));
        while (share.finished.load(std::memory_order_acquire) != share.begun) relax();
    }
    if (failed_.load(std::memory_order_relaxed)) {
        const std::exception_ptr error = std::exchange(error_, nullptr);
        failed_.store(false, std::memory_order_relaxed);
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
        loop_.job.store(nullptr, std::memory_order_release);
        ++loop_.epoch;
        loop_.epoch.notify_all();
    };
#if defined(_OPENMP)
    if (openmp_can(threads_)) {
#pragma omp parallel num_threads(threads_)
        {
            if (omp_get_thread_num() == 0)
                lead();
            else
                help(omp_get_thread_num());
        }
        if (error) std::rethrow_exception(error);
        return;
    }
#endif
    // As many helpers as there can be: what they do not do the caller does, with the same result.
    std::vector<std::thread> helpers;
    helpers.reserve(static_cast<std::size_t>(threads_));
    try {
        for (int k = 1; k < threads_; ++k) helpers.emplace_back([this, k] { help(k); });
    } catch (const std::system_error&) {
    }
    lead();
    for (std::thread& t : helpers) t.join();
    if (error) std::rethrow_exception(error);
}

}  // namespace dqa
