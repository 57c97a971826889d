/* SPDX-License-Identifier: MIT
 * The space that most groups of tests share, made before the first test of a program and freed after the last. */
#ifndef DQA_TEST_SPACE_H
#define DQA_TEST_SPACE_H

#include "support.h"

extern dqa_shape_space* space; /* tiny_space() */

/* For cmocka_run_group_tests_name. */
int open_space(void** state);
int close_space(void** state);

#endif
