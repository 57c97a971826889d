// SPDX-License-Identifier: MIT
#include "trial.hpp"

#include <algorithm>
#include <cmath>

#include "oracle_run.hpp"
#include "tape/adjoint.hpp"

namespace stability {
namespace {

using dqa::Design;
using dqa::Simulation;

constexpr double kStill = 1e-6;  // cells: a body that moves less than that is at rest

bool all_finite(const Vector& a) {
    return std::all_of(a.begin(), a.end(), [](double x) { return std::isfinite(x); });
}

double top_speed(const Vector& v) {
    double top = 0.0;
    for (std::size_t n = 0; n < v.size(); n += 3)
        top = std::max(top, std::sqrt(v[n] * v[n] + v[n + 1] * v[n + 1] + v[n + 2] * v[n + 2]));
    return top;
}

Gradient gradient_of(const std::shared_ptr<dqa::Tape>& tape) {
    dqa::Adjoint adjoint(tape);
    adjoint.seed_objective({dqa::ObjectiveTerm{}});
    adjoint.backward(0, nullptr);
    return {adjoint.actuation_bar(), adjoint.velocity_bar(), adjoint.weights_bar()};
}

// Relative to b, or to `least` where that is larger.
double relative_error(const Vector& a, const Vector& b, double least = 0.0) {
    double difference = 0.0, size = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) difference += (a[i] - b[i]) * (a[i] - b[i]), size += b[i] * b[i];
    return difference == 0.0 ? 0.0 : std::sqrt(difference) / std::max(least, std::sqrt(size));
}

void compare_gradients(const Gradient& ours, const OracleRun& oracle, Result& out) {
    if (!all_finite(ours.actuation) || !all_finite(ours.velocity) || !all_finite(ours.weights)) {
        out.outcome = Outcome::nan;
        out.reason = "the gradient is not finite";
        return;
    }
    const Gradient theirs = gradient_of(oracle.tape());
    const Design& design = oracle.design();
    double mass = 0.0;
    for (const double m : design.mass()) mass += 3.0 * m;
    const double way =
        mass_norm(design, oracle.state().q, oracle.tape()->q(0)) / std::sqrt(mass) + kStill * design.space().box().dx;
    const double by_actuation = relative_error(ours.actuation, theirs.actuation),
                 by_velocity = relative_error(ours.velocity, theirs.velocity),
                 by_weights = relative_error(ours.weights, theirs.weights, way);
    out.gradient_error = std::max({by_actuation, by_velocity, by_weights});
    if (!(out.gradient_error <= kGradientBound)) {
        out.outcome = Outcome::silent;
        out.reason = dqa::format("gradient by actuation %.1e; velocity %.1e; weights %.1e off", by_actuation,
                                 by_velocity, by_weights);
    }
}

}  // namespace

const char* name_of(Outcome outcome) {
    constexpr const char* names[] = {"accurate", "reported", "silent", "nan"};
    return names[static_cast<std::size_t>(outcome)];
}

std::string Trial::method() const {
    constexpr const char* names[] = {"newton_pcg", "newton_direct", "pd"};
    const std::string solver = reference ? "reference" : names[static_cast<std::size_t>(scene.method)];
    return variant.empty() ? solver : solver + "/" + variant;
}

Vector Trial::signals(const Design& design, int step) const {
    return Vector(static_cast<std::size_t>(design.n_signals()), step / 2 % 2 ? -stroke : stroke);
}

dqa::State Trial::start_of(const Design& design) const {
    dqa::State s;
    s.q = design.rest();
    s.v.assign(s.q.size(), 0.0);
    if (start) start(design, s.q, s.v);
    return s;
}

void report_error(const dqa::Error& error, Result& out) {
    out.outcome = Outcome::reported;
    out.reason = error.what();
    std::replace(out.reason.begin(), out.reason.end(), ',', ';');
    std::replace(out.reason.begin(), out.reason.end(), '\n', ' ');
}

Answer answer_of_library(const Trial& trial, Result& out) {
    Answer answer;
    auto tape = std::make_shared<dqa::Tape>(0);
    answer.gradient = [tape] { return gradient_of(tape); };
    try {
        answer.design = std::make_shared<Design>(trial.space, trial.weights, trial.scene, nullptr);
        Simulation simulation(answer.design);
        const dqa::State start = trial.start_of(*answer.design);
        simulation.set_state(start.q.data(), start.v.data());
        for (int k = 0; k < trial.steps; ++k) {
            const dqa::StepReport report = dqa::advance(simulation, trial.signals(*answer.design, k), tape.get());
            answer.q.push_back(simulation.q());
            out.residual = std::max(out.residual, report.residual);
            out.rescued += report.rescued;
            out.inverted = std::max(out.inverted, report.inverted);
            out.max_speed = std::max(out.max_speed, top_speed(simulation.v()));
        }
        out.outcome = Outcome::accurate;
    } catch (const dqa::Error& e) {
        report_error(e, out);
    }
    return answer;
}

Result run(const Trial& trial) {
    Result out;
    const Answer answer = trial.reference ? answer_of_reference(trial, out) : answer_of_library(trial, out);
    out.steps_done = static_cast<int>(answer.q.size());
    if (!answer.design) return out;
    for (const Vector& q : answer.q)
        if (!all_finite(q)) {
            out.outcome = Outcome::nan;
            out.reason = "a state is not finite";
            return out;
        }
    OracleRun oracle(*answer.design, trial.start_of(*answer.design));
    for (int k = 0; k < trial.steps && k <= out.steps_done; ++k) {
        const bool failed = k == out.steps_done;
        const Vector* hint = failed ? nullptr : &answer.q[static_cast<std::size_t>(k)];
        out.solvable = oracle.step(trial.signals(*answer.design, k), hint, trial.independent);
        if (failed) break;
        if (!out.solvable) {
            out.outcome = Outcome::silent;
            out.reason = dqa::format("the oracle finds no equilibrium near the answer of step %d", k);
            return out;
        }
        out.state_error = std::max(out.state_error, oracle.distance(*hint, oracle.state().q));
        if (!(out.state_error <= kStateBound)) break;  // whatever follows, the answer is wrong
    }
    if (!(out.state_error <= kStateBound)) {
        out.outcome = Outcome::silent;
        out.reason = dqa::format("positions are off by %.1e of the way moved", out.state_error);
    }
    if (out.outcome != Outcome::accurate) return out;
    out.reason = oracle.other_basins();
    try {
        compare_gradients(answer.gradient(), oracle, out);
    } catch (const dqa::Error& e) {
        report_error(e, out);
    }
    return out;
}

double check_oracle(const Trial& trial) {
    const Design design(trial.space, trial.weights, trial.scene, nullptr);
    OracleRun middle(design, trial.start_of(design));
    std::vector<Vector> states;
    for (int k = 0; k < trial.steps; ++k) {
        if (!middle.step(trial.signals(design, k), nullptr)) return std::nan("");
        states.push_back(middle.state().q);
    }
    const Gradient g = gradient_of(middle.tape());
    double worst = 0.0;
    for (const int at : {0, trial.steps - 1}) {
        double value[2] = {0.0, 0.0};
        const double eps = 2e-5;
        for (int side = 0; side < 2; ++side) {
            OracleRun moved(design, trial.start_of(design));
            for (int k = 0; k < trial.steps; ++k) {
                Vector signals = trial.signals(design, k);
                if (k == at) signals[0] += side ? eps : -eps;
                if (!moved.step(signals, &states[static_cast<std::size_t>(k)])) return std::nan("");
            }
            value[side] = moved.tape()->objective({dqa::ObjectiveTerm{}}, nullptr);
        }
        const std::size_t entry = static_cast<std::size_t>(at * design.n_signals());
        const double difference = (value[1] - value[0]) / (2.0 * eps);
        double size = 0.0;
        for (const double x : g.actuation) size = std::max(size, std::fabs(x));
        worst = std::max(worst, std::fabs(difference - g.actuation[entry]) / size);
    }
    return worst;
}

}  // namespace stability
