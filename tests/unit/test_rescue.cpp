// SPDX-License-Identifier: MIT
// Where Newton's method fails, and what takes over: the same minimiser, the same derivative, at a bounded price.
#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;

// A slender body with one muscle pair over most of its length.
std::shared_ptr<const ShapeSpace> slender_space() {
    dqa::ShapeSettings s;
    s.cells = {30, 6, 6};
    s.cell_size = 0.03;
    s.sigma = 0.5;
    auto space = std::make_shared<ShapeSpace>(s);
    for (const double width : {1.7, 1.5}) {
        const Vec3 radius{13.0, width, 1.6};
        space->add_fractions("slender", ellipsoid_fractions(s.cells, radius).data());
        Actuator a;
        a.mean = {-0.06, 0.0, 0.0};
        const Vec3 half{10.0 * s.cell_size, 0.97 * width * s.cell_size, 0.05};
        for (std::size_t k = 0; k < 3; ++k) a.variance[k] = half[k] * half[k] / dqa::kTwoLn2;
        space->add_actuator(width > 1.6 ? 0 : 1, a);
    }
    space->build(nullptr);
    return space;
}

struct Swim {
    dqa::State state;
    int newton = 0, linear = 0, rescued = 0;
    double residual = 0.0;
};

// Steps from rest under a sine of 2.5 Hz.
Swim swim(const std::shared_ptr<const Design>& design, int steps, double amplitude = 1.0) {
    dqa::Stepper stepper(design);
    const SceneSettings& scene = design->scene();
    Swim out;
    out.state.q = design->rest();
    out.state.v.assign(out.state.q.size(), 0.0);
    dqa::State next;
    for (int k = 0; k < steps; ++k) {
        const Vector signals(static_cast<std::size_t>(design->n_signals()),
                             amplitude * std::sin(5.0 * 3.14159265358979 * (k + 1) * scene.time_step + 0.5));
        const dqa::StepReport r = stepper.step(out.state, {signals.data(), {}}, k, next);
        std::swap(out.state, next);
        out.newton += r.newton_iterations, out.linear += r.linear_iterations, out.rescued += r.rescued;
        out.residual = std::max(out.residual, r.residual);
    }
    return out;
}

// Close to rest the parts of a neo-Hookean energy cancel, and what its rounding hides is no reason to fail.
void test_small_motions_of_neo_hookean_bodies() {
    const auto space = ellipsoid_space({14, 6, 6}, 0.07);
    for (const double threshold : {0.02, 0.005, 0.001})
        for (const double amplitude : {1e-2, 1e-4, 1e-6}) {
            SceneSettings scene = tight_scene();
            scene.material = Material::neo_hookean;
            scene.threshold = threshold;
            scene.tolerance = 1e-13;
            const Swim got = swim(make_design(scene, {0.6, 0.4}, space), 4, amplitude);
            print_message("threshold %g, amplitude %g: %d iterations in four steps\n", threshold, amplitude,
                          got.newton);
            CHECK(got.rescued == 0 && got.newton <= 4 * 12);
        }
}

// With three iterations allowed the scene's method fails at every step, and the other one answers: as Newton's method
// and direct solves do where they have time, and with the same derivative.
void test_same_answer() {
    SceneSettings scene = tight_scene();
    scene.max_newton = 3;
    const auto hurried = make_design(scene);
    const Swim got = swim(hurried, 3);
    CHECK(got.rescued == 3 && got.residual <= scene.tolerance);
    scene.max_newton = 50;
    scene.method = dqa::Method::newton_direct;
    const auto patient = make_design(scene);
    const Swim expected = swim(patient, 3);
    CHECK(expected.rescued == 0);
    Vector moved(got.state.q), moved_expected(expected.state.q);
    for (std::size_t i = 0; i < moved.size(); ++i)
        moved[i] -= hurried->rest()[i], moved_expected[i] -= hurried->rest()[i];
    const double error = relative_difference(moved, moved_expected);
    print_message("rescued against direct: displacements differ by %.1e\n", error);
    CHECK(error <= 1e-8);

    // The adjoint of the last of two steps.
    const Swim before = swim(patient, 2);
    const Vector signals(static_cast<std::size_t>(patient->n_signals()), 0.4);
    Random random(3);
    dqa::State next_bar;
    next_bar.q = random_vector(before.state.q.size(), random), next_bar.v.assign(next_bar.q.size(), 0.0);
    Vector gradients[2];
    for (int k = 0; k < 2; ++k) {
        const auto design = k ? hurried : patient;
        dqa::Stepper stepper(design);
        dqa::State next;
        const dqa::StepReport r = stepper.step(before.state, {signals.data(), {}}, 2, next);
        CHECK(r.rescued == (k == 1));
        dqa::StepBar out;
        dqa::DesignBar bar = design->zero_bar();
        stepper.adjoint(before.state, {signals.data(), {}}, next, 2, next_bar, out, bar);
        gradients[k] = out.state.q;
    }
    CHECK(norm_of(gradients[0]) > 0.0 && relative_difference(gradients[1], gradients[0]) <= 1e-6);
}

// A slender body under a full stroke snaps from side to side through a curved valley of its energy.
void test_snapping_body() {
    SceneSettings scene;
    scene.time_step = 1.0 / 15.0;
    scene.threshold = 0.02;
    const auto space = slender_space();
    int rescued = 0;
    for (const double contraction : {0.4, 0.6}) {
        scene.contraction = contraction;
        const Swim got = swim(make_design(scene, {0.5, 0.5}, space), 6);
        print_message("%d of 6 steps rescued, %d iterations, %d products\n", got.rescued, got.newton, got.linear);
        CHECK(got.residual <= scene.tolerance);
        CHECK(got.linear <= 30000);
        rescued += got.rescued;
    }
    CHECK(rescued >= 1);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_small_motions_of_neo_hookean_bodies),
        TEST(test_same_answer),
        TEST(test_snapping_body),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
