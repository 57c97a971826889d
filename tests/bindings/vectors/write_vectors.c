/* SPDX-License-Identifier: MIT
 *
 * write_vectors — inputs and what the library answers, as one JSON file for the tests of every language.
 *
 *   write_vectors FILE
 *
 * README.md beside this file says what stands in it. Solves are tight, so that another processor or compiler changes
 * the numbers by rounding alone. Only diffaqua.h and the C library are used. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "diffaqua.h"
#include "scenes.h"

static FILE* out;

static void ok(dqa_status status, const char* what) {
    if (status == DQA_SUCCESS) return;
    fprintf(stderr, "write_vectors: %s: %s: %s\n", what, dqa_status_name(status), dqa_last_error());
    exit(1);
}

static double* numbers(int64_t n) {
    double* values = calloc((size_t)(n > 0 ? n : 1), sizeof *values);
    if (values == NULL) exit(1);
    return values;
}

/* ------------------------------------------------------------------ JSON */
static const char* separator = "";

static void key(const char* name) {
    fprintf(out, "%s\n\"%s\": ", separator, name);
    separator = ",";
}

static void open_object(const char* name) {
    if (name != NULL)
        key(name);
    else
        fprintf(out, "%s\n", separator);
    fputc('{', out);
    separator = "";
}

static void close_object(void) {
    fputs("}", out);
    separator = ",";
}

static void open_list(const char* name) {
    key(name);
    fputc('[', out);
    separator = "";
}

static void close_list(void) {
    fputs("]", out);
    separator = ",";
}

static void put(const char* name, double value) {
    key(name);
    fprintf(out, "%.17g", value);
}

static void put_text(const char* name, const char* text) {
    key(name);
    fputc('"', out);
    for (; *text != '\0'; ++text) {
        if (*text == '"' || *text == '\\') fputc('\\', out);
        fputc(*text, out);
    }
    fputc('"', out);
}

static void put_array(const char* name, const double* values, int64_t n) {
    key(name);
    fputc('[', out);
    for (int64_t i = 0; i < n; ++i) fprintf(out, "%s%.17g", i > 0 ? (i % 8 == 0 ? ",\n" : ", ") : "", values[i]);
    fputc(']', out);
}

static void put_settings(const setting* list) {
    open_object("options");
    for (; list->name != NULL; ++list) put(list->name, list->value);
    close_object();
}

/* ------------------------------------------------------------------ helpers of optimisers */
static void write_helpers(void) {
    double x[4] = {0.7, -0.2, 0.4, 0.31}, projected[4];
    double point[3] = {0.3, -1.5, 2.0}, first[3] = {0.1, 0.0, -0.2}, second[3] = {0.01, 0.0, 0.5};
    const double gradient[3] = {0.5, -2.0, 1e-3}, rates[3] = {0.05, 0.1, 0.2};
    open_object("project_simplex");
    memcpy(projected, x, sizeof x);
    ok(dqa_project_simplex(projected, 4), "project");
    put_array("x", x, 4);
    put_array("result", projected, 4);
    close_object();
    open_object("adam_step");
    put_array("x", point, 3);
    put_array("gradient", gradient, 3);
    put_array("rates", rates, 3);
    put_array("first_moment", first, 3);
    put_array("second_moment", second, 3);
    put("iteration", 7);
    ok(dqa_adam_step(point, gradient, rates, first, second, 3, 7), "adam");
    put_array("x_after", point, 3);
    put_array("first_moment_after", first, 3);
    put_array("second_moment_after", second, 3);
    close_object();
}

/* ------------------------------------------------------------------ spaces */
static void write_bases(const scene* s) {
    open_list(s->dims == 2 ? "polygons" : "meshes");
    for (int b = 0; b < N_BASES; ++b) {
        open_object(NULL);
        put_text("name", s->names[b]);
        if (s->dims == 2) {
            put_array("corners", s->points[b], 2 * s->n_points);
        } else {
            double corners[3 * MAX_TRIANGLES];
            for (int64_t i = 0; i < 3 * s->n_triangles; ++i) corners[i] = s->triangles[i];
            put_array("vertices", s->points[b], 3 * s->n_points);
            put_array("triangles", corners, 3 * s->n_triangles);
        }
        close_object();
    }
    close_list();
}

static void write_space(const scene* s) {
    const double weights[N_BASES] = {0.375, 0.625};
    dqa_shape_space_info info;
    double *density, *bar, weights_bar[N_BASES];
    ok(dqa_shape_space_get_info(s->space, &info, sizeof info), "info");
    density = numbers(info.n_cells);
    bar = numbers(info.n_cells);
    for (int64_t i = 0; i < info.n_cells; ++i) bar[i] = (double)(i % 7) - 3.0;
    open_object(NULL);
    put_text("name", s->name);
    put_settings(s->space_settings);
    write_bases(s);
    put_array("weights", weights, N_BASES);
    ok(dqa_shape_space_density(s->space, weights, N_BASES, density, info.n_cells), "density");
    put_array("density", density, info.n_cells);
    put_array("density_bar", bar, info.n_cells);
    ok(dqa_shape_space_pullback(s->space, weights, N_BASES, bar, info.n_cells, weights_bar), "pullback");
    put_array("weights_bar", weights_bar, N_BASES);
    close_object();
    free(density);
    free(bar);
}

/* ------------------------------------------------------------------ rollouts */
static void put_gradient(dqa_adjoint* adjoint, const char* name, int32_t wrt, int64_t n) {
    double* values = numbers(n);
    ok(dqa_adjoint_get(adjoint, wrt, values, n), name);
    put_array(name, values, n);
    free(values);
}

static void write_state(dqa_simulator* simulator, const dqa_simulator_info* info) {
    const int64_t n = info->n_nodes * info->dims;
    double *q = numbers(n), *v = numbers(n), sensors[15], forces[12];
    ok(dqa_simulator_get_state(simulator, q, n, v, n), "state");
    ok(dqa_simulator_sensors(simulator, sensors, info->n_sensors), "sensors");
    ok(dqa_simulator_forces(simulator, forces, 4 * info->dims), "forces");
    put_array("q", q, n);
    put_array("v", v, n);
    put_array("sensors", sensors, info->n_sensors);
    put_array("forces", forces, 4 * info->dims);
    free(q);
    free(v);
}

static void write_rollout(const scene* s, int32_t index, const setting* simulator_settings, int closed_loop) {
    const double weights[N_BASES] = {0.5, 0.5};
    const int64_t n_steps = s->dims == 2 ? 12 : 6;
    dqa_objective_term terms[2];
    dqa_simulator* simulator = make_simulator(s, simulator_settings);
    dqa_controller* controller;
    dqa_simulator_info info;
    dqa_tape* tape;
    dqa_adjoint* adjoint;
    double loss, per_term[2], *theta;
    int64_t n_theta;

    open_object(NULL);
    put("space", index);
    put_settings(simulator_settings);
    put_array("weights", weights, N_BASES);
    ok(dqa_simulator_set_weights(simulator, weights, N_BASES, NULL, NULL), "weights");
    ok(dqa_simulator_get_info(simulator, &info, sizeof info), "info");
    open_object("controller");
    put_text("kind", closed_loop ? "mlp" : "sinusoid");
    controller = closed_loop ? make_perceptron(s->dims) : make_sine();
    if (closed_loop) put_settings(s->dims == 2 ? plane_perceptron : box_perceptron);
    ok(dqa_controller_n_parameters(controller, &n_theta), "parameters");
    theta = numbers(n_theta);
    ok(dqa_controller_get_parameters(controller, theta, n_theta), "parameters");
    put_array("theta", theta, n_theta);
    close_object();
    put("n_steps", (double)n_steps);

    ok(dqa_objective_term_init(&terms[0], sizeof terms[0]), "term");
    ok(dqa_objective_term_init(&terms[1], sizeof terms[1]), "term");
    terms[1].kind = DQA_OBJECTIVE_EFFORT;
    /* Of the sign of the first term: nothing cancels, so that rounding stays small beside the loss. */
    terms[1].weight = s->dims == 2 && closed_loop ? 0.0078125 : -0.0078125;
    open_list("terms");
    for (int t = 0; t < 2; ++t) {
        open_object(NULL);
        put("kind", terms[t].kind);
        put("weight", terms[t].weight);
        close_object();
    }
    close_list();

    ok(dqa_tape_create(simulator, NULL, &tape), "tape");
    ok(dqa_simulator_rollout(simulator, controller, n_steps, tape, NULL, NULL), "rollout");
    ok(dqa_tape_objective(tape, terms, 2, &loss, per_term), "objective");
    put("loss", loss);
    put_array("per_term", per_term, 2);
    write_state(simulator, &info);
    ok(dqa_adjoint_create(tape, &adjoint), "adjoint");
    ok(dqa_adjoint_seed_objective(adjoint, terms, 2), "seed");
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL), "backward");
    put_gradient(adjoint, "gradient_weights", DQA_WRT_WEIGHTS, N_BASES);
    put_gradient(adjoint, "gradient_control", DQA_WRT_CONTROL, n_theta);
    put_gradient(adjoint, "gradient_actuation", DQA_WRT_ACTUATION, n_steps * info.n_signals);
    put_gradient(adjoint, "gradient_initial_position", DQA_WRT_INITIAL_POSITION, info.n_nodes * info.dims);
    put_gradient(adjoint, "gradient_material", DQA_WRT_MATERIAL, 4);
    close_object();
    free(theta);
    dqa_adjoint_free(adjoint);
    dqa_tape_free(tape);
    dqa_controller_free(controller);
    dqa_simulator_free(simulator);
}

/* ------------------------------------------------------------------ ten iterations of an optimisation */
static void write_optimisation(const scene* s) {
    enum { ITERATIONS = 10, STEPS = 24, N = N_BASES + 3 };
    const double start[N] = {0.5, 0.5, 0.75, 12.0, 0.25}, rates[N] = {0.05, 0.05, 0.05, 0.5, 0.1};
    double x[N], first[N] = {0}, second[N] = {0}, gradient[N], losses[ITERATIONS], points[ITERATIONS][N];
    dqa_simulator* simulator = make_simulator(s, plane_simulator);
    dqa_controller* sine = make_sine();
    dqa_objective_term travel;
    dqa_tape* tape;
    ok(dqa_objective_term_init(&travel, sizeof travel), "term");
    ok(dqa_tape_create(simulator, NULL, &tape), "tape");
    memcpy(x, start, sizeof x);
    for (int k = 0; k < ITERATIONS; ++k) {
        dqa_adjoint* adjoint;
        ok(dqa_tape_clear(tape), "clear");
        ok(dqa_simulator_set_weights(simulator, x, N_BASES, NULL, NULL), "weights");
        ok(dqa_controller_set_parameters(sine, x + N_BASES, 3), "parameters");
        ok(dqa_simulator_rollout(simulator, sine, STEPS, tape, NULL, NULL), "rollout");
        ok(dqa_tape_objective(tape, &travel, 1, &losses[k], NULL), "objective");
        ok(dqa_adjoint_create(tape, &adjoint), "adjoint");
        ok(dqa_adjoint_seed_objective(adjoint, &travel, 1), "seed");
        ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL), "backward");
        ok(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, gradient, N_BASES), "gradient");
        ok(dqa_adjoint_get(adjoint, DQA_WRT_CONTROL, gradient + N_BASES, 3), "gradient");
        dqa_adjoint_free(adjoint);
        ok(dqa_adam_step(x, gradient, rates, first, second, N, k + 1), "adam");
        ok(dqa_project_simplex(x, N_BASES), "project");
        x[N_BASES] = fmin(fmax(x[N_BASES], 0.0), 1.0);
        memcpy(points[k], x, sizeof x);
    }
    open_object("optimisation");
    put("space", 0);
    put_settings(plane_simulator);
    put("n_bases", N_BASES);
    put("n_steps", STEPS);
    put("iterations", ITERATIONS);
    put_array("x", start, N);
    put_array("rates", rates, N);
    put_array("losses", losses, ITERATIONS);
    put_array("x_after", &points[0][0], (int64_t)ITERATIONS * N);
    close_object();
    dqa_tape_free(tape);
    dqa_controller_free(sine);
    dqa_simulator_free(simulator);
}

/* ------------------------------------------------------------------ what is refused */
static void write_errors(const scene* s) {
    const double off_the_simplex[N_BASES] = {0.75, 0.5}, right[N_BASES] = {0.5, 0.5}, too_much[1] = {1.5};
    dqa_simulator* simulator = make_simulator(s, plane_simulator);
    dqa_status status = dqa_simulator_set_weights(simulator, off_the_simplex, N_BASES, NULL, NULL);
    open_list("errors");
    open_object(NULL);
    put_text("call", "set_weights");
    put_array("argument", off_the_simplex, N_BASES);
    put("status", status);
    put_text("name", dqa_status_name(status));
    put_text("message", dqa_last_error());
    close_object();
    ok(dqa_simulator_set_weights(simulator, right, N_BASES, NULL, NULL), "weights");
    status = dqa_simulator_step(simulator, too_much, 1, NULL);
    open_object(NULL);
    put_text("call", "step");
    put_array("argument", too_much, 1);
    put("status", status);
    put_text("name", dqa_status_name(status));
    put_text("message", dqa_last_error());
    close_object();
    close_list();
    dqa_simulator_free(simulator);
}

int main(int argc, char** argv) {
    scene plane, box;
    if (argc != 2) {
        fprintf(stderr, "usage: write_vectors FILE\n");
        return 2;
    }
    out = fopen(argv[1], "w");
    if (out == NULL) {
        perror(argv[1]);
        return 1;
    }
    make_plane(&plane);
    make_box(&box);
    open_object(NULL);
    put("format", 1);
    put_text("library", dqa_version());
    write_helpers();
    open_list("spaces");
    write_space(&plane);
    write_space(&box);
    close_list();
    open_list("rollouts");
    write_rollout(&plane, 0, plane_simulator, 0);
    write_rollout(&plane, 0, plane_simulator, 1);
    write_rollout(&box, 1, box_simulator, 1);
    close_list();
    write_optimisation(&plane);
    write_errors(&plane);
    close_object();
    fputc('\n', out);
    dqa_shape_space_free(plane.space);
    dqa_shape_space_free(box.space);
    if (ferror(out) || fclose(out) != 0) {
        fprintf(stderr, "write_vectors: cannot write %s\n", argv[1]);
        return 1;
    }
    return 0;
}
