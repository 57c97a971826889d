/* SPDX-License-Identifier: MIT
 * Scenes of the accuracy tests: shape spaces from shipped shapes and from the real meshes of DQA_TEST_DATA. */
#ifndef DQA_TEST_SCENES_H
#define DQA_TEST_SCENES_H

/* cmocka.h needs the standard headers before it. */
/* clang-format off */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
/* clang-format on */

#include "diffaqua.h"

/* The call succeeds; otherwise the library's own message is printed. */
#define ok(call) scene_ok((call), #call, __FILE__, __LINE__)
void scene_ok(dqa_status status, const char* call, const char* file, int line);

/* A built space of two bases with a tight marginal error. NULL (and a printed message) where the meshes are absent. */
dqa_shape_space* scene_real(int32_t nx, int32_t ny, int32_t nz, double tolerance);    /* orca, great white shark */
dqa_shape_space* scene_shipped(int32_t nx, int32_t ny, int32_t nz, double tolerance); /* clownfish, tuna */

dqa_simulator* scene_simulator(dqa_shape_space* space, const dqa_simulator_options* options, double first_weight);
dqa_objective_term scene_travel(void);
/* Defaults, with the instruction set that the variable DQA_TEST_INSTRUCTION_SET names (1 baseline, 2 AVX2), if any. */
dqa_simulator_options scene_options(void);
/* Whether that set would try nothing new on this processor; a program then ends with 77. */
int scene_skipped(void);
double* scene_doubles(int64_t n);

#endif
