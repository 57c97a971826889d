// SPDX-License-Identifier: MIT
// Objectives of a rollout and their seeds.
#pragma once

#include <vector>

#include "motion/design.hpp"

namespace dqa {

enum class ObjectiveKind : int { travel = 0 };

struct ObjectiveTerm {
    ObjectiveKind kind = ObjectiveKind::travel;
    double weight = 1.0;
};

// Travel (DiffAqua, loss of 8.1): -(mean over the spine of x_N - x_0), weighted by rest occupancy (m).
double travel_loss(const Design& design, const double* q_first, const double* q_last);
// Adds `scale` times the gradient to q_first_bar, q_last_bar [n_nodes][3] and to spine_bar [n_nodes].
void travel_pullback(const Design& design, const double* q_first, const double* q_last, double scale,
                     double* q_first_bar, double* q_last_bar, double* spine_bar);

}  // namespace dqa
