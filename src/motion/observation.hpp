// SPDX-License-Identifier: MIT
// What controllers see of a state (DiffAqua 2021, section "Sensing"), 5 dims numbers in the frame of the world:
//   velocities of head, centre and tail sensors (m/s), then offsets of head and of tail from the centre sensor (m).
#pragma once

#include <vector>

#include "control/controller.hpp"
#include "motion/simulation.hpp"

namespace dqa {

int n_observed(const Design& design);
// q, v [n_nodes][dims] -> observation [n_observed].
std::vector<double> observe(const Design& design, const double* q, const double* v);
// Adds to q_bar, v_bar, and through the places of head and tail to `bar`.
void observe_pullback(const Design& design, const double* q, const double* v, const double* observation_bar,
                      double* q_bar, double* v_bar, DesignBar& bar);

// Derivative of the reading of a field at a sensor by the sensor's rest x, times bar.
double reading_by_place(const MaterialPoint& point, const double* field, const Vec3& bar);

// The controller's actuation [n_signals] for the next step of a simulation.
std::vector<double> actuation_of(const Controller& controller, const Simulation& simulation);

}  // namespace dqa
