// SPDX-License-Identifier: MIT
// The surface of the solid that a closed mesh describes. Components may overlap, nest, touch or pass through
// themselves: the solid is where the winding number of the mesh is positive. So a part of a triangle bounds it if the
// number is positive behind the part and not in front of it; parts inside the solid, or in a hollow that counts as
// outside, do not.
#pragma once

#include <array>
#include <vector>

#include "grid/box.hpp"
#include "shape/convex_polygon.hpp"

namespace dqa {

// Convex polygons in the order of the triangles they come from, counter-clockwise seen from outside of the solid.
struct OuterSurface {
    static constexpr int kMostCorners = 12;
    std::vector<Vec3> corner;
    std::vector<std::size_t> first{0};  // corner of each polygon, and one past the last
    bool simple = true;                 // all of the mesh bounds the solid: no component overlaps another or itself

    std::size_t size() const { return first.size() - 1; }
    ConvexPolygon polygon(std::size_t p) const {
        ConvexPolygon out;
        for (std::size_t c = first[p]; c < first[p + 1]; ++c) out.add(corner[c]);
        return out;
    }
};

// Of a closed mesh of positive volume, whose corners lie at most 100 from the origin. The triangles as
// they are if no surfaces meet or all of them count, else right to 1e-6 (1e-5
// where several sheets lie within 1e-7 of one another).
OuterSurface outer_surface(const std::vector<Vec3>& vertices, const std::vector<std::array<int, 3>>& triangles);

}  // namespace dqa
