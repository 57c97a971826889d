// SPDX-License-Identifier: MIT
// Time steps: two solvers with one answer, conservation, order in h, invariance, and the same bits for any threads.
#include "motion_fixtures.hpp"
#include "tape/adjoint.hpp"

namespace {

using namespace fixtures;

const std::shared_ptr<const ShapeSpace>& space() {
    static const auto s = ellipsoid_space();
    return s;
}

std::shared_ptr<const Design> design_of(const SceneSettings& scene) {
    return make_design(scene, {0.6, 0.4}, space());
}

Vec3 momentum(const Simulation& s) {
    Vec3 p{};
    for (std::size_t i = 0; i < s.v().size(); ++i) p[i % 3] += s.design().mass()[i / 3] * s.v()[i];
    return p;
}

double energy(const Simulation& s, const Vector& signals) {
    BodyWorkspace ws;
    Vector elastic(s.q().size()), muscle(s.q().size());
    double e = s.design().body().gradient(ws, s.q().data(), signals.data(), 1, elastic.data(), muscle.data());
    for (std::size_t i = 0; i < s.v().size(); ++i) e += 0.5 * s.design().mass()[i / 3] * s.v()[i] * s.v()[i];
    return e;
}

void test_design() {
    const auto design = design_of(tight_scene());
    CHECK(design->n_signals() == 1 && design->n_body_cells() > 50 && design->n_muscle_cells() > 10);
    // Mass and spine by their definition.
    double mass = 0.0, occupied = 0.0;
    for (const double m : design->mass()) mass += m;
    for (const double g : design->occupancy()) occupied += g;
    NEAR(mass, 1000 * occupied * 0.05 * 0.05 * 0.05, 1e-10 * mass);
    for (std::size_t n = 0; n < design->spine().size(); ++n)
        CHECK((design->spine()[n] > 0) == (design->rest()[3 * n + 1] == 0.0));
}

// A wriggling swimmer in water by every method, of every material.
void check_methods(Material material) {
    SceneSettings scene = tight_scene();
    scene.material = material;
    scene.max_linear = 5000;
    Simulation pcg(design_of(scene));
    scene.method = Method::newton_direct;
    Simulation direct(design_of(scene));
    scene.method = Method::projective;
    scene.tolerance = 1e-11;  // it stops just below its tolerance, where Newton's last step goes far beyond
    Simulation projective(design_of(scene));
    CHECK(pcg.q() == direct.q());
    const Vector v = swirl(pcg.q(), 0.5);
    for (Simulation* s : {&pcg, &direct, &projective}) s->set_state(nullptr, v.data());
    double worst = 0.0;
    int newton = 0, quasi_newton = 0;
    for (int k = 0; k < 6; ++k) {
        const double signal = std::sin(0.6 * k + 0.5);
        const StepInput input{&signal, scene.hydrodynamics.current};
        const StepReport a = pcg.step(input), b = direct.step(input), c = projective.step(input);
        CHECK(a.residual <= 1e-10 && b.residual <= 1e-10 && c.residual <= 1e-10 && a.inverted == 0);
        CHECK(a.newton_iterations <= 12 && a.linear_iterations > a.newton_iterations);
        // The quasi-Newton method may end in a correction by conjugate gradients, until positions are known.
        CHECK(b.linear_iterations == b.newton_iterations && c.linear_iterations >= c.newton_iterations);
        newton += a.linear_iterations, quasi_newton += c.linear_iterations;
        const Vector moved = plus(direct.q(), -1.0, direct.design().rest());
        for (const Simulation* s : {&pcg, &projective}) {
            worst = std::max(worst, norm_of(plus(s->q(), -1.0, direct.q())) / norm_of(moved));
            NEAR(relative_difference(s->v(), direct.v()), 0.0, 1e-6);
            NEAR(s->forces().drag[0], direct.forces().drag[0], 1e-6 * std::fabs(direct.forces().drag[0]));
        }
    }
    print_message("methods differ by %.1e of the displacement; solves: newton_pcg %d, projective %d\n", worst, newton,
                  quasi_newton);
    CHECK(worst > 0 && worst < 1e-8);  // the tolerance times the condition of the softest motions
    NEAR(pcg.time(), 6.0 / 30, 1e-15);
}

void test_methods_agree() {
    for (const Material m : {Material::corotated, Material::corotated_volume, Material::neo_hookean}) check_methods(m);
}

// Without water and actuation: momentum stays, energy does not grow, for a translation, rotation and bending at once.
void test_conservation() {
    SceneSettings scene = tight_scene();
    scene.water = false;
    scene.tolerance = 1e-12;
    Simulation s(design_of(scene));
    CHECK(!s.design().water());
    const Vector v = swirl(s.q(), 1.0), none = {0.0};
    s.set_state(nullptr, v.data());
    const Vec3 start = momentum(s);
    double before = energy(s, none), worst = 0.0;
    const double first = before, size = std::sqrt(start[0] * start[0] + start[1] * start[1] + start[2] * start[2]);
    CHECK(size > 1.0);
    for (int k = 0; k < 20; ++k) {
        s.step({none.data(), s.design().scene().hydrodynamics.current});
        const Vec3 p = momentum(s);
        for (std::size_t a = 0; a < 3; ++a) worst = std::max(worst, std::fabs(p[a] - start[a]) / size);
        const double now = energy(s, none);
        CHECK(now <= before * (1 + 1e-11));
        before = now;
    }
    print_message("momentum drifts by %.1e, energy falls to %.3f\n", worst, before / first);
    CHECK(worst <= 1e-10);
    CHECK(before < first && before > 0.1 * first);  // most of it is rigid motion, which implicit Euler keeps
    CHECK(norm_of(Vector{s.forces().drag[0], s.forces().thrust[0]}) == 0.0);
}

// The muscles act between parts of the body: they leave the momentum alone.
void test_muscles_conserve_momentum() {
    SceneSettings scene = tight_scene();
    scene.water = false;
    scene.tolerance = 1e-12;
    Simulation s(design_of(scene));
    for (int k = 0; k < 6; ++k) {
        const double signal = k % 2 ? -1.0 : 1.0;
        s.step({&signal, s.design().scene().hydrodynamics.current});
    }
    const Vec3 p = momentum(s);
    double size = 0.0;
    for (std::size_t i = 0; i < s.v().size(); ++i) size += s.design().mass()[i / 3] * std::fabs(s.v()[i]);
    CHECK(size > 0.1);
    for (const double x : p) NEAR(x, 0.0, 1e-10 * size);
}

// Error at a fixed time against a fine reference halves with h; water, muscle and inertia at work. The body is soft
// enough that the steps resolve waves from cell to cell (5 m/s).
void test_first_order() {
    const double end = 0.02;
    const auto run = [&](int steps) {
        SceneSettings scene = tight_scene();
        scene.time_step = end / steps;
        scene.young_modulus = 5e4, scene.muscle_stiffness = 2e4;
        Simulation s(design_of(scene));
        const Vector v = swirl(s.q(), 0.5);
        s.set_state(nullptr, v.data());
        const double signal = 0.4;
        for (int k = 0; k < steps; ++k) s.step({&signal, s.design().scene().hydrodynamics.current});
        return s.q();
    };
    const Vector reference = run(640);
    const double e1 = norm_of(plus(run(20), -1.0, reference)), e2 = norm_of(plus(run(40), -1.0, reference));
    // The reference's own error, of first order, is known from its step: e(h) ~ c (h - h_ref).
    const double ratio = (e1 / (1.0 / 20 - 1.0 / 640)) / (e2 / (1.0 / 40 - 1.0 / 640)) * 2.0;
    print_message("first order: error ratio %.3f\n", ratio);
    NEAR(ratio, 2.0, 0.2);
}

// BDF2 on the same body: differences between successive step sizes fall by four. The first step is one of implicit
// Euler and costs no order.
void test_second_order() {
    const double end = 0.02;
    const auto run = [&](int steps) {
        SceneSettings scene = tight_scene();
        scene.integrator = Integrator::bdf2;
        scene.time_step = end / steps;
        scene.young_modulus = 5e4, scene.muscle_stiffness = 2e4;
        Simulation s(design_of(scene));
        const Vector v = swirl(s.q(), 0.5);
        s.set_state(nullptr, v.data());
        const double signal = 0.4;
        for (int k = 0; k < steps; ++k) s.step({&signal, scene.hydrodynamics.current});
        return s.q();
    };
    const Vector a = run(40), b = run(80), c = run(160), d = run(320);
    const double first = norm_of(plus(a, -1.0, b)) / norm_of(plus(b, -1.0, c)),
                 second = norm_of(plus(b, -1.0, c)) / norm_of(plus(c, -1.0, d));
    print_message("second order: error ratios %.3f, %.3f\n", first, second);
    NEAR(second, 4.0, 0.4);
}

// A hundred metres away the same happens, to the rounding of positions there.
void test_translation_invariance() {
    const auto design = design_of(tight_scene());
    Simulation here(design), there(design);
    const Vector v = swirl(here.q(), 0.5);
    Vector shifted(design->rest());
    const Vec3 shift = {100, -60, 80};
    for (std::size_t i = 0; i < shifted.size(); ++i) shifted[i] += shift[i % 3];
    here.set_state(nullptr, v.data()), there.set_state(shifted.data(), v.data());
    for (int k = 0; k < 5; ++k) {
        const double signal = std::sin(0.6 * k + 0.5);
        const StepReport a = here.step({&signal, here.design().scene().hydrodynamics.current}),
                         b = there.step({&signal, there.design().scene().hydrodynamics.current});
        CHECK(std::abs(a.newton_iterations - b.newton_iterations) <= 1 && b.residual < 1e-9);
    }
    const Vector moved = plus(here.q(), -1.0, design->rest()), moved_there = plus(there.q(), -1.0, shifted);
    print_message("100 m away: displacement differs by %.1e\n", relative_difference(moved_there, moved));
    NEAR(relative_difference(moved_there, moved), 0.0, 1e-9);
}

// Forward and backward, weights included.
void test_threads_give_the_same_bits() {
    const auto run = [&](int threads) {
        SceneSettings scene;
        scene.threads = threads;
        Simulation s(design_of(scene));
        const Vector v = swirl(s.q(), 0.5);
        s.set_state(nullptr, v.data());
        auto tape = std::make_shared<Tape>(0);
        for (int k = 0; k < 5; ++k) advance(s, {std::sin(0.6 * k + 0.5)}, tape.get());
        Adjoint adjoint(tape);
        adjoint.seed_objective({{}});
        adjoint.backward(0, nullptr);
        Vector out(s.q());
        for (const Vector& part : {s.v(), adjoint.weights_bar(), adjoint.actuation_bar(), adjoint.position_bar(),
                                   adjoint.velocity_bar(), Vector{tape->objective({{}}, nullptr)}})
            out.insert(out.end(), part.begin(), part.end());
        return out;
    };
    const Vector one = run(1);
    CHECK(all_finite(one));
    for (const int threads : {2, 4}) CHECK(run(threads) == one);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_design),
        TEST(test_methods_agree),
        TEST(test_conservation),
        TEST(test_muscles_conserve_momentum),
        TEST(test_first_order),
        TEST(test_second_order),
        TEST(test_translation_invariance),
        TEST(test_threads_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
