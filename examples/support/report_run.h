/* SPDX-License-Identifier: MIT
 * The report of an optimisation: its headline numbers, its curves, its swimmers and its settings. */
#ifndef DQA_EXAMPLES_REPORT_RUN_H
#define DQA_EXAMPLES_REPORT_RUN_H

#include "motion.h"
#include "options.h"
#include "report.h"
#include "run.h"
#include "scene.h"

/* Writes folder/report.html, whole or not at all, for a run of at least one iteration; `first` and `best` are the swims
 * of its first and its best design, `program` and `command` are what made it. DONE or FAILED (said). */
int report_run(const char* program, const run* r, const options* o, const scene* s, const motion* first,
               const motion* best, const char* command, const char* folder);

#endif
