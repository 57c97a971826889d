// SPDX-License-Identifier: MIT
// The operator of Newton's systems and of the pullback: z -> P (I - J) z for the bases `which`, under the product
// <y, z> = sum_k weight_k sum_c p y_k z_k. P projects onto sum_k weight_k z_k = 0; without `joint` each base stands
// alone. Everything counts up to constants; p is taken relative to its peak.
#pragma once

#include <functional>
#include <vector>

#include "grid/parallel.hpp"
#include "shape/coarse_correction.hpp"
#include "shape/transport.hpp"

namespace dqa {

class Tangent {
public:
    Tangent(const Jacobian& jacobian, Threads threads, std::vector<std::size_t> which, std::vector<double> weights,
            std::vector<double> p, bool joint, const CoarseCorrection& correction)
        : jacobian_(jacobian),
          correction_(correction),
          threads_(threads),
          which_(std::move(which)),
          weights_(std::move(weights)),
          p_(std::move(p)),
          joint_(joint) {}

    std::size_t size() const { return which_.size() * p_.size(); }

    void laplacian(const std::vector<double>& in, std::vector<double>& out) const {
        jacobian_.laplacian(which_, in.data(), out.data());
    }

    // Removes the constant part of every base under p.
    void centre(std::vector<double>& z) const;

    // P z, each base centred.
    void project(std::vector<double>& z) const;

    // sum_k weight_k z_k [n]
    std::vector<double> mean(const std::vector<double>& z) const;

    double product(const std::vector<double>& y, const std::vector<double>& z) const {
        return over_cells([&](std::size_t begin, std::size_t end) { return product(y, z, begin, end); });
    }

    // Conjugate gradients for P (I - J) y = b from the given y with residual r = P (b - (I - J) y), until <r, r> <=
    // target or rounding has the better of it. tick(r's norm) counts applications.
    void solve(std::vector<double>& y, std::vector<double>& r, double target,
               const std::function<void(double)>& tick) const;

    // z from r; returns <r, z>.
    double precondition(const std::vector<double>& r, std::vector<double>& z) const;

private:
    static constexpr int kGrain = 1024, kRefresh = 10, kPatience = 200;

    template <class F>
    double over_cells(F&& f) const {
        return parallel_sum(threads_, static_cast<int>(p_.size()), kGrain, [&](int begin, int end) {
            return f(static_cast<std::size_t>(begin), static_cast<std::size_t>(end));
        });
    }
    double product(const std::vector<double>& y, const std::vector<double>& z, std::size_t begin,
                   std::size_t end) const;
    void mean_of(const std::vector<double>& z, std::size_t begin, std::size_t end, double* mean) const;

    const Jacobian& jacobian_;
    const CoarseCorrection& correction_;
    Threads threads_;
    std::vector<std::size_t> which_;
    std::vector<double> weights_, p_;
    bool joint_;
};

}  // namespace dqa
