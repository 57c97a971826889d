/* SPDX-License-Identifier: MIT */
#include "scene.h"

dqa_shape_space* space = NULL;
dqa_simulator* simulator = NULL;

int open_scene(void** state) {
    (void)state;
    space = tiny_space();
    simulator = tiny_simulator(space);
    return 0;
}

int close_scene(void** state) {
    (void)state;
    dqa_simulator_free(simulator);
    dqa_shape_space_free(space);
    return 0;
}
