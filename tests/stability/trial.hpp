// SPDX-License-Identifier: MIT
// One cell of the stability map: a short rollout of a scene by the library, or by the textbook method of the
// benchmarks, held against the oracle's.
//
// Outcomes: `accurate`, positions of every step within 1e-4 (of the way moved in that step and all before, in the norm
// of the mass) and the gradient of the travel by actuation, initial velocity and weights within 1e-3 of the oracle's
// (by weights: or of the way moved, where that is longer: in stiff bodies tissue and muscles, which grow together,
// cancel in this derivative until only rounding is left); `reported`, a status said that there is no answer; `silent`,
// an answer that is neither; `nan`. The last two are defects.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "grid/error.hpp"
#include "motion/design.hpp"
#include "motion/state.hpp"
#include "step_oracle.hpp"

namespace stability {

enum class Outcome { accurate, reported, silent, nan };
const char* name_of(Outcome outcome);

struct Trial {
    std::string axis_x, axis_y;
    double value_x = 0.0, value_y = 0.0;
    std::string variant;  // of the method: material, integrator, water, where not the default
    std::shared_ptr<const dqa::ShapeSpace> space;
    Vector weights{0.6, 0.4};
    dqa::SceneSettings scene;
    bool reference = false;    // by the textbook method (bench/reference.hpp): full box, no gradient by weights
    bool independent = false;  // tell where another start leads the oracle to another minimum
    int steps = 4;
    double stroke = 1.0;  // signals: +stroke and -stroke, two steps each
    std::function<void(const dqa::Design&, Vector& q, Vector& v)> start = {};  // none: at rest

    std::string method() const;
    Vector signals(const dqa::Design& design, int step) const;
    dqa::State start_of(const dqa::Design& design) const;
};

struct Result {
    Outcome outcome = Outcome::nan;
    int steps_done = 0;
    int rescued = 0;       // steps
    bool solvable = true;  // the oracle found an equilibrium of every step that was tried
    int inverted = 0;      // most Gauss points inverted at the end of a step
    double residual = 0.0, gradient_error = 0.0, max_speed = 0.0;
    double state_error = 0.0;  // largest of the steps, up to the first that is wrong
    std::string reason;
};

// The travel's, by actuation of each step, initial velocity and weights; the last may be empty.
struct Gradient {
    Vector actuation, velocity, weights;
};

// What a method made of a trial.
struct Answer {
    std::shared_ptr<const dqa::Design> design;  // null: it could not be made
    std::vector<Vector> q;                      // after every step that was done
    std::function<Gradient()> gradient;         // may throw a dqa::Error
};

// They fill what they know of the result; a status that says why there is no answer makes it `reported`.
Answer answer_of_library(const Trial& trial, Result& out);
Answer answer_of_reference(const Trial& trial, Result& out);
void report_error(const dqa::Error& error, Result& out);

Result run(const Trial& trial);
// Largest relative error of the oracle's gradient by actuation against differences of its own rollouts.
double check_oracle(const Trial& trial);

}  // namespace stability
