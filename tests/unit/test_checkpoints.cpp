// SPDX-License-Identifier: MIT
// Tapes with a memory budget: the same bits as without one, whatever it is, within the budget, at the cost that
// binomial checkpointing promises, and without asking the controller again.
#include <map>
#include <thread>

#include "control/callback.hpp"
#include "motion_fixtures.hpp"
#include "tape/adjoint.hpp"

namespace {

using namespace fixtures;

constexpr int kSteps = 23;

std::shared_ptr<const Design> design_of(Integrator integrator) {
    static const auto space = ellipsoid_space({12, 5, 5}, 0.08);
    SceneSettings scene;
    scene.integrator = integrator;
    scene.hydrodynamics.current = {-0.5, 0.0, 0.0};
    return make_design(scene, {0.6, 0.4}, space);
}

// ---------------------------------------------------------------- the schedule

// Forward steps that reading l states backwards takes with s slots, by the rule under test and at best.
long cost(long l, long s) {
    if (l <= 1 || s == 0) return l * (l + 1) / 2;
    const long left = checkpoint_after(l, s);
    CHECK(left >= 1 && left < l);
    return left + cost(l - left, s - 1) + cost(left - 1, s);
}
long best(long l, long s) {
    static std::map<std::pair<long, long>, long> known;
    if (l <= 1 || s == 0) return l * (l + 1) / 2;
    long& value = known[{l, s}];
    if (value == 0) {
        value = l * (l + 1) / 2;
        for (long left = 1; left < l; ++left) value = std::min(value, left + best(l - left, s - 1) + best(left - 1, s));
    }
    return value;
}

void test_schedule() {
    for (long l = 2; l <= 60; ++l)
        for (long s = 1; s <= 12; ++s) CHECK(cost(l, s) == best(l, s));
    CHECK(cost(50, 49) == 50 && cost(50, 100) == 50);  // room for all: each once
    CHECK(cost(10000, 20) < 4 * 10000);
    CHECK(checkpoint_after(1000000000L, 1) > 1);
}

// ---------------------------------------------------------------- bits

Vector all_of(Adjoint& a) {
    Vector out;
    for (const Vector& part : {a.weights_bar(), a.actuation_bar(), a.position_bar(), a.velocity_bar(),
                               a.tape().controller() ? a.control_bar() : Vector{}})
        out.insert(out.end(), part.begin(), part.end());
    return out;
}

void seed(Adjoint& a) {
    a.seed_objective({{}});
    Vector bar(a.tape().design().rest().size());
    for (const long k : {0L, 5L, 6L, 16L, 22L}) {
        for (std::size_t i = 0; i < bar.size(); ++i)
            bar[i] = std::cos(0.3 * static_cast<double>(i) + 0.1 * static_cast<double>(k));
        a.seed_position(k, bar.data());
        a.seed_velocity(k + 1, bar.data());
    }
}

Vector gradients(const std::shared_ptr<Tape>& tape) {
    Adjoint a(tape);
    seed(a);
    a.backward(0, nullptr);
    return all_of(a);
}

std::int64_t bytes_of_states(const Design& design, double n) {
    const double fields = design.scene().integrator == Integrator::bdf2 ? 4 : 2;
    return static_cast<std::int64_t>(8.0 * fields * n * static_cast<double>(design.rest().size())) +
           kSteps * (8 * (design.n_signals() + 3) + 144);
}

int& calls() {
    static int n = 0;
    return n;
}
std::int32_t reflex(std::int64_t, double time, const double* s, std::int64_t, const double* theta, std::int64_t,
                    double* actuation, std::int64_t, void*) {
    ++calls();
    actuation[0] = std::tanh(theta[0] * std::sin(11.0 * time + 0.3) + theta[1] * s[7]);
    return 0;
}
std::int32_t reflex_back(std::int64_t, double time, const double* s, std::int64_t, const double* theta, std::int64_t,
                         const double* bar, std::int64_t, double* theta_bar, double* sensors_bar, void*) {
    const double y = std::tanh(theta[0] * std::sin(11.0 * time + 0.3) + theta[1] * s[7]), b = bar[0] * (1.0 - y * y);
    theta_bar[0] = b * std::sin(11.0 * time + 0.3), theta_bar[1] = b * s[7], sensors_bar[7] = b * theta[1];
    return 0;
}

std::shared_ptr<Tape> roll(const std::shared_ptr<const Design>& design, std::int64_t memory_bytes) {
    CallbackSettings settings;
    settings.n_sensors = 15, settings.evaluate = reflex, settings.pullback = reflex_back;
    const CallbackController controller(settings, {0.9, 1.2});
    Simulation s(design);
    const Vector v = swirl(s.q(), 0.3);
    s.set_state(nullptr, v.data());
    advance(s, {0.2}, nullptr);  // the tape's clock does not begin at 0, nor its state at a restart
    auto tape = std::make_shared<Tape>(memory_bytes);
    tape->set_controller(controller);
    for (int k = 0; k < kSteps; ++k) {
        advance(s, actuation_of(controller, s), tape.get());
        CHECK(tape->continues(s));
        if (memory_bytes > 0) CHECK(tape->statistics().bytes <= memory_bytes);
    }
    return tape;
}

void check_budgets(Integrator integrator) {
    const auto design = design_of(integrator);
    const auto full = roll(design, 0);
    CHECK(full->n_kept() == kSteps + 1 && full->recomputed_steps() == 0);
    const Vector expected = gradients(full);
    CHECK(all_finite(expected) && norm_of(expected) > 0 && full->recomputed_steps() == 0);
    std::int64_t before = 1 << 30;
    for (const double states : {40.0, 12.5, 11.5, 9.0, 6.0, 5.0, 4.0}) {
        const auto tape = roll(design, bytes_of_states(*design, states));
        const int asked = calls();
        CHECK(gradients(tape) == expected);
        CHECK(calls() == asked);
        const std::int64_t once = tape->recomputed_steps();
        print_message("%s, room for %4.1f states: keeps %2d, %3d steps again\n",
                      integrator == Integrator::bdf2 ? "BDF2" : "Euler", states, static_cast<int>(tape->n_kept()),
                      static_cast<int>(once));
        CHECK((once == 0) == (tape->n_kept() == kSteps + 1));
        CHECK(tape->n_kept() <= before);
        before = tape->n_kept();
        CHECK(gradients(tape) == expected && tape->recomputed_steps() == 2 * once);
    }
    // With the least budget the whole way is taken again for every step.
    CHECK(before == 2);
}

void test_euler() {
    check_budgets(Integrator::implicit_euler);
}
void test_bdf2() {
    check_budgets(Integrator::bdf2);
}

// States in any order, and again and again.
void test_random_reads() {
    for (const Integrator integrator : {Integrator::implicit_euler, Integrator::bdf2}) {
        const auto design = design_of(integrator);
        const auto full = roll(design, 0), thin = roll(design, bytes_of_states(*design, 7.0));
        TapeReader reader(*thin);
        Random random{4};
        for (int k = 0; k < 40; ++k) {
            const long step = std::min<long>(kSteps, static_cast<long>(between(random, 0.0, kSteps + 1.0)));
            CHECK(reader.state(step) == full->state(step));
        }
        CHECK(thin->state(13) == full->state(13) && thin->q(2) == full->q(2) && thin->v(2) == full->v(2));
        // Forwards each dropped state costs one step.
        const std::int64_t count = thin->recomputed_steps();
        TapeReader forwards(*thin);
        for (long k = 0; k <= kSteps; ++k) CHECK(forwards.state(k) == full->state(k));
        CHECK(thin->recomputed_steps() - count == kSteps + 1 - thin->n_kept());
        reader.reset();
        CHECK(reader.state(13) == full->state(13));
    }
}

// Sweeps that stop and are resumed, several of them at once on one tape, on several threads.
void test_many_adjoints() {
    const auto design = design_of(Integrator::implicit_euler);
    const Vector expected = gradients(roll(design, 0));
    const auto tape = roll(design, bytes_of_states(*design, 8.0));
    Adjoint one(tape), two(tape);
    seed(one), seed(two);
    for (const long to : {22L, 17L, 16L, 9L, 3L, 0L}) {
        one.backward(to, nullptr);
        two.backward(std::max(0L, to - 2), nullptr);
    }
    CHECK(all_of(one) == expected && all_of(two) == expected);
    Vector results[3];
    std::vector<std::thread> threads;
    for (Vector& r : results) threads.emplace_back([&r, &tape] { r = gradients(tape); });
    for (std::thread& t : threads) t.join();
    for (const Vector& r : results) CHECK(r == expected);
}

// Several tapes of one simulation, one after another on the same rollout.
void test_many_tapes() {
    const auto design = design_of(Integrator::bdf2);
    Simulation s(design);
    auto first = std::make_shared<Tape>(bytes_of_states(*design, 6.0)), second = std::make_shared<Tape>(0);
    for (int k = 0; k < 20; ++k) {
        Tape* tape = k < 10 ? first.get() : second.get();
        CHECK(tape->continues(s));
        advance(s, {std::sin(0.5 * k)}, tape);
    }
    CHECK(!first->continues(s) && second->continues(s));
    CHECK(first->state(10) == second->state(0));
    Adjoint a(first), b(second);
    a.seed_objective({{}}), b.seed_objective({{}});
    a.backward(0, nullptr), b.backward(0, nullptr);
    CHECK(norm_of(a.weights_bar()) > 0 && norm_of(b.weights_bar()) > 0);
}

// A sweep that is asked to stop within a step that is computed again goes on afterwards.
void test_cancelled_on_the_way() {
    static const auto space = ellipsoid_space({12, 5, 5}, 0.08);
    SceneSettings scene;
    scene.cancel = std::make_shared<std::atomic<int>>(0);
    const auto design = make_design(scene, {0.6, 0.4}, space);
    const auto full = roll(design, 0), thin = roll(design, bytes_of_states(*design, 5.0));
    const Vector expected = gradients(full);
    Adjoint a(thin);
    seed(a);
    const StepMonitor stop = [&](long done, long) { scene.cancel->store(done % 3 == 2 ? 1 : 0); };
    int stops = 0;
    while (a.position() > 0) try {
            a.backward(0, stop);
        } catch (const Error& e) {
            CHECK(e.status() == Status::CANCELLED);
            scene.cancel->store(0);
            ++stops;
        }
    CHECK(stops > 2 && all_of(a) == expected);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_schedule),
        TEST(test_euler),
        TEST(test_bdf2),
        TEST(test_random_reads),
        TEST(test_many_adjoints),
        TEST(test_many_tapes),
        TEST(test_cancelled_on_the_way),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
