// SPDX-License-Identifier: MIT
// The half-iterations of the convolutional barycentre for all bases at once, and their Jacobians: p_i -> w_i =
// p_i / (K v_i) -> d_i = K w_i. What lies outside the rows that a base covers is never computed; work is shared between
// threads by bases, columns and slabs, and its results do not depend on how.
#pragma once

#include <memory>
#include <vector>

#include "grid/parallel.hpp"
#include "shape/gaussian_kernel.hpp"
#include "shape/kernels.hpp"

namespace dqa {

using Densities = std::vector<std::vector<double>>;

class Transport {
public:
    // logarithmic: which form of the kernel each base takes. Linear form: K v and w as they are. Logarithmic form:
    // their logarithms, -infinity where p_i is zero.
    Transport(const GaussianKernel& kernel, const Densities& bases, std::vector<char> logarithmic, Threads threads);

    // x = log v [m][n] -> K v, w on the cover, log d; each [m][n]. d is floored at `floor` in the linear form.
    void sweep(const double* x, double* kv, double* w, double* log_d, double floor) const;

    const GaussianKernel& kernel() const { return kernel_; }
    const std::vector<char>& logarithmic() const { return logarithmic_; }
    bool logarithmic(std::size_t i) const { return logarithmic_[i] != 0; }
    void make_logarithmic(std::size_t i) { logarithmic_[i] = 1; }
    Threads threads() const { return threads_; }
    std::size_t bases() const { return bases_.size(); }
    std::size_t cells() const { return n_; }
    // Whether base i covers cell c by its hull of rows; elsewhere kv and w stay as they were.
    bool covers(std::size_t i, std::size_t c) const;

private:
    friend class Jacobian;
    // forward(k, plane, c0, c1, scratch), slab(k, x, plane, scratch), backward(k, plane, c0, c1, scratch) for the k
    // listed.
    template <class Forward, class Slab, class Backward>
    void run(const std::vector<std::size_t>& listed, Forward&& forward, Slab&& slab, Backward&& backward) const;

    const GaussianKernel& kernel_;
    const Densities& bases_;
    std::vector<char> logarithmic_;  // [m]
    Threads threads_;
    std::size_t n_;
    const BarycenterKernels& kernels_;
    std::vector<std::vector<int>> rows_;  // [m][nx][2]
    std::vector<Cover> covers_;
    std::unique_ptr<double[]> planes_;  // between the passes of one call; calls do not overlap
};

// J_i = diag(1/d) K diag(w / (K v)) K diag(v), a stochastic matrix: positive semi-definite and self-adjoint under the
// weight v d. The forms are those of the transport now. Exact at x if all four come from one sweep; with v = p / d, K v
// of that v and the w that gave d, it is self-adjoint under p and differs from the exact one by the error of the
// iterate.
class Jacobian {
public:
    Jacobian(const Transport& transport, const double* x, const double* kv, const double* w, const double* log_d);

    // out_k = in_k - J_i in_k, i = which[k]; in, out [which.size()][n].
    void laplacian(const std::vector<std::size_t>& which, const double* in, double* out) const;

private:
    const Transport& t_;
    std::vector<double> v_, w_, ratio_, inv_d_;  // of bases in that form: logarithms of v and w, and no others
};

}  // namespace dqa
