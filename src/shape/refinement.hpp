// SPDX-License-Identifier: MIT
// Cells finer than the box's, between which the interpolation moves mass, and the way from their values to the box's.
//
// A barycentre on a grid carries mass between cell centres and spreads it by the kernel. Where the kernel is narrower
// than the cells can resolve, a body that is stretched from its bases becomes a comb: sum_j exp(-(x - j)^2 / 2 sigma^2)
// ripples by 2 exp(-2 pi^2 sigma^2) of its mean (Poisson's summation formula), 8.5 % along each axis at 0.4 cells and
// 6.5e-6 at 0.8. On cells of half the edge the same kernel (in metres) spans twice as many of them.
#pragma once

#include <vector>

#include "grid/box.hpp"

namespace dqa {

constexpr int kMaxRefinement = 4;

class Refinement {
public:
    // `factor` finer cells along every axis of a cell of `box`, in two dimensions along x and y. Throws when their
    // number does not fit an int.
    Refinement(const Box& box, int factor);

    // Of the finer cells, without an edge in metres.
    const Box& box() const { return fine_; }
    int factor() const { return factor_; }

    // Sum over the finer cells [n_fine] of every cell [n].
    std::vector<double> sum(const std::vector<double>& fine) const;
    // The transpose of sum: to every finer cell [n_fine] the value of the cell [n] that holds it.
    std::vector<double> spread(const double* coarse) const;
    // As sum, divided by the number of finer cells in a cell.
    std::vector<double> mean(const std::vector<double>& fine) const;

private:
    int holder(int fine_cell) const;  // the cell that holds it

    Box box_, fine_;
    int factor_;
};

}  // namespace dqa
