// SPDX-License-Identifier: MIT
// Loops over the nodes of grids, one table per instruction set: what the multigrid cycle and the preconditioner around
// it do node by node. Vectors of a grid are [n][4] with the fourth entry 0, blocks (3 x 3) are by columns of four.
#pragma once

#include "grid/precision.hpp"
#include "grid/simd.hpp"

namespace dqa {

// Of trilinear interpolation Q from coarse nodes to fine ones (GridTransfer).
struct TransferRows {
    const int* fine_from;      // [fine nodes][8] coarse nodes, where there are fewer: the one past the last, all zero
    const float* fine_weight;  // [fine nodes], of each of the eight
    const int* coarse_start;   // compressed rows of Q^T
    const int* coarse_to;      // fine nodes
    const float* coarse_weight;
};
// Compressed rows of a matrix of blocks, and the damped inverses of those on its diagonal.
template <class Real>
struct LevelRows {
    const int *start, *column;
    const Real *block, *inverse;
};

// All of nodes [begin, end), unless said otherwise.
template <class Real>
struct GridKernels {
    // out [count][4] = Q^T fine at the coarse nodes listed
    void (*restrict_to)(const TransferRows& q, const int* nodes, int count, const Real* fine, Real* out);
    // right = Q^T fine, x = inverse right
    void (*begin_smooth)(const LevelRows<Real>& level, const TransferRows& q, const Real* fine, int begin, int end,
                         Real* right, Real* x);
    // out = right - M x
    void (*residual)(const LevelRows<Real>& level, const Real* right, const Real* x, int begin, int end, Real* out);
    // x += Q coarse
    void (*correct)(const TransferRows& q, const Real* coarse, int begin, int end, Real* x);
    // out = x + inverse (right - M x); not in place, as the residuals of other nodes need x
    void (*end_smooth)(const LevelRows<Real>& level, const Real* right, const Real* x, int begin, int end, Real* out);
};

// Between vectors [n][3] of T in the frame of the world and those of a grid in the frames of its nodes: rotations R
// [n] by columns of four.
template <class Real, class T>
struct TurnKernels {
    // turned = R^T (scale in)
    void (*back)(const Real* turns, T scale, const T* in, int begin, int end, Real* turned);
    // out = size R (share Q coarse + local turned), or without `local` (null) that beside what `out` holds; sums
    // [2] = in.out, other.out
    void (*out)(const Real* turns, const Real* local, const TransferRows& q, const Real* coarse, Real share, T size,
                const Real* turned, const T* in, const T* other, int begin, int end, T* out, double* sums);
};

// By the precision of the grid, then by that of the vectors.
template <class Real>
struct TurnTables {
    template <class T>
    using Of = TurnKernels<Real, T>;
    InBothPrecisions<Of> vectors;
};
struct GridTables {
    InBothPrecisions<GridKernels> grid;
    InBothPrecisions<TurnTables> turns;
};

const GridTables& grid_kernels(InstructionSet set);
const GridTables& grid_kernels_baseline();
const GridTables& grid_kernels_avx2();
const GridTables& grid_kernels_avx512();

}  // namespace dqa
