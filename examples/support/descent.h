/* SPDX-License-Identifier: MIT
 * Going down the gradient: what an optimisation does in an iteration, and the proof that comes before it. */
#ifndef DQA_EXAMPLES_DESCENT_H
#define DQA_EXAMPLES_DESCENT_H

#include "progress.h"
#include "run.h"
#include "scene.h"

/* An optimisation in its scene, with the folder of its table and checkpoint. */
typedef struct descent {
    run* r;
    scene* s;
    progress* p;
    const char* settings; /* that the checkpoint belongs to */
    const char* out;
    int64_t before; /* what the progress counts of other runs */
} descent;

/* Proves the gradients of r->x by the weights and by the controller, as far as they were not proven yet. DONE, FAILED
 * (said) or INTERRUPTED. */
int descent_prove(const descent* d);
/* Evaluates r->x, moves it, and writes table and checkpoint. DONE, FAILED (said) or INTERRUPTED. */
int descent_iterate(const descent* d);
/* What follows a finished iteration of any method: the time it took, table, checkpoint, and progress, which counts
 * `units` of this run now. DONE or FAILED. */
int descent_finish(const descent* d, const history_row* row, int64_t units);

#endif
