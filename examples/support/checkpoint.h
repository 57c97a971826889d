/* SPDX-License-Identifier: MIT
 * The state of an optimisation on disk, so that an interrupted run goes on bit for bit. */
#ifndef DQA_EXAMPLES_CHECKPOINT_H
#define DQA_EXAMPLES_CHECKPOINT_H

#include "options.h"
#include "run.h"

#define CHECKPOINT_FILE "checkpoint.txt"
#define CHECKPOINT_SETTINGS_END "settings-end\n" /* follows the settings in the file */

/* What a checkpoint belongs to: all that changes the numbers (grid, steps, bases by content, initial weights, kind of
 * control, library version). Thread count and number of iterations do not. A text of "name value" lines; owned. */
char* checkpoint_settings(const options* o); /* NULL (said): a mesh cannot be read, or out of memory */

/* DONE where the settings found in a checkpoint are those wanted; USAGE, with the first line that differs (said). */
int checkpoint_compare(const char* found, const char* wanted);
/* 1 when the folder holds a checkpoint file. */
int checkpoint_exists(const char* folder);
/* Writes folder/checkpoint.txt, whole or not at all. DONE or FAILED (said). */
int checkpoint_save(const run* r, const char* settings, const char* folder);
/* Reads it into `r`, which run_create has set up for the same problem. Refuses a damaged checkpoint, or one of other
 * settings, and says which. DONE, FAILED or USAGE (said). */
int checkpoint_load(run* r, const char* settings, const char* folder);

#endif
