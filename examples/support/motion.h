/* SPDX-License-Identifier: MIT
 * The surface of a swimmer over time, and what moves it. */
#ifndef DQA_EXAMPLES_MOTION_H
#define DQA_EXAMPLES_MOTION_H

#include <stdint.h>

#include "activity.h"
#include "progress.h"
#include "scene.h"

typedef struct motion {
    int64_t n_vertices, n_triangles;
    int64_t n_frames;   /* steps + 1: frame k is the state after k steps */
    double time_step;   /* s between frames */
    double loss;        /* m: minus the distance travelled */
    double objective;   /* what is made smallest */
    int32_t* triangles; /* [n_triangles][3] */
    double* frames;     /* [n_frames][n_vertices][3], m */
    activity work;      /* its signals, forces and muscles */
} motion;

/* Lets x swim and keeps its surface at every step. DONE, FAILED (said) or INTERRUPTED. */
int motion_record(motion* m, scene* s, const double* x, progress* p);
void motion_free(motion* m);
/* Vertices of a frame, [n_vertices][3]. */
const double* motion_frame(const motion* m, int64_t frame);

#endif
