// SPDX-License-Identifier: MIT
// Limited-memory BFGS (Nocedal & Wright 2006, algorithm 7.4): the two-loop recursion around an initial inverse Hessian
// that the caller applies.
#pragma once

#include <deque>
#include <functional>
#include <vector>

namespace dqa {

class Lbfgs {
public:
    explicit Lbfgs(std::size_t history) : history_(history) {}

    void clear() { pairs_.clear(); }
    bool empty() const { return pairs_.empty(); }
    // A step and the change of the gradient along it. Pairs without positive curvature are not kept.
    void remember(const std::vector<double>& step, const std::vector<double>& gradient_change);
    // direction = -H gradient; initial(in, out) applies the initial inverse Hessian.
    void direction(const double* gradient, const std::function<void(const double*, double*)>& initial,
                   std::vector<double>& direction);

private:
    struct Pair {
        std::vector<double> s, y;
        double inv_sy;
    };
    std::size_t history_;
    std::deque<Pair> pairs_;
    std::vector<double> work_;
};

}  // namespace dqa
