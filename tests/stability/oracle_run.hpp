// SPDX-License-Identifier: MIT
// A rollout of the oracle beside one that is to be judged: every step from the oracle's own state, to the equilibrium
// that the judged answer is at.
//
// A violent step may have several equilibria, and any of them is right. So the oracle starts from the judged answer,
// and takes what it converges to if that is a minimum (forces balance to 1e-12, Hessian positive definite); where it is
// not, or where there is no answer, it goes downhill from where steps start. On demand it also starts there where it
// need not, and tells when that leads to another minimum.
#pragma once

#include <memory>
#include <string>

#include "step_oracle.hpp"
#include "tape/tape.hpp"

namespace stability {

constexpr double kStateBound = 1e-4, kGradientBound = 1e-3;

double mass_norm(const dqa::Design& design, const Vector& a, const Vector& b);

class OracleRun {
public:
    OracleRun(const dqa::Design& like, const dqa::State& start);

    const dqa::Design& design() const { return *design_; }
    const dqa::State& state() const { return state_; }
    const std::shared_ptr<dqa::Tape>& tape() const { return tape_; }

    // The equilibrium of the next step: the one that `hint` is at, if it is at one that is stable; otherwise, or
    // without a hint (null), what is found from the usual starting points. False: there is none.
    bool step(const Vector& signals, const Vector* hint, bool independent = false);
    // Steps from whose usual starting point another minimum was found, in words; empty: none.
    const std::string& other_basins() const { return other_basins_; }

    // Of two answers to the last step, relative to the way to b from where the step or the rollout began. Ways shorter
    // than what rounding makes of places count as that.
    double distance(const Vector& a, const Vector& b) const;

private:
    void compare_basins(StepProblem& problem, const Vector& q);

    std::shared_ptr<const dqa::Design> design_;
    std::unique_ptr<dqa::Simulation> simulation_;
    std::shared_ptr<dqa::Tape> tape_;
    dqa::State state_;
    Vector from_;  // positions at the start of the last step
    std::string other_basins_;
};

}  // namespace stability
