// SPDX-License-Identifier: MIT
// The end-to-end promise: the gradient of a rollout against finite differences, for every quantity it can be taken by,
// inside the simplex and at a vertex, from rest and in motion, in water that comes head-on.
#include "motion_fixtures.hpp"
#include "tape/gradient_check.hpp"

namespace {

using namespace fixtures;

constexpr const char* kNames[] = {"weights", "control", "actuation", "initial position", "initial velocity"};

void check_all(const Vector& weights, bool moving) {
    static const auto space = ellipsoid_space({14, 6, 6}, 0.07);
    SceneSettings scene;
    scene.hydrodynamics.current = {-0.6, 0.0, 0.0};
    Simulation s(make_design(scene, weights, space));
    Sinusoid controller(1, scene.time_step);
    controller.set_parameters({0.8, 11.0, 0.3});
    if (moving) {
        const Vector v = swirl(s.q(), 0.3);
        s.set_state(nullptr, v.data());
        for (int k = 0; k < 3; ++k) {
            double a = 0.0;
            controller.evaluate(k, &a);
            s.step(&a);
        }
    }
    const Vector q(s.q()), v(s.v());
    const long clock = s.steps();
    for (int quantity = 0; quantity < 5; ++quantity) {
        GradientCheckSettings settings;
        settings.quantity = static_cast<WithRespectTo>(quantity);
        settings.n_steps = moving ? 3 : 4;
        settings.seed = 7;
        const GradientCheckReport r = check_gradient(s, quantity < 2 ? &controller : nullptr, {{}}, settings);
        print_message("%-17s %-6s %-6s: adjoint % .6e, error %.1e, slope %.3f\n", kNames[quantity],
                      weights[0] == 0.0 ? "vertex" : "inside", moving ? "moving" : "rest", r.adjoint, r.relative_error,
                      r.taylor_slope);
        CHECK(r.gradient_norm > 0 && r.adjoint != 0.0);
        CHECK(r.one_sided == (quantity == 0 && weights[0] == 0.0));
        CHECK(r.relative_error <= 1e-6);
        NEAR(r.taylor_slope, 2.0, 0.1);
        CHECK(s.q() == q && s.v() == v && s.steps() == clock);  // the caller's simulation is not touched
    }
}

void test_inside_from_rest() { check_all({0.6, 0.4}, false); }
void test_inside_in_motion() { check_all({0.3, 0.7}, true); }
void test_vertex_from_rest() { check_all({0.0, 1.0}, false); }
void test_vertex_in_motion() { check_all({0.0, 1.0}, true); }

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_inside_from_rest),
        TEST(test_inside_in_motion),
        TEST(test_vertex_from_rest),
        TEST(test_vertex_in_motion),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
