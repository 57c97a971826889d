// SPDX-License-Identifier: MIT
#include "long_rollout.hpp"

#include <algorithm>
#include <cmath>

#include "grid/random.hpp"
#include "oracle_run.hpp"
#include "scenes.hpp"
#include "tape/adjoint.hpp"

namespace stability {
namespace {

using dqa::Design;
using dqa::Simulation;

constexpr double kDriftBound = 1e-5, kNudge = 1e-4;
constexpr int kWatch = 100;  // steps between looks at the energy

// Flying, turning and stretched at once.
Vector tumbling(const Design& design) {
    Vector v(design.rest().size());
    for (std::size_t i = 0; i < v.size(); i += 3) {
        const double *x = &design.rest()[i], turn[3] = {x[1], -x[0], 0.0};
        for (std::size_t a = 0; a < 3; ++a) v[i + a] = 0.2 + 4.0 * turn[a] + 2.0 * x[a];
    }
    return v;
}

std::array<double, 3> momentum(const Simulation& s) {
    std::array<double, 3> p{};
    for (std::size_t i = 0; i < s.v().size(); ++i) p[i % 3] += s.design().mass()[i / 3] * s.v()[i];
    return p;
}

double energy(const Simulation& s, const Vector& signals) {
    dqa::BodyWorkspace workspace;
    Vector elastic(s.q().size()), muscle(s.q().size());
    double e = s.design().body().gradient(workspace, s.q().data(), signals.data(), 1, elastic.data(), muscle.data());
    for (std::size_t i = 0; i < s.v().size(); ++i) e += 0.5 * s.design().mass()[i / 3] * s.v()[i] * s.v()[i];
    return e;
}

}  // namespace

Result run(const LongRollout& trial) {
    Result out;
    try {
        dqa::SceneSettings scene;
        scene.water = false;
        scene.integrator = trial.integrator;
        scene.time_step = trial.time_step;
        const auto design = std::make_shared<Design>(cell_space(), Vector{0.5, 0.5}, scene, nullptr);
        const Vector signals(static_cast<std::size_t>(design->n_signals()), 0.0), start = tumbling(*design);
        const auto tape = std::make_shared<dqa::Tape>(0);
        Simulation simulation(design);
        simulation.set_state(nullptr, start.data());
        const std::array<double, 3> p = momentum(simulation);
        const double first = energy(simulation, signals);
        double last = first;
        bool rises = false;
        for (; out.steps_done < trial.steps; ++out.steps_done) {
            const dqa::StepReport report = dqa::advance(simulation, signals, tape.get());
            out.residual = std::max(out.residual, report.residual);
            out.rescued += report.rescued, out.inverted = std::max(out.inverted, report.inverted);
            if ((out.steps_done + 1) % kWatch) continue;
            const double now = energy(simulation, signals);
            rises = rises || !(now <= last * (1.0 + 1e-6));
            last = now;
        }
        for (std::size_t a = 0; a < 3; ++a)
            out.state_error = std::max(out.state_error, std::fabs(momentum(simulation)[a] / p[a] - 1.0));
        dqa::Random random{3};
        Vector along(start.size());
        for (double& x : along) x = random();
        dqa::Adjoint adjoint(tape);
        adjoint.seed_objective({dqa::ObjectiveTerm{}});
        adjoint.backward(0, nullptr);
        double derivative = 0.0, value[2];
        for (std::size_t i = 0; i < along.size(); ++i) derivative += adjoint.velocity_bar()[i] * along[i];
        for (int side = 0; side < 2; ++side) {
            Vector v(start);
            for (std::size_t i = 0; i < v.size(); ++i) v[i] += (side ? kNudge : -kNudge) * along[i];
            dqa::Tape nudged(0);
            simulation.set_state(nullptr, v.data());
            for (int k = 0; k < trial.steps; ++k) dqa::advance(simulation, signals, &nudged);
            value[side] = nudged.objective({dqa::ObjectiveTerm{}}, nullptr);
        }
        const double difference = (value[1] - value[0]) / (2.0 * kNudge);
        out.gradient_error = std::fabs(derivative - difference) / std::fabs(difference);
        out.reason = dqa::format("energy falls to %.4f of its first value", last / first);
        out.outcome = Outcome::accurate;
        if (!std::isfinite(last) || !std::isfinite(derivative)) {
            out.outcome = Outcome::nan;
        } else if (rises || !(out.state_error <= kDriftBound) || !(out.gradient_error <= kGradientBound)) {
            out.outcome = Outcome::silent;
            if (rises) out.reason += "; it rose on the way";
        }
    } catch (const dqa::Error& e) {
        report_error(e, out);
    }
    return out;
}

}  // namespace stability
