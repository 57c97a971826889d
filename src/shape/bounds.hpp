// SPDX-License-Identifier: MIT
// A box along the axes around points.
#pragma once

#include <algorithm>

#include "grid/box.hpp"

namespace dqa {

struct Bounds {
    Vec3 lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};  // around nothing

    void include(const Vec3& x) {
        for (std::size_t a = 0; a < 3; ++a) lo[a] = std::min(lo[a], x[a]), hi[a] = std::max(hi[a], x[a]);
    }
    void include(const Bounds& o) {
        for (std::size_t a = 0; a < 3; ++a) lo[a] = std::min(lo[a], o.lo[a]), hi[a] = std::max(hi[a], o.hi[a]);
    }
    // Whether no gap between the boxes is wider than `most` along an axis.
    bool near(const Bounds& o, double most) const {
        for (std::size_t a = 0; a < 3; ++a)
            if (lo[a] > o.hi[a] + most || o.lo[a] > hi[a] + most) return false;
        return true;
    }
    std::size_t longest_axis() const {
        std::size_t axis = 0;
        for (std::size_t a = 1; a < 3; ++a)
            if (hi[a] - lo[a] > hi[axis] - lo[axis]) axis = a;
        return axis;
    }
};

}  // namespace dqa
