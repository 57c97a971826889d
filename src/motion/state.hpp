// SPDX-License-Identifier: MIT
// The state of a time integrator, and what drives one of its steps.
#pragma once

#include <vector>

#include "grid/box.hpp"

namespace dqa {

// Nodal fields, [n_nodes][3] each. A two-step integrator also needs the state one step earlier; where that is empty
// (always under implicit Euler, and at the first step after a restart) a step is one of implicit Euler.
struct State {
    std::vector<double> q, v;                // m, m/s
    std::vector<double> q_before, v_before;  // of the same sizes, or empty

    bool operator==(const State&) const = default;
};

struct StepInput {
    const double* signals = nullptr;  // actuation [n_signals]
    Vec3 current{};                   // velocity of the water during the step (m/s)
};

// Cotangents of a step's old state and inputs.
struct StepBar {
    State state;
    std::vector<double> signals;
    Vec3 current{};
};

}  // namespace dqa
