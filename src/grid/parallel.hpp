// SPDX-License-Identifier: MIT
// Threads of one call: loops whose results do not depend on the number of threads, and that carry exceptions out of the
// parallel part. Sums are taken over chunks of fixed size and added in order.
//
// A step runs thousands of loops of some ten microseconds. Opening a parallel region for each would wait at every
// loop's end for all threads, also for one that the system has put aside: on a busy machine that costs a time slice a
// loop. So a WorkCrew opens one region around the whole step; inside it the calling thread posts loops, and workers
// help with chunks while there are any. The caller waits only for chunks that a worker has begun.
//
// Each thread begins with a share of its own: the first of T threads with the first T-th of the chunks, and so on. As
// loops over cells, nodes and faces all run along the body, a thread finds in its cache what it left there in the loop
// before; who is done with his share helps the others from the ends of theirs.
//
// What one thread has written costs another a hundred nanoseconds to read, and a small body's loop takes two thousand.
// So the caller publishes a loop in one cache line, and a share stays in its owner's cache unless it is helped with.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace dqa {

// The first chunk of share k; share k of T ends where share k + 1 begins.
inline int share_begin(int k, int threads, int count) {
    return static_cast<int>(static_cast<std::int64_t>(count) * k / threads);
}

class WorkCrew {
public:
    explicit WorkCrew(int threads)
        : threads_(threads), shares_(std::make_unique<Share[]>(static_cast<std::size_t>(threads))) {}
    WorkCrew(const WorkCrew&) = delete;
    WorkCrew& operator=(const WorkCrew&) = delete;

    // Runs `work` on the calling thread with threads - 1 helpers standing by for for_chunks.
    void run(const std::function<void()>& work);
    // f(chunk) for chunks 0 ... count - 1, any order, any thread; only from within run, on the calling thread.
    template <class F>
    void for_chunks(int count, const F& f) {
        for_chunks(
            count, [](const void* context, int chunk) { (*static_cast<const F*>(context))(chunk); }, &f);
    }

private:
    using Job = void (*)(const void* context, int chunk);
    // An open loop. Its job is null when there will be no more.
    struct alignas(64) Loop {
        std::atomic<std::uint32_t> epoch{0};  // counts the loops
        std::atomic<int> count{0};
        std::atomic<Job> job{nullptr};
        std::atomic<const void*> context{nullptr};
    };
    // The chunks of a share that nobody has taken: the epoch of the loop, the first of them, one past the last. Of an
    // older epoch: nobody has looked at it in this loop, and it is whole. The caller ends a loop by leaving all shares
    // empty and in its epoch, so that a thread that comes late, wherever it was put aside, can take nothing any more.
    struct alignas(64) Share {
        std::atomic<std::uint64_t> left{0};
        std::atomic<std::uint32_t> finished{0};  // chunks of all loops
        std::uint32_t begun = 0;                 // the same, the caller's account
    };
    static constexpr int kMost = 0xffff;  // chunks that a share's number holds

    void for_chunks(int count, Job job, const void* context);
    // A chunk of share k, the last one of those left or the first; -1 if none is left.
    int take(int k, std::uint32_t epoch, int count, bool last);
    void take_chunks(int self, std::uint32_t epoch);
    void run_chunk(Job job, const void* context, int chunk);
    void help(int self);

    int threads_;
    std::unique_ptr<Share[]> shares_;
    Loop loop_;
    alignas(64) std::atomic<bool> failed_{false};
    std::mutex error_mutex_;
    std::exception_ptr error_;
};

// How a function may use threads: a number (1: none), and the crew it runs in, if any.
struct Threads {
    int count = 1;
    WorkCrew* crew = nullptr;
    Threads(int n) : count(n) {}  // NOLINT(google-explicit-constructor): a plain number says it all
    Threads(int n, WorkCrew* c) : count(n), crew(c) {}
};

// work(threads) with a crew standing by if there is more than one thread.
template <class F>
void with_crew(int count, F&& work) {
    if (count <= 1) {
        work(Threads(1));
        return;
    }
    WorkCrew crew(count);
    crew.run([&] { work(Threads(count, &crew)); });
}

// f(begin, end) over [0, n) in chunks of `grain`; any order, any thread.
template <class F>
void parallel_chunks(Threads threads, int n, int grain, F&& f) {
    const int chunks = (n + grain - 1) / grain;
    const auto one = [&](int k) { f(k * grain, std::min(n, (k + 1) * grain)); };
    if (threads.count <= 1 || chunks <= 1) {
        for (int k = 0; k < chunks; ++k) one(k);
    } else if (threads.crew) {
        threads.crew->for_chunks(chunks, one);
    } else {
        WorkCrew crew(threads.count);
        crew.run([&] { crew.for_chunks(chunks, one); });
    }
}

// Ordered sum by += of what f(begin, end) gives for chunks of `grain`: the same bits for any number of threads.
template <class T, class F>
T parallel_total(Threads threads, int n, int grain, F&& f) {
    const int chunks = (n + grain - 1) / grain;
    std::vector<T> partial(static_cast<std::size_t>(chunks));
    parallel_chunks(threads, n, grain,
                    [&](int begin, int end) { partial[static_cast<std::size_t>(begin / grain)] = f(begin, end); });
    T sum{};
    for (const T& p : partial) sum += p;
    return sum;
}
template <class F>
double parallel_sum(Threads threads, int n, int grain, F&& f) {
    return parallel_total<double>(threads, n, grain, std::forward<F>(f));
}

}  // namespace dqa
