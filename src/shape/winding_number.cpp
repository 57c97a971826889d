// SPDX-License-Identifier: MIT
#include "shape/winding_number.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "shape/bounds.hpp"
#include "shape/vector.hpp"

namespace dqa {
namespace {

constexpr double kNearEdge = 1e-11;  // well above the rounding of coordinates up to 100

std::size_t idx(int i) {
    return static_cast<std::size_t>(i);
}

}  // namespace

WindingNumber::WindingNumber(const std::vector<Vec3>& vertices, const std::vector<std::array<int, 3>>& triangles,
                             std::size_t axis)
    : vertices_(vertices), triangles_(triangles), axis_(axis), side_{(axis + 1) % 3, (axis + 2) % 3} {
    Bounds all;
    for (const Vec3& v : vertices) all.include(v);
    // About one bin for every two triangles, nearly square.
    std::array<double, 2> extent;
    for (std::size_t s = 0; s < 2; ++s) extent[s] = std::max(all.hi[side_[s]] - all.lo[side_[s]], 1e-9);
    const double per_unit = std::sqrt(0.5 * static_cast<double>(triangles.size()) / (extent[0] * extent[1]));
    for (std::size_t s = 0; s < 2; ++s) {
        lo_[s] = all.lo[side_[s]];
        bins_[s] = static_cast<int>(std::clamp(std::ceil(extent[s] * per_unit), 1.0, 1024.0));
        per_unit_[s] = bins_[s] / extent[s];
    }
    const auto for_bins = [&](const auto& f) {
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            Bounds b;
            for (const int i : triangles[t]) b.include(vertices[idx(i)]);
            for (int p = bin_of(b.lo[side_[0]] - kNearEdge, 0); p <= bin_of(b.hi[side_[0]] + kNearEdge, 0); ++p)
                for (int q = bin_of(b.lo[side_[1]] - kNearEdge, 1); q <= bin_of(b.hi[side_[1]] + kNearEdge, 1); ++q)
                    f(idx(p * bins_[1] + q), static_cast<int>(t));
        }
    };
    first_.assign(idx(bins_[0] * bins_[1]) + 1, 0);
    for_bins([&](std::size_t bin, int) { ++first_[bin + 1]; });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    triangle_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for_bins([&](std::size_t bin, int t) { triangle_[next[bin]++] = t; });
}

int WindingNumber::bin_of(double x, std::size_t side) const {
    const double bin = std::floor((x - lo_[side]) * per_unit_[side]);
    return static_cast<int>(std::clamp(bin, 0.0, bins_[side] - 1.0));
}

WindingNumber::Count WindingNumber::ahead(const Vec3& x, const std::vector<int>& passed) const {
    Count count;
    const std::size_t bin = idx(bin_of(x[side_[0]], 0) * bins_[1] + bin_of(x[side_[1]], 1));
    for (std::size_t k = first_[bin]; k < first_[bin + 1]; ++k) {
        const int number = triangle_[k];
        if (std::find(passed.begin(), passed.end(), number) != passed.end()) continue;
        const auto& t = triangles_[idx(number)];
        const std::array<Vec3, 3> v{minus(vertices_[idx(t[0])], x), minus(vertices_[idx(t[1])], x),
                                    minus(vertices_[idx(t[2])], x)};
        if (std::max({v[0][axis_], v[1][axis_], v[2][axis_]}) < -kNearEdge) continue;
        // Where the ray stands across each edge: all three on the left or all on the right mean a hit.
        int left = 0, right = 0;
        for (std::size_t e = 0; e < 3; ++e) {
            const Vec3 &a = v[e], &b = v[(e + 1) % 3];
            const double across = a[side_[0]] * b[side_[1]] - a[side_[1]] * b[side_[0]];
            const double close = kNearEdge * std::hypot(b[side_[0]] - a[side_[0]], b[side_[1]] - a[side_[1]]);
            left += across >= -close, right += across <= close;
        }
        if (left < 3 && right < 3) continue;
        if (left + right > 3) count.uncertain = true;  // close to an edge, or the triangle is seen edge-on
        const Vec3 normal = cross(minus(v[1], v[0]), minus(v[2], v[0]));
        const bool outwards = normal[axis_] > 0;
        if ((dot(normal, v[0]) > 0) == outwards) count.winding += outwards ? 1 : -1;
    }
    return count;
}

}  // namespace dqa
