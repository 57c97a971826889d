// SPDX-License-Identifier: MIT
// Preconditioner of the barycentre's tangent systems. I - J_i moves mass by about sigma cells: what varies over the
// whole body it hardly sees, and conjugate gradients alone carry it from end to end in steps of that length. On such
// functions I - J_i is close to a diffusion, <z, (I - J_i) z>_p ~ sigma^2 sum_c p |grad z|^2 (two kernel steps of
// variance sigma^2 each, halved), the same for all bases. It is solved on a coarse grid: r -> r + C A^-1 C^T (p r),
// with C trilinear interpolation from nodes three cells apart and A = C^T L C of the diffusion L between
// neighbouring cells.
#pragma once

#include <array>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

namespace dqa {

class CoarseCorrection {
public:
    // p [n], relative to its peak.
    CoarseCorrection(const std::array<int, 3>& cells, double sigma, const std::vector<double>& p);

    // The weight p of the product, from now on; A stays that of the p it was built for.
    void reweight(const std::vector<double>& p) { p_ = p; }

    // z = r + C A^-1 C^T (p r); r, z [n]. Returns sum p r z.
    double apply(const double* r, double* z) const;

private:
    struct Line {
        int low = 0;
        double high_share = 0.0;  // weight of node low + 1
    };

    std::array<int, 3> cells_, nodes_;
    std::array<std::vector<Line>, 3> lines_;
    std::vector<double> p_;
    std::vector<int> number_;  // of a node among those that carry mass, or -1
    Eigen::Index unknowns_ = 0;
    Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
};

}  // namespace dqa
