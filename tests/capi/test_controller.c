/* SPDX-License-Identifier: MIT
 * The controller, and the rollout that it drives. */
#include "space.h"

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
    refused(dqa_controller_evaluate(NULL, 0, NULL, 0, u, 2), DQA_ERROR_ARGUMENT, "controller");
    refused(dqa_controller_evaluate(controller, 0, NULL, 0, NULL, 2), DQA_ERROR_ARGUMENT, "actuation");
    refused(dqa_controller_evaluate(controller, -1, NULL, 0, u, 2), DQA_ERROR_ARGUMENT, "step");
    refused(dqa_controller_evaluate(controller, 0, NULL, 0, u, 3), DQA_ERROR_ARGUMENT, "actuation|n");
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
        ok(dqa_controller_evaluate(controller, step, NULL, 0, u, 2));
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
        ok(dqa_controller_evaluate(controller, step, NULL, 0, u, info.n_signals));
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

static void mlp_is_checked(void** state) {
    dqa_mlp_options o;
    dqa_controller* mlp = NULL;
    dqa_controller* again = NULL;
    dqa_controller_info info;
    double sensors[15] = {0}, u[17], u2[17], *theta = doubles(7569), *theta2 = doubles(7569);
    int64_t n = 0;
    (void)state;
    ok(dqa_mlp_options_init(&o, sizeof o));
    assert_true(o.n_signals == 1 && o.dims == 3 && o.n_hidden == 2 && o.hidden[0] == 64 && o.hidden[1] == 64);
    assert_true(o.temporal_encoding == 1 && o.period_steps == 25 && o.scale == 1.0);
    ok(dqa_controller_create_mlp(NULL, &mlp));
    ok(dqa_controller_n_parameters(mlp, &n));
    assert_int_equal(n + 12, 6541); /* with the weights of 12 bases */
    dqa_controller_free(mlp);
    o.n_signals = 17;
    ok(dqa_controller_create_mlp(&o, &mlp));
    ok(dqa_controller_get_info(mlp, &info, sizeof info));
    assert_true(info.kind == DQA_CONTROLLER_MLP && info.n_signals == 17 && info.n_sensors == 15 && info.has_pullback);
    assert_int_equal(info.n_parameters + 3, 7572); /* with the weights of 3 bases */
    refused(dqa_controller_evaluate(mlp, 0, NULL, 0, u, 17), DQA_ERROR_ARGUMENT, "sensors");
    refused(dqa_controller_evaluate(mlp, 0, sensors, 14, u, 17), DQA_ERROR_ARGUMENT, "n_sensors");
    sensors[3] = NAN;
    refused(dqa_controller_evaluate(mlp, 0, sensors, 15, u, 17), DQA_ERROR_ARGUMENT, "sensors");
    sensors[3] = 0.5;
    ok(dqa_controller_evaluate(mlp, 3, sensors, 15, u, 17));
    ok(dqa_controller_create_mlp(&o, &again)); /* the same seed: the same bits */
    ok(dqa_controller_get_parameters(mlp, theta, 7569));
    ok(dqa_controller_get_parameters(again, theta2, 7569));
    assert_memory_equal(theta, theta2, 7569 * sizeof *theta);
    dqa_controller_free(again);
    theta[5] = NAN;
    refused(dqa_controller_set_parameters(mlp, theta, 7569), DQA_ERROR_ARGUMENT, "theta");

    refused(dqa_controller_save(NULL, "mlp.dqa"), DQA_ERROR_ARGUMENT, "controller");
    refused(dqa_controller_save(mlp, NULL), DQA_ERROR_ARGUMENT, "path");
    assert_int_equal(dqa_controller_save(mlp, "no/such/folder/mlp.dqa"), DQA_ERROR_IO);
    ok(dqa_controller_save(mlp, "mlp.dqa"));
    again = (dqa_controller*)&again;
    refused(dqa_controller_load(NULL, &again), DQA_ERROR_ARGUMENT, "path");
    assert_null(again);
    assert_int_equal(dqa_controller_load("no_such_file.dqa", &again), DQA_ERROR_IO);
    ok(dqa_controller_load("mlp.dqa", &again));
    dqa_controller_free(mlp);
    ok(dqa_controller_evaluate(again, 3, sensors, 15, u2, 17));
    assert_memory_equal(u, u2, sizeof u);
    dqa_controller_free(again);
    refused(dqa_controller_get_info(NULL, &info, sizeof info), DQA_ERROR_ARGUMENT, "controller");

    o.n_signals = 0;
    refused(dqa_controller_create_mlp(&o, &mlp), DQA_ERROR_ARGUMENT, "n_signals");
    assert_null(mlp);
    o.n_signals = 1, o.dims = 4;
    refused(dqa_controller_create_mlp(&o, &mlp), DQA_ERROR_ARGUMENT, "dims");
    o.dims = 3, o.n_hidden = 6;
    refused(dqa_controller_create_mlp(&o, &mlp), DQA_ERROR_ARGUMENT, "n_hidden");
    o.n_hidden = 3;
    refused(dqa_controller_create_mlp(&o, &mlp), DQA_ERROR_ARGUMENT, "hidden");
    o.n_hidden = 2, o.temporal_encoding = 2;
    refused(dqa_controller_create_mlp(&o, &mlp), DQA_ERROR_ARGUMENT, "temporal_encoding");
    o.temporal_encoding = 1, o.period_steps = 0;
    refused(dqa_controller_create_mlp(&o, &mlp), DQA_ERROR_ARGUMENT, "period_steps");
    o.period_steps = 25, o.scale = -1.0;
    refused(dqa_controller_create_mlp(&o, &mlp), DQA_ERROR_ARGUMENT, "scale");
    free(theta), free(theta2);
}

/* The caller's own: u = theta sin(20 t) - velocity of the tail along y. */
typedef struct own {
    int32_t result, result_back;
    double spoil;
    int64_t calls, calls_back;
} own;
static int32_t own_evaluate(int64_t step, double time, const double* sensors, int64_t n_sensors, const double* theta,
                            int64_t n_parameters, double* actuation, int64_t n_signals, void* user_data) {
    own* w = user_data;
    (void)step, (void)n_parameters, (void)n_signals;
    ++w->calls;
    actuation[0] = tanh(theta[0] * sin(20.0 * time) - (n_sensors > 0 ? sensors[7] : 0.0)) + w->spoil;
    return w->result;
}
static int32_t own_pullback(int64_t step, double time, const double* sensors, int64_t n_sensors, const double* theta,
                            int64_t n_parameters, const double* actuation_bar, int64_t n_signals, double* theta_bar,
                            double* sensors_bar, void* user_data) {
    own* w = user_data;
    const double y = tanh(theta[0] * sin(20.0 * time) - (n_sensors > 0 ? sensors[7] : 0.0));
    const double bar = actuation_bar[0] * (1.0 - y * y);
    (void)step, (void)n_parameters, (void)n_signals;
    ++w->calls_back;
    theta_bar[0] = bar * sin(20.0 * time);
    if (n_sensors > 0) sensors_bar[7] = -bar;
    return w->result_back;
}

static dqa_controller* own_controller(own* w, int32_t n_sensors, int with_pullback) {
    dqa_callback_controller_options o;
    dqa_controller* controller = NULL;
    const double theta = 0.9;
    memset(w, 0, sizeof *w);
    ok(dqa_callback_controller_options_init(&o, sizeof o));
    assert_true(o.n_signals == 1 && o.n_sensors == 0 && !o.evaluate && !o.pullback && !o.user_data);
    o.n_sensors = n_sensors, o.evaluate = own_evaluate, o.user_data = w;
    if (with_pullback) o.pullback = own_pullback;
    ok(dqa_controller_create_callback(&o, &theta, 1, &controller));
    return controller;
}

static void callback_is_checked(void** state) {
    dqa_callback_controller_options o;
    dqa_controller* controller = NULL;
    dqa_controller_info info;
    own w;
    double theta = NAN, u = 7.0, sensors[15] = {0};
    (void)state;
    ok(dqa_callback_controller_options_init(&o, sizeof o));
    refused(dqa_controller_create_callback(NULL, NULL, 0, &controller), DQA_ERROR_ARGUMENT, "evaluate");
    refused(dqa_controller_create_callback(&o, NULL, 0, &controller), DQA_ERROR_ARGUMENT, "evaluate");
    o.evaluate = own_evaluate;
    refused(dqa_controller_create_callback(&o, NULL, 0, NULL), DQA_ERROR_ARGUMENT, "controller");
    refused(dqa_controller_create_callback(&o, NULL, 1, &controller), DQA_ERROR_ARGUMENT, "theta");
    refused(dqa_controller_create_callback(&o, &theta, 1, &controller), DQA_ERROR_ARGUMENT, "theta");
    refused(dqa_controller_create_callback(&o, &theta, -1, &controller), DQA_ERROR_ARGUMENT, "n_parameters");
    o.n_sensors = 14;
    refused(dqa_controller_create_callback(&o, NULL, 0, &controller), DQA_ERROR_ARGUMENT, "n_sensors");
    o.n_sensors = 0, o.time_step = 0.0;
    refused(dqa_controller_create_callback(&o, NULL, 0, &controller), DQA_ERROR_ARGUMENT, "time_step");
    o.time_step = 0.1, o.n_signals = 0;
    refused(dqa_controller_create_callback(&o, NULL, 0, &controller), DQA_ERROR_ARGUMENT, "n_signals");
    assert_null(controller);

    controller = own_controller(&w, 15, 0);
    ok(dqa_controller_get_info(controller, &info, sizeof info));
    assert_true(info.kind == DQA_CONTROLLER_CALLBACK && info.n_sensors == 15 && !info.has_pullback);
    assert_int_equal(info.n_parameters, 1);
    assert_int_equal(dqa_controller_save(controller, "own.dqa"), DQA_ERROR_UNSUPPORTED);
    w.result = 5;
    refused(dqa_controller_evaluate(controller, 2, sensors, 15, &u, 1), DQA_CANCELLED, "evaluate");
    w.result = 0, w.spoil = NAN;
    refused(dqa_controller_evaluate(controller, 2, sensors, 15, &u, 1), DQA_ERROR_ARGUMENT, "actuation");
    assert_true(u == 7.0);
    w.spoil = 0.0;
    ok(dqa_controller_evaluate(controller, 2, sensors, 15, &u, 1));
    assert_true(fabs(u - tanh(0.9 * sin(20.0 * 2 / 30.0))) < 1e-15);
    dqa_controller_free(controller);
}

/* Rollout, tape and sweep with the caller's own controller: stopped by it, resumed, and proven. */
static void callback_drives_a_rollout(void** state) {
    dqa_simulator* simulator = tiny_simulator(space);
    dqa_objective_term term;
    dqa_tape* tape = NULL;
    dqa_adjoint* adjoint = NULL;
    dqa_gradient_check_options check;
    dqa_gradient_check_report report;
    own w;
    dqa_controller* controller = own_controller(&w, 15, 1);
    double bar = 0.0;
    int64_t n_steps = -1, calls;
    (void)state;
    ok(dqa_objective_term_init(&term, sizeof term));
    ok(dqa_tape_create(simulator, NULL, &tape));
    w.result = 5;
    refused(dqa_simulator_rollout(simulator, controller, 3, tape, NULL, NULL), DQA_CANCELLED, "evaluate");
    ok(dqa_tape_n_steps(tape, &n_steps));
    assert_int_equal(n_steps, 0);
    w.result = 0;
    ok(dqa_simulator_rollout(simulator, controller, 4, tape, NULL, NULL));
    calls = w.calls;
    ok(dqa_adjoint_create(tape, &adjoint));
    ok(dqa_adjoint_seed_objective(adjoint, &term, 1));
    w.result_back = -1;
    refused(dqa_adjoint_backward(adjoint, 0, NULL, NULL), DQA_CANCELLED, "pullback");
    w.result_back = 0;
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_CONTROL, &bar, 1));
    assert_true(isfinite(bar) && bar != 0.0);
    assert_int_equal(w.calls, calls); /* the sweep does not call it again */
    dqa_adjoint_free(adjoint);
    ok(dqa_gradient_check_options_init(&check, sizeof check));
    check.with_respect_to = DQA_WRT_CONTROL, check.n_steps = 3;
    ok(dqa_check_gradient(simulator, controller, &term, 1, &check, &report, sizeof report));
    assert_true(report.relative_error <= 1e-6 && fabs(report.taylor_slope - 2.0) <= 0.1);
    dqa_tape_free(tape), dqa_controller_free(controller);

    /* Without a pullback a loop that is closed has no gradient; an open one has all but that of its parameters. */
    ok(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0));
    controller = own_controller(&w, 15, 0);
    ok(dqa_tape_create(simulator, NULL, &tape));
    ok(dqa_simulator_rollout(simulator, controller, 2, tape, NULL, NULL));
    refused(dqa_adjoint_create(tape, &adjoint), DQA_ERROR_STATE, "pullback");
    assert_null(adjoint);
    dqa_tape_free(tape), dqa_controller_free(controller);
    ok(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0));
    controller = own_controller(&w, 0, 0);
    ok(dqa_tape_create(simulator, NULL, &tape));
    ok(dqa_simulator_rollout(simulator, controller, 1, tape, NULL, NULL));
    ok(dqa_adjoint_create(tape, &adjoint));
    ok(dqa_adjoint_seed_objective(adjoint, &term, 1));
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_ACTUATION, &bar, 1));
    refused(dqa_adjoint_get(adjoint, DQA_WRT_CONTROL, &bar, 1), DQA_ERROR_STATE, "pullback");
    dqa_adjoint_free(adjoint), dqa_tape_free(tape), dqa_controller_free(controller);

    controller = own_controller(&w, 10, 0); /* of a planar world */
    refused(dqa_simulator_rollout(simulator, controller, 1, NULL, NULL, NULL), DQA_ERROR_ARGUMENT, "controller");
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
        cmocka_unit_test(mlp_is_checked),
        cmocka_unit_test(callback_is_checked),
        cmocka_unit_test(callback_drives_a_rollout),
    };
    return cmocka_run_group_tests_name("controller", tests, open_space, close_space);
}
