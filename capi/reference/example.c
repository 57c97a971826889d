/* SPDX-License-Identifier: MIT
 * The example of the guide: finds the mix of two fish that travels farther, by descent along the gradient. */
#include <diffaqua.h>
#include <stdio.h>
#include <stdlib.h>

/* Leaves with the library's own words when a call fails. */
static void ok(dqa_status status) {
    if (status == DQA_SUCCESS) return;
    fprintf(stderr, "%s: %s\n", dqa_status_name(status), dqa_last_error());
    exit(1);
}

int main(void) {
    /* Outlines, seen from above: the head points along +x. */
    static const double slender[] = {-0.5, -0.05, 0.0, -0.08, 0.5, 0.0, 0.0, 0.08, -0.5, 0.05};
    static const double stout[] = {-0.5, -0.15, -0.3, -0.05, 0.2, -0.2, 0.5, 0.0, 0.2, 0.2, -0.3, 0.05, -0.5, 0.15};
    double weights[2] = {0.5, 0.5}, gradient[2], rates[2] = {0.02, 0.02}, first[2] = {0, 0}, second[2] = {0, 0}, loss;
    dqa_shape_space_options options;
    dqa_objective_term travel;
    dqa_shape_space* space;
    dqa_simulator* simulator;
    dqa_controller* sine;
    dqa_tape* tape;

    ok(dqa_shape_space_options_init(&options, sizeof options));
    options.dims = 2;
    options.cells_x = 32;
    options.cells_y = 16;
    ok(dqa_shape_space_create(&options, &space));
    ok(dqa_shape_space_add_polygon(space, "slender", slender, 5, NULL));
    ok(dqa_shape_space_add_polygon(space, "stout", stout, 7, NULL));
    ok(dqa_shape_space_build(space, NULL, NULL));

    ok(dqa_simulator_create(space, NULL, &simulator)); /* NULL: the defaults */
    ok(dqa_controller_create_sinusoid(1, 1.0 / 30.0, &sine));
    ok(dqa_tape_create(simulator, NULL, &tape));
    ok(dqa_objective_term_init(&travel, sizeof travel)); /* minus the distance travelled */

    for (int k = 1; k <= 3; ++k) {
        dqa_adjoint* adjoint;
        ok(dqa_simulator_set_weights(simulator, weights, 2, NULL, NULL)); /* a new design, at rest */
        ok(dqa_tape_clear(tape));
        ok(dqa_simulator_rollout(simulator, sine, 12, tape, NULL, NULL));
        ok(dqa_tape_objective(tape, &travel, 1, &loss, NULL));

        ok(dqa_adjoint_create(tape, &adjoint));
        ok(dqa_adjoint_seed_objective(adjoint, &travel, 1));
        ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
        ok(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, gradient, 2));
        dqa_adjoint_free(adjoint);

        printf("%.3f %.3f: loss %.6f m\n", weights[0], weights[1], loss);
        ok(dqa_adam_step(weights, gradient, rates, first, second, 2, k));
        ok(dqa_project_simplex(weights, 2));
    }
    dqa_tape_free(tape);
    dqa_controller_free(sine);
    dqa_simulator_free(simulator);
    dqa_shape_space_free(space);
    return 0;
}
