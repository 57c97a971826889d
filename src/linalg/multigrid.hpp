// SPDX-License-Identifier: MIT
// A V-cycle for block matrices (3 x 3) on the nodes of a grid: geometric coarsening by two, trilinear interpolation,
// Galerkin products, damped block Jacobi before and after, Cholesky on the coarsest level (e.g. Trottenberg, Oosterlee
// & Schueller 2001, ch. 2). A symmetric positive definite approximation of the inverse.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "grid/parallel.hpp"
#include "linalg/grid_kernels.hpp"
#include "linalg/packed_factor.hpp"

namespace dqa {

using GridNode = std::array<int, 3>;

// A 3 x 3 block, row-major, times `scale` by columns of four.
template <class Real>
inline void by_columns(const double* block, double scale, Real* out) {
    for (std::size_t column = 0; column < 3; ++column) {
        for (std::size_t row = 0; row < 3; ++row)
            out[4 * column + row] = static_cast<Real>(scale * block[3 * row + column]);
        out[4 * column + 3] = 0;
    }
}

// Trilinear interpolation between the nodes of a grid and those of one twice as coarse, by rows both ways.
struct GridTransfer {
    std::vector<GridNode> coarse;  // node (i, j, k) stands at (2 i, 2 j, 2 k)
    // Of each fine node: the one to eight coarse nodes around it, of equal weights, then coarse.size(). Always eight,
    // as the processor cannot guess their number.
    std::vector<std::array<int, 8>> fine_from;
    std::vector<float> fine_weight;
    std::vector<int> coarse_start{0}, coarse_to;  // of each coarse node: fine nodes
    std::vector<float> coarse_weight;             // halves, quarters, eighths: exact

    explicit GridTransfer(const std::vector<GridNode>& fine);

    TransferRows rows() const {
        return {fine_from.data()->data(), fine_weight.data(), coarse_start.data(), coarse_to.data(),
                coarse_weight.data()};
    }
    // Bytes that the two read.
    std::size_t bytes() const {
        return fine_from.size() * (sizeof(fine_from[0]) + sizeof(float)) +
               coarse_to.size() * (sizeof(int) + sizeof(float)) + coarse_start.size() * sizeof(int);
    }
};

// Compressed rows of 3 x 3 blocks, row-major, all of them (both triangles).
struct BlockMatrix {
    std::vector<int> start{0}, column;
    std::vector<std::array<double, 9>> block;
    int size() const { return static_cast<int>(start.size()) - 1; }
};

// Vectors are [n][4] with the fourth entry 0.
template <class Real>
class Multigrid {
public:
    // Nodes couple to their neighbours at most one away along each axis.
    Multigrid(std::vector<GridNode> nodes, BlockMatrix matrix, InstructionSet instructions);

    struct Workspace {
        std::vector<std::vector<Real>> right, solution, residual;  // by level
        PackedFactor::Workspace factor;
    };
    // solution [n + 1][4] of the right-hand side Q^T fine, by the transfer from the fine nodes to the first level; the
    // last four are zero. Returned is a part of the workspace.
    const Real* solve(const GridTransfer& transfer, const Real* fine, Threads threads, Workspace& ws) const;
    // Bytes of what a cycle reads: blocks and their places, transfers, and the factor both ways.
    std::int64_t bytes() const;
    long factor_entries() const { return coarsest_->entries(); }

private:
    struct Level {
        std::vector<int> start, column;
        std::vector<Real> block;    // [block][3 columns][4]
        std::vector<Real> inverse;  // damped inverse of the diagonal blocks, [n][3 columns][4]
        std::unique_ptr<GridTransfer> transfer;
        int size() const { return static_cast<int>(start.size()) - 1; }
        LevelRows<Real> rows() const { return {start.data(), column.data(), block.data(), inverse.data()}; }
    };
    void prepare(Workspace& ws) const;
    const Real* cycle(std::size_t level, const GridTransfer& transfer, const Real* fine, Threads threads,
                      Workspace& ws) const;

    const GridKernels<Real>& kernels_;
    std::vector<Level> levels_;
    std::unique_ptr<PackedFactor> coarsest_;
};

// Inverse of a symmetric positive 3 x 3 block with the rows and columns of zero diagonal left out, or of its diagonal
// if it is not positive definite.
std::array<double, 9> invert_block(const std::array<double, 9>& block);

extern template class Multigrid<float>;
extern template class Multigrid<double>;

}  // namespace dqa
