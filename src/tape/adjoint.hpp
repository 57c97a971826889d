// SPDX-License-Identifier: MIT
// The backward sweep over a tape: cotangents of the last state and of whatever states were seeded go back step by step,
// through the controller if one closed the loop, to the initial state, the actuations, the parameters and the design.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "motion/observation.hpp"
#include "tape/reader.hpp"
#include "tape/tape.hpp"

namespace dqa {

using StepMonitor = std::function<void(long done, long total)>;  // may throw to cancel

class Adjoint {
public:
    // Throws ERROR_STATE if the tape's controller reads sensors but has no pullback: its loop cannot be closed.
    explicit Adjoint(std::shared_ptr<const Tape> tape);

    const Tape& tape() const { return *tape_; }
    long position() const { return position_; }  // state index the sweep stands at
    bool begun() const { return begun_; }
    void seed_position(long step, const double* bar);
    void seed_velocity(long step, const double* bar);
    void seed_objective(const std::vector<ObjectiveTerm>& terms);
    void backward(long to_step, const StepMonitor& monitor);

    std::vector<double> weights_bar();  // cached after the first call
    std::vector<double> control_bar() const;
    // Of numbers added to the actuation of each step; the controller reacts to what follows from them.
    std::vector<double> actuation_bar() const;
    std::vector<Vec3> current_bar() const { return current_bar_; }  // [n_steps]
    // Of the table that all steps read their current from (ERROR_STATE where they did not), [n_rows].
    std::vector<Vec3> current_table_bar() const;
    // Uniform current (its sum over the steps) [3], density, ordinates of drag [4] and thrust [4].
    std::vector<double> water_bar() const;
    MaterialBar material_bar() const { return tape_->design().material_bar(bar_); }
    const std::vector<double>& position_bar() const { return state_bar_.q; }
    const std::vector<double>& velocity_bar() const { return state_bar_.v; }

    std::int64_t iterations() const { return iterations_; }
    double worst_residual() const { return worst_residual_; }

private:
    void collect(long step);  // seeds of a state, objectives included, into the running cotangents
    void efforts(long step, std::vector<double>& signals_bar) const;
    // Cotangents of the controller in one step.
    void control(long step, const State& now, StepBar& out, std::vector<double>& theta_bar, DesignBar& bar) const;

    std::shared_ptr<const Tape> tape_;
    TapeReader reader_;
    Stepper stepper_;
    State next_;  // of the cursor
    long position_;
    bool begun_ = false;
    std::vector<std::vector<double>> q_seed_, v_seed_;  // per state; empty: none
    State state_bar_;                                   // running cotangents of the cursor's state
    StepBar step_bar_, totals_step_bar_;
    std::vector<ObjectiveTerm> terms_;  // but travel, which seeds the first and the last state
    WaterTotals totals_bar_;            // of the step that led to the cursor's state
    std::vector<std::vector<double>> signal_bar_;
    std::vector<Vec3> current_bar_;
    DesignBar bar_;
    std::vector<double> theta_bar_;
    std::vector<double> weights_bar_;
    std::int64_t iterations_ = 0;
    double worst_residual_ = 0.0;
};

}  // namespace dqa
