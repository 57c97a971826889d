// SPDX-License-Identifier: MIT
// Two flat bodies with a tail and a pair of fins that differ in place, size and tilt: their fibres turn with the
// weights.
#pragma once

#include "motion_fixtures.hpp"

namespace table {

std::shared_ptr<const dqa::ShapeSpace> winged_space(dqa::Interpolation interpolation);

}  // namespace table
