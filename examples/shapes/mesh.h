/* SPDX-License-Identifier: MIT
 * Closed triangle meshes of solids. */
#ifndef DQA_SHAPES_MESH_H
#define DQA_SHAPES_MESH_H

#include "solid.h"

/* Triangles are counter-clockwise seen from outside. */
typedef struct {
    int vertices, triangles;
    vec* vertex;
    int (*triangle)[3];
} mesh;

/* Memory of at least one byte, zero; the program ends with a message when there is none. */
void* shapes_memory(unsigned long count, unsigned long size);

/* The half y >= 0 of a solid's surface, from marching tetrahedra of edge `step`. Its boundary lies in y = 0. */
mesh mesh_half(const solid* s, double step);
/* Evens out the triangles of a half: its vertices move to the middle of their neighbours and back to the surface. */
void mesh_relax(mesh* m, const solid* s, double step);
/* Collapses edges of half a solid's surface until `most` triangles are left, or none can go without folding it. */
void mesh_simplify(mesh* m, int most);
/* Joins a half and its mirror image. */
void mesh_mirror(mesh* m);
/* Scales to length 1 along x with the head at x = +1/2; *scale, *shift: x_new = scale * x + shift, y and z scaled. */
void mesh_fit(mesh* m, double* scale, double* shift);
vec mesh_centre(const mesh* m);
void mesh_free(mesh* m);

#endif
