/* SPDX-License-Identifier: MIT
 * Shared by the tests of the C API: two assertions, and a space, a simulator and a tape small enough for thousands of
 * runs. The tests see the library as callers do: through its header and the shared object alone. */
#ifndef DQA_TEST_SUPPORT_H
#define DQA_TEST_SUPPORT_H

/* cmocka.h needs the standard headers before it. */
/* clang-format off */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
/* clang-format on */

#include "diffaqua.h"

/* The call succeeds; otherwise the library's own message is printed. */
#define ok(call) check_ok((call), #call, __FILE__, __LINE__)

/* The call fails with `status`, and the message it leaves names one of `names` ("a|b": a or b) as a whole word. */
#define refused(call, status, names) \
    check_refused((leave_other_error(), (call)), (status), (names), #call, __FILE__, __LINE__)

void check_ok(dqa_status status, const char* call, const char* file, int line);
void check_refused(dqa_status got, dqa_status status, const char* names, const char* call, const char* file, int line);
/* Makes some other call fail, so that a message left over from earlier cannot pass for that of the call under test. */
void leave_other_error(void);

enum { NX = 16, NY = 8, NZ = 8, N_CELLS = NX * NY * NZ, N_BASES = 2 };

extern const double HALF[N_BASES]; /* weights of the design half way between the two bases */

/* Covered fractions of an ellipsoid in the middle of the box, semi-axes in cells. */
void ellipsoid(double* cells, double a, double b, double c);
/* Options of the small box: 16 x 8 x 8 cells of 0.1 m. */
dqa_shape_space_options tiny_options(void);
/* A space with two ellipsoids as bases, still open; and the same built. */
dqa_shape_space* tiny_space_open(void);
dqa_shape_space* tiny_space(void);
/* A simulator of the space with default options and the design HALF; and its number of state elements. */
dqa_simulator* tiny_simulator(dqa_shape_space* space);
int64_t state_length(const dqa_simulator* simulator);
/* A sinusoid that swims: amplitude, frequency and phase differ between signals. */
dqa_controller* tiny_controller(dqa_simulator* simulator);
/* A tape of `n_steps` steps of the simulator under tiny_controller. */
dqa_tape* tiny_tape(dqa_simulator* simulator, int64_t n_steps);

/* malloc that fails the test rather than return NULL; zeroed; at least one element. */
double* doubles(int64_t n);

/* Progress callbacks: count calls in *(int64_t *)user_data; cancel at the first call; cancel at `done` == *user_data.
 */
int32_t count_progress(int64_t done, int64_t total, void* user_data);
int32_t cancel_at_once(int64_t done, int64_t total, void* user_data);
int32_t cancel_when(int64_t done, int64_t total, void* user_data);

#endif
