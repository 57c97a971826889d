// SPDX-License-Identifier: MIT
// Rows of one step of the integrators: the new state and the hydrodynamic totals by everything a step reads.
#include "motion_fixtures.hpp"
#include "table.hpp"

namespace table {
namespace {

using namespace dqa;

enum Input : std::size_t { position, velocity, signals, current, before, velocity_before };

constexpr double kVelocity = 0.05;  // weight of the new velocities beside the new positions (s)

State state_of(const Inputs& x) {
    State s{x[position], x[velocity], {}, {}};
    if (x.size() > before) s.q_before = x[before], s.v_before = x[velocity_before];
    return s;
}

StepInput input_of(const Inputs& x) {
    return {x[signals].data(), {x[current][0], x[current][1], x[current][2]}};
}

Inputs bars_of(const StepBar& bar, const Inputs& x) {
    Inputs out{bar.state.q, bar.state.v, bar.signals, Vector(bar.current.begin(), bar.current.end())};
    if (x.size() > before) out.push_back(bar.state.q_before), out.push_back(bar.state.v_before);
    return out;
}

void rows_of(Table& t, const std::string& name, const SceneSettings& scene,
             const std::shared_ptr<const ShapeSpace>& space, bool totals) {
    const auto design = fixtures::make_design(scene, {0.6, 0.4}, space);
    derivative::Random random(9);
    const Vector& rest = design->rest();
    const bool plane = space->box().dims == 2;
    const auto flat = [&](Vector v) {
        for (std::size_t i = 2; plane && i < v.size(); i += 3) v[i] = 0.0;
        return v;
    };
    const Vector q = derivative::along(rest, 1.0, flat(random.vector(rest.size(), -0.002, 0.002)));
    std::vector<Field> fields{{"positions", q, 8e-4},
                              {"velocities", flat(fixtures::swirl(q, 0.4)), 0.02},
                              {"signals", {0.6}, 0.3},
                              {"current", {-0.4, 0.05, plane ? 0.0 : 0.1}, 0.02}};
    if (scene.integrator == Integrator::bdf2) {
        const Vector v = flat(fixtures::swirl(q, 0.35));
        fields.push_back({"positions one step before", derivative::along(q, -scene.time_step, v), 8e-4});
        fields.push_back({"velocities one step before", v, 0.02});
    }
    Stepper stepper(design);
    t.prove(
        "step, " + name, fields,
        [&](const Inputs& x) {
            State next;
            stepper.step(state_of(x), input_of(x), 0, next);
            Vector out = next.q;
            for (const double v : next.v) out.push_back(kVelocity * v);
            return out;
        },
        [&](const Inputs& x, const Vector& bar) {
            State next, next_bar;
            stepper.step(state_of(x), input_of(x), 0, next);
            next_bar.q.assign(bar.begin(), bar.begin() + static_cast<long>(rest.size()));
            for (std::size_t i = rest.size(); i < bar.size(); ++i) next_bar.v.push_back(kVelocity * bar[i]);
            StepBar out;
            DesignBar design_bar = design->zero_bar();
            stepper.adjoint(state_of(x), input_of(x), next, 0, next_bar, out, design_bar);
            return bars_of(out, x);
        });
    if (!totals) return;
    // Signals do not matter where the new state is held.
    State held;
    Inputs at;
    for (const Field& f : fields) at.push_back(f.value);
    stepper.step(state_of(at), input_of(at), 0, held);
    const Vector signal = fields[signals].value;
    fields[signals] = {"new positions", held.q, 8e-4, true};
    const auto with_signal = [&](Inputs x) {
        x[signals] = signal;
        return x;
    };
    t.prove(
        "totals of a step, " + name, fields,
        [&](const Inputs& x) {
            // Totals belong to the last step taken: one with the same lagged coefficients, whatever its end.
            State scratch, next = held;
            const Inputs from = with_signal(x);
            stepper.step(state_of(from), input_of(from), 0, scratch);
            next.q = x[signals];
            const WaterTotals w = stepper.totals(next);
            Vector out;
            for (const Vec3& v : {w.drag, w.thrust, w.mean_drag, w.mean_thrust})
                out.insert(out.end(), v.begin(), v.end());
            return out;
        },
        [&](const Inputs& x, const Vector& bar) {
            WaterTotals w;
            std::size_t k = 0;
            for (Vec3* v : {&w.drag, &w.thrust, &w.mean_drag, &w.mean_thrust})
                for (double& c : *v) c = bar[k++];
            State next = held, next_bar;
            next.q = x[signals];
            next_bar.q.assign(rest.size(), 0.0);
            StepBar out;
            DesignBar design_bar = design->zero_bar();
            const Inputs from = with_signal(x);
            stepper.totals_pullback(state_of(from), input_of(from), next, w, next_bar, out, design_bar);
            Inputs bars = bars_of(out, x);
            bars[signals] = next_bar.q;
            return bars;
        });
}

}  // namespace

void step_rows(Table& t) {
    const auto space = fixtures::ellipsoid_space({12, 6, 6}, 0.08);
    SceneSettings scene = fixtures::tight_scene();
    scene.tolerance = 1e-13;
    rows_of(t, "implicit Euler", scene, space, true);
    rows_of(t, "implicit Euler, 2-D", scene, fixtures::plane_space(16, 8, 0.06), false);
    scene.integrator = Integrator::bdf2;
    rows_of(t, "BDF2", scene, space, true);
    rows_of(t, "BDF2, 2-D", scene, fixtures::plane_space(16, 8, 0.06), false);
    scene.planar = true;
    for (int k = 0; k < 49; ++k) scene.fixed_nodes.push_back(space->box().node(6, k / 7, k % 7));
    rows_of(t, "BDF2, planar, nodes held", scene, space, false);
    scene.integrator = Integrator::implicit_euler;
    rows_of(t, "implicit Euler, planar, nodes held", scene, space, false);
}

}  // namespace table
