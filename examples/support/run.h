/* SPDX-License-Identifier: MIT
 * The state of an optimisation: everything that a checkpoint has to hold, and the optimiser's step. */
#ifndef DQA_EXAMPLES_RUN_H
#define DQA_EXAMPLES_RUN_H

#include <stdint.h>

#include "diffaqua.h"
#include "options.h"

/* What one evaluation of the loss and its gradient tells. */
typedef struct history_row {
    int64_t iteration;                         /* counts from 1 */
    double loss;                               /* travel alone: m */
    double terms[OBJECTIVE_KINDS];             /* of the loss, without their weights */
    double place, heading;                     /* smoothed sums (m) that its term `keep` is made of: objective_keeps */
    double gradient_weights, gradient_control; /* 2-norms */
    double seconds;
    double cpu_seconds;  /* of all threads since the start of the run, interrupted sessions included */
    int32_t stage;       /* of the schedule, from 0: losses of different stages are not comparable */
    int64_t simulations; /* rollouts since the start of the run */
    int64_t newton_iterations, linear_iterations, adjoint_iterations;
} history_row;

/* What an iteration moves. */
#define RUN_BOTH 0    /* weights and controller */
#define RUN_WEIGHTS 1 /* the controller stays */
#define RUN_CONTROL 2 /* the weights stay */
#define RUN_IN_TURN 3 /* weights in odd iterations, the controller in even ones, each with an Adam of its own */

#define PROOF_OPEN 0   /* not made yet, or there is nothing to prove */
#define PROOF_MADE 1   /* the report tells */
#define PROOF_FAILED 2 /* the library could not make it */

/* The library's proof of a gradient. */
typedef struct gradient_proof {
    int state; /* PROOF_* */
    dqa_gradient_check_report report;
} gradient_proof;

typedef struct run {
    int64_t n_weights, n_control, n; /* the unknowns x = (weights, controller parameters), n = both */
    int moves;                       /* RUN_* */
    int mlp;                         /* the controller's parameters are those of a network, not (a, omega, phi) */
    const objective* loss;           /* whose terms the rows hold */
    double omega0;                   /* rad/s: natural frequency of the controller, the scale of its omega */
    double* x;                       /* [n]: the design of the next iteration */
    double* first_moment;            /* [n] of Adam */
    double* second_moment;           /* [n] */
    double* rates;                   /* [n] */
    double* units;                   /* [n]: what counts as one step of an unknown */
    double* gradient;                /* [n] of the last evaluation */
    double* best_x;                  /* [n]: the design of lowest loss so far in this stage */
    double best_loss;
    int64_t best_iteration; /* 0: none yet */
    int64_t iteration;      /* finished iterations */
    int32_t n_stages;       /* of the schedule */
    int32_t stage;          /* of them, from 0 */
    int64_t stage_first;    /* iterations finished when it began */
    double first_loss;      /* of the first design under the settings of the last stage */
    double seconds;         /* wall time spent so far, interrupted sessions included */
    double cpu_before;      /* of all threads, of earlier sessions */
    history_row* rows;      /* [iteration] */
    double* row_x;          /* [iteration][n]: the design evaluated in each */
    int64_t capacity;
    gradient_proof proof_weights, proof_control; /* at the first design of the last stage */
} run;

/* A run of the options' task at its start. `theta` [n_control] are the controller's initial parameters: (a, omega, phi)
 * per signal, or those of a network. `o` outlives the run. DONE or FAILED (said). */
int run_create(run* r, const options* o, int64_t n_weights, const double* theta, int64_t n_control, double omega0);
void run_free(run* r);
/* Room for one more row. DONE or FAILED. */
int run_reserve(run* r);
/* Records an evaluation of r->x and remembers the best. DONE or FAILED. */
int run_record(run* r, const history_row* row);
/* The nearest x [n] with weights on the simplex and a controller within its bounds. DONE or FAILED. */
int run_project(const run* r, double* x);
/* run_record, then moves r->x by one Adam step along `gradient` [n], and projects. */
int run_advance(run* r, const history_row* row, const double* gradient);
/* 1 when r->x is, to the bit, the design evaluated last, as at a vertex of the simplex: *row and r->gradient then are
 * its evaluation, which took no work. */
int run_repeats(const run* r, history_row* row);
/* 1 when neither loss nor design moved by more than 1e-6 for several iterations of this stage. */
int run_converged(const run* r);
/* 1 when the best loss of this stage has hardly improved for several iterations. */
int run_stalled(const run* r);
/* Goes on from the best design of this stage in the next one. */
void run_next_stage(run* r);

#endif
