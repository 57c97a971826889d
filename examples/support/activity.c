/* SPDX-License-Identifier: MIT
 * Muscles lie in cells, the surface between them: a vertex gets the muscles of the cells around it, weighted by
 * distance and by stiffness, as one signed pull per signal. */
#include "activity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "say.h"

#define REACH 0.75 /* standard deviation of the weights, in cells */
#define LEAST 0.02 /* pulls below this share of the strongest are left out */

int activity_begin(activity* a, const scene* s, progress* p) {
    dqa_shape_space_info info;
    int outcome = say_status(dqa_shape_space_get_info(s->space, &info, sizeof info), "read the shape space");
    memset(a, 0, sizeof *a);
    if (outcome != DONE) return outcome;
    a->n_steps = s->steps;
    a->n_signals = info.n_signals;
    a->simulator = s->simulator;
    a->watched = p;
    a->signals = calloc((size_t)(a->n_steps * (a->n_signals > 0 ? a->n_signals : 1)), sizeof *a->signals);
    a->forces = calloc((size_t)a->n_steps * 6, sizeof *a->forces);
    a->current = calloc((size_t)a->n_steps * 3, sizeof *a->current);
    return a->signals != NULL && a->forces != NULL && a->current != NULL ? DONE : say_no_memory();
}

void activity_free(activity* a) {
    free(a->signals);
    free(a->forces);
    free(a->current);
    free(a->first);
    free(a->signal);
    free(a->pull);
    memset(a, 0, sizeof *a);
}

int32_t activity_watch(int64_t done, int64_t total, void* user_data) {
    activity* a = user_data;
    double forces[12];
    /* It can only fail for wrong arguments; a zero row then stays. */
    if (done >= 1 && done <= a->n_steps && dqa_simulator_forces(a->simulator, forces, 12) == DQA_SUCCESS)
        memcpy(a->forces + 6 * (done - 1), forces, 6 * sizeof *forces);
    return progress_callback(done, total, a->watched);
}

/* ------------------------------------------------------------------ muscles by cell */
/* The simulated cells on their lattice, and the muscles of each. */
typedef struct fibres {
    int64_t n_cells, n_muscles;
    double origin[3], size; /* m: lowest corner of the lattice, edge of a cell */
    int64_t extent[3];      /* cells of the lattice that the simulated ones span */
    int64_t* at;            /* [n_cells][3]: place on the lattice */
    int32_t* cell_of;       /* [extent]: index of the cell there, -1: none */
    int32_t *first, *order; /* muscles of cell c: order[first[c]] ... */
    int32_t *cells, *signals, *signs;
    double* stiffness;
} fibres;

static void fibres_free(fibres* f) {
    free(f->at);
    free(f->cell_of);
    free(f->first);
    free(f->order);
    free(f->cells);
    free(f->signals);
    free(f->signs);
    free(f->stiffness);
}

/* Lowest corner of every cell at rest, from the start of the tape. */
static int read_cells(fibres* f, scene* s, const dqa_simulator_info* info) {
    const int64_t n = info->n_active_cells;
    int32_t* nodes = malloc((size_t)n * 8 * sizeof *nodes);
    double* q = malloc((size_t)info->n_nodes * 3 * sizeof *q);
    int outcome = nodes != NULL && q != NULL && f->at != NULL ? DONE : say_no_memory();
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_mesh(s->simulator, nodes, 8 * n, NULL, 0, NULL, 0), "read the cells");
    if (outcome == DONE)
        outcome = say_status(dqa_tape_get_state(s->tape, 0, q, 3 * info->n_nodes, NULL, 0), "read the first state");
    for (int axis = 0; axis < 3 && outcome == DONE; ++axis) {
        double least = HUGE_VAL;
        for (int64_t c = 0; c < n; ++c) least = fmin(least, q[3 * nodes[8 * c] + axis]);
        f->origin[axis] = least;
        f->extent[axis] = 0;
        for (int64_t c = 0; c < n; ++c) {
            const int64_t place = (int64_t)floor((q[3 * nodes[8 * c] + axis] - least) / f->size + 0.5);
            f->at[3 * c + axis] = place;
            if (place >= f->extent[axis]) f->extent[axis] = place + 1;
        }
    }
    free(nodes);
    free(q);
    return outcome;
}

static int64_t lattice_index(const fibres* f, const int64_t at[3]) {
    return (at[0] * f->extent[1] + at[1]) * f->extent[2] + at[2];
}

static int index_cells(fibres* f) {
    const int64_t total = f->extent[0] * f->extent[1] * f->extent[2];
    f->cell_of = malloc((size_t)total * sizeof *f->cell_of);
    if (f->cell_of == NULL) return say_no_memory();
    for (int64_t i = 0; i < total; ++i) f->cell_of[i] = -1;
    for (int64_t c = 0; c < f->n_cells; ++c) f->cell_of[lattice_index(f, f->at + 3 * c)] = (int32_t)c;
    return DONE;
}

static int read_muscles(fibres* f, const scene* s) {
    const size_t n = (size_t)(f->n_muscles > 0 ? f->n_muscles : 1);
    int outcome;
    f->cells = malloc(n * sizeof *f->cells);
    f->signals = malloc(n * sizeof *f->signals);
    f->signs = malloc(n * sizeof *f->signs);
    f->stiffness = malloc(n * sizeof *f->stiffness);
    f->order = malloc(n * sizeof *f->order);
    f->first = calloc((size_t)f->n_cells + 1, sizeof *f->first);
    if (f->cells == NULL || f->signals == NULL || f->signs == NULL || f->stiffness == NULL || f->order == NULL ||
        f->first == NULL)
        return say_no_memory();
    outcome = say_status(dqa_simulator_muscles(s->simulator, f->cells, f->signals, f->signs, f->n_muscles, NULL, 0,
                                               f->stiffness, f->n_muscles, NULL),
                         "read the muscles");
    if (outcome != DONE) return outcome;
    for (int64_t m = 0; m < f->n_muscles; ++m) ++f->first[f->cells[m] + 1];
    for (int64_t c = 0; c < f->n_cells; ++c) f->first[c + 1] += f->first[c];
    /* Filled from the back, which leaves `first` at the start of each cell. */
    for (int64_t m = f->n_muscles - 1; m >= 0; --m) f->order[--f->first[f->cells[m] + 1]] = (int32_t)m;
    memmove(f->first, f->first + 1, (size_t)f->n_cells * sizeof *f->first);
    f->first[f->n_cells] = (int32_t)f->n_muscles;
    return DONE;
}

static int fibres_read(fibres* f, scene* s) {
    dqa_simulator_info info;
    int outcome = say_status(dqa_simulator_get_info(s->simulator, &info, sizeof info), "read the simulator");
    memset(f, 0, sizeof *f);
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_muscles(s->simulator, NULL, NULL, NULL, 0, NULL, 0, NULL, 0, &f->n_muscles),
                             "count the muscles");
    if (outcome != DONE) return outcome;
    f->n_cells = info.n_active_cells;
    f->size = info.cell_size;
    f->at = malloc((size_t)f->n_cells * 3 * sizeof *f->at);
    outcome = read_cells(f, s, &info);
    if (outcome == DONE) outcome = index_cells(f);
    return outcome == DONE ? read_muscles(f, s) : outcome;
}

/* ------------------------------------------------------------------ pulls by vertex */
/* Adds up the pull of every signal at a point, pull [n_signals]. */
static void pulls_at(const fibres* f, const double* x, double* pull, int32_t n_signals) {
    int64_t middle[3], at[3];
    double weights = 0.0;
    memset(pull, 0, (size_t)n_signals * sizeof *pull);
    for (int axis = 0; axis < 3; ++axis) middle[axis] = (int64_t)floor((x[axis] - f->origin[axis]) / f->size);
    for (int k = 0; k < 27; ++k) {
        double square = 0.0, weight;
        int32_t cell;
        int inside = 1;
        at[0] = middle[0] + k / 9 - 1;
        at[1] = middle[1] + k / 3 % 3 - 1;
        at[2] = middle[2] + k % 3 - 1;
        for (int axis = 0; axis < 3; ++axis) {
            const double d = (x[axis] - f->origin[axis]) / f->size - (double)at[axis] - 0.5;
            square += d * d;
            inside = inside && at[axis] >= 0 && at[axis] < f->extent[axis];
        }
        cell = inside ? f->cell_of[lattice_index(f, at)] : -1;
        if (cell < 0) continue;
        weight = exp(-0.5 * square / (REACH * REACH));
        weights += weight;
        for (int32_t i = f->first[cell]; i < f->first[cell + 1]; ++i) {
            const int32_t m = f->order[i];
            pull[f->signals[m]] += weight * f->signs[m] * f->stiffness[m];
        }
    }
    for (int32_t k = 0; k < n_signals && weights > 0.0; ++k) pull[k] /= weights;
}

static int find_pulls(activity* a, const fibres* f, const double* vertices) {
    const int64_t n = a->n_vertices, width = a->n_signals > 0 ? a->n_signals : 1;
    double* all = malloc((size_t)(n * width) * sizeof *all);
    double strongest = 0.0;
    int64_t count = 0;
    int outcome = DONE;
    if (all == NULL) return say_no_memory();
    for (int64_t i = 0; i < n; ++i) pulls_at(f, vertices + 3 * i, all + i * width, a->n_signals);
    for (int64_t i = 0; i < n * a->n_signals; ++i) strongest = fmax(strongest, fabs(all[i]));
    for (int64_t i = 0; i < n * a->n_signals; ++i) count += fabs(all[i]) > LEAST * strongest;
    a->first = malloc((size_t)(n + 1) * sizeof *a->first);
    a->signal = malloc((size_t)(count + 1) * sizeof *a->signal);
    a->pull = malloc((size_t)(count + 1) * sizeof *a->pull);
    if (a->first == NULL || a->signal == NULL || a->pull == NULL) outcome = say_no_memory();
    count = 0;
    for (int64_t i = 0; i < n && outcome == DONE; ++i) {
        a->first[i] = (int32_t)count;
        for (int32_t k = 0; k < a->n_signals; ++k) {
            if (!(fabs(all[i * width + k]) > LEAST * strongest)) continue;
            a->signal[count] = k;
            a->pull[count++] = all[i * width + k] / strongest;
        }
    }
    if (outcome == DONE) a->first[n] = (int32_t)count;
    free(all);
    return outcome;
}

int activity_end(activity* a, scene* s, const double* vertices, int64_t n) {
    fibres f;
    int outcome = DONE;
    for (int64_t k = 0; k < a->n_steps && outcome == DONE; ++k) {
        outcome = say_status(dqa_tape_get_current(s->tape, k, a->current + 3 * k, 3), "read the water's current");
        if (outcome == DONE && a->n_signals > 0)
            outcome = say_status(dqa_tape_get_actuation(s->tape, k, a->signals + k * a->n_signals, a->n_signals),
                                 "read the signals of a step");
    }
    if (outcome != DONE) return outcome;
    a->n_vertices = n;
    outcome = fibres_read(&f, s);
    if (outcome == DONE) outcome = find_pulls(a, &f, vertices);
    fibres_free(&f);
    return outcome;
}
