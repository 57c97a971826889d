// SPDX-License-Identifier: MIT
// The two-level preconditioner: a symmetric positive definite operator that turns with the body, gives the same bits
// for any number of threads, and saves iterations; and that no answer depends on it.
#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;

// Actuation that bends the body well.
StepReport swim(Simulation& simulation, int steps) {
    StepReport sum;
    for (int k = 0; k < steps; ++k) {
        const Vector signals(static_cast<std::size_t>(simulation.design().n_signals()), std::sin(0.6 * k));
        const StepReport r = simulation.step({signals.data(), {}});
        sum.newton_iterations += r.newton_iterations, sum.linear_iterations += r.linear_iterations;
    }
    return sum;
}

Vector solved(const Preconditioner& p, const Vector& in, int threads, Preconditioner::Workspace& ws) {
    Vector out(in.size());
    with_crew(threads, [&](Threads t) { p.solve(in.data(), out.data(), t, ws); });
    return out;
}

void test_operator() {
    for (const int kind : {0, 1, 2, 3}) {
        const Precision precision = kind % 2 ? Precision::double_precision : Precision::single_precision;
        SceneSettings scene;
        scene.precision = precision;
        scene.preconditioner = kind / 2 ? PreconditionerKind::factor : PreconditionerKind::multilevel;
        const auto design = make_design(scene);
        const Preconditioner& p = design->preconditioner();
        const std::size_t n = design->rest().size();
        const double rounding = precision == Precision::single_precision ? 1e-5 : 1e-12;
        Random random{4};
        const auto turn = random_rotation(random);
        const Vector q = mapped(design->rest(), turn, {3.0, -1.0, 2.0});
        Vector a = random_vector(n, random), b = random_vector(n, random);
        Preconditioner::Workspace ws;
        p.turn(q.data(), 1, ws);
        const Vector pa = solved(p, a, 1, ws), pb = solved(p, b, 1, ws);
        CHECK(dot_of(a, pa) > 0 && dot_of(b, pb) > 0);
        NEAR(dot_of(pa, b), dot_of(a, pb), rounding * norm_of(pa) * norm_of(b));
        for (const int threads : {2, 3, 8}) {
            Preconditioner::Workspace other;
            with_crew(threads, [&](Threads t) { p.turn(q.data(), t, other); });
            CHECK(solved(p, a, threads, other) == pa);
        }
        // P(turned body) (turned force) = turned P(force).
        Preconditioner::Workspace rest;
        p.turn(design->rest().data(), 1, rest);
        const Vector turned = solved(p, mapped(a, turn), 1, ws), unturned = mapped(solved(p, a, 1, rest), turn);
        NEAR(relative_difference(turned, unturned), 0.0, rounding);
        // Where cells are crushed or inverted it stays an operator.
        Vector crushed(q);
        for (std::size_t i = 0; i < n; ++i) crushed[i] = i % 3 == 0 ? -q[i] : 0.0;
        p.turn(crushed.data(), 1, ws);
        const Vector pc = solved(p, a, 1, ws);
        CHECK(all_finite(pc) && dot_of(a, pc) > 0);
    }
}

// Iterations that do not grow with the grid; the same motion with the factor.
void test_few_iterations() {
    double per_newton[2];
    for (const int scale : {1, 2}) {
        const auto space = ellipsoid_space({20 * scale, 8 * scale, 8 * scale}, 0.05 / scale);
        SceneSettings scene;
        scene.tolerance = 1e-9;
        Vector states[2];
        for (const bool factor : {false, true}) {
            scene.preconditioner = factor ? PreconditionerKind::factor : PreconditionerKind::multilevel;
            Simulation simulation(std::make_shared<const Design>(space, Vector{0.6, 0.4}, scene, nullptr));
            const StepReport report = swim(simulation, 4);
            states[factor] = simulation.q();
            const double linear = static_cast<double>(report.linear_iterations) / report.newton_iterations;
            print_message("%d cells, %s: %.1f linear iterations a Newton iteration\n",
                          simulation.design().set().n_cells(), factor ? "factor" : "multilevel", linear);
            if (!factor) per_newton[scale - 1] = linear;
        }
        NEAR(relative_difference(states[1], states[0]), 0.0, 1e-7);
    }
    CHECK(per_newton[1] < 1.5 * per_newton[0]);
}

// Constrained coordinates, two dimensions, all materials and BDF2: the same motion as by the direct solver.
void test_same_answer() {
    const auto compare = [](SceneSettings scene, const std::shared_ptr<const ShapeSpace>& space) {
        scene.tolerance = 1e-9;
        Vector states[2];
        for (const Method method : {Method::newton_pcg, Method::newton_direct}) {
            scene.method = method;
            Simulation simulation(std::make_shared<const Design>(space, Vector{0.6, 0.4}, scene, nullptr));
            swim(simulation, 3);
            states[method == Method::newton_direct] = simulation.q();
        }
        NEAR(relative_difference(states[0], states[1]), 0.0, 1e-8);
    };
    const auto space = ellipsoid_space({14, 8, 8});
    SceneSettings scene;
    scene.planar = true;
    scene.fixed_nodes = {100, 101, 200, 300, 301, 302};
    compare(scene, space);
    scene = {};
    scene.integrator = Integrator::bdf2;
    compare(scene, plane_space());
    scene = {};
    scene.material = Material::corotated_volume;
    compare(scene, space);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {TEST(test_operator), TEST(test_few_iterations), TEST(test_same_answer)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
