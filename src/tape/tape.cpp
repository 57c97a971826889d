// SPDX-License-Identifier: MIT
#include "tape/tape.hpp"

#include <algorithm>
#include <cmath>

#include "grid/error.hpp"

namespace dqa {

std::int64_t Tape::step_bytes(const Design& design) const {
    return static_cast<std::int64_t>(sizeof(double)) * (3 * design.n_nodes() + design.n_signals() + 3) *
           (design.scene().integrator == Integrator::bdf2 ? 2 : 1);
}

void Tape::require_room(const Design& design) const {
    if (memory_bytes_ <= 0) return;
    const std::int64_t step = step_bytes(design);
    const std::int64_t need = statistics_.bytes + (design_ ? step : 3 * step);  // the first step holds two states and v
    if (need > memory_bytes_)
        fail(Status::ERROR_MEMORY, "memory_bytes is %lld, expected at least %lld to record step %ld of %d nodes",
             static_cast<long long>(memory_bytes_), static_cast<long long>(need), n_steps(), design.n_nodes());
}

void Tape::begin(const Simulation& simulation) {
    if (design_) return;
    design_ = simulation.shared_design();
    q_.push_back(simulation.q());
    v_.push_back(simulation.v());
    before_first_ = simulation.state();
    before_first_.q.clear(), before_first_.v.clear();
    first_step_ = simulation.steps();
    statistics_.bytes = 2 * static_cast<std::int64_t>(sizeof(double) * simulation.v().size());
}

void Tape::append(const Simulation& simulation, const StepInput& input, const StepReport& report) {
    q_.push_back(simulation.q());
    if (design_->scene().integrator == Integrator::bdf2) v_.push_back(simulation.v());
    actuation_.emplace_back(input.signals, input.signals + design_->n_signals());
    current_.push_back(input.current);
    statistics_.bytes += step_bytes(*design_);
    statistics_.newton_iterations += report.newton_iterations;
    statistics_.linear_iterations += report.linear_iterations;
    statistics_.worst_residual = std::max(statistics_.worst_residual, report.residual);
}

bool Tape::continues(const Simulation& simulation) const {
    return empty() || (design_ == simulation.shared_design() && first_step_ + n_steps() == simulation.steps() &&
                       state(n_steps()) == simulation.state());
}

void Tape::set_controller(const Controller& controller) {
    if (controller_ && !controller_->equals(controller))
        fail(Status::ERROR_STATE,
             "the tape was recorded with another controller or other controller parameters; clear it first");
    if (!controller_ && n_steps() > 0)
        fail(Status::ERROR_STATE, "the tape holds steps that no controller drove; clear it first");
    controller_ = controller.clone();
}

void Tape::clear() {
    design_.reset();
    controller_.reset();
    q_.clear(), v_.clear(), actuation_.clear(), current_.clear();
    before_first_ = {};
    first_step_ = 0;
    statistics_ = {};
}

std::vector<double> Tape::v(long step) const {
    if (static_cast<std::size_t>(step) < v_.size()) return v_[static_cast<std::size_t>(step)];
    const std::vector<double>&a = q(step - 1), &b = q(step);
    const double h = design_->scene().time_step;
    std::vector<double> out(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) out[i] = (b[i] - a[i]) / h;
    for (const int i : design_->constrained()) out[static_cast<std::size_t>(i)] = 0.0;
    return out;
}

State Tape::state(long step) const {
    State s;
    if (step == 0)
        s = before_first_;
    else if (design_->scene().integrator == Integrator::bdf2)
        s.q_before = q(step - 1), s.v_before = v(step - 1);
    s.q = q(step), s.v = v(step);
    return s;
}

double Tape::objective(const std::vector<ObjectiveTerm>& terms, double* per_term) const {
    double loss = 0.0;
    for (std::size_t k = 0; k < terms.size(); ++k) {
        const double value = travel_loss(*design_, q_.front().data(), q_.back().data());
        if (per_term) per_term[k] = value;
        loss += terms[k].weight * value;
    }
    return loss;
}

StepReport advance(Simulation& simulation, const std::vector<double>& signals, Tape* tape) {
    const StepInput input{signals.data(), simulation.design().scene().hydrodynamics.current};
    if (tape) tape->require_room(simulation.design());
    if (!tape) return simulation.step(input);
    const bool first = tape->empty();
    tape->begin(simulation);
    try {
        const StepReport report = simulation.step(input);
        tape->append(simulation, input, report);
        return report;
    } catch (...) {
        if (first) tape->clear();
        throw;
    }
}

Adjoint::Adjoint(std::shared_ptr<const Tape> tape)
    : tape_(std::move(tape)),
      stepper_(tape_->shared_design()),
      position_(tape_->n_steps()),
      q_seed_(static_cast<std::size_t>(position_) + 1),
      v_seed_(static_cast<std::size_t>(position_) + 1),
      signal_bar_(static_cast<std::size_t>(position_)),
      bar_(tape_->design().zero_bar()) {
    state_bar_.q.assign(tape_->design().rest().size(), 0.0);
    state_bar_.v = state_bar_.q;
    const Controller* controller = tape_->controller();
    if (!controller) return;
    if (controller->n_sensors() > 0 && !controller->differentiable())
        fail(Status::ERROR_STATE,
             "the tape's controller reads %d sensors but has no pullback callback: without it the loop through the "
             "sensors cannot be closed; give one, or drive the steps one by one",
             controller->n_sensors());
    theta_bar_.assign(controller->parameters().size(), 0.0);
}

namespace {

void accumulate(std::vector<double>& into, const double* bar, std::size_t n) {
    if (into.empty()) into.assign(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) into[i] += bar[i];
}

}  // namespace

void Adjoint::seed_position(long step, const double* bar) {
    // The cursor's own state has been collected once the sweep began: add to the running cotangent there.
    if (begun_ && step == position_)
        for (std::size_t i = 0; i < state_bar_.q.size(); ++i) state_bar_.q[i] += bar[i];
    else
        accumulate(q_seed_[static_cast<std::size_t>(step)], bar, state_bar_.q.size());
}

void Adjoint::seed_velocity(long step, const double* bar) {
    if (begun_ && step == position_)
        for (std::size_t i = 0; i < state_bar_.v.size(); ++i) state_bar_.v[i] += bar[i];
    else
        accumulate(v_seed_[static_cast<std::size_t>(step)], bar, state_bar_.v.size());
}

void Adjoint::seed_objective(const std::vector<ObjectiveTerm>& terms) {
    if (begun_) fail(Status::ERROR_STATE, "seed_objective: the backward sweep has already begun");
    std::vector<double> first(state_bar_.q.size(), 0.0), last(state_bar_.q.size(), 0.0);
    for (const ObjectiveTerm& t : terms)
        travel_pullback(tape_->design(), tape_->q(0).data(), tape_->q(tape_->n_steps()).data(), t.weight, first.data(),
                        last.data(), bar_.spine.data());
    seed_position(0, first.data());
    seed_position(tape_->n_steps(), last.data());
}

void Adjoint::collect(long step) {
    auto &qs = q_seed_[static_cast<std::size_t>(step)], &vs = v_seed_[static_cast<std::size_t>(step)];
    if (!qs.empty())
        for (std::size_t i = 0; i < state_bar_.q.size(); ++i) state_bar_.q[i] += qs[i];
    if (!vs.empty())
        for (std::size_t i = 0; i < state_bar_.v.size(); ++i) state_bar_.v[i] += vs[i];
    qs = {}, vs = {};
}

void Adjoint::control(long step, const State& now, StepBar& out, std::vector<double>& theta_bar, DesignBar& bar) const {
    const Controller* controller = tape_->controller();
    if (!controller || !controller->differentiable()) return;
    std::vector<double> seen, seen_bar(static_cast<std::size_t>(controller->n_sensors()), 0.0);
    if (!seen_bar.empty()) seen = observe(tape_->design(), now.q.data(), now.v.data());
    controller->pullback(tape_->first_step() + step, seen.data(), out.signals.data(), theta_bar.data(),
                         seen_bar.data());
    if (!seen_bar.empty())
        observe_pullback(tape_->design(), now.q.data(), now.v.data(), seen_bar.data(), out.state.q.data(),
                         out.state.v.data(), bar);
}

void Adjoint::backward(long to_step, const StepMonitor& monitor) {
    if (!begun_) {
        collect(position_);
        begun_ = true;
    }
    const long from = position_;
    while (position_ > to_step) {
        const long step = position_ - 1;
        // Into fresh arrays: the running cotangents change only once the step succeeded, so that it can be tried again.
        const State now = tape_->state(step);
        std::vector<double> theta_bar(theta_bar_);
        DesignBar bar(bar_);
        const AdjointReport report = stepper_.adjoint(now, {tape_->actuation(step).data(), tape_->current(step)},
                                                      tape_->state(step + 1), step, state_bar_, step_bar_, bar);
        control(step, now, step_bar_, theta_bar, bar);
        iterations_ += report.linear_iterations;
        worst_residual_ = std::max(worst_residual_, report.residual);
        std::swap(state_bar_, step_bar_.state), std::swap(bar_, bar), theta_bar_.swap(theta_bar);
        signal_bar_[static_cast<std::size_t>(step)] = step_bar_.signals;
        position_ = step;
        collect(step);
        if (monitor) monitor(from - position_, from - to_step);
    }
}

std::vector<double> Adjoint::weights_bar() {
    if (weights_bar_.empty()) weights_bar_ = tape_->design().weights_bar(bar_, nullptr);
    return weights_bar_;
}

std::vector<double> Adjoint::control_bar() const {
    const Controller* controller = tape_->controller();
    if (!controller) fail(Status::ERROR_STATE, "CONTROL: the tape was not driven by a controller");
    if (!controller->differentiable())
        fail(Status::ERROR_STATE, "CONTROL: the tape's controller has no pullback callback");
    return theta_bar_;
}

std::vector<double> Adjoint::actuation_bar() const {
    std::vector<double> out;
    const std::size_t n = static_cast<std::size_t>(tape_->design().n_signals());
    for (const auto& s : signal_bar_)
        for (std::size_t k = 0; k < n; ++k) out.push_back(s.empty() ? 0.0 : s[k]);
    return out;
}

}  // namespace dqa
