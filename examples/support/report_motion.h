/* SPDX-License-Identifier: MIT
 * A motion as compact JSON: positions rounded to 1/16383 of the longest way through the scene (0.1 mm on 1.6 m), which
 * is less than a pixel. */
#ifndef DQA_EXAMPLES_REPORT_MOTION_H
#define DQA_EXAMPLES_REPORT_MOTION_H

#include "json.h"
#include "motion.h"

/* Writes the members of the open object of `j`:
 * vertices, elements, frames  counts
 * travel      m: the distance travelled, which is minus the loss DQA_OBJECTIVE_TRAVEL
 * times       s, of the frames kept: all, or every second, third, ... and the last where the page would get too large
 * origin, quantum     m: coordinate = origin + quantum * whole number
 * triangles   base64 of 32-bit little-endian indices
 * positions   base64 of the whole numbers [frames][vertices][3], each as its difference from a guess (frame 0: the
 *             vertex before; frame 1: the frame before; later: straight on from the two frames before), the sign in the
 *             lowest bit (0, -1, 1, -2, ... are 0, 1, 2, 3, ...), seven bits a byte, lowest first, the eighth: more
 *             follow
 * first_pull, pull_signal, pull   the muscles beneath each vertex (activity.h)
 * signals     [signals][frames - 1]: of the step that ends at each kept frame but the first
 * current     [3][frames - 1], m/s, likewise */
void report_motion_write(json* j, const motion* m);

#endif
