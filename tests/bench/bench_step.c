/* SPDX-License-Identifier: MIT
 * Time and error of one forward and one backward step, against newton_direct at 1e-12 on the same cells.
 *
 *   bench_step [--csv FILE] [--threads N] [--grid NXxNYxNZ] [--steps N] [--repeat N] [--quick] [--direct] [mesh mesh]
 *
 * Without meshes: the shipped clownfish and tuna. Figures are medians over --repeat rollouts (and least, largest). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "diffaqua.h"

enum { MOST_REPEATS = 64 };

typedef struct settings {
    int grid[3], threads, steps, repeat, direct;
    const char *csv, *meshes[2];
} settings;

typedef struct outcome {
    dqa_simulator_info info;
    dqa_tape_statistics stats;
    double forward[MOST_REPEATS], backward[MOST_REPEATS]; /* ms a step */
    int64_t n;
    double *q, bar[2];
} outcome;

static void check(dqa_status status, const char* what) {
    if (status == DQA_SUCCESS) return;
    fprintf(stderr, "bench_step: %s: %s: %s\n", what, dqa_status_name(status), dqa_last_error());
    exit(1);
}

static double milliseconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static int ascending(const void* a, const void* b) {
    const double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

static outcome run(dqa_shape_space* space, const settings* s, int32_t method, double tolerance,
                   double adjoint_tolerance, int repeat) {
    const double weights[2] = {0.5, 0.5};
    dqa_simulator_options o;
    dqa_simulator* simulator;
    dqa_controller* controller;
    dqa_objective_term term;
    outcome out;
    int k;
    memset(&out, 0, sizeof out);
    check(dqa_simulator_options_init(&o, sizeof o), "options");
    o.threads = s->threads, o.method = method, o.tolerance = tolerance, o.adjoint_tolerance = adjoint_tolerance;
    check(dqa_simulator_create(space, &o, &simulator), "simulator");
    check(dqa_simulator_set_weights(simulator, weights, 2, NULL, NULL), "weights");
    check(dqa_objective_term_init(&term, sizeof term), "term");
    check(dqa_controller_create_sinusoid(1, o.time_step, &controller), "controller");
    for (k = 0; k < repeat; ++k) {
        dqa_tape* tape;
        dqa_adjoint* adjoint;
        double start;
        check(dqa_simulator_set_state(simulator, NULL, 0, NULL, 0), "state");
        check(dqa_tape_create(simulator, NULL, &tape), "tape");
        start = milliseconds();
        check(dqa_simulator_rollout(simulator, controller, s->steps, tape, NULL, NULL), "rollout");
        out.forward[k] = (milliseconds() - start) / s->steps;
        check(dqa_adjoint_create(tape, &adjoint), "adjoint");
        check(dqa_adjoint_seed_objective(adjoint, &term, 1), "seed");
        start = milliseconds();
        check(dqa_adjoint_backward(adjoint, 0, NULL, NULL), "backward");
        out.backward[k] = (milliseconds() - start) / s->steps;
        check(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, out.bar, 2), "gradient");
        check(dqa_tape_stats(tape, &out.stats, sizeof out.stats), "statistics");
        dqa_adjoint_free(adjoint);
        dqa_tape_free(tape);
    }
    check(dqa_simulator_get_info(simulator, &out.info, sizeof out.info), "info");
    out.n = 3 * out.info.n_nodes;
    out.q = malloc((size_t)out.n * sizeof *out.q);
    if (!out.q) check(DQA_ERROR_MEMORY, "state");
    check(dqa_simulator_get_state(simulator, out.q, out.n, NULL, 0), "state");
    qsort(out.forward, (size_t)repeat, sizeof *out.forward, ascending);
    qsort(out.backward, (size_t)repeat, sizeof *out.backward, ascending);
    dqa_controller_free(controller);
    dqa_simulator_free(simulator);
    return out;
}

static void report(FILE* csv, const settings* s, const outcome* o, const outcome* reference, const char* method,
                   double tolerance, int repeat) {
    struct rusage usage;
    const double steps = (double)s->steps, peak = (getrusage(RUSAGE_SELF, &usage), (double)usage.ru_maxrss / 1024.0);
    double state = 0.0, largest = 0.0, gradient = 0.0;
    int64_t i;
    for (i = 0; reference && i < o->n; ++i) {
        state = fmax(state, fabs(o->q[i] - reference->q[i]));
        largest = fmax(largest, fabs(reference->q[i]));
    }
    if (reference) gradient = fabs(o->bar[0] / reference->bar[0] - 1.0), state /= largest;
    printf(
        "%-14s tolerance %.0e  %d threads  %lld cells: set-up %.0f ms (barycentre %.0f), forward %.1f ms [%.1f, %.1f], "
        "backward %.1f ms [%.1f, %.1f], %.1f Newton, %.0f linear, %.0f adjoint iterations a step, residual %.1e, "
        "state error %.1e, gradient error %.1e, peak %.0f MiB\n",
        method, tolerance, s->threads, (long long)o->info.n_active_cells, 1e3 * o->info.setup_seconds,
        1e3 * o->info.barycenter_seconds, o->forward[repeat / 2], o->forward[0], o->forward[repeat - 1],
        o->backward[repeat / 2], o->backward[0], o->backward[repeat - 1], (double)o->stats.newton_iterations / steps,
        (double)o->stats.linear_iterations / steps, (double)o->stats.adjoint_iterations / steps,
        o->stats.worst_residual, state, gradient, peak);
    if (!csv) return;
    fprintf(csv, "%s,%dx%dx%d,%lld,0.02,%s,euler,double,%g,%d,%.3f,%.4f,%.4f,%.2f,%.2f,%.2f,%.3e,%.3e,%.3e,%.1f\n",
            s->meshes[0] ? "meshes" : "shipped fish", s->grid[0], s->grid[1], s->grid[2],
            (long long)o->info.n_active_cells, method, tolerance, s->threads, 1e3 * o->info.setup_seconds,
            o->forward[repeat / 2], o->backward[repeat / 2], (double)o->stats.newton_iterations / steps,
            (double)o->stats.linear_iterations / steps, (double)o->stats.adjoint_iterations / steps,
            o->stats.worst_residual, state, gradient, peak);
}

static int usage(const char* why) {
    fprintf(stderr,
            "bench_step: %s\nusage: bench_step [--csv FILE] [--threads N] [--grid NXxNYxNZ] [--steps N] "
            "[--repeat N] [--quick] [--direct] [mesh mesh]\n",
            why);
    return 2;
}

int main(int argc, char** argv) {
    settings s = {{60, 16, 26}, 1, 10, 5, 0, NULL, {NULL, NULL}};
    dqa_shape_space_options o;
    dqa_shape_space* space;
    FILE* csv = NULL;
    outcome fast, reference;
    int k, n_meshes = 0;
    for (k = 1; k < argc; ++k) {
        const char *name = argv[k], *value = k + 1 < argc ? argv[k + 1] : "";
        if (!strcmp(name, "--quick"))
            s.grid[0] = 28, s.grid[1] = 10, s.grid[2] = 14, s.repeat = 3;
        else if (!strcmp(name, "--direct"))
            s.direct = 1;
        else if (!strcmp(name, "--csv"))
            s.csv = value, ++k;
        else if (!strcmp(name, "--threads"))
            s.threads = atoi(value), ++k;
        else if (!strcmp(name, "--steps"))
            s.steps = atoi(value), ++k;
        else if (!strcmp(name, "--repeat"))
            s.repeat = atoi(value), ++k;
        else if (!strcmp(name, "--grid")) {
            if (sscanf(value, "%dx%dx%d", &s.grid[0], &s.grid[1], &s.grid[2]) != 3)
                return usage("--grid takes NXxNYxNZ");
            ++k;
        } else if (name[0] == '-')
            return usage("unknown option");
        else if (n_meshes < 2)
            s.meshes[n_meshes++] = name;
        else
            return usage("two meshes at most");
    }
    if (n_meshes == 1) return usage("two meshes or none");
    if (s.steps < 1 || s.repeat < 1 || s.repeat > MOST_REPEATS) return usage("--steps and --repeat must be in [1, 64]");
    check(dqa_shape_space_options_init(&o, sizeof o), "options");
    o.cells_x = s.grid[0], o.cells_y = s.grid[1], o.cells_z = s.grid[2];
    check(dqa_shape_space_create(&o, &space), "space");
    for (k = 0; k < 2; ++k) {
        const char* shipped = k ? DQA_SHAPES_DIR "/tuna.stl" : DQA_SHAPES_DIR "/clownfish.stl";
        check(dqa_shape_space_add_mesh_file(space, s.meshes[k] ? s.meshes[k] : shipped, NULL), "mesh");
    }
    check(dqa_shape_space_build(space, NULL, NULL), "build");
    if (s.csv) {
        csv = fopen(s.csv, "w");
        if (!csv) return usage("cannot write the CSV file");
        fprintf(
            csv,
            "scene,grid,active_cells,threshold,method,integrator,precision,tolerance,threads,setup_ms,forward_ms,"
            "backward_ms,newton_iterations,linear_iterations,adjoint_iterations,residual,state_error,gradient_error,"
            "peak_mib\n");
    }
    fast = run(space, &s, DQA_METHOD_NEWTON_PCG, 1e-6, 1e-8, s.repeat); /* before the direct solver raises the peak */
    report(NULL, &s, &fast, NULL, "newton_pcg", 1e-6, s.repeat);
    if (s.direct) {
        reference = run(space, &s, DQA_METHOD_NEWTON_DIRECT, 1e-12, 1e-12, 1);
        report(csv, &s, &fast, &reference, "newton_pcg", 1e-6, s.repeat);
        report(csv, &s, &reference, &reference, "newton_direct", 1e-12, 1);
        free(reference.q);
    } else if (csv) {
        report(csv, &s, &fast, NULL, "newton_pcg", 1e-6, s.repeat);
    }
    if (csv && fclose(csv) != 0) return usage("cannot write the CSV file");
    free(fast.q);
    dqa_shape_space_free(space);
    return 0;
}
