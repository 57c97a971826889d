/* SPDX-License-Identifier: MIT
 * An experiment of the paper: several optimisations in one scene, side by side, and what they have to show. A program
 * states its settings, its claims and the curves of its picture; everything else is here. */
#ifndef DQA_EXAMPLES_EXPERIMENT_H
#define DQA_EXAMPLES_EXPERIMENT_H

#include <stdio.h>

#include "findings.h"
#include "json.h"
#include "motion.h"
#include "options.h"
#include "progress.h"
#include "scene.h"
#include "trial.h"

#define EXPERIMENT_MAX_TRIALS 16
#define EXPERIMENT_MAX_CLAIMS 16

struct experiment_plan;

typedef struct experiment {
    const struct experiment_plan* plan;
    char* command; /* the line that started it */
    options o;
    scene s;
    progress p;
    const trial_plan* asked[EXPERIMENT_MAX_TRIALS]; /* those of the plan that --only names, or all */
    int n_asked;
    trial stage;        /* of the plan, before the trials */
    options stage_o;    /* of the stage; borrows from o */
    int has_stage;      /* it is open */
    double measured[2]; /* by plan->before, for plan->tell: what the program makes of them */
    trial trials[EXPERIMENT_MAX_TRIALS];
    int n_trials; /* that are open */
    int shown;    /* trial whose swimmers are shown */
    finding claims[EXPERIMENT_MAX_CLAIMS];
    int n_claims;
} experiment;

typedef struct experiment_plan {
    const options_form* form;
    const trial_plan* trials;
    int n_trials;
    double theta[3];     /* a, omega (rad/s), phi (rad) at the start */
    const char* picture; /* its file */
    const char* script;
    int shown; /* trial whose first and best swimmers the picture and the report show, or the first that runs */
    const char *first_label, *best_label;
    const char* crowd; /* what the curves of all trials but the first are called where they are many */
    /* An optimisation in still water before the trials, which begin with its best network; NULL: none. stage_options
     * turns the options of the experiment into its own, and stage_task the loss in the scene. */
    const trial_plan* stage;
    void (*stage_options)(options* o);
    void (*stage_task)(scene* s);
    /* What comes before the trials, in the finished scene and after the stage; NULL: nothing. DONE, FAILED (said) or
     * INTERRUPTED. */
    int (*before)(experiment* e);
    /* Adds to summary.json what the program found before the trials; NULL: nothing. */
    void (*tell)(const experiment* e, json* j);
    /* Appends the claims of the finished trials. */
    void (*claim)(experiment* e);
    /* Writes the curves of the picture: gnuplot commands after plot_head. */
    void (*curves)(const experiment* e, FILE* f);
} experiment_plan;

/* The whole program. Returns its exit code; claims that do not hold are reported, and are no failure. */
int experiment_main(const experiment_plan* plan, int argc, char** argv);

void experiment_claim_add(experiment* e, const char* name, const char* says, double value, double bound,
                          finding_kind kind);
/* Column (from 1) of a number in the tables: that of the weight of base i, and of what stands so many columns after
 * the unknowns. */
int experiment_column_weight(const experiment* e, int i);
int experiment_column_after(const experiment* e, int k);
#define EXPERIMENT_CPU_SECONDS 3 /* for experiment_column_after */
#define EXPERIMENT_SIMULATIONS 8
/* Writes a plot of column y against column x of all trials, of the lowest y so far if `lowest`. */
void experiment_curves(const experiment* e, FILE* f, const char* x, int y, int lowest);
/* Writes a plot of the share of every base over the iterations of the shown trial. */
void experiment_shares(const experiment* e, FILE* f);
/* Writes a plot of the signals of the best swimmer over time: the tail's, and thinly those of the fins. */
void experiment_signals(const experiment* e, FILE* f);
/* The whole picture. *drawn is 0 when gnuplot is missing. DONE, FAILED (said) or INTERRUPTED. */
int experiment_draw(const experiment* e, const motion* first, const motion* best, int* drawn);

/* summary.json. DONE or FAILED (said). */
int experiment_summary(const experiment* e);

#endif
