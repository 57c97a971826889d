// SPDX-License-Identifier: MIT
// The yardstick of the benchmarks solves the library's discrete problem: two codes that share only densities, fibres
// and coefficient laws agree in state and gradient, over several steps and back, for every form of the water.
#include "../bench/reference.hpp"
#include "../unit/motion_fixtures.hpp"

namespace {

using namespace fixtures;

constexpr int kSteps = 2;

std::shared_ptr<const ShapeSpace> space() {
    return ellipsoid_space({14, 7, 6}, 0.06);
}

struct Rollout {
    Vector q, v, q_bar, v_bar, signals_bar;
    double iterations = 0.0, adjoint_iterations = 0.0;
};

double signal_at(int step) {
    return std::sin(0.7 * step + 0.6);
}

Vector flat(const bench::Field& f) {
    return {f.data(), f.data() + f.size()};
}

SceneSettings scene_of(double tolerance) {
    SceneSettings scene = tight_scene();
    scene.threshold = 0.0, scene.quadrature = dqa::Quadrature::full;
    scene.tolerance = tolerance, scene.adjoint_tolerance = tolerance;
    scene.hydrodynamics.current = {-0.3, 0.1, 0.0};
    return scene;
}

// A cotangent for the last positions and velocities, weighted by mass as sums over the body are.
void seed(const Vector& mass, Vector& q_bar, Vector& v_bar) {
    Random random{11};
    q_bar = random_vector(3 * mass.size(), random), v_bar = random_vector(3 * mass.size(), random, 0.05);
    for (std::size_t i = 0; i < q_bar.size(); ++i) q_bar[i] *= mass[i / 3], v_bar[i] *= mass[i / 3];
}

Rollout by_library(const std::shared_ptr<const Design>& design) {
    Stepper stepper(design);
    std::vector<State> states{{design->rest(), Vector(design->rest().size(), 0.0), {}, {}}};
    Rollout out;
    for (int k = 0; k < kSteps; ++k) {
        const double signal = signal_at(k);
        State next;
        out.iterations +=
            stepper.step(states.back(), {&signal, design->scene().hydrodynamics.current}, k, next).linear_iterations;
        states.push_back(next);
    }
    out.q = states.back().q, out.v = states.back().v;
    State bar;
    seed(design->mass(), bar.q, bar.v);
    DesignBar unused = design->zero_bar();
    for (int k = kSteps - 1; k >= 0; --k) {
        const double signal = signal_at(k);
        const std::size_t at = static_cast<std::size_t>(k);
        StepBar step;
        out.adjoint_iterations += stepper
                                      .adjoint(states[at], {&signal, design->scene().hydrodynamics.current},
                                               states[at + 1], k, bar, step, unused)
                                      .linear_iterations;
        bar = step.state;
        out.signals_bar.push_back(step.signals[0]);
    }
    out.q_bar = bar.q, out.v_bar = bar.v;
    return out;
}

Rollout by_reference(const SceneSettings& scene, const Vector& mass) {
    bench::Reference reference(*space(), {0.6, 0.4}, scene);
    CHECK(relative_difference(Vector(reference.mass().begin(), reference.mass().end()), mass) < 1e-14);
    std::vector<bench::FieldState> states{{reference.rest(), bench::Field::Zero(3, reference.rest().cols())}};
    Rollout out;
    for (int k = 0; k < kSteps; ++k) {
        bench::FieldState next;
        const bench::ReferenceReport report = reference.step(states.back(), {signal_at(k)}, next);
        CHECK(report.residual <= scene.tolerance);
        out.iterations += report.iterations;
        states.push_back(next);
    }
    out.q = flat(states.back().q), out.v = flat(states.back().v);
    Vector q_bar, v_bar;
    seed(mass, q_bar, v_bar);
    bench::FieldState bar{Eigen::Map<bench::Field>(q_bar.data(), 3, reference.rest().cols()),
                          Eigen::Map<bench::Field>(v_bar.data(), 3, reference.rest().cols())};
    for (int k = kSteps - 1; k >= 0; --k) {
        const std::size_t at = static_cast<std::size_t>(k);
        bench::FieldState before;
        Vector signals_bar(1, 0.0);
        const bench::ReferenceReport report =
            reference.adjoint(states[at], {signal_at(k)}, states[at + 1], bar, before, signals_bar);
        CHECK(report.residual <= scene.adjoint_tolerance);
        out.adjoint_iterations += report.iterations;
        bar = before;
        out.signals_bar.push_back(signals_bar[0]);
    }
    out.q_bar = flat(bar.q), out.v_bar = flat(bar.v);
    return out;
}

// Nodes far from the body weigh next to nothing and are known less well than those of the body.
Vector weighted(const Vector& field, const Vector& mass) {
    Vector out(field);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] *= std::sqrt(mass[i / 3]);
    return out;
}

void compare(const char* name, const SceneSettings& scene) {
    const auto design = make_design(scene, {0.6, 0.4}, space());
    const Rollout a = by_library(design), b = by_reference(scene, design->mass());
    const Vector moved = weighted(plus(a.q, -1.0, design->rest()), design->mass());
    const double q = norm_of(weighted(plus(b.q, -1.0, a.q), design->mass())) / norm_of(moved);
    const double v = relative_difference(weighted(b.v, design->mass()), weighted(a.v, design->mass()));
    const double q_bar = relative_difference(b.q_bar, a.q_bar), v_bar = relative_difference(b.v_bar, a.v_bar);
    const double signals = relative_difference(b.signals_bar, a.signals_bar);
    print_message(
        "%s: displacement %.1e, velocity %.1e; gradient by position %.1e, velocity %.1e, actuation %.1e; "
        "%.0f and %.0f iterations forward, %.0f and %.0f back\n",
        name, q, v, q_bar, v_bar, signals, a.iterations, b.iterations, a.adjoint_iterations, b.adjoint_iterations);
    CHECK(norm_of(moved) > 1e-3 && norm_of(a.signals_bar) > 0 && norm_of(a.q_bar) > 0 && norm_of(a.v_bar) > 0);
    for (const double error : {q, v, q_bar, v_bar, signals}) CHECK(error <= 1e-6);
}

void test_agreement() {
    SceneSettings scene = scene_of(1e-10);
    compare("water in the step", scene);
    scene.hydrodynamics.windward_only = true;
    compare("windward faces", scene);
    scene.hydrodynamics.windward_only = false;
    scene.water = false;
    compare("no water", scene);
}

// Shorter steps: explicit forces blow up where the water is heavier than the nodes it acts on.
void test_explicit_water() {
    SceneSettings scene = scene_of(1e-10);
    scene.time_step = 1e-3;
    scene.hydrodynamics.explicit_forces = true;
    scene.occupancy_floor = 1e-2;
    compare("water at the start of the step", scene);
}

void test_refusals() {
    EXPECT_ERROR(ERROR_ARGUMENT, "three dimensions", bench::Reference(*plane_space(), {0.5, 0.5}, SceneSettings{}));
    SceneSettings scene = scene_of(1e-10);
    scene.max_linear = 3;
    bench::Reference reference(*space(), {0.6, 0.4}, scene);
    const bench::FieldState start{reference.rest(), bench::Field::Zero(3, reference.rest().cols())};
    bench::FieldState next, bar;
    EXPECT_ERROR(NOT_CONVERGED, "after 3 iterations", reference.step(start, {0.5}, next));
    Vector signals_bar(1, 0.0);
    next = start;
    bench::FieldState next_bar{bench::Field::Random(3, reference.rest().cols()), start.v};
    EXPECT_ERROR(NOT_CONVERGED, "adjoint", reference.adjoint(start, {0.5}, next, next_bar, bar, signals_bar));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {TEST(test_agreement), TEST(test_explicit_water), TEST(test_refusals)};
    return cmocka_run_group_tests_name("reference", tests, nullptr, nullptr);
}
