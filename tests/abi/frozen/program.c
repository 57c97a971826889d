/* SPDX-License-Identifier: MIT
 * A caller of version 0.1: compiled against the header frozen beside it, run against the library of today. It takes a
 * few steps down the gradient of a plane swimmer and checks what it gets: the gradient against finite differences, a
 * loss that falls, options and infos that mean what they meant.
 *
 * A released header stays as it is, and so does this program. Until the release of 0.1 the header follows the current
 * one by `tests/abi/freeze.py BUILD`. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "diffaqua-0.1.h"

static int failures = 0;

static void expect(int condition, const char* what) {
    if (condition) return;
    fprintf(stderr, "not so: %s (last error: %s)\n", what, dqa_last_error());
    ++failures;
}
#define EXPECT(condition) expect(condition, #condition)
#define OK(call) expect((call) == DQA_SUCCESS, #call)

enum { N_BASES = 2, N_STEPS = 12, DIMS = 2 };

static dqa_shape_space* make_space(void) {
    static const double slender[] = {-0.5, -0.05, 0.0, -0.08, 0.5, 0.0, 0.0, 0.08, -0.5, 0.05};
    static const double stout[] = {-0.5, -0.15, -0.3, -0.05, 0.2, -0.2, 0.5, 0.0, 0.2, 0.2, -0.3, 0.05, -0.5, 0.15};
    dqa_shape_space_options options;
    dqa_shape_space_info info;
    dqa_shape_space* space = NULL;
    int32_t base = -1;
    OK(dqa_shape_space_options_init(&options, sizeof options));
    EXPECT(options.struct_size == sizeof options && options.dims == 3 && options.cells_x == 60);
    options.dims = DIMS, options.cells_x = 32, options.cells_y = 16;
    OK(dqa_shape_space_create(&options, &space));
    OK(dqa_shape_space_add_polygon(space, "slender", slender, 5, &base));
    EXPECT(base == 0);
    OK(dqa_shape_space_add_polygon(space, "stout", stout, 7, &base));
    EXPECT(base == 1);
    OK(dqa_shape_space_build(space, NULL, NULL));
    memset(&info, 0xff, sizeof info);
    OK(dqa_shape_space_get_info(space, &info, sizeof info));
    EXPECT(info.dims == DIMS && info.n_bases == N_BASES && info.n_signals == 1 && info.is_built == 1);
    EXPECT(info.n_cells == 32 * 16 && info.cell_size > 0.02 && info.cell_size < 0.05);
    EXPECT(strcmp(dqa_shape_space_base_name(space, 1), "stout") == 0);
    return space;
}

static int32_t count(int64_t done, int64_t total, void* user_data) {
    EXPECT(done <= total && total == N_STEPS);
    ++*(int*)user_data;
    return 0;
}

/* One rollout: its loss, and the gradient by the weights. */
static double descend(dqa_simulator* simulator, const dqa_controller* sine, const double* weights, double* gradient) {
    dqa_simulator_info info;
    dqa_tape_statistics statistics;
    dqa_objective_term terms[2];
    dqa_controller* controller = NULL;
    dqa_adjoint* adjoint = NULL;
    dqa_tape* tape = NULL;
    double theta[3], theta_bar[3], parts[2], loss = NAN;
    int calls = 0;

    OK(dqa_controller_get_parameters(sine, theta, 3));
    OK(dqa_controller_create_sinusoid(1, 1.0 / 30.0, &controller));
    OK(dqa_controller_set_parameters(controller, theta, 3));
    OK(dqa_objective_term_init(&terms[0], sizeof terms[0]));
    OK(dqa_objective_term_init(&terms[1], sizeof terms[1]));
    EXPECT(terms[0].kind == DQA_OBJECTIVE_TRAVEL && terms[0].weight == 1.0);
    terms[1].kind = DQA_OBJECTIVE_EFFORT, terms[1].weight = 1e-3;

    OK(dqa_simulator_set_weights(simulator, weights, N_BASES, NULL, NULL));
    OK(dqa_tape_create(simulator, NULL, &tape));
    OK(dqa_simulator_rollout(simulator, controller, N_STEPS, tape, count, &calls));
    EXPECT(calls > 0);
    OK(dqa_simulator_get_info(simulator, &info, sizeof info));
    EXPECT(info.has_design == 1 && info.steps == N_STEPS && fabs(info.time - N_STEPS / 30.0) < 1e-12);
    EXPECT(info.n_sensors == 5 * DIMS && info.n_nodes > info.n_active_cells && info.last_residual <= 1e-6);
    OK(dqa_tape_objective(tape, terms, 2, &loss, parts));
    EXPECT(fabs(parts[0] + 1e-3 * parts[1] - loss) <= 1e-15 && parts[1] > 0.0);

    OK(dqa_adjoint_create(tape, &adjoint));
    OK(dqa_adjoint_seed_objective(adjoint, terms, 2));
    OK(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    OK(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, gradient, N_BASES));
    OK(dqa_adjoint_get(adjoint, DQA_WRT_CONTROL, theta_bar, 3));
    EXPECT(fabs(gradient[0] + gradient[1]) <= 1e-9 * fabs(gradient[0]) && theta_bar[0] != 0.0);
    OK(dqa_tape_stats(tape, &statistics, sizeof statistics));
    EXPECT(statistics.steps == N_STEPS && statistics.checkpoints == N_STEPS + 1 && statistics.adjoint_iterations > 0);
    dqa_tape_free(tape); /* before its child */
    dqa_adjoint_free(adjoint);
    dqa_controller_free(controller);
    return loss;
}

static void prove(const dqa_simulator* simulator, const dqa_controller* sine, int32_t with_respect_to) {
    dqa_gradient_check_options options;
    dqa_gradient_check_report report;
    dqa_objective_term travel;
    OK(dqa_objective_term_init(&travel, sizeof travel));
    OK(dqa_gradient_check_options_init(&options, sizeof options));
    options.with_respect_to = with_respect_to, options.n_steps = N_STEPS;
    OK(dqa_check_gradient(simulator, sine, &travel, 1, &options, &report, sizeof report));
    EXPECT(report.gradient_norm > 0.0 && report.relative_error <= 1e-6);
}

int main(void) {
    double weights[N_BASES] = {0.5, 0.5}, rates[N_BASES] = {0.05, 0.05}, first[N_BASES] = {0}, second[N_BASES] = {0};
    double gradient[N_BASES], losses[3], x[4] = {0};
    dqa_shape_space* space = make_space();
    dqa_simulator_options options;
    dqa_simulator* simulator = NULL;
    dqa_controller* sine = NULL;

    EXPECT(dqa_abi_version() == DQA_ABI_VERSION);
    OK(dqa_simulator_options_init(&options, sizeof options));
    EXPECT(options.water == DQA_WATER_IMPLICIT && fabs(options.time_step - 1.0 / 30.0) < 1e-15);
    OK(dqa_simulator_create(space, &options, &simulator));
    dqa_shape_space_free(space); /* before its child */
    OK(dqa_controller_create_sinusoid(1, options.time_step, &sine));
    for (int k = 0; k < 3 && failures == 0; ++k) {
        losses[k] = descend(simulator, sine, weights, gradient);
        printf("%.4f %.4f: loss %.8f, gradient %.3e\n", weights[0], weights[1], losses[k], gradient[0]);
        OK(dqa_adam_step(weights, gradient, rates, first, second, N_BASES, k + 1));
        OK(dqa_project_simplex(weights, N_BASES));
        if (k > 0) EXPECT(losses[k] < losses[k - 1]);
    }
    prove(simulator, sine, DQA_WRT_WEIGHTS);
    prove(simulator, sine, DQA_WRT_CONTROL);

    /* Errors keep their numbers, and a struct of a size that never was is refused. */
    EXPECT(dqa_simulator_sensors(simulator, x, 4) == DQA_ERROR_ARGUMENT && dqa_last_error()[0] != '\0');
    EXPECT(strcmp(dqa_status_name(DQA_ERROR_ARGUMENT), "DQA_ERROR_ARGUMENT") == 0);
    EXPECT(dqa_simulator_options_init(&options, 4) == DQA_ERROR_ARGUMENT);
    dqa_controller_free(sine);
    dqa_simulator_free(simulator);
    printf("%d failures\n", failures);
    return failures != 0;
}
