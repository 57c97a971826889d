// SPDX-License-Identifier: MIT
// Proof of the gradient by finite differences along one random direction: five-point stencil over a ladder of steps
// with Ridders' extrapolation, one-sided where the weights stand at the edge of the simplex, and the slope of the
// Taylor remainder.
#pragma once

#include <cstdint>

#include "tape/adjoint.hpp"

namespace dqa {

enum class WithRespectTo : int {
    weights = 0,
    control = 1,
    actuation = 2,
    initial_position = 3,
    initial_velocity = 4,
    water = 5,
    current = 6,
    current_table = 7,
    young_modulus = 8,     // [n_box_cells]
    muscle_stiffness = 9,  // [n_box_cells]
    material = 10,         // Young's modulus and muscle stiffness of all cells, Poisson's ratio, density
    lame = 11,             // mu and lambda of all cells
};

// Cotangents by Young's modulus and muscle stiffness of all cells together, Poisson's ratio and density.
std::vector<double> material_vector(const MaterialBar& bar);

struct GradientCheckSettings {
    WithRespectTo quantity = WithRespectTo::weights;
    int n_steps = 10;
    std::uint64_t seed = 1;
    double step = 0.0;  // 0: automatic
};

struct GradientCheckReport {
    bool one_sided = false;
    double adjoint = 0.0, finite_difference = 0.0, relative_error = 0.0, taylor_slope = 0.0, gradient_norm = 0.0;
    double step = 0.0;
};

// Checks the objective of a rollout from the simulation's current state. controller may be null: the actuation is then
// a fixed smooth signal of amplitude 1/2. With one, its loop through the sensors is closed. Tolerances are tightened to
// rounding on a copy of the design.
GradientCheckReport check_gradient(const Simulation& simulation, const Controller* controller,
                                   const std::vector<ObjectiveTerm>& terms, const GradientCheckSettings& settings);

}  // namespace dqa
