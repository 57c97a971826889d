// SPDX-License-Identifier: MIT
// The box Omega: nx x ny x nz cubic cells of edge dx (m), centred at the origin; heading +x, lateral y, up z.
//
// In two dimensions it is a slab one cell thick (nz = 1) in plane strain: the two ends of an edge along z are the same
// node, at z = 0. Cells keep their eight corners, so that every formula of three dimensions holds as it stands.
#pragma once

#include <array>
#include <cstdint>

namespace dqa {

using Vec3 = std::array<double, 3>;

struct Box {
    std::array<int, 3> cells{60, 16, 26};
    double dx = 0.0;  // m
    int dims = 3;

    int n_cells() const { return cells[0] * cells[1] * cells[2]; }
    int n_nodes() const { return (cells[0] + 1) * (cells[1] + 1) * node_planes(); }
    int node_planes() const { return dims == 2 ? 1 : cells[2] + 1; }  // of nodes along z
    int cell(int i, int j, int k) const { return (i * cells[1] + j) * cells[2] + k; }
    int node(int i, int j, int k) const { return (i * (cells[1] + 1) + j) * node_planes() + (dims == 2 ? 0 : k); }
    std::array<int, 3> cell_ijk(int c) const {
        return {c / (cells[1] * cells[2]), c / cells[2] % cells[1], c % cells[2]};
    }
    // Centre of a cell (m).
    Vec3 cell_centre(int c) const {
        const auto ijk = cell_ijk(c);
        return {(ijk[0] + 0.5 - 0.5 * cells[0]) * dx, (ijk[1] + 0.5 - 0.5 * cells[1]) * dx,
                (ijk[2] + 0.5 - 0.5 * cells[2]) * dx};
    }
    // Position of a node (m).
    Vec3 node_position(int i, int j, int k) const {
        return {(i - 0.5 * cells[0]) * dx, (j - 0.5 * cells[1]) * dx, dims == 2 ? 0.0 : (k - 0.5 * cells[2]) * dx};
    }
};

}  // namespace dqa
