/* SPDX-License-Identifier: MIT
 * What drives a swimmer and what pushes it, step by step; and which muscles lie beneath its surface. */
#ifndef DQA_EXAMPLES_ACTIVITY_H
#define DQA_EXAMPLES_ACTIVITY_H

#include <stdint.h>

#include "progress.h"
#include "scene.h"

typedef struct activity {
    int64_t n_steps;
    int32_t n_signals;
    double* signals; /* [n_steps][n_signals], in [-1, 1] */
    double* forces;  /* [n_steps][6]: drag along x, y, z and thrust along x, y, z, N on the swimmer */
    double* current; /* [n_steps][3], m/s of the water */
    /* The muscles beneath vertex i are entries first[i] to first[i + 1] of signal and pull: a signal u contracts the
     * body there by pull u, 1 being the strongest muscle beneath the surface; an antagonist has pull < 0. */
    int64_t n_vertices;
    int32_t* first;  /* [n_vertices + 1] */
    int32_t* signal; /* [first[n_vertices]] */
    double* pull;
    /* While it records. */
    dqa_simulator* simulator;
    progress* watched;
} activity;

/* Room for the swim of `s`; then scene_swim_watched with activity_watch and the activity records the forces. */
int activity_begin(activity* a, const scene* s, progress* p);
int32_t activity_watch(int64_t done, int64_t total, void* user_data);
/* After the swim: signals and current from the tape, and the muscles beneath the vertices [n][3] of the surface at
 * rest. DONE or FAILED (said). */
int activity_end(activity* a, scene* s, const double* vertices, int64_t n);
void activity_free(activity* a);

#endif
