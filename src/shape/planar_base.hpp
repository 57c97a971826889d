// SPDX-License-Identifier: MIT
// Base shapes of a plane space: covered fractions of the cells of an nx x ny x 1 box by a closed polygon or a grey
// image, scaled uniformly to fit the box with its margins and centred by the centre of mass, as meshes are. Exact: the
// area of the polygon (or of the image's pixels) within each cell, divided by the cell's.
#pragma once

#include <array>
#include <vector>

#include "shape/voxelize.hpp"

namespace dqa {

// Corners of a simple polygon in either sense (the last one is joined to the first). `length_in_cells` receives its
// scaled extent along x.
std::vector<double> polygon_fractions(const std::vector<std::array<double, 2>>& corners, const Box& box, Margin margin,
                                      double* length_in_cells);

// Grey values in [0, 1], [rows][columns], square pixels: column 0 is the tail's side (least x), row 0 the left side
// (largest y). The extent of the body is that of its pixels above zero; its length that of those of at least 1/2.
std::vector<double> image_fractions(const double* pixels, int rows, int columns, const Box& box, Margin margin,
                                    double* length_in_cells);

}  // namespace dqa
