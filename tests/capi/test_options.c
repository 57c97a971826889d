/* SPDX-License-Identifier: MIT
 * Growable structs: their sizes through time, and the range of every option. */
#include <stdio.h>

#include "scene.h"

typedef dqa_status (*create_function)(const void* options);

/* Creates from the options and frees at once; the handle must be NULL exactly when the call failed. */
static dqa_status create_space(const void* options) {
    dqa_shape_space* made = (dqa_shape_space*)&made;
    const dqa_status status = dqa_shape_space_create(options, &made);
    assert_true((made == NULL) == (status != DQA_SUCCESS));
    dqa_shape_space_free(made);
    return status;
}

static dqa_status create_simulator(const void* options) {
    dqa_simulator* made = (dqa_simulator*)&made;
    const dqa_status status = dqa_simulator_create(space, options, &made);
    assert_true((made == NULL) == (status != DQA_SUCCESS));
    dqa_simulator_free(made);
    return status;
}

static dqa_status create_tape(const void* options) {
    dqa_tape* made = (dqa_tape*)&made;
    const dqa_status status = dqa_tape_create(simulator, options, &made);
    assert_true((made == NULL) == (status != DQA_SUCCESS));
    dqa_tape_free(made);
    return status;
}

static dqa_status check_gradient(const void* options) {
    dqa_gradient_check_report report;
    dqa_objective_term term;
    ok(dqa_objective_term_init(&term, sizeof term));
    return dqa_check_gradient(simulator, NULL, &term, 1, options, &report, sizeof report);
}

static dqa_status create_mlp(const void* options) {
    dqa_controller* made = (dqa_controller*)&made;
    const dqa_status status = dqa_controller_create_mlp(options, &made);
    assert_true((made == NULL) == (status != DQA_SUCCESS));
    dqa_controller_free(made);
    return status;
}

static dqa_status init_space(void* options, uint64_t size) {
    return dqa_shape_space_options_init(options, size);
}
static dqa_status init_simulator(void* options, uint64_t size) {
    return dqa_simulator_options_init(options, size);
}
static dqa_status init_actuator(void* options, uint64_t size) {
    return dqa_actuator_options_init(options, size);
}
static dqa_status init_tape(void* options, uint64_t size) {
    return dqa_tape_options_init(options, size);
}
static dqa_status init_term(void* options, uint64_t size) {
    return dqa_objective_term_init(options, size);
}
static dqa_status init_check(void* options, uint64_t size) {
    return dqa_gradient_check_options_init(options, size);
}

static dqa_status init_mlp(void* options, uint64_t size) {
    return dqa_mlp_options_init(options, size);
}
static dqa_status init_callback(void* options, uint64_t size) {
    return dqa_callback_controller_options_init(options, size);
}

static const struct {
    const char* name;
    uint32_t size;
    dqa_status (*init)(void*, uint64_t);
    create_function create; /* NULL: only initialised here */
} STRUCTS[] = {
    {"shape_space", sizeof(dqa_shape_space_options), init_space, create_space},
    {"simulator", sizeof(dqa_simulator_options), init_simulator, create_simulator},
    {"actuator", sizeof(dqa_actuator_options), init_actuator, NULL},
    {"tape", sizeof(dqa_tape_options), init_tape, create_tape},
    {"term", sizeof(dqa_objective_term), init_term, NULL},
    {"gradient_check", sizeof(dqa_gradient_check_options), init_check, check_gradient},
    {"mlp", sizeof(dqa_mlp_options), init_mlp, create_mlp},
    {"callback_controller", sizeof(dqa_callback_controller_options), init_callback, NULL},
};

/* Room for a struct of a later release, its tail included. */
typedef union future {
    double align;
    uint32_t struct_size;
    unsigned char bytes[512];
} future;

static void sizes_through_time(void** state) {
    size_t i;
    (void)state;
    for (i = 0; i < sizeof STRUCTS / sizeof *STRUCTS; ++i) {
        const uint32_t size = STRUCTS[i].size;
        future options;
        uint32_t at;
        refused(STRUCTS[i].init(NULL, size), DQA_ERROR_ARGUMENT, "options|term");
        refused(STRUCTS[i].init(&options, 0), DQA_ERROR_ARGUMENT, "size");
        refused(STRUCTS[i].init(&options, 3), DQA_ERROR_ARGUMENT, "size");

        /* A newer caller: the tail that this library does not know comes zeroed. */
        memset(&options, 0xee, sizeof options);
        ok(STRUCTS[i].init(&options, size + 16));
        assert_int_equal(options.struct_size, size + 16);
        for (at = size; at < size + 16; ++at) assert_int_equal(options.bytes[at], 0);
        assert_int_equal(options.bytes[size + 16], 0xee);
        if (STRUCTS[i].create) {
            ok(STRUCTS[i].create(&options));
            options.bytes[size + 9] = 1; /* asks for what this library does not have */
            refused(STRUCTS[i].create(&options), DQA_ERROR_ARGUMENT, "options|struct_size");
        }

        /* An older caller: not a byte behind its struct is touched or read. */
        memset(&options, 0xee, sizeof options);
        ok(STRUCTS[i].init(&options, size - 8));
        assert_int_equal(options.struct_size, size - 8);
        for (at = size - 8; at < sizeof options; ++at) assert_int_equal(options.bytes[at], 0xee);
        if (STRUCTS[i].create) ok(STRUCTS[i].create(&options));

        /* A caller that forgot to initialise. */
        memset(&options, 0, sizeof options);
        if (STRUCTS[i].create) refused(STRUCTS[i].create(&options), DQA_ERROR_ARGUMENT, "struct_size");
    }
}

/* Structs that come out: as much as the caller has room for, and the size that the library filled. */
static void statistics_through_time(void** state) {
    dqa_tape* tape = tiny_tape(simulator, 1);
    union {
        future room;
        dqa_simulator_info info;
        dqa_shape_space_info space_info;
        dqa_tape_statistics statistics;
    } out;
    size_t at;
    (void)state;
    memset(&out, 0xee, sizeof out);
    ok(dqa_simulator_get_info(simulator, &out.info, offsetof(dqa_simulator_info, total_mass)));
    for (at = offsetof(dqa_simulator_info, total_mass); at < sizeof out; ++at)
        assert_int_equal(out.room.bytes[at], 0xee);
    assert_true(out.info.n_nodes > 0);
    ok(dqa_simulator_get_info(simulator, &out.info, sizeof out.info + 64));
    refused(dqa_simulator_get_info(simulator, &out.info, 0), DQA_ERROR_ARGUMENT, "size");
    memset(&out, 0xee, sizeof out);
    ok(dqa_shape_space_get_info(space, &out.space_info, offsetof(dqa_shape_space_info, cell_size)));
    for (at = offsetof(dqa_shape_space_info, cell_size); at < sizeof out; ++at)
        assert_int_equal(out.room.bytes[at], 0xee);
    ok(dqa_shape_space_get_info(space, &out.space_info, sizeof out.space_info + 64));
    refused(dqa_shape_space_get_info(space, &out.space_info, 0), DQA_ERROR_ARGUMENT, "size");
    memset(&out, 0xee, sizeof out);
    ok(dqa_tape_stats(tape, &out.statistics, offsetof(dqa_tape_statistics, worst_residual)));
    for (at = offsetof(dqa_tape_statistics, worst_residual); at < sizeof out; ++at)
        assert_int_equal(out.room.bytes[at], 0xee);
    ok(dqa_tape_stats(tape, &out.statistics, sizeof out.statistics + 64));
    refused(dqa_tape_stats(tape, &out.statistics, 0), DQA_ERROR_ARGUMENT, "size");
    dqa_tape_free(tape);
}

/* One field out of its range. */
typedef struct trial {
    const char* name;
    size_t offset;
    int is_integer;
    double value;
} trial;
#define I(type, field, value) \
    { #field, offsetof(type, field), 1, value }
#define D(type, field, value) \
    { #field, offsetof(type, field), 0, value }

static void run_trial(const trial* t, const void* options, size_t size, create_function create) {
    future changed;
    char what[128];
    memcpy(&changed, options, size);
    if (t->is_integer) {
        const int32_t value = (int32_t)t->value;
        memcpy(changed.bytes + t->offset, &value, sizeof value);
    } else {
        memcpy(changed.bytes + t->offset, &t->value, sizeof t->value);
    }
    snprintf(what, sizeof what, "%s = %g", t->name, t->value);
    check_refused((leave_other_error(), create(&changed)), DQA_ERROR_ARGUMENT, t->name, what, __FILE__, __LINE__);
}

static void shape_space_ranges(void** state) {
    dqa_shape_space_options options = tiny_options();
#define SI(field, value) I(dqa_shape_space_options, field, value)
#define SD(field, value) D(dqa_shape_space_options, field, value)
    static const trial trials[] = {
        SI(flags, 1),
        SI(dims, 4),
        SI(dims, 0),
        SI(cells_x, 7),
        SI(cells_x, 513),
        SI(cells_y, 0),
        SI(cells_y, 100000),
        SI(cells_z, -5),
        SI(cells_z, 513),
        SI(margin, 0),
        SI(margin, -1),
        SI(margin, 8),
        SI(margin_across, -1),
        SI(margin_across, 4),
        SI(padding, 1),
        SI(up, -1),
        SI(up, 3),
        SI(subsamples, 0),
        SI(subsamples, 17),
        SI(refinement, 0),
        SI(refinement, 5),
        SI(peak, -1),
        SI(peak, 2),
        SI(max_iterations, 0),
        SI(threads, 0),
        SI(threads, -2),
        SD(body_length, 0),
        SD(body_length, 1e10),
        SD(body_length, 1e-308),
        SD(cell_size, 1e-10),
        SD(cell_size, 1e308),
        SD(body_length, -1),
        SD(body_length, NAN),
        SD(cell_size, -1),
        SD(cell_size, NAN),
        SD(sigma, 0.1),
        SD(sigma, 17),
        SD(sigma, NAN),
        SD(tolerance, 0),
        SD(tolerance, -1e-9),
        SD(tolerance, NAN),
        SD(cell_size, INFINITY),
    };
    size_t i;
    (void)state;
    ok(create_space(&options));
    for (i = 0; i < sizeof trials / sizeof *trials; ++i) run_trial(&trials[i], &options, sizeof options, create_space);
    options.dims = 2, options.cells_z = 0; /* not looked at in two dimensions */
    ok(create_space(&options));
}

static void simulator_ranges(void** state) {
    dqa_simulator_options options;
    int i, axis;
#define MI(field, value) I(dqa_simulator_options, field, value)
#define MD(field, value) D(dqa_simulator_options, field, value)
    static const trial trials[] = {
        MI(flags, 1),
        MI(threads, 0),
        MI(threads, -1),
        MI(method, -1),
        MI(method, 3),
        MI(water, -1),
        MI(water, 3),
        MI(water_faces, -1),
        MI(water_faces, 2),
        MI(preconditioner, -1),
        MI(preconditioner, 2),
        MI(linear_precision, -1),
        MI(linear_precision, 2),
        MI(quadrature, -1),
        MI(quadrature, 2),
        MI(padding, 1),
        MI(max_newton, 0),
        MI(max_linear, 0),
        MI(instruction_set, -1),
        MI(instruction_set, 4),
        MD(time_step, 0),
        MD(time_step, 1e13),
        MD(time_step, 1e-308),
        MD(young_modulus, 1e308),
        MD(young_modulus, 1e-13),
        MD(density, 1e19),
        MD(water_density, 1e-300),
        MD(muscle_stiffness, 1e19),
        MD(speed_smoothing, 1e-13),
        MD(surface_smoothing, 1e300),
        MD(time_step, -0.1),
        MD(time_step, NAN),
        MD(time_step, INFINITY),
        MD(young_modulus, 0),
        MD(young_modulus, -5e6),
        MD(young_modulus, NAN),
        MD(poisson_ratio, -0.1),
        MD(poisson_ratio, 0.5),
        MD(poisson_ratio, NAN),
        MD(density, 0),
        MD(density, -1000),
        MD(density, NAN),
        MD(muscle_stiffness, -1),
        MD(muscle_stiffness, NAN),
        MD(contraction, 0),
        MD(contraction, 1),
        MD(contraction, NAN),
        MD(threshold, -0.01),
        MD(threshold, 0.5),
        MD(threshold, NAN),
        MD(occupancy_floor, 0),
        MD(occupancy_floor, 0.2),
        MD(occupancy_floor, NAN),
        MD(tolerance, 0),
        MD(tolerance, NAN),
        MD(adjoint_tolerance, 1),
        MD(adjoint_tolerance, -1),
        MD(adjoint_tolerance, NAN),
        MD(water_density, 0),
        MD(water_density, -1),
        MD(water_density, NAN),
        MD(speed_smoothing, 0),
        MD(speed_smoothing, NAN),
        MD(angle_smoothing, 0),
        MD(angle_smoothing, 0.6),
        MD(angle_smoothing, NAN),
        MD(surface_smoothing, 0),
        MD(surface_smoothing, -1),
        MD(surface_smoothing, NAN),
    };
    (void)state;
    ok(dqa_simulator_options_init(&options, sizeof options));
    ok(create_simulator(&options));
    for (i = 0; i < (int)(sizeof trials / sizeof *trials); ++i)
        run_trial(&trials[i], &options, sizeof options, create_simulator);
    for (i = 0; i < 2; ++i) {
        ok(dqa_simulator_options_init(&options, sizeof options));
        options.max_products = -i;
        refused(create_simulator(&options), DQA_ERROR_ARGUMENT, "max_products");
    }
    for (axis = 0; axis < 3; ++axis) {
        ok(dqa_simulator_options_init(&options, sizeof options));
        options.current[axis] = NAN;
        refused(create_simulator(&options), DQA_ERROR_ARGUMENT, "current");
    }
    for (i = 0; i < 4; ++i) {
        ok(dqa_simulator_options_init(&options, sizeof options));
        options.drag_coefficients[i] = i % 3 ? -2.0 : -0.1; /* an inner ordinate must pull harder */
        refused(create_simulator(&options), DQA_ERROR_ARGUMENT, "drag_coefficients");
        options.drag_coefficients[i] = NAN;
        refused(create_simulator(&options), DQA_ERROR_ARGUMENT, "drag_coefficients");
        ok(dqa_simulator_options_init(&options, sizeof options));
        options.thrust_coefficients[i] = NAN;
        refused(create_simulator(&options), DQA_ERROR_ARGUMENT, "thrust_coefficients");
    }
    ok(dqa_simulator_options_init(&options, sizeof options));
    for (i = 0; i < 4; ++i) options.thrust_coefficients[i] = i % 2 ? 1.0 : -i; /* up, down, up */
    refused(create_simulator(&options), DQA_ERROR_ARGUMENT, "thrust_coefficients");
    /* An ordinate may fall, or be negative, where the curve does not. */
    options.thrust_coefficients[2] = 0.0;
    options.drag_coefficients[1] = -0.02;
    ok(create_simulator(&options));
}

static void tape_ranges(void** state) {
    dqa_tape_options options;
    (void)state;
    ok(dqa_tape_options_init(&options, sizeof options));
    options.memory_bytes = -1;
    refused(create_tape(&options), DQA_ERROR_ARGUMENT, "memory_bytes");
    ok(dqa_tape_options_init(&options, sizeof options));
    options.flags = 1;
    refused(create_tape(&options), DQA_ERROR_ARGUMENT, "flags");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_through_time), cmocka_unit_test(statistics_through_time),
        cmocka_unit_test(shape_space_ranges), cmocka_unit_test(simulator_ranges),
        cmocka_unit_test(tape_ranges),
    };
    return cmocka_run_group_tests_name("options", tests, open_scene, close_scene);
}
