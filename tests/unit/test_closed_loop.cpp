// SPDX-License-Identifier: MIT
// What controllers see, and gradients of rollouts whose loop is closed through the sensors: perceptron and callback,
// by every quantity, against finite differences.
#include "control/callback.hpp"
#include "control/perceptron.hpp"
#include "motion/observation.hpp"
#include "motion_fixtures.hpp"
#include "tape/gradient_check.hpp"

namespace {

using namespace fixtures;

const std::shared_ptr<const ShapeSpace>& space() {
    static const auto s = ellipsoid_space({14, 6, 6}, 0.07);
    return s;
}

std::shared_ptr<const Design> design_of(const Vector& weights = {0.6, 0.4},
                                        const std::shared_ptr<const ShapeSpace>& in = space(),
                                        Integrator integrator = Integrator::implicit_euler) {
    SceneSettings scene = tight_scene();
    scene.integrator = integrator;
    scene.hydrodynamics.current = {-0.6, 0.0, 0.0};
    return make_design(scene, weights, in);
}

void test_observation() {
    const auto design = design_of();
    const Vector q = plus(design->rest(), 0.01, swirl(design->rest(), 1.0)), v = swirl(q, 0.5);
    const Vector seen = observe(*design, q.data(), v.data());
    CHECK(seen.size() == 15 && n_observed(*design) == 15);
    const Sensors& s = design->sensors();
    for (std::size_t a = 0; a < 3; ++a) {
        CHECK(seen[a] == s.read(Sensors::head, v.data())[a]);
        CHECK(seen[3 + a] == s.read(Sensors::centre, v.data())[a]);
        CHECK(seen[6 + a] == s.read(Sensors::tail, v.data())[a]);
        const double centre = s.read(Sensors::centre, q.data())[a];
        CHECK(seen[9 + a] == s.read(Sensors::head, q.data())[a] - centre);
        CHECK(seen[12 + a] == s.read(Sensors::tail, q.data())[a] - centre);
    }
    CHECK(seen[9] > 0 && seen[12] < 0);
    // By the state it is linear; by the weights through the places of head and tail.
    Random random{1};
    const Vector w = random_vector(15, random), dq = random_vector(q.size(), random),
                 dv = random_vector(q.size(), random);
    Vector q_bar(q.size(), 0.0), v_bar(q_bar);
    DesignBar bar = design->zero_bar();
    observe_pullback(*design, q.data(), v.data(), w.data(), q_bar.data(), v_bar.data(), bar);
    const auto value = [&](const Vector& x, const Vector& u) {
        return dot_of(w, observe(*design, x.data(), u.data()));
    };
    CHECK_LINEAR_DERIVATIVE([&](double e) { return value(plus(q, e, dq), v); }, dot_of(q_bar, dq), 0.1);
    CHECK_LINEAR_DERIVATIVE([&](double e) { return value(q, plus(v, e, dv)); }, dot_of(v_bar, dv), 0.1);
    // The same fields read at other places of head and tail, which the weights move.
    const auto moved = [&](int which, std::size_t velocity, std::size_t offset, double e) {
        Vec3 x = s.point(which).rest;
        x[0] += e;
        const MaterialPoint p = locate(design->set(), x, 1, false);
        double sum = 0.0;
        for (std::size_t n = 0; n < 8; ++n)
            for (std::size_t a = 0; a < 3; ++a) {
                const std::size_t at = 3 * static_cast<std::size_t>(p.node[n]) + a;
                sum += p.weight[n] * (w[velocity + a] * v[at] + w[offset + a] * q[at]);
            }
        return sum;
    };
    CHECK_LINEAR_DERIVATIVE([&](double e) { return moved(Sensors::head, 0, 9, e); }, bar.head_x, 1e-3);
    CHECK_LINEAR_DERIVATIVE([&](double e) { return moved(Sensors::tail, 6, 12, e); }, bar.tail_x, 1e-3);
    report_worst("observation");
}

// A stretch reflex with a rhythm: u = tanh(theta_0 sin(theta_1 t) + theta_2 lateral velocity of the tail + theta_3
// offset of the tail).
std::int32_t reflex(std::int64_t, double time, const double* s, std::int64_t, const double* theta, std::int64_t,
                    double* actuation, std::int64_t, void*) {
    actuation[0] = std::tanh(theta[0] * std::sin(theta[1] * time + 0.3) + theta[2] * s[7] + theta[3] * s[13]);
    return 0;
}
std::int32_t reflex_pullback(std::int64_t, double time, const double* s, std::int64_t, const double* theta,
                             std::int64_t, const double* bar, std::int64_t, double* theta_bar, double* sensors_bar,
                             void*) {
    const double phase = theta[1] * time + 0.3;
    const double y = std::tanh(theta[0] * std::sin(phase) + theta[2] * s[7] + theta[3] * s[13]);
    const double b = bar[0] * (1.0 - y * y);
    theta_bar[0] = b * std::sin(phase), theta_bar[1] = b * theta[0] * time * std::cos(phase);
    theta_bar[2] = b * s[7], theta_bar[3] = b * s[13];
    sensors_bar[7] = b * theta[2], sensors_bar[13] = b * theta[3];
    return 0;
}

CallbackSettings reflex_settings() {
    CallbackSettings s;
    s.n_sensors = 15, s.evaluate = reflex, s.pullback = reflex_pullback;
    return s;
}

void check_all(const char* name, const Controller& controller, const std::shared_ptr<const Design>& design) {
    Simulation s(design);
    const Vector v = swirl(s.q(), 0.3);
    s.set_state(nullptr, v.data());
    for (int k = 0; k < 2; ++k) advance(s, actuation_of(controller, s), nullptr);  // in motion, at clock 2
    for (int quantity = 0; quantity < 5; ++quantity) {
        GradientCheckSettings settings;
        settings.quantity = static_cast<WithRespectTo>(quantity);
        settings.n_steps = 4;
        settings.seed = 3;
        const GradientCheckReport r = check_gradient(s, &controller, {{}}, settings);
        print_message("%-10s quantity %d: adjoint % .6e, error %.1e, slope %.3f\n", name, quantity, r.adjoint,
                      r.relative_error, r.taylor_slope);
        CHECK(r.gradient_norm > 0 && r.adjoint != 0.0);
        CHECK(r.relative_error <= 1e-6);
        NEAR(r.taylor_slope, 2.0, 0.1);
    }
}

void test_perceptron() {
    PerceptronSettings s;
    s.hidden = {16, 12}, s.seed = 5, s.scale = 1.5;
    check_all("perceptron", Perceptron(s), design_of());
}

void test_callback() {
    check_all("callback", CallbackController(reflex_settings(), {0.9, 11.0, 1.4, 6.0}), design_of({0.3, 0.7}));
}

// In two dimensions the sensor vector has ten numbers.
void test_in_the_plane() {
    PerceptronSettings s;
    s.hidden = {16, 12}, s.seed = 6, s.scale = 1.5, s.dims = 2;
    const auto design = design_of({0.6, 0.4}, plane_space());
    CHECK(n_observed(*design) == 10);
    const Vector v = swirl(design->rest(), 1.0), seen = observe(*design, design->rest().data(), v.data());
    CHECK(seen.size() == 10 && seen[6] > 0 && seen[8] < 0);
    CHECK(seen[1] == design->sensors().read(Sensors::head, v.data())[1] && seen[5] != 0.0);
    check_all("plane", Perceptron(s), design);
}

// The integrator with memory, and a sweep that crosses its first step.
void test_two_steps() {
    PerceptronSettings s;
    s.hidden = {16, 12}, s.seed = 7, s.scale = 1.5;
    check_all("BDF2", Perceptron(s), design_of({0.6, 0.4}, space(), Integrator::bdf2));
}

std::shared_ptr<Tape> recorded(const Controller& controller, int n_steps) {
    Simulation s(design_of());
    auto tape = std::make_shared<Tape>(0);
    tape->set_controller(controller);
    for (int k = 0; k < n_steps; ++k) advance(s, actuation_of(controller, s), tape.get());
    return tape;
}

// The loop matters: with the sensors' part cut off the gradient is another one.
void test_the_loop_is_closed() {
    const CallbackController closed(reflex_settings(), {0.9, 11.0, 1.4, 6.0});
    const auto tape = recorded(closed, 5);
    Adjoint adjoint(tape);
    adjoint.seed_objective({{}});
    adjoint.backward(0, nullptr);
    auto open_tape = std::make_shared<Tape>(0);
    Simulation s(design_of());
    for (int k = 0; k < 5; ++k) advance(s, tape->actuation(k), open_tape.get());
    Adjoint open(open_tape);
    open.seed_objective({{}});
    open.backward(0, nullptr);
    CHECK(relative_difference(adjoint.velocity_bar(), open.velocity_bar()) > 1e-4);
    CHECK(relative_difference(adjoint.actuation_bar(), open.actuation_bar()) > 1e-4);
    CHECK(adjoint.actuation_bar().back() == open.actuation_bar().back());  // nothing reacts after the last step
}

struct Switch {
    std::int32_t result = 0;
};
std::int32_t failing(std::int64_t step, double time, const double* s, std::int64_t ns, const double* theta,
                     std::int64_t n, const double* bar, std::int64_t nu, double* theta_bar, double* sensors_bar,
                     void* user_data) {
    const std::int32_t result = static_cast<Switch*>(user_data)->result;
    if (result != 0 && step == 2) return result;
    return reflex_pullback(step, time, s, ns, theta, n, bar, nu, theta_bar, sensors_bar, nullptr);
}

// A pullback that fails leaves the sweep where it was; going on gives the same bits as never having failed.
void test_failure_in_the_sweep() {
    Switch on;
    CallbackSettings settings = reflex_settings();
    settings.pullback = failing, settings.user_data = &on;
    const auto tape = recorded(CallbackController(settings, {0.9, 11.0, 1.4, 6.0}), 4);
    const auto result = [](Adjoint& a) {
        Vector out;
        for (const Vector& part :
             {a.weights_bar(), a.control_bar(), a.actuation_bar(), a.position_bar(), a.velocity_bar()})
            out.insert(out.end(), part.begin(), part.end());
        return out;
    };
    Adjoint whole(tape), stopped(tape);
    whole.seed_objective({{}}), stopped.seed_objective({{}});
    whole.backward(0, nullptr);
    on.result = 8;
    EXPECT_ERROR(CANCELLED, "pullback callback returned 8 at step 2", stopped.backward(0, nullptr));
    CHECK(stopped.position() == 3);
    on.result = 0;
    stopped.backward(0, nullptr);
    CHECK(result(stopped) == result(whole));
}

std::int32_t rhythm(std::int64_t, double time, const double* s, std::int64_t ns, const double* theta, std::int64_t,
                    double* actuation, std::int64_t, void*) {
    CHECK(!s && ns == 0);
    actuation[0] = theta[0] * std::sin(theta[1] * time);
    return 0;
}

void test_without_pullback() {
    CallbackSettings settings = reflex_settings();
    settings.pullback = nullptr;
    const auto closed = recorded(CallbackController(settings, {0.9, 11.0, 1.4, 6.0}), 2);
    EXPECT_ERROR(ERROR_STATE, "loop through the sensors cannot be closed", Adjoint{closed});
    settings.evaluate = rhythm, settings.n_sensors = 0;
    const auto open = recorded(CallbackController(settings, {0.8, 11.0}), 3);
    Adjoint adjoint(open);
    adjoint.seed_objective({{}});
    adjoint.backward(0, nullptr);
    CHECK(norm_of(adjoint.actuation_bar()) > 0 && norm_of(adjoint.weights_bar()) > 0);
    EXPECT_ERROR(ERROR_STATE, "CONTROL", adjoint.control_bar());
}

// Forward and backward, parameters of the perceptron included.
void test_threads_give_the_same_bits() {
    const auto run = [](int threads) {
        SceneSettings scene;
        scene.threads = threads;
        Simulation s(make_design(scene, {0.6, 0.4}, space()));
        const Perceptron controller{PerceptronSettings{}};
        auto tape = std::make_shared<Tape>(0);
        tape->set_controller(controller);
        for (int k = 0; k < 4; ++k) advance(s, actuation_of(controller, s), tape.get());
        Adjoint adjoint(tape);
        adjoint.seed_objective({{}});
        adjoint.backward(0, nullptr);
        Vector out(s.q());
        for (const Vector& part : {s.v(), adjoint.weights_bar(), adjoint.control_bar(), adjoint.actuation_bar()})
            out.insert(out.end(), part.begin(), part.end());
        return out;
    };
    const Vector one = run(1);
    CHECK(all_finite(one) && run(2) == one && run(3) == one);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_observation),          TEST(test_perceptron),       TEST(test_callback),
        TEST(test_in_the_plane),         TEST(test_two_steps),        TEST(test_the_loop_is_closed),
        TEST(test_failure_in_the_sweep), TEST(test_without_pullback), TEST(test_threads_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
