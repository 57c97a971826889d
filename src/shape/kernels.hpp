// SPDX-License-Identifier: MIT
// Kernels of the convolutional barycentre, one table per instruction set: products with the Gaussian along an axis, and
// exp and log of arrays. The order x | y z | z y | x of the axes lets one half-iteration K (w K (v .)) do its inner
// half slab by slab on the rows that the base covers, with the two passes along x over columns of all slabs.
#pragma once

#include "grid/simd.hpp"

namespace dqa {

constexpr int kColumnBlock = 64;  // columns of one pass along x
constexpr int kLogLines = 16;     // lines of one pass in logarithms

// The Gaussian on a box of [nx][ny][nz] cells. taps[a] + n_a - 1 is the weight at distance 0; offsets beyond the reach,
// where exp underflows to zero, are skipped, which changes no bit. Three zeros stand beyond either end of taps.
struct GaussianGrid {
    int cells[3];
    int reach[3];
    const double* taps[2];  // [2 n_a - 1] along x and y
    const double* along_z;  // [nz][padded_z(nz)], zeros beyond nz
};

constexpr int padded_z(int nz) {
    return (nz + 7) / 8 * 8;
}

// What one base covers: slabs [first, last), of each slab the rows [rows[2 x], rows[2 x + 1]).
struct Cover {
    int first, last;
    const int* rows;  // [nx][2]
};

struct BarycenterKernels {
    // Columns [c0, c1) of the planes, at most kColumnBlock of them: out = K_x (factor in), or K_x exp(in) if factor is
    // null; out is set in the slabs of the cover. scratch: 2 nx kColumnBlock.
    void (*forward_columns)(const GaussianGrid& grid, const Cover& cover, const double* in, const double* factor,
                            double* out, int c0, int c1, double* scratch);
    // One slab, in place: K_y K_z (w K_y K_z a) on the rows of the cover. w = share / (K a), kept with K a if `ratio`
    // is null; else w = share ratio, with share and ratio as given. scratch: (2 ny + 2 rows) padded_z(nz).
    void (*slab)(const GaussianGrid& grid, const Cover& cover, int x, const double* share, const double* ratio,
                 double* kv, double* w, double* a, double* scratch);
    // out = factor (K_x a) - minus, over all slabs from those of the cover; with factor null out = log max(K_x a,
    // floor).
    void (*backward_columns)(const GaussianGrid& grid, const Cover& cover, const double* a, const double* factor,
                             const double* minus, double floor, double* out, int c0, int c1, double* scratch);
    // Lines [l0, l1), at most kLogLines of them, along an axis of n cells that are `step` apart, all in logarithms:
    // out = log(K exp(in)), -infinity where every entry of the line is; cost[k] = k^2 / (2 sigma^2), -n < k < n.
    // value unless null, in place: its mean under K exp(in), 0 where that is nothing. scratch: 4 n kLogLines.
    void (*log_lines)(const double* cost, int n, long step, const double* in, double* out, double* value, int l0,
                      int l1, double* scratch);
    // Within 2 units in the last place. exp: 0 below the least double, infinity above the largest. log: of positive,
    // normal numbers.
    void (*exp)(const double* in, double* out, int n);
    void (*log)(const double* in, double* out, int n);
};

const BarycenterKernels& barycenter_kernels(InstructionSet set);
const BarycenterKernels& shape_kernels_baseline();
const BarycenterKernels& shape_kernels_avx2();
const BarycenterKernels& shape_kernels_avx512();

}  // namespace dqa
