// SPDX-License-Identifier: MIT
#include "tape/tape.hpp"

#include <algorithm>

#include "grid/error.hpp"
#include "tape/reader.hpp"

namespace dqa {
namespace {

bool is_two_step(const Design& design) {
    return design.scene().integrator == Integrator::bdf2;
}

std::int64_t field_bytes(const Design& design) {
    return static_cast<std::int64_t>(sizeof(double) * design.rest().size());
}

// A state by itself, and one among all others.
std::int64_t state_bytes(const Design& design) {
    return field_bytes(design) * (is_two_step(design) ? 4 : 2);
}
std::int64_t dense_bytes(const Design& design) {
    return field_bytes(design) * (is_two_step(design) ? 2 : 1);
}

// Inputs and observed numbers.
std::int64_t input_bytes(const Design& design) {
    return static_cast<std::int64_t>(sizeof(double)) * design.n_signals() +
           static_cast<std::int64_t>(sizeof(Vec3) + sizeof(Observed));
}

std::int64_t bytes_of(const State& s) {
    return static_cast<std::int64_t>(sizeof(double) *
                                     (s.q.size() + s.v.size() + s.q_before.size() + s.v_before.size()));
}

}  // namespace

void Tape::make_room(const Design& design) {
    if (memory_bytes_ <= 0) return;
    const std::int64_t state = state_bytes(design), inputs = (n_steps() + 1) * input_bytes(design);
    if (memory_bytes_ < inputs + 4 * state)
        fail(Status::ERROR_MEMORY, "memory_bytes is %lld, expected at least %lld to record step %ld of %d nodes",
             static_cast<long long>(memory_bytes_), static_cast<long long>(inputs + 4 * state), n_steps(),
             design.n_nodes());
    if (stride_ == 1) {
        const std::int64_t now = empty() ? state : statistics_.bytes;
        if (now + dense_bytes(design) + input_bytes(design) <= memory_bytes_) return;
    }
    // The states after the coming step: every stride-th, the first included, and the last.
    const std::int64_t room = (memory_bytes_ - inputs) / 2;
    long stride = std::max(2L, stride_);
    while (((n_steps() + 1) / stride + 2) * state > room) stride *= 2;
    if (stride == stride_) return;
    try {
        thin(stride);
    } catch (...) {  // out of memory half-way: nothing is left that could be used
        clear();
        throw;
    }
}

void Tape::thin(long stride) {
    std::vector<State> kept;
    if (stride_ == 1) {
        last_ = kept_state(n_steps());
        for (long k = 0; k <= n_steps(); k += stride) {
            kept.push_back(kept_state(k));
            // What came before is not needed any more.
            for (long j = std::max(0L, k - stride); j < k; ++j) states_[static_cast<std::size_t>(j)] = {};
        }
    } else {
        const std::size_t factor = static_cast<std::size_t>(stride / stride_);
        for (std::size_t k = 0; k < states_.size(); k += factor) kept.push_back(std::move(states_[k]));
    }
    states_ = std::move(kept);
    stride_ = stride;
    count_bytes();
}

void Tape::count_bytes() {
    statistics_.bytes = bytes_of(last_) + n_steps() * input_bytes(*design_);
    for (const State& s : states_) statistics_.bytes += bytes_of(s);
}

void Tape::begin(const Simulation& simulation) {
    if (design_) return;
    design_ = simulation.shared_design();
    states_.push_back(simulation.state());
    observed_.push_back(observed_of(simulation));
    first_step_ = simulation.steps();
    count_bytes();
}

void Tape::append(const Simulation& simulation, const StepInput& input, const StepReport& report) {
    const std::size_t n = actuation_.size(), observed = observed_.size();
    try {
        actuation_.emplace_back(input.signals, input.signals + design_->n_signals());
        current_.push_back(input.current);
        current_source_.push_back(simulation.current());
        observed_.push_back(observed_of(simulation));
        keep_state(simulation);
    } catch (...) {  // out of memory: as it was
        actuation_.resize(n), current_.resize(n), current_source_.resize(n), observed_.resize(observed);
        throw;
    }
    statistics_.bytes += input_bytes(*design_);
    statistics_.newton_iterations += report.newton_iterations;
    statistics_.linear_iterations += report.linear_iterations;
    statistics_.rescued_steps += report.rescued ? 1 : 0;
    statistics_.indefinite_steps += report.indefinite > 0 ? 1 : 0;
    statistics_.worst_residual = std::max(statistics_.worst_residual, report.residual);
}

// All of it or, on an exception, nothing.
void Tape::keep_state(const Simulation& simulation) {
    if (stride_ == 1) {
        State s;
        s.q = simulation.q();
        if (is_two_step(*design_)) s.v = simulation.v();
        const std::int64_t bytes = bytes_of(s);
        states_.push_back(std::move(s));
        statistics_.bytes += bytes;
        return;
    }
    State s = simulation.state();
    const std::int64_t bytes = bytes_of(s);
    if (n_steps() % stride_ == 0) {
        states_.push_back(s);
        statistics_.bytes += bytes;
    }
    statistics_.bytes += bytes - bytes_of(last_);
    last_ = std::move(s);
}

bool Tape::continues(const Simulation& simulation) const {
    return empty() || (design_ == simulation.shared_design() && first_step_ + n_steps() == simulation.steps() &&
                       kept_state(n_steps()) == simulation.state());
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
    states_.clear(), observed_.clear(), actuation_.clear(), current_.clear(), current_source_.clear();
    last_ = {};
    stride_ = 1;
    first_step_ = 0;
    statistics_ = {};
    recomputed_ = 0;
}

State Tape::kept_state(long step) const {
    if (stride_ > 1) return step == n_steps() ? last_ : states_[static_cast<std::size_t>(step / stride_)];
    const std::size_t k = static_cast<std::size_t>(step);
    if (k == 0) return states_[0];
    State s;
    s.q = states_[k].q, s.v = states_[k].v;
    if (is_two_step(*design_)) {
        s.q_before = states_[k - 1].q, s.v_before = states_[k - 1].v;
        return s;
    }
    const double h = design_->scene().time_step;
    s.v.resize(s.q.size());
    for (std::size_t i = 0; i < s.q.size(); ++i) s.v[i] = (s.q[i] - states_[k - 1].q[i]) / h;
    for (const int i : design_->constrained()) s.v[static_cast<std::size_t>(i)] = 0.0;
    return s;
}

State Tape::state(long step) const {
    return keeps(step) ? kept_state(step) : TapeReader(*this).state(step);
}

long Tape::reader_slots() const {
    if (stride_ == 1) return 0;
    const std::int64_t room = (memory_bytes_ - n_steps() * input_bytes(*design_)) / 2;
    return static_cast<long>(room / state_bytes(*design_)) - 2;
}

std::int64_t Tape::n_kept() const {
    if (empty()) return 0;
    return static_cast<std::int64_t>(states_.size()) + (stride_ > 1 && n_steps() % stride_ != 0 ? 1 : 0);
}

void Tape::require_terms(const std::vector<ObjectiveTerm>& terms) const {
    for (std::size_t k = 0; k < terms.size(); ++k)
        if (terms[k].kind == ObjectiveKind::efficiency && !design_->water())
            fail(Status::ERROR_ARGUMENT, "terms[%zu] is the efficiency of swimming in water, and the scene has none",
                 k);
}

double Tape::objective(const std::vector<ObjectiveTerm>& terms, double* per_term) const {
    require_terms(terms);
    const std::vector<double> first = q(0), last = q(n_steps());
    double loss = 0.0;
    for (std::size_t k = 0; k < terms.size(); ++k) {
        double value = 0.0;
        if (terms[k].kind == ObjectiveKind::travel)
            value = travel_loss(*design_, first.data(), last.data());
        else if (terms[k].kind == ObjectiveKind::effort)
            for (const auto& a : actuation_) value += effort_value(a, design_->scene().time_step);
        else
            for (long i = 1; i <= n_steps(); ++i) value += state_value(terms[k], *design_, observed(i), time(i));
        if (per_term) per_term[k] = value;
        loss += terms[k].weight * value;
    }
    return loss;
}

StepReport advance(Simulation& simulation, const std::vector<double>& signals, Tape* tape) {
    return advance(simulation, signals, simulation.current_now(), tape);
}

StepReport advance(Simulation& simulation, const std::vector<double>& signals, const Vec3& current, Tape* tape) {
    const StepInput input{signals.data(), current};
    if (!tape) return simulation.step(input);
    tape->make_room(simulation.design());
    const bool first = tape->empty();
    // Simulation and tape go on together or not at all, also when there is no memory for the record.
    State before = simulation.state();
    const long steps = simulation.steps();
    const WaterTotals forces = simulation.forces();
    try {
        tape->begin(simulation);
        const StepReport report = simulation.step(input);
        tape->append(simulation, input, report);
        return report;
    } catch (...) {
        if (first) tape->clear();
        simulation.take_back(std::move(before), steps, forces);
        throw;
    }
}

}  // namespace dqa
