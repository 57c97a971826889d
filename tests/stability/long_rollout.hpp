// SPDX-License-Identifier: MIT
// Ten thousand steps of one cell's body without water, flying, turning and ringing: no energy is made, no momentum is
// lost, and the gradient that comes back through all of them is that of differences.
#pragma once

#include "trial.hpp"

namespace stability {

struct LongRollout {
    dqa::Integrator integrator = dqa::Integrator::implicit_euler;
    int steps = 10000;
    double time_step = 1e-3;  // s
};

// state_error: the largest change of a component of the momentum, relative to it (accurate: to 1e-5); gradient_error:
// of the travel by the initial velocity along a fixed direction, against differences. The reason tells what energy is
// left.
Result run(const LongRollout& trial);

}  // namespace stability
