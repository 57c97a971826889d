/* SPDX-License-Identifier: MIT
 * The scene that most groups of tests share: one space and one simulator of it, made before the first test of a program
 * and freed after the last. */
#ifndef DQA_TEST_SCENE_H
#define DQA_TEST_SCENE_H

#include "space.h"

extern dqa_simulator* simulator; /* tiny_simulator(space) */

/* For cmocka_run_group_tests_name. */
int open_scene(void** state);
int close_scene(void** state);

#endif
