// SPDX-License-Identifier: MIT
// Derivative of the muscles' forces by the directions of their fibres, for designs whose fibres turn with the weights.
#pragma once

#include <vector>

#include "body/body.hpp"

namespace dqa {

// Adds d(lambda . dE/dq)/d(direction) of each muscle to direction_bar [n_muscles], E the energy of body.hpp at q with
// these signals. lambda like q, [n_nodes][3]. Finite for any finite q: where a fibre is crushed to a point it has no
// direction, and nothing is added.
void add_direction_bar(const ActiveSet& set, const std::vector<MuscleEntry>& muscles, double contraction,
                       const double* q, const double* lambda, const double* signals, std::vector<Vec3>& direction_bar);

}  // namespace dqa
