/* SPDX-License-Identifier: MIT
 * The adjoint: seeds, the sweep in one piece or in several, results, and its refusals. */
#include "scene.h"

enum { STEPS = 4 };

static dqa_tape* tape;
static int64_t n_state;
static int32_t n_signals;

static int open_recorded_scene(void** state) {
    dqa_simulator_info info;
    (void)open_scene(state);
    tape = tiny_tape(simulator, STEPS);
    n_state = state_length(simulator);
    ok(dqa_simulator_get_info(simulator, &info, sizeof info));
    n_signals = info.n_signals;
    return 0;
}

static int close_recorded_scene(void** state) {
    dqa_tape_free(tape);
    return close_scene(state);
}

/* All the gradients of one sweep, behind one another, so that two sweeps compare in one line. */
typedef struct gradients {
    double* all;
    size_t bytes;
    double *weights, *control, *actuation, *position, *velocity;
} gradients;

static gradients get_all(dqa_adjoint* adjoint) {
    gradients g;
    const int64_t n = N_BASES + 3 * n_signals + STEPS * n_signals + 2 * n_state;
    g.all = doubles(n);
    g.bytes = (size_t)n * sizeof(double);
    g.weights = g.all;
    g.control = g.weights + N_BASES;
    g.actuation = g.control + 3 * n_signals;
    g.position = g.actuation + STEPS * n_signals;
    g.velocity = g.position + n_state;
    ok(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, g.weights, N_BASES));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_CONTROL, g.control, 3 * (int64_t)n_signals));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_ACTUATION, g.actuation, STEPS * (int64_t)n_signals));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_INITIAL_POSITION, g.position, n_state));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_INITIAL_VELOCITY, g.velocity, n_state));
    return g;
}

static dqa_adjoint* new_adjoint(void) {
    dqa_adjoint* adjoint = NULL;
    ok(dqa_adjoint_create(tape, &adjoint));
    assert_non_null(adjoint);
    return adjoint;
}

static dqa_objective_term travel(double weight) {
    dqa_objective_term term;
    ok(dqa_objective_term_init(&term, sizeof term));
    term.kind = DQA_OBJECTIVE_TRAVEL;
    term.weight = weight;
    return term;
}

static void null_arguments(void** state) {
    dqa_adjoint* adjoint = new_adjoint();
    dqa_adjoint* none = (dqa_adjoint*)&none;
    const dqa_objective_term term = travel(1.0);
    double* bar = doubles(n_state);
    (void)state;
    refused(dqa_adjoint_create(NULL, &none), DQA_ERROR_ARGUMENT, "tape");
    assert_null(none);
    refused(dqa_adjoint_create(tape, NULL), DQA_ERROR_ARGUMENT, "adjoint");
    refused(dqa_adjoint_seed(NULL, 0, DQA_SEED_POSITION, bar, n_state), DQA_ERROR_ARGUMENT, "adjoint");
    refused(dqa_adjoint_seed(adjoint, 0, DQA_SEED_POSITION, NULL, n_state), DQA_ERROR_ARGUMENT, "bar");
    refused(dqa_adjoint_seed_objective(NULL, &term, 1), DQA_ERROR_ARGUMENT, "adjoint");
    refused(dqa_adjoint_seed_objective(adjoint, NULL, 1), DQA_ERROR_ARGUMENT, "terms");
    refused(dqa_adjoint_backward(NULL, 0, NULL, NULL), DQA_ERROR_ARGUMENT, "adjoint");
    refused(dqa_adjoint_get(NULL, DQA_WRT_WEIGHTS, bar, N_BASES), DQA_ERROR_ARGUMENT, "adjoint");
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    refused(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, NULL, N_BASES), DQA_ERROR_ARGUMENT, "out");
    dqa_adjoint_free(NULL);
    dqa_adjoint_free(adjoint);
    free(bar);
}

static void arguments_are_checked(void** state) {
    dqa_adjoint* adjoint = new_adjoint();
    dqa_objective_term term = travel(1.0);
    double* bar = doubles(n_state + 1);
    (void)state;
    refused(dqa_adjoint_seed(adjoint, -1, DQA_SEED_POSITION, bar, n_state), DQA_ERROR_ARGUMENT, "step");
    refused(dqa_adjoint_seed(adjoint, STEPS + 1, DQA_SEED_POSITION, bar, n_state), DQA_ERROR_ARGUMENT, "step");
    refused(dqa_adjoint_seed(adjoint, 0, 7, bar, n_state), DQA_ERROR_ARGUMENT, "quantity");
    refused(dqa_adjoint_seed(adjoint, 0, DQA_SEED_VELOCITY, bar, n_state - 1), DQA_ERROR_ARGUMENT, "bar|n");
    refused(dqa_adjoint_seed(adjoint, 0, DQA_SEED_VELOCITY, bar, -n_state), DQA_ERROR_ARGUMENT, "bar|n");
    bar[3] = NAN;
    refused(dqa_adjoint_seed(adjoint, 0, DQA_SEED_POSITION, bar, n_state), DQA_ERROR_ARGUMENT, "bar");
    refused(dqa_adjoint_seed_objective(adjoint, &term, 0), DQA_ERROR_ARGUMENT, "n_terms");
    term.kind = -1;
    refused(dqa_adjoint_seed_objective(adjoint, &term, 1), DQA_ERROR_ARGUMENT, "kind");
    term = travel(INFINITY);
    refused(dqa_adjoint_seed_objective(adjoint, &term, 1), DQA_ERROR_ARGUMENT, "weight");
    term.struct_size = 0;
    refused(dqa_adjoint_seed_objective(adjoint, &term, 1), DQA_ERROR_ARGUMENT, "struct_size");
    refused(dqa_adjoint_backward(adjoint, -1, NULL, NULL), DQA_ERROR_ARGUMENT, "to_step");
    refused(dqa_adjoint_backward(adjoint, STEPS + 1, NULL, NULL), DQA_ERROR_ARGUMENT, "to_step");
    refused(dqa_adjoint_get(adjoint, 99, bar, n_state), DQA_ERROR_ARGUMENT, "with_respect_to");

    /* Nothing of what was refused stayed as a seed. */
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_INITIAL_POSITION, bar, n_state));
    for (int64_t i = 0; i < n_state; ++i) assert_true(bar[i] == 0.0);
    refused(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, bar, N_BASES + 1), DQA_ERROR_ARGUMENT, "out|n");
    refused(dqa_adjoint_get(adjoint, DQA_WRT_CONTROL, bar, -1), DQA_ERROR_ARGUMENT, "out|n");
    refused(dqa_adjoint_get(adjoint, DQA_WRT_ACTUATION, bar, 0), DQA_ERROR_ARGUMENT, "out|n");
    refused(dqa_adjoint_get(adjoint, DQA_WRT_INITIAL_POSITION, bar, n_state + 1), DQA_ERROR_ARGUMENT, "out|n");
    refused(dqa_adjoint_get(adjoint, DQA_WRT_INITIAL_VELOCITY, bar, n_state - 3), DQA_ERROR_ARGUMENT, "out|n");
    dqa_adjoint_free(adjoint);
    free(bar);
}

static void order_is_checked(void** state) {
    dqa_adjoint* adjoint = new_adjoint();
    const dqa_objective_term term = travel(1.0);
    double* bar = doubles(n_state);
    (void)state;
    ok(dqa_adjoint_seed_objective(adjoint, &term, 1));
    assert_int_equal(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, bar, N_BASES), DQA_ERROR_STATE);
    ok(dqa_adjoint_backward(adjoint, 2, NULL, NULL));
    assert_int_equal(dqa_adjoint_seed_objective(adjoint, &term, 1), DQA_ERROR_STATE);
    assert_int_equal(dqa_adjoint_seed(adjoint, STEPS, DQA_SEED_POSITION, bar, n_state), DQA_ERROR_STATE);
    assert_int_equal(dqa_adjoint_seed(adjoint, 3, DQA_SEED_VELOCITY, bar, n_state), DQA_ERROR_STATE);
    ok(dqa_adjoint_seed(adjoint, 2, DQA_SEED_VELOCITY, bar, n_state)); /* the step it stands at */
    ok(dqa_adjoint_seed(adjoint, 1, DQA_SEED_POSITION, bar, n_state));
    assert_int_equal(dqa_adjoint_backward(adjoint, 3, NULL, NULL), DQA_ERROR_STATE); /* forwards again? */
    ok(dqa_adjoint_backward(adjoint, 2, NULL, NULL));                                /* already there */
    assert_int_equal(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, bar, N_BASES), DQA_ERROR_STATE);
    assert_int_equal(dqa_adjoint_get(adjoint, DQA_WRT_CONTROL, bar, 3 * (int64_t)n_signals), DQA_ERROR_STATE);
    assert_int_equal(dqa_adjoint_get(adjoint, DQA_WRT_INITIAL_POSITION, bar, n_state), DQA_ERROR_STATE);
    assert_int_equal(dqa_adjoint_get(adjoint, DQA_WRT_INITIAL_VELOCITY, bar, n_state), DQA_ERROR_STATE);
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, bar, N_BASES));
    assert_int_equal(dqa_adjoint_seed(adjoint, 1, DQA_SEED_POSITION, bar, n_state), DQA_ERROR_STATE);

    /* The tape is in use. */
    assert_int_equal(dqa_tape_clear(tape), DQA_ERROR_STATE);
    dqa_adjoint_free(adjoint);
    free(bar);
}

/* One sweep, a sweep with stops, and one cancelled on the way and resumed give the same bits. */
static void sweep_may_stop_and_go_on(void** state) {
    const dqa_objective_term term = travel(1.0);
    dqa_adjoint *whole = new_adjoint(), *parts = new_adjoint(), *cancelled = new_adjoint();
    gradients a, b, c;
    int64_t calls = 0, stop = 2, i;
    double norm = 0.0;
    (void)state;
    ok(dqa_adjoint_seed_objective(whole, &term, 1));
    ok(dqa_adjoint_backward(whole, 0, count_progress, &calls));
    assert_true(calls >= STEPS);
    a = get_all(whole);
    for (i = 0; i < STEPS * n_signals; ++i) norm += a.actuation[i] * a.actuation[i];
    assert_true(norm > 0.0 && isfinite(norm));
    assert_true(fabs(a.weights[0] + a.weights[1]) <= 1e-9 * fabs(a.weights[0]));

    ok(dqa_adjoint_seed_objective(parts, &term, 1));
    for (i = STEPS; i >= 0; --i) ok(dqa_adjoint_backward(parts, i, NULL, NULL));
    b = get_all(parts);
    assert_memory_equal(a.all, b.all, a.bytes);

    ok(dqa_adjoint_seed_objective(cancelled, &term, 1));
    assert_int_equal(dqa_adjoint_backward(cancelled, 0, cancel_when, &stop), DQA_CANCELLED);
    ok(dqa_adjoint_backward(cancelled, 0, NULL, NULL));
    c = get_all(cancelled);
    assert_memory_equal(a.all, c.all, a.bytes);
    dqa_adjoint_free(whole), dqa_adjoint_free(parts), dqa_adjoint_free(cancelled);
    free(a.all), free(b.all), free(c.all);
}

static void expect_close(const double* a, double factor, const double* b, size_t bytes) {
    double scale = 0.0;
    size_t i;
    for (i = 0; i < bytes / sizeof *a; ++i) scale = fmax(scale, fabs(factor * b[i]));
    assert_true(scale > 0.0);
    for (i = 0; i < bytes / sizeof *a; ++i) assert_true(fabs(a[i] - factor * b[i]) <= 1e-6 * scale);
}

/* Twice the same seed is the double seed; seeds at step 0 come out as they went in. */
static void seeds_accumulate(void** state) {
    dqa_adjoint *once = new_adjoint(), *twice = new_adjoint(), *start = new_adjoint();
    gradients a, b, c;
    double* bar = doubles(n_state);
    int64_t i;
    (void)state;
    for (i = 0; i < n_state; ++i) bar[i] = cos(0.3 * (double)i);
    ok(dqa_adjoint_seed(once, STEPS, DQA_SEED_POSITION, bar, n_state));
    ok(dqa_adjoint_seed(once, 2, DQA_SEED_VELOCITY, bar, n_state));
    ok(dqa_adjoint_backward(once, 0, NULL, NULL));
    a = get_all(once);
    for (i = 0; i < 2; ++i) {
        ok(dqa_adjoint_seed(twice, STEPS, DQA_SEED_POSITION, bar, n_state));
        ok(dqa_adjoint_seed(twice, 2, DQA_SEED_VELOCITY, bar, n_state));
    }
    ok(dqa_adjoint_backward(twice, 0, NULL, NULL));
    b = get_all(twice);
    expect_close(b.position, 2.0, a.position, (size_t)n_state * sizeof *bar);
    expect_close(b.actuation, 2.0, a.actuation, (size_t)(STEPS * n_signals) * sizeof *bar);
    expect_close(b.weights, 2.0, a.weights, N_BASES * sizeof *bar);

    ok(dqa_adjoint_seed(start, 0, DQA_SEED_POSITION, bar, n_state));
    ok(dqa_adjoint_backward(start, 0, NULL, NULL));
    c = get_all(start);
    assert_memory_equal(c.position, bar, (size_t)n_state * sizeof *bar);
    for (i = 0; i < n_state; ++i) assert_true(c.velocity[i] == 0.0);
    dqa_adjoint_free(once), dqa_adjoint_free(twice), dqa_adjoint_free(start);
    free(a.all), free(b.all), free(c.all), free(bar);
}

/* A tape recorded without a controller has no control gradient. */
static void control_needs_a_controller(void** state) {
    dqa_tape* own = NULL;
    dqa_adjoint* adjoint = NULL;
    double x[64] = {0};
    (void)state;
    ok(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0));
    ok(dqa_tape_create(simulator, NULL, &own));
    ok(dqa_simulator_step(simulator, x, n_signals, own));
    ok(dqa_adjoint_create(own, &adjoint));
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    assert_int_equal(dqa_adjoint_get(adjoint, DQA_WRT_CONTROL, x, 3 * (int64_t)n_signals), DQA_ERROR_STATE);
    ok(dqa_adjoint_get(adjoint, DQA_WRT_ACTUATION, x, n_signals));
    /* While an adjoint reads it, the record does not grow. */
    assert_int_equal(dqa_simulator_step(simulator, x, n_signals, own), DQA_ERROR_STATE);
    dqa_adjoint_free(adjoint);
    ok(dqa_tape_clear(own));
    dqa_tape_free(own);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(null_arguments),   cmocka_unit_test(arguments_are_checked),
        cmocka_unit_test(order_is_checked), cmocka_unit_test(sweep_may_stop_and_go_on),
        cmocka_unit_test(seeds_accumulate), cmocka_unit_test(control_needs_a_controller),
    };
    return cmocka_run_group_tests_name("adjoint", tests, open_recorded_scene, close_recorded_scene);
}
