// SPDX-License-Identifier: MIT
// Rows of the water: its force on a ragged body and the totals of drag and thrust, by states and parameters.
#include "table.hpp"
#include "water_fixtures.hpp"

namespace table {
namespace {

using namespace dqa;

enum Input : std::size_t { q_new, q_base, lag_q, lag_v, spine, current, density, drag, thrust, occupancy, n_inputs };

Vec3 vec3(const Vector& v) {
    return {v[0], v[1], v[2]};
}
template <std::size_t n>
Vector vector(const std::array<double, n>& a) {
    return Vector(a.begin(), a.end());
}

// The water of a body with these inputs, its coefficients evaluated.
struct Evaluated {
    Water water;
    WaterWorkspace ws;

    static WaterSettings settings_of(WaterSettings s, const Inputs& x) {
        s.density = x[density][0];
        std::copy_n(x[drag].begin(), 4, s.drag.begin());
        std::copy_n(x[thrust].begin(), 4, s.thrust.begin());
        return s;
    }
    Evaluated(const fixtures::Sample& body, const Inputs& x)
        : water(body.set, x[occupancy], settings_of(body.settings, x)) {
        water.lag(ws, x[lag_q].data(), x[lag_v].data(), vec3(x[spine]), vec3(x[current]), 1);
    }
};

struct Bars {
    Inputs of{n_inputs};
    Vec3 spine_bar{}, current_bar{};
    WaterParameterBar parameter_bar;

    explicit Bars(const Inputs& x) {
        for (std::size_t k = 0; k < n_inputs; ++k) of[k].assign(x[k].size(), 0.0);
    }
    Inputs result() {
        of[spine] = vector(spine_bar), of[current] = vector(current_bar), of[density] = {parameter_bar.density};
        std::array<double, 4> drag_bar{}, thrust_bar{};
        WaterLaws::ordinates_pullback(parameter_bar.laws, drag_bar, thrust_bar);
        of[drag] = vector(drag_bar), of[thrust] = vector(thrust_bar);
        return of;
    }
};

std::vector<Field> fields_of(const fixtures::Sample& s, bool force) {
    derivative::Random random(7);
    const Vector moved = derivative::along(derivative::along(s.q, fixtures::kStep, s.v), 0.4 * fixtures::kStep,
                                           random.vector(s.q.size()));
    const bool constant = s.settings.explicit_forces;  // the force, during the step
    const double rough = s.settings.windward_only ? 1e-3 : 1.0;
    std::vector<Field> out(n_inputs);
    out[q_new] = {"new positions", moved, 0.01, true};
    out[q_base] = {"positions that the new velocity counts from", s.q, 0.01, true};
    out[lag_q] = {"lagged positions", s.q, 4e-3 * rough};
    out[lag_v] = {"lagged velocities", s.v, 4e-3 * rough};
    out[spine] = {"spine direction", vector(s.spine), 0.02};
    out[current] = {"current", vector(s.settings.current), 4e-3 * rough};
    out[density] = {"density", {s.settings.density}, 100.0, true};
    out[drag] = {"drag coefficients", vector(s.settings.drag), 0.02, true};
    out[thrust] = {"thrust coefficients", vector(s.settings.thrust), 0.02, true};
    out[occupancy] = {"occupancy", s.occupancy, 1e-3};
    if (force && !constant) {
        out[q_new].note = "J d is the Hessian's product: its symmetry";
        out[q_new].product = [&s](const Inputs& x, const Vector& d) {
            Evaluated at(s, x);
            Vector p(d.size(), 0.0);
            at.water.product(at.ws, d.data(), fixtures::kStep, 1, p.data());
            return p;
        };
    }
    if (s.settings.windward_only)
        for (const Input k : {lag_q, lag_v, current}) out[k].note = "within a side of the jump at Φ = 0";
    if (constant) out.erase(out.begin(), out.begin() + 2);  // does not depend on the new velocity
    return out;
}

void rows_of(Table& t, const std::string& name, const fixtures::Sample& s) {
    // Explicit forces lack the first two inputs: those stay as they are.
    const Inputs first{fields_of(fixtures::Sample(), true)[q_new].value, s.q};
    const auto all = [&](const Inputs& in) {
        Inputs x = in.size() == n_inputs ? Inputs{} : first;
        x.insert(x.end(), in.begin(), in.end());
        return x;
    };
    const auto asked = [&](Inputs bars) {
        if (s.settings.explicit_forces) bars.erase(bars.begin(), bars.begin() + 2);
        return bars;
    };
    t.prove(
        name + ": force", fields_of(s, true),
        [&](const Inputs& in) {
            const Inputs x = all(in);
            Evaluated at(s, x);
            Vector out(s.q.size(), 0.0);
            at.water.gradient(at.ws, x[q_new].data(), x[q_base].data(), fixtures::kStep, 1, out.data());
            return out;
        },
        [&](const Inputs& in, const Vector& bar) {
            const Inputs x = all(in);
            Evaluated at(s, x);
            Bars b(x);
            at.water.product(at.ws, bar.data(), fixtures::kStep, 1, b.of[q_new].data());
            at.water.pullback(at.ws, x[q_new].data(), x[q_base].data(), x[lag_q].data(), bar.data(), fixtures::kStep, 1,
                              b.of[q_base].data(), b.of[lag_q].data(), b.of[lag_v].data(), b.spine_bar, b.current_bar,
                              b.parameter_bar, b.of[occupancy].data());
            return asked(b.result());
        });
    t.prove(
        name + ": drag and thrust totals", fields_of(s, false),
        [&](const Inputs& in) {
            const Inputs x = all(in);
            Evaluated at(s, x);
            const WaterTotals w = at.water.totals(at.ws, x[q_new].data(), x[q_base].data(), fixtures::kStep);
            Vector out;
            for (const Vec3& v : {w.drag, w.thrust, w.mean_drag, w.mean_thrust})
                out.insert(out.end(), v.begin(), v.end());
            return out;
        },
        [&](const Inputs& in, const Vector& bar) {
            const Inputs x = all(in);
            Evaluated at(s, x);
            WaterTotals w;
            std::size_t k = 0;
            for (Vec3* v : {&w.drag, &w.thrust, &w.mean_drag, &w.mean_thrust})
                for (double& c : *v) c = bar[k++];
            Bars b(x);
            at.water.totals_pullback(at.ws, x[q_new].data(), x[q_base].data(), x[lag_q].data(), w, fixtures::kStep, 1,
                                     b.of[q_new].data(), b.of[q_base].data(), b.of[lag_q].data(), b.of[lag_v].data(),
                                     b.spine_bar, b.current_bar, b.parameter_bar, b.of[occupancy].data());
            return asked(b.result());
        });
}

}  // namespace

void water_rows(Table& t) {
    fixtures::Sample s({4, 3, 3});
    rows_of(t, "water", s);
    s.settings.explicit_forces = true;
    rows_of(t, "water, explicit", s);
    s.settings.windward_only = true;
    rows_of(t, "water, explicit, windward faces", s);
}

}  // namespace table
