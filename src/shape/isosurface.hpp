// SPDX-License-Identifier: MIT
// Closed triangle surface {value = level} of cell-centred values, e.g. of the density at half its peak.
#pragma once

#include <array>
#include <vector>

#include "grid/box.hpp"

namespace dqa {

struct Isosurface {
    std::vector<Vec3> vertices;                 // m, in the frame of the box
    std::vector<std::array<int, 3>> triangles;  // counter-clockwise seen from the side of lower values
};

// values: one finite number per cell, indexed by box.cell(i, j, k); level > 0 in their unit. Outside the box the value
// is 0, so the surface is always a closed manifold (possibly empty).
Isosurface extract_isosurface(const Box& box, const double* values, double level);

}  // namespace dqa
