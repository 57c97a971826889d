/* SPDX-License-Identifier: MIT */
#include "scenes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

static void ok(dqa_status status, const char* what) {
    if (status == DQA_SUCCESS) return;
    fprintf(stderr, "scenes: %s: %s: %s\n", what, dqa_status_name(status), dqa_last_error());
    exit(1);
}

/* Solves are tight and in plain instructions: what is left of the difference between two machines is rounding. */
const setting plane_space[] = {{"dims", 2},     {"cells_x", 24},      {"cells_y", 10},
                               {"sigma", 0.75}, {"tolerance", 1e-13}, {NULL, 0}};
const setting box_space[] = {{"cells_x", 16}, {"cells_y", 8},       {"cells_z", 8},
                             {"sigma", 0.75}, {"tolerance", 1e-13}, {NULL, 0}};
const setting plane_simulator[] = {{"instruction_set", 1},
                                   {"time_step", 0.03125},
                                   {"young_modulus", 2e5},
                                   {"muscle_stiffness", 1e6},
                                   {"tolerance", 1e-13},
                                   {"adjoint_tolerance", 1e-14},
                                   {"linear_precision", DQA_PRECISION_DOUBLE},
                                   {NULL, 0}};
const setting box_simulator[] = {{"instruction_set", 1},
                                 {"time_step", 0.03125},
                                 {"material", DQA_MATERIAL_NEO_HOOKEAN},
                                 {"young_modulus", 2e5},
                                 {"poisson_ratio", 0.375},
                                 {"muscle_stiffness", 1e6},
                                 {"tolerance", 1e-13},
                                 {"adjoint_tolerance", 1e-14},
                                 {"linear_precision", DQA_PRECISION_DOUBLE},
                                 {NULL, 0}};
const setting plane_perceptron[] = {{"n_signals", 1}, {"dims", 2},  {"n_hidden", 1}, {"hidden", 8},
                                    {"seed", 5},      {"scale", 2}, {NULL, 0}};
const setting box_perceptron[] = {{"n_signals", 1}, {"dims", 3},  {"n_hidden", 1}, {"hidden", 8},
                                  {"seed", 5},      {"scale", 2}, {NULL, 0}};

#define INTEGER(field) \
    if (strcmp(list->name, #field) == 0) o.field = (int32_t)list->value, known = 1
#define NUMBER(field) \
    if (strcmp(list->name, #field) == 0) o.field = list->value, known = 1

static void must(int known, const char* name) {
    if (known) return;
    fprintf(stderr, "scenes: unknown option %s\n", name);
    exit(1);
}

static dqa_shape_space* open_space(const setting* list) {
    dqa_shape_space_options o;
    dqa_shape_space* space;
    ok(dqa_shape_space_options_init(&o, sizeof o), "options");
    for (; list->name != NULL; ++list) {
        int known = 0;
        INTEGER(dims);
        INTEGER(cells_x);
        INTEGER(cells_y);
        INTEGER(cells_z);
        NUMBER(sigma);
        NUMBER(tolerance);
        must(known, list->name);
    }
    ok(dqa_shape_space_create(&o, &space), "space");
    return space;
}

dqa_simulator* make_simulator(const scene* s, const setting* list) {
    dqa_simulator_options o;
    dqa_simulator* simulator;
    ok(dqa_simulator_options_init(&o, sizeof o), "options");
    for (; list->name != NULL; ++list) {
        int known = 0;
        INTEGER(instruction_set);
        INTEGER(material);
        INTEGER(linear_precision);
        NUMBER(time_step);
        NUMBER(young_modulus);
        NUMBER(poisson_ratio);
        NUMBER(muscle_stiffness);
        NUMBER(tolerance);
        NUMBER(adjoint_tolerance);
        must(known, list->name);
    }
    ok(dqa_simulator_create(s->space, &o, &simulator), "simulator");
    return simulator;
}

dqa_controller* make_sine(void) {
    const double theta[3] = {0.75, 12.0, 0.25};
    dqa_controller* sine;
    ok(dqa_controller_create_sinusoid(1, 0.03125, &sine), "sine");
    ok(dqa_controller_set_parameters(sine, theta, 3), "sine");
    return sine;
}

dqa_controller* make_perceptron(int32_t dims) {
    const setting* list = dims == 2 ? plane_perceptron : box_perceptron;
    dqa_mlp_options o;
    dqa_controller* perceptron;
    ok(dqa_mlp_options_init(&o, sizeof o), "options");
    for (; list->name != NULL; ++list) {
        int known = 0;
        INTEGER(n_signals);
        INTEGER(dims);
        INTEGER(n_hidden);
        NUMBER(scale);
        if (strcmp(list->name, "hidden") == 0) o.hidden[0] = (int32_t)list->value, known = 1;
        if (strcmp(list->name, "seed") == 0) o.seed = (uint64_t)list->value, known = 1;
        must(known, list->name);
    }
    ok(dqa_controller_create_mlp(&o, &perceptron), "perceptron");
    return perceptron;
}

/* A fish from above: half its width over the length, a peduncle and a tail fin behind it. */
static void outline(double* corners, int64_t n, double width) {
    for (int64_t i = 0; i < n / 2; ++i) {
        const double s = ((double)i + 0.5) / (double)(n / 2);
        const double trunk = width * sin(PI * pow(s, 0.75)), tail = s > 0.75 ? 0.25 * (s - 0.75) : 0.0;
        const double half = 0.02 + trunk + tail;
        corners[2 * i] = corners[2 * (n - 1 - i)] = 0.5 - s;
        corners[2 * i + 1] = half;
        corners[2 * (n - 1 - i) + 1] = -half;
    }
}

void make_plane(scene* s) {
    memset(s, 0, sizeof *s);
    s->name = "plane";
    s->dims = 2;
    s->space_settings = plane_space;
    s->names[0] = "slim";
    s->names[1] = "stout";
    s->n_points = 32;
    s->space = open_space(plane_space);
    for (int b = 0; b < N_BASES; ++b) {
        outline(s->points[b], s->n_points, b == 0 ? 0.0625 : 0.125);
        ok(dqa_shape_space_add_polygon(s->space, s->names[b], s->points[b], s->n_points, NULL), "polygon");
    }
    ok(dqa_shape_space_build(s->space, NULL, NULL), "build");
}

/* A spindle: a nose, rings of eight vertices, a tail point. */
enum { RINGS = 5, SEGMENTS = 8 };

static void spindle(double* vertices, double width, double height) {
    int64_t v = 0;
    vertices[3 * v] = 0.5, vertices[3 * v + 1] = vertices[3 * v + 2] = 0.0, ++v;
    for (int r = 0; r < RINGS; ++r) {
        const double s = (r + 1.0) / (RINGS + 1.0), radius = sqrt(sin(PI * s));
        for (int k = 0; k < SEGMENTS; ++k, ++v) {
            const double angle = 2.0 * PI * k / SEGMENTS;
            vertices[3 * v] = 0.5 - s;
            vertices[3 * v + 1] = width * radius * cos(angle);
            vertices[3 * v + 2] = height * radius * sin(angle);
        }
    }
    vertices[3 * v] = -0.5, vertices[3 * v + 1] = vertices[3 * v + 2] = 0.0;
}

static int64_t spindle_triangles(int32_t* t) {
    const int32_t tail = 1 + RINGS * SEGMENTS;
    int64_t n = 0;
    for (int32_t k = 0; k < SEGMENTS; ++k) {
        const int32_t next = (k + 1) % SEGMENTS, last = 1 + (RINGS - 1) * SEGMENTS;
        t[3 * n] = 0, t[3 * n + 1] = 1 + k, t[3 * n + 2] = 1 + next, ++n;
        for (int32_t r = 0; r + 1 < RINGS; ++r) {
            const int32_t a = 1 + r * SEGMENTS, b = a + SEGMENTS;
            t[3 * n] = a + k, t[3 * n + 1] = b + k, t[3 * n + 2] = b + next, ++n;
            t[3 * n] = a + k, t[3 * n + 1] = b + next, t[3 * n + 2] = a + next, ++n;
        }
        t[3 * n] = last + k, t[3 * n + 1] = tail, t[3 * n + 2] = last + next, ++n;
    }
    return n;
}

void make_box(scene* s) {
    memset(s, 0, sizeof *s);
    s->name = "box";
    s->dims = 3;
    s->space_settings = box_space;
    s->names[0] = "tall";
    s->names[1] = "wide";
    s->n_points = 2 + RINGS * SEGMENTS;
    s->n_triangles = spindle_triangles(s->triangles);
    s->space = open_space(box_space);
    for (int b = 0; b < N_BASES; ++b) {
        spindle(s->points[b], b == 0 ? 0.1 : 0.17, b == 0 ? 0.17 : 0.1);
        ok(dqa_shape_space_add_mesh(s->space, s->names[b], s->points[b], s->n_points, s->triangles, s->n_triangles,
                                    NULL),
           "mesh");
    }
    ok(dqa_shape_space_build(s->space, NULL, NULL), "build");
}
