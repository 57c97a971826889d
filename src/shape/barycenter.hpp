// SPDX-License-Identifier: MIT
// Wasserstein barycentre of m densities on a box (Solomon et al. 2015, algorithm 2), converged to a marginal error by
// Newton's method, and its pullback by implicit differentiation of the fixed point.
//
// Unknowns x_i = log v_i, [m][n]. One iteration T, per base i:
//   w_i = p_i / (K v_i),  d_i = K w_i,  log p = sum_k alpha_k log d_k,  x_i <- log p - log d_i.
// Marginal error: max_i sum |v_i d_i - p|: how far plan i is from having p as its marginal.
//
// T's derivative on the subspace sum_i alpha_i x_i = 0 is P J with J_i of transport.hpp and P the projection onto that
// subspace, so that x - T(x) has a symmetric positive semi-definite derivative under the weight p: Newton's systems and
// that of the pullback are the same and are solved by conjugate gradients. The start comes from wider kernels, from
// four times sigma down (entropic scaling, e.g. Schmitzer 2019), whose potentials sigma^2 x differ little from those of
// sigma. Where a step does not bring the error down, Anderson's acceleration of the iteration takes over for a while.
#pragma once

#include <functional>
#include <vector>

#include "grid/parallel.hpp"
#include "shape/gaussian_kernel.hpp"

namespace dqa {

struct BarycenterSettings {
    double tolerance = 1e-9;
    int max_iterations = 5000;  // of both kinds together
    int window = 15;            // of Anderson's acceleration, where it is used; 0: nothing but the plain iteration
    Threads threads{1};
    bool force_log = false;  // always the logarithmic kernel (else where the linear one underflows, base by base)
    // Counts both kinds; may throw to cancel.
    std::function<void(int iteration, double error)> monitor;
};

struct Barycenter {
    int m = 0, n = 0;
    std::vector<double> weights;    // alpha
    std::vector<double> p;          // [n], sums to 1 within the marginal error
    std::vector<double> log_d;      // [m][n]
    std::vector<double> log_v;      // [m][n]
    std::vector<double> log_kv;     // [m][n]; where base i has cells next to each other, see transport.hpp; else 0
    std::vector<char> logarithmic;  // [m]: bases that needed that form of the kernel
    int iterations = 0;             // evaluations of T, over all widths of the kernel
    int linear_iterations = 0;      // of conjugate gradients: as much work as an evaluation, or less
    double marginal_error = 0.0;
};

// bases [m][n], each >= 0 with sum 1. Throws NOT_CONVERGED.
Barycenter solve_barycenter(const GaussianKernel& kernel, const std::vector<std::vector<double>>& bases,
                            const std::vector<double>& weights, const BarycenterSettings& settings);

// dL/dalpha, mean-free, from p_bar = dL/dp [n]. One-sided where alpha_i = 0.
std::vector<double> barycenter_pullback(const GaussianKernel& kernel, const std::vector<std::vector<double>>& bases,
                                        const Barycenter& solution, const double* p_bar,
                                        const BarycenterSettings& settings);

}  // namespace dqa
