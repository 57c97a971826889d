// SPDX-License-Identifier: MIT
// The end of a step: positions are known to the bound that the header promises, nearly empty cells among them, by every
// instruction set; its work does not explode with the unit of length, and has a bound of its own.
#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;
using dqa::State;
using dqa::Stepper;
using dqa::StepReport;

struct Run {
    std::vector<Vector> q;  // after each step
    std::vector<State> start;
    int newton = 0, linear = 0, indefinite = 0, rescued = 0;
};

double full_strokes(int step) {
    return step / 2 % 2 ? -1.0 : 1.0;
}
double sine(int step) {
    return std::sin(3.14159265358979 / 6.0 * step);
}

Run strokes(const std::shared_ptr<const Design>& design, int steps, double (*stroke)(int) = full_strokes) {
    Stepper stepper(design);
    Run out;
    State now, next;
    now.q = design->rest();
    now.v.assign(now.q.size(), 0.0);
    for (int k = 0; k < steps; ++k) {
        const Vector signals(static_cast<std::size_t>(design->n_signals()), stroke(k));
        const StepReport r = stepper.step(now, {signals.data(), {}}, k, next);
        out.newton += r.newton_iterations, out.linear += r.linear_iterations;
        out.indefinite += r.indefinite > 0, out.rescued += r.rescued;
        out.start.push_back(now);
        std::swap(now, next);
        out.q.push_back(now.q);
    }
    return out;
}

double mass_norm(const Design& design, const Vector& a, const Vector& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += design.mass()[i / 3] * (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(sum);
}

// Each step of the run again from where it began, to a residual of 1e-12: how far its positions were off, against what
// the header allows.
void check_positions(const SceneSettings& scene) {
    const auto design = make_design(scene);
    const Run run = strokes(design, 4);
    SceneSettings exact = scene;
    exact.tolerance = 1e-12, exact.max_newton = 200, exact.precision = Precision::double_precision;
    const auto same = std::make_shared<const Design>(*design, exact);
    double by_mass = 0.0, by_node = 0.0;
    for (std::size_t k = 0; k < run.q.size(); ++k) {
        Stepper stepper(same);
        const Vector signals(static_cast<std::size_t>(design->n_signals()), full_strokes(static_cast<int>(k)));
        State next;
        stepper.step(run.start[k], {signals.data(), {}}, static_cast<long>(k), next);
        const Vector& old = run.start[k].q;
        by_mass = std::max(by_mass, mass_norm(*design, run.q[k], next.q) / mass_norm(*design, old, next.q));
        by_node = std::max(by_node, norm_of(plus(run.q[k], -1.0, next.q)) / norm_of(plus(old, -1.0, next.q)));
    }
    print_message("E %.0e, nu %.3f, floor %.0e, set %d: positions off by %.1e in the mass, %.1e over the nodes\n",
                  scene.young_modulus, scene.poisson_ratio, scene.occupancy_floor, static_cast<int>(scene.instructions),
                  by_mass, by_node);
    CHECK(by_mass <= 5.0 * scene.tolerance && by_node <= 50.0 * scene.tolerance);
}

void test_positions_are_known() {
    for (const auto set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
        if (dqa::choose_instruction_set(set) != set) continue;
        SceneSettings scene;
        scene.instructions = set;
        check_positions(scene);
        // Softer than its muscles, over short steps: where a residual of 1e-6 once left 2e-3 over the nodes.
        scene.young_modulus = 1e5, scene.time_step = 1e-2;
        check_positions(scene);
        scene.integrator = dqa::Integrator::bdf2, scene.material = Material::corotated_volume;
        scene.poisson_ratio = 0.499, scene.contraction = 0.4, scene.occupancy_floor = 2e-6;
        scene.muscle_stiffness = 5e5;
        check_positions(scene);
    }
}

// The same fish up to a thousand times smaller, all else alike, so that inertia is next to nothing beside its
// stiffness. A tuna of a centimetre once took 700 times the products of one of a metre; one of a millimetre did not
// end.
void test_small_bodies() {
    double of_metre = 0.0;
    for (const double size : {1.0, 0.1, 0.01, 0.001}) {
        const auto space = ellipsoid_space({20, 8, 8}, 0.05 * size);
        const Run run = strokes(make_design({}, {0.6, 0.4}, space), 4, sine);
        print_message("body of %g m: %d Newton iterations, %d products, %d steps rescued\n", size, run.newton,
                      run.linear, run.rescued);
        if (size == 1.0) of_metre = run.linear;
        CHECK(run.linear <= (size >= 0.01 ? 40.0 : 200.0) * of_metre);
    }
}

// A stiff body that spins by a radian a step: along straight ways it would be stretched at every iteration.
void test_spinning_body() {
    SceneSettings scene;
    scene.young_modulus = 1e9, scene.water = false;
    const auto design = make_design(scene);
    Stepper stepper(design);
    State now, next;
    now.q = design->rest();
    now.v.resize(now.q.size());
    const double rate = 1.0 / scene.time_step;
    for (std::size_t n = 0; n < now.q.size(); n += 3) now.v[n] = -rate * now.q[n + 1], now.v[n + 1] = rate * now.q[n];
    const double none = 0.0;
    const StepReport r = stepper.step(now, {&none, {}}, 0, next);
    print_message("spin of a radian a step: %d Newton iterations, %d products\n", r.newton_iterations,
                  r.linear_iterations);
    CHECK(r.newton_iterations <= 12 && !r.rescued);
}

// The bound of a step's work, and the state that it leaves.
void test_max_products() {
    SceneSettings scene;
    scene.max_products = 10;
    Simulation s(make_design(scene));
    const double signal = 1.0;
    EXPECT_ERROR(NOT_CONVERGED, "step 0: it has taken ", s.step({&signal, {}}));
    EXPECT_ERROR(NOT_CONVERGED, "max_products is 10", s.step({&signal, {}}));
    CHECK(s.q() == s.design().rest() && s.steps() == 0);
    scene.max_products = 1000;
    Simulation enough(make_design(scene));
    enough.step({&signal, {}});
    // Of the L-BFGS method, too.
    scene.method = dqa::Method::projective, scene.max_products = 3;
    Simulation quasi(make_design(scene));
    EXPECT_ERROR(NOT_CONVERGED, "max_products is 3", quasi.step({&signal, {}}));
}

// A step tells that its energy was not convex: where muscles shorten a body that is softer than they are, not in a
// stiff body that hardly strains.
void test_indefinite_steps() {
    SceneSettings scene;
    scene.young_modulus = 1e4, scene.contraction = 0.8;
    CHECK(strokes(make_design(scene), 2).indefinite > 0);
    scene.young_modulus = 1e8, scene.contraction = 0.05;
    CHECK(strokes(make_design(scene), 2).indefinite == 0);
}

// In two dimensions the factor is that of the plane: both ways to a step that use it, and the multigrid.
void test_factor_in_the_plane() {
    const auto space = plane_space();
    SceneSettings scene;
    scene.tolerance = 1e-10;
    const Vector expected = strokes(make_design(scene, {0.6, 0.4}, space), 2).q.back();
    for (const bool projective : {false, true}) {
        SceneSettings other = scene;
        if (projective)
            other.method = dqa::Method::projective;
        else
            other.preconditioner = dqa::PreconditionerKind::factor;
        const Run run = strokes(make_design(other, {0.6, 0.4}, space), 2);
        print_message("plane, %s: %d iterations\n", projective ? "L-BFGS on the factor" : "factor", run.linear);
        NEAR(relative_difference(run.q.back(), expected), 0.0, 1e-9);
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_positions_are_known), TEST(test_small_bodies),     TEST(test_spinning_body),
        TEST(test_max_products),        TEST(test_indefinite_steps), TEST(test_factor_in_the_plane),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
