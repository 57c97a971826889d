/* SPDX-License-Identifier: MIT
 * Materials, integrators, methods and constraints through the interface: moduli by cell, fixed nodes, plane spaces, and
 * the gradients by all of them. */
#include "space.h"

enum { STEPS = 3, N_NODES = (NX + 1) * (NY + 1) * (NZ + 1) };

static dqa_simulator* simulator_of(const dqa_simulator_options* options) {
    dqa_simulator* simulator = NULL;
    ok(dqa_simulator_create(space, options, &simulator));
    ok(dqa_simulator_set_weights(simulator, HALF, N_BASES, NULL, NULL));
    return simulator;
}

static dqa_simulator_options defaults(void) {
    dqa_simulator_options o;
    ok(dqa_simulator_options_init(&o, sizeof o));
    return o;
}

/* Travel of a short rollout from rest; and, if asked for, a gradient. */
static double travel(dqa_simulator* simulator, int32_t with_respect_to, double* gradient, int64_t n) {
    dqa_objective_term term;
    dqa_adjoint* adjoint = NULL;
    dqa_tape* tape;
    double loss = 0.0;
    ok(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0));
    tape = tiny_tape(simulator, STEPS);
    ok(dqa_objective_term_init(&term, sizeof term));
    ok(dqa_tape_objective(tape, &term, 1, &loss, NULL));
    if (gradient) {
        ok(dqa_adjoint_create(tape, &adjoint));
        ok(dqa_adjoint_seed_objective(adjoint, &term, 1));
        ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
        refused(dqa_adjoint_get(adjoint, with_respect_to, gradient, n + 1), DQA_ERROR_ARGUMENT, "n");
        ok(dqa_adjoint_get(adjoint, with_respect_to, gradient, n));
    }
    dqa_adjoint_free(adjoint);
    dqa_tape_free(tape);
    return loss;
}

static void choices_differ_and_methods_agree(void** state) {
    static const int32_t materials[] = {DQA_MATERIAL_COROTATED, DQA_MATERIAL_COROTATED_VOLUME,
                                        DQA_MATERIAL_NEO_HOOKEAN};
    double loss[3][2][2];
    int m, i, p;
    (void)state;
    for (m = 0; m < 3; ++m)
        for (i = 0; i < 2; ++i)
            for (p = 0; p < 2; ++p) {
                dqa_simulator_options o = defaults();
                dqa_simulator* simulator;
                o.material = materials[m];
                o.integrator = i ? DQA_INTEGRATOR_BDF2 : DQA_INTEGRATOR_IMPLICIT_EULER;
                o.method = p ? DQA_METHOD_PROJECTIVE : DQA_METHOD_NEWTON_PCG;
                o.tolerance = 1e-9;
                simulator = simulator_of(&o);
                loss[m][i][p] = travel(simulator, 0, NULL, 0);
                dqa_simulator_free(simulator);
            }
    for (m = 0; m < 3; ++m)
        for (i = 0; i < 2; ++i) {
            assert_true(loss[m][i][0] != 0.0);
            assert_true(fabs(loss[m][i][1] - loss[m][i][0]) <= 1e-5 * fabs(loss[m][i][0]));
            assert_true(fabs(loss[m][0][0] - loss[m][1][0]) > 1e-4 * fabs(loss[m][0][0]));
            assert_true(m == 0 || fabs(loss[m][i][0] - loss[m - 1][i][0]) > 1e-4 * fabs(loss[0][i][0]));
        }
}

static void moduli_by_cell(void** state) {
    dqa_simulator* simulator = simulator_of(NULL);
    double *young = doubles(N_CELLS), *muscle = doubles(N_CELLS), *bar = doubles(N_CELLS);
    double uniform[4], sum = 0.0, muscle_sum = 0.0;
    double lame[2];
    const double plain = travel(simulator, DQA_WRT_MATERIAL, uniform, 4);
    int64_t c;
    (void)state;
    /* The options' own values, cell by cell, change nothing. */
    for (c = 0; c < N_CELLS; ++c) young[c] = 5e6, muscle[c] = 2e6;
    ok(dqa_simulator_set_material(simulator, young, muscle, N_CELLS));
    assert_true(travel(simulator, DQA_WRT_YOUNGS_MODULUS, bar, N_CELLS) == plain);
    for (c = 0; c < N_CELLS; ++c) sum += bar[c];
    assert_true(uniform[0] != 0.0 && fabs(sum - uniform[0]) <= 1e-9 * fabs(uniform[0]));
    assert_true(travel(simulator, DQA_WRT_MUSCLE_STIFFNESS, bar, N_CELLS) == plain);
    for (c = 0; c < N_CELLS; ++c) muscle_sum += bar[c];
    assert_true(uniform[1] != 0.0 && fabs(muscle_sum - uniform[1]) <= 1e-9 * fabs(uniform[1]));
    /* The corotated energy without its volume term depends on mu = E / (2 (1 + nu)) alone. */
    (void)travel(simulator, DQA_WRT_LAME, lame, 2);
    assert_true(fabs(lame[0] / (2.0 * 1.45) - uniform[0]) <= 1e-9 * fabs(uniform[0]) && lame[1] == 0.0);
    assert_true(fabs(uniform[2] + lame[0] * 5e6 / (2.0 * 1.45 * 1.45)) <= 1e-9 * fabs(uniform[2]));
    /* A first-order step in one cell's modulus. */
    for (c = 0; c < N_CELLS; ++c) young[c] *= 1.0 + 0.3 * sin(0.7 * (double)c);
    ok(dqa_simulator_set_material(simulator, young, NULL, N_CELLS));
    assert_true(travel(simulator, 0, NULL, 0) != plain);
    ok(dqa_simulator_set_weights(simulator, HALF, N_BASES, NULL, NULL)); /* later designs have it too */
    assert_true(travel(simulator, 0, NULL, 0) != plain);
    refused(dqa_simulator_set_material(simulator, young, NULL, N_CELLS - 1), DQA_ERROR_ARGUMENT, "n");
    refused(dqa_simulator_set_material(NULL, NULL, NULL, 0), DQA_ERROR_ARGUMENT, "simulator");
    young[7] = 0.0;
    refused(dqa_simulator_set_material(simulator, young, NULL, N_CELLS), DQA_ERROR_ARGUMENT, "young_modulus");
    muscle[9] = -1.0;
    refused(dqa_simulator_set_material(simulator, NULL, muscle, N_CELLS), DQA_ERROR_ARGUMENT, "muscle_stiffness");
    muscle[9] = NAN;
    refused(dqa_simulator_set_material(simulator, NULL, muscle, N_CELLS), DQA_ERROR_ARGUMENT, "muscle_stiffness");
    ok(dqa_simulator_set_material(simulator, NULL, NULL, 0));
    assert_true(travel(simulator, 0, NULL, 0) == plain);
    free(young), free(muscle), free(bar);
    dqa_simulator_free(simulator);
}

static void nodes_stay_where_they_are(void** state) {
    dqa_simulator* simulator = NULL;
    dqa_simulator_info info;
    int32_t fixed[(NY + 1) * (NZ + 1)], *box;
    double *q, *rest;
    int64_t n, k, held = 0, moved = 0;
    (void)state;
    for (k = 0; k < (NY + 1) * (NZ + 1); ++k) fixed[k] = (int32_t)((NX / 2) * (NY + 1) * (NZ + 1) + k);
    ok(dqa_simulator_create(space, NULL, &simulator));
    ok(dqa_simulator_set_fixed_nodes(simulator, fixed, (NY + 1) * (NZ + 1))); /* before there is a design */
    refused(dqa_simulator_node_box_index(simulator, fixed, 1), DQA_ERROR_STATE, "design");
    ok(dqa_simulator_set_weights(simulator, HALF, N_BASES, NULL, NULL));
    ok(dqa_simulator_get_info(simulator, &info, sizeof info));
    box = malloc((size_t)info.n_nodes * sizeof *box);
    assert_non_null(box);
    refused(dqa_simulator_node_box_index(simulator, box, info.n_nodes + 1), DQA_ERROR_ARGUMENT, "n");
    ok(dqa_simulator_node_box_index(simulator, box, info.n_nodes));
    n = 3 * info.n_nodes;
    q = doubles(n), rest = doubles(n);
    ok(dqa_simulator_get_state(simulator, rest, n, NULL, 0));
    (void)travel(simulator, 0, NULL, 0);
    ok(dqa_simulator_get_state(simulator, q, n, NULL, 0));
    for (k = 0; k < info.n_nodes; ++k) {
        const int same = memcmp(q + 3 * k, rest + 3 * k, 3 * sizeof *q) == 0;
        assert_in_range(box[k], 0, N_NODES - 1);
        if (box[k] / ((NY + 1) * (NZ + 1)) == NX / 2) {
            assert_true(same);
            ++held;
        } else if (!same) {
            ++moved;
        }
    }
    assert_true(held > 4 && moved > info.n_nodes / 2);
    fixed[0] = N_NODES;
    refused(dqa_simulator_set_fixed_nodes(simulator, fixed, 1), DQA_ERROR_ARGUMENT, "nodes");
    refused(dqa_simulator_set_fixed_nodes(simulator, NULL, 1), DQA_ERROR_ARGUMENT, "nodes");
    refused(dqa_simulator_set_fixed_nodes(simulator, fixed, -1), DQA_ERROR_ARGUMENT, "n");
    ok(dqa_simulator_set_fixed_nodes(simulator, NULL, 0));
    (void)travel(simulator, 0, NULL, 0);
    ok(dqa_simulator_get_state(simulator, q, n, NULL, 0));
    for (held = 0, k = 0; k < n; ++k) held += q[k] == rest[k];
    assert_true(held < n / 4);
    free(box), free(q), free(rest);
    dqa_simulator_free(simulator);
}

static void planar_motion(void** state) {
    dqa_simulator_options o = defaults();
    dqa_simulator* simulator;
    int64_t n, k;
    double *q, *rest;
    (void)state;
    o.planar = 1;
    simulator = simulator_of(&o);
    n = state_length(simulator);
    q = doubles(n), rest = doubles(n);
    ok(dqa_simulator_get_state(simulator, rest, n, NULL, 0));
    assert_true(travel(simulator, 0, NULL, 0) != 0.0);
    ok(dqa_simulator_get_state(simulator, q, n, NULL, 0));
    for (k = 2; k < n; k += 3) assert_true(q[k] == rest[k]);
    free(q), free(rest);
    dqa_simulator_free(simulator);
}

static void ranges(void** state) {
    dqa_simulator* simulator = NULL;
    dqa_simulator_options o;
    (void)state;
    o = defaults(), o.material = 3;
    refused(dqa_simulator_create(space, &o, &simulator), DQA_ERROR_ARGUMENT, "material");
    o = defaults(), o.integrator = 2;
    refused(dqa_simulator_create(space, &o, &simulator), DQA_ERROR_ARGUMENT, "integrator");
    o = defaults(), o.planar = 2;
    refused(dqa_simulator_create(space, &o, &simulator), DQA_ERROR_ARGUMENT, "planar");
    o = defaults(), o.preconditioner = 7;
    refused(dqa_simulator_create(space, &o, &simulator), DQA_ERROR_ARGUMENT, "preconditioner");
    assert_null(simulator);
}

/* The whole chain in two dimensions: every array has two components, the surface is made of segments. */
static void in_the_plane(void** state) {
    dqa_shape_space_options s = tiny_options();
    dqa_shape_space* plane = NULL;
    dqa_simulator* simulator = NULL;
    dqa_simulator_info info;
    dqa_tape* tape;
    dqa_adjoint* adjoint = NULL;
    dqa_objective_term term;
    double *cells = doubles(NX * NY), *q, *bar, *vertices, forces[8], weights_bar[2];
    int64_t n, n_vertices = 0, n_segments = 0, k;
    int32_t *segments, *nodes;
    int base, i, j;
    (void)state;
    s.dims = 2;
    ok(dqa_shape_space_create(&s, &plane));
    for (base = 0; base < 2; ++base) {
        for (i = 0; i < NX; ++i)
            for (j = 0; j < NY; ++j) {
                const double x = (i + 0.5 - 0.5 * NX) / (base ? 4.7 : 6.2),
                             y = (j + 0.5 - 0.5 * NY) / (base ? 2.6 : 1.9);
                cells[i * NY + j] = fmin(1.0, fmax(0.0, 3.0 - 2.5 * (x * x + y * y)));
            }
        ok(dqa_shape_space_add_density(plane, base ? "round" : "long", cells, NX * NY, NULL));
    }
    ok(dqa_shape_space_build(plane, NULL, NULL));
    ok(dqa_simulator_create(plane, NULL, &simulator));
    ok(dqa_simulator_set_weights(simulator, HALF, N_BASES, NULL, NULL));
    ok(dqa_simulator_get_info(simulator, &info, sizeof info));
    assert_int_equal(info.dims, 2);
    n = 2 * info.n_nodes;
    q = doubles(n), bar = doubles(n);
    tape = tiny_tape(simulator, STEPS);
    ok(dqa_simulator_get_state(simulator, q, n, NULL, 0));
    ok(dqa_simulator_forces(simulator, forces, 8));
    assert_true(forces[0] != 0.0);
    ok(dqa_simulator_surface(simulator, NULL, 0, NULL, 0, &n_vertices, &n_segments));
    assert_true(n_vertices == n_segments && n_segments > 8);
    vertices = doubles(2 * n_vertices);
    segments = malloc(2 * (size_t)n_segments * sizeof *segments);
    nodes = malloc(4 * (size_t)info.n_active_cells * sizeof *nodes);
    assert_true(segments != NULL && nodes != NULL);
    ok(dqa_simulator_surface(simulator, vertices, 2 * n_vertices, segments, 2 * n_segments, NULL, NULL));
    ok(dqa_tape_get_surface(tape, STEPS, vertices, 2 * n_vertices));
    ok(dqa_simulator_mesh(simulator, nodes, 4 * info.n_active_cells, NULL, 0, NULL, 0));
    for (k = 0; k < 4 * info.n_active_cells; ++k) assert_in_range(nodes[k], 0, info.n_nodes - 1);
    for (k = 0; k < 2 * n_segments; ++k) assert_in_range(segments[k], 0, n_vertices - 1);
    ok(dqa_objective_term_init(&term, sizeof term));
    ok(dqa_adjoint_create(tape, &adjoint));
    ok(dqa_adjoint_seed_objective(adjoint, &term, 1));
    ok(dqa_adjoint_seed(adjoint, STEPS, DQA_SEED_VELOCITY, q, n));
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, weights_bar, 2));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_INITIAL_POSITION, bar, n));
    assert_true(weights_bar[0] != 0.0 && fabs(weights_bar[0] + weights_bar[1]) < 1e-12);
    dqa_adjoint_free(adjoint);
    dqa_tape_free(tape);
    ok(dqa_simulator_set_state(simulator, q, n, NULL, 0));
    free(cells), free(q), free(bar), free(vertices), free(segments), free(nodes);
    dqa_simulator_free(simulator);
    dqa_shape_space_free(plane);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(choices_differ_and_methods_agree),
        cmocka_unit_test(moduli_by_cell),
        cmocka_unit_test(nodes_stay_where_they_are),
        cmocka_unit_test(planar_motion),
        cmocka_unit_test(ranges),
        cmocka_unit_test(in_the_plane),
    };
    return cmocka_run_group_tests_name("material", tests, open_space, close_space);
}
