/* SPDX-License-Identifier: MIT
 * Points of two losses, both to be made small: which are better than which, and how much of the plane they beat. */
#ifndef DQA_EXAMPLES_FRONT_H
#define DQA_EXAMPLES_FRONT_H

#include <stdint.h>

/* Non-dominated sorting of points [n][2]: rank [n] is 0 for those that no other one dominates (no larger in both losses
 * and smaller in one), 1 for those that only points of rank 0 dominate, and so on (Deb et al. 2002, "NSGA-II"). In
 * O(n log n): in order of the first loss, a point has the first rank whose least second loss so far is larger. Equal
 * points have equal rank. DONE or FAILED (said). */
int front_ranks(const double* points, int64_t n, int64_t* rank);
/* Area of what is dominated by some point and dominates the reference [2] (Zitzler & Thiele 1999); *area. DONE or
 * FAILED (said). */
int front_hypervolume(const double* points, int64_t n, const double* reference, double* area);
/* Indices of the points of rank 0 in rising order of the first loss, one of equal ones: chain [n], *length of them are
 * written. DONE or FAILED (said). */
int front_chain(const double* points, int64_t n, int64_t* chain, int64_t* length);

#endif
