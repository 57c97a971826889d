// SPDX-License-Identifier: MIT
// Kernels of the packed supernodal triangular solve, one table per instruction set. In single precision they serve as a
// preconditioner and are bound by the traffic of the factor's entries; double precision is there for comparison.
#pragma once

#include <cstdint>

#include "grid/simd.hpp"

namespace dqa {

// Rows of a packed chunk: one line of 64 bytes.
template <class Real>
constexpr int kFactorLanes = static_cast<int>(64 / sizeof(Real));

// Offset of the chunk that begins at row r of B (a multiple of lanes): chunks of the triangle L11^-1 hold the columns
// up to their last row alone. And of the chunk of B^T that begins at column c: rows above it are zero and not stored.
static inline constexpr std::int64_t packed_forward_offset(int lanes, int columns, int r) {
    const std::int64_t k = r / lanes, triangle = k < columns / lanes ? k : columns / lanes;
    return lanes * (lanes * triangle * (triangle + 1) / 2 + (k - triangle) * columns);
}
static inline constexpr std::int64_t packed_backward_offset(int lanes, int total, int c) {
    const std::int64_t k = c / lanes;
    return lanes * (k * total - lanes * k * (k - 1) / 2);
}

// One supernode: columns [first, first + columns), rows_below rows listed elsewhere.
struct PackedSupernode {
    int first = 0, columns = 0, rows_below = 0;
    int row_offset = 0;         // into the row list
    std::int64_t forward = 0;   // offset of B = [L11^-1; L21 L11^-1], chunks of lanes rows; see packed_factor.hpp
    std::int64_t backward = 0;  // offset of B^T, chunks of lanes columns
};

// Vectors hold one right-hand side, [n][1], or three and padding, [n][4], in elimination order; s numbers a row. Rows
// from `top` on are read and written at outside + s (row - top) instead of x + s row.
template <class Real>
struct FactorKernels {
    // Of one supernode, rows [begin, end) of B, begin a multiple of lanes: own rows are set, rows below reduced.
    // in [columns][s]: its own entries before the sweep.
    void (*forward)(const PackedSupernode& node, const int* rows, const Real* values, const Real* in, int begin,
                    int end, Real* x, Real* outside, int top);
    // in [columns + rows_below][s]: own entries, then minus those of the rows below. Sets own columns [begin, end).
    void (*backward)(const PackedSupernode& node, const Real* values, const Real* in, int begin, int end, Real* x);
    // The inputs of both.
    void (*own)(const PackedSupernode& node, const Real* x, Real* in);
    void (*below)(const PackedSupernode& node, const int* rows, const Real* x, const Real* outside, int top, Real* in);
};

// For one right-hand side and for three.
template <class Real>
struct FactorTables {
    FactorKernels<Real> one, three;
};
struct LinalgKernels {
    FactorTables<float> single_factor;
    FactorTables<double> double_factor;
};

const LinalgKernels& linalg_kernels(InstructionSet set);
const LinalgKernels& linalg_kernels_baseline();
const LinalgKernels& linalg_kernels_avx2();
const LinalgKernels& linalg_kernels_avx512();

}  // namespace dqa
