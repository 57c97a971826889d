// SPDX-License-Identifier: MIT
// Muscles from the geometry of a base shape, for bases that name none: a caudal muscle, and a pair of lateral fins.
#pragma once

#include <optional>
#include <vector>

#include "shape/actuator.hpp"

namespace dqa {

// A caudal muscle from covered fractions. A body with a peduncle (a narrowest section in its rear with a wider tail fin
// behind it) gets it from there to the middle of the body, so that the fin's blade stays passive; one without, an eel,
// from 40 to 90 % of its length, measured from the tail. ERROR_ARGUMENT if that
// stretch is empty.
Actuator place_caudal(const Box& box, const std::vector<double>& fractions);

// The left half of a pair of lateral fins, the right one being its mirror image; nothing if the body has none. Fins are
// what reaches at least two cells beyond the trunk on both sides, ahead of the tail's quarter, over at most two
// thirds of the body's length, with at least 1 % of its volume; of several pairs the largest counts. The trunk of a
// section ends where the body's height falls below about half of that in the middle, and is no wider than high; in the
// plane it is twice as wide as the median section.
std::optional<Actuator> place_fins(const Box& box, const std::vector<double>& fractions);

}  // namespace dqa
