// SPDX-License-Identifier: MIT
// The end-to-end promise: the gradient of a rollout against finite differences, for every quantity it can be taken by,
// inside the simplex and at a vertex, from rest and in motion, in water that comes head-on.
#include "motion_fixtures.hpp"
#include "tape/gradient_check.hpp"

namespace {

using namespace fixtures;

constexpr const char* kNames[] = {"weights",          "control", "actuation", "initial position",
                                  "initial velocity", "water",   "current",   "current table",
                                  "Young's modulus",  "muscles", "material",  "Lame"};

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
            controller.evaluate(k, nullptr, &a);
            s.step({&a, s.design().scene().hydrodynamics.current});
        }
    }
    const Vector q(s.q()), v(s.v());
    const long clock = s.steps();
    if (moving)  // the clock stands at 0.1 s: one knot lies within the rollout
        s.set_current(std::make_shared<dqa::WaterCurrent>(
            std::vector<double>{0.0, 0.15, 0.3}, std::vector<Vec3>{{-0.5, 0, 0}, {-0.6, 0.1, 0}, {-0.3, 0.2, 0.1}}));
    for (int quantity = 0; quantity < 12; ++quantity) {
        GradientCheckSettings settings;
        settings.quantity = static_cast<WithRespectTo>(quantity);
        settings.n_steps = moving ? 3 : 4;
        settings.seed = 2;
        if (quantity == 11) settings.step = 0.03;  // the loss is nearly linear in the moduli of all cells
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

void test_inside_from_rest() {
    check_all({0.6, 0.4}, false);
}
void test_inside_in_motion() {
    check_all({0.3, 0.7}, true);
}
void test_vertex_from_rest() {
    check_all({0.0, 1.0}, false);
}
void test_vertex_in_motion() {
    check_all({0.0, 1.0}, true);
}

// Every material, integrator and constraint, by everything that the body depends on.
void test_materials() {
    static const auto space = ellipsoid_space({14, 6, 6}, 0.07);
    struct Case {
        Material material;
        Integrator integrator;
        bool planar, fixed;
    };
    for (const Case& c : {Case{Material::corotated_volume, Integrator::implicit_euler, false, false},
                          Case{Material::neo_hookean, Integrator::bdf2, true, false},
                          Case{Material::corotated_volume, Integrator::bdf2, false, true}}) {
        SceneSettings scene;
        scene.material = c.material, scene.integrator = c.integrator, scene.planar = c.planar;
        if (c.fixed)
            for (int k = 0; k < 49; ++k) scene.fixed_nodes.push_back(space->box().node(7, k / 7, k % 7));
        scene.hydrodynamics.current = {-0.4, 0.05, 0.0};
        auto young = std::make_shared<Vector>(), muscle = std::make_shared<Vector>();
        for (int k = 0; k < space->box().n_cells(); ++k)
            young->push_back(4e6 + 2e6 * std::sin(0.3 * k)), muscle->push_back(2e6 + 1e6 * std::cos(0.2 * k));
        if (c.planar) scene.young_of_cell = young, scene.muscle_of_cell = muscle;
        const Simulation s(make_design(scene, {0.6, 0.4}, space));
        for (int quantity = 0; quantity < 12; ++quantity) {
            if (quantity == 1 || (c.planar && quantity == 11)) continue;  // no controller; one modulus for all needed
            GradientCheckSettings settings;
            settings.quantity = static_cast<WithRespectTo>(quantity);
            settings.n_steps = 3;
            const GradientCheckReport r = check_gradient(s, nullptr, {{}}, settings);
            print_message("material %d, %-17s: adjoint % .6e, error %.1e, slope %.3f\n", static_cast<int>(c.material),
                          kNames[quantity], r.adjoint, r.relative_error, r.taylor_slope);
            CHECK(r.gradient_norm > 0 && r.relative_error <= 1e-6);
            NEAR(r.taylor_slope, 2.0, 0.1);
        }
    }
}

// The variants of the water, away from tangential flow: the force of the start of the step, and windward faces alone.
void test_water_variants() {
    static const auto space = ellipsoid_space({14, 6, 6}, 0.07);
    for (const bool windward : {false, true}) {
        SceneSettings scene;
        scene.hydrodynamics.current = {-0.3, 0.23, -0.26};
        scene.hydrodynamics.explicit_forces = true;
        scene.hydrodynamics.windward_only = windward;
        const Simulation s(make_design(scene, {0.6, 0.4}, space));
        for (const WithRespectTo quantity : {WithRespectTo::weights, WithRespectTo::actuation, WithRespectTo::water}) {
            GradientCheckSettings settings;
            settings.quantity = quantity;
            settings.n_steps = 2;
            settings.step = 1e-3;
            // A direction that is not nearly orthogonal to any of the gradients: along such a one the difference drowns
            // in the rounding of the loss, as these are small.
            settings.seed = 3;
            const GradientCheckReport r = check_gradient(s, nullptr, {{}}, settings);
            print_message("%s, %s: error %.1e, slope %.3f\n", windward ? "windward" : "both faces",
                          kNames[static_cast<int>(quantity)], r.relative_error, r.taylor_slope);
            CHECK(std::fabs(r.adjoint) > 0.1 * r.gradient_norm && r.relative_error <= 1e-6);
        }
    }
}

// A function of time: read once a step, never by the adjoint; its pullback hears of each step, last first.
void test_current_function() {
    static const auto space = ellipsoid_space({14, 6, 6}, 0.07);
    Simulation s(make_design({}, {0.6, 0.4}, space));
    int calls = 0;
    std::vector<double> heard, bars;
    s.set_current(std::make_shared<dqa::WaterCurrent>(
        [&](double t) {
            ++calls;
            return Vec3{-0.4 * std::cos(9 * t), 0.0, 0.1};
        },
        [&](double t, const Vec3& bar) { heard.push_back(t), bars.insert(bars.end(), bar.begin(), bar.end()); }));
    const auto tape = std::make_shared<Tape>(0);
    for (int k = 0; k < 4; ++k) advance(s, {0.5}, tape.get());
    CHECK(calls == 4);
    Adjoint adjoint(tape);
    adjoint.seed_objective({{}});
    adjoint.backward(2, nullptr);
    adjoint.backward(0, nullptr);
    CHECK(calls == 4 && heard.size() == 4);
    for (std::size_t k = 0; k < 4; ++k) {
        NEAR(heard[k], static_cast<double>(3 - k) / 30.0, 1e-15);
        for (std::size_t x = 0; x < 3; ++x) CHECK(bars[3 * k + x] == adjoint.current_bar()[3 - k][x]);
    }
    EXPECT_ERROR(ERROR_STATE, "CURRENT_TABLE", adjoint.current_table_bar());
    GradientCheckSettings settings;
    settings.n_steps = 2;
    for (const WithRespectTo quantity : {WithRespectTo::actuation, WithRespectTo::current}) {
        settings.quantity = quantity;
        CHECK(check_gradient(s, nullptr, {{}}, settings).relative_error <= 1e-6);
    }
    CHECK(calls == 8 && heard.size() == 4);  // once a step of each rollout, whatever is perturbed
    settings.quantity = WithRespectTo::current_table;
    EXPECT_ERROR(ERROR_ARGUMENT, "CURRENT_TABLE", check_gradient(s, nullptr, {{}}, settings));
}

// A design from a loosely converged density: the check converges its own, whose active set may have other cells.
void test_loose_density() {
    const auto space = ellipsoid_space({14, 6, 6}, 0.07);
    const Vector weights = {0.6, 0.4};
    const Vector loose = space->evaluate(weights, 1e-2, 1, nullptr).p_hat,
                 tight = space->evaluate(weights, 1e-13, 1, nullptr).p_hat;
    int tried = 0;
    for (const double sign : {1.0, -1.0}) {
        // A threshold between the two values of one cell: it enters, or leaves.
        const auto moves = [&](std::size_t c) {
            return sign * (tight[c] - loose[c]) > 1e-6 && std::min(tight[c], loose[c]) > 0.005 && tight[c] < 0.1;
        };
        std::size_t cell = 0;
        while (cell < tight.size() && !moves(cell)) ++cell;
        if (cell == tight.size()) continue;
        ++tried;
        SceneSettings scene;
        scene.shape_tolerance = 1e-2;
        scene.threshold = 0.5 * (tight[cell] + loose[cell]);
        const auto design = make_design(scene, weights, space);
        scene.shape_tolerance = 1e-13;
        CHECK(design->set().cells != make_design(scene, weights, space)->set().cells);
        const Simulation s(design);
        for (const WithRespectTo quantity : {WithRespectTo::initial_position, WithRespectTo::initial_velocity}) {
            GradientCheckSettings settings;
            settings.quantity = quantity;
            settings.n_steps = 2;
            CHECK(check_gradient(s, nullptr, {{}}, settings).relative_error <= 1e-6);
        }
    }
    CHECK(tried >= 1);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_inside_from_rest), TEST(test_inside_in_motion), TEST(test_vertex_from_rest),
        TEST(test_vertex_in_motion), TEST(test_loose_density),    TEST(test_materials),
        TEST(test_water_variants),   TEST(test_current_function),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
