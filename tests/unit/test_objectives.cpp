// SPDX-License-Identifier: MIT
// Objectives: their values written down once more, the pullback of the hydrodynamic totals, and the gradient of every
// kind by every quantity against finite differences, alone and as a weighted sum, also on a tape that dropped states.
#include "control/perceptron.hpp"
#include "motion_fixtures.hpp"
#include "tape/gradient_check.hpp"

namespace {

using namespace fixtures;

const std::shared_ptr<const ShapeSpace>& space() {
    static const auto s = ellipsoid_space({14, 6, 6}, 0.07);
    return s;
}

std::shared_ptr<const Design> design_of(Integrator integrator = Integrator::implicit_euler,
                                        const std::shared_ptr<const ShapeSpace>& in = space(),
                                        const Vector& weights = {0.6, 0.4}) {
    SceneSettings scene = tight_scene();
    scene.integrator = integrator;
    scene.hydrodynamics.current = {-0.6, 0.1, 0.0};
    return make_design(scene, weights, in);
}

ObjectiveTerm term_of(ObjectiveKind kind, double weight = 1.0) {
    ObjectiveTerm t;
    t.kind = kind, t.weight = weight;
    t.target = {0.15, -0.04, 0.06};
    t.epsilon = kind == ObjectiveKind::efficiency ? 1e-2 : 1e-3;
    if (kind == ObjectiveKind::position_keeping) t.gamma = 0.05;
    if (kind == ObjectiveKind::path) t.path = {{0.05, {0.0, 0.0, 0.0}}, {0.11, {0.1, 0.05, -0.02}}, {0.5, {0, 0.3, 0}}};
    return t;
}

constexpr ObjectiveKind kKinds[] = {ObjectiveKind::travel, ObjectiveKind::position_keeping, ObjectiveKind::efficiency,
                                    ObjectiveKind::effort, ObjectiveKind::path};
constexpr const char* kNames[] = {"travel", "keeping", "efficiency", "effort", "path"};

Simulation moving(const std::shared_ptr<const Design>& design, const Controller& controller) {
    Simulation s(design);
    const Vector v = swirl(s.q(), 0.3);
    s.set_state(nullptr, v.data());
    for (int k = 0; k < 2; ++k) advance(s, actuation_of(controller, s), nullptr);
    return s;
}

PerceptronSettings small_net() {
    PerceptronSettings s;
    s.hidden = {12, 8}, s.seed = 5, s.scale = 1.5;
    return s;
}

void test_values() {
    const Perceptron controller(small_net());
    Simulation s = moving(design_of(), controller);
    const Design& design = s.design();
    Tape tape(0);
    const double h = design.scene().time_step, eps = 1e-3;
    const auto size = [](double x, double e) { return std::sqrt(x * x + e * e) - e; };
    double keeping = 0.0, efficiency = 0.0, effort = 0.0, path = 0.0;
    const Vector first = s.q();
    for (int k = 0; k < 5; ++k) {
        const Vector a = actuation_of(controller, s);
        effort += h * a[0] * a[0];
        advance(s, a, &tape);
        const Vec3 c = design.sensors().read(Sensors::centre, s.q().data()),
                   front = design.sensors().read(Sensors::head, s.q().data()),
                   rear = design.sensors().read(Sensors::tail, s.q().data());
        keeping += size(c[0] - 0.15, eps) + size(c[1] + 0.04, eps) + size(c[2] - 0.06, eps);
        keeping -= 0.05 * (front[0] - rear[0]);
        Vec3 velocity{};
        double weight = 0.0;
        for (std::size_t n = 0; n < design.spine().size(); ++n) {
            weight += design.spine()[n];
            for (std::size_t x = 0; x < 3; ++x) velocity[x] += design.spine()[n] * s.v()[3 * n + x];
        }
        double thrust = 0.0, drag = 0.0;
        for (std::size_t x = 0; x < 3; ++x) {
            thrust += s.forces().mean_thrust[x] * velocity[x] / weight;
            drag += s.forces().mean_drag[x] * velocity[x] / weight;
        }
        efficiency -= size(thrust, 1e-2) / (1.0 + size(thrust, 1e-2) + size(drag, 1e-2));
        const double t = s.time();  // 3/30 ... 7/30 s: on the second and the third piece of the path
        const double r = t < 0.11 ? (t - 0.05) / 0.06 : (t - 0.11) / 0.39;
        const Vec3 p = t < 0.11 ? Vec3{0.1 * r, 0.05 * r, -0.02 * r}
                                : Vec3{0.1 * (1 - r), 0.05 * (1 - r) + 0.3 * r, -0.02 * (1 - r)};
        path += size(std::sqrt(std::pow(c[0] - p[0], 2) + std::pow(c[1] - p[1], 2) + std::pow(c[2] - p[2], 2)), eps);
    }
    std::vector<ObjectiveTerm> terms;
    for (const ObjectiveKind kind : kKinds) terms.push_back(term_of(kind, 1.0 + static_cast<double>(terms.size())));
    double parts[5];
    const double loss = tape.objective(terms, parts);
    NEAR(parts[0], travel_loss(design, first.data(), s.q().data()), 0.0);
    NEAR(parts[1], keeping, 1e-14 * std::fabs(keeping));
    NEAR(parts[2], efficiency, 1e-12 * std::fabs(efficiency));
    NEAR(parts[3], effort, 1e-14 * effort);
    NEAR(parts[4], path, 1e-12 * path);
    NEAR(loss, parts[0] + 2 * parts[1] + 3 * parts[2] + 4 * parts[3] + 5 * parts[4], 1e-13);
    CHECK(effort > 1e-3 && efficiency < -1e-3 && path > 0.05);
    // Before and after the path.
    ObjectiveTerm still = term_of(ObjectiveKind::path);
    still.path = {{10.0, {1.0, 2.0, 3.0}}, {11.0, {0.0, 0.0, 0.0}}};
    Observed o;
    NEAR(state_value(still, design, o, 2.0), std::sqrt(14.0), 1.1e-3);
    NEAR(state_value(still, design, o, 10.5), std::sqrt(14.0) / 2, 1.1e-3);
    CHECK(state_value(still, design, o, 12.0) == 0.0);
}

// Totals of one step against its old state, its new state and the water's velocity, on their own.
void test_totals() {
    for (const Integrator integrator : {Integrator::implicit_euler, Integrator::bdf2}) {
        const auto design = design_of(integrator);
        Simulation s = moving(design, Perceptron(small_net()));
        const State now = s.state();
        Stepper stepper(design);
        const double signal = 0.4;
        State next, scratch;
        const StepInput input{&signal, {-0.6, 0.1, 0.0}};
        stepper.step(now, input, 0, next);
        Random random{11};
        WaterTotals bar;
        for (Vec3* v : {&bar.drag, &bar.thrust, &bar.mean_drag, &bar.mean_thrust})
            for (double& x : *v) x = random();
        const auto value = [&](const State& from, const State& to, const Vec3& current) {
            // The totals belong to the last step taken: one with the same lagged coefficients, whatever its end.
            stepper.step(from, {&signal, current}, 0, scratch);
            const WaterTotals t = stepper.totals(to);
            double sum = 0.0;
            for (std::size_t k = 0; k < 3; ++k)
                sum += bar.drag[k] * t.drag[k] + bar.thrust[k] * t.thrust[k] + bar.mean_drag[k] * t.mean_drag[k] +
                       bar.mean_thrust[k] * t.mean_thrust[k];
            return sum;
        };
        State next_bar;
        next_bar.q.assign(now.q.size(), 0.0);
        StepBar out;
        DesignBar design_bar = design->zero_bar();
        stepper.totals_pullback(now, input, next, bar, next_bar, out, design_bar);
        CHECK(norm_of(design_bar.occupancy) > 0 && design_bar.head_x != 0.0);
        const Vector dq = random_vector(now.q.size(), random, 0.002), dv = random_vector(now.q.size(), random, 0.1);
        const auto by_old = [&](double e) {
            State from = now;
            from.q = plus(now.q, e, dq);
            return value(from, next, input.current);
        };
        CHECK_DERIVATIVE(by_old, dot_of(out.state.q, dq), 0.2);
        const auto by_velocity = [&](double e) {
            State from = now;
            from.v = plus(now.v, e, dv);
            return value(from, next, input.current);
        };
        CHECK_DERIVATIVE(by_velocity, dot_of(out.state.v, dv), 0.1);
        const auto by_new = [&](double e) {
            State to = next;
            to.q = plus(next.q, e, dq);
            return value(now, to, input.current);
        };
        CHECK_LINEAR_DERIVATIVE(by_new, dot_of(next_bar.q, dq), 0.2);
        const auto by_current = [&](double e) { return value(now, next, {-0.6 + e, 0.1 - 2 * e, 0.3 * e}); };
        CHECK_DERIVATIVE(by_current, out.current[0] - 2 * out.current[1] + 0.3 * out.current[2], 0.05);
        if (integrator != Integrator::bdf2) continue;
        const auto by_before = [&](double e) {
            State from = now;
            from.q_before = plus(now.q_before, e, dq), from.v_before = plus(now.v_before, e, dv);
            return value(from, next, input.current);
        };
        CHECK_DERIVATIVE(by_before, dot_of(out.state.q_before, dq) + dot_of(out.state.v_before, dv), 0.05);
    }
    report_worst("totals");
}

void check_all(const char* name, const Simulation& s, const Controller& controller,
               const std::vector<ObjectiveTerm>& terms, double weights_step) {
    for (int quantity = 0; quantity < 6; ++quantity) {
        GradientCheckSettings settings;
        settings.quantity = static_cast<WithRespectTo>(quantity);
        settings.n_steps = 3;
        settings.seed = 4;
        if (quantity == 0) settings.step = weights_step;
        const GradientCheckReport r = check_gradient(s, &controller, terms, settings);
        print_message("%-10s quantity %d: adjoint % .6e, error %.1e, slope %.3f\n", name, quantity, r.adjoint,
                      r.relative_error, r.taylor_slope);
        CHECK(r.gradient_norm > 0 && r.adjoint != 0.0);
        CHECK(r.relative_error <= 1e-6);
        NEAR(r.taylor_slope, 2.0, 0.1);
    }
}

void test_gradients() {
    const Perceptron controller(small_net());
    const Simulation s = moving(design_of(), controller);
    for (std::size_t k = 1; k < 5; ++k) check_all(kNames[k], s, controller, {term_of(kKinds[k])}, 8e-3);
}

std::vector<ObjectiveTerm> sum_of_all() {
    std::vector<ObjectiveTerm> all;
    for (const ObjectiveKind kind : kKinds) all.push_back(term_of(kind, kind == ObjectiveKind::travel ? -2.0 : 0.5));
    return all;
}

void test_sum_in_two_steps() {
    const Perceptron controller(small_net());
    check_all("sum, BDF2", moving(design_of(Integrator::bdf2, space(), {0.3, 0.7}), controller), controller,
              sum_of_all(), 2e-3);
}

void test_sum_in_the_plane() {
    PerceptronSettings settings = small_net();
    settings.dims = 2;
    const Perceptron controller(settings);
    check_all("sum, plane", moving(design_of(Integrator::implicit_euler, plane_space()), controller), controller,
              sum_of_all(), 2e-3);
}

// Seeds are the same bits whatever the tape keeps and wherever the sweep stops; several calls add up.
void test_seeds() {
    const auto design = design_of(Integrator::bdf2);
    const Perceptron controller(small_net());
    const auto run = [&](double states, bool in_pieces) {
        Simulation s = moving(design, controller);
        const std::int64_t bytes = static_cast<std::int64_t>(states * 8.0 * 4.0 * static_cast<double>(s.q().size()));
        auto tape = std::make_shared<Tape>(states > 0 ? bytes + 9 * (8 + 168) : 0);
        tape->set_controller(controller);
        for (int k = 0; k < 9; ++k) advance(s, actuation_of(controller, s), tape.get());
        Adjoint a(tape);
        if (in_pieces) {
            for (const ObjectiveTerm& t : sum_of_all()) a.seed_objective({t});
            for (const long to : {9L, 6L, 5L, 1L}) a.backward(to, nullptr);
        } else {
            a.seed_objective(sum_of_all());
        }
        a.backward(0, nullptr);
        CHECK((tape->recomputed_steps() > 0) == (states > 0));
        Vector out = {tape->objective(sum_of_all(), nullptr)};
        for (const Vector& part :
             {a.weights_bar(), a.control_bar(), a.actuation_bar(), a.position_bar(), a.velocity_bar()})
            out.insert(out.end(), part.begin(), part.end());
        return out;
    };
    const Vector expected = run(0, false);
    CHECK(all_finite(expected));
    CHECK(run(0, true) == expected && run(4, false) == expected && run(5, true) == expected);
}

void test_efficiency_needs_water() {
    SceneSettings scene;
    scene.water = false;
    Simulation s(make_design(scene, {0.6, 0.4}, space()));
    auto tape = std::make_shared<Tape>(0);
    advance(s, {0.3}, tape.get());
    EXPECT_ERROR(ERROR_ARGUMENT, "terms[1] is the efficiency",
                 tape->objective({{}, term_of(ObjectiveKind::efficiency)}, nullptr));
    Adjoint a(tape);
    EXPECT_ERROR(ERROR_ARGUMENT, "terms[0] is the efficiency", a.seed_objective({term_of(ObjectiveKind::efficiency)}));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_values),
        TEST(test_totals),
        TEST(test_gradients),
        TEST(test_sum_in_two_steps),
        TEST(test_sum_in_the_plane),
        TEST(test_seeds),
        TEST(test_efficiency_needs_water),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
