// SPDX-License-Identifier: MIT
// The adjoint of one step against differences, and against itself by another linear solver.
#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;

const std::shared_ptr<const ShapeSpace>& space() {
    static const auto s = ellipsoid_space();
    return s;
}

struct Cotangents {
    Vector q, v, signal;
    DesignBar design;
    AdjointReport report;
};

Cotangents adjoint_of(const std::shared_ptr<const Design>& design, const Vector& q, const Vector& v, double signal,
                      const Vector& q_new, const Vector& q_new_bar) {
    Stepper stepper(design);
    Cotangents c{Vector(q.size(), 0.0), Vector(q.size(), 0.0), {0.0}, design->zero_bar(), {}};
    c.report = stepper.adjoint(q.data(), v.data(), &signal, q_new.data(), 0, q_new_bar.data(), c.q.data(), c.v.data(),
                               c.signal.data(), c.design);
    return c;
}

SceneSettings scene_of(Method method) {
    SceneSettings scene = tight_scene();
    scene.tolerance = 1e-13;
    scene.method = method;
    scene.hydrodynamics.current = {-0.4, 0.0, 0.0};
    return scene;
}

void check_step(const std::shared_ptr<const Design>& design, const Vector& q, const Vector& v, double signal,
                std::uint64_t seed) {
    Random random{seed};
    Stepper stepper(design);
    Vector q_new(q.size());
    const StepReport report = stepper.step(q.data(), v.data(), &signal, 0, q_new.data());
    CHECK(report.inverted == 0);
    const Vector bar = random_vector(q.size(), random);
    const Cotangents c = adjoint_of(design, q, v, signal, q_new, bar);
    CHECK(!c.report.direct && c.report.residual <= 1e-12 && c.report.linear_iterations > 0);
    const auto value = [&](const Vector& q_old, const Vector& vel, double s) {
        Vector out(q.size());
        stepper.step(q_old.data(), vel.data(), &s, 0, out.data());
        return dot_of(bar, plus(out, -1.0, q_new));  // the difference: a sum of all positions would drown in rounding
    };
    const Vector dq = random_vector(q.size(), random, 0.002), dv = random_vector(q.size(), random, 0.1);
    CHECK_DERIVATIVE([&](double e) { return value(plus(q, e, dq), v, signal); }, dot_of(c.q, dq), 0.2);
    CHECK_DERIVATIVE([&](double e) { return value(q, plus(v, e, dv), signal); }, dot_of(c.v, dv), 0.1);
    CHECK_DERIVATIVE([&](double e) { return value(q, v, signal + e); }, c.signal[0], 0.2);
}

void test_against_differences() {
    const auto design = make_design(scene_of(Method::newton_pcg), {0.6, 0.4}, space());
    const Vector none(design->rest().size(), 0.0);
    check_step(design, design->rest(), none, 0.5, 1);
    check_step(design, design->rest(), swirl(design->rest(), 0.5), -0.7, 2);
    Random random{3};
    const Vector deformed =
        plus(mapped(design->rest(), random_rotation(random), {1, 2, 3}), 0.003, random_vector(none.size(), random));
    check_step(design, deformed, swirl(deformed, 0.3), 1.0, 4);
    report_worst("step");
}

// CHOLMOD or LDL^T instead of conjugate gradients; also the parts that only differences in alpha can reach.
void test_methods_agree() {
    const auto pcg = make_design(scene_of(Method::newton_pcg), {0.6, 0.4}, space());
    const auto direct = make_design(scene_of(Method::newton_direct), {0.6, 0.4}, space());
    Random random{5};
    const Vector v = swirl(pcg->rest(), 0.5), bar = random_vector(v.size(), random);
    const double signal = 0.8;
    Stepper stepper(direct);
    Vector q_new(v.size());
    stepper.step(direct->rest().data(), v.data(), &signal, 0, q_new.data());
    const Cotangents a = adjoint_of(pcg, pcg->rest(), v, signal, q_new, bar);
    const Cotangents b = adjoint_of(direct, direct->rest(), v, signal, q_new, bar);
    CHECK(b.report.direct && b.report.linear_iterations == 0 && b.report.residual <= 1e-9);
    NEAR(relative_difference(a.q, b.q), 0.0, 1e-9);
    NEAR(relative_difference(a.v, b.v), 0.0, 1e-9);
    NEAR(a.signal[0], b.signal[0], 1e-9 * std::fabs(b.signal[0]));
    NEAR(relative_difference(a.design.mu, b.design.mu), 0.0, 1e-9);
    NEAR(relative_difference(a.design.mass, b.design.mass), 0.0, 1e-9);
    NEAR(relative_difference(a.design.muscle_weight, b.design.muscle_weight), 0.0, 1e-9);
    NEAR(relative_difference(a.design.occupancy, b.design.occupancy), 0.0, 1e-9);
    CHECK(norm_of(b.design.mu) > 0 && norm_of(b.design.muscle_weight) > 0 && norm_of(b.design.occupancy) > 0);
}

// A state that no step made, turned inside out in places: the Hessian is indefinite, and the linear system still
// solved.
void test_indefinite_hessian() {
    SceneSettings scene = scene_of(Method::newton_pcg);
    scene.time_step = 0.5;  // little inertia to hide behind
    const auto design = make_design(scene, {0.6, 0.4}, space());
    Random random{6};
    const Vector v(design->rest().size(), 0.0), bar = random_vector(v.size(), random);
    const Vector broken = plus(design->rest(), 0.04, random_vector(v.size(), random));
    const Cotangents c = adjoint_of(design, design->rest(), v, 0.0, broken, bar);
    CHECK(c.report.direct && c.report.residual <= 1e-9);
    CHECK(all_finite(c.q) && norm_of(c.q) > 0);
    scene.method = Method::newton_direct;
    const Cotangents d = adjoint_of(make_design(scene, {0.6, 0.4}, space()), design->rest(), v, 0.0, broken, bar);
    NEAR(relative_difference(c.v, d.v), 0.0, 1e-6);
}

void test_special_seeds() {
    const auto design = make_design(scene_of(Method::newton_pcg), {0.6, 0.4}, space());
    const Vector v(design->rest().size(), 0.0);
    Vector bar(v);
    Stepper stepper(design);
    Vector q_new(v.size());
    const double signal = 0.5;
    stepper.step(design->rest().data(), v.data(), &signal, 0, q_new.data());
    const Cotangents zero = adjoint_of(design, design->rest(), v, signal, q_new, bar);
    CHECK(norm_of(zero.q) == 0.0 && norm_of(zero.design.mu) == 0.0 && zero.report.linear_iterations == 0);
    bar[4] = std::nan("");
    EXPECT_ERROR(NOT_CONVERGED, "adjoint of step 0", adjoint_of(design, design->rest(), v, signal, q_new, bar));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_against_differences),
        TEST(test_methods_agree),
        TEST(test_indefinite_hessian),
        TEST(test_special_seeds),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
