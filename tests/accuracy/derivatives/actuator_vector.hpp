// SPDX-License-Identifier: MIT
// An interpolated actuator, or its cotangents, as one vector: what has a derivative, in one order.
#pragma once

#include "derivative_checks.hpp"
#include "shape/actuator.hpp"

namespace table {

template <class Point, class F>
void each_entry(Point& p, const F& f) {
    for (auto& x : p.mean) f(x);
    for (auto& x : p.half) f(x);
    for (auto& axis : p.normal)
        for (auto& x : axis) f(x);
    for (auto& axis : p.edge)
        for (auto& x : axis) f(x);
    f(p.strength);
}

template <class Point>
derivative::Vector actuator_vector(const Point& p) {
    derivative::Vector out;
    each_entry(p, [&](double x) { out.push_back(x); });
    return out;
}

// The same point with these entries.
template <class Point>
Point actuator_of(const derivative::Vector& v, Point p = {}) {
    std::size_t at = 0;
    each_entry(p, [&](double& x) { x = v[at++]; });
    return p;
}

}  // namespace table
