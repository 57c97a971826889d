/* SPDX-License-Identifier: MIT
 * The tape: recording, reading back, the objective, and its refusals. */
#include "scene.h"

enum { STEPS = 4 };

static int at_rest(void** state) {
    (void)state;
    ok(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0));
    return 0;
}

static int32_t n_signals(void) {
    dqa_simulator_info info;
    ok(dqa_simulator_get_info(simulator, &info, sizeof info));
    return info.n_signals;
}

/* Steps of a controller and steps of the caller's own do not mix on one tape. */
static void controllers_steps_stay_alone(void** state) {
    dqa_tape* tape = tiny_tape(simulator, 1);
    double u[64] = {0};
    (void)state;
    refused(dqa_simulator_step(simulator, u, n_signals(), tape), DQA_ERROR_STATE, "controller");
    dqa_tape_free(tape);
}

static void null_arguments(void** state) {
    dqa_tape* tape = tiny_tape(simulator, 1);
    dqa_tape* none = (dqa_tape*)&none;
    dqa_tape_statistics statistics;
    dqa_objective_term term;
    double x[64] = {0};
    int64_t n;
    (void)state;
    ok(dqa_objective_term_init(&term, sizeof term));
    refused(dqa_tape_create(NULL, NULL, &none), DQA_ERROR_ARGUMENT, "simulator");
    assert_null(none);
    refused(dqa_tape_create(simulator, NULL, NULL), DQA_ERROR_ARGUMENT, "tape");
    refused(dqa_tape_clear(NULL), DQA_ERROR_ARGUMENT, "tape");
    refused(dqa_tape_n_steps(NULL, &n), DQA_ERROR_ARGUMENT, "tape");
    refused(dqa_tape_n_steps(tape, NULL), DQA_ERROR_ARGUMENT, "n_steps");
    refused(dqa_tape_get_state(NULL, 0, x, 1, NULL, 0), DQA_ERROR_ARGUMENT, "tape");
    refused(dqa_tape_get_actuation(NULL, 0, x, 1), DQA_ERROR_ARGUMENT, "tape");
    refused(dqa_tape_get_actuation(tape, 0, NULL, n_signals()), DQA_ERROR_ARGUMENT, "actuation");
    refused(dqa_tape_get_surface(NULL, 0, x, 3), DQA_ERROR_ARGUMENT, "tape");
    refused(dqa_tape_get_surface(tape, 0, NULL, 3), DQA_ERROR_ARGUMENT, "vertices");
    refused(dqa_tape_stats(NULL, &statistics, sizeof statistics), DQA_ERROR_ARGUMENT, "tape");
    refused(dqa_tape_stats(tape, NULL, sizeof statistics), DQA_ERROR_ARGUMENT, "statistics");
    refused(dqa_tape_objective(NULL, &term, 1, x, NULL), DQA_ERROR_ARGUMENT, "tape");
    refused(dqa_tape_objective(tape, NULL, 1, x, NULL), DQA_ERROR_ARGUMENT, "terms");
    refused(dqa_tape_objective(tape, &term, 1, NULL, NULL), DQA_ERROR_ARGUMENT, "loss");
    dqa_tape_free(NULL);
    dqa_tape_free(tape);
}

/* Every state and actuation read back is that of the simulator at that step, bit by bit. */
static void records_what_happened(void** state) {
    dqa_controller* controller = tiny_controller(simulator);
    dqa_tape* tape = NULL;
    dqa_tape_statistics statistics;
    const int64_t n = state_length(simulator);
    const size_t bytes = (size_t)n * sizeof(double);
    double *q = doubles(n * (STEPS + 1)), *v = doubles(n * (STEPS + 1)), *q2 = doubles(n), *v2 = doubles(n);
    double u[64], u2[64], *vertices, *vertices2;
    int64_t step, n_steps = -1, nv = 0;
    (void)state;
    ok(dqa_tape_create(simulator, NULL, &tape));
    ok(dqa_tape_n_steps(tape, &n_steps));
    assert_int_equal(n_steps, 0);
    ok(dqa_simulator_get_state(simulator, q, n, v, n));
    for (step = 0; step < STEPS; ++step) {
        ok(dqa_controller_evaluate(controller, step, NULL, 0, u, n_signals()));
        ok(dqa_simulator_step(simulator, u, n_signals(), tape));
        ok(dqa_simulator_get_state(simulator, q + n * (step + 1), n, v + n * (step + 1), n));
    }
    ok(dqa_tape_n_steps(tape, &n_steps));
    assert_int_equal(n_steps, STEPS);
    for (step = STEPS; step >= 0; --step) {
        ok(dqa_tape_get_state(tape, step, q2, n, v2, n));
        assert_memory_equal(q + n * step, q2, bytes);
        assert_memory_equal(v + n * step, v2, bytes);
    }
    ok(dqa_tape_get_state(tape, 0, NULL, 0, NULL, 0));
    for (step = 0; step < STEPS; ++step) {
        ok(dqa_controller_evaluate(controller, step, NULL, 0, u, n_signals()));
        ok(dqa_tape_get_actuation(tape, step, u2, n_signals()));
        assert_memory_equal(u, u2, (size_t)n_signals() * sizeof *u);
    }
    ok(dqa_simulator_surface(simulator, NULL, 0, NULL, 0, &nv, NULL));
    vertices = doubles(3 * nv);
    vertices2 = doubles(3 * nv);
    ok(dqa_simulator_surface(simulator, vertices, 3 * nv, NULL, 0, NULL, NULL));
    ok(dqa_tape_get_surface(tape, STEPS, vertices2, 3 * nv));
    assert_memory_equal(vertices, vertices2, 3 * (size_t)nv * sizeof *vertices);
    ok(dqa_tape_stats(tape, &statistics, sizeof statistics));
    assert_int_equal(statistics.struct_size, sizeof statistics);
    assert_int_equal(statistics.steps, STEPS);
    assert_true(statistics.bytes >= (int64_t)(STEPS * bytes));
    assert_true(statistics.newton_iterations >= STEPS && statistics.adjoint_iterations == 0);
    assert_true(statistics.worst_residual <= 1e-6);

    refused(dqa_tape_get_state(tape, -1, q2, n, NULL, 0), DQA_ERROR_ARGUMENT, "step");
    refused(dqa_tape_get_state(tape, STEPS + 1, q2, n, NULL, 0), DQA_ERROR_ARGUMENT, "step");
    refused(dqa_tape_get_state(tape, 0, q2, n - 1, NULL, 0), DQA_ERROR_ARGUMENT, "q|nq");
    refused(dqa_tape_get_state(tape, 0, NULL, 0, v2, n + 1), DQA_ERROR_ARGUMENT, "v|nv");
    refused(dqa_tape_get_actuation(tape, STEPS, u2, n_signals()), DQA_ERROR_ARGUMENT, "step");
    refused(dqa_tape_get_actuation(tape, -1, u2, n_signals()), DQA_ERROR_ARGUMENT, "step");
    refused(dqa_tape_get_actuation(tape, 0, u2, n_signals() + 1), DQA_ERROR_ARGUMENT, "actuation|n");
    refused(dqa_tape_get_surface(tape, STEPS + 1, vertices, 3 * nv), DQA_ERROR_ARGUMENT, "step");
    refused(dqa_tape_get_surface(tape, 0, vertices, 3 * nv - 3), DQA_ERROR_ARGUMENT, "vertices|nv");
    dqa_tape_free(tape);
    dqa_controller_free(controller);
    free(q), free(v), free(q2), free(v2), free(vertices), free(vertices2);
}

static void objective_is_checked(void** state) {
    dqa_tape* tape = tiny_tape(simulator, STEPS);
    dqa_objective_term terms[2];
    double loss = NAN, two = NAN, per_term[2] = {NAN, NAN};
    (void)state;
    ok(dqa_objective_term_init(&terms[0], sizeof *terms));
    terms[0].kind = DQA_OBJECTIVE_TRAVEL;
    terms[0].weight = 1.0;
    terms[1] = terms[0];
    terms[1].weight = 0.5;
    ok(dqa_tape_objective(tape, terms, 1, &loss, NULL));
    ok(dqa_tape_objective(tape, terms, 2, &two, per_term));
    assert_true(isfinite(loss) && loss != 0.0);
    assert_true(fabs(two - 1.5 * loss) <= 1e-14 * fabs(loss));
    assert_true(per_term[0] == loss && per_term[1] == loss);

    refused(dqa_tape_objective(tape, terms, 0, &loss, NULL), DQA_ERROR_ARGUMENT, "n_terms");
    refused(dqa_tape_objective(tape, terms, -1, &loss, NULL), DQA_ERROR_ARGUMENT, "n_terms");
    terms[1].kind = 99;
    refused(dqa_tape_objective(tape, terms, 2, &loss, NULL), DQA_ERROR_ARGUMENT, "kind");
    terms[1] = terms[0];
    terms[1].weight = NAN;
    refused(dqa_tape_objective(tape, terms, 2, &loss, NULL), DQA_ERROR_ARGUMENT, "weight");
    terms[1] = terms[0];
    terms[1].struct_size = 8;
    refused(dqa_tape_objective(tape, terms, 2, &loss, NULL), DQA_ERROR_ARGUMENT, "struct_size");
    terms[0].struct_size = 0;
    refused(dqa_tape_objective(tape, terms, 1, &loss, NULL), DQA_ERROR_ARGUMENT, "struct_size");
    dqa_tape_free(tape);
}

static void record_is_one_piece(void** state) {
    dqa_simulator* other = tiny_simulator(space);
    dqa_controller* controller = tiny_controller(simulator);
    dqa_tape* tape = tiny_tape(simulator, 2);
    dqa_tape* clean = NULL;
    int64_t n_steps = -1;
    (void)state;
    /* Another simulator's steps do not belong on it. */
    refused(dqa_simulator_rollout(other, controller, 1, tape, NULL, NULL), DQA_ERROR_ARGUMENT, "tape");
    /* Nor do steps after a gap: one that was not recorded, a state that was set, another design. */
    ok(dqa_simulator_rollout(simulator, controller, 1, NULL, NULL, NULL));
    assert_int_equal(dqa_simulator_rollout(simulator, controller, 1, tape, NULL, NULL), DQA_ERROR_STATE);
    ok(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0));
    assert_int_equal(dqa_simulator_rollout(simulator, controller, 1, tape, NULL, NULL), DQA_ERROR_STATE);
    ok(dqa_simulator_set_weights(simulator, HALF, N_BASES, NULL, NULL));
    assert_int_equal(dqa_simulator_rollout(simulator, controller, 1, tape, NULL, NULL), DQA_ERROR_STATE);
    ok(dqa_tape_n_steps(tape, &n_steps));
    assert_int_equal(n_steps, 2);
    /* Cleared, it takes another rollout. */
    ok(dqa_tape_clear(tape));
    ok(dqa_tape_n_steps(tape, &n_steps));
    assert_int_equal(n_steps, 0);
    ok(dqa_simulator_rollout(simulator, controller, 3, tape, NULL, NULL));
    ok(dqa_tape_n_steps(tape, &n_steps));
    assert_int_equal(n_steps, 3);
    dqa_tape_free(clean);
    dqa_tape_free(tape);
    dqa_controller_free(controller);
    dqa_simulator_free(other);
}

/* Every kind through the interface: its value against the states that the tape gives back, and each field's range. */
static void kinds_of_objective(void** state) {
    static const double path[] = {0.0, 0.0, 0.0, 0.0, 1.0, 0.3, 0.1, -0.2};
    dqa_tape* tape = tiny_tape(simulator, STEPS);
    dqa_adjoint* adjoint = NULL;
    dqa_objective_term terms[5], good;
    double per_term[5], loss = NAN, effort = 0.0, u[64], weights[2] = {0.0, 0.0};
    int32_t k;
    (void)state;
    for (k = 0; k < 5; ++k) {
        ok(dqa_objective_term_init(&terms[k], sizeof *terms));
        assert_true(terms[k].weight == 1.0 && terms[k].gamma == 0.01 && terms[k].epsilon == 1e-4 && !terms[k].path);
        terms[k].kind = k;
        terms[k].weight = 1.0 + k;
    }
    terms[DQA_OBJECTIVE_PATH].path = path;
    terms[DQA_OBJECTIVE_PATH].n_path = sizeof path / sizeof *path;
    ok(dqa_tape_objective(tape, terms, 5, &loss, per_term));
    assert_true(fabs(loss - (per_term[0] + 2 * per_term[1] + 3 * per_term[2] + 4 * per_term[3] + 5 * per_term[4])) <
                1e-13);
    for (k = 0; k < STEPS; ++k) {
        ok(dqa_tape_get_actuation(tape, k, u, n_signals()));
        effort += u[0] * u[0] / 30.0;
    }
    assert_true(fabs(per_term[3] - effort) < 1e-14);
    assert_true(per_term[1] < 0.0 && per_term[2] < 0.0 && per_term[4] > 0.0);
    ok(dqa_adjoint_create(tape, &adjoint));
    ok(dqa_adjoint_seed_objective(adjoint, terms, 5));
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, weights, N_BASES));
    assert_true(isfinite(weights[0]) && weights[0] != 0.0);
    dqa_adjoint_free(adjoint);

    good = terms[1];
    terms[1].target[1] = NAN;
    refused(dqa_tape_objective(tape, terms, 2, &loss, NULL), DQA_ERROR_ARGUMENT, "target");
    terms[1] = good, terms[1].gamma = INFINITY;
    refused(dqa_tape_objective(tape, terms, 2, &loss, NULL), DQA_ERROR_ARGUMENT, "gamma");
    terms[1] = good, terms[1].epsilon = 0.0;
    refused(dqa_tape_objective(tape, terms, 2, &loss, NULL), DQA_ERROR_ARGUMENT, "epsilon");
    terms[1] = terms[DQA_OBJECTIVE_PATH], terms[1].path = NULL;
    refused(dqa_tape_objective(tape, terms, 2, &loss, NULL), DQA_ERROR_ARGUMENT, "path");
    terms[1] = terms[DQA_OBJECTIVE_PATH], terms[1].n_path = 7;
    refused(dqa_tape_objective(tape, terms, 2, &loss, NULL), DQA_ERROR_ARGUMENT, "n_path");
    terms[1].n_path = 0;
    refused(dqa_tape_objective(tape, terms, 2, &loss, NULL), DQA_ERROR_ARGUMENT, "n_path");
    {
        double bad[8];
        memcpy(bad, path, sizeof bad);
        bad[4] = 0.0; /* the same time twice */
        terms[1] = terms[DQA_OBJECTIVE_PATH], terms[1].path = bad;
        refused(dqa_tape_objective(tape, terms, 2, &loss, NULL), DQA_ERROR_ARGUMENT, "path");
        bad[4] = 1.0, bad[6] = NAN;
        refused(dqa_tape_objective(tape, terms, 2, &loss, NULL), DQA_ERROR_ARGUMENT, "path");
    }
    dqa_tape_free(tape);
}

/* Gradient of the travelled distance by the actuations, behind it the state of a step in the middle. */
static double* swim_and_sweep(int64_t memory_bytes, int64_t steps, int64_t* n, dqa_tape_statistics* statistics) {
    dqa_controller* controller = tiny_controller(simulator);
    dqa_tape_options options;
    dqa_objective_term term;
    dqa_tape* tape = NULL;
    dqa_adjoint* adjoint = NULL;
    const int64_t n_actuation = steps * n_signals(), n_state = state_length(simulator);
    double* out = doubles(n_actuation + 2 * n_state);
    ok(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0));
    ok(dqa_tape_options_init(&options, sizeof options));
    assert_int_equal(options.memory_bytes, 0);
    options.memory_bytes = memory_bytes;
    ok(dqa_tape_create(simulator, &options, &tape));
    ok(dqa_simulator_rollout(simulator, controller, steps, tape, NULL, NULL));
    ok(dqa_adjoint_create(tape, &adjoint));
    ok(dqa_objective_term_init(&term, sizeof term));
    ok(dqa_adjoint_seed_objective(adjoint, &term, 1));
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_ACTUATION, out, n_actuation));
    ok(dqa_tape_get_state(tape, 3, out + n_actuation, n_state, out + n_actuation + n_state, n_state));
    ok(dqa_tape_stats(tape, statistics, sizeof *statistics));
    dqa_adjoint_free(adjoint);
    dqa_tape_free(tape);
    dqa_controller_free(controller);
    *n = n_actuation + 2 * n_state;
    return out;
}

static void memory_budget_holds(void** state) {
    enum { LONG = 14 };
    dqa_controller* controller = tiny_controller(simulator);
    dqa_tape_options options;
    dqa_tape_statistics statistics;
    dqa_tape* tape = NULL;
    dqa_simulator_info info;
    int64_t n_steps = -1, n, n2;
    const int64_t one_state = 2 * state_length(simulator) * (int64_t)sizeof(double);
    const int64_t inputs = LONG * (168 + n_signals() * (int64_t)sizeof(double));
    double *all, *few;
    (void)state;
    all = swim_and_sweep(0, LONG, &n, &statistics);
    assert_int_equal(statistics.checkpoints, LONG + 1);
    assert_int_equal(statistics.recomputed_steps, 0);
    few = swim_and_sweep(4 * one_state + inputs, LONG, &n2, &statistics);
    assert_true(statistics.checkpoints == 2 && statistics.recomputed_steps > LONG);
    assert_true(statistics.bytes <= 4 * one_state + inputs);
    assert_int_equal(n, n2);
    assert_memory_equal(all, few, (size_t)n * sizeof *all);
    free(all), free(few);

    /* Less than four states: nothing was recorded, nothing has happened. */
    ok(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0));
    ok(dqa_tape_options_init(&options, sizeof options));
    options.memory_bytes = 4 * one_state;
    ok(dqa_tape_create(simulator, &options, &tape));
    refused(dqa_simulator_rollout(simulator, controller, 20, tape, NULL, NULL), DQA_ERROR_MEMORY, "memory_bytes");
    ok(dqa_tape_stats(tape, &statistics, sizeof statistics));
    ok(dqa_tape_n_steps(tape, &n_steps));
    ok(dqa_simulator_get_info(simulator, &info, sizeof info));
    assert_true(n_steps == 0 && statistics.steps == 0 && info.steps == 0 && statistics.bytes == 0);
    dqa_tape_free(tape);
    dqa_controller_free(controller);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(controllers_steps_stay_alone, at_rest),
        cmocka_unit_test_setup(null_arguments, at_rest),
        cmocka_unit_test_setup(records_what_happened, at_rest),
        cmocka_unit_test_setup(objective_is_checked, at_rest),
        cmocka_unit_test_setup(record_is_one_piece, at_rest),
        cmocka_unit_test_setup(memory_budget_holds, at_rest),
        cmocka_unit_test_setup(kinds_of_objective, at_rest),
    };
    return cmocka_run_group_tests_name("tape", tests, open_scene, close_scene);
}
