// SPDX-License-Identifier: MIT
// The record of one rollout and the backward sweep over it. Under implicit Euler velocities are not stored:
// v_{i+1} = (q_{i+1} - q_i) / h gives the same bits again.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "control/controller.hpp"
#include "motion/observation.hpp"
#include "motion/simulation.hpp"
#include "tape/objective.hpp"

namespace dqa {

using StepMonitor = std::function<void(long done, long total)>;  // may throw to cancel

class Tape {
public:
    explicit Tape(std::int64_t memory_bytes) : memory_bytes_(memory_bytes) {}

    bool empty() const { return !design_; }
    long n_steps() const { return static_cast<long>(actuation_.size()); }
    const Design& design() const { return *design_; }
    std::shared_ptr<const Design> shared_design() const { return design_; }
    const Controller* controller() const { return controller_.get(); }

    // Throws ERROR_MEMORY if one more step would exceed the budget.
    void require_room(const Design& design) const;
    // Called before the first step is recorded: fixes design and initial state.
    void begin(const Simulation& simulation);
    // The simulation after a step with this actuation.
    void append(const Simulation& simulation, const StepInput& input, const StepReport& report);
    // Whether the simulation stands where the tape ends.
    bool continues(const Simulation& simulation) const;
    // Remembers the controller that drives the steps from here on; all steps of a tape share one set of parameters.
    void set_controller(const Controller& controller);
    void clear();

    const std::vector<double>& q(long step) const { return q_[static_cast<std::size_t>(step)]; }
    std::vector<double> v(long step) const;
    // The integrator's state after `step` steps.
    State state(long step) const;
    const Vec3& current(long step) const { return current_[static_cast<std::size_t>(step)]; }
    const std::vector<double>& actuation(long step) const { return actuation_[static_cast<std::size_t>(step)]; }
    // Clock of the simulation when the first step was taken: controllers see step + first_step.
    long first_step() const { return first_step_; }

    double objective(const std::vector<ObjectiveTerm>& terms, double* per_term) const;

    struct Statistics {
        std::int64_t bytes = 0, newton_iterations = 0, linear_iterations = 0;
        double worst_residual = 0.0;
    };
    const Statistics& statistics() const { return statistics_; }

private:
    std::int64_t step_bytes(const Design& design) const;

    std::int64_t memory_bytes_;
    std::shared_ptr<const Design> design_;
    std::unique_ptr<Controller> controller_;
    std::vector<std::vector<double>> q_;
    std::vector<std::vector<double>> v_;  // of all states for a two-step integrator, else of the first alone
    State before_first_;                  // its q_before and v_before
    std::vector<Vec3> current_;
    std::vector<std::vector<double>> actuation_;
    long first_step_ = 0;
    Statistics statistics_;
};

// One step driven by given signals, recorded if tape is not null.
StepReport advance(Simulation& simulation, const std::vector<double>& signals, Tape* tape);

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
    const std::vector<double>& position_bar() const { return state_bar_.q; }
    const std::vector<double>& velocity_bar() const { return state_bar_.v; }

    std::int64_t iterations() const { return iterations_; }
    double worst_residual() const { return worst_residual_; }

private:
    void collect(long step);  // seeds of a state into the running cotangents
    // Cotangents of the controller in one step.
    void control(long step, const State& now, StepBar& out, std::vector<double>& theta_bar, DesignBar& bar) const;

    std::shared_ptr<const Tape> tape_;
    Stepper stepper_;
    long position_;
    bool begun_ = false;
    std::vector<std::vector<double>> q_seed_, v_seed_;  // per state; empty: none
    State state_bar_;                                   // running cotangents of the cursor's state
    StepBar step_bar_;
    std::vector<std::vector<double>> signal_bar_;
    DesignBar bar_;
    std::vector<double> theta_bar_;
    std::vector<double> weights_bar_;
    std::int64_t iterations_ = 0;
    double worst_residual_ = 0.0;
};

}  // namespace dqa
