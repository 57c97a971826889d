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

#include "long_rollout.hpp"
#include "scenes.hpp"

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

std::string name_of(const Trial& t) {
    return t.axis_x + " " + std::to_string(t.value_x) + ", " + t.axis_y + " " + std::to_string(t.value_y) + ", " +
           t.method();
}

void add(Tally& tally, const stability::Result& r, const std::string& name) {
    ++tally.cells;
    tally.solvable += r.solvable;
    tally.accurate += r.solvable && r.outcome == Outcome::accurate;
    if (r.outcome == Outcome::silent || r.outcome == Outcome::nan) {
        ++tally.wrong;
        print_message("%s: %s: %s\n", name.c_str(), stability::name_of(r.outcome), r.reason.c_str());
    }
    if (r.outcome == Outcome::reported) CHECK(!r.reason.empty());
}

void finish(const char* what, const Tally& tally) {
    print_message("%s: %d cells, %d with a solution, %d of them accurate\n", what, tally.cells, tally.solvable,
                  tally.accurate);
    CHECK(tally.cells > 0 && tally.wrong == 0);
    CHECK(10 * tally.accurate >= 9 * tally.solvable);
}

// Every n-th cell of the quick map of the library whose axis passes.
template <class Pick>
void sample(const char* what, int every, const Pick& pick) {
    Tally tally;
    int k = 0;
    for (const Trial& trial : stability::mechanics(true))
        if (!trial.reference && pick(trial) && k++ % every == 0) add(tally, stability::run(trial), name_of(trial));
    finish(what, tally);
}

void test_stiffness_and_time_step() {
    sample("stiffness", 8, [](const Trial& t) { return t.axis_x == "young_modulus"; });
}
// A residual under the tolerance is not enough: two bodies whose positions were once off by up to 1.4e-4 under it.
void test_positions_are_known() {
    int seen = 0;
    for (const Trial& trial : stability::mechanics(true)) {
        const bool soft = trial.value_x == 1e4 && trial.method() == "newton_pcg/neo-Hookean bdf2";
        const bool other = trial.value_x == 1e5 && trial.method() == "newton_pcg";
        if (trial.axis_x != "young_modulus" || trial.value_y != 1e-2 || !(soft || other)) continue;
        const stability::Result r = stability::run(trial);
        CHECK(r.outcome == Outcome::accurate && r.steps_done == trial.steps);
        CHECK(r.state_error <= 2e-5);
        ++seen;
    }
    CHECK(seen == 2);
}
void test_actuation() {
    sample("actuation", 4, [](const Trial& t) { return t.axis_x == "contraction"; });
}
void test_currents() {
    sample("currents", 4, [](const Trial& t) { return t.axis_x == "flow" && t.variant != "explicit water"; });
}
void test_void_contrast() {
    sample("void contrast", 3, [](const Trial& t) { return t.axis_x == "occupancy_floor"; });
}
void test_starts() {
    // Not a body in one point: it is reported as such, though a saddle solves its equations.
    sample("initial states", 6,
           [](const Trial& t) { return t.axis_x.rfind("start_", 0) == 0 && t.axis_x != "start_point"; });
}
void test_odd_shapes() {
    sample("odd shapes", 5, [](const Trial& t) {
        return t.axis_x == "fin_one_cell_wide" || t.axis_x == "two_pieces" || t.axis_x == "one_cell" ||
               t.axis_x == "opposite_ends" || t.axis_x == "first_weight";
    });
}

// Supports at opposite ends of the box, kernels from a fifth of a cell to the width of the box; the textbook method
// agrees where it works at all, and is wrong in silence where its kernel underflows.
void test_barycenters() {
    Tally tally;
    int textbook = 0, wrong = 0;
    for (const stability::BarycenterTrial& trial : stability::barycenters(true)) {
        const stability::Result r = stability::run(trial);
        if (trial.reference) {
            textbook += r.outcome == Outcome::accurate;
            wrong += r.outcome == Outcome::silent && trial.sigma <= 0.4 && trial.separation >= 8.0;
        } else {
            CHECK(r.outcome == Outcome::accurate);
            CHECK(stability::check_oracle(trial) <= 1e-9);
            add(tally, r, "sigma " + std::to_string(trial.sigma));
        }
    }
    CHECK(textbook >= 3 && wrong >= 3);
    finish("barycentres", tally);
}

// The textbook method answers what the library does where nothing is extreme: the map judges both by one oracle.
void test_reference() {
    for (const Trial& trial : stability::mechanics(true)) {
        if (!trial.reference || trial.axis_x != "young_modulus" || trial.value_y > 0.1) continue;
        const stability::Result r = stability::run(trial);
        CHECK(r.outcome == Outcome::accurate && r.steps_done == trial.steps);
        CHECK(r.gradient_error > 0.0);
    }
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

void test_point_is_reported() {
    for (const Trial& trial : stability::mechanics(true)) {
        if (trial.axis_x != "start_point" || !trial.variant.empty()) continue;
        const stability::Result r = stability::run(trial);
        CHECK(r.outcome == Outcome::reported && r.reason.find("unfold") != std::string::npos);
    }
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

void test_long_rollout() {
    for (const auto integrator : {dqa::Integrator::implicit_euler, dqa::Integrator::bdf2}) {
        stability::LongRollout trial;
        trial.integrator = integrator;
        const stability::Result r = stability::run(trial);
        print_message("%d steps: %s, momentum drifts by %.1e, gradient off by %.1e\n", r.steps_done, r.reason.c_str(),
                      r.state_error, r.gradient_error);
        CHECK(r.outcome == Outcome::accurate && r.steps_done == trial.steps);
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_oracle),
        TEST(test_stiff_body_turns_right),
        TEST(test_stiffness_and_time_step),
        TEST(test_positions_are_known),
        TEST(test_actuation),
        TEST(test_currents),
        TEST(test_void_contrast),
        TEST(test_starts),
        TEST(test_odd_shapes),
        TEST(test_barycenters),
        TEST(test_reference),
        TEST(test_explicit_water_is_reported),
        TEST(test_point_is_reported),
        TEST(test_long_rollout),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
