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

class WorkCrew {
public:
    explicit WorkCrew(int threads)
        : threads_(threads), shares_(std::make_unique<Share[]>(static_cast<std::size_t>(threads))) {}
    WorkCrew(const WorkCrew&) = delete;
    WorkCrew& operator=(const WorkCrew&) = delete;

    // Runs `work` on the calling thread with threads - 1 helpers standing by for for_chunks.
    void run(const std::function<void()>& work);
    // f(chunk) for chunks 0 ... count - 1, any order, any thread; only from within run, on the calling thread.
    void for_chunks(int count, const std::function<void(int)>& f);

private:
    // Chunks of a share that nobody has taken: the first in the upper half, one past the last in the lower.
    struct alignas(64) Share {
        std::atomic<std::uint64_t> left{0};
        int take_first();  // -1: none is left
        int take_last();
    };

    void help(int self);
    void take_chunks(int self);
    void run_chunk(int chunk);

    int threads_;
    std::unique_ptr<Share[]> shares_;
    // Even: no loop is open; odd: one is. Workers announce themselves in inside_ before they look, and the caller
    // closes the loop before it looks at inside_: one of the two always sees the other.
    alignas(64) std::atomic<std::uint32_t> epoch_{0};
    alignas(64) std::atomic<int> inside_{0};
    std::atomic<bool> stop_{false};
    const std::function<void(int)>* job_ = nullptr;
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
        with_crew(threads.count, [&](Threads t) { t.crew->for_chunks(chunks, one); });
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
