/* SPDX-License-Identifier: MIT
 * Descents on weighted sums, with Adam as everywhere; each has a table and a checkpoint of its own. */
#include "gamut.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "front.h"
#include "say.h"

/* ------------------------------------------------------------------ a leg */
int gamut_descend(gamut* g, double w, const double* x, int64_t iterations, int64_t before) {
    leg* l = &g->legs[g->n_legs];
    char what[64];
    if (g->n_legs == GAMUT_MAX_LEGS) {
        say("more than %d descents", GAMUT_MAX_LEGS);
        return FAILED;
    }
    l->w = w;
    (void)snprintf(l->name, sizeof l->name, "%s_%d", g->name, g->n_legs);
    (void)snprintf(what, sizeof what, "weight %.17g", w);
    ++g->n_legs;
    g->s->terms[0].weight = w / fabs(g->initial[0]);
    g->s->terms[1].weight = (1.0 - w) / fabs(g->initial[1]);
    return leg_descend(l, g->o, g->s, g->p, what, x, NULL, iterations, before);
}

void gamut_free(gamut* g) {
    for (int k = 0; k < g->n_legs; ++k) leg_free(&g->legs[k]);
    g->n_legs = 0;
}

/* ------------------------------------------------------------------ its designs */
int64_t gamut_simulations(const gamut* g) {
    int64_t n = 0;
    for (int k = 0; k < g->n_legs; ++k) n += leg_simulations(&g->legs[k]);
    return n;
}

int64_t gamut_size(const gamut* g) {
    int64_t n = 0;
    for (int k = 0; k < g->n_legs; ++k) n += g->legs[k].r.iteration;
    return n;
}

void gamut_place(const gamut* g, int64_t i, int* of, int64_t* row) {
    int k = 0;
    while (i >= g->legs[k].r.iteration) i -= g->legs[k++].r.iteration;
    *of = k;
    *row = i;
}

void gamut_point(const gamut* g, int64_t i, double* losses) {
    int64_t row = 0;
    int of = 0;
    gamut_place(g, i, &of, &row);
    for (int k = 0; k < 2; ++k) losses[k] = g->legs[of].r.rows[row].terms[k] / fabs(g->initial[k]);
}

const double* gamut_design(const gamut* g, int64_t i) {
    int64_t row = 0;
    int of = 0;
    gamut_place(g, i, &of, &row);
    return g->legs[of].r.row_x + row * g->legs[of].r.n;
}

/* ------------------------------------------------------------------ methods */
int gamut_sweep(gamut* g, int n_weights, int64_t iterations, int64_t before) {
    int outcome = DONE;
    for (int k = 0; k < n_weights && outcome == DONE; ++k)
        outcome = gamut_descend(g, (double)k / (double)(n_weights - 1), g->start, iterations, before + k * iterations);
    return outcome;
}

/* The design seen so far whose weighted sum is least. */
static const double* best_under(const gamut* g, double w) {
    const double* best = g->start;
    double least = HUGE_VAL;
    for (int64_t i = 0; i < gamut_size(g); ++i) {
        double f[2];
        gamut_point(g, i, f);
        if (w * f[0] + (1.0 - w) * f[1] < least) {
            least = w * f[0] + (1.0 - w) * f[1];
            best = gamut_design(g, i);
        }
    }
    return best;
}

/* A gap of the front, by the designs at its ends. */
typedef struct gap {
    int64_t a, b;
} gap;

static int is_tried(const gap* tried, int n, int64_t a, int64_t b) {
    for (int k = 0; k < n; ++k)
        if (tried[k].a == a && tried[k].b == b) return 1;
    return 0;
}

/* The weight for the widest gap that was not tried yet, which becomes tried[n]; 1/2 where there is none. Widths are
 * relative to the extents of the front. */
static int widest_gap(const gamut* g, gap* tried, int n, double* w) {
    const int64_t size = gamut_size(g);
    double* points = malloc((size_t)size * 2 * sizeof *points);
    int64_t* chain = malloc((size_t)size * sizeof *chain);
    int64_t length = 0;
    double widest = 0.0;
    int outcome = points != NULL && chain != NULL ? DONE : say_no_memory();
    for (int64_t i = 0; i < size && outcome == DONE; ++i) gamut_point(g, i, points + 2 * i);
    if (outcome == DONE) outcome = front_chain(points, size, chain, &length);
    *w = 0.5;
    tried[n] = (gap){-1, -1};
    for (int64_t k = 0; k + 1 < length && outcome == DONE; ++k) {
        const double *a = points + 2 * chain[k], *b = points + 2 * chain[k + 1];
        const double *first = points + 2 * chain[0], *last = points + 2 * chain[length - 1];
        const double d0 = b[0] - a[0], d1 = a[1] - b[1];
        const double width = hypot(d0 / (last[0] - first[0]), d1 / (first[1] - last[1]));
        if (width > widest && !is_tried(tried, n, chain[k], chain[k + 1])) {
            widest = width;
            *w = d1 / (d0 + d1);
            tried[n] = (gap){chain[k], chain[k + 1]};
        }
    }
    free(points);
    free(chain);
    return outcome;
}

/* Shares of the iterations that a descent of the sweep has: the climb that all have in common is made once. */
static int64_t share(int64_t iterations, double of) {
    const int64_t n = (int64_t)((double)iterations * of);
    return n > 0 ? n : 1;
}
#define MIDDLE 0.5
#define END 0.75
#define GAP 0.4

int64_t gamut_bisect_budget(int n_gaps, int64_t iterations) {
    return share(iterations, MIDDLE) + 2 * share(iterations, END) + n_gaps * share(iterations, GAP);
}

int gamut_bisect(gamut* g, int n_gaps, int64_t iterations, int64_t before) {
    gap tried[GAMUT_MAX_LEGS];
    int64_t made = share(iterations, MIDDLE);
    int outcome = gamut_descend(g, 0.5, g->start, made, before);
    for (int end = 1; end >= 0 && outcome == DONE; --end, made += share(iterations, END))
        outcome = gamut_descend(g, end, best_under(g, end), share(iterations, END), before + made);
    for (int k = 0; k < n_gaps && outcome == DONE; ++k, made += share(iterations, GAP)) {
        double w = 0.5;
        outcome = widest_gap(g, tried, k, &w);
        if (outcome == DONE) outcome = gamut_descend(g, w, best_under(g, w), share(iterations, GAP), before + made);
    }
    return outcome;
}
