/* SPDX-License-Identifier: MIT
 * One of several descents in a scene, each from a design of its own, in a folder of its own with a table and a
 * checkpoint. */
#ifndef DQA_EXAMPLES_LEG_H
#define DQA_EXAMPLES_LEG_H

#include "descent.h"

typedef struct leg {
    char name[32]; /* of its folder */
    char *folder, *settings;
    double w; /* the caller's: what the leg is about */
    run r;
    int has_run;
} leg;

/* Sets l->name's descent up in out/name, at its beginning from the design x or, with --resume, where it was left, and
 * makes its iterations. `what`: for the checkpoint, what sets it apart beside scene and x. rates [2]: factors of Adam's
 * rates of weights and controller (NULL: 1). `before`: what the progress counts of other legs. DONE, USAGE, FAILED
 * (said) or INTERRUPTED. */
int leg_descend(leg* l, const options* o, scene* s, progress* p, const char* what, const double* x, const double* rates,
                int64_t iterations, int64_t before);
void leg_free(leg* l);
/* Simulations so far. */
int64_t leg_simulations(const leg* l);

#endif
