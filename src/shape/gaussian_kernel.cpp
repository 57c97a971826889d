// SPDX-License-Identifier: MIT
#include "shape/gaussian_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <Eigen/Dense>

#if !defined(EIGEN_DONT_PARALLELIZE)
#error "Eigen would start threads of its own; the number of threads is a setting of each object"
#endif

namespace dqa {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ConstMap = Eigen::Map<const Matrix>;
using Map = Eigen::Map<Matrix>;

constexpr int kLogGrain = 8 * kLogLines;  // lines of a thread's task

}  // namespace

GaussianKernel::GaussianKernel(const std::array<int, 3>& cells, double sigma) : cells_(cells), sigma_(sigma) {
    const double inv_two_sigma2 = 0.5 / (sigma * sigma);
    for (std::size_t a = 0; a < 3; ++a) {
        const int n = cells[a];
        matrix_[a].resize(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j)
                matrix_[a][static_cast<std::size_t>(i * n + j)] = std::exp(-inv_two_sigma2 * (i - j) * (i - j));
        reach_[a] = 0;
        while (reach_[a] + 1 < n && matrix_[a][static_cast<std::size_t>(reach_[a] + 1)] > 0) ++reach_[a];
    }
    const int longest = *std::max_element(cells.begin(), cells.end());
    for (int offset = 1 - longest; offset < longest; ++offset) cost_.push_back(inv_two_sigma2 * offset * offset);
    constexpr int kBeyond = 3;  // rows of a tile of the product reach so far past the last offset
    for (std::size_t a = 0; a < 2; ++a) {
        const int n = cells[a];
        taps_[a].assign(static_cast<std::size_t>(2 * n - 1 + 2 * kBeyond), 0.0);
        for (int offset = 1 - n; offset < n; ++offset)
            taps_[a][static_cast<std::size_t>(kBeyond + n - 1 + offset)] =
                matrix_[a][static_cast<std::size_t>(std::abs(offset))];
    }
    const int nz = cells[2], width = padded_z(nz);
    along_z_.assign(static_cast<std::size_t>(nz) * static_cast<std::size_t>(width), 0.0);
    for (int i = 0; i < nz; ++i)
        for (int j = 0; j < nz; ++j)
            along_z_[static_cast<std::size_t>(i * width + j)] = matrix_[2][static_cast<std::size_t>(i * nz + j)];
}

GaussianGrid GaussianKernel::grid() const {
    return {{cells_[0], cells_[1], cells_[2]},
            {reach_[0], reach_[1], reach_[2]},
            {taps_[0].data() + 3, taps_[1].data() + 3},
            along_z_.data()};
}

void GaussianKernel::apply(const double* in, double* out, double* scratch) const {
    const int nx = cells_[0], ny = cells_[1], nz = cells_[2];
    const ConstMap kx(matrix_[0].data(), nx, nx), ky(matrix_[1].data(), ny, ny), kz(matrix_[2].data(), nz, nz);
    Map(scratch, nx * ny, nz).noalias() = ConstMap(in, nx * ny, nz) * kz;
    for (int i = 0; i < nx; ++i)
        Map(out + static_cast<long>(i) * ny * nz, ny, nz).noalias() =
            ky * ConstMap(scratch + static_cast<long>(i) * ny * nz, ny, nz);
    Map(scratch, nx, ny * nz) = ConstMap(out, nx, ny * nz);
    Map(out, nx, ny * nz).noalias() = kx * ConstMap(scratch, nx, ny * nz);
}

void GaussianKernel::apply_log(const double* log_in, double* log_out, double* value, Threads threads) const {
    const BarycenterKernels& kernels = barycenter_kernels(InstructionSet::automatic);
    const int stride[3] = {cells_[1] * cells_[2], cells_[2], 1};
    const double *in = log_in, *cost = cost_.data() + cost_.size() / 2;
    for (const std::size_t axis : {2u, 1u, 0u}) {
        const int n = cells_[axis], lines = size() / n;
        parallel_chunks(threads, lines, kLogGrain, [&](int begin, int end) {
            std::vector<double> scratch(static_cast<std::size_t>(4 * n * kLogLines));
            for (int l = begin; l < end; l += kLogLines)
                kernels.log_lines(cost, n, stride[axis], in, log_out, value, l, std::min(l + kLogLines, end),
                                  scratch.data());
        });
        in = log_out;
    }
}

}  // namespace dqa
