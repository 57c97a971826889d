// SPDX-License-Identifier: MIT
// Which triangles of a closed mesh meet others elsewhere than along the edges and corners that join them: where a
// surface passes through itself or another component, or lies on it.
#pragma once

#include <array>
#include <vector>

#include "grid/box.hpp"

namespace dqa {

// Triangles closer than this count as meeting (the unit of the vertices). It lies far above the round-off of
// coordinates up to a few thousand, and far below any thickness that matters.
constexpr double kTouching = 4e-8;

// The partners of triangle t are partner[first[t]] ... partner[first[t + 1] - 1], in ascending order.
struct TriangleCrossings {
    std::vector<std::size_t> first;
    std::vector<int> partner;
    bool any(int t) const { return first[static_cast<std::size_t>(t)] != first[static_cast<std::size_t>(t) + 1]; }
};

struct TriangleEdge {
    int lo, hi;  // numbers of its ends
    int triangle;
};
// Three a triangle; those with the same ends follow one another, by triangle.
std::vector<TriangleEdge> triangle_edges(const std::vector<std::array<int, 3>>& triangles);

// Errs on the side of naming a pair that only comes near; never misses one that meets.
TriangleCrossings triangle_crossings(const std::vector<Vec3>& vertices,
                                     const std::vector<std::array<int, 3>>& triangles,
                                     const std::vector<TriangleEdge>& edges);

}  // namespace dqa
