// SPDX-License-Identifier: MIT
// States of a tape in any order, best from the last to the first, computed again from the nearest earlier one where the
// tape does not keep them. On the way states are held where binomial checkpointing wants them (Griewank & Walther 2000,
// "revolve"), so that each of l states costs at most r steps with s slots as soon as C(s + 1 + r, r) > l.
#pragma once

#include <memory>
#include <vector>

#include "motion/simulation.hpp"

namespace dqa {

class Tape;

// Where to hold the next state on a way of n >= 2 steps whose ends' states, but the first, will be asked for backwards,
// with s >= 1 free slots: a number of steps in [1, n - 1].
long checkpoint_after(long n, long s);

class TapeReader {
public:
    explicit TapeReader(const Tape& tape) : tape_(&tape) {}

    // The state after `step` steps; valid until the next call. Throws CANCELLED if the scene's token is set while it
    // computes.
    const State& state(long step);
    // Forgets everything, e.g. because the tape was cleared.
    void reset();

private:
    struct Held {
        long step;
        State state;
    };

    const Tape* tape_;
    std::unique_ptr<Simulation> simulation_;  // made when first needed
    std::vector<Held> held_;                  // ascending
    State given_;
    long given_step_ = -1;
};

}  // namespace dqa
