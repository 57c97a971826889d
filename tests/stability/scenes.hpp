// SPDX-License-Identifier: MIT
// The scenes of the stability map: axes of settings from harmless to absurd, on bodies small enough that the oracle is
// quick.
#pragma once

#include <vector>

#include "barycenter_trial.hpp"
#include "trial.hpp"

namespace stability {

// Two ellipsoids in a small box; the same as ellipses in the plane.
std::shared_ptr<const dqa::ShapeSpace> small_space();
std::shared_ptr<const dqa::ShapeSpace> flat_space();
// A single full cell.
std::shared_ptr<const dqa::ShapeSpace> cell_space();

// All cells of the map, or those at the ends of the axes, where methods fail.
std::vector<Trial> mechanics(bool quick);
std::vector<BarycenterTrial> barycenters(bool quick);

}  // namespace stability
