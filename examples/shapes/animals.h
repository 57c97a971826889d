/* SPDX-License-Identifier: MIT
 * The shapes: what each is made of, where its muscles lie, and how fine its mesh is. Head at +x, z up; lengths in body
 * lengths before the last scaling to a length of exactly 1. */
#ifndef DQA_SHAPES_ANIMALS_H
#define DQA_SHAPES_ANIMALS_H

#include "solid.h"

/* A box: a caudal pair across y = 0, or the left one of two fins. */
typedef struct {
    int is_fin;
    double mean[3], half[3];
    double degrees[3]; /* Euler angles as in codesign's lists */
} muscle;

typedef struct {
    const char* name;
    const char* what; /* for the head of its list of muscles */
    void (*build)(solid* s);
    double cells;  /* about how many the shape is long in the paper's box: fins are 4/3 cells thick there */
    int triangles; /* of the mesh, at most */
    int muscles;
    muscle muscle[2];
} animal;

extern const animal eels[2], bony_fishes[2], rays[2], sharks[4], goldfishes[7], others[2];

#endif
