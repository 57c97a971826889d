// SPDX-License-Identifier: MIT
// A convex polygon in space with few corners, and cutting it in two along a plane.
#pragma once

#include <algorithm>
#include <array>
#include <utility>

#include "grid/box.hpp"

namespace dqa {

struct ConvexPolygon {
    static constexpr int kMost = 24;  // corners
    int n = 0;
    std::array<Vec3, kMost> v;

    void add(const Vec3& x) { v[static_cast<std::size_t>(n++)] = x; }
    const Vec3& operator[](int i) const { return v[static_cast<std::size_t>(i)]; }

    // Smallest and largest coordinate along an axis.
    std::pair<double, double> extent(std::size_t axis) const {
        double lo = v[0][axis], hi = lo;
        for (int i = 1; i < n; ++i) lo = std::min(lo, (*this)[i][axis]), hi = std::max(hi, (*this)[i][axis]);
        return {lo, hi};
    }
};

// Cuts a polygon of less than kMost corners along the plane where `height`, a linear function of space, vanishes: one
// part lies where it is <= 0 and one where it is >= 0, with one corner more at most. A part without area has fewer than
// three corners. The point where an edge meets the plane depends on the edge alone and not on its direction, so that
// neighbouring polygons stay closed.
template <class Height>
void cut(const ConvexPolygon& in, const Height& height, ConvexPolygon& below, ConvexPolygon& above) {
    below.n = above.n = 0;
    std::array<double, ConvexPolygon::kMost> h;
    for (int i = 0; i < in.n; ++i) h[static_cast<std::size_t>(i)] = height(in[i]);
    for (int i = 0; i < in.n; ++i) {
        const int next = i + 1 < in.n ? i + 1 : 0;
        const double a = h[static_cast<std::size_t>(i)], b = h[static_cast<std::size_t>(next)];
        if (a <= 0) below.add(in[i]);
        if (a >= 0) above.add(in[i]);
        if (!((a < 0 && b > 0) || (a > 0 && b < 0))) continue;
        const Vec3 &lower = a < 0 ? in[i] : in[next], &upper = a < 0 ? in[next] : in[i];
        const double lo = std::min(a, b), hi = std::max(a, b), s = -lo / (hi - lo);
        Vec3 x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = lower[k] + s * (upper[k] - lower[k]);
        below.add(x), above.add(x);
    }
}

}  // namespace dqa
