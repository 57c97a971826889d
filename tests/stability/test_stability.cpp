// SPDX-License-Identifier: MIT
// Never wrong in silence: the quick cells of the stability map, and the cases in which other swimmers' simulators fail.
// Rows that have a test elsewhere:
//   full actuation, h up to 1/3; E = 5e8 and 5e4; mirrored body   unit/test_motion_failures
//   water along a face normal; uniform initial velocity            unit/test_water, unit/test_water_states
//   reflections have energy, R is a rotation                       unit/test_rotation
//   scene far from the origin                                      unit/test_motion (test_translation_invariance)
//   line search exhausted is a failure, the state stays            unit/test_motion_failures (test_max_newton)
//   mass of the body                                               unit/test_motion (test_design)
//   sigma small or large, supports far apart, mass lost, stopping  unit/test_barycenter, unit/test_barycenter_pullback
//   normalisation by the peak                                      unit/test_occupancy
#include <cmath>

#include "scenes.hpp"
#include "tape/tape.hpp"

// cmocka last: it defines fail() as a macro.
#include "../unit/shape_fixtures.hpp"

namespace {

using namespace fixtures;
using stability::Outcome;
using stability::Trial;
using stability::Vector;

struct Tally {
    int cells = 0, solvable = 0, accurate = 0, wrong = 0;
};

void add(Tally& tally, const Trial& trial) {
    const stability::Result r = stability::run(trial);
    ++tally.cells;
    tally.solvable += r.solvable;
    tally.accurate += r.solvable && r.outcome == Outcome::accurate;
    if (r.outcome == Outcome::silent || r.outcome == Outcome::nan) {
        ++tally.wrong;
        print_message("%s %g, %s %g, %s: %s: %s\n", trial.axis_x.c_str(), trial.value_x, trial.axis_y.c_str(),
                      trial.value_y, trial.method().c_str(), stability::name_of(r.outcome), r.reason.c_str());
    }
    if (r.outcome == Outcome::reported) CHECK(!r.reason.empty());
}

void finish(const char* what, const Tally& tally) {
    print_message("%s: %d cells, %d with a solution, %d of them accurate\n", what, tally.cells, tally.solvable,
                  tally.accurate);
    CHECK(tally.cells > 0 && tally.wrong == 0);
    CHECK(10 * tally.accurate >= 9 * tally.solvable);
}

// Every n-th cell of the quick map whose axis passes.
template <class Pick>
void sample(const char* what, int every, const Pick& pick) {
    Tally tally;
    int k = 0;
    for (const Trial& trial : stability::mechanics(true))
        if (pick(trial) && k++ % every == 0) add(tally, trial);
    finish(what, tally);
}

void test_stiffness_and_time_step() {
    sample("stiffness", 3, [](const Trial& t) { return t.axis_x == "young_modulus" && t.value_x >= 1e6; });
}
void test_actuation() {
    sample("actuation", 3, [](const Trial& t) { return t.axis_x == "contraction"; });
}
void test_currents() {
    sample("currents", 2, [](const Trial& t) { return t.axis_x == "flow" && t.variant != "explicit water"; });
}
void test_void_contrast() {
    sample("void contrast", 2, [](const Trial& t) { return t.axis_x == "occupancy_floor"; });
}
void test_starts() {
    sample("initial states", 4,
           [](const Trial& t) { return t.axis_x.rfind("start_", 0) == 0; });
}
void test_odd_shapes() {
    sample("odd shapes", 5, [](const Trial& t) {
        return t.axis_x == "fin_one_cell_wide" || t.axis_x == "two_pieces" || t.axis_x == "one_cell" ||
               t.axis_x == "opposite_ends" || t.axis_x == "first_weight";
    });
}

// The public code's silent blow-up: explicit water under a long step. Here a status says so.
void test_explicit_water_is_reported() {
    int reported = 0;
    for (const Trial& trial : stability::mechanics(false)) {
        if (trial.axis_x != "flow" || trial.variant != "explicit water" || trial.value_x < 10.0 || trial.value_y < 0.09)
            continue;
        const stability::Result r = stability::run(trial);
        CHECK(r.outcome == Outcome::reported);
        CHECK(r.reason.find("explicit water") != std::string::npos);
        ++reported;
    }
    CHECK(reported == 3);
}

// The oracle's gradient is that of its own rollouts.
void test_oracle() {
    Trial trial;
    trial.space = stability::small_space();
    for (const auto material : {dqa::Material::corotated, dqa::Material::neo_hookean}) {
        trial.scene.material = material;
        const double error = stability::check_oracle(trial);
        print_message("oracle's gradient against differences: %.1e\n", error);
        CHECK(error <= 1e-6);
    }
}

// The whole-body balance: a stiff body over a long step turns as the exact solution does.
void test_stiff_body_turns_right() {
    Trial trial;
    trial.space = stability::small_space();
    trial.scene.young_modulus = 1e9;
    trial.scene.time_step = 0.5;
    const stability::Result r = stability::run(trial);
    CHECK(r.steps_done == trial.steps && r.state_error <= 1e-5);
}

// Ten thousand steps of one cell's body without water: no energy is made, no momentum lost.
void test_long_rollout() {
    for (const auto integrator : {dqa::Integrator::implicit_euler, dqa::Integrator::bdf2}) {
        dqa::SceneSettings scene;
        scene.water = false;
        scene.integrator = integrator;
        scene.time_step = 1e-3;
        const auto design = std::make_shared<dqa::Design>(stability::cell_space(), Vector{0.5, 0.5}, scene, nullptr);
        dqa::Simulation simulation(design);
        Vector v(design->rest().size());
        for (std::size_t i = 0; i < v.size(); i += 3) {
            const double *x = &design->rest()[i], shape[3] = {x[1], -x[0], 0.0};
            for (std::size_t a = 0; a < 3; ++a) v[i + a] = 0.2 + 4.0 * shape[a] + 2.0 * x[a];
        }
        simulation.set_state(nullptr, v.data());
        const auto momentum = [&](std::size_t axis) {
            double p = 0.0;
            for (std::size_t n = 0; n < design->mass().size(); ++n)
                p += design->mass()[n] * simulation.v()[3 * n + axis];
            return p;
        };
        const auto energy = [&] {
            dqa::BodyWorkspace ws;
            Vector elastic(v.size()), muscle(v.size());
            const Vector none(static_cast<std::size_t>(design->n_signals()), 0.0);
            double e =
                design->body().gradient(ws, simulation.q().data(), none.data(), 1, elastic.data(), muscle.data());
            for (std::size_t i = 0; i < v.size(); ++i)
                e += 0.5 * design->mass()[i / 3] * simulation.v()[i] * simulation.v()[i];
            return e;
        };
        const Vector signals(static_cast<std::size_t>(design->n_signals()), 0.0);
        const double first = energy(), start[3] = {momentum(0), momentum(1), momentum(2)};
        double last = first, drift = 0.0;
        for (int k = 1; k <= 10000; ++k) {
            dqa::advance(simulation, signals, nullptr);
            if (k % 100) continue;
            const double now = energy();
            CHECK(std::isfinite(now) && now <= last * (1.0 + 1e-6));
            last = now;
        }
        for (std::size_t a = 0; a < 3; ++a) drift = std::max(drift, std::fabs(momentum(a) / start[a] - 1.0));
        print_message("10,000 steps: energy falls to %.4f, momentum drifts by %.1e\n", last / first, drift);
        CHECK(drift <= 1e-5);
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_oracle),
        TEST(test_stiff_body_turns_right),
        TEST(test_stiffness_and_time_step),
        TEST(test_actuation),
        TEST(test_currents),
        TEST(test_void_contrast),
        TEST(test_starts),
        TEST(test_odd_shapes),
        TEST(test_explicit_water_is_reported),
        TEST(test_long_rollout),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
