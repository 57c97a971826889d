// SPDX-License-Identifier: MIT
// How often a closed mesh winds around a point, from the triangles that a ray along an axis meets.
#pragma once

#include <array>
#include <vector>

#include "grid/box.hpp"

namespace dqa {

class WindingNumber {
public:
    // Keeps references. Rays run along +`axis`.
    WindingNumber(const std::vector<Vec3>& vertices, const std::vector<std::array<int, 3>>& triangles,
                  std::size_t axis);

    struct Count {
        int winding = 0;         // 0 outside, 1 inside one component that is oriented outwards
        bool uncertain = false;  // the ray runs so close to an edge that rounding decides: a neighbouring point will do
    };
    // As if the triangles in `passed`, on which x lies, were behind the start of the ray.
    Count ahead(const Vec3& x, const std::vector<int>& passed) const;

private:
    int bin_of(double x, std::size_t side) const;

    const std::vector<Vec3>& vertices_;
    const std::vector<std::array<int, 3>>& triangles_;
    std::size_t axis_;
    // Triangles by their shadows on a grid across the axis, whose sides are the two axes after it.
    std::array<std::size_t, 2> side_;
    std::array<double, 2> lo_{0, 0}, per_unit_{0, 0};
    std::array<int, 2> bins_{1, 1};
    std::vector<std::size_t> first_;
    std::vector<int> triangle_;
};

}  // namespace dqa
