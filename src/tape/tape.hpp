// SPDX-License-Identifier: MIT
// The record of one rollout. Without a memory budget, or within it, every state is kept; beyond it every second,
// fourth, eighth ... alone, and the states between are computed again when they are asked for (tape/reader.hpp). A step
// is a function of the integrator's state and recorded inputs, so these have the same bits, and no controller is asked
// again.
//
// Budget: inputs and observed numbers of all steps, plus states. While all states are kept they may fill it; thinned
// out they take half of it, and every reader (an adjoint has one) may hold states of its own in as much as the other
// half. The least budget holds four states: the first and the last here, the two ends of a step in a reader. Working
// memory of the solver is not counted.
//
// Under implicit Euler velocities are not stored while all states are kept: v_{i+1} = (q_{i+1} - q_i) / h gives the
// same bits again.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "control/controller.hpp"
#include "motion/simulation.hpp"
#include "tape/objective.hpp"

namespace dqa {

class Tape {
public:
    explicit Tape(std::int64_t memory_bytes) : memory_bytes_(memory_bytes) {}

    bool empty() const { return !design_; }
    long n_steps() const { return static_cast<long>(actuation_.size()); }
    const Design& design() const { return *design_; }
    std::shared_ptr<const Design> shared_design() const { return design_; }
    const Controller* controller() const { return controller_.get(); }

    // Thins out the states if one more step would exceed the budget; throws ERROR_MEMORY if that is not enough.
    void make_room(const Design& design);
    // Called before the first step is recorded: fixes design and initial state.
    void begin(const Simulation& simulation);
    // The simulation after a step with this actuation.
    void append(const Simulation& simulation, const StepInput& input, const StepReport& report);
    // Whether the simulation stands where the tape ends.
    bool continues(const Simulation& simulation) const;
    // Remembers the controller that drives the steps from here on; all steps of a tape share one set of parameters.
    void set_controller(const Controller& controller);
    void clear();

    // The integrator's state after `step` steps, computed again if it was not kept; many are read better by a
    // TapeReader.
    State state(long step) const;
    std::vector<double> q(long step) const { return state(step).q; }
    std::vector<double> v(long step) const { return state(step).v; }
    // Velocity of the water during step `step`, and where it came from.
    const Vec3& current(long step) const { return current_[static_cast<std::size_t>(step)]; }
    const WaterCurrent& current_source(long step) const { return *current_source_[static_cast<std::size_t>(step)]; }
    const std::vector<double>& actuation(long step) const { return actuation_[static_cast<std::size_t>(step)]; }
    // Clock of the simulation when the first step was taken: controllers see step + first_step.
    long first_step() const { return first_step_; }
    // Of state `step`, where the step of this index starts (s): what the simulation's clock showed.
    double time(long step) const { return static_cast<double>(first_step_ + step) * design_->scene().time_step; }
    const Observed& observed(long step) const { return observed_[static_cast<std::size_t>(step)]; }

    bool keeps(long step) const { return step % stride_ == 0 || step == n_steps(); }
    State kept_state(long step) const;
    // How many states a reader may hold beside the two ends of a step.
    long reader_slots() const;

    // Weighted sum of the terms, and each of them (null: not wanted). Throws ERROR_ARGUMENT for terms that do not fit.
    double objective(const std::vector<ObjectiveTerm>& terms, double* per_term) const;
    void require_terms(const std::vector<ObjectiveTerm>& terms) const;

    struct Statistics {
        std::int64_t bytes = 0, newton_iterations = 0, linear_iterations = 0, rescued_steps = 0, indefinite_steps = 0;
        double worst_residual = 0.0;
    };
    const Statistics& statistics() const { return statistics_; }
    std::int64_t n_kept() const;
    std::int64_t recomputed_steps() const { return recomputed_.load(); }
    void count_recomputed() const { ++recomputed_; }

private:
    void thin(long stride);
    void count_bytes();
    void keep_state(const Simulation& simulation);

    std::int64_t memory_bytes_;
    std::shared_ptr<const Design> design_;
    std::unique_ptr<Controller> controller_;
    long stride_ = 1;
    // States 0, stride, 2 stride ... With stride 1 they lack what their neighbours tell: before, and under implicit
    // Euler v, except in the first.
    std::vector<State> states_;
    State last_;  // if the stride is not 1
    std::vector<Vec3> current_;
    std::vector<std::shared_ptr<const WaterCurrent>> current_source_;
    std::vector<Observed> observed_;  // of every state
    std::vector<std::vector<double>> actuation_;
    long first_step_ = 0;
    Statistics statistics_;
    mutable std::atomic<std::int64_t> recomputed_{0};  // by readers, perhaps on several threads
};

// One step driven by given signals and the simulation's current, recorded if tape is not null.
StepReport advance(Simulation& simulation, const std::vector<double>& signals, Tape* tape);
// The same in a current that was read before.
StepReport advance(Simulation& simulation, const std::vector<double>& signals, const Vec3& current, Tape* tape);

}  // namespace dqa
