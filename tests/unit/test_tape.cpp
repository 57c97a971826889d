// SPDX-License-Identifier: MIT
// The tape and its backward sweep: objective, seeds of the caller's own loss at any step, resuming, and what a tape
// refuses.
#include "control/controller.hpp"
#include "motion_fixtures.hpp"
#include "tape/adjoint.hpp"

namespace {

using namespace fixtures;

const std::shared_ptr<const ShapeSpace>& space() {
    static const auto s = ellipsoid_space({16, 6, 8}, 0.06);
    return s;
}

std::shared_ptr<const Design> design_of(const SceneSettings& scene, const Vector& weights = {0.6, 0.4}) {
    return make_design(scene, weights, space());
}

SceneSettings exact_scene() {
    SceneSettings scene = tight_scene();
    scene.tolerance = 1e-13;
    scene.shape_tolerance = 1e-13;
    scene.hydrodynamics.current = {-0.5, 0.0, 0.0};
    return scene;
}

constexpr int kSteps = 5;

// A rollout from this state with these actuations.
std::shared_ptr<Tape> roll(const std::shared_ptr<const Design>& design, const Vector& q, const Vector& v,
                           const Vector& signals) {
    Simulation s(design);
    s.set_state(q.data(), v.data());
    auto tape = std::make_shared<Tape>(0);
    for (const double a : signals) advance(s, {a}, tape.get());
    return tape;
}

const Vector kSignals = {0.4, 0.9, -0.2, -0.8, 0.5};

void test_objective() {
    const auto design = design_of(exact_scene());
    Random random{1};
    const std::size_t n = design->rest().size();
    const Vector first = plus(design->rest(), 0.01, random_vector(n, random)),
                 last = plus(first, 0.1, random_vector(n, random));
    // A translation by d has the loss -d_x.
    Vector moved(first);
    for (std::size_t i = 0; i < n; i += 3) moved[i] += 0.25, moved[i + 1] -= 3;
    NEAR(travel_loss(*design, first.data(), moved.data()), -0.25, 1e-15);
    Vector first_bar(n, 0.0), last_bar(n, 0.0), spine_bar(n / 3, 0.0);
    travel_pullback(*design, first.data(), last.data(), 3.0, first_bar.data(), last_bar.data(), spine_bar.data());
    const Vector d = random_vector(n, random);
    CHECK_LINEAR_DERIVATIVE([&](double e) { return 3.0 * travel_loss(*design, plus(first, e, d).data(), last.data()); },
                            dot_of(first_bar, d), 0.1);
    CHECK_LINEAR_DERIVATIVE([&](double e) { return 3.0 * travel_loss(*design, first.data(), plus(last, e, d).data()); },
                            dot_of(last_bar, d), 0.1);
    // By the spine's weights, from the definition.
    const Vector ds = random_vector(n / 3, random);
    double by_spine = 0.0;
    for (std::size_t k = 0; k < n / 3; ++k) by_spine += spine_bar[k] * ds[k] * design->spine()[k];
    const auto loss = [&](double e) {
        double sum = 0.0, weight = 0.0;
        for (std::size_t k = 0; k < n / 3; ++k) {
            const double w = design->spine()[k] * (1.0 + e * ds[k]);
            sum += w * (last[3 * k] - first[3 * k]), weight += w;
        }
        return -3.0 * sum / weight;
    };
    CHECK_DERIVATIVE(loss, by_spine, 0.1);
    report_worst("objective");
}

// A loss of the caller: linear and quadratic in positions and velocities at several steps, the first and last included.
struct OwnLoss {
    std::vector<Vector> a, b;  // per state: of positions (against rest), of velocities
    explicit OwnLoss(std::size_t n) : a(kSteps + 1), b(kSteps + 1) {
        Random random{2};
        for (const long k : {0L, 2L, 3L, static_cast<long>(kSteps)})
            a[static_cast<std::size_t>(k)] = random_vector(n, random);
        for (const long k : {0L, 1L, static_cast<long>(kSteps)})
            b[static_cast<std::size_t>(k)] = random_vector(n, random);
    }
    static double term(const Vector& w, const Vector& x) {
        double s = 0.0;
        for (std::size_t i = 0; i < w.size(); ++i) s += w[i] * (x[i] + 0.5 * x[i] * x[i]);
        return s;
    }
    static Vector seed(const Vector& w, const Vector& x) {
        Vector s(w);
        for (std::size_t i = 0; i < w.size(); ++i) s[i] *= 1.0 + x[i];
        return s;
    }
    double operator()(const Tape& t) const {
        double s = 0.0;
        for (long k = 0; k <= kSteps; ++k) {
            s += term(a[static_cast<std::size_t>(k)], plus(t.q(k), -1.0, t.design().rest()));
            s += term(b[static_cast<std::size_t>(k)], t.v(k));
        }
        return s;
    }
    void seed_into(Adjoint& adjoint, long k) const {
        const Tape& t = adjoint.tape();
        const Vector &wa = a[static_cast<std::size_t>(k)], &wb = b[static_cast<std::size_t>(k)];
        if (!wa.empty()) adjoint.seed_position(k, seed(wa, plus(t.q(k), -1.0, t.design().rest())).data());
        if (!wb.empty()) adjoint.seed_velocity(k, seed(wb, t.v(k)).data());
    }
};

// A third of the states' tolerance, less by how stiff the body is, and over a long rollout, where what adjoints leave
// unsolved must not add up.
void test_tolerance_of_adjoints() {
    SceneSettings scene;
    NEAR(scene.adjoint_tolerance_over(0), 3e-7, 1e-22);
    NEAR(scene.adjoint_tolerance_over(100), 3e-7, 1e-22);
    NEAR(scene.adjoint_tolerance_over(10000), 3e-9, 1e-22);
    NEAR(scene.adjoint_tolerance_over(10000, 0.5), 1.5e-9, 1e-22);
    NEAR(scene.adjoint_tolerance_over(10000, 1e-4), 3e-10, 1e-22);
    NEAR(scene.adjoint_tolerance_over(1000000000), 1e-12, 0.0);
    scene.tolerance = 1e-2;
    NEAR(scene.adjoint_tolerance_over(3), 3e-3, 1e-18);
    scene.adjoint_tolerance = 1e-5;
    NEAR(scene.adjoint_tolerance_over(10000), 1e-5, 0.0);

    SceneSettings loose;
    loose.tolerance = 1e-3, loose.hydrodynamics.current = {-0.5, 0.0, 0.0};
    const auto design = design_of(loose);
    const Vector q = design->rest(), v(q.size(), 0.0);
    for (const std::size_t steps : {std::size_t{10}, std::size_t{400}}) {
        const double allowed = steps == 10 ? 1e-3 : 2.5e-4;
        const auto tape = roll(design, q, v, Vector(steps, 0.5));
        Adjoint adjoint(tape);
        adjoint.seed_objective({ObjectiveTerm{}});
        adjoint.backward(0, nullptr);
        CHECK(adjoint.worst_residual() <= allowed && adjoint.worst_residual() > 0.01 * allowed);
    }
}

void test_own_loss() {
    const auto design = design_of(exact_scene());
    const Vector q = plus(design->rest(), 0.002, swirl(design->rest(), 1.0)), v = swirl(q, 0.4);
    const auto tape = roll(design, q, v, kSignals);
    const OwnLoss loss(q.size());
    Adjoint adjoint(tape);
    for (long k = 0; k <= kSteps; ++k) loss.seed_into(adjoint, k);
    adjoint.backward(0, nullptr);
    CHECK(adjoint.position() == 0 && adjoint.worst_residual() <= 1e-12 && adjoint.iterations() > kSteps);
    Random random{3};
    const Vector dq = random_vector(q.size(), random, 0.003), dv = random_vector(q.size(), random, 0.3),
                 da = random_vector(kSteps, random);
    const double base = loss(*tape);
    CHECK_DERIVATIVE([&](double e) { return loss(*roll(design, plus(q, e, dq), v, kSignals)) - base; },
                     dot_of(adjoint.position_bar(), dq), 0.1);
    CHECK_DERIVATIVE([&](double e) { return loss(*roll(design, q, plus(v, e, dv), kSignals)) - base; },
                     dot_of(adjoint.velocity_bar(), dv), 0.05);
    CHECK_DERIVATIVE([&](double e) { return loss(*roll(design, q, v, plus(kSignals, e, da))) - base; },
                     dot_of(adjoint.actuation_bar(), da), 0.1);
    report_worst("own loss");
}

// In one go, in pieces, with seeds given just before the sweep comes by, and with a monitor that stops it half-way.
void test_resuming_gives_the_same_bits() {
    const auto design = design_of(SceneSettings{});
    const auto tape = roll(design, design->rest(), swirl(design->rest(), 0.4), kSignals);
    const OwnLoss loss(design->rest().size());
    const auto result = [](Adjoint& adjoint) {
        Vector out(adjoint.position_bar());
        for (const Vector& part : {adjoint.velocity_bar(), adjoint.actuation_bar(), adjoint.weights_bar()})
            out.insert(out.end(), part.begin(), part.end());
        return out;
    };
    Adjoint whole(tape);
    for (long k = 0; k <= kSteps; ++k) loss.seed_into(whole, k);
    whole.backward(0, nullptr);
    const Vector expected = result(whole);
    CHECK(norm_of(expected) > 0);

    Adjoint pieces(tape);
    for (long k = 0; k <= kSteps; ++k) loss.seed_into(pieces, k);
    pieces.backward(kSteps, nullptr);
    for (const long to : {4L, 4L, 1L, 0L}) pieces.backward(to, nullptr);
    CHECK(result(pieces) == expected);

    Adjoint late(tape);
    loss.seed_into(late, kSteps);
    for (long k = kSteps; k > 0; --k) {
        late.backward(k, nullptr);
        loss.seed_into(late, k - 1);
    }
    late.backward(0, nullptr);
    CHECK(result(late) == expected);

    Adjoint here(tape);  // seeds for the state that the sweep stands at
    here.backward(kSteps, nullptr);
    for (long k = kSteps; k >= 0; --k) {
        here.backward(k, nullptr);
        loss.seed_into(here, k);
    }
    CHECK(result(here) == expected);

    Adjoint stopped(tape);
    for (long k = 0; k <= kSteps; ++k) loss.seed_into(stopped, k);
    std::vector<long> heard;
    const StepMonitor monitor = [&](long done, long total) {
        CHECK(total == kSteps);
        heard.push_back(done);
        if (done == 2) throw Error(Status::CANCELLED, "enough");
    };
    EXPECT_ERROR(CANCELLED, "enough", stopped.backward(0, monitor));
    CHECK((heard == std::vector<long>{1, 2}) && stopped.position() == kSteps - 2);
    stopped.backward(0, nullptr);
    CHECK(result(stopped) == expected);
    EXPECT_ERROR(ERROR_STATE, "already begun", stopped.seed_objective({{}}));
}

// Weights bar is mean-free, and the objective's seeds equal the caller's own of the same loss.
void test_objective_seeds() {
    const auto design = design_of(exact_scene());
    const auto tape = roll(design, design->rest(), swirl(design->rest(), 0.4), kSignals);
    Adjoint built_in(tape), own(tape);
    built_in.seed_objective({{ObjectiveKind::travel, 2.0}, {ObjectiveKind::travel, 0.5}});
    double parts[2];
    const double loss = tape->objective({{ObjectiveKind::travel, 2.0}, {ObjectiveKind::travel, 0.5}}, parts);
    NEAR(loss, 2.5 * parts[0], 1e-15);
    CHECK(parts[0] == parts[1] && parts[0] != 0.0);
    double weight = 0.0;
    for (const double w : design->spine()) weight += w;
    Vector first(design->rest().size(), 0.0), last(first);
    for (std::size_t n = 0; n < first.size(); n += 3)
        last[n] = -2.5 * design->spine()[n / 3] / weight, first[n] = -last[n];
    own.seed_position(0, first.data()), own.seed_position(kSteps, last.data());
    built_in.backward(0, nullptr), own.backward(0, nullptr);
    NEAR(relative_difference(built_in.position_bar(), own.position_bar()), 0.0, 1e-9);
    NEAR(relative_difference(built_in.actuation_bar(), own.actuation_bar()), 0.0, 1e-9);
    const Vector bar = built_in.weights_bar();
    CHECK(bar.size() == 2 && std::fabs(bar[0]) > 0);
    NEAR(bar[0] + bar[1], 0.0, 1e-14 * std::fabs(bar[0]));
}

void test_controller_and_clock() {
    const auto design = design_of(exact_scene());
    Sinusoid controller(1, design->scene().time_step);
    controller.set_parameters({0.7, 9.0, 0.4});
    Simulation s(design);
    double a = 0.0;
    controller.evaluate(0, nullptr, &a);
    NEAR(a, 0.7 * std::sin(0.4), 1e-15);
    advance(s, {a}, nullptr);  // not recorded: the tape's clock starts at 1
    auto tape = std::make_shared<Tape>(0);
    tape->set_controller(controller);
    for (int k = 0; k < 4; ++k) {
        controller.evaluate(s.steps(), nullptr, &a);
        advance(s, {a}, tape.get());
        CHECK(tape->continues(s) && tape->n_steps() == k + 1);
    }
    CHECK(tape->first_step() == 1 && tape->v(4) == s.v() && tape->q(4) == s.q());
    Adjoint adjoint(tape);
    adjoint.seed_objective({{}});
    adjoint.backward(0, nullptr);
    const Vector theta = controller.parameters(), bar = adjoint.control_bar(), d = {0.2, 3.0, 1.0};
    const Vector q1 = tape->q(0), v1 = tape->v(0);
    const auto loss = [&](double e) {
        Sinusoid changed(controller);
        changed.assign_parameters(plus(theta, e, d));
        Vector signals;
        for (int k = 1; k <= 4; ++k) changed.evaluate(k, nullptr, &a), signals.push_back(a);
        return roll(design, q1, v1, signals)->objective({{}}, nullptr);
    };
    CHECK_DERIVATIVE(loss, dot_of(bar, d), 0.1);
    controller.set_parameters({0.8, 9.0, 0.4});
    EXPECT_ERROR(ERROR_STATE, "other controller parameters", tape->set_controller(controller));
    advance(s, {0.0}, nullptr);
    CHECK(!tape->continues(s));
    EXPECT_ERROR(ERROR_STATE, "no controller", roll(design, q1, v1, {0.1})->set_controller(controller));
    Adjoint free(roll(design, q1, v1, {0.1}));
    free.backward(0, nullptr);
    EXPECT_ERROR(ERROR_STATE, "not driven by a controller", free.control_bar());
    EXPECT_ERROR(ERROR_ARGUMENT, "theta[0] is 1.5", controller.set_parameters({1.5, 9.0, 0.4}));
    EXPECT_ERROR(ERROR_ARGUMENT, "theta[1]", controller.set_parameters({1.0, std::nan(""), 0.4}));
    CHECK(controller.parameters() == Vector({0.8, 9.0, 0.4}));
    report_worst("controller");
}

void test_memory_and_failures() {
    const auto design = design_of(SceneSettings{});
    const std::int64_t state = 2 * 8 * static_cast<std::int64_t>(design->rest().size()), inputs = 8 * 4 + 144;
    Tape tape(4 * state + 2 * inputs);  // the least, and the inputs of two steps
    Simulation s(design);
    advance(s, {0.1}, &tape);
    advance(s, {0.2}, &tape);
    CHECK(tape.n_steps() == 2 && tape.statistics().bytes <= 4 * state + 2 * inputs);
    const Vector q(s.q());
    EXPECT_ERROR(ERROR_MEMORY, "to record step 2", advance(s, {0.3}, &tape));
    CHECK(s.q() == q && s.steps() == 2 && tape.n_steps() == 2 && tape.continues(s));
    CHECK(tape.statistics().newton_iterations >= 2 && tape.statistics().worst_residual <= 1e-6);
    tape.clear();
    CHECK(tape.empty() && tape.n_steps() == 0 && tape.statistics().bytes == 0 && tape.n_kept() == 0);
    Tape small(4 * state + inputs - 1);
    EXPECT_ERROR(ERROR_MEMORY, "to record step 0", advance(s, {0.3}, &small));
    CHECK(small.empty() && s.steps() == 2);
    // A failed first step leaves no trace.
    SceneSettings scene;
    scene.max_newton = 1;
    Simulation failing(design_of(scene));
    failing.set_state(nullptr, swirl(failing.q(), 3.0).data());
    Tape fresh(0);
    EXPECT_ERROR(NOT_CONVERGED, "step 0", advance(failing, {1.0}, &fresh));
    CHECK(fresh.empty());
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_objective),
        TEST(test_own_loss),
        TEST(test_tolerance_of_adjoints),
        TEST(test_resuming_gives_the_same_bits),
        TEST(test_objective_seeds),
        TEST(test_controller_and_clock),
        TEST(test_memory_and_failures),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
