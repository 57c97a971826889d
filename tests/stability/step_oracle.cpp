// SPDX-License-Identifier: MIT
#include "step_oracle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stability {
namespace {

constexpr double kTolerance = 1e-12;

double norm_of(const Vector& a) {
    double s = 0.0;
    for (const double x : a) s += x * x;
    return std::sqrt(s);
}

}  // namespace

bool StepProblem::Value::finite() const {
    return std::isfinite(energy) && std::isfinite(residual) && std::isfinite(scale);
}

StepProblem::StepProblem(const dqa::Design& design, const dqa::State& now, const dqa::StepInput& input)
    : design_(design), signals_(input.signals, input.signals + design.n_signals()), base_(now.q), inertial_(now.q) {
    const dqa::SceneSettings& scene = design.scene();
    const bool two_step = !now.q_before.empty();
    beta_ = two_step ? 2.0 / 3.0 * scene.time_step : scene.time_step;
    Vector lag_q(now.q), lag_v(now.v);
    for (std::size_t i = 0; i < base_.size(); ++i) {
        double velocity = now.v[i];
        if (two_step) {
            base_[i] = (4.0 * now.q[i] - now.q_before[i]) / 3.0;
            velocity = (4.0 * now.v[i] - now.v_before[i]) / 3.0;
            lag_q[i] += now.q[i] - now.q_before[i];
            lag_v[i] += now.v[i] - now.v_before[i];
        }
        inertial_[i] = base_[i] + beta_ * velocity;
    }
    predicted_ = inertial_;
    for (const int i : design.constrained())
        predicted_[static_cast<std::size_t>(i)] = now.q[static_cast<std::size_t>(i)];
    if (design.water())
        design.water()->lag(water_, lag_q.data(), lag_v.data(), design.sensors().direction(lag_q.data()), input.current,
                            1);
    // Nodes of equal coordinates modulo 3 share no cell, so that their columns may be probed together.
    const auto& nodes = design.set().node_ijk;
    const dqa::Box& box = design.space().box();
    colours_.resize(27);
    std::vector<char> fixed(base_.size(), 0);
    for (const int i : design.constrained()) fixed[static_cast<std::size_t>(i)] = 1;
    pattern_.n = static_cast<int>(base_.size());
    std::vector<int> rows;  // of a node and its neighbours
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        const auto& [i, j, k] = nodes[n];
        colours_[static_cast<std::size_t>(i % 3 * 9 + j % 3 * 3 + k % 3)].push_back(static_cast<int>(n));
        rows.clear();
        for (int a = std::max(0, i - 1); a <= std::min(box.cells[0], i + 1); ++a)
            for (int b = std::max(0, j - 1); b <= std::min(box.cells[1], j + 1); ++b)
                for (int c = std::max(0, k - 1); c <= std::min(box.node_planes() - 1, k + 1); ++c) {
                    const int other = design.set().node_to_active[static_cast<std::size_t>(box.node(a, b, c))];
                    for (int axis = 0; other >= 0 && axis < 3; ++axis) rows.push_back(3 * other + axis);
                }
        std::sort(rows.begin(), rows.end());
        for (int column = 3 * static_cast<int>(n); column < 3 * static_cast<int>(n) + 3; ++column) {
            pattern_.start.push_back(static_cast<int>(pattern_.row.size()));
            for (const int row : rows) {
                const bool free = !fixed[static_cast<std::size_t>(row)] && !fixed[static_cast<std::size_t>(column)];
                if (row == column || (row > column && free)) pattern_.row.push_back(row);
            }
        }
    }
    pattern_.start.push_back(static_cast<int>(pattern_.row.size()));
}

StepProblem::Value StepProblem::evaluate(const Vector& q) {
    Value out;
    const std::size_t n = q.size();
    Vector elastic(n), muscle(n), flow(n, 0.0), inertia(n);
    out.energy = design_.body().gradient(body_, q.data(), signals_.data(), 1, elastic.data(), muscle.data());
    if (design_.water()) out.energy += design_.water()->gradient(water_, q.data(), base_.data(), beta_, 1, flow.data());
    double rounding2 = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        const double away = q[i] - inertial_[i];
        inertia[i] = design_.mass()[i / 3] / (beta_ * beta_) * away;
        out.energy += 0.5 * inertia[i] * away;
        const double force = design_.stiffness_diagonal()[i / 3] * q[i] * std::numeric_limits<double>::epsilon();
        rounding2 += force * force;
    }
    out.scale = norm_of(elastic) + norm_of(muscle) + norm_of(flow) + norm_of(inertia);
    out.gradient.resize(n);
    for (std::size_t i = 0; i < n; ++i) out.gradient[i] = elastic[i] + muscle[i] + flow[i] + inertia[i];
    for (const int i : design_.constrained()) out.gradient[static_cast<std::size_t>(i)] = 0.0;
    const double size = norm_of(out.gradient);
    out.residual = out.scale > 0 ? size / out.scale : size;
    out.rounding = out.scale > 0 ? std::sqrt(rounding2) / out.scale : 0.0;
    return out;
}

void StepProblem::product(const Vector& p, Vector& out) {
    for (std::size_t i = 0; i < p.size(); ++i) out[i] = design_.mass()[i / 3] / (beta_ * beta_) * p[i];
    design_.body().product(body_, p.data(), 1, out.data());
    if (design_.water()) design_.water()->product(water_, p.data(), beta_, 1, out.data());
}

dqa::SymmetricMatrix StepProblem::hessian() {
    dqa::SymmetricMatrix h = pattern_;
    h.value.resize(h.row.size());
    Vector probe(base_.size()), out(base_.size());
    for (const auto& colour : colours_)
        for (std::size_t axis = 0; axis < 3 && !colour.empty(); ++axis) {
            std::fill(probe.begin(), probe.end(), 0.0);
            for (const int node : colour) probe[3 * static_cast<std::size_t>(node) + axis] = 1.0;
            product(probe, out);
            for (const int node : colour) {
                const std::size_t column = 3 * static_cast<std::size_t>(node) + axis;
                for (std::size_t k = static_cast<std::size_t>(h.start[column]);
                     k < static_cast<std::size_t>(h.start[column + 1]); ++k)
                    h.value[k] = out[static_cast<std::size_t>(h.row[k])];
            }
        }
    for (const int i : design_.constrained())
        h.value[static_cast<std::size_t>(h.start[static_cast<std::size_t>(i)])] = 1.0;
    return h;
}

dqa::State StepProblem::state_of(const dqa::State& now, const Vector& q) const {
    dqa::State out;
    out.q = q;
    out.v.resize(q.size());
    for (std::size_t i = 0; i < q.size(); ++i) out.v[i] = (q[i] - base_[i]) / beta_;
    for (const int i : design_.constrained()) out.v[static_cast<std::size_t>(i)] = 0.0;
    if (design_.scene().integrator == dqa::Integrator::bdf2) out.q_before = now.q, out.v_before = now.v;
    return out;
}

Found solve_step(StepProblem& problem, const Vector& start, int max_iterations) {
    Found out;
    out.q = start;
    StepProblem::Value now = problem.evaluate(out.q);
    const Vector& diagonal = problem.design().stiffness_diagonal();
    const double dx = problem.design().space().box().dx;
    const double cancelling = std::numeric_limits<double>::epsilon() * problem.design().body().cancelling();
    double shift = 0.0, stride = std::numeric_limits<double>::infinity();
    const auto shifted_by = [&](dqa::SymmetricMatrix m, double s) {
        for (std::size_t j = 0; j < out.q.size(); ++j)
            m.value[static_cast<std::size_t>(m.start[j])] += s * diagonal[j / 3];
        return m;
    };
    for (; now.finite() && out.iterations < max_iterations; ++out.iterations) {
        // Where Newton's steps have become as short as the rounding of places there is nothing left to gain.
        if (now.residual <= kTolerance || (shift == 0.0 && stride < 1e-13 * dx)) break;
        const dqa::SymmetricMatrix h = problem.hessian();
        bool moved = false, settled = false;
        for (int trial = 0; trial < 40 && !moved && !settled; ++trial) {
            Vector d(now.gradient);
            for (double& x : d) x = -x;
            if (dqa::solve_positive(shifted_by(h, shift), d)) {
                double slope = 0.0;
                Vector q(out.q);
                for (std::size_t i = 0; i < q.size(); ++i) slope += now.gradient[i] * d[i], q[i] += d[i];
                const StepProblem::Value next = problem.evaluate(q);
                const double noise = 1e-13 * std::fabs(now.energy) + cancelling + 1e-15 * now.scale * norm_of(q);
                if (next.finite() && (next.energy <= now.energy + 1e-3 * slope ||
                                      (next.energy <= now.energy + noise && next.residual <= now.residual))) {
                    stride = shift == 0.0 ? norm_of(d) : std::numeric_limits<double>::infinity();
                    out.q.swap(q);
                    now = next;
                    moved = true;
                    shift = shift < 1e-9 ? 0.0 : 0.1 * shift;
                    break;
                }
                // Forces at the rounding of places, and a full step that only trades one rounding for another: more
                // such steps would wander about the answer.
                settled = shift == 0.0 && now.residual <= now.rounding && std::fabs(next.energy - now.energy) <= noise;
            }
            shift = std::max(1e-8, 5.0 * shift);
        }
        if (!moved) break;
    }
    now = problem.evaluate(out.q);
    out.residual = now.residual;
    out.found = now.finite() && now.residual <= std::max(1e-10, 10.0 * now.rounding);
    if (out.found) {
        Vector none(out.q.size(), 0.0);
        out.minimum = dqa::solve_positive(problem.hessian(), none);
    }
    return out;
}

}  // namespace stability
