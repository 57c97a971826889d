// SPDX-License-Identifier: MIT
// Muscles from the geometry of a base shape, for bases that name none: a caudal muscle, and a pair of lateral fins.
#pragma once

#include <optional>
#include <vector>

#include "shape/actuator.hpp"

namespace dqa {

// A caudal muscle from covered fractions. A body with a peduncle (a narrowest section in its rear with a wider tail fin
// behind it) gets it from there to the middle of the body, so that the fin's blade stays passive; one without, an eel,
// from 40 to 90 % of its length, measured from the tail.
Actuator place_caudal(const Box& box, const std::vector<double>& fractions);

// The left half of a pair of lateral fins, the right one being its mirror image; nothing if the body has none. The
// trunk is as wide as twice the body's standard deviation across, and no wider than high; fins are what reaches at
// least two cells beyond it on both sides, over at most three quarters of the body's length, with at least 1 % of its
// volume; of several pairs the largest counts.
std::optional<Actuator> place_fins(const Box& box, const std::vector<double>& fractions);

}  // namespace dqa
