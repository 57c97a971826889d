/* SPDX-License-Identifier: MIT
 * Descents on weighted sums of two losses, and all designs that they come by: the gamut. */
#ifndef DQA_EXAMPLES_GAMUT_H
#define DQA_EXAMPLES_GAMUT_H

#include "leg.h"

#define GAMUT_MAX_LEGS 32

/* The legs of one method, in the order in which they are made: each a descent on w first + (1 - w) second loss, with
 * its w, each loss divided by the size of its initial value. */
typedef struct gamut {
    const char* name;
    const options* o; /* whose objective has two terms */
    scene* s;
    progress* p;
    const double* start;   /* [unknowns]: the first design */
    const double* initial; /* [2]: its losses */
    leg legs[GAMUT_MAX_LEGS];
    int n_legs;
} gamut;

/* Makes one more leg from the design x: in the folder out/name_K, at its beginning or, with --resume, where it was
 * left. `before`: what the progress counts of other legs. DONE, USAGE, FAILED (said) or INTERRUPTED. */
int gamut_descend(gamut* g, double w, const double* x, int64_t iterations, int64_t before);
void gamut_free(gamut* g);

/* Simulations of all legs. */
int64_t gamut_simulations(const gamut* g);
/* Designs of all legs, in order. */
int64_t gamut_size(const gamut* g);
/* Design i: its leg and its row there; losses [2] divided by the sizes of the initial ones. */
void gamut_place(const gamut* g, int64_t i, int* leg, int64_t* row);
void gamut_point(const gamut* g, int64_t i, double* losses);
const double* gamut_design(const gamut* g, int64_t i);

/* The sweep of the paper: n_weights weights from 0 to 1, each from the first design. */
int gamut_sweep(gamut* g, int n_weights, int64_t iterations, int64_t before);
/* Bisects the front: a descent on the plain mean, one on each loss alone, then one for the widest gap of the front each
 * time, under the weight whose sum is equal at both of its ends (Cohon 1978, "noninferior set estimation"). Every one
 * but the first starts from the design seen so far that is best under its weight. gamut_bisect_budget is the number of
 * its simulations. */
int gamut_bisect(gamut* g, int n_gaps, int64_t iterations, int64_t before);
int64_t gamut_bisect_budget(int n_gaps, int64_t iterations);

#endif
