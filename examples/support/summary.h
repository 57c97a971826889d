/* SPDX-License-Identifier: MIT
 * summary.json: what was asked, what came out, and how far the gradient can be trusted. */
#ifndef DQA_EXAMPLES_SUMMARY_H
#define DQA_EXAMPLES_SUMMARY_H

#include "json.h"
#include "options.h"
#include "run.h"
#include "scene.h"

#define SUMMARY_FILE "summary.json"

/* Writes folder/summary.json, whole or not at all, for a run of at least one iteration whose best design is the
 * scene's current one. DONE or FAILED (said). */
int summary_write(const run* r, const options* o, const scene* s, int converged, const char* folder);

/* Its parts, as members of the open object of `j`, for other files that show them. */
void summary_settings(json* j, const options* o, const run* r, const scene* s);
void summary_proofs(json* j, const run* r);
void summary_machine(json* j, const options* o);

/* The same of the program and the library; as members of their own, the cells of the current design, numbers, and a
 * design as evaluated in an iteration (from 1). */
void summary_program(json* j, const char* program);
void summary_cells(json* j, const options* o, const dqa_simulator_info* info);
void summary_numbers(json* j, const char* key, const double* x, int64_t n);
void summary_design(json* j, const char* key, const run* r, int64_t iteration);

#endif
