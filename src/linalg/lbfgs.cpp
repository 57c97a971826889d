// SPDX-License-Identifier: MIT
#include "linalg/lbfgs.hpp"

#include <cmath>

#include "linalg/pcg.hpp"

namespace dqa {

void Lbfgs::remember(const std::vector<double>& step, const std::vector<double>& gradient_change) {
    const std::size_t n = step.size();
    const double sy = ordered_dot(step.data(), gradient_change.data(), n);
    const double scale = std::sqrt(ordered_dot(step.data(), step.data(), n) *
                                   ordered_dot(gradient_change.data(), gradient_change.data(), n));
    if (!(sy > 1e-10 * scale)) return;
    if (pairs_.size() == history_) pairs_.pop_front();
    pairs_.push_back({step, gradient_change, 1.0 / sy});
}

void Lbfgs::direction(const double* gradient, const std::function<void(const double*, double*)>& initial,
                      std::vector<double>& direction) {
    const std::size_t n = direction.size();
    work_.assign(gradient, gradient + n);
    std::vector<double> alpha(pairs_.size());
    for (std::size_t k = pairs_.size(); k-- > 0;) {
        const Pair& p = pairs_[k];
        alpha[k] = p.inv_sy * ordered_dot(p.s.data(), work_.data(), n);
        for (std::size_t i = 0; i < n; ++i) work_[i] -= alpha[k] * p.y[i];
    }
    initial(work_.data(), direction.data());
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
        const Pair& p = pairs_[k];
        const double beta = p.inv_sy * ordered_dot(p.y.data(), direction.data(), n);
        for (std::size_t i = 0; i < n; ++i) direction[i] += (alpha[k] - beta) * p.s[i];
    }
    for (double& d : direction) d = -d;
}

}  // namespace dqa
