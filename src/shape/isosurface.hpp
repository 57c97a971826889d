// SPDX-License-Identifier: MIT
// Closed surface {value = level} of cell-centred values, e.g. of the density at half its peak: triangles, or segments
// in two dimensions.
#pragma once

#include <array>
#include <vector>

#include "grid/box.hpp"

namespace dqa {

struct Isosurface {
    std::vector<Vec3> vertices;                 // m, in the frame of the box
    std::vector<std::array<int, 3>> triangles;  // counter-clockwise seen from the side of lower values
    std::vector<std::array<int, 2>> segments;   // in two dimensions: the higher values lie to their left
};

// values: one finite number per cell, indexed by box.cell(i, j, k); level > 0 in their unit. Outside the box the value
// is 0, so the surface is always a closed manifold (possibly empty).
Isosurface extract_isosurface(const Box& box, const double* values, double level);

// The same for a box in two dimensions: closed polygons at z = 0, each vertex the end of one segment and the start of
// another.
Isosurface extract_contour(const Box& box, const double* values, double level);

}  // namespace dqa
