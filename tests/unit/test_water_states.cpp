// SPDX-License-Identifier: MIT
// Forces of the water as a whole: their direction, states in which an unrounded law has no value or no slope, threads.
#include "water_fixtures.hpp"

namespace {

using namespace fixtures;

// Rigid motion through still water: drag takes energy; uniform motion gives a net force against it.
void test_drag_opposes_motion() {
    Sample s;
    s.settings.current = {};
    const Water w = s.water();
    Random random{6};
    for (int round = 0; round < 50; ++round) {
        Vector v(s.q.size());
        const Vec3 u = {random(), random(), random()};
        for (std::size_t i = 0; i < v.size(); ++i) v[i] = u[i % 3];
        WaterWorkspace ws;
        w.lag(ws, s.q.data(), v.data(), s.spine, w.settings().current, 1);
        const WaterTotals t = w.totals(ws, plus(s.q, kStep, v).data(), s.q.data(), kStep);
        CHECK(dot3(t.drag, u) < -0.9 * std::sqrt(dot3(t.drag, t.drag) * dot3(u, u)));
        CHECK(dot3(t.mean_drag, u) < 0);
        // Twice the speed: four times the force, once past the rounding of the speed.
        const Vector fast = plus(v, 1.0, v);
        w.lag(ws, s.q.data(), fast.data(), s.spine, w.settings().current, 1);
        const WaterTotals t2 = w.totals(ws, plus(s.q, kStep, fast).data(), s.q.data(), kStep);
        NEAR(dot3(t2.drag, u) / dot3(t.drag, u), 4.0, 4.0 * 1e-4 / dot3(u, u) + 1e-3);
    }
    // With the current there is none.
    s.settings.current = {0.3, -0.2, 0.5};
    Vector v(s.q.size());
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = s.settings.current[i % 3];
    NEAR(norm_of(s.gradient(plus(s.q, kStep, v), s.q, v, s.spine, s.occupancy)), 0.0, 1e-10);
}

// A plate turned at random, with the water exactly along its normal, across it, or not moving against it at all.
void test_head_on_flow_is_finite() {
    Sample s;
    s.set = full_set({6, 1, 5}, 0.1);
    s.rest = s.set.rest_positions();
    s.occupancy.assign(30, 1.0);
    Random random{8};
    for (int round = 0; round < 1500; ++round) {
        const auto r = random_rotation(random);
        const std::size_t axis = round % 3 ? 1 : 0;
        const Vec3 normal = {r[axis], r[3 + axis], r[6 + axis]};
        const double speed = round % 5 == 4 ? 0.0 : std::pow(10.0, between(random, -12, 2));
        s.q = mapped(s.rest, r, {100, -200, 50});
        s.spine = {r[0], r[3], r[6]};
        Vector v(s.q.size(), 0.0);
        const bool moving = round % 2 == 0;  // the plate moves, or the water
        s.settings.current = {};
        for (std::size_t a = 0; a < 3; ++a) {
            if (!moving) s.settings.current[a] = -speed * normal[a];
            for (std::size_t n = a; n < v.size(); n += 3) v[n] = moving ? speed * normal[a] : 0.0;
        }
        const Water w = s.water();
        WaterWorkspace ws;
        w.lag(ws, s.q.data(), v.data(), s.spine, w.settings().current, 1);
        const Vector q_new = plus(s.q, kStep, v), lambda = random_vector(s.q.size(), random);
        Vector out(s.q.size(), 0.0), q_bar(out), v_bar(out), g_bar(30, 0.0);
        Vec3 spine_bar{}, current_bar{};
        WaterParameterBar parameter_bar;
        CHECK(std::isfinite(w.gradient(ws, q_new.data(), s.q.data(), kStep, 1, out.data())));
        w.pullback(ws, q_new.data(), s.q.data(), s.q.data(), lambda.data(), kStep, 1, q_bar.data(), q_bar.data(),
                   v_bar.data(), spine_bar, current_bar, parameter_bar, g_bar.data());
        CHECK(all_finite(out) && all_finite(q_bar) && all_finite(v_bar) && all_finite(g_bar));
        CHECK(std::isfinite(dot3(spine_bar, {1, 1, 1})));
        if (speed > 0.1 && axis == 1) {  // drag of a plate: both sides, Cd about 2, and little at the rim
            const WaterTotals t = w.totals(ws, q_new.data(), s.q.data(), kStep);
            NEAR(-dot3(t.drag, normal) / (500 * speed * speed), 2 * 0.3 * 2.05 + 0.22 * 0.05, 0.05);
        }
    }
    // A face crushed to a point, and one to a line.
    s.q.assign(s.q.size(), 3.0);
    Vector v(s.q.size(), 1.0);
    CHECK(all_finite(s.gradient(s.q, s.q, v, s.spine, s.occupancy)));
}

void test_threads_give_the_same_bits() {
    const Sample s({14, 12, 11}, 9);
    const auto run = [&](int threads) {
        const Water w = s.water();
        WaterWorkspace ws;
        w.lag(ws, s.q.data(), s.v.data(), s.spine, w.settings().current, threads);
        Vector out(2 * s.q.size() + 1, 0.0);
        out.back() = w.gradient(ws, plus(s.q, 0.03, s.v).data(), s.q.data(), kStep, threads, out.data());
        w.product(ws, s.v.data(), kStep, threads, out.data() + s.q.size());
        return out;
    };
    const Vector one = run(1);
    CHECK(norm_of(one) > 0 && all_finite(one));
    for (const int threads : {2, 3, 4}) CHECK(run(threads) == one);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_drag_opposes_motion),
        TEST(test_head_on_flow_is_finite),
        TEST(test_threads_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
