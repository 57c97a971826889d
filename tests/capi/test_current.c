/* SPDX-License-Identifier: MIT
 * Currents over time: from options, tables and callbacks; on tapes; their gradients; and the water's variants. */
#include "scene.h"

static dqa_controller* controller;

static int open_driven_scene(void** state) {
    (void)open_scene(state);
    controller = tiny_controller(simulator);
    return 0;
}

static int close_driven_scene(void** state) {
    dqa_controller_free(controller);
    return close_scene(state);
}

enum { STEPS = 4 };

static dqa_tape* swim(dqa_simulator* swimmer) {
    dqa_tape* tape = NULL;
    ok(dqa_tape_create(swimmer, NULL, &tape));
    ok(dqa_simulator_set_state(swimmer, NULL, 0, NULL, 0));
    ok(dqa_simulator_rollout(swimmer, controller, STEPS, tape, NULL, NULL));
    return tape;
}

static double travel_of(dqa_tape* tape) {
    dqa_objective_term term;
    double loss = 0.0;
    ok(dqa_objective_term_init(&term, sizeof term));
    ok(dqa_tape_objective(tape, &term, 1, &loss, NULL));
    return loss;
}

/* A gust that knows how often it was asked, and collects dL/d(strength) through its pullback. */
typedef struct gust {
    double strength, strength_bar;
    int calls, pullbacks, stop_call, stop_pullback;
    double last_time;
} gust;

static int32_t blow(double time, double* current, void* user_data) {
    gust* g = user_data;
    assert_true(current[0] == 0.0 && current[1] == 0.0 && current[2] == 0.0);
    current[0] = -g->strength * cos(5.0 * time);
    current[1] = 0.1 * g->strength;
    return ++g->calls == g->stop_call;
}

static int32_t blow_back(double time, const double* current_bar, void* user_data) {
    gust* g = user_data;
    assert_true(g->pullbacks == 0 || time < g->last_time);
    g->last_time = time;
    g->strength_bar += -cos(5.0 * time) * current_bar[0] + 0.1 * current_bar[1];
    return ++g->pullbacks == g->stop_pullback;
}

static void table_is_interpolated(void** state) {
    const double times[3] = {0.0, 1.0 / 30.0, 3.0 / 30.0}, rows[9] = {-0.1, 0, 0, -0.3, 0.2, 0, -0.5, 0, 0.4};
    const double expected[STEPS][3] = {{-0.1, 0, 0}, {-0.3, 0.2, 0}, {-0.4, 0.1, 0.2}, {-0.5, 0, 0.4}};
    dqa_tape* tape;
    double c[3];
    int k, a;
    (void)state;
    ok(dqa_simulator_set_current_table(simulator, times, 3, rows, 9));
    tape = swim(simulator);
    for (k = 0; k < STEPS; ++k) {
        ok(dqa_tape_get_current(tape, k, c, 3));
        for (a = 0; a < 3; ++a) assert_true(fabs(c[a] - expected[k][a]) < 1e-12);
    }
    refused(dqa_tape_get_current(tape, STEPS, c, 3), DQA_ERROR_ARGUMENT, "step");
    refused(dqa_tape_get_current(tape, 0, c, 2), DQA_ERROR_ARGUMENT, "n");
    refused(dqa_tape_get_current(tape, 0, NULL, 3), DQA_ERROR_ARGUMENT, "current");
    dqa_tape_free(tape);
}

/* A constant table, a constant callback and the options say the same in the same bits; taking them away brings back
 * the options' current; a new design keeps them. */
static void same_current_same_bits(void** state) {
    const double time = 7.0, row[3] = {-0.2, 0.05, 0.0};
    dqa_simulator_options options;
    dqa_simulator* in_current = NULL;
    dqa_tape *a, *b;
    double still, moving;
    (void)state;
    ok(dqa_simulator_options_init(&options, sizeof options));
    memcpy(options.current, row, sizeof row);
    ok(dqa_simulator_create(space, &options, &in_current));
    ok(dqa_simulator_set_weights(in_current, HALF, N_BASES, NULL, NULL));
    a = swim(in_current);
    moving = travel_of(a);
    ok(dqa_simulator_set_current_table(simulator, &time, 1, row, 3));
    ok(dqa_simulator_set_weights(simulator, HALF, N_BASES, NULL, NULL));
    b = swim(simulator);
    assert_true(travel_of(b) == moving);
    dqa_tape_free(b);
    ok(dqa_simulator_set_current_table(simulator, NULL, 0, NULL, 0));
    b = swim(simulator);
    still = travel_of(b);
    assert_true(still != moving);
    dqa_tape_free(b);
    ok(dqa_simulator_set_current_table(simulator, &time, 1, row, 3));
    ok(dqa_simulator_set_current_callback(simulator, NULL, NULL, NULL));
    b = swim(simulator);
    assert_true(travel_of(b) == still);
    dqa_tape_free(b);
    dqa_tape_free(a);
    dqa_simulator_free(in_current);
}

static double loss_in_gust(gust* g) {
    dqa_tape* tape = swim(simulator);
    const double loss = travel_of(tape);
    g->calls = 0;
    dqa_tape_free(tape);
    return loss;
}

/* The callback is asked once a step and not by the adjoint; its pullback gives the derivative by a parameter of the
 * caller's. */
static void callback_and_pullback(void** state) {
    gust g = {0.3, 0.0, 0, 0, 0, 0, 0.0};
    dqa_objective_term term;
    dqa_tape* tape;
    dqa_adjoint* adjoint = NULL;
    double by_step[STEPS][3], water[12], sum[3] = {0}, table[3];
    double difference;
    int k, a;
    (void)state;
    ok(dqa_objective_term_init(&term, sizeof term));
    ok(dqa_simulator_set_current_callback(simulator, blow, blow_back, &g));
    tape = swim(simulator);
    assert_int_equal(g.calls, STEPS);
    ok(dqa_adjoint_create(tape, &adjoint));
    ok(dqa_adjoint_seed_objective(adjoint, &term, 1));
    refused(dqa_adjoint_get(adjoint, DQA_WRT_WATER, water, 12), DQA_ERROR_STATE, "sweep");
    g.stop_pullback = 2; /* cancels after the second step; the sweep goes on from there */
    assert_int_equal(dqa_adjoint_backward(adjoint, 0, NULL, NULL), DQA_CANCELLED);
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    assert_int_equal(g.calls, STEPS);
    assert_int_equal(g.pullbacks, STEPS);
    ok(dqa_adjoint_get(adjoint, DQA_WRT_CURRENT, by_step[0], 3 * STEPS));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_WATER, water, 12));
    for (k = 0; k < STEPS; ++k)
        for (a = 0; a < 3; ++a) sum[a] += by_step[k][a];
    for (a = 0; a < 3; ++a) assert_true(fabs(sum[a] - water[a]) <= 1e-12 * fabs(sum[0]));
    for (k = 3; k < 12; ++k) assert_true(water[k] != 0.0);
    refused(dqa_adjoint_get(adjoint, DQA_WRT_CURRENT_TABLE, table, 3), DQA_ERROR_STATE, "CURRENT_TABLE");
    refused(dqa_adjoint_get(adjoint, DQA_WRT_WATER, water, 11), DQA_ERROR_ARGUMENT, "n");
    refused(dqa_adjoint_get(adjoint, DQA_WRT_CURRENT, by_step[0], 3), DQA_ERROR_ARGUMENT, "n");
    dqa_adjoint_free(adjoint);
    dqa_tape_free(tape);
    g.strength = 0.3 + 1e-3;
    difference = loss_in_gust(&g);
    g.strength = 0.3 - 1e-3;
    difference = (difference - loss_in_gust(&g)) / 2e-3;
    assert_true(fabs(difference - g.strength_bar) <= 1e-3 * fabs(difference)); /* steps converge to 1e-6 only */
    /* Cancelled by the callback: the state and the tape are those after the last complete step. */
    g.stop_call = 3;
    ok(dqa_tape_create(simulator, NULL, &tape));
    ok(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0));
    assert_int_equal(dqa_simulator_rollout(simulator, controller, STEPS, tape, NULL, NULL), DQA_CANCELLED);
    {
        int64_t recorded = 0;
        ok(dqa_tape_n_steps(tape, &recorded));
        assert_int_equal(recorded, 2);
    }
    dqa_tape_free(tape);
    /* Not a number from the callback is an error of the argument, not of the motion. */
    g.strength = NAN;
    g.stop_call = 0;
    refused(dqa_simulator_rollout(simulator, controller, 1, NULL, NULL, NULL), DQA_ERROR_ARGUMENT, "callback");
    ok(dqa_simulator_set_current_callback(simulator, NULL, NULL, NULL));
}

static void table_gradient(void** state) {
    const double times[2] = {0.0, 0.2}, rows[6] = {-0.1, 0.02, 0, -0.4, 0.1, 0.03};
    dqa_objective_term term;
    dqa_gradient_check_options options;
    dqa_gradient_check_report report;
    double gradient[6];
    dqa_tape* tape;
    dqa_adjoint* adjoint = NULL;
    (void)state;
    ok(dqa_objective_term_init(&term, sizeof term));
    ok(dqa_simulator_set_current_table(simulator, times, 2, rows, 6));
    tape = swim(simulator);
    ok(dqa_adjoint_create(tape, &adjoint));
    ok(dqa_adjoint_seed_objective(adjoint, &term, 1));
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_CURRENT_TABLE, gradient, 6));
    assert_true(gradient[0] != 0.0 && gradient[3] != 0.0);
    dqa_adjoint_free(adjoint);
    dqa_tape_free(tape);
    ok(dqa_gradient_check_options_init(&options, sizeof options));
    options.n_steps = 3;
    for (options.with_respect_to = DQA_WRT_WATER; options.with_respect_to <= DQA_WRT_CURRENT_TABLE;
         ++options.with_respect_to) {
        ok(dqa_check_gradient(simulator, NULL, &term, 1, &options, &report, sizeof report));
        if (!(report.relative_error < 1e-6 && report.gradient_norm > 0.0))
            fail_msg("quantity %d: relative error %.2g", options.with_respect_to, report.relative_error);
    }
    ok(dqa_simulator_set_current_table(simulator, NULL, 0, NULL, 0));
}

static void bad_tables(void** state) {
    double times[2] = {0.0, 0.0}, rows[6] = {0};
    (void)state;
    refused(dqa_simulator_set_current_table(NULL, times, 2, rows, 6), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_set_current_callback(NULL, blow, NULL, NULL), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_set_current_table(simulator, times, 2, rows, 6), DQA_ERROR_ARGUMENT, "times");
    times[1] = 1.0;
    refused(dqa_simulator_set_current_table(simulator, NULL, 2, rows, 6), DQA_ERROR_ARGUMENT, "times");
    refused(dqa_simulator_set_current_table(simulator, times, 2, NULL, 6), DQA_ERROR_ARGUMENT, "velocities");
    refused(dqa_simulator_set_current_table(simulator, times, -1, rows, 6), DQA_ERROR_ARGUMENT, "n_times");
    refused(dqa_simulator_set_current_table(simulator, times, 2, rows, 4), DQA_ERROR_ARGUMENT, "n");
    rows[5] = INFINITY;
    refused(dqa_simulator_set_current_table(simulator, times, 2, rows, 6), DQA_ERROR_ARGUMENT, "velocities");
}

/* The variants for comparison swim too, and differently. */
static void variants(void** state) {
    double travel[3];
    int k;
    (void)state;
    for (k = 0; k < 3; ++k) {
        dqa_simulator_options options;
        dqa_simulator* swimmer = NULL;
        dqa_tape* tape;
        ok(dqa_simulator_options_init(&options, sizeof options));
        assert_int_equal(options.water_faces, DQA_FACES_BOTH);
        options.current[0] = -0.1;
        if (k == 1) options.water = DQA_WATER_EXPLICIT;
        if (k == 2) options.water_faces = DQA_FACES_WINDWARD;
        ok(dqa_simulator_create(space, &options, &swimmer));
        ok(dqa_simulator_set_weights(swimmer, HALF, N_BASES, NULL, NULL));
        tape = swim(swimmer);
        travel[k] = travel_of(tape);
        dqa_tape_free(tape);
        dqa_simulator_free(swimmer);
    }
    assert_true(travel[0] != travel[1] && travel[0] != travel[2] && travel[1] != travel[2]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table_is_interpolated),
        cmocka_unit_test(same_current_same_bits),
        cmocka_unit_test(callback_and_pullback),
        cmocka_unit_test(table_gradient),
        cmocka_unit_test(bad_tables),
        cmocka_unit_test(variants),
    };
    return cmocka_run_group_tests_name("current", tests, open_driven_scene, close_driven_scene);
}
