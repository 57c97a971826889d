// SPDX-License-Identifier: MIT
// Rows of the objectives: each kind by what it looks at.
#include "motion_fixtures.hpp"
#include "objective_terms.hpp"
#include "table.hpp"

namespace table {

using namespace dqa;

ObjectiveTerm term_of(ObjectiveKind kind) {
    ObjectiveTerm t;
    t.kind = kind;
    t.target = {0.15, -0.04, 0.06};
    t.epsilon = kind == ObjectiveKind::efficiency ? 1e-2 : 1e-3;
    if (kind == ObjectiveKind::position_keeping) t.gamma = 0.05;
    if (kind == ObjectiveKind::path) t.path = {{0.05, {0.0, 0.0, 0.0}}, {0.2, {0.1, 0.05, -0.02}}, {0.5, {0, 0.3, 0}}};
    return t;
}

namespace {

void travel_rows(Table& t, const Design& design) {
    const Vector& rest = design.rest();
    const Vector moved = derivative::along(rest, 0.1, fixtures::swirl(rest, 1.0));
    t.prove(
        "objective, travel", {{"first positions", rest, 0.01, true}, {"last positions", moved, 0.01, true}},
        [&](const Inputs& x) { return Vector{travel_loss(design, x[0].data(), x[1].data())}; },
        [&](const Inputs& x, const Vector& bar) {
            Inputs out{Vector(rest.size(), 0.0), Vector(rest.size(), 0.0)};
            Vector spine_bar(design.spine().size(), 0.0);
            travel_pullback(design, x[0].data(), x[1].data(), bar[0], out[0].data(), out[1].data(), spine_bar.data());
            return out;
        });
}

// The kinds that are sums over the states, at one of them.
void state_rows(Table& t, const std::string& stage, ObjectiveKind kind, const Simulation& simulation) {
    const Design& design = simulation.design();
    const ObjectiveTerm term = term_of(kind);
    constexpr double kTime = 0.15;
    const Vector q = derivative::along(design.rest(), 0.05, fixtures::swirl(design.rest(), 1.0)),
                 v = fixtures::swirl(q, 0.4);
    const auto observed = [&](const Inputs& x, State& state) {
        const bool places = kind != ObjectiveKind::efficiency;
        state = {places ? x[0] : q, places ? v : x[0], {}, {}};
        Simulation s(simulation);
        s.restore(state, 0);
        Observed o = observed_of(s);
        if (!places)
            for (std::size_t k = 0; k < 3; ++k) o.mean_drag[k] = x[1][k], o.mean_thrust[k] = x[1][3 + k];
        return o;
    };
    std::vector<Field> fields{{"positions", q, 5e-3}};
    if (kind == ObjectiveKind::efficiency)
        fields = {{"velocities", v, 0.02}, {"mean drag and thrust", {-1.1, 0.3, 0.2, 0.8, 0.4, -0.5}, 0.02}};
    t.prove(
        stage, fields,
        [&](const Inputs& x) {
            State state;
            const Observed o = observed(x, state);
            return Vector{state_value(term, design, o, kTime)};
        },
        [&](const Inputs& x, const Vector& bar) {
            State state;
            const Observed o = observed(x, state);
            State state_bar{Vector(q.size(), 0.0), Vector(q.size(), 0.0), {}, {}};
            WaterTotals totals_bar;
            DesignBar design_bar = design.zero_bar();
            state_pullback(term, design, o, kTime, bar[0], state, state_bar, totals_bar, design_bar);
            Vector forces(totals_bar.mean_drag.begin(), totals_bar.mean_drag.end());
            forces.insert(forces.end(), totals_bar.mean_thrust.begin(), totals_bar.mean_thrust.end());
            return Inputs{kind == ObjectiveKind::efficiency ? state_bar.v : state_bar.q, forces};
        });
}

void effort_rows(Table& t) {
    t.prove(
        "objective, effort", {{"actuation", {0.3, -0.7, 0.9}, 0.1}},
        [](const Inputs& x) { return Vector{effort_value(x[0], 0.05)}; },
        [](const Inputs& x, const Vector& bar) {
            Vector out(3, 0.0);
            effort_pullback(x[0], 0.05, bar[0], out.data());
            return Inputs{out};
        });
}

}  // namespace

void objective_rows(Table& t) {
    const Simulation s(
        fixtures::make_design(fixtures::tight_scene(), {0.6, 0.4}, fixtures::ellipsoid_space({12, 6, 6}, 0.08)));
    travel_rows(t, s.design());
    state_rows(t, "objective, position keeping", ObjectiveKind::position_keeping, s);
    state_rows(t, "objective, efficiency", ObjectiveKind::efficiency, s);
    effort_rows(t);
    state_rows(t, "objective, path", ObjectiveKind::path, s);
}

}  // namespace table
