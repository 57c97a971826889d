// SPDX-License-Identifier: MIT
// Threads of one call: OpenMP loops whose results do not depend on the number of threads, and that carry exceptions
// out of the parallel region. Sums are taken over chunks of fixed size and added in order.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <vector>

namespace dqa {

// f(begin, end) over [0, n) in chunks of `grain`; any order, any thread.
template <class F>
void parallel_chunks(int threads, int n, int grain, F&& f) {
    const int chunks = (n + grain - 1) / grain;
    if (threads <= 1 || chunks <= 1) {
        for (int k = 0; k < chunks; ++k) f(k * grain, std::min(n, (k + 1) * grain));
        return;
    }
    std::exception_ptr error;
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int k = 0; k < chunks; ++k) {
        try {
            f(k * grain, std::min(n, (k + 1) * grain));
        } catch (...) {
#pragma omp critical(dqa_parallel_error)
            if (!error) error = std::current_exception();
        }
    }
    if (error) std::rethrow_exception(error);
}

// Ordered sum of f(begin, end) over chunks of `grain`: the same bits for any number of threads.
template <class F>
double parallel_sum(int threads, int n, int grain, F&& f) {
    const int chunks = (n + grain - 1) / grain;
    std::vector<double> partial(static_cast<std::size_t>(chunks), 0.0);
    parallel_chunks(threads, n, grain,
                    [&](int begin, int end) { partial[static_cast<std::size_t>(begin / grain)] = f(begin, end); });
    double sum = 0.0;
    for (const double p : partial) sum += p;
    return sum;
}

}  // namespace dqa
