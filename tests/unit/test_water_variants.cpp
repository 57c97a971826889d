// SPDX-License-Identifier: MIT
// The variants of the water that exist for comparison with the paper's public code: forces of the start of the step,
// and windward faces alone. Values against the default ones, derivatives by differences.
#include "water_fixtures.hpp"

namespace {

using namespace fixtures;

// A body whose faces all stand well away from tangential flow, where `windward` jumps.
Sample oblique(bool explicit_forces, bool windward) {
    Sample s;
    Random random{21};
    s.q = plus(s.rest, 0.004, random_vector(s.rest.size(), random));
    s.spine = {0.6, 0.0, -0.8};
    for (std::size_t i = 0; i < s.v.size(); ++i) {
        const Vec3 u{0.7, 0.5, -0.6};
        s.v[i] = u[i % 3] + 0.02 * random();
    }
    s.settings.explicit_forces = explicit_forces;
    s.settings.windward_only = windward;
    return s;
}

// At the velocity of the start of the step both schemes have the same force; the explicit one has it at every other.
void test_explicit_is_constant() {
    Sample lagged = oblique(false, false), fixed = oblique(true, false);
    Random random{22};
    const Vector steady = plus(lagged.q, kStep, lagged.v),
                 other = plus(steady, 0.1, random_vector(steady.size(), random));
    const Vector expected = lagged.gradient(steady, lagged.q, lagged.v, lagged.spine, lagged.occupancy);
    for (const Vector& q_new : {steady, other}) {
        const Vector g = fixed.gradient(q_new, fixed.q, fixed.v, fixed.spine, fixed.occupancy);
        NEAR(relative_difference(g, expected), 0.0, 1e-12);
    }
    CHECK(relative_difference(lagged.gradient(other, lagged.q, lagged.v, lagged.spine, lagged.occupancy), expected) >
          0.01);
    const Water w = fixed.water();
    WaterWorkspace ws;
    w.lag(ws, fixed.q.data(), fixed.v.data(), fixed.spine, fixed.settings.current, 1);
    Vector product(steady.size(), 0.0), gradient(product);
    w.product(ws, fixed.v.data(), kStep, 1, product.data());
    CHECK(norm_of(product) == 0.0);
    // The potential is linear, and its slope is the force.
    w.gradient(ws, steady.data(), fixed.q.data(), kStep, 1, gradient.data());
    Vector scratch(steady.size(), 0.0);
    CHECK_LINEAR_DERIVATIVE(
        [&](double e) {
            return w.gradient(ws, plus(steady, e, fixed.v).data(), fixed.q.data(), kStep, 1, scratch.data());
        },
        dot_of(gradient, fixed.v), 1.0);
    const WaterTotals a = w.totals(ws, steady.data(), fixed.q.data(), kStep),
                      b = w.totals(ws, other.data(), fixed.q.data(), kStep);
    CHECK(a.drag == b.drag && a.thrust == b.thrust && dot3(a.drag, a.drag) > 0);
}

// In still water the power that the faces take is that of the potential's Hessian along the way moved.
void test_dissipation() {
    Sample s({6, 5, 4}, 9);
    s.settings.current = {};
    const Water w = s.water();
    WaterWorkspace ws;
    w.lag(ws, s.q.data(), s.v.data(), s.spine, s.settings.current, 1);
    Random random{41};
    const Vector p = random_vector(s.q.size(), random, 0.01);
    Vector product(s.q.size(), 0.0);
    w.product(ws, p.data(), kStep, 1, product.data());
    const double expected = dot_of(p, product) / kStep;
    CHECK(expected > 0);
    NEAR(w.dissipation(ws, plus(s.q, 1.0, p).data(), s.q.data(), kStep), expected, 1e-12 * expected);
}

// A full cell in oblique flow: three faces move into the water, three away from it, and without deformation the
// opposite ones carry the same drag: half of it is left.
void test_windward_counts_half() {
    Sample s;
    s.set = full_set({1, 1, 1}, 0.1);
    s.occupancy = {1.0};
    s.rest = s.q = s.set.rest_positions();
    s.settings.current = {};
    s.v.assign(24, 0.0);
    for (std::size_t i = 0; i < 24; ++i) s.v[i] = Vec3{0.7, 0.5, -0.6}[i % 3];
    const auto totals = [&] {
        const Water w = s.water();
        WaterWorkspace ws;
        w.lag(ws, s.q.data(), s.v.data(), s.spine, s.settings.current, 1);
        return w.totals(ws, plus(s.q, kStep, s.v).data(), s.q.data(), kStep);
    };
    const WaterTotals both = totals();
    s.settings.windward_only = true;
    const WaterTotals windward = totals();
    for (std::size_t a = 0; a < 3; ++a) {
        NEAR(windward.drag[a], 0.5 * both.drag[a], 1e-12 * std::fabs(both.drag[a]));
        CHECK(windward.thrust[a] != both.thrust[a]);
    }
    // Without flow no face counts.
    s.v.assign(24, 0.0);
    const WaterTotals still = totals();
    CHECK(dot3(still.drag, still.drag) == 0.0 && dot3(still.thrust, still.thrust) == 0.0);
}

void check_variant(bool explicit_forces, bool windward, std::uint64_t seed) {
    const Sample s = oblique(explicit_forces, windward);
    Random random{seed};
    const Water w = s.water();
    WaterWorkspace ws;
    const Vector q_new = plus(plus(s.q, kStep, s.v), kStep, random_vector(s.q.size(), random, 0.4));
    const Vector lambda = random_vector(s.q.size(), random);
    w.lag(ws, s.q.data(), s.v.data(), s.spine, s.settings.current, 1);
    Vector q_bar(s.q.size(), 0.0), v_bar(q_bar), g_bar(s.occupancy.size(), 0.0);
    Vec3 spine_bar{}, current_bar{};
    WaterParameterBar parameter_bar;
    w.pullback(ws, q_new.data(), s.q.data(), s.q.data(), lambda.data(), kStep, 1, q_bar.data(), q_bar.data(),
               v_bar.data(), spine_bar, current_bar, parameter_bar, g_bar.data());
    const auto value = [&](const Vector& q_old, const Vector& vel, const Vec3& spine, const Vector& g) {
        return dot_of(lambda, s.gradient(q_new, q_old, vel, spine, g));
    };
    const Vector dq = random_vector(s.q.size(), random, 0.01), dv = random_vector(s.q.size(), random, 0.2),
                 dg = random_vector(s.occupancy.size(), random, 0.2);
    const Vec3 ds = {0.3, -0.5, 0.2};
    CHECK_DERIVATIVE([&](double e) { return value(plus(s.q, e, dq), s.v, s.spine, s.occupancy); }, dot_of(q_bar, dq),
                     0.1);
    CHECK_DERIVATIVE([&](double e) { return value(s.q, plus(s.v, e, dv), s.spine, s.occupancy); }, dot_of(v_bar, dv),
                     1e-2);
    // Fuller and emptier sides of a face do not change places for this step.
    CHECK_DERIVATIVE([&](double e) { return value(s.q, s.v, s.spine, plus(s.occupancy, e, dg)); }, dot_of(g_bar, dg),
                     1e-4);
    CHECK_DERIVATIVE(
        [&](double e) {
            return value(s.q, s.v, {s.spine[0] + e * ds[0], s.spine[1] + e * ds[1], s.spine[2] + e * ds[2]},
                         s.occupancy);
        },
        dot3(spine_bar, ds), 1e-2);
    const Vec3 dc = {0.2, 0.3, -0.4};
    CHECK_DERIVATIVE(
        [&](double e) {
            Sample moved = s;
            for (std::size_t k = 0; k < 3; ++k) moved.settings.current[k] += e * dc[k];
            return dot_of(lambda, moved.gradient(q_new, s.q, s.v, s.spine, s.occupancy));
        },
        dot3(current_bar, dc), 1e-2);
    const ParameterDirection dp;
    CHECK_DERIVATIVE(
        [&](double e) {
            Sample moved = s;
            moved.settings = dp.moved(s.settings, e);
            return dot_of(lambda, moved.gradient(q_new, s.q, s.v, s.spine, s.occupancy));
        },
        dp.slope(parameter_bar), 0.1);
}

void test_pullbacks() {
    check_variant(true, false, 31);
    check_variant(false, true, 32);
    check_variant(true, true, 33);
    report_worst("water variants");
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_explicit_is_constant),
        TEST(test_dissipation),
        TEST(test_windward_counts_half),
        TEST(test_pullbacks),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
