// SPDX-License-Identifier: MIT
// One cell of the stability map: a short rollout of a scene by the library, held against the oracle's.
//
// Outcomes: `accurate`, positions of every step within 1e-4 (of the way moved in that step and all before, in the norm
// of the mass) and the gradient of the travel by actuation, initial velocity and weights within 1e-3 of the oracle's
// (by weights: or of the way moved, where that is longer: in stiff bodies tissue and muscles, which grow together,
// cancel in this derivative until only rounding is left); `reported`, a status said that there is no answer; `silent`,
// an answer that is neither; `nan`. The last two are defects.
//
// A violent step may have several equilibria, and any of them is right. So the oracle starts from the library's answer,
// and takes what it converges to if that is a minimum (forces balance to 1e-12, Hessian positive definite); where it is
// not, or where the library gave no answer, it goes downhill from where steps start.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "motion/design.hpp"
#include "step_oracle.hpp"

namespace stability {

constexpr double kStateBound = 1e-4, kGradientBound = 1e-3;

enum class Outcome { accurate, reported, silent, nan };
const char* name_of(Outcome outcome);

struct Trial {
    std::string axis_x, axis_y;
    double value_x = 0.0, value_y = 0.0;
    std::string variant;  // of the method: material, integrator, water, where not the default
    std::shared_ptr<const dqa::ShapeSpace> space;
    Vector weights{0.6, 0.4};
    dqa::SceneSettings scene;
    int steps = 4;
    double stroke = 1.0;  // signals: +stroke and -stroke, two steps each
    std::function<void(const dqa::Design&, Vector& q, Vector& v)> start = {};  // none: at rest

    std::string method() const;
};

struct Result {
    Outcome outcome = Outcome::nan;
    int steps_done = 0;
    int rescued = 0;       // steps
    bool solvable = true;  // the oracle found an equilibrium of every step that the library tried
    int other_minima = 0;  // steps in which the oracle had to start from the library's answer
    int inverted = 0;      // most Gauss points inverted at the end of a step
    double residual = 0.0, state_error = 0.0, gradient_error = 0.0, max_speed = 0.0;
    std::string reason;
};

Result run(const Trial& trial);
// Largest relative error of the oracle's gradient by actuation against differences of its own rollouts.
double check_oracle(const Trial& trial);

}  // namespace stability
