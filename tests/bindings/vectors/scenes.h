/* SPDX-License-Identifier: MIT
 * The small scenes of the test vectors: a plane one of two outlines, and a box with two spindles of few triangles. */
#ifndef DQA_VECTOR_SCENES_H
#define DQA_VECTOR_SCENES_H

#include "diffaqua.h"

enum { N_BASES = 2, MAX_POINTS = 64, MAX_TRIANGLES = 96 };

/* A field of an options struct by its name in the header; a list ends with a NULL name. */
typedef struct setting {
    const char* name;
    double value;
} setting;

typedef struct scene {
    const char* name;
    int32_t dims;
    const setting* space_settings;
    const char* names[N_BASES];
    int64_t n_points, n_triangles;
    double points[N_BASES][3 * MAX_POINTS]; /* corners of polygons or vertices of meshes */
    int32_t triangles[3 * MAX_TRIANGLES];
    dqa_shape_space* space; /* built */
} scene;

extern const setting plane_space[], box_space[], plane_simulator[], box_simulator[], plane_perceptron[],
    box_perceptron[];

void make_plane(scene* s);
void make_box(scene* s);
dqa_simulator* make_simulator(const scene* s, const setting* settings);
dqa_controller* make_sine(void);
dqa_controller* make_perceptron(int32_t dims);

#endif
