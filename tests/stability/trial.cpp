// SPDX-License-Identifier: MIT
#include "trial.hpp"

#include <algorithm>
#include <cmath>

#include "grid/error.hpp"
#include "tape/adjoint.hpp"

namespace stability {
namespace {

using dqa::Design;
using dqa::Simulation;
using dqa::State;

constexpr double kStill = 1e-6;  // cells: a body that moves less than that is at rest
constexpr int kOracleIterations = 200;

double mass_norm(const Design& design, const Vector& a, const Vector& b) {
    double s = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) s += design.mass()[i / 3] * (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(s);
}

bool all_finite(const Vector& a) {
    return std::all_of(a.begin(), a.end(), [](double x) { return std::isfinite(x); });
}

double top_speed(const Vector& v) {
    double top = 0.0;
    for (std::size_t n = 0; n < v.size(); n += 3)
        top = std::max(top, std::sqrt(v[n] * v[n] + v[n + 1] * v[n + 1] + v[n + 2] * v[n + 2]));
    return top;
}

State start_of(const Trial& trial, const Design& design) {
    State s;
    s.q = design.rest();
    s.v.assign(s.q.size(), 0.0);
    if (trial.start) trial.start(design, s.q, s.v);
    return s;
}

Vector signals_of(const Trial& trial, const Design& design, int step) {
    return Vector(static_cast<std::size_t>(design.n_signals()), step / 2 % 2 ? -trial.stroke : trial.stroke);
}

struct Gradient {
    Vector actuation, velocity, weights;
};

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

std::string plain(std::string text) {
    std::replace(text.begin(), text.end(), ',', ';');
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

// A tape of the oracle's rollout. `follow` are the library's states, among which it may find its way.
class OracleRun {
public:
    OracleRun(const Trial& trial, const Design& like) : trial_(trial) {
        dqa::SceneSettings scene = trial.scene;
        scene.method = dqa::Method::newton_direct;
        scene.adjoint_tolerance = 1e-6;  // a direct solver does not iterate: this only lets its rounding pass
        design_ = std::make_shared<Design>(like, scene);
        simulation_ = std::make_unique<Simulation>(design_);
        state_ = start_of(trial, *design_);
        simulation_->set_state(state_.q.data(), state_.v.data());
        tape_ = std::make_shared<dqa::Tape>(0);
        tape_->begin(*simulation_);
    }

    const State& state() const { return state_; }
    const std::shared_ptr<dqa::Tape>& tape() const { return tape_; }

    // The equilibrium of the next step: the one that `hint` is at, if it is at one that is stable; otherwise, or
    // without a hint (null), what is found from the usual starting points. False: there is none.
    bool step(const Vector& signals, const Vector* hint) {
        const dqa::StepInput input{signals.data(), trial_.scene.hydrodynamics.current};
        from_ = state_.q;
        StepProblem problem(*design_, state_, input);
        Found found;
        if (hint) found = solve_step(problem, *hint, kOracleIterations);
        if (!found.found || !found.minimum || distance(found.q, *hint) > kStateBound) {
            found = solve_step(problem, problem.predicted(), kOracleIterations);
            if (!found.found) found = solve_step(problem, state_.q, kOracleIterations);
        }
        if (!found.found) return false;
        state_ = problem.state_of(state_, found.q);
        simulation_->restore(state_, simulation_->steps() + 1);
        dqa::StepReport report;
        report.residual = found.residual;
        tape_->append(*simulation_, input, report);
        return true;
    }

    // Of two answers to the last step, relative to the way to b from where the step or the rollout began. Ways shorter
    // than what rounding makes of places count as that.
    double distance(const Vector& a, const Vector& b) const {
        double mass = 0.0;
        for (const double m : design_->mass()) mass += 3.0 * m;
        const double least = 1e-9 * design_->space().box().dx * std::sqrt(mass);
        return mass_norm(*design_, a, b) /
               std::max({mass_norm(*design_, b, from_), mass_norm(*design_, b, tape_->q(0)), least});
    }

private:
    const Trial& trial_;
    std::shared_ptr<const Design> design_;
    std::unique_ptr<Simulation> simulation_;
    std::shared_ptr<dqa::Tape> tape_;
    State state_;
    Vector from_;  // positions at the start of the last step
};

}  // namespace

const char* name_of(Outcome outcome) {
    constexpr const char* names[] = {"accurate", "reported", "silent", "nan"};
    return names[static_cast<std::size_t>(outcome)];
}

std::string Trial::method() const {
    constexpr const char* names[] = {"newton_pcg", "newton_direct", "pd"};
    const std::string solver = names[static_cast<std::size_t>(scene.method)];
    return variant.empty() ? solver : solver + "/" + variant;
}

Result run(const Trial& trial) {
    Result out;
    std::shared_ptr<const Design> design;
    auto tape = std::make_shared<dqa::Tape>(0);
    const auto report_error = [&](const dqa::Error& e) {
        out.outcome = Outcome::reported;
        out.reason = plain(e.what());
    };
    try {
        design = std::make_shared<Design>(trial.space, trial.weights, trial.scene, nullptr);
        Simulation simulation(design);
        const State start = start_of(trial, *design);
        simulation.set_state(start.q.data(), start.v.data());
        for (; out.steps_done < trial.steps; ++out.steps_done) {
            const dqa::StepReport report =
                dqa::advance(simulation, signals_of(trial, *design, out.steps_done), tape.get());
            out.residual = std::max(out.residual, report.residual);
            out.rescued += report.rescued;
            out.inverted = std::max(out.inverted, report.inverted);
            out.max_speed = std::max(out.max_speed, top_speed(simulation.v()));
            if (!all_finite(simulation.q()) || !all_finite(simulation.v())) {
                out.reason = "a state is not finite";
                return out;
            }
        }
        out.outcome = Outcome::accurate;
    } catch (const dqa::Error& e) {
        report_error(e);
        if (!design) return out;
    }
    OracleRun oracle(trial, *design);
    for (int k = 0; k < trial.steps && k <= out.steps_done; ++k) {
        const bool failed = k == out.steps_done;
        const Vector hint = failed ? Vector() : tape->q(k + 1);
        out.solvable = oracle.step(signals_of(trial, *design, k), failed ? nullptr : &hint);
        if (failed) break;
        if (!out.solvable) {
            out.outcome = Outcome::silent;
            out.reason = dqa::format("the oracle finds no equilibrium near the answer of step %d", k);
            return out;
        }
        out.state_error = std::max(out.state_error, oracle.distance(hint, oracle.state().q));
    }
    if (!(out.state_error <= kStateBound)) {
        out.outcome = Outcome::silent;
        out.reason = "the oracle ends elsewhere";
    }
    if (out.outcome != Outcome::accurate) return out;
    try {
        const Gradient ours = gradient_of(tape), theirs = gradient_of(oracle.tape());
        if (!all_finite(ours.actuation) || !all_finite(ours.velocity) || !all_finite(ours.weights)) {
            out.outcome = Outcome::nan;
            out.reason = "the gradient is not finite";
            return out;
        }
        double mass = 0.0;
        for (const double m : design->mass()) mass += 3.0 * m;
        const double way = mass_norm(*design, oracle.state().q, start_of(trial, *design).q) / std::sqrt(mass) +
                           kStill * design->space().box().dx;
        const double by_actuation = relative_error(ours.actuation, theirs.actuation),
                     by_velocity = relative_error(ours.velocity, theirs.velocity),
                     by_weights = relative_error(ours.weights, theirs.weights, way);
        out.gradient_error = std::max({by_actuation, by_velocity, by_weights});
        if (!(out.gradient_error <= kGradientBound)) {
            out.outcome = Outcome::silent;
            out.reason = dqa::format("gradient by actuation %.1e; velocity %.1e; weights %.1e off", by_actuation,
                                     by_velocity, by_weights);
        }
    } catch (const dqa::Error& e) {
        report_error(e);
    }
    return out;
}

double check_oracle(const Trial& trial) {
    const Design design(trial.space, trial.weights, trial.scene, nullptr);
    OracleRun middle(trial, design);
    std::vector<Vector> states;
    for (int k = 0; k < trial.steps; ++k) {
        if (!middle.step(signals_of(trial, design, k), nullptr)) return std::nan("");
        states.push_back(middle.state().q);
    }
    const Gradient g = gradient_of(middle.tape());
    double worst = 0.0;
    for (int at = 0; at < trial.steps; ++at) {
        double value[2] = {0.0, 0.0};
        const double eps = 2e-5;
        for (int side = 0; side < 2; ++side) {
            OracleRun moved(trial, design);
            for (int k = 0; k < trial.steps; ++k) {
                Vector signals = signals_of(trial, design, k);
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
