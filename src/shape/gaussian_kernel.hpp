// SPDX-License-Identifier: MIT
// Separable Gaussian kernel K(x, y) = exp(-|x - y|^2 / (2 sigma^2)) on the cells of a box, sigma in cells
// (convolutional optimal transport, Solomon et al. 2015). Two forms of the same product: linear (fast; underflows
// beyond about 37 sigma) and logarithmic (slower, any distance).
#pragma once

#include <array>
#include <vector>

#include "grid/parallel.hpp"
#include "shape/kernels.hpp"

namespace dqa {

class GaussianKernel {
public:
    GaussianKernel(const std::array<int, 3>& cells, double sigma);

    int size() const { return cells_[0] * cells_[1] * cells_[2]; }

    const std::array<int, 3>& cells() const { return cells_; }
    double sigma() const { return sigma_; }
    // The same for the kernels of the barycentre; points into this object.
    GaussianGrid grid() const;

    // out = K in. `in` and `out` may be the same array. scratch: size() doubles.
    void apply(const double* in, double* out, double* scratch) const;

    // log_out = log(K exp(log_in)); entries of log_in may be -infinity. If `value` is given, it is replaced by
    // (K (exp(log_in) value)) / (K exp(log_in)): the mean of `value` under the kernel-weighted measure.
    // log_in and log_out may be the same array. The results do not depend on the threads.
    void apply_log(const double* log_in, double* log_out, double* value, Threads threads = 1) const;

private:
    std::array<int, 3> cells_;
    double sigma_;
    std::array<std::vector<double>, 3> matrix_;  // [n][n] of each axis, symmetric
    std::array<int, 3> reach_;                   // of each axis: exp underflows to zero beyond
    std::array<std::vector<double>, 2> taps_;    // along x and y: by offset, see GaussianGrid
    std::vector<double> cost_;                   // [2 n - 1], n of the longest axis: -log of the kernel, by offset
    std::vector<double> along_z_;                // [nz][padded_z(nz)]
};

}  // namespace dqa
