/* SPDX-License-Identifier: MIT */
#include "support.h"

#include <ctype.h>
#include <stdio.h>

const double HALF[N_BASES] = {0.5, 0.5};

void check_ok(dqa_status status, const char* call, const char* file, int line) {
    if (status == DQA_SUCCESS) return;
    print_error("%s gave %s: %s\n", call, dqa_status_name(status), dqa_last_error());
    _fail(file, line);
}

static int is_word(char c) {
    return isalnum((unsigned char)c) || c == '_';
}

/* Whether `name` (of `length` characters) stands in `text` as a word of its own. */
static int has_word(const char* text, const char* name, size_t length) {
    const char* at;
    for (at = text; *at != '\0'; ++at)
        if (strncmp(at, name, length) == 0 && (at == text || !is_word(at[-1])) && !is_word(at[length])) return 1;
    return 0;
}

void check_refused(dqa_status got, dqa_status status, const char* names, const char* call, const char* file, int line) {
    const char* message = dqa_last_error();
    const char* name = names;
    int named = 0;
    while (*name != '\0') {
        const size_t length = strcspn(name, "|");
        named = named || has_word(message, name, length);
        name += length;
        if (*name == '|') ++name;
    }
    if (got == status && named) return;
    if (got != status)
        print_error("%s gave %s, not %s; last error: %s\n", call, dqa_status_name(got), dqa_status_name(status),
                    message);
    else
        print_error("%s was refused, but the message does not name %s: %s\n", call, names, message);
    _fail(file, line);
}

void leave_other_error(void) {
    double moment = 0.0;
    (void)dqa_adam_step(NULL, NULL, NULL, &moment, &moment, -1, -1);
}

void ellipsoid(double* cells, double a, double b, double c) {
    enum { SAMPLES = 4 };
    int i, j, k, s;
    for (i = 0; i < NX; ++i)
        for (j = 0; j < NY; ++j)
            for (k = 0; k < NZ; ++k) {
                int inside = 0;
                for (s = 0; s < SAMPLES * SAMPLES * SAMPLES; ++s) {
                    const double x = (i + (s / 16 + 0.5) / SAMPLES - 0.5 * NX) / a;
                    const double y = (j + (s / 4 % 4 + 0.5) / SAMPLES - 0.5 * NY) / b;
                    const double z = (k + (s % 4 + 0.5) / SAMPLES - 0.5 * NZ) / c;
                    if (x * x + y * y + z * z <= 1.0) ++inside;
                }
                cells[(i * NY + j) * NZ + k] = inside / (double)(SAMPLES * SAMPLES * SAMPLES);
            }
}

dqa_shape_space_options tiny_options(void) {
    dqa_shape_space_options options;
    ok(dqa_shape_space_options_init(&options, sizeof options));
    options.cells_x = NX;
    options.cells_y = NY;
    options.cells_z = NZ;
    options.cell_size = 0.1;
    return options;
}

dqa_shape_space* tiny_space_open(void) {
    const dqa_shape_space_options options = tiny_options();
    dqa_shape_space* space = NULL;
    double* cells = doubles(N_CELLS);
    int32_t base = -1;
    ok(dqa_shape_space_create(&options, &space));
    assert_non_null(space);
    ellipsoid(cells, 6.0, 1.8, 2.4);
    ok(dqa_shape_space_add_density(space, "long", cells, N_CELLS, &base));
    assert_int_equal(base, 0);
    ellipsoid(cells, 4.5, 2.2, 2.2);
    ok(dqa_shape_space_add_density(space, "round", cells, N_CELLS, &base));
    assert_int_equal(base, 1);
    free(cells);
    return space;
}

dqa_shape_space* tiny_space(void) {
    dqa_shape_space* space = tiny_space_open();
    ok(dqa_shape_space_build(space, NULL, NULL));
    return space;
}

dqa_simulator* tiny_simulator(dqa_shape_space* space) {
    dqa_simulator* simulator = NULL;
    ok(dqa_simulator_create(space, NULL, &simulator));
    assert_non_null(simulator);
    ok(dqa_simulator_set_weights(simulator, HALF, N_BASES, NULL, NULL));
    return simulator;
}

int64_t state_length(const dqa_simulator* simulator) {
    dqa_simulator_info info;
    ok(dqa_simulator_get_info(simulator, &info, sizeof info));
    assert_true(info.n_nodes > 0);
    return info.n_nodes * info.dims;
}

dqa_controller* tiny_controller(dqa_simulator* simulator) {
    dqa_simulator_info info;
    dqa_controller* controller = NULL;
    double* theta;
    int32_t i;
    ok(dqa_simulator_get_info(simulator, &info, sizeof info));
    assert_true(info.n_signals > 0);
    ok(dqa_controller_create_sinusoid(info.n_signals, 1.0 / 30.0, &controller));
    theta = doubles(3 * (int64_t)info.n_signals);
    for (i = 0; i < info.n_signals; ++i) {
        theta[3 * i] = 0.8 - 0.1 * i;
        theta[3 * i + 1] = 12.0 + i;
        theta[3 * i + 2] = 0.3 + 0.5 * i;
    }
    ok(dqa_controller_set_parameters(controller, theta, 3 * (int64_t)info.n_signals));
    free(theta);
    return controller;
}

dqa_tape* tiny_tape(dqa_simulator* simulator, int64_t n_steps) {
    dqa_controller* controller = tiny_controller(simulator);
    dqa_tape* tape = NULL;
    ok(dqa_tape_create(simulator, NULL, &tape));
    ok(dqa_simulator_rollout(simulator, controller, n_steps, tape, NULL, NULL));
    dqa_controller_free(controller);
    return tape;
}

double* doubles(int64_t n) {
    double* array = calloc(n > 0 ? (size_t)n : 1, sizeof *array);
    assert_non_null(array);
    return array;
}

int32_t count_progress(int64_t done, int64_t total, void* user_data) {
    assert_true(done >= 0 && done <= total);
    ++*(int64_t*)user_data;
    return 0;
}

int32_t cancel_at_once(int64_t done, int64_t total, void* user_data) {
    (void)done;
    (void)total;
    (void)user_data;
    return 1;
}

int32_t cancel_when(int64_t done, int64_t total, void* user_data) {
    (void)total;
    return done == *(const int64_t*)user_data;
}
