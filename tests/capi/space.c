/* SPDX-License-Identifier: MIT */
#include "space.h"

dqa_shape_space* space = NULL;

int open_space(void** state) {
    (void)state;
    space = tiny_space();
    return 0;
}

int close_space(void** state) {
    (void)state;
    dqa_shape_space_free(space);
    return 0;
}
