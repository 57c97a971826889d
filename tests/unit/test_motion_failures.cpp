// SPDX-License-Identifier: MIT
// Hard scenes: a converged answer or a status that says why, never a number that is not one, and an unchanged state
// after a failure.
#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;

const std::shared_ptr<const ShapeSpace>& space() {
    static const auto s = ellipsoid_space();
    return s;
}

std::shared_ptr<const Design> design_of(const SceneSettings& scene) {
    return make_design(scene, {0.6, 0.4}, space());
}

double top_speed(const Vector& v) {
    double top = 0.0;
    for (std::size_t n = 0; n < v.size(); n += 3)
        top = std::max(top, std::sqrt(v[n] * v[n] + v[n + 1] * v[n + 1] + v[n + 2] * v[n + 2]));
    return top;
}

// Force residual of the step equation, from the parts: an accepted step must satisfy it.
double relative_residual(const Design& design, const Vector& q, const Vector& v, const Vector& signals,
                         const Vector& q_new) {
    const double h = design.scene().time_step;
    BodyWorkspace body;
    WaterWorkspace water;
    Vector elastic(q.size()), muscle(q.size()), flow(q.size(), 0.0), inertia(q.size());
    design.body().gradient(body, q_new.data(), signals.data(), 1, elastic.data(), muscle.data());
    if (design.water()) {
        design.water()->lag(water, q.data(), v.data(), design.sensors().direction(q.data()),
                            design.scene().hydrodynamics.current, 1);
        design.water()->gradient(water, q_new.data(), q.data(), h, 1, flow.data());
    }
    for (std::size_t i = 0; i < q.size(); ++i)
        inertia[i] = design.mass()[i / 3] * (q_new[i] - q[i] - h * v[i]) / (h * h);
    const double scale = norm_of(elastic) + norm_of(muscle) + norm_of(flow) + norm_of(inertia);
    return norm_of(plus(plus(elastic, 1.0, muscle), 1.0, plus(flow, 1.0, inertia))) / scale;
}

// True: the step was taken, and satisfies its equation. False: a status with a reason, and the state as it was.
bool step_or_status(Simulation& s, const Vector& signals, double tolerance) {
    const Vector q(s.q()), v(s.v());
    const long steps = s.steps();
    try {
        s.step({signals.data(), s.design().scene().hydrodynamics.current});
    } catch (const Error& e) {
        CHECK(e.status() == Status::NOT_CONVERGED || e.status() == Status::DIVERGED);
        for (const char* part : {"step", "residual", "cell"}) CHECK(std::strstr(e.what(), part));
        CHECK(s.q() == q && s.v() == v && s.steps() == steps);
        return false;
    }
    CHECK(all_finite(s.q()) && all_finite(s.v()) && s.steps() == steps + 1);
    CHECK(relative_residual(s.design(), q, v, signals, s.q()) <= 1.01 * tolerance);
    return true;
}

// The muscles at their limits, switching sides, at time steps up to ten times the usual.
void test_full_actuation() {
    for (const Method method : {Method::newton_pcg, Method::newton_direct})
        for (const double h : {1.0 / 30, 1.0 / 10, 1.0 / 3}) {
            SceneSettings scene;
            scene.time_step = h;
            scene.method = method;
            Simulation s(design_of(scene));
            int taken = 0;
            double top = 0.0;
            const int steps = method == Method::newton_pcg ? 24 : 8;
            for (int k = 0; k < steps; ++k) {
                if (!step_or_status(s, {k / 4 % 2 ? -1.0 : 1.0}, scene.tolerance)) break;
                ++taken;
                top = std::max(top, top_speed(s.v()));
            }
            print_message("h = %.3f: %d of %d steps, top speed %.2f m/s\n", h, taken, steps, top);
            CHECK(taken == steps);
            CHECK(top > 0.01 && top < 10.0);  // nothing can move faster than the muscles
        }
}

void test_stiff_and_soft() {
    for (const double modulus : {5e8, 5e4})
        for (const double h : {1.0 / 100, 1.0 / 10}) {
            SceneSettings scene;
            scene.time_step = h;
            scene.young_modulus = modulus;
            Simulation s(design_of(scene));
            int taken = 0;
            for (; taken < 10; ++taken)
                if (!step_or_status(s, {taken / 3 % 2 ? -1.0 : 1.0}, scene.tolerance)) break;
            print_message("E = %.0e, h = %.2f: %d of 10 steps\n", modulus, h, taken);
            // Muscles of 2e6 Pa crush a body of 5e4 Pa: there a status is an answer, too.
            CHECK(taken == 10 || (modulus < 1e8 && taken > 0));
            CHECK(top_speed(s.v()) < 20.0);
        }
}

// Nodes displaced at random by up to half a cell and more, with the body in its place or far off, and moving.
void test_violent_states() {
    int taken = 0, refused = 0, inverted = 0;
    for (const Method method : {Method::newton_pcg, Method::newton_direct})
        for (const bool water : {true, false}) {
            SceneSettings scene;
            scene.method = method;
            scene.water = water;
            const auto design = design_of(scene);
            for (std::uint64_t seed = 1; seed <= 3; ++seed) {
                Random random{seed};
                const std::size_t n = design->rest().size();
                const double dx = space()->box().dx;
                Simulation s(design);
                const Vector q = plus(design->rest(), seed == 3 ? 1.0 : 0.5, random_vector(n, random, dx)),
                             v = random_vector(n, random, seed == 2 ? 10.0 : 0.0);
                BodyWorkspace ws;
                Vector elastic(n), muscle(n);
                const double none = 0.0;
                design->body().gradient(ws, q.data(), &none, 1, elastic.data(), muscle.data());
                inverted += ws.inverted;
                s.set_state(q.data(), v.data());
                for (int k = 0; k < 3; ++k) {
                    if (!step_or_status(s, {0.5}, scene.tolerance)) {
                        ++refused;
                        break;
                    }
                    ++taken;
                }
            }
        }
    print_message("violent states: %d steps taken, %d refused, %d points inverted at the start\n", taken, refused,
                  inverted);
    CHECK(inverted > 100);  // of one point a cell
    CHECK(taken >= 30);
}

// The whole body mirrored: every cell inside out, energy far from zero.
void test_mirrored_body() {
    SceneSettings scene;
    scene.water = false;
    Simulation s(design_of(scene));
    Vector q(s.q());
    for (std::size_t n = 0; n < q.size(); n += 3) q[n + 2] = -q[n + 2];
    s.set_state(q.data(), nullptr);
    int taken = 0;
    while (taken < 3 && step_or_status(s, {0.0}, scene.tolerance)) ++taken;
    print_message("mirrored body: %d of 3 steps\n", taken);
    CHECK(norm_of(plus(s.q(), -1.0, q)) > 0.0 || taken == 0);
}

void test_max_newton() {
    SceneSettings scene;
    scene.max_newton = 1;
    Simulation s(design_of(scene));
    const Vector q(s.q()), v = swirl(q, 2.0);
    s.set_state(nullptr, v.data());
    const double signal = 1.0;
    EXPECT_ERROR(NOT_CONVERGED, "step 0: Newton's method reached max_newton; relative force residual",
                 s.step({&signal, s.design().scene().hydrodynamics.current}));
    EXPECT_ERROR(NOT_CONVERGED, "worst at cell ", s.step({&signal, s.design().scene().hydrodynamics.current}));
    CHECK(s.q() == q && s.v() == v && s.steps() == 0);
    // The cell is one of the scene's.
    try {
        s.step({&signal, s.design().scene().hydrodynamics.current});
    } catch (const Error& e) {
        const int cell = std::atoi(std::strstr(e.what(), "cell ") + 5);
        CHECK(cell >= 0 && cell < space()->box().n_cells());
        CHECK(s.design().set().cell_to_active[static_cast<std::size_t>(cell)] >= 0);
    }
}

void test_max_linear() {
    SceneSettings scene;
    scene.max_linear = 1;  // steepest descent on the preconditioner: slow, and still right or reported
    Simulation s(design_of(scene));
    const Vector v = swirl(s.q(), 0.5);
    s.set_state(nullptr, v.data());
    step_or_status(s, {0.5}, scene.tolerance);
}

void test_non_finite_states() {
    Simulation s(design_of({}));
    const Vector rest(s.q());
    const double signal = 0.0;
    for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e200}) {
        Vector q(rest), v(rest.size(), 0.0);
        q[7] = bad;
        s.set_state(q.data(), nullptr);
        EXPECT_ERROR(DIVERGED, "step 0: the state is not finite",
                     s.step({&signal, s.design().scene().hydrodynamics.current}));
        v[5] = bad;
        s.set_state(nullptr, v.data());
        EXPECT_ERROR(DIVERGED, "step 0: the state is not finite",
                     s.step({&signal, s.design().scene().hydrodynamics.current}));
        CHECK(s.q() == rest);
    }
    // And on from there.
    s.set_state(nullptr, nullptr);
    s.step({&signal, s.design().scene().hydrodynamics.current});
    CHECK(all_finite(s.q()));
    const double not_a_number = std::nan("");
    EXPECT_ERROR(DIVERGED, "step 1", s.step({&not_a_number, s.design().scene().hydrodynamics.current}));
}

void test_cancel() {
    SceneSettings scene;
    scene.cancel = std::make_shared<std::atomic<int>>(1);
    Simulation s(design_of(scene));
    const Vector q(s.q());
    const double signal = 1.0;
    EXPECT_ERROR(CANCELLED, "step 0", s.step({&signal, s.design().scene().hydrodynamics.current}));
    CHECK(s.q() == q);
    scene.cancel->store(0);
    s.step({&signal, s.design().scene().hydrodynamics.current});
    CHECK(s.q() != q);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_full_actuation), TEST(test_stiff_and_soft), TEST(test_violent_states),    TEST(test_mirrored_body),
        TEST(test_max_newton),     TEST(test_max_linear),     TEST(test_non_finite_states), TEST(test_cancel),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
