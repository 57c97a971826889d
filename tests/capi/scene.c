/* SPDX-License-Identifier: MIT */
#include "scene.h"

dqa_simulator* simulator = NULL;

int open_scene(void** state) {
    const int failed = open_space(state);
    simulator = tiny_simulator(space);
    return failed;
}

int close_scene(void** state) {
    dqa_simulator_free(simulator);
    return close_space(state);
}
