/* SPDX-License-Identifier: MIT
 * Commands of simulators. Names and arguments are those of diffaqua.h; outputs become results, counts of elements are
 * those of the arrays. */
#include "gateway.h"

static dqa_simulator* simulator_of(call* c) {
    return object(c, 0, "simulator", SIMULATOR);
}

static dqa_simulator* simulator_to_change(call* c) {
    return object_to_change(c, 0, "simulator", SIMULATOR);
}

static dqa_simulator_info info_of(call* c, const dqa_simulator* simulator) {
    dqa_simulator_info info;
    check(c, dqa_simulator_get_info(simulator, &info, sizeof info));
    return info;
}

/* (space, options, token) -> handle, options as they are used */
static void create(call* c) {
    dqa_shape_space* space = object(c, 0, "space", SPACE);
    dqa_simulator_options options;
    dqa_simulator* simulator;
    check(c, dqa_simulator_options_init(&options, sizeof options));
    fill(c, 1, "dqa_simulator_options", &options);
    options.cancel = optional_object(c, 2, "cancel", TOKEN);
    check(c, dqa_simulator_create(space, &options, &simulator));
    give_object(c, SIMULATOR, simulator);
    give_record(c, "dqa_simulator_options", &options);
}

static void get_info(call* c) {
    const dqa_simulator_info info = info_of(c, simulator_of(c));
    give_record(c, "dqa_simulator_info", &info);
}

/* ------------------------------------------------------------------ design */
/* (simulator, weights, progress) */
static void set_weights(call* c) {
    dqa_simulator* simulator = simulator_to_change(c);
    shape s = axes1(-1);
    const double* weights = doubles(c, 1, "weights", &s);
    const int64_t id = whole(c, 2, "progress");
    check(c, dqa_simulator_set_weights(simulator, weights, count(&s), progress_of(id), user_data_of(id, 0)));
}

static void get_weights(call* c) {
    dqa_simulator* simulator = simulator_of(c);
    const shape s = axes1(info_of(c, simulator).n_bases);
    double* weights = room(&s);
    check(c, dqa_simulator_get_weights(simulator, weights, count(&s)));
    give_doubles(c, weights, s);
}

/* (simulator, young_modulus, muscle_stiffness, n_cells) */
static void set_material(call* c) {
    dqa_simulator* simulator = simulator_to_change(c);
    const int64_t n = whole(c, 3, "n_cells");
    shape solid = axes1(n), muscle = axes1(n);
    const double* young_modulus = optional_doubles(c, 1, "young_modulus", &solid);
    const double* stiffness = optional_doubles(c, 2, "muscle_stiffness", &muscle);
    check(c, dqa_simulator_set_material(simulator, young_modulus, stiffness, n));
}

/* (simulator, nodes) */
static void set_fixed_nodes(call* c) {
    dqa_simulator* simulator = simulator_to_change(c);
    shape s = axes1(-1);
    const int32_t* nodes = integers(c, 1, "nodes", &s);
    check(c, dqa_simulator_set_fixed_nodes(simulator, nodes, count(&s)));
}

static void node_box_index(call* c) {
    dqa_simulator* simulator = simulator_of(c);
    const shape s = axes1(info_of(c, simulator).n_nodes);
    int32_t* nodes = room_for_integers(&s);
    check(c, dqa_simulator_node_box_index(simulator, nodes, count(&s)));
    give_integers(c, nodes, s);
}

/* (simulator, weights, tolerance) -> threshold, estimate */
static void suggest_threshold(call* c) {
    dqa_simulator* simulator = simulator_of(c);
    shape s = axes1(-1);
    const double* weights = doubles(c, 1, "weights", &s);
    double threshold = 0.0, estimate = 0.0;
    check(c, dqa_simulator_suggest_threshold(simulator, weights, count(&s), number(c, 2, "tolerance"), &threshold,
                                             &estimate));
    give_number(c, threshold);
    give_number(c, estimate);
}

/* ------------------------------------------------------------------ water */
/* (simulator, times, velocities) */
static void set_current_table(call* c) {
    dqa_simulator* simulator = simulator_to_change(c);
    shape at = axes1(-1), rows;
    const double* times = doubles(c, 1, "times", &at);
    const double* velocities;
    rows = axes2(count(&at), info_of(c, simulator).dims);
    velocities = doubles(c, 2, "velocities", &rows);
    check(c, dqa_simulator_set_current_table(simulator, times, count(&at), velocities, count(&rows)));
}

/* (simulator, id, whether there is a pullback); id 0: back to the options */
static void set_current_callback(call* c) {
    dqa_simulator* simulator = simulator_to_change(c);
    const int64_t id = whole(c, 1, "id");
    const dqa_current_pullback bar = whole(c, 2, "has_pullback") ? current_pullback_callback : NULL;
    void* data = user_data_of(id, info_of(c, simulator).dims);
    check(c,
          dqa_simulator_set_current_callback(simulator, id == 0 ? NULL : current_callback, id == 0 ? NULL : bar, data));
}

/* ------------------------------------------------------------------ motion */
static dqa_tape* record_of(call* c, int argument) {
    return is_given(c, argument) ? object_to_change(c, argument, "tape", TAPE) : NULL;
}

/* (simulator, actuation, tape) */
static void step(call* c) {
    dqa_simulator* simulator = simulator_to_change(c);
    shape s = axes1(-1);
    const double* actuation = doubles(c, 1, "actuation", &s);
    check(c, dqa_simulator_step(simulator, actuation, count(&s), record_of(c, 2)));
}

/* (simulator, controller, n_steps, tape, progress) */
static void rollout(call* c) {
    dqa_simulator* simulator = simulator_to_change(c);
    dqa_controller* controller = object(c, 1, "controller", CONTROLLER);
    const int64_t n_steps = whole(c, 2, "n_steps");
    dqa_tape* tape = record_of(c, 3);
    const int64_t id = whole(c, 4, "progress");
    check(c, dqa_simulator_rollout(simulator, controller, n_steps, tape, progress_of(id), user_data_of(id, 0)));
}

/* -> q, v */
static void get_state(call* c) {
    dqa_simulator* simulator = simulator_of(c);
    const dqa_simulator_info info = info_of(c, simulator);
    const shape s = axes2(info.n_nodes, info.dims);
    double *q = room(&s), *v = room(&s);
    check(c, dqa_simulator_get_state(simulator, q, count(&s), v, count(&s)));
    give_doubles(c, q, s);
    give_doubles(c, v, s);
}

/* (simulator, q, v) */
static void set_state(call* c) {
    dqa_simulator* simulator = simulator_to_change(c);
    const dqa_simulator_info info = info_of(c, simulator);
    shape sq = axes2(info.n_nodes, info.dims), sv = sq;
    const double* q = optional_doubles(c, 1, "q", &sq);
    const double* v = optional_doubles(c, 2, "v", &sv);
    check(c, dqa_simulator_set_state(simulator, q, count(&sq), v, count(&sv)));
}

static void sensors(call* c) {
    dqa_simulator* simulator = simulator_of(c);
    const shape s = axes2(5, info_of(c, simulator).dims);
    double* seen = room(&s);
    check(c, dqa_simulator_sensors(simulator, seen, count(&s)));
    give_doubles(c, seen, s);
}

static void forces(call* c) {
    dqa_simulator* simulator = simulator_of(c);
    const shape s = axes2(4, info_of(c, simulator).dims);
    double* totals = room(&s);
    check(c, dqa_simulator_forces(simulator, totals, count(&s)));
    give_doubles(c, totals, s);
}

/* ------------------------------------------------------------------ geometry */
/* -> vertices, elements */
static void surface(call* c) {
    dqa_simulator* simulator = simulator_of(c);
    const int32_t dims = info_of(c, simulator).dims;
    int64_t n_vertices = 0, n_elements = 0;
    shape points, corners;
    double* vertices;
    int32_t* elements;
    check(c, dqa_simulator_surface(simulator, NULL, 0, NULL, 0, &n_vertices, &n_elements));
    points = axes2(n_vertices, dims);
    corners = axes2(n_elements, dims);
    vertices = room(&points);
    elements = room_for_integers(&corners);
    check(c, dqa_simulator_surface(simulator, vertices, count(&points), elements, count(&corners), NULL, NULL));
    give_doubles(c, vertices, points);
    give_integers(c, elements, corners);
}

/* -> cell_nodes, box_index, occupancy */
static void mesh(call* c) {
    dqa_simulator* simulator = simulator_of(c);
    const dqa_simulator_info info = info_of(c, simulator);
    const shape corners = axes2(info.n_active_cells, info.dims == 2 ? 4 : 8), cells = axes1(info.n_active_cells);
    int32_t *nodes = room_for_integers(&corners), *index = room_for_integers(&cells);
    double* occupancy = room(&cells);
    check(c, dqa_simulator_mesh(simulator, nodes, count(&corners), index, count(&cells), occupancy, count(&cells)));
    give_integers(c, nodes, corners);
    give_integers(c, index, cells);
    give_doubles(c, occupancy, cells);
}

/* (simulator, category, side) */
static void actuator(call* c) {
    dqa_simulator* simulator = simulator_of(c);
    dqa_actuator_info info;
    check(c, dqa_simulator_actuator(simulator, index_of(c, 1, "category"), index_of(c, 2, "side"), &info, sizeof info));
    give_record(c, "dqa_actuator_info", &info);
}

/* -> cells, signals, signs, directions, stiffness */
static void muscles(call* c) {
    dqa_simulator* simulator = simulator_of(c);
    const int32_t dims = info_of(c, simulator).dims;
    int64_t n = 0;
    shape rows, vectors;
    int32_t *cells, *signals, *signs;
    double *directions, *stiffness;
    check(c, dqa_simulator_muscles(simulator, NULL, NULL, NULL, 0, NULL, 0, NULL, 0, &n));
    rows = axes1(n);
    vectors = axes2(n, dims);
    cells = room_for_integers(&rows);
    signals = room_for_integers(&rows);
    signs = room_for_integers(&rows);
    directions = room(&vectors);
    stiffness = room(&rows);
    check(c,
          dqa_simulator_muscles(simulator, cells, signals, signs, n, directions, count(&vectors), stiffness, n, NULL));
    give_integers(c, cells, rows);
    give_integers(c, signals, rows);
    give_integers(c, signs, rows);
    give_doubles(c, directions, vectors);
    give_doubles(c, stiffness, rows);
}

/* clang-format off */
const command simulator_commands[] = {
    {"simulator_create", create, 1, 3},
    {"simulator_get_info", get_info, 1, 1},
    {"simulator_set_weights", set_weights, 3, 3},
    {"simulator_get_weights", get_weights, 1, 1},
    {"simulator_set_material", set_material, 4, 4},
    {"simulator_set_fixed_nodes", set_fixed_nodes, 2, 2},
    {"simulator_node_box_index", node_box_index, 1, 1},
    {"simulator_suggest_threshold", suggest_threshold, 3, 3},
    {"simulator_set_current_table", set_current_table, 3, 3},
    {"simulator_set_current_callback", set_current_callback, 3, 3},
    {"simulator_step", step, 2, 3},
    {"simulator_rollout", rollout, 5, 5},
    {"simulator_get_state", get_state, 1, 1},
    {"simulator_set_state", set_state, 1, 3},
    {"simulator_sensors", sensors, 1, 1},
    {"simulator_forces", forces, 1, 1},
    {"simulator_surface", surface, 1, 1},
    {"simulator_mesh", mesh, 1, 1},
    {"simulator_actuator", actuator, 3, 3},
    {"simulator_muscles", muscles, 1, 1},
    {NULL, NULL, 0, 0}};
