// SPDX-License-Identifier: MIT
#include "tape/adjoint.hpp"

#include <algorithm>

#include "grid/error.hpp"

namespace dqa {

Adjoint::Adjoint(std::shared_ptr<const Tape> tape)
    : tape_(std::move(tape)),
      reader_(*tape_),
      stepper_(tape_->shared_design()),
      position_(tape_->n_steps()),
      q_seed_(static_cast<std::size_t>(position_) + 1),
      v_seed_(static_cast<std::size_t>(position_) + 1),
      signal_bar_(static_cast<std::size_t>(position_)),
      current_bar_(static_cast<std::size_t>(position_)),
      bar_(tape_->design().zero_bar()) {
    stepper_.expect_sweep(position_);
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

void add(StepBar& to, const StepBar& from) {
    for (const auto field : {&State::q, &State::v, &State::q_before, &State::v_before})
        accumulate(to.state.*field, (from.state.*field).data(), (from.state.*field).size());
    for (std::size_t k = 0; k < 3; ++k) to.current[k] += from.current[k];
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
    tape_->require_terms(terms);
    for (const ObjectiveTerm& t : terms) {
        if (t.kind != ObjectiveKind::travel) {
            terms_.push_back(t);
            continue;
        }
        std::vector<double> first(state_bar_.q.size(), 0.0), last(state_bar_.q.size(), 0.0);
        travel_pullback(tape_->design(), tape_->q(0).data(), tape_->q(tape_->n_steps()).data(), t.weight, first.data(),
                        last.data(), bar_.spine.data());
        seed_position(0, first.data());
        seed_position(tape_->n_steps(), last.data());
    }
}

void Adjoint::collect(long step) {
    auto &qs = q_seed_[static_cast<std::size_t>(step)], &vs = v_seed_[static_cast<std::size_t>(step)];
    if (!qs.empty())
        for (std::size_t i = 0; i < state_bar_.q.size(); ++i) state_bar_.q[i] += qs[i];
    if (!vs.empty())
        for (std::size_t i = 0; i < state_bar_.v.size(); ++i) state_bar_.v[i] += vs[i];
    qs = {}, vs = {};
    totals_bar_ = {};
    if (step == 0) return;  // objectives look at the states that steps lead to
    for (const ObjectiveTerm& t : terms_)
        state_pullback(t, tape_->design(), tape_->observed(step), tape_->time(step), t.weight, next_, state_bar_,
                       totals_bar_, bar_);
}

void Adjoint::efforts(long step, std::vector<double>& signals_bar) const {
    const double h = tape_->design().scene().time_step;
    for (const ObjectiveTerm& t : terms_)
        if (t.kind == ObjectiveKind::effort) effort_pullback(tape_->actuation(step), h, t.weight, signals_bar.data());
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
        next_ = reader_.state(position_);
        collect(position_);
        begun_ = true;
    }
    const long from = position_;
    while (position_ > to_step) {
        const long step = position_ - 1;
        // Into fresh arrays: the running cotangents change only once the step succeeded, so that it can be tried again.
        State now = reader_.state(step);
        std::vector<double> theta_bar(theta_bar_);
        DesignBar bar(bar_);
        const StepInput input{tape_->actuation(step).data(), tape_->current(step)};
        const bool by_totals = totals_bar_.mean_drag != Vec3{} || totals_bar_.mean_thrust != Vec3{};
        State next_bar;
        if (by_totals) {
            next_bar = state_bar_;
            stepper_.totals_pullback(now, input, next_, totals_bar_, next_bar, totals_step_bar_, bar);
        }
        const AdjointReport report =
            stepper_.adjoint(now, input, next_, step, by_totals ? next_bar : state_bar_, step_bar_, bar);
        if (by_totals) add(step_bar_, totals_step_bar_);
        efforts(step, step_bar_.signals);
        control(step, now, step_bar_, theta_bar, bar);
        // Nothing throws until the cursor has moved.
        stepper_.keep_solution();
        iterations_ += report.linear_iterations;
        worst_residual_ = std::max(worst_residual_, report.residual);
        std::swap(state_bar_, step_bar_.state), std::swap(bar_, bar), theta_bar_.swap(theta_bar);
        signal_bar_[static_cast<std::size_t>(step)] = std::move(step_bar_.signals);
        current_bar_[static_cast<std::size_t>(step)] = step_bar_.current;
        next_ = std::move(now);
        position_ = step;
        collect(step);
        // A function's pullback hears of every step once; tables are gathered on demand.
        tape_->current_source(step).function_pullback(tape_->time(step), step_bar_.current);
        if (monitor) monitor(from - position_, from - to_step);
    }
}

std::vector<Vec3> Adjoint::current_table_bar() const {
    const WaterCurrent& table = tape_->current_source(0);
    std::vector<Vec3> bar(table.rows().size());
    for (long step = 0; step < tape_->n_steps(); ++step) {
        if (bar.empty() || &tape_->current_source(step) != &table)
            fail(Status::ERROR_STATE, "CURRENT_TABLE: not all steps of the tape read their current from one table");
        table.table_pullback(tape_->time(step), current_bar_[static_cast<std::size_t>(step)], bar);
    }
    return bar;
}

std::vector<double> Adjoint::water_bar() const {
    std::vector<double> out(3, 0.0);
    for (const Vec3& bar : current_bar_)
        for (std::size_t k = 0; k < 3; ++k) out[k] += bar[k];
    std::array<double, 4> drag{}, thrust{};
    WaterLaws::ordinates_pullback(bar_.water.laws, drag, thrust);
    out.push_back(bar_.water.density);
    out.insert(out.end(), drag.begin(), drag.end());
    out.insert(out.end(), thrust.begin(), thrust.end());
    return out;
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
