// SPDX-License-Identifier: MIT
// Preconditioner of a design's Newton systems: the projective-dynamics factor A (Bouaziz et al. 2014), one scalar
// matrix for all directions, and a correction on a coarse grid:
//   P^-1 = A^-1 + 1/2 (R Q) (Q^T H_0 Q)^-1 (R Q)^T.
// A knows neither that rotations cost no energy nor how easily slender bodies bend: some tens of smooth modes are up to
// a thousand times softer than it believes, and each costs conjugate gradients several iterations. H_0, the exact
// Hessian at rest, knows them; Q interpolates trilinearly from every third node, and the rotations R of the cells
// around each node turn the modes with the body. A two-level method (e.g. Toselli & Widlund 2005, ch. 2); the half
// makes up for what both parts see. It is a function of the positions alone.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "grid/active_set.hpp"
#include "grid/parallel.hpp"
#include "linalg/packed_factor.hpp"

namespace dqa {

class Preconditioner {
public:
    struct Workspace {
        PackedFactor::Workspace factor, coarse_factor;
        std::vector<double> turns;           // R, [n_nodes][9]
        std::vector<double> turned, coarse;  // R^T residual [n_nodes][3]; coarse residual
    };

    // The factor alone; cell_weight [n_cells] weighs the cells around a node (occupancy).
    Preconditioner(const ActiveSet& set, const std::vector<double>& cell_weight, PackedFactor factor);

    // Adds the coarse correction; apply(p, out): out = H_0 p, which leaves constrained coordinates at zero.
    void add_coarse(const ActiveSet& set, const std::vector<int>& constrained,
                    const std::function<void(const double*, double*)>& apply, Precision precision,
                    InstructionSet instructions);

    // Turns the coarse modes with the positions q [n_nodes][3], before solve.
    void turn(const double* q, Threads threads, Workspace& ws) const;
    // out [n_nodes][3] ~ H^-1 in, not the same array. A symmetric positive definite operator up to rounding, if
    // constrained coordinates of `out` are ignored.
    void solve(const double* in, double* out, Threads threads, Workspace& ws) const;

    const PackedFactor& factor() const { return factor_; }

private:
    // Interpolation from the coarse nodes; compressed rows both ways.
    struct Interpolation {
        std::vector<int> start, other;
        std::vector<double> weight;
    };
    void node_turns(const double* q, Threads threads, std::vector<double>& turns) const;
    int n_nodes() const { return static_cast<int>(node_start_.size()) - 1; }
    int n_coarse() const { return static_cast<int>(to_coarse_.start.size()) - 1; }

    PackedFactor factor_;
    std::unique_ptr<PackedFactor> coarse_;
    Interpolation to_fine_, to_coarse_;
    double inv_dx_, slab_;
    std::vector<std::array<int, 8>> cell_nodes_;
    std::vector<int> node_start_, node_cells_;  // compressed rows: cells around each node
    std::vector<double> cell_weight_;
};

}  // namespace dqa
