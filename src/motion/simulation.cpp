// SPDX-License-Identifier: MIT
#include "motion/simulation.hpp"

namespace dqa {

Simulation::Simulation(std::shared_ptr<const Design> design)
    : design_(std::move(design)),
      stepper_(design_),
      current_(std::make_shared<WaterCurrent>(design_->scene().hydrodynamics.current)) {
    set_state(nullptr, nullptr);
}

void Simulation::set_state(const double* q, const double* v) {
    const std::size_t n = design_->rest().size();
    state_ = {};
    state_.q = q ? std::vector<double>(q, q + n) : design_->rest();
    state_.v = v ? std::vector<double>(v, v + n) : std::vector<double>(n, 0.0);
    steps_ = 0;
    forces_ = {};
}

void Simulation::restore(const State& state, long steps) {
    state_ = state;
    steps_ = steps;
    forces_ = {};
}

void Simulation::take_back(State&& state, long steps, const WaterTotals& forces) noexcept {
    state_ = std::move(state);
    steps_ = steps;
    forces_ = forces;
}

StepReport Simulation::step(const StepInput& input) {
    const StepReport report = stepper_.step(state_, input, steps_, next_);
    forces_ = stepper_.totals(next_);
    std::swap(state_, next_);
    ++steps_;
    return report;
}

}  // namespace dqa
