/* SPDX-License-Identifier: MIT
 * The library's own proof of its gradient, and the stateless helpers for optimisers. */
#include "scene.h"

static dqa_objective_term travel(void) {
    dqa_objective_term term;
    ok(dqa_objective_term_init(&term, sizeof term));
    term.kind = DQA_OBJECTIVE_TRAVEL;
    term.weight = 1.0;
    return term;
}

static void check_arguments(void** state) {
    const dqa_objective_term term = travel();
    dqa_gradient_check_options options;
    dqa_gradient_check_report report;
    (void)state;
    refused(dqa_check_gradient(NULL, NULL, &term, 1, NULL, &report, sizeof report), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_check_gradient(simulator, NULL, NULL, 1, NULL, &report, sizeof report), DQA_ERROR_ARGUMENT, "terms");
    refused(dqa_check_gradient(simulator, NULL, &term, 0, NULL, &report, sizeof report), DQA_ERROR_ARGUMENT, "n_terms");
    refused(dqa_check_gradient(simulator, NULL, &term, 1, NULL, NULL, sizeof report), DQA_ERROR_ARGUMENT, "report");
    refused(dqa_check_gradient(simulator, NULL, &term, 1, NULL, &report, 0), DQA_ERROR_ARGUMENT, "report_size|size");
    ok(dqa_gradient_check_options_init(&options, sizeof options));
    assert_int_equal(options.n_steps, 10);
    assert_int_equal(options.seed, 1);
    options.n_steps = 0;
    refused(dqa_check_gradient(simulator, NULL, &term, 1, &options, &report, sizeof report), DQA_ERROR_ARGUMENT,
            "n_steps");
    ok(dqa_gradient_check_options_init(&options, sizeof options));
    options.with_respect_to = 99;
    refused(dqa_check_gradient(simulator, NULL, &term, 1, &options, &report, sizeof report), DQA_ERROR_ARGUMENT,
            "with_respect_to");
    ok(dqa_gradient_check_options_init(&options, sizeof options));
    options.step = -1.0;
    refused(dqa_check_gradient(simulator, NULL, &term, 1, &options, &report, sizeof report), DQA_ERROR_ARGUMENT,
            "step");
    options.step = NAN;
    refused(dqa_check_gradient(simulator, NULL, &term, 1, &options, &report, sizeof report), DQA_ERROR_ARGUMENT,
            "step");
    /* A controller for another number of signals. */
    {
        dqa_simulator_info info;
        dqa_controller* other = NULL;
        ok(dqa_simulator_get_info(simulator, &info, sizeof info));
        ok(dqa_controller_create_sinusoid(info.n_signals + 1, 1.0 / 30.0, &other));
        refused(dqa_check_gradient(simulator, other, &term, 1, NULL, &report, sizeof report), DQA_ERROR_ARGUMENT,
                "controller");
        dqa_controller_free(other);
    }
    /* Without a controller there is no control gradient to check. */
    ok(dqa_gradient_check_options_init(&options, sizeof options));
    options.with_respect_to = DQA_WRT_CONTROL;
    assert_int_not_equal(dqa_check_gradient(simulator, NULL, &term, 1, &options, &report, sizeof report), DQA_SUCCESS);
}

/* Every quantity passes, and the simulator is as it was. */
static void every_gradient_is_proved(void** state) {
    static const int32_t quantities[] = {DQA_WRT_WEIGHTS, DQA_WRT_CONTROL, DQA_WRT_ACTUATION, DQA_WRT_INITIAL_POSITION,
                                         DQA_WRT_INITIAL_VELOCITY};
    const dqa_objective_term term = travel();
    dqa_controller* controller = tiny_controller(simulator);
    const int64_t n = state_length(simulator);
    double *q = doubles(n), *v = doubles(n), *q2 = doubles(n), *v2 = doubles(n);
    size_t i;
    (void)state;
    ok(dqa_simulator_rollout(simulator, controller, 2, NULL, NULL, NULL));
    ok(dqa_simulator_get_state(simulator, q, n, v, n));
    for (i = 0; i < sizeof quantities / sizeof *quantities; ++i) {
        dqa_gradient_check_options options;
        dqa_gradient_check_report report;
        ok(dqa_gradient_check_options_init(&options, sizeof options));
        options.with_respect_to = quantities[i];
        options.n_steps = 4;
        ok(dqa_check_gradient(simulator, controller, &term, 1, &options, &report, sizeof report));
        if (!(report.relative_error < 1e-4 && report.taylor_slope > 1.8 && report.gradient_norm > 0.0))
            fail_msg("quantity %d: adjoint %.9g, differences %.9g, relative error %.2g, slope %.3f", quantities[i],
                     report.adjoint, report.finite_difference, report.relative_error, report.taylor_slope);
        assert_int_equal(report.struct_size, sizeof report);
    }
    ok(dqa_simulator_get_state(simulator, q2, n, v2, n));
    assert_memory_equal(q, q2, (size_t)n * sizeof *q);
    assert_memory_equal(v, v2, (size_t)n * sizeof *v);
    dqa_controller_free(controller);
    free(q), free(v), free(q2), free(v2);
}

static void adam_arguments(void** state) {
    double x[2] = {1.0, 2.0}, g[2] = {0.1, -0.2}, r[2] = {0.1, 0.1}, m[2] = {0}, s[2] = {0};
    (void)state;
    refused(dqa_adam_step(NULL, g, r, m, s, 2, 1), DQA_ERROR_ARGUMENT, "x");
    refused(dqa_adam_step(x, NULL, r, m, s, 2, 1), DQA_ERROR_ARGUMENT, "gradient");
    refused(dqa_adam_step(x, g, NULL, m, s, 2, 1), DQA_ERROR_ARGUMENT, "rates");
    refused(dqa_adam_step(x, g, r, NULL, s, 2, 1), DQA_ERROR_ARGUMENT, "first_moment");
    refused(dqa_adam_step(x, g, r, m, NULL, 2, 1), DQA_ERROR_ARGUMENT, "second_moment");
    refused(dqa_adam_step(x, g, r, m, s, -1, 1), DQA_ERROR_ARGUMENT, "n");
    refused(dqa_adam_step(x, g, r, m, s, 2, 0), DQA_ERROR_ARGUMENT, "iteration");
    g[1] = NAN;
    refused(dqa_adam_step(x, g, r, m, s, 2, 1), DQA_ERROR_ARGUMENT, "gradient");
    g[1] = -0.2;
    r[1] = -0.1;
    refused(dqa_adam_step(x, g, r, m, s, 2, 1), DQA_ERROR_ARGUMENT, "rates");
    r[1] = 0.1;
    s[1] = -1e-9;
    refused(dqa_adam_step(x, g, r, m, s, 2, 1), DQA_ERROR_ARGUMENT, "second_moment");
    assert_true(x[0] == 1.0 && x[1] == 2.0 && m[0] == 0.0 && s[0] == 0.0);
}

/* Three steps against the formulas of the paper, written out. */
static void adam_is_the_papers(void** state) {
    double x[2] = {1.0, -2.0}, m[2] = {0}, s[2] = {0};
    double y[2] = {1.0, -2.0}, first[2] = {0}, second[2] = {0};
    const double rates[2] = {0.1, 0.02};
    int64_t t;
    int i;
    (void)state;
    for (t = 1; t <= 3; ++t) {
        const double g[2] = {2.0 * x[0], sin(x[1])};
        ok(dqa_adam_step(x, g, rates, m, s, 2, t));
        for (i = 0; i < 2; ++i) {
            first[i] = 0.9 * first[i] + 0.1 * g[i];
            second[i] = 0.999 * second[i] + 0.001 * g[i] * g[i];
            y[i] -= rates[i] * (first[i] / (1.0 - pow(0.9, (double)t))) /
                    (sqrt(second[i] / (1.0 - pow(0.999, (double)t))) + 1e-8);
            assert_true(fabs(x[i] - y[i]) < 1e-12);
        }
    }
}

static void simplex_projection(void** state) {
    double inside[3] = {0.2, 0.3, 0.5};
    double shifted[3] = {1.2, 1.3, 1.5}; /* the same point, moved along the normal */
    double corner[3] = {5.0, 0.0, -3.0};
    double edge[3] = {1.0, 0.8, -2.0};
    double wrong[2] = {NAN, 0.5};
    double one[1] = {-4.0};
    int i;
    (void)state;
    refused(dqa_project_simplex(NULL, 3), DQA_ERROR_ARGUMENT, "x");
    refused(dqa_project_simplex(inside, 0), DQA_ERROR_ARGUMENT, "n");
    refused(dqa_project_simplex(wrong, 2), DQA_ERROR_ARGUMENT, "x");
    ok(dqa_project_simplex(inside, 3));
    ok(dqa_project_simplex(shifted, 3));
    ok(dqa_project_simplex(corner, 3));
    ok(dqa_project_simplex(edge, 3));
    ok(dqa_project_simplex(one, 1));
    for (i = 0; i < 3; ++i) {
        static const double expected[3] = {0.2, 0.3, 0.5}, at_corner[3] = {1.0, 0.0, 0.0}, at_edge[3] = {0.6, 0.4, 0.0};
        assert_true(fabs(inside[i] - expected[i]) < 1e-15);
        assert_true(fabs(shifted[i] - expected[i]) < 1e-15);
        assert_true(fabs(corner[i] - at_corner[i]) < 1e-15);
        assert_true(fabs(edge[i] - at_edge[i]) < 1e-15);
    }
    assert_true(one[0] == 1.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(check_arguments),    cmocka_unit_test(every_gradient_is_proved),
        cmocka_unit_test(adam_arguments),     cmocka_unit_test(adam_is_the_papers),
        cmocka_unit_test(simplex_projection),
    };
    return cmocka_run_group_tests_name("gradient", tests, open_scene, close_scene);
}
