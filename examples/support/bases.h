/* SPDX-License-Identifier: MIT
 * A list of base shapes with their actuators, as text that a person can read and write:
 *
 *     # two animals; lengths in metres, the longest animal being 1 m; the origin is the centre of mass
 *     base shark.stl
 *       caudal mean -0.25 0 0.01  half 0.18 0.08 0.09
 *       fins   mean 0.03 0.13 -0.06  half 0.08 0.05 0.02  angles 10 0 0  layers 4
 *     base meshes/tuna.stl
 *
 * A block begins with "base" and the path of a mesh, relative to the list. Each actuator line has a kind (caudal or
 * fins), the middle of its box, the half lengths of the box's edges, and optionally its Euler angles in degrees, its
 * category (0 for caudal and 1 for fins unless given), and for fins their layers (1 to 4) and the side (left or right)
 * when only one of the two is described; otherwise the left one is, and the right one is its mirror image. A base
 * without actuators gets them from its geometry. What follows a # is a comment.
 *
 * After a line "lengths own" the lengths of the list are those of an animal 1 m long, each of its own: a shape
 * described so fits with every other one. "lengths longest" goes back to metres. */
#ifndef DQA_EXAMPLES_BASES_H
#define DQA_EXAMPLES_BASES_H

#include "diffaqua.h"

#define BASES_MAX_ACTUATORS 1024

typedef struct bases_actuator {
    int32_t base; /* index of its mesh in the list */
    int line;     /* in the file */
    int own;      /* its lengths are relative to that of its own animal */
    dqa_actuator_options options;
} bases_actuator;

typedef struct bases {
    int32_t n_bases; /* of all lists read so far */
    int32_t n_actuators;
    bases_actuator* actuators;
} bases;

/* Reads a list, after any read before; add_mesh is called with the path of every mesh, in order. Returns DONE, or USAGE
 * or FAILED (said, with the number of the line). */
int bases_read(bases* b, const char* path, int (*add_mesh)(void* context, const char* mesh), void* context);
/* Gives a space, whose bases are the meshes of the list and whose cell size is set, the actuators. lengths [bases] (m;
 * NULL: 1 m each): of the animals, for lists of which each is described as if it were 1 m long. */
int bases_add_actuators(const bases* b, const char* path, const double* lengths, dqa_shape_space* space);
void bases_free(bases* b);

#endif
