// SPDX-License-Identifier: MIT
// A design in motion: current state (q, v), clock, and the totals of the last step. Copyable: a copy continues alone.
#pragma once

#include <memory>
#include <vector>

#include "motion/stepper.hpp"
#include "water/current.hpp"

namespace dqa {

class Simulation {
public:
    explicit Simulation(std::shared_ptr<const Design> design);

    const Design& design() const { return stepper_.design(); }
    std::shared_ptr<const Design> shared_design() const { return design_; }
    const std::vector<double>& q() const { return state_.q; }  // [n_nodes][3] m
    const std::vector<double>& v() const { return state_.v; }  // [n_nodes][3] m/s
    const State& state() const { return state_; }
    long steps() const { return steps_; }
    double time() const { return static_cast<double>(steps_) * design().scene().time_step; }
    const WaterTotals& forces() const { return forces_; }
    // Velocity of the water over time; at first uniform, as the scene says. Kept by set_state.
    const std::shared_ptr<const WaterCurrent>& current() const { return current_; }
    void set_current(std::shared_ptr<const WaterCurrent> current) { current_ = std::move(current); }
    // That of the step that starts now: asks a caller's function, so call it once a step.
    Vec3 current_now() const { return current_->value(time()); }

    // Sets the state and the clock to 0; sizes and finiteness are the caller's to check.
    void set_state(const double* q, const double* v);
    // Puts the simulation where another of the same design stood.
    void restore(const State& state, long steps);
    // Takes back what was kept of the simulation before a step.
    void take_back(State&& state, long steps, const WaterTotals& forces) noexcept;
    // One step; on an exception the state is that before the call.
    StepReport step(const StepInput& input);

private:
    std::shared_ptr<const Design> design_;
    Stepper stepper_;
    State state_, next_;
    std::shared_ptr<const WaterCurrent> current_;
    long steps_ = 0;
    WaterTotals forces_;
};

}  // namespace dqa
