/* SPDX-License-Identifier: MIT
 * CMA-ES over the unknowns x = (weights, controller). It searches all of space: a candidate is evaluated at the nearest
 * x with weights on the simplex and a controller within its bounds, and told the loss there plus the squared distance,
 * in the units of the unknowns, as section B.5 of Hansen's tutorial (arXiv 1604.00772) has it. */
#include "evolution.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "output.h"
#include "say.h"

#define PENALTY 1.0 /* m: of a distance of one unit; losses differ by a tenth of it */
#define CALM_SPREAD 1e-6

static void state_name(int64_t generation, char* name, size_t size) {
    (void)snprintf(name, size, "cma-es-%" PRId64 ".dqa", generation);
}

static char* state_path(const descent* d, int64_t generation) {
    char name[64];
    state_name(generation, name, sizeof name);
    return output_path(d->out, name);
}

int evolution_open(const descent* d, dqa_cma_es** search) {
    const run* r = d->r;
    int outcome = DONE;
    if (r->iteration > 0) {
        char* path = state_path(d, r->iteration);
        if (path == NULL) return FAILED;
        outcome = say_status(dqa_cma_es_load(path, search), "continue the search");
        free(path);
    } else {
        /* What Adam moves in equal steps counts as equally far here. */
        outcome = say_status(dqa_cma_es_create(NULL, r->x, r->units, r->n, search), "create the search");
    }
    return outcome;
}

int evolution_converged(const dqa_cma_es* search) {
    dqa_cma_es_info info;
    return dqa_cma_es_get_info(search, &info, sizeof info) == DQA_SUCCESS && info.widest < CALM_SPREAD;
}

/* Evaluates candidate x [n], which becomes the one that was evaluated; *value is what the search is told. */
static int evaluate(const descent* d, double* x, history_row* row, double* value) {
    const run* r = d->r;
    double* asked = malloc((size_t)r->n * sizeof *asked);
    int outcome = asked != NULL ? DONE : say_no_memory();
    if (outcome == DONE) {
        memcpy(asked, x, (size_t)r->n * sizeof *asked);
        outcome = run_project(r, x);
    }
    if (outcome == DONE) outcome = scene_try(d->s, x, row, d->p);
    if (outcome == DONE) {
        *value = row->loss;
        for (int64_t i = 0; i < r->n; ++i) {
            const double distance = (asked[i] - x[i]) / r->units[i];
            *value += PENALTY * distance * distance;
        }
    }
    free(asked);
    return outcome;
}

/* All candidates x [population][n]; the row is that of the lowest loss, whose design becomes r->x. */
static int evaluate_all(const descent* d, double* x, double* values, int64_t population, history_row* row) {
    run* r = d->r;
    const double started = progress_clock();
    int64_t newton = 0, linear = 0;
    for (int64_t k = 0; k < population; ++k) {
        history_row one;
        const int outcome = evaluate(d, x + k * r->n, &one, &values[k]);
        if (outcome != DONE) return outcome;
        newton += one.newton_iterations;
        linear += one.linear_iterations;
        if (k == 0 || one.loss < row->loss) {
            *row = one;
            memcpy(r->x, x + k * r->n, (size_t)r->n * sizeof(double));
        }
        d->p->iteration = d->before + r->iteration * population + k + 1;
    }
    row->newton_iterations = newton;
    row->linear_iterations = linear;
    row->seconds = progress_clock() - started;
    return DONE;
}

static int save_state(const descent* d, const dqa_cma_es* search) {
    char* path = state_path(d, d->r->iteration);
    int outcome;
    if (path == NULL) return FAILED;
    outcome = say_status(dqa_cma_es_save(search, path), "save the search");
    free(path);
    return outcome;
}

int evolution_generation(const descent* d, dqa_cma_es* search) {
    run* r = d->r;
    dqa_cma_es_info info;
    history_row row = {0};
    double *x = NULL, *values = NULL;
    int outcome = say_status(dqa_cma_es_get_info(search, &info, sizeof info), "read the search");
    if (outcome != DONE) return outcome;
    x = malloc((size_t)(info.population * r->n) * sizeof *x);
    values = malloc((size_t)info.population * sizeof *values);
    if (x == NULL || values == NULL) outcome = say_no_memory();
    if (outcome == DONE) outcome = say_status(dqa_cma_es_ask(search, x, info.population * r->n), "ask for candidates");
    if (outcome == DONE) outcome = evaluate_all(d, x, values, info.population, &row);
    if (outcome == DONE) outcome = say_status(dqa_cma_es_tell(search, values, info.population), "tell their losses");
    free(x);
    free(values);
    if (outcome == DONE) {
        row.iteration = r->iteration + 1;
        row.simulations = row.iteration * info.population;
        row.cpu_seconds = r->cpu_before + progress_cpu();
        outcome = run_record(r, &row);
    }
    /* The checkpoint names the state by its generation: until it is written, the state before is the valid one. */
    if (outcome == DONE) outcome = save_state(d, search);
    if (outcome == DONE) outcome = descent_finish(d, &row, row.simulations);
    if (outcome == DONE) {
        char name[64];
        state_name(r->iteration - 1, name, sizeof name);
        output_remove(d->out, name);
    }
    return outcome;
}
