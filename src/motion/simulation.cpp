// SPDX-License-Identifier: MIT
#include "motion/simulation.hpp"

namespace dqa {

Simulation::Simulation(std::shared_ptr<const Design> design)
    : design_(std::move(design)), stepper_(design_), q_(design_->rest()), v_(q_.size(), 0.0), q_new_(q_.size()) {}

void Simulation::set_state(const double* q, const double* v) {
    if (q)
        q_.assign(q, q + q_.size());
    else
        q_ = design_->rest();
    if (v)
        v_.assign(v, v + v_.size());
    else
        v_.assign(v_.size(), 0.0);
    steps_ = 0;
    forces_ = {};
}

StepReport Simulation::step(const double* signals) {
    const StepReport report = stepper_.step(q_.data(), v_.data(), signals, steps_, q_new_.data());
    forces_ = stepper_.totals(q_.data(), q_new_.data());
    const double h = design_->scene().time_step;
    for (std::size_t i = 0; i < q_.size(); ++i) v_[i] = (q_new_[i] - q_[i]) / h;
    q_.swap(q_new_);
    ++steps_;
    return report;
}

}  // namespace dqa
