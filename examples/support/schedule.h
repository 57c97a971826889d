/* SPDX-License-Identifier: MIT
 * The schedule of an optimisation: coarse and loose first, fine and tight last. Weights of bases and parameters of a
 * controller mean the same on every grid, so each stage goes on where the one before ended. */
#ifndef DQA_EXAMPLES_SCHEDULE_H
#define DQA_EXAMPLES_SCHEDULE_H

#include <stdint.h>

#include "memory_text.h"

#define SCHEDULE_MAX_STAGES 8

typedef struct schedule_stage {
    double grid;      /* cells along an axis, relative to the grid asked for; 1 in the last stage */
    double tolerance; /* of a time step; those of the adjoint and of the shapes scale with it; 0: the library's */
    double share;     /* of the iterations, at most; the last stage has what the others leave */
} schedule_stage;

typedef struct schedule {
    int32_t n_stages; /* >= 1 */
    schedule_stage stages[SCHEDULE_MAX_STAGES];
} schedule;

/* Reads "none" (also NULL: one stage with the library's tolerances), "coarse" (half the grid, then all of it), or a
 * list "grid:tolerance[:share],..." whose last stage has grid 1. DONE or USAGE (said). */
int schedule_parse(schedule* s, const char* text);
/* A line of a checkpoint's settings. */
void schedule_add_settings(const schedule* s, memory_text* t);
/* Cells of stage k when the last one has `grid`; no axis gets fewer than 8. */
void schedule_grid(const schedule* s, int32_t k, const int32_t grid[3], int32_t cells[3]);
/* Iterations that stage k may take of `iterations`, when `before` are spent: at least one is kept for the last. */
int64_t schedule_budget(const schedule* s, int32_t k, int64_t iterations, int64_t before);

#endif
