/* SPDX-License-Identifier: MIT
 * history.csv: one row per iteration of an optimisation. */
#ifndef DQA_EXAMPLES_HISTORY_H
#define DQA_EXAMPLES_HISTORY_H

#include "diffaqua.h"
#include "run.h"

#define HISTORY_FILE "history.csv"

/* Writes the finished iterations to folder/history.csv, whole or not at all. Columns: iteration, loss (m), the weight
 * of each base, a, omega (rad/s) and phi (rad) of each signal, grad_norm_weights, grad_norm_control, seconds,
 * cpu_seconds (since the start), newton_iterations, linear_iterations, adjoint_iterations (0 where the design repeats),
 * stage (of the schedule, from 1), simulations (since the start), and the terms of a sum. DONE or FAILED (said). */
int history_write(const run* r, const dqa_shape_space* space, const char* folder);

#endif
