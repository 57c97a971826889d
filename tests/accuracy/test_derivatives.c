/* SPDX-License-Identifier: MIT
 * The gradient of the whole chain through the interface against finite differences, to 1e-6, on meshes: shipped shapes
 * and real ones, inside the simplex and at a vertex, from rest and in motion, in still water and with a head-on
 * current. Ten steps, force residual 1e-13, marginal error 1e-13, five-point stencils over a ladder of steps. Every
 * quantity, dimension, integrator, material and controller is in the table of derivatives/, on small bodies. */
#include "scenes.h"

static const char* const QUANTITIES[] = {"weights", "control", "actuation", "initial position", "initial velocity"};

/* Prints one row a quantity and fails on an error above 1e-6, a vanishing gradient or a slope away from 2. */
static void prove(const char* scene, dqa_shape_space* space, double first_weight, double current, int moving,
                  int32_t first_quantity, int32_t last_quantity) {
    dqa_simulator_options o;
    dqa_simulator* simulator;
    dqa_controller* controller;
    const dqa_objective_term term = scene_travel();
    const double theta[3] = {0.8, 15.0, 0.4};
    int32_t k, failures = 0;
    o = scene_options();
    o.threads = 2;
    o.current[0] = -current;
    simulator = scene_simulator(space, &o, first_weight);
    ok(dqa_controller_create_sinusoid(1, o.time_step, &controller));
    ok(dqa_controller_set_parameters(controller, theta, 3));
    if (moving) ok(dqa_simulator_rollout(simulator, controller, 4, NULL, NULL, NULL));
    for (k = first_quantity; k <= last_quantity; ++k) {
        dqa_gradient_check_options check;
        dqa_gradient_check_report r;
        ok(dqa_gradient_check_options_init(&check, sizeof check));
        check.with_respect_to = k;
        ok(dqa_check_gradient(simulator, controller, &term, 1, &check, &r, sizeof r));
        print_message("  %-28s %-16s adjoint % .9e  differences % .9e  error %.1e  slope %.2f%s\n", scene,
                      QUANTITIES[k], r.adjoint, r.finite_difference, r.relative_error, r.taylor_slope,
                      r.one_sided ? "  (one-sided)" : "");
        if (!(r.relative_error <= 1e-6) || !(r.gradient_norm > 0) || !(fabs(r.taylor_slope - 2.0) <= 0.1)) ++failures;
    }
    dqa_controller_free(controller);
    dqa_simulator_free(simulator);
    assert_int_equal(failures, 0);
}

static void all_of(const char* name, dqa_shape_space* space) {
    char scene[64];
    if (!space) skip();
    snprintf(scene, sizeof scene, "%s, 1/2 1/2, from rest", name);
    prove(scene, space, 0.5, 0.0, 0, DQA_WRT_WEIGHTS, DQA_WRT_INITIAL_VELOCITY);
    snprintf(scene, sizeof scene, "%s, moving, current", name);
    prove(scene, space, 0.6, 0.5, 1, DQA_WRT_WEIGHTS, DQA_WRT_INITIAL_VELOCITY);
    snprintf(scene, sizeof scene, "%s, vertex 1 0", name);
    prove(scene, space, 1.0, 0.0, 0, DQA_WRT_WEIGHTS, DQA_WRT_WEIGHTS);
    snprintf(scene, sizeof scene, "%s, vertex 0 1, current", name);
    prove(scene, space, 0.0, 0.5, 0, DQA_WRT_WEIGHTS, DQA_WRT_WEIGHTS);
    dqa_shape_space_free(space);
}

static void shipped_shapes(void** state) {
    (void)state;
    all_of("fish", scene_shipped(28, 10, 14, 1e-10));
}

static void real_meshes(void** state) {
    (void)state;
    all_of("orca/shark", scene_real(30, 8, 14, 1e-10));
}

/* The same for the weights without any help of dqa_check_gradient: rollouts of the public functions, differenced. */
static double loss_at(dqa_shape_space* space, double first_weight, double* bar) {
    dqa_simulator_options o;
    dqa_simulator* simulator;
    dqa_controller* controller;
    dqa_tape* tape;
    dqa_adjoint* adjoint;
    const dqa_objective_term term = scene_travel();
    double loss = NAN;
    o = scene_options();
    o.tolerance = 1e-13, o.adjoint_tolerance = 1e-12;
    simulator = scene_simulator(space, &o, first_weight);
    ok(dqa_controller_create_sinusoid(1, o.time_step, &controller));
    ok(dqa_tape_create(simulator, NULL, &tape));
    ok(dqa_simulator_rollout(simulator, controller, 10, tape, NULL, NULL));
    ok(dqa_tape_objective(tape, &term, 1, &loss, NULL));
    if (bar) {
        ok(dqa_adjoint_create(tape, &adjoint));
        ok(dqa_adjoint_seed_objective(adjoint, &term, 1));
        ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
        ok(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, bar, 2));
        dqa_adjoint_free(adjoint);
    }
    dqa_tape_free(tape);
    dqa_controller_free(controller);
    dqa_simulator_free(simulator);
    return loss;
}

static void weights_by_hand(void** state) {
    dqa_shape_space* space = scene_shipped(28, 10, 14, 1e-13);
    const double w = 0.35, e = 2.5e-4;
    double bar[2], difference, derivative;
    (void)state;
    (void)loss_at(space, w, bar);
    difference = (8 * (loss_at(space, w + e, NULL) - loss_at(space, w - e, NULL)) -
                  (loss_at(space, w + 2 * e, NULL) - loss_at(space, w - 2 * e, NULL))) /
                 (12 * e);
    derivative = bar[0] - bar[1];
    print_message("  by hand: adjoint % .9e  differences % .9e  error %.1e\n", derivative, difference,
                  fabs(derivative / difference - 1));
    assert_true(fabs(bar[0] + bar[1]) <= 1e-12 * fabs(derivative));
    assert_true(fabs(derivative - difference) <= 1e-6 * fabs(difference));
    dqa_shape_space_free(space);
}

int main(void) {
    if (scene_skipped()) return 77;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shipped_shapes),
        cmocka_unit_test(real_meshes),
        cmocka_unit_test(weights_by_hand),
    };
    return cmocka_run_group_tests_name("derivatives of the whole chain", tests, NULL, NULL);
}
