/* SPDX-License-Identifier: MIT
 * Filling and freezing a shape space: bases from densities and meshes, actuators, build, and its refusals. */
#include <stdio.h>

#include "support.h"

static const double TETRAHEDRON[4][3] = {{0, 0, 0}, {4, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const int32_t FACES[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

static void null_arguments(void** state) {
    dqa_shape_space* space = tiny_space_open();
    dqa_shape_space_info info;
    dqa_actuator_options actuator;
    double* cells = doubles(N_CELLS);
    (void)state;
    ok(dqa_actuator_options_init(&actuator, sizeof actuator));

    refused(dqa_shape_space_create(NULL, NULL), DQA_ERROR_ARGUMENT, "space");
    refused(dqa_shape_space_add_mesh(NULL, "m", TETRAHEDRON[0], 4, FACES[0], 4, NULL), DQA_ERROR_ARGUMENT, "space");
    refused(dqa_shape_space_add_mesh(space, "m", NULL, 4, FACES[0], 4, NULL), DQA_ERROR_ARGUMENT, "vertices");
    refused(dqa_shape_space_add_mesh(space, "m", TETRAHEDRON[0], 4, NULL, 4, NULL), DQA_ERROR_ARGUMENT, "triangles");
    refused(dqa_shape_space_add_mesh_file(NULL, "a.stl", NULL), DQA_ERROR_ARGUMENT, "space");
    refused(dqa_shape_space_add_mesh_file(space, NULL, NULL), DQA_ERROR_ARGUMENT, "path");
    refused(dqa_shape_space_add_density(NULL, "d", cells, N_CELLS, NULL), DQA_ERROR_ARGUMENT, "space");
    refused(dqa_shape_space_add_density(space, "d", NULL, N_CELLS, NULL), DQA_ERROR_ARGUMENT, "cells");
    refused(dqa_shape_space_add_actuator(NULL, 0, &actuator), DQA_ERROR_ARGUMENT, "space");
    refused(dqa_shape_space_get_actuator(NULL, 0, 0, DQA_SIDE_BOTH, &actuator), DQA_ERROR_ARGUMENT, "space");
    refused(dqa_shape_space_build(NULL, NULL, NULL), DQA_ERROR_ARGUMENT, "space");
    refused(dqa_shape_space_get_info(NULL, &info, sizeof info), DQA_ERROR_ARGUMENT, "space");
    refused(dqa_shape_space_get_info(space, NULL, sizeof info), DQA_ERROR_ARGUMENT, "info");
    refused(dqa_shape_space_get_base(NULL, 0, cells, N_CELLS), DQA_ERROR_ARGUMENT, "space");
    refused(dqa_shape_space_get_base(space, 0, NULL, N_CELLS), DQA_ERROR_ARGUMENT, "cells");
    assert_string_equal(dqa_shape_space_base_name(NULL, 0), "");
    dqa_shape_space_free(NULL);

    dqa_shape_space_free(space);
    free(cells);
}

static void densities_are_checked(void** state) {
    dqa_shape_space* space = tiny_space_open();
    dqa_shape_space_info info;
    double* cells = doubles(N_CELLS);
    static const double wrong[] = {-0.1, 1.1, NAN, INFINITY};
    int32_t base = 77;
    size_t i;
    (void)state;
    refused(dqa_shape_space_add_density(space, "empty", cells, N_CELLS, &base), DQA_ERROR_ARGUMENT, "cells");
    for (i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        ellipsoid(cells, 5.0, 2.0, 2.0);
        cells[N_CELLS / 2 + 3] = wrong[i];
        refused(dqa_shape_space_add_density(space, "wrong", cells, N_CELLS, &base), DQA_ERROR_ARGUMENT, "cells");
    }
    ellipsoid(cells, 5.0, 2.0, 2.0);
    refused(dqa_shape_space_add_density(space, "short", cells, N_CELLS - 1, &base), DQA_ERROR_ARGUMENT, "cells|n");
    refused(dqa_shape_space_add_density(space, "long", cells, N_CELLS + 1, &base), DQA_ERROR_ARGUMENT, "cells|n");
    refused(dqa_shape_space_add_density(space, "none", cells, -N_CELLS, &base), DQA_ERROR_ARGUMENT, "cells|n");

    /* None of the refused ones became a base. */
    ok(dqa_shape_space_get_info(space, &info, sizeof info));
    assert_int_equal(info.n_bases, N_BASES);
    ok(dqa_shape_space_add_density(space, "third", cells, N_CELLS, &base));
    assert_int_equal(base, N_BASES);
    assert_string_equal(dqa_shape_space_base_name(space, base), "third");
    dqa_shape_space_free(space);
    free(cells);
}

static void meshes_are_checked(void** state) {
    const dqa_shape_space_options options = tiny_options();
    dqa_shape_space* space = NULL;
    double vertices[4][3];
    int32_t faces[4][3];
    int32_t base = -1;
    (void)state;
    ok(dqa_shape_space_create(&options, &space));

    refused(dqa_shape_space_add_mesh(space, "m", TETRAHEDRON[0], -4, FACES[0], 4, NULL), DQA_ERROR_ARGUMENT,
            "n_vertices");
    refused(dqa_shape_space_add_mesh(space, "m", TETRAHEDRON[0], 4, FACES[0], -4, NULL), DQA_ERROR_ARGUMENT,
            "n_triangles");
    assert_int_equal(dqa_shape_space_add_mesh(space, "open", TETRAHEDRON[0], 4, FACES[0], 3, NULL), DQA_ERROR_MESH);
    assert_int_equal(dqa_shape_space_add_mesh(space, "empty", TETRAHEDRON[0], 4, FACES[0], 0, NULL), DQA_ERROR_MESH);

    memcpy(faces, FACES, sizeof faces);
    faces[2][1] = 4;
    assert_int_not_equal(dqa_shape_space_add_mesh(space, "index", TETRAHEDRON[0], 4, faces[0], 4, NULL), DQA_SUCCESS);
    faces[2][1] = -1;
    assert_int_not_equal(dqa_shape_space_add_mesh(space, "index", TETRAHEDRON[0], 4, faces[0], 4, NULL), DQA_SUCCESS);
    memcpy(faces, FACES, sizeof faces);
    faces[2][1] = FACES[2][2];
    faces[2][2] = FACES[2][1];
    assert_int_equal(dqa_shape_space_add_mesh(space, "turned", TETRAHEDRON[0], 4, faces[0], 4, NULL), DQA_ERROR_MESH);

    memcpy(vertices, TETRAHEDRON, sizeof vertices);
    vertices[1][2] = NAN;
    assert_int_equal(dqa_shape_space_add_mesh(space, "nan", vertices[0], 4, FACES[0], 4, NULL), DQA_ERROR_MESH);
    memset(vertices, 0, sizeof vertices);
    assert_int_equal(dqa_shape_space_add_mesh(space, "flat", vertices[0], 4, FACES[0], 4, NULL), DQA_ERROR_MESH);

    ok(dqa_shape_space_add_mesh(space, "good", TETRAHEDRON[0], 4, FACES[0], 4, &base));
    assert_int_equal(base, 0);
    assert_string_equal(dqa_shape_space_base_name(space, 0), "good");
    assert_string_equal(dqa_shape_space_base_name(space, 1), "");
    assert_string_equal(dqa_shape_space_base_name(space, -1), "");
    dqa_shape_space_free(space);
}

static void mesh_files_are_checked(void** state) {
    dqa_shape_space* space = tiny_space_open();
    FILE* file;
    int32_t base = -1;
    int i, k;
    (void)state;
    refused(dqa_shape_space_add_mesh_file(space, "no/such/file.stl", NULL), DQA_ERROR_IO, "stl");
    file = fopen("garbage.stl", "wb");
    assert_non_null(file);
    fputs("solid but then nothing that an STL file would say", file);
    fclose(file);
    refused(dqa_shape_space_add_mesh_file(space, "garbage.stl", NULL), DQA_ERROR_FILE, "stl");
    file = fopen("empty.stl", "wb");
    assert_non_null(file);
    fclose(file);
    refused(dqa_shape_space_add_mesh_file(space, "empty.stl", NULL), DQA_ERROR_FILE, "stl");
    /* A good one, and the name that its base gets from it. */
    file = fopen("tetrahedron.v2.stl", "wb");
    assert_non_null(file);
    fputs("solid t\n", file);
    for (i = 0; i < 4; ++i) {
        fputs("facet normal 0 0 0\nouter loop\n", file);
        for (k = 0; k < 3; ++k) {
            const double* v = TETRAHEDRON[FACES[i][k]];
            fprintf(file, "vertex %g %g %g\n", v[0], v[1], v[2]);
        }
        fputs("endloop\nendfacet\n", file);
    }
    fputs("endsolid t\n", file);
    fclose(file);
    ok(dqa_shape_space_add_mesh_file(space, "./tetrahedron.v2.stl", &base));
    assert_int_equal(base, 2);
    assert_string_equal(dqa_shape_space_base_name(space, 2), "tetrahedron.v2");
    dqa_shape_space_free(space);
}

static void actuators_are_checked(void** state) {
    dqa_shape_space_options options = tiny_options();
    dqa_shape_space* space = tiny_space_open();
    dqa_shape_space* unscaled = NULL;
    dqa_actuator_options actuator, wrong, read;
    double* cells = doubles(N_CELLS);
    int axis;
    (void)state;
    ok(dqa_actuator_options_init(&actuator, sizeof actuator));
    ok(dqa_actuator_options_init(&read, sizeof read));
    actuator.mean[0] = -0.2;
    actuator.variance[0] = 0.02;
    actuator.variance[1] = 0.01;
    actuator.variance[2] = 0.01;

    assert_int_equal(dqa_shape_space_get_actuator(space, 0, 0, DQA_SIDE_BOTH, &read), DQA_ERROR_STATE);
    refused(dqa_shape_space_add_actuator(space, 9, &actuator), DQA_ERROR_ARGUMENT, "base");
    refused(dqa_shape_space_add_actuator(space, -1, &actuator), DQA_ERROR_ARGUMENT, "base");
    for (axis = 0; axis < 3; ++axis) {
        wrong = actuator;
        wrong.variance[axis] = 0.0;
        refused(dqa_shape_space_add_actuator(space, 0, &wrong), DQA_ERROR_ARGUMENT, "variance");
        wrong = actuator;
        wrong.mean[axis] = NAN;
        refused(dqa_shape_space_add_actuator(space, 0, &wrong), DQA_ERROR_ARGUMENT, "mean");
        wrong = actuator;
        wrong.euler[axis] = INFINITY;
        refused(dqa_shape_space_add_actuator(space, 0, &wrong), DQA_ERROR_ARGUMENT, "euler");
    }
    wrong = actuator;
    wrong.category = 16;
    refused(dqa_shape_space_add_actuator(space, 0, &wrong), DQA_ERROR_ARGUMENT, "category");
    wrong = actuator;
    wrong.category = -1;
    refused(dqa_shape_space_add_actuator(space, 0, &wrong), DQA_ERROR_ARGUMENT, "category");
    wrong = actuator;
    wrong.kind = 2;
    refused(dqa_shape_space_add_actuator(space, 0, &wrong), DQA_ERROR_ARGUMENT, "kind");
    wrong = actuator;
    wrong.side = DQA_SIDE_LEFT;
    refused(dqa_shape_space_add_actuator(space, 0, &wrong), DQA_ERROR_ARGUMENT, "side");
    wrong = actuator;
    wrong.kind = DQA_ACTUATOR_FINS;
    wrong.layers = 5;
    refused(dqa_shape_space_add_actuator(space, 0, &wrong), DQA_ERROR_ARGUMENT, "layers");
    wrong = actuator;
    wrong.kind = DQA_ACTUATOR_FINS;
    wrong.variance[2] = 1.0;
    refused(dqa_shape_space_add_actuator(space, 0, &wrong), DQA_ERROR_ARGUMENT, "variance");
    wrong = actuator;
    wrong.flags = 1;
    refused(dqa_shape_space_add_actuator(space, 0, &wrong), DQA_ERROR_ARGUMENT, "flags");

    ok(dqa_shape_space_add_actuator(space, 0, &actuator));
    assert_int_not_equal(dqa_shape_space_add_actuator(space, 0, &actuator), DQA_SUCCESS); /* one of each category */
    ok(dqa_shape_space_get_actuator(space, 0, 0, DQA_SIDE_BOTH, &read));
    assert_memory_equal(read.mean, actuator.mean, sizeof read.mean);
    assert_memory_equal(read.variance, actuator.variance, sizeof read.variance);
    refused(dqa_shape_space_get_actuator(space, 2, 0, DQA_SIDE_BOTH, &read), DQA_ERROR_ARGUMENT, "base");
    refused(dqa_shape_space_get_actuator(space, 0, 0, DQA_SIDE_BOTH, NULL), DQA_ERROR_ARGUMENT, "options");

    /* The base without one gets its own from its geometry. */
    ok(dqa_shape_space_build(space, NULL, NULL));
    ok(dqa_shape_space_get_actuator(space, 1, 0, DQA_SIDE_BOTH, &read));
    assert_true(read.variance[0] > 0.0 && read.variance[1] > 0.0 && read.variance[2] > 0.0);
    refused(dqa_shape_space_get_actuator(space, 1, 16, DQA_SIDE_BOTH, &read), DQA_ERROR_ARGUMENT, "category");
    refused(dqa_shape_space_get_actuator(space, 1, 0, 3, &read), DQA_ERROR_ARGUMENT, "side");
    assert_int_equal(dqa_shape_space_get_actuator(space, 1, 5, DQA_SIDE_BOTH, &read), DQA_ERROR_STATE);
    dqa_shape_space_free(space);

    /* Without a cell size, metres have no meaning yet. */
    options.cell_size = 0.0;
    ok(dqa_shape_space_create(&options, &unscaled));
    ellipsoid(cells, 5.0, 2.0, 2.0);
    ok(dqa_shape_space_add_density(unscaled, "a", cells, N_CELLS, NULL));
    refused(dqa_shape_space_add_actuator(unscaled, 0, &actuator), DQA_ERROR_STATE, "cell_size");
    dqa_shape_space_free(unscaled);
    free(cells);
}

/* Sixteen signals of a pair of fins and one of the tail, in the order of their categories. */
static void fins_and_their_signals(void** state) {
    dqa_shape_space* space = tiny_space_open();
    dqa_simulator* simulator;
    dqa_shape_space_info info;
    dqa_signal_info signal;
    dqa_actuator_options fins, caudal, read;
    dqa_actuator_info left, right;
    int32_t *cells, *signals, *signs, counts[17] = {0};
    double *directions, *stiffness, weights[N_BASES] = {0.4, 0.6};
    int64_t n = 0, i;
    int32_t k;
    (void)state;
    ok(dqa_actuator_options_init(&fins, sizeof fins));
    assert_int_equal(fins.layers, 4);
    fins.kind = DQA_ACTUATOR_FINS;
    fins.category = 3;
    fins.mean[1] = 0.1;
    fins.variance[0] = 0.03;
    fins.variance[1] = 0.012;
    fins.variance[2] = 0.006;
    fins.euler[0] = 0.2;
    ok(dqa_shape_space_add_actuator(space, 0, &fins));
    fins.side = DQA_SIDE_LEFT;
    fins.euler[0] = 0.3;
    ok(dqa_shape_space_add_actuator(space, 1, &fins));
    assert_int_equal(dqa_shape_space_add_actuator(space, 1, &fins), DQA_ERROR_STATE);
    fins.side = DQA_SIDE_RIGHT;
    fins.layers = 3;
    refused(dqa_shape_space_add_actuator(space, 1, &fins), DQA_ERROR_ARGUMENT, "layers");
    fins.layers = 4;
    fins.kind = DQA_ACTUATOR_CAUDAL;
    fins.side = DQA_SIDE_BOTH;
    refused(dqa_shape_space_add_actuator(space, 1, &fins), DQA_ERROR_ARGUMENT, "kind");
    ok(dqa_actuator_options_init(&caudal, sizeof caudal));
    caudal.category = 7;
    caudal.mean[0] = -0.3;
    ok(dqa_shape_space_add_actuator(space, 0, &caudal));
    ok(dqa_actuator_options_init(&read, sizeof read));
    ok(dqa_shape_space_get_actuator(space, 0, 3, DQA_SIDE_RIGHT, &read));
    assert_true(read.mean[1] == -0.1 && read.euler[0] == -0.2 && read.variance[1] == 0.012 && read.layers == 4);
    assert_int_equal(read.kind, DQA_ACTUATOR_FINS);
    assert_int_equal(read.side, DQA_SIDE_RIGHT);
    assert_int_equal(dqa_shape_space_get_actuator(space, 1, 3, DQA_SIDE_RIGHT, &read), DQA_ERROR_STATE);
    assert_int_equal(dqa_shape_space_signal(space, 0, &signal, sizeof signal), DQA_ERROR_STATE);

    ok(dqa_shape_space_build(space, NULL, NULL));
    ok(dqa_shape_space_get_info(space, &info, sizeof info));
    assert_int_equal(info.n_signals, 17);
    for (k = 0; k < 16; ++k) {
        ok(dqa_shape_space_signal(space, k, &signal, sizeof signal));
        assert_int_equal(signal.category, 3);
        assert_int_equal(signal.kind, DQA_ACTUATOR_FINS);
        assert_int_equal(signal.layer, k / 4);
        assert_int_equal(signal.group, k % 4);
    }
    ok(dqa_shape_space_signal(space, 16, &signal, sizeof signal));
    assert_int_equal(signal.category, 7);
    assert_int_equal(signal.kind, DQA_ACTUATOR_CAUDAL);
    refused(dqa_shape_space_signal(space, 17, &signal, sizeof signal), DQA_ERROR_ARGUMENT, "signal");
    refused(dqa_shape_space_signal(space, -1, &signal, sizeof signal), DQA_ERROR_ARGUMENT, "signal");
    refused(dqa_shape_space_signal(space, 0, NULL, sizeof signal), DQA_ERROR_ARGUMENT, "info");

    ok(dqa_simulator_create(space, NULL, &simulator));
    assert_int_equal(dqa_simulator_actuator(simulator, 3, DQA_SIDE_LEFT, &left, sizeof left), DQA_ERROR_STATE);
    ok(dqa_simulator_set_weights(simulator, weights, N_BASES, NULL, NULL));
    ok(dqa_simulator_actuator(simulator, 3, DQA_SIDE_LEFT, &left, sizeof left));
    ok(dqa_simulator_actuator(simulator, 3, DQA_SIDE_RIGHT, &right, sizeof right));
    assert_true(left.share == 1.0 && left.strength == 1.0 && right.share == 0.4);
    assert_true(left.n_signals == 16 && left.first_signal == 0 && left.layers == 4);
    assert_true(left.mean[1] > 0.0 && right.mean[1] == -0.1);
    assert_true(left.covariance[0] > 0.0 && left.covariance[1] == left.covariance[3]);
    assert_int_equal(dqa_simulator_actuator(simulator, 3, DQA_SIDE_BOTH, &left, sizeof left), DQA_ERROR_STATE);
    assert_int_equal(dqa_simulator_actuator(simulator, 4, DQA_SIDE_LEFT, &left, sizeof left), DQA_ERROR_STATE);

    ok(dqa_simulator_muscles(simulator, NULL, NULL, NULL, 0, NULL, 0, NULL, 0, &n));
    assert_true(n > 100);
    cells = malloc(3 * (size_t)n * sizeof *cells);
    assert_non_null(cells);
    signals = cells + n;
    signs = signals + n;
    directions = doubles(3 * n);
    stiffness = doubles(n);
    ok(dqa_simulator_muscles(simulator, cells, signals, signs, n, directions, 3 * n, stiffness, n, NULL));
    for (i = 0; i < n; ++i) {
        const double* d = directions + 3 * i;
        assert_true(signals[i] >= 0 && signals[i] < 17 && cells[i] >= 0 && stiffness[i] > 0.0);
        assert_true(fabs(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1.0) < 1e-14);
        assert_true(signals[i] == 16 ? d[0] == 1.0 : signs[i] == 1);
        ++counts[signals[i]];
    }
    for (k = 0; k < 17; ++k) assert_true(counts[k] > 0);
    refused(dqa_simulator_muscles(simulator, cells, NULL, NULL, n - 1, NULL, 0, NULL, 0, NULL), DQA_ERROR_ARGUMENT,
            "n");
    refused(dqa_simulator_muscles(simulator, NULL, NULL, NULL, 0, directions, n, NULL, 0, NULL), DQA_ERROR_ARGUMENT,
            "nd");
    dqa_simulator_free(simulator);
    dqa_shape_space_free(space);
    free(cells);
    free(directions);
    free(stiffness);
}

static void plane_bases(void** state) {
    const double fish[10] = {-1.0, -0.1, 0.2, -0.3, 1.0, 0.0, 0.2, 0.3, -1.0, 0.1};
    const double bow[8] = {0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0};
    const double pixels[6] = {0.2, 1.0, 0.5, 0.2, 1.0, 0.5};
    dqa_shape_space_options options;
    dqa_shape_space *space = NULL, *solid = tiny_space_open();
    dqa_simulator* simulator = NULL;
    dqa_actuator_info actuator;
    double* directions;
    int64_t n = 0;
    double* cells = doubles(24 * 10);
    int32_t base = -1;
    int64_t c;
    double total = 0.0;
    (void)state;
    ok(dqa_shape_space_options_init(&options, sizeof options));
    options.dims = 2;
    options.cells_x = 24;
    options.cells_y = 10;
    ok(dqa_shape_space_create(&options, &space));
    ok(dqa_shape_space_add_polygon(space, "fish", fish, 5, &base));
    assert_int_equal(base, 0);
    ok(dqa_shape_space_add_image(space, "bar", pixels, 2, 3, &base));
    assert_int_equal(base, 1);
    ok(dqa_shape_space_get_base(space, 0, cells, 24 * 10));
    for (c = 0; c < 24 * 10; ++c) total += cells[c];
    assert_true(total > 20.0);
    refused(dqa_shape_space_add_polygon(space, "bow", bow, 4, NULL), DQA_ERROR_ARGUMENT, "polygon");
    refused(dqa_shape_space_add_polygon(space, "bow", bow, 2, NULL), DQA_ERROR_ARGUMENT, "n_corners");
    refused(dqa_shape_space_add_polygon(space, "bow", NULL, 4, NULL), DQA_ERROR_ARGUMENT, "corners");
    refused(dqa_shape_space_add_polygon(solid, "fish", fish, 5, NULL), DQA_ERROR_ARGUMENT, "dims");
    refused(dqa_shape_space_add_image(space, "bar", NULL, 2, 3, NULL), DQA_ERROR_ARGUMENT, "pixels");
    refused(dqa_shape_space_add_image(space, "bar", pixels, 0, 3, NULL), DQA_ERROR_ARGUMENT, "n_rows");
    refused(dqa_shape_space_add_image(space, "bar", pixels, 2, -1, NULL), DQA_ERROR_ARGUMENT, "n_columns");
    refused(dqa_shape_space_add_image(space, NULL, pixels, 2, 3, NULL), DQA_ERROR_ARGUMENT, "name");
    refused(dqa_shape_space_add_image(solid, "bar", pixels, 2, 3, NULL), DQA_ERROR_ARGUMENT, "dims");
    ok(dqa_shape_space_build(space, NULL, NULL));
    ok(dqa_simulator_create(space, NULL, &simulator));
    ok(dqa_simulator_set_weights(simulator, HALF, N_BASES, NULL, NULL));
    ok(dqa_simulator_muscles(simulator, NULL, NULL, NULL, 0, NULL, 0, NULL, 0, &n));
    assert_true(n > 10);
    directions = doubles(2 * n);
    ok(dqa_simulator_muscles(simulator, NULL, NULL, NULL, 0, directions, 2 * n, NULL, 0, NULL));
    for (c = 0; c < n; ++c) assert_true(directions[2 * c] == 1.0 && directions[2 * c + 1] == 0.0);
    ok(dqa_simulator_actuator(simulator, 0, DQA_SIDE_BOTH, &actuator, sizeof actuator));
    assert_true(actuator.half[0] > 0.1 && actuator.strength == 1.0);
    dqa_simulator_free(simulator);
    free(directions);
    dqa_shape_space_free(space);
    dqa_shape_space_free(solid);
    free(cells);
}

static void build_freezes(void** state) {
    dqa_shape_space* space = tiny_space_open();
    dqa_shape_space* bare = NULL;
    dqa_shape_space_info info;
    dqa_actuator_options actuator;
    double* cells = doubles(N_CELLS);
    double* base = doubles(N_CELLS);
    int64_t calls = 0;
    (void)state;
    ok(dqa_shape_space_create(NULL, &bare));
    assert_int_equal(dqa_shape_space_build(bare, NULL, NULL), DQA_ERROR_STATE); /* no base yet */
    dqa_shape_space_free(bare);

    ok(dqa_shape_space_get_info(space, &info, sizeof info));
    assert_int_equal(info.is_built, 0);
    assert_int_equal(info.n_signals, 0);
    refused(dqa_shape_space_build(space, cancel_at_once, NULL), DQA_CANCELLED, "callback");
    ok(dqa_shape_space_build(space, count_progress, &calls));
    ok(dqa_shape_space_get_info(space, &info, sizeof info));
    assert_int_equal(info.struct_size, sizeof info);
    assert_int_equal(info.dims, 3);
    assert_int_equal(info.cells_x, NX);
    assert_int_equal(info.cells_y, NY);
    assert_int_equal(info.cells_z, NZ);
    assert_int_equal(info.n_cells, N_CELLS);
    assert_int_equal(info.n_bases, N_BASES);
    assert_int_equal(info.is_built, 1);
    assert_true(info.n_signals > 0);
    assert_true(info.cell_size == 0.1);

    assert_int_equal(dqa_shape_space_build(space, NULL, NULL), DQA_ERROR_STATE);
    ellipsoid(cells, 6.0, 1.8, 2.4);
    assert_int_equal(dqa_shape_space_add_density(space, "late", cells, N_CELLS, NULL), DQA_ERROR_STATE);
    assert_int_equal(dqa_shape_space_add_mesh(space, "late", TETRAHEDRON[0], 4, FACES[0], 4, NULL), DQA_ERROR_STATE);
    assert_int_equal(dqa_shape_space_add_mesh_file(space, "late.stl", NULL), DQA_ERROR_STATE);
    ok(dqa_actuator_options_init(&actuator, sizeof actuator));
    assert_int_equal(dqa_shape_space_add_actuator(space, 0, &actuator), DQA_ERROR_STATE);

    ok(dqa_shape_space_get_base(space, 0, base, N_CELLS));
    assert_memory_equal(base, cells, N_CELLS * sizeof *base);
    refused(dqa_shape_space_get_base(space, 2, base, N_CELLS), DQA_ERROR_ARGUMENT, "base");
    refused(dqa_shape_space_get_base(space, 0, base, N_CELLS - 1), DQA_ERROR_ARGUMENT, "cells|n");
    dqa_shape_space_free(space);
    free(cells);
    free(base);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(null_arguments),        cmocka_unit_test(densities_are_checked),
        cmocka_unit_test(meshes_are_checked),    cmocka_unit_test(mesh_files_are_checked),
        cmocka_unit_test(actuators_are_checked), cmocka_unit_test(fins_and_their_signals),
        cmocka_unit_test(plane_bases),           cmocka_unit_test(build_freezes),
    };
    return cmocka_run_group_tests_name("shape_space", tests, NULL, NULL);
}
