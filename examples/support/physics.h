/* SPDX-License-Identifier: MIT
 * The part of the command line that changes the laws: how muscles are interpolated, what the body is made of, how time
 * is integrated and how the water moves. */
#ifndef DQA_EXAMPLES_PHYSICS_H
#define DQA_EXAMPLES_PHYSICS_H

#include "diffaqua.h"
#include "json.h"
#include "memory_text.h"

/* The words of the command line; NULL or 0 where it was silent. */
typedef struct physics_words {
    const char *interpolation, *material, *quadrature, *integrator, *current, *current_file;
    int automatic_fins, planar;
} physics_words;

typedef struct physics {
    int32_t interpolation;    /* DQA_INTERPOLATION_* */
    int32_t material;         /* DQA_MATERIAL_* */
    int32_t quadrature;       /* DQA_QUADRATURE_* */
    int32_t integrator;       /* DQA_INTEGRATOR_* */
    int32_t automatic_fins;   /* 0 or 1 */
    int32_t planar;           /* 0 or 1 */
    double current[3];        /* m/s, without a table */
    const char* current_file; /* NULL: none */
    double* table;            /* rows of t, x, y, z (s, m/s); owned */
    int64_t n_table;          /* its elements */
} physics;

/* DONE, USAGE or FAILED (said). */
int physics_parse(physics* p, const physics_words* words);
void physics_free(physics* p);
void physics_of_space(const physics* p, dqa_shape_space_options* options);
void physics_of_simulator(const physics* p, dqa_simulator_options* options);
/* Gives the simulator the table of the current, where there is one. DONE or FAILED (said). */
int physics_set_current(const physics* p, dqa_simulator* simulator);
/* As lines of a checkpoint, and as members of the summary. */
void physics_add_settings(const physics* p, memory_text* t);
void physics_write(const physics* p, json* j);

#endif
