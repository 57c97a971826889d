// SPDX-License-Identifier: MIT
// Covered fraction of every cell of the box by a closed triangle mesh, scaled and centred to fit. Dimensionless: works
// in cell units (1 = the edge of a cell).
#pragma once

#include <vector>

#include "shape/mesh.hpp"

namespace dqa {

// Cells that stay empty on each side of a mesh.
struct Margin {
    int along = 0;                                // ahead and behind, along x
    int across = 0;                               // along y and z
    Margin(int all) : along(all), across(all) {}  // NOLINT(google-explicit-constructor): one number for every side
    Margin(int a, int b) : along(a), across(b) {}
    int of(std::size_t axis) const { return axis == 0 ? along : across; }
};

// Scales `cleaned` (from clean_and_check) uniformly so that, with its centre of mass at the centre of the box, at least
// the margin's cells stay empty on every side, and returns the covered fraction of each cell in [0, 1], indexed by
// box.cell(i, j, k). Fractions are exact up to rounding, however thin a part is and however it lies; where components
// overlap they are right to 1e-5. Overlapping components form a union (winding number > 0), with the centre of mass of
// the union. `length_in_cells` (may be null) receives the mesh's scaled extent along x. The result does not depend on
// `threads`, and a mesh that mirrors across y or z gives fractions that do.
std::vector<double> covered_fractions(const TriangleMesh& cleaned, const Box& box, Margin margin, int threads,
                                      double* length_in_cells);

}  // namespace dqa
