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

#endif
