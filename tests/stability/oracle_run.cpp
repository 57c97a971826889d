// SPDX-License-Identifier: MIT
#include "oracle_run.hpp"

#include <algorithm>
#include <cmath>

#include "grid/error.hpp"

namespace stability {
namespace {

constexpr int kIterations = 200;
constexpr int kSecondIterations = 60;  // from another start, which nothing depends on

}  // namespace

double mass_norm(const dqa::Design& design, const Vector& a, const Vector& b) {
    double s = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) s += design.mass()[i / 3] * (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(s);
}

OracleRun::OracleRun(const dqa::Design& like, const dqa::State& start) : state_(start) {
    dqa::SceneSettings scene = like.scene();
    scene.method = dqa::Method::newton_direct;
    scene.adjoint_tolerance = 1e-6;  // a direct solver does not iterate: this only lets its rounding pass
    design_ = std::make_shared<dqa::Design>(like, scene);
    simulation_ = std::make_unique<dqa::Simulation>(design_);
    simulation_->set_state(state_.q.data(), state_.v.data());
    tape_ = std::make_shared<dqa::Tape>(0);
    tape_->begin(*simulation_);
}

bool OracleRun::step(const Vector& signals, const Vector* hint, bool independent) {
    const dqa::StepInput input{signals.data(), design_->scene().hydrodynamics.current};
    from_ = state_.q;
    StepProblem problem(*design_, state_, input);
    Found found;
    if (hint) found = solve_step(problem, *hint, kIterations);
    if (!found.found || !found.minimum || distance(found.q, *hint) > kStateBound) {
        found = solve_step(problem, problem.predicted(), kIterations);
        if (!found.found) found = solve_step(problem, state_.q, kIterations);
    } else if (independent) {
        compare_basins(problem, found.q);
    }
    if (!found.found) return false;
    state_ = problem.state_of(state_, found.q);
    simulation_->restore(state_, simulation_->steps() + 1);
    dqa::StepReport report;
    report.residual = found.residual;
    tape_->append(*simulation_, input, report);
    return true;
}

void OracleRun::compare_basins(StepProblem& problem, const Vector& q) {
    const Found other = solve_step(problem, problem.predicted(), kSecondIterations);
    if (!other.found || !other.minimum || distance(other.q, q) <= kStateBound) return;
    const bool higher = problem.evaluate(other.q).energy > problem.evaluate(q).energy;
    if (!other_basins_.empty()) other_basins_ += "; ";
    other_basins_ +=
        dqa::format("step %ld has another minimum of %s energy", simulation_->steps() + 1, higher ? "higher" : "lower");
}

double OracleRun::distance(const Vector& a, const Vector& b) const {
    double mass = 0.0;
    for (const double m : design_->mass()) mass += 3.0 * m;
    const double least = 1e-9 * design_->space().box().dx * std::sqrt(mass);
    return mass_norm(*design_, a, b) /
           std::max({mass_norm(*design_, b, from_), mass_norm(*design_, b, tape_->q(0)), least});
}

}  // namespace stability
