/* SPDX-License-Identifier: MIT
 * The controller, and the rollout that it drives. */
#include "support.h"

static dqa_shape_space* space;

static int open_space(void** state) {
    (void)state;
    space = tiny_space();
    return 0;
}

static int close_space(void** state) {
    (void)state;
    dqa_shape_space_free(space);
    return 0;
}

static void create_is_checked(void** state) {
    static const double wrong[] = {0.0, -0.1, NAN, INFINITY};
    dqa_controller* controller = (dqa_controller*)&controller;
    size_t i;
    (void)state;
    refused(dqa_controller_create_sinusoid(2, 0.1, NULL), DQA_ERROR_ARGUMENT, "controller");
    refused(dqa_controller_create_sinusoid(0, 0.1, &controller), DQA_ERROR_ARGUMENT, "n_signals");
    assert_null(controller);
    refused(dqa_controller_create_sinusoid(-3, 0.1, &controller), DQA_ERROR_ARGUMENT, "n_signals");
    for (i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        controller = (dqa_controller*)&controller;
        refused(dqa_controller_create_sinusoid(2, wrong[i], &controller), DQA_ERROR_ARGUMENT, "time_step");
        assert_null(controller);
    }
    dqa_controller_free(NULL);
}

static void arguments_are_checked(void** state) {
    dqa_controller* controller = NULL;
    static const double wrong[] = {NAN, INFINITY, -0.1, 1.1};
    double theta[6], kept[6], u[2];
    int64_t n = 0;
    size_t i;
    (void)state;
    ok(dqa_controller_create_sinusoid(2, 0.1, &controller));
    refused(dqa_controller_n_parameters(NULL, &n), DQA_ERROR_ARGUMENT, "controller");
    refused(dqa_controller_n_parameters(controller, NULL), DQA_ERROR_ARGUMENT, "n");
    ok(dqa_controller_n_parameters(controller, &n));
    assert_int_equal(n, 6);
    refused(dqa_controller_get_parameters(NULL, theta, 6), DQA_ERROR_ARGUMENT, "controller");
    refused(dqa_controller_get_parameters(controller, NULL, 6), DQA_ERROR_ARGUMENT, "theta");
    refused(dqa_controller_get_parameters(controller, theta, 5), DQA_ERROR_ARGUMENT, "theta|n");
    ok(dqa_controller_get_parameters(controller, theta, 6));
    refused(dqa_controller_set_parameters(NULL, theta, 6), DQA_ERROR_ARGUMENT, "controller");
    refused(dqa_controller_set_parameters(controller, NULL, 6), DQA_ERROR_ARGUMENT, "theta");
    refused(dqa_controller_set_parameters(controller, theta, 7), DQA_ERROR_ARGUMENT, "theta|n");
    for (i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        ok(dqa_controller_get_parameters(controller, theta, 6));
        theta[3] = wrong[i]; /* an amplitude: in [0, 1] */
        refused(dqa_controller_set_parameters(controller, theta, 6), DQA_ERROR_ARGUMENT, "theta");
    }
    ok(dqa_controller_get_parameters(controller, theta, 6));
    memcpy(kept, theta, sizeof kept);
    theta[5] = NAN; /* a phase */
    refused(dqa_controller_set_parameters(controller, theta, 6), DQA_ERROR_ARGUMENT, "theta");
    ok(dqa_controller_get_parameters(controller, theta, 6));
    assert_memory_equal(kept, theta, sizeof kept);
    refused(dqa_controller_evaluate(NULL, 0, u, 2), DQA_ERROR_ARGUMENT, "controller");
    refused(dqa_controller_evaluate(controller, 0, NULL, 2), DQA_ERROR_ARGUMENT, "actuation");
    refused(dqa_controller_evaluate(controller, -1, u, 2), DQA_ERROR_ARGUMENT, "step");
    refused(dqa_controller_evaluate(controller, 0, u, 3), DQA_ERROR_ARGUMENT, "actuation|n");
    dqa_controller_free(controller);
}

static void sinusoid_is_as_documented(void** state) {
    const double pi = 3.14159265358979323846;
    const double h = 0.05;
    dqa_controller* controller = NULL;
    const double other[6] = {0.5, 3.0, 0.25, 1.0, 7.0, -1.0};
    double theta[6], u[2];
    int64_t step;
    int s;
    (void)state;
    ok(dqa_controller_create_sinusoid(2, h, &controller));
    ok(dqa_controller_get_parameters(controller, theta, 6));
    for (s = 0; s < 2; ++s) {
        assert_true(theta[3 * s] == 1.0 && theta[3 * s + 2] == 0.0);
        assert_true(fabs(theta[3 * s + 1] - pi / (6.0 * h)) < 1e-12);
    }
    ok(dqa_controller_set_parameters(controller, other, 6));
    for (step = 0; step < 20; ++step) {
        ok(dqa_controller_evaluate(controller, step, u, 2));
        for (s = 0; s < 2; ++s) {
            const double t = h * (double)step;
            assert_true(fabs(u[s] - other[3 * s] * sin(other[3 * s + 1] * t + other[3 * s + 2])) < 1e-12);
        }
    }
    dqa_controller_free(controller);
}

/* The caller's own loop over dqa_simulator_step gives the bits of dqa_simulator_rollout. */
static void rollout_is_the_own_loop(void** state) {
    enum { STEPS = 4 };
    dqa_simulator* simulator = tiny_simulator(space);
    dqa_controller* controller = tiny_controller(simulator);
    dqa_simulator_info info;
    const int64_t n = state_length(simulator);
    const size_t bytes = (size_t)n * sizeof(double);
    double *q = doubles(n), *v = doubles(n), *q2 = doubles(n), *v2 = doubles(n);
    double u[64];
    int64_t step, calls = 0;
    (void)state;
    ok(dqa_simulator_rollout(simulator, controller, STEPS, NULL, count_progress, &calls));
    assert_true(calls >= STEPS);
    ok(dqa_simulator_get_state(simulator, q, n, v, n));
    ok(dqa_simulator_get_info(simulator, &info, sizeof info));
    assert_int_equal(info.steps, STEPS);
    assert_true(fabs(info.time - STEPS / 30.0) < 1e-12);
    assert_true(info.newton_iterations >= STEPS);
    assert_true(info.last_residual <= 1e-6);

    ok(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0));
    for (step = 0; step < STEPS; ++step) {
        ok(dqa_controller_evaluate(controller, step, u, info.n_signals));
        ok(dqa_simulator_step(simulator, u, info.n_signals, NULL));
    }
    ok(dqa_simulator_get_state(simulator, q2, n, v2, n));
    assert_memory_equal(q, q2, bytes);
    assert_memory_equal(v, v2, bytes);
    dqa_controller_free(controller);
    dqa_simulator_free(simulator);
    free(q), free(v), free(q2), free(v2);
}

static void rollout_is_checked_and_cancelled(void** state) {
    dqa_simulator* simulator = tiny_simulator(space);
    dqa_controller* controller = tiny_controller(simulator);
    dqa_controller* wide = NULL;
    dqa_simulator_info info;
    dqa_tape* tape = NULL;
    int64_t stop = 2, n_steps = -1;
    (void)state;
    ok(dqa_simulator_get_info(simulator, &info, sizeof info));
    ok(dqa_controller_create_sinusoid(info.n_signals + 1, 1.0 / 30.0, &wide));
    refused(dqa_simulator_rollout(simulator, wide, 2, NULL, NULL, NULL), DQA_ERROR_ARGUMENT, "controller");
    refused(dqa_simulator_rollout(simulator, controller, -1, NULL, NULL, NULL), DQA_ERROR_ARGUMENT, "n_steps");

    /* The complete steps stay, in the simulator and on the tape, and the simulator goes on from there. */
    ok(dqa_tape_create(simulator, NULL, &tape));
    assert_int_equal(dqa_simulator_rollout(simulator, controller, 5, tape, cancel_when, &stop), DQA_CANCELLED);
    ok(dqa_simulator_get_info(simulator, &info, sizeof info));
    ok(dqa_tape_n_steps(tape, &n_steps));
    assert_int_equal(info.steps, 2);
    assert_int_equal(n_steps, 2);
    ok(dqa_simulator_rollout(simulator, controller, 1, tape, NULL, NULL));
    ok(dqa_tape_n_steps(tape, &n_steps));
    assert_int_equal(n_steps, 3);
    dqa_tape_free(tape);
    dqa_controller_free(wide);
    dqa_controller_free(controller);
    dqa_simulator_free(simulator);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(create_is_checked),
        cmocka_unit_test(arguments_are_checked),
        cmocka_unit_test(sinusoid_is_as_documented),
        cmocka_unit_test(rollout_is_the_own_loop),
        cmocka_unit_test(rollout_is_checked_and_cancelled),
    };
    return cmocka_run_group_tests_name("controller", tests, open_space, close_space);
}
