/* SPDX-License-Identifier: MIT
 * The best design of an optimisation as files that other programs read. */
#ifndef DQA_EXAMPLES_RESULTS_H
#define DQA_EXAMPLES_RESULTS_H

#include "motion.h"

#define DESIGN_FILE "design.stl"
#define CONTROLLER_FILE "controller.dqa" /* dqa_controller_load reads it */

/* Writes the surface at rest, the motion, and the controller of the scene's current design, whose motion is `m`, into
 * the folder. DONE, FAILED (said) or INTERRUPTED. */
int results_write(const scene* s, const motion* m, const char* folder);

#endif
