/* SPDX-License-Identifier: MIT
 * codesign.png: the optimisation's curves, and the first and the best swimmer in motion, drawn by gnuplot. */
#ifndef DQA_EXAMPLES_PICTURE_H
#define DQA_EXAMPLES_PICTURE_H

#include "motion.h"
#include "plot.h"
#include "run.h"

#define PICTURE_FILE "codesign.png"
#define PICTURE_FIRST_COLOUR 0x5b6770u /* slate */
#define PICTURE_BEST_COLOUR 0x0b5c8au  /* deep blue */
#define PICTURE_SCRIPT "codesign.gp"

/* Writes the script and its data into the folder, beside history.csv, and runs gnuplot there. *drawn is 0 when gnuplot
 * is missing, which is said but is no failure. DONE, FAILED (said) or INTERRUPTED. */
int picture_make(const run* r, const dqa_shape_space* space, const motion* first, const motion* best,
                 const char* folder, int* drawn);

#endif
