/* SPDX-License-Identifier: MIT
 * What a design is as a set of cells: its parts, and how far it agrees with another set. */
#ifndef DQA_EXAMPLES_CENSUS_H
#define DQA_EXAMPLES_CENSUS_H

#include <stdint.h>

/* Number of parts, connected by faces, of the cells of [cells[0]][cells[1]][cells[2]] that are above 1/2; *largest: the
 * share of all of them in the largest part. -1 (said) when memory runs out. */
int64_t census_parts(const double* value, const int32_t cells[3], double* largest);
/* Cells above 1/2 in both over those in either. 1 when both are empty. */
double census_overlap(const double* a, const double* b, int64_t n);

#endif
