/* SPDX-License-Identifier: MIT
 * Handles freed in any order, many lives after one another, several lives at once. The address sanitizer's run turns
 * a leak or a use after free here into a failure. */
#include <pthread.h>

#include "support.h"

enum { HANDLES = 5, ORDERS = 120 };

/* The k-th permutation of the five handles. */
static void permutation(int k, int order[HANDLES]) {
    int left[HANDLES] = {0, 1, 2, 3, 4};
    int n, i, factorial = 24;
    for (n = HANDLES; n > 0; --n) {
        const int pick = k / factorial;
        order[HANDLES - n] = left[pick];
        for (i = pick; i + 1 < n; ++i) left[i] = left[i + 1];
        k %= factorial;
        if (n > 1) factorial /= n - 1;
    }
}

/* Space, simulator, controller, tape, adjoint: after each free, what is left must still work. */
static void any_order_of_frees(void** state) {
    int k, i;
    (void)state;
    for (k = 0; k < ORDERS; ++k) {
        dqa_objective_term term;
        dqa_shape_space* own = tiny_space();
        dqa_simulator* simulator = tiny_simulator(own);
        dqa_controller* controller = tiny_controller(simulator);
        dqa_tape* tape = tiny_tape(simulator, 2);
        dqa_adjoint* adjoint = NULL;
        double u[64] = {0}, weights[N_BASES];
        int64_t n_steps = 0, n_parameters = 0;
        int order[HANDLES];
        ok(dqa_controller_n_parameters(controller, &n_parameters));
        ok(dqa_adjoint_create(tape, &adjoint));
        ok(dqa_objective_term_init(&term, sizeof term));
        ok(dqa_adjoint_seed_objective(adjoint, &term, 1));
        permutation(k, order);
        for (i = 0; i < HANDLES; ++i) {
            switch (order[i]) {
                case 0:
                    dqa_shape_space_free(own), own = NULL;
                    break;
                case 1:
                    dqa_simulator_free(simulator), simulator = NULL;
                    break;
                case 2:
                    dqa_controller_free(controller), controller = NULL;
                    break;
                case 3:
                    dqa_tape_free(tape), tape = NULL;
                    break;
                default:
                    dqa_adjoint_free(adjoint), adjoint = NULL;
                    break;
            }
            if (simulator) ok(dqa_simulator_get_weights(simulator, weights, N_BASES));
            if (simulator && i == 0) {
                dqa_simulator_info info;
                ok(dqa_simulator_get_info(simulator, &info, sizeof info));
                ok(dqa_simulator_step(simulator, u, info.n_signals, NULL));
            }
            if (controller) ok(dqa_controller_evaluate(controller, 1, NULL, 0, u, n_parameters / 3));
            if (tape) ok(dqa_tape_n_steps(tape, &n_steps));
            if (adjoint && i == 3) {
                /* The last one alive: its parents are there as long as it needs them. */
                ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
                ok(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, weights, N_BASES));
            }
        }
    }
}

/* A token in the options is one more parent. */
static void token_outlives_its_free(void** state) {
    dqa_shape_space_options options = tiny_options();
    dqa_simulator_options scene;
    dqa_cancel_token* token = NULL;
    dqa_shape_space* space = NULL;
    dqa_simulator* simulator = NULL;
    double* cells = doubles(N_CELLS);
    const double weight = 1.0;
    (void)state;
    ok(dqa_cancel_token_create(&token));
    options.cancel = token;
    ok(dqa_shape_space_create(&options, &space));
    ok(dqa_simulator_options_init(&scene, sizeof scene));
    ellipsoid(cells, 6.0, 2.0, 2.0);
    ok(dqa_shape_space_add_density(space, "a", cells, N_CELLS, NULL));
    ok(dqa_shape_space_build(space, NULL, NULL));
    scene.cancel = token;
    ok(dqa_simulator_create(space, &scene, &simulator));
    dqa_cancel_token_free(token);
    dqa_shape_space_free(space);
    ok(dqa_simulator_set_weights(simulator, &weight, 1, NULL, NULL));
    dqa_simulator_free(simulator);
    free(cells);
}

static void thousand_lives(void** state) {
    int i;
    (void)state;
    for (i = 0; i < 1000; ++i) {
        dqa_shape_space* space = tiny_space();
        dqa_simulator* simulator = NULL;
        dqa_tape* tape = NULL;
        dqa_adjoint* adjoint = NULL;
        ok(dqa_simulator_create(space, NULL, &simulator));
        /* A whole run in every tenth life: its set-up and steps are what takes the time. */
        if (i % 10 == 0) {
            ok(dqa_simulator_set_weights(simulator, HALF, N_BASES, NULL, NULL));
            tape = tiny_tape(simulator, 1);
            ok(dqa_adjoint_create(tape, &adjoint));
            ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
        }
        dqa_adjoint_free(adjoint);
        dqa_tape_free(tape);
        dqa_simulator_free(simulator);
        dqa_shape_space_free(space);
    }
}

/* A rollout with its gradient, on a simulator of its own over a shared space. cmocka's assertions may not be used off
 * the main thread, so trouble comes back as a status. */
typedef struct job {
    dqa_shape_space* space;
    dqa_status status;
    double loss, gradient[N_BASES];
} job;

#define TRY(call)                                         \
    do {                                                  \
        if (j->status == DQA_SUCCESS) j->status = (call); \
    } while (0)

static void* run_job(void* data) {
    job* j = data;
    dqa_simulator* simulator = NULL;
    dqa_controller* controller = NULL;
    dqa_tape* tape = NULL;
    dqa_adjoint* adjoint = NULL;
    dqa_objective_term term;
    dqa_simulator_info info;
    TRY(dqa_simulator_create(j->space, NULL, &simulator));
    TRY(dqa_simulator_set_weights(simulator, HALF, N_BASES, NULL, NULL));
    TRY(dqa_simulator_get_info(simulator, &info, sizeof info));
    TRY(dqa_controller_create_sinusoid(j->status == DQA_SUCCESS ? info.n_signals : 0, 1.0 / 30.0, &controller));
    TRY(dqa_tape_create(simulator, NULL, &tape));
    TRY(dqa_simulator_rollout(simulator, controller, 3, tape, NULL, NULL));
    TRY(dqa_objective_term_init(&term, sizeof term));
    TRY(dqa_tape_objective(tape, &term, 1, &j->loss, NULL));
    TRY(dqa_adjoint_create(tape, &adjoint));
    TRY(dqa_adjoint_seed_objective(adjoint, &term, 1));
    TRY(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    TRY(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, j->gradient, N_BASES));
    dqa_adjoint_free(adjoint);
    dqa_tape_free(tape);
    dqa_controller_free(controller);
    dqa_simulator_free(simulator);
    return NULL;
}

static void lives_at_once(void** state) {
    enum { JOBS = 4 };
    dqa_shape_space* space = tiny_space();
    pthread_t threads[JOBS];
    job jobs[JOBS + 1];
    int i;
    (void)state;
    for (i = 0; i <= JOBS; ++i) {
        memset(&jobs[i], 0, sizeof jobs[i]);
        jobs[i].space = space;
    }
    for (i = 0; i < JOBS; ++i) assert_int_equal(pthread_create(&threads[i], NULL, run_job, &jobs[i]), 0);
    for (i = 0; i < JOBS; ++i) assert_int_equal(pthread_join(threads[i], NULL), 0);
    run_job(&jobs[JOBS]);
    for (i = 0; i <= JOBS; ++i) {
        ok(jobs[i].status);
        assert_memory_equal(&jobs[i].loss, &jobs[JOBS].loss, sizeof jobs[i].loss);
        assert_memory_equal(jobs[i].gradient, jobs[JOBS].gradient, sizeof jobs[i].gradient);
    }
    dqa_shape_space_free(space);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_order_of_frees),
        cmocka_unit_test(token_outlives_its_free),
        cmocka_unit_test(thousand_lives),
        cmocka_unit_test(lives_at_once),
    };
    return cmocka_run_group_tests_name("lifetime", tests, NULL, NULL);
}
