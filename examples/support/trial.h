/* SPDX-License-Identifier: MIT
 * One optimisation of an experiment: what it moves, by which method, from where. Several run in one scene; each has a
 * folder of its own with its table and its checkpoint. */
#ifndef DQA_EXAMPLES_TRIAL_H
#define DQA_EXAMPLES_TRIAL_H

#include "descent.h"

typedef struct trial_plan {
    const char* name;      /* of its folder, and in tables */
    const char* label;     /* in pictures */
    int moves;             /* RUN_* */
    int cma_es;            /* all unknowns by CMA-ES, without gradients */
    int64_t times;         /* as many iterations as the command line says, times this; 0 counts as 1 */
    const double* weights; /* first design [bases]; NULL: that of the command line */
    int no_encoding;       /* the network has no temporal encoding among its inputs */
    double network_rate;   /* of Adam for a network's parameters; 0: that of the form */
} trial_plan;

typedef struct trial {
    const trial_plan* plan;
    options o; /* with the first design of this trial; borrows from those of the experiment */
    char *folder, *settings;
    run r;
    int has_run; /* r is set up */
    dqa_cma_es* search;
    int converged;
} trial;

/* 1 when the folder of the plan holds a checkpoint. */
int trial_exists(const trial_plan* plan, const char* out);
/* What progress counts of it at most: simulations. */
int64_t trial_units(const trial_plan* plan, const options* o, int64_t population);
/* Sets the trial up with its folder, at its beginning or, with --resume, where its checkpoint left it. theta [3]: a,
 * omega, phi of every signal at the start; a network starts with the parameters `network` [n_control], or where they
 * are NULL with those that the library gives it. DONE, USAGE or FAILED (said). */
int trial_open(trial* t, const trial_plan* plan, const options* o, scene* s, const double* theta,
               const double* network);
/* Gives the scene the controller of the trial. */
int trial_enter(const trial* t, scene* s);
/* Optimises; `before`: units of other trials that progress counts. `proves`: the gradient first. DONE, FAILED (said) or
 * INTERRUPTED. */
int trial_run(trial* t, scene* s, progress* p, int64_t before, int proves);
void trial_free(trial* t);
/* The lowest loss within the first n simulations; infinite where there is none. */
double trial_best_within(const trial* t, int64_t n);
int64_t trial_simulations(const trial* t);

#endif
