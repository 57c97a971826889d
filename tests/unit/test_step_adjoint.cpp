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

StepInput input_of(const std::shared_ptr<const Design>& design, const double* signal) {
    return {signal, design->scene().hydrodynamics.current};
}

Cotangents adjoint_of(const std::shared_ptr<const Design>& design, const Vector& q, const Vector& v, double signal,
                      const Vector& q_new, const Vector& q_new_bar) {
    Stepper stepper(design);
    Cotangents c;
    c.design = design->zero_bar();
    StepBar out;
    const State next_bar{q_new_bar, Vector(q.size(), 0.0), {}, {}};
    c.report =
        stepper.adjoint({q, v, {}, {}}, input_of(design, &signal), {q_new, v, {}, {}}, 0, next_bar, out, c.design);
    c.q = out.state.q, c.v = out.state.v, c.signal = out.signals;
    return c;
}

StepReport step_of(Stepper& stepper, const Vector& q, const Vector& v, double signal, Vector& q_new) {
    State next;
    const StepReport report =
        stepper.step({q, v, {}, {}}, {&signal, stepper.design().scene().hydrodynamics.current}, 0, next);
    q_new = next.q;
    return report;
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
    const StepReport report = step_of(stepper, q, v, signal, q_new);
    CHECK(report.inverted == 0);
    const Vector bar = random_vector(q.size(), random);
    const Cotangents c = adjoint_of(design, q, v, signal, q_new, bar);
    CHECK(!c.report.direct && c.report.residual <= 1e-12 && c.report.linear_iterations > 0);
    const auto value = [&](const Vector& q_old, const Vector& vel, double s) {
        Vector out(q.size());
        step_of(stepper, q_old, vel, s, out);
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

// A solution that was kept is where the next adjoint starts, which changes the way to the answer, not the answer.
void test_kept_solution() {
    const auto design = make_design(scene_of(Method::newton_pcg), {0.6, 0.4}, space());
    Random random{21};
    const std::size_t n = design->rest().size();
    const double signal = 0.5;
    const StepInput input = input_of(design, &signal);
    const State now{design->rest(), swirl(design->rest(), 0.4), {}, {}};
    Stepper stepper(design);
    State next;
    stepper.step(now, input, 0, next);
    const Vector bar = random_vector(n, random), other = random_vector(n, random);
    const auto adjoint = [&](const Vector& q_bar, Vector& q) {
        StepBar out;
        DesignBar design_bar = design->zero_bar();
        const AdjointReport report =
            stepper.adjoint(now, input, next, 0, {q_bar, Vector(n, 0.0), {}, {}}, out, design_bar);
        q = out.state.q;
        return report;
    };
    Vector cold, same, multiple, near, again;
    const int iterations = adjoint(bar, cold).linear_iterations;
    CHECK(iterations > 20 && adjoint(bar, same).linear_iterations == iterations && same == cold);
    stepper.keep_solution();
    CHECK(adjoint(plus(bar, -3.0, bar), multiple).linear_iterations == 0);  // -2 bar
    CHECK(relative_difference(plus(multiple, 3.0, cold), cold) <= 1e-11);
    stepper.keep_solution();
    const AdjointReport close = adjoint(plus(bar, 1e-4, other), near);
    CHECK(close.linear_iterations > 0 && close.linear_iterations < iterations - 5 && close.residual <= 1e-12);
    const Cotangents alone = adjoint_of(design, now.q, now.v, signal, next.q, plus(bar, 1e-4, other));
    CHECK(relative_difference(near, alone.q) <= 1e-11);
    stepper.keep_solution();
    CHECK(adjoint(other, again).residual <= 1e-12);  // from one that has little to do with it
    CHECK(relative_difference(again, adjoint_of(design, now.q, now.v, signal, next.q, other).q) <= 1e-11);
}

// Everything a step reads, along random directions: a two-step step, constrained coordinates, both.
void check_state(const SceneSettings& scene, std::uint64_t seed,
                 const std::shared_ptr<const ShapeSpace>& shapes = space()) {
    const auto design = make_design(scene, {0.6, 0.4}, shapes);
    Random random{seed};
    const std::size_t n = design->rest().size();
    State now;
    now.q = plus(design->rest(), 0.002, random_vector(n, random)), now.v = swirl(now.q, 0.4);
    if (scene.integrator == Integrator::bdf2) {
        now.q_before = plus(now.q, -scene.time_step, swirl(now.q, 0.35));
        now.v_before = swirl(now.q, 0.35);
    }
    const double signal = 0.6;
    const Vec3 current = scene.hydrodynamics.current;
    Stepper stepper(design);
    State next;
    const StepReport report = stepper.step(now, {&signal, current}, 0, next);
    CHECK(report.inverted == 0);
    for (const int c : design->constrained()) {
        const std::size_t i = static_cast<std::size_t>(c);
        CHECK(next.q[i] == now.q[i] && next.v[i] == 0.0);
    }
    State bar;
    bar.q = random_vector(n, random), bar.v = random_vector(n, random, 0.05);
    if (scene.integrator == Integrator::bdf2)
        bar.q_before = random_vector(n, random), bar.v_before = random_vector(n, random, 0.05);
    StepBar out;
    DesignBar design_bar = design->zero_bar();
    stepper.adjoint(now, {&signal, current}, next, 0, bar, out, design_bar);
    const auto change = [](const Vector& b, const Vector& x, const Vector& x0) {
        return b.empty() ? 0.0 : dot_of(b, plus(x, -1.0, x0));
    };
    const auto value = [&](const State& from, double s, const Vec3& c) {
        State to;
        stepper.step(from, {&s, c}, 0, to);
        return change(bar.q, to.q, next.q) + change(bar.v, to.v, next.v) +
               change(bar.q_before, to.q_before, next.q_before) + change(bar.v_before, to.v_before, next.v_before);
    };
    const auto check = [&](Vector State::*field, double size, double step) {
        if ((now.*field).empty()) return;
        const Vector d = random_vector(n, random, size);
        CHECK_DERIVATIVE(
            [&](double e) {
                State from = now;
                from.*field = plus(now.*field, e, d);
                return value(from, signal, current);
            },
            dot_of(out.state.*field, d), step);
    };
    check(&State::q, 0.002, 0.2);
    check(&State::v, 0.1, 0.1);
    check(&State::q_before, 0.002, 0.2);
    check(&State::v_before, 0.1, 0.1);
    CHECK_DERIVATIVE([&](double e) { return value(now, signal + e, current); }, out.signals[0], 0.2);
    const Vec3 d = {0.3, 0.5, -0.2};
    CHECK_DERIVATIVE(
        [&](double e) {
            return value(now, signal, {current[0] + e * d[0], current[1] + e * d[1], current[2] + e * d[2]});
        },
        out.current[0] * d[0] + out.current[1] * d[1] + out.current[2] * d[2], 0.1);
}

void test_two_steps_and_constraints() {
    SceneSettings scene = scene_of(Method::newton_pcg);
    check_state(scene, 21);
    scene.integrator = Integrator::bdf2;
    check_state(scene, 22);
    scene.planar = true;
    check_state(scene, 23);
    scene.integrator = Integrator::implicit_euler;
    const Box& box = space()->box();
    for (int j = 0; j <= box.cells[1]; ++j)
        for (int k = 0; k <= box.cells[2]; ++k) scene.fixed_nodes.push_back(box.node(box.cells[0] / 2, j, k));
    check_state(scene, 24);
    scene.planar = false;
    scene.integrator = Integrator::bdf2;
    check_state(scene, 25);
    scene.method = Method::newton_direct;  // dear: on a smaller body
    scene.fixed_nodes.clear();
    const auto small = ellipsoid_space({10, 6, 6}, 0.1);
    for (int node = 0; node < 49; ++node) scene.fixed_nodes.push_back(small->box().node(5, node / 7, node % 7));
    check_state(scene, 26, small);
    report_worst("two-step and constrained steps");
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
    step_of(stepper, direct->rest(), v, signal, q_new);
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
    step_of(stepper, design->rest(), v, signal, q_new);
    const Cotangents zero = adjoint_of(design, design->rest(), v, signal, q_new, bar);
    CHECK(norm_of(zero.q) == 0.0 && norm_of(zero.design.mu) == 0.0 && zero.report.linear_iterations == 0);
    bar[4] = std::nan("");
    EXPECT_ERROR(NOT_CONVERGED, "adjoint of step 0", adjoint_of(design, design->rest(), v, signal, q_new, bar));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_against_differences), TEST(test_kept_solution),      TEST(test_two_steps_and_constraints),
        TEST(test_methods_agree),       TEST(test_indefinite_hessian), TEST(test_special_seeds),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
