// SPDX-License-Identifier: MIT
#include "optimize/optimizer.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace dqa {

void adam_step(double* x, const double* gradient, const double* rates, double* first, double* second, std::int64_t n,
               std::int64_t iteration) {
    constexpr double beta1 = 0.9, beta2 = 0.999, epsilon = 1e-8;
    const double t = static_cast<double>(iteration);
    const double correct1 = 1.0 - std::pow(beta1, t), correct2 = 1.0 - std::pow(beta2, t);
    for (std::int64_t i = 0; i < n; ++i) {
        first[i] = beta1 * first[i] + (1.0 - beta1) * gradient[i];
        second[i] = beta2 * second[i] + (1.0 - beta2) * gradient[i] * gradient[i];
        x[i] -= rates[i] * (first[i] / correct1) / (std::sqrt(second[i] / correct2) + epsilon);
    }
}

void project_simplex(double* x, std::int64_t n) {
    // The projection does not change when all move alike, and what lies two below the largest is not in it: from there
    // the sums neither overflow nor cancel.
    const double largest = *std::max_element(x, x + n);
    for (std::int64_t k = 0; k < n; ++k) x[k] = std::max(x[k] - largest, -2.0);
    std::vector<double> sorted(x, x + n);
    std::sort(sorted.begin(), sorted.end(), std::greater<>());
    double sum = 0.0, shift = 0.0;
    for (std::int64_t k = 0; k < n; ++k) {
        sum += sorted[static_cast<std::size_t>(k)];
        const double candidate = (sum - 1.0) / static_cast<double>(k + 1);
        if (sorted[static_cast<std::size_t>(k)] > candidate) shift = candidate;
    }
    double total = 0.0;
    for (std::int64_t k = 0; k < n; ++k) x[k] = std::max(0.0, x[k] - shift), total += x[k];
    for (std::int64_t k = 0; k < n; ++k) x[k] /= total;  // removes the last rounding from the sum
}

}  // namespace dqa
