/* SPDX-License-Identifier: MIT
 * The loss that the command line asks for: a weighted sum of the library's objectives. */
#ifndef DQA_EXAMPLES_OBJECTIVE_H
#define DQA_EXAMPLES_OBJECTIVE_H

#include "diffaqua.h"

#define OBJECTIVE_KINDS 5 /* each may stand in the sum once */

typedef struct objective {
    int32_t n_terms;
    int32_t kinds[OBJECTIVE_KINDS]; /* DQA_OBJECTIVE_* */
    double weights[OBJECTIVE_KINDS];
    double* path; /* rows of t, x, y, z for DQA_OBJECTIVE_PATH; owned */
    int64_t n_path;
} objective;

/* Reads "kind[:weight],..." and, for the kind `path`, the file of its points (NULL: none was named): lines of four
 * numbers, time in s and place in m. DONE, USAGE or FAILED (said). */
int objective_parse(objective* o, const char* text, const char* path_file);
void objective_free(objective* o);
/* Fills terms [n_terms] for the library. DONE or FAILED (said). */
int objective_terms(const objective* o, dqa_objective_term* terms);
/* "travel", "keep", ... */
const char* objective_name(int32_t kind);
/* 1 when the loss has the term `keep`: the sum of the distances (along each axis, smoothed by epsilon) from a place,
 * less a share of the heading, the sum of how far the head is ahead of the tail. */
int objective_keeps(const objective* o);
/* 1 when the loss is minus the distance travelled and nothing else. */
int objective_is_travel(const objective* o);

#endif
