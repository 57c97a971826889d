/* SPDX-License-Identifier: MIT
 * A progress bar on a terminal, or a line per iteration elsewhere, with an estimate of the time left. */
#ifndef DQA_EXAMPLES_PROGRESS_H
#define DQA_EXAMPLES_PROGRESS_H

#include <stdint.h>

/* What the time goes into; the bar learns how long each takes. */
#define PROGRESS_SPACE 0    /* the shape space */
#define PROGRESS_PROOF 1    /* the check of the gradients */
#define PROGRESS_SETUP 2    /* a new design */
#define PROGRESS_FORWARD 3  /* a rollout */
#define PROGRESS_BACKWARD 4 /* its adjoint */
#define PROGRESS_OUTPUT 5   /* files and picture */
#define PROGRESS_STAGES 6

typedef struct progress {
    int terminal;          /* stderr is one */
    int64_t iterations;    /* planned */
    int64_t iteration;     /* finished */
    int32_t part, parts;   /* of the schedule: the running one (from 1) of how many */
    const char* part_name; /* instead of its number; NULL: none */
    int64_t part_end;      /* iterations finished when the running part ends */
    double cost;           /* of a later iteration, relative to one of this part */
    int64_t extra;         /* rollouts still to come after the last iteration, for the frames */
    int stage;
    double loss, best; /* m; only meaningful when iteration > 0 */
    double started;    /* s: of the whole run */
    double stage_started;
    double fraction;                 /* of the running stage */
    double drawn;                    /* s: when the bar was last drawn */
    double seconds[PROGRESS_STAGES]; /* what a stage took, < 0: not known yet */
} progress;

/* Seconds of a clock that only goes forward. */
double progress_clock(void);
/* CPU seconds of this process, all threads. */
double progress_cpu(void);
void progress_begin(progress* p, int64_t iterations, int64_t extra);
/* Part `part` (from 1) of a schedule begins and lasts until `end` iterations are finished; those after it take about
 * `cost` times as long. */
void progress_part(progress* p, int32_t part, int32_t parts, int64_t end, double cost);
/* A stage begins or the running one ends (which teaches how long it took). */
void progress_stage(progress* p, int stage);
void progress_stage_done(progress* p);
/* An iteration has ended, `finished` of them now. */
void progress_iteration(progress* p, int64_t finished, double loss, double best, double seconds);
/* The same of a shape that only was interpolated. */
void progress_shape(progress* p, int64_t finished, double seconds);
/* Takes the bar off the terminal. */
void progress_end(progress* p);
/* A dqa_progress: `user_data` is the progress; cancels after a signal. */
int32_t progress_callback(int64_t done, int64_t total, void* user_data);

#endif
