/* SPDX-License-Identifier: MIT
 * The simulator: designs, steps, state, and what it tells about itself. */
#include "space.h"

static dqa_simulator_info info_of(const dqa_simulator* simulator) {
    dqa_simulator_info info;
    ok(dqa_simulator_get_info(simulator, &info, sizeof info));
    return info;
}

static void null_arguments(void** state) {
    dqa_simulator* simulator = tiny_simulator(space);
    dqa_controller* controller = tiny_controller(simulator);
    dqa_simulator_info info;
    double x[64] = {0};
    (void)state;
    refused(dqa_simulator_create(space, NULL, NULL), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_set_weights(NULL, HALF, N_BASES, NULL, NULL), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_set_weights(simulator, NULL, N_BASES, NULL, NULL), DQA_ERROR_ARGUMENT, "weights");
    refused(dqa_simulator_get_info(NULL, &info, sizeof info), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_get_info(simulator, NULL, sizeof info), DQA_ERROR_ARGUMENT, "info");
    refused(dqa_simulator_get_weights(NULL, x, N_BASES), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_get_weights(simulator, NULL, N_BASES), DQA_ERROR_ARGUMENT, "weights");
    refused(dqa_simulator_step(NULL, x, 2, NULL), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_step(simulator, NULL, info_of(simulator).n_signals, NULL), DQA_ERROR_ARGUMENT, "actuation");
    refused(dqa_simulator_rollout(NULL, controller, 1, NULL, NULL, NULL), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_rollout(simulator, NULL, 1, NULL, NULL, NULL), DQA_ERROR_ARGUMENT, "controller");
    refused(dqa_simulator_get_state(NULL, x, 1, NULL, 0), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_set_state(NULL, NULL, 0, NULL, 0), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_sensors(NULL, x, 15), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_sensors(simulator, NULL, info_of(simulator).n_sensors), DQA_ERROR_ARGUMENT, "sensors");
    refused(dqa_simulator_forces(NULL, x, 12), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_forces(simulator, NULL, 12), DQA_ERROR_ARGUMENT, "forces");
    refused(dqa_simulator_surface(NULL, NULL, 0, NULL, 0, NULL, NULL), DQA_ERROR_ARGUMENT, "simulator");
    refused(dqa_simulator_mesh(NULL, NULL, 0, NULL, 0, NULL, 0), DQA_ERROR_ARGUMENT, "simulator");
    dqa_simulator_free(NULL);
    dqa_controller_free(controller);
    dqa_simulator_free(simulator);
}

static void create_needs_a_built_space(void** state) {
    dqa_shape_space* open = tiny_space_open();
    dqa_simulator* simulator = (dqa_simulator*)&simulator;
    (void)state;
    assert_int_equal(dqa_simulator_create(open, NULL, &simulator), DQA_ERROR_STATE);
    assert_null(simulator);
    simulator = (dqa_simulator*)&simulator;
    refused(dqa_simulator_create(NULL, NULL, &simulator), DQA_ERROR_ARGUMENT, "space");
    assert_null(simulator);
    dqa_shape_space_free(open);
}

static void most_calls_need_a_design(void** state) {
    dqa_simulator* simulator = NULL;
    dqa_simulator* designed = tiny_simulator(space);
    dqa_controller* controller = tiny_controller(designed);
    dqa_gradient_check_report report;
    dqa_objective_term term;
    dqa_simulator_info info;
    double x[64] = {0};
    int32_t i[8];
    (void)state;
    ok(dqa_simulator_create(space, NULL, &simulator));
    info = info_of(simulator);
    assert_int_equal(info.has_design, 0);
    assert_int_equal(info.n_bases, N_BASES);
    assert_int_equal(dqa_simulator_get_weights(simulator, x, N_BASES), DQA_ERROR_STATE);
    assert_int_equal(dqa_simulator_step(simulator, x, info.n_signals, NULL), DQA_ERROR_STATE);
    assert_int_equal(dqa_simulator_rollout(simulator, controller, 1, NULL, NULL, NULL), DQA_ERROR_STATE);
    assert_int_equal(dqa_simulator_get_state(simulator, x, 3, NULL, 0), DQA_ERROR_STATE);
    assert_int_equal(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0), DQA_ERROR_STATE);
    assert_int_equal(dqa_simulator_sensors(simulator, x, 15), DQA_ERROR_STATE);
    assert_int_equal(dqa_simulator_forces(simulator, x, 12), DQA_ERROR_STATE);
    assert_int_equal(dqa_simulator_surface(simulator, x, 3, i, 3, NULL, NULL), DQA_ERROR_STATE);
    assert_int_equal(dqa_simulator_mesh(simulator, i, 8, NULL, 0, NULL, 0), DQA_ERROR_STATE);
    ok(dqa_objective_term_init(&term, sizeof term));
    assert_int_equal(dqa_check_gradient(simulator, NULL, &term, 1, NULL, &report, sizeof report), DQA_ERROR_STATE);
    dqa_simulator_free(simulator);
    dqa_controller_free(controller);
    dqa_simulator_free(designed);
}

static void designs_are_checked_and_kept(void** state) {
    static const double wrong[][N_BASES] = {{0.6, 0.5}, {-0.1, 1.1}, {NAN, 0.5}, {0.5, INFINITY}, {0.0, 0.0}};
    static const double other[N_BASES] = {1.0, 0.0};
    dqa_simulator* simulator = tiny_simulator(space);
    dqa_simulator_info before = info_of(simulator), after;
    double actuation[64] = {0};
    double weights[N_BASES];
    size_t i;
    (void)state;
    ok(dqa_simulator_step(simulator, actuation, before.n_signals, NULL));
    for (i = 0; i < sizeof wrong / sizeof *wrong; ++i)
        refused(dqa_simulator_set_weights(simulator, wrong[i], N_BASES, NULL, NULL), DQA_ERROR_ARGUMENT, "weights");
    refused(dqa_simulator_set_weights(simulator, HALF, N_BASES + 1, NULL, NULL), DQA_ERROR_ARGUMENT, "weights|m");
    assert_int_equal(dqa_simulator_set_weights(simulator, other, N_BASES, cancel_at_once, NULL), DQA_CANCELLED);
    after = info_of(simulator);
    assert_int_equal(after.n_active_cells, before.n_active_cells);
    assert_int_equal(after.steps, 1);
    ok(dqa_simulator_get_weights(simulator, weights, N_BASES));
    assert_memory_equal(weights, HALF, sizeof weights);
    refused(dqa_simulator_get_weights(simulator, weights, 1), DQA_ERROR_ARGUMENT, "weights|m");

    ok(dqa_simulator_set_weights(simulator, other, N_BASES, NULL, NULL));
    assert_int_equal(info_of(simulator).steps, 0);
    dqa_simulator_free(simulator);
}

static void thresholds_are_suggested(void** state) {
    static const double wrong[][N_BASES] = {{0.6, 0.5}, {-0.1, 1.1}, {NAN, 0.5}};
    static const double not_errors[] = {0.0, 1.0, -0.1, 2.0, NAN, INFINITY};
    dqa_simulator *simulator = NULL, *designed = tiny_simulator(space);
    double threshold = -7.0, estimate = -7.0, again = 0.0, finer = 0.0;
    size_t i;
    (void)state;
    ok(dqa_simulator_create(space, NULL, &simulator));
    refused(dqa_simulator_suggest_threshold(NULL, HALF, N_BASES, 0.05, &threshold, &estimate), DQA_ERROR_ARGUMENT,
            "simulator");
    refused(dqa_simulator_suggest_threshold(simulator, NULL, N_BASES, 0.05, &threshold, &estimate), DQA_ERROR_ARGUMENT,
            "weights");
    refused(dqa_simulator_suggest_threshold(simulator, HALF, N_BASES + 1, 0.05, &threshold, &estimate),
            DQA_ERROR_ARGUMENT, "weights|m");
    for (i = 0; i < sizeof wrong / sizeof *wrong; ++i)
        refused(dqa_simulator_suggest_threshold(simulator, wrong[i], N_BASES, 0.05, &threshold, &estimate),
                DQA_ERROR_ARGUMENT, "weights");
    for (i = 0; i < sizeof not_errors / sizeof *not_errors; ++i)
        refused(dqa_simulator_suggest_threshold(simulator, HALF, N_BASES, not_errors[i], &threshold, &estimate),
                DQA_ERROR_ARGUMENT, "tolerance");
    refused(dqa_simulator_suggest_threshold(simulator, HALF, N_BASES, 0.05, NULL, &estimate), DQA_ERROR_ARGUMENT,
            "threshold");
    assert_true(threshold == -7.0 && estimate == -7.0);

    /* With a design or without one, and whatever its own threshold: the same bits. */
    ok(dqa_simulator_suggest_threshold(simulator, HALF, N_BASES, 0.05, &threshold, &estimate));
    assert_true(threshold >= 1e-4 && threshold < 0.5 && estimate > 0.0 && estimate <= 0.05);
    assert_int_equal(info_of(simulator).has_design, 0);
    ok(dqa_simulator_suggest_threshold(designed, HALF, N_BASES, 0.05, &again, NULL));
    assert_true(again == threshold);
    ok(dqa_simulator_suggest_threshold(simulator, HALF, N_BASES, 0.005, &finer, &estimate));
    assert_true(finer < threshold && estimate <= 0.005);
    /* What no threshold can keep is the full box; what any keeps is the largest. */
    ok(dqa_simulator_suggest_threshold(simulator, HALF, N_BASES, 1e-12, &finer, &estimate));
    assert_true(finer == 0.0 && estimate == 0.0);
    ok(dqa_simulator_suggest_threshold(simulator, HALF, N_BASES, 0.999999, &threshold, &estimate));
    assert_true(threshold < 0.5 && estimate < 1.0);
    dqa_simulator_free(simulator);
    dqa_simulator_free(designed);
}

static void info_is_consistent(void** state) {
    dqa_simulator* simulator = tiny_simulator(space);
    const dqa_simulator_info info = info_of(simulator);
    (void)state;
    assert_int_equal(info.struct_size, sizeof info);
    assert_int_equal(info.dims, 3);
    assert_int_equal(info.has_design, 1);
    assert_true(info.n_signals > 0 && info.n_sensors == 15);
    assert_true(info.n_body_cells > 0 && info.n_active_cells >= info.n_body_cells);
    assert_true(info.n_muscle_cells > 0 && info.n_muscle_cells <= info.n_active_cells);
    assert_true(info.n_nodes > info.n_active_cells && info.n_nodes <= 8 * info.n_active_cells);
    assert_true(info.n_faces > 0 && info.factor_entries >= info.n_nodes);
    assert_true(info.cell_size == 0.1 && info.time == 0.0 && info.steps == 0);
    assert_true(info.volume > 0.0);
    assert_true(fabs(info.total_mass - 1000.0 * info.volume) <= 0.2 * info.total_mass);
    dqa_simulator_free(simulator);
}

static void actuation_is_checked(void** state) {
    dqa_simulator* simulator = tiny_simulator(space);
    const dqa_simulator_info info = info_of(simulator);
    static const double wrong[] = {1.5, -1.5, NAN, INFINITY};
    double u[64] = {0};
    const int64_t n = state_length(simulator);
    double *before = doubles(n), *after = doubles(n);
    size_t i;
    (void)state;
    ok(dqa_simulator_get_state(simulator, before, n, NULL, 0));
    refused(dqa_simulator_step(simulator, u, info.n_signals + 1, NULL), DQA_ERROR_ARGUMENT, "actuation|n");
    refused(dqa_simulator_step(simulator, u, -1, NULL), DQA_ERROR_ARGUMENT, "actuation|n");
    for (i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        u[0] = wrong[i];
        refused(dqa_simulator_step(simulator, u, info.n_signals, NULL), DQA_ERROR_ARGUMENT, "actuation");
    }
    ok(dqa_simulator_get_state(simulator, after, n, NULL, 0));
    assert_memory_equal(before, after, (size_t)n * sizeof *before);
    assert_int_equal(info_of(simulator).steps, 0);
    u[0] = 1.0;
    ok(dqa_simulator_step(simulator, u, info.n_signals, NULL));
    assert_int_equal(info_of(simulator).steps, 1);
    ok(dqa_simulator_get_state(simulator, after, n, NULL, 0));
    assert_memory_not_equal(before, after, (size_t)n * sizeof *before);
    dqa_simulator_free(simulator);
    free(before);
    free(after);
}

static void state_goes_in_and_out(void** state) {
    dqa_simulator* simulator = tiny_simulator(space);
    const int64_t n = state_length(simulator);
    const size_t bytes = (size_t)n * sizeof(double);
    double *rest = doubles(n), *q = doubles(n), *v = doubles(n), *q2 = doubles(n), *v2 = doubles(n);
    double u[64] = {0};
    int64_t i;
    (void)state;
    ok(dqa_simulator_get_state(simulator, rest, n, v, n));
    for (i = 0; i < n; ++i) assert_true(v[i] == 0.0);
    ok(dqa_simulator_step(simulator, u, info_of(simulator).n_signals, NULL));
    for (i = 0; i < n; ++i) {
        q[i] = rest[i] + 1e-3 * sin((double)i);
        v[i] = 1e-2 * cos((double)i);
    }
    ok(dqa_simulator_set_state(simulator, q, n, v, n));
    assert_int_equal(info_of(simulator).steps, 0);
    ok(dqa_simulator_get_state(simulator, q2, n, v2, n));
    assert_memory_equal(q, q2, bytes);
    assert_memory_equal(v, v2, bytes);

    refused(dqa_simulator_get_state(simulator, q2, n - 1, NULL, 0), DQA_ERROR_ARGUMENT, "q|nq");
    refused(dqa_simulator_get_state(simulator, NULL, 0, v2, n + 1), DQA_ERROR_ARGUMENT, "v|nv");
    refused(dqa_simulator_set_state(simulator, q, n + 1, NULL, 0), DQA_ERROR_ARGUMENT, "q|nq");
    refused(dqa_simulator_set_state(simulator, q, n, v, 0), DQA_ERROR_ARGUMENT, "v|nv");
    q2[4] = NAN;
    refused(dqa_simulator_set_state(simulator, q2, n, NULL, 0), DQA_ERROR_ARGUMENT, "q");
    v2[4] = INFINITY;
    refused(dqa_simulator_set_state(simulator, q, n, v2, n), DQA_ERROR_ARGUMENT, "v");
    ok(dqa_simulator_get_state(simulator, q2, n, v2, n));
    assert_memory_equal(q, q2, bytes);
    assert_memory_equal(v, v2, bytes);

    ok(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0));
    ok(dqa_simulator_get_state(simulator, q2, n, v2, n));
    assert_memory_equal(rest, q2, bytes);
    for (i = 0; i < n; ++i) assert_true(v2[i] == 0.0);
    dqa_simulator_free(simulator);
    free(rest), free(q), free(v), free(q2), free(v2);
}

static void sensors_and_forces(void** state) {
    dqa_simulator* simulator = tiny_simulator(space);
    const dqa_simulator_info info = info_of(simulator);
    double sensors[16], forces[12], u[64] = {0};
    int i;
    (void)state;
    refused(dqa_simulator_sensors(simulator, sensors, 16), DQA_ERROR_ARGUMENT, "sensors|n");
    refused(dqa_simulator_forces(simulator, forces, 13), DQA_ERROR_ARGUMENT, "forces|n");
    ok(dqa_simulator_sensors(simulator, sensors, info.n_sensors));
    for (i = 0; i < 9; ++i) assert_true(sensors[i] == 0.0); /* velocities at rest */
    assert_true(sensors[9] > 0.3 && sensors[12] < -0.3);    /* the head is ahead of the centre, the tail behind */
    for (i = 1; i < 3; ++i) assert_true(fabs(sensors[9 + i]) < 1e-12 && fabs(sensors[12 + i]) < 1e-12);
    ok(dqa_simulator_forces(simulator, forces, 12));
    for (i = 0; i < 12; ++i) assert_true(forces[i] == 0.0);
    u[0] = 0.5;
    ok(dqa_simulator_step(simulator, u, info.n_signals, NULL));
    ok(dqa_simulator_sensors(simulator, sensors, info.n_sensors));
    ok(dqa_simulator_forces(simulator, forces, 12));
    for (i = 0; i < 15; ++i) assert_true(isfinite(sensors[i]));
    for (i = 0; i < 12; ++i) assert_true(isfinite(forces[i]));
    dqa_simulator_free(simulator);
}

/* Both in two calls: the counts first, then the buffers; every index within its range. */
static void surface_and_mesh(void** state) {
    dqa_simulator* simulator = tiny_simulator(space);
    const dqa_simulator_info info = info_of(simulator);
    int64_t n_vertices = -1, n_triangles = -1, i;
    double *vertices, *occupancy = doubles(info.n_active_cells);
    int32_t *triangles, *nodes, *cells;
    (void)state;
    ok(dqa_simulator_surface(simulator, NULL, 0, NULL, 0, &n_vertices, &n_triangles));
    assert_true(n_vertices > 8 && n_triangles == 2 * n_vertices - 4); /* closed, of genus 0: Euler */
    vertices = doubles(3 * n_vertices);
    triangles = malloc(3 * (size_t)n_triangles * sizeof *triangles);
    nodes = malloc(8 * (size_t)info.n_active_cells * sizeof *nodes);
    cells = malloc((size_t)info.n_active_cells * sizeof *cells);
    assert_true(triangles != NULL && nodes != NULL && cells != NULL);
    refused(dqa_simulator_surface(simulator, vertices, 3 * n_vertices - 1, NULL, 0, NULL, NULL), DQA_ERROR_ARGUMENT,
            "vertices|nv");
    refused(dqa_simulator_surface(simulator, NULL, 0, triangles, 3, NULL, NULL), DQA_ERROR_ARGUMENT, "elements|ne");
    ok(dqa_simulator_surface(simulator, vertices, 3 * n_vertices, triangles, 3 * n_triangles, NULL, NULL));
    for (i = 0; i < 3 * n_vertices; ++i) assert_true(fabs(vertices[i]) < 0.1 * NX);
    for (i = 0; i < 3 * n_triangles; ++i) assert_in_range(triangles[i], 0, n_vertices - 1);

    refused(dqa_simulator_mesh(simulator, nodes, info.n_active_cells, NULL, 0, NULL, 0), DQA_ERROR_ARGUMENT,
            "cell_nodes|n_cell_nodes");
    refused(dqa_simulator_mesh(simulator, NULL, 0, cells, 1, NULL, 0), DQA_ERROR_ARGUMENT, "cell_box_index|n_cells");
    refused(dqa_simulator_mesh(simulator, NULL, 0, NULL, 0, occupancy, -1), DQA_ERROR_ARGUMENT,
            "occupancy|n_occupancy");
    ok(dqa_simulator_mesh(simulator, nodes, 8 * info.n_active_cells, cells, info.n_active_cells, occupancy,
                          info.n_active_cells));
    for (i = 0; i < 8 * info.n_active_cells; ++i) assert_in_range(nodes[i], 0, info.n_nodes - 1);
    for (i = 0; i < info.n_active_cells; ++i) {
        assert_in_range(cells[i], 0, N_CELLS - 1);
        assert_true(occupancy[i] > 0.0 && occupancy[i] <= 17.0 / 16.0);
    }
    dqa_simulator_free(simulator);
    free(vertices), free(occupancy), free(triangles), free(nodes), free(cells);
}

/* A callback of a call may look at its objects, and is told so when it tries to change them. */
typedef struct {
    dqa_simulator* simulator;
    dqa_controller* controller;
    int calls;
} meddling;

static int32_t meddle(int64_t done, int64_t total, void* user_data) {
    meddling* m = (meddling*)user_data;
    double signals[64] = {0}, times[1] = {0.0}, velocities[3] = {0.0, 0.0, 0.0}, weights[N_BASES];
    dqa_simulator* s = m->simulator;
    (void)done, (void)total;
    ++m->calls;
    ok(dqa_simulator_get_weights(s, weights, N_BASES));
    refused(dqa_simulator_set_weights(s, HALF, N_BASES, NULL, NULL), DQA_ERROR_STATE, "simulator");
    refused(dqa_simulator_set_current_table(s, times, 1, velocities, 3), DQA_ERROR_STATE, "simulator");
    refused(dqa_simulator_set_current_callback(s, NULL, NULL, NULL), DQA_ERROR_STATE, "simulator");
    refused(dqa_simulator_set_material(s, NULL, NULL, 0), DQA_ERROR_STATE, "simulator");
    refused(dqa_simulator_set_fixed_nodes(s, NULL, 0), DQA_ERROR_STATE, "simulator");
    refused(dqa_simulator_set_state(s, NULL, 0, NULL, 0), DQA_ERROR_STATE, "simulator");
    refused(dqa_simulator_step(s, signals, 1, NULL), DQA_ERROR_STATE, "simulator");
    refused(dqa_simulator_rollout(s, m->controller, 1, NULL, NULL, NULL), DQA_ERROR_STATE, "simulator");
    return 0;
}

static void callbacks_do_not_change_the_simulator(void** state) {
    meddling m = {tiny_simulator(space), NULL, 0};
    dqa_simulator* other = tiny_simulator(space);
    const int64_t n = state_length(other);
    double *q = doubles(n), *expected = doubles(n);
    (void)state;
    m.controller = tiny_controller(other);
    ok(dqa_simulator_set_weights(m.simulator, HALF, N_BASES, meddle, &m));
    assert_true(m.calls > 0);
    m.calls = 0;
    ok(dqa_simulator_rollout(m.simulator, m.controller, 3, NULL, meddle, &m));
    assert_int_equal(m.calls, 3);
    ok(dqa_simulator_rollout(other, m.controller, 3, NULL, NULL, NULL));
    ok(dqa_simulator_get_state(m.simulator, q, n, NULL, 0));
    ok(dqa_simulator_get_state(other, expected, n, NULL, 0));
    assert_memory_equal(q, expected, (size_t)n * sizeof *q);
    /* Failed or not, a call that is over leaves the simulator free. */
    refused(dqa_simulator_step(m.simulator, NULL, 1, NULL), DQA_ERROR_ARGUMENT, "actuation");
    ok(dqa_simulator_set_state(m.simulator, NULL, 0, NULL, 0));
    free(q), free(expected);
    dqa_controller_free(m.controller);
    dqa_simulator_free(other);
    dqa_simulator_free(m.simulator);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(null_arguments),
        cmocka_unit_test(create_needs_a_built_space),
        cmocka_unit_test(most_calls_need_a_design),
        cmocka_unit_test(designs_are_checked_and_kept),
        cmocka_unit_test(thresholds_are_suggested),
        cmocka_unit_test(info_is_consistent),
        cmocka_unit_test(actuation_is_checked),
        cmocka_unit_test(state_goes_in_and_out),
        cmocka_unit_test(callbacks_do_not_change_the_simulator),
        cmocka_unit_test(sensors_and_forces),
        cmocka_unit_test(surface_and_mesh),
    };
    return cmocka_run_group_tests_name("simulator", tests, open_space, close_space);
}
