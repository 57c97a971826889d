/* SPDX-License-Identifier: MIT
 * Sets of cells: parts by flooding. */
#include "census.h"

#include <stdlib.h>

#include "say.h"

#define INSIDE 0.5

/* Number of cells of the part around `start`; marks them as seen. */
static int64_t flood(const double* value, const int32_t cells[3], int64_t start, unsigned char* seen, int64_t* stack) {
    const int64_t stride[3] = {(int64_t)cells[1] * cells[2], cells[2], 1};
    int64_t depth = 0, count = 0;
    stack[depth++] = start;
    seen[start] = 1;
    while (depth > 0) {
        const int64_t at = stack[--depth];
        ++count;
        for (int axis = 0; axis < 3; ++axis) {
            const int64_t place = at / stride[axis] % cells[axis];
            for (int side = -1; side <= 1; side += 2) {
                const int64_t next = at + side * stride[axis];
                if (place + side < 0 || place + side >= cells[axis] || seen[next] || !(value[next] > INSIDE)) continue;
                seen[next] = 1;
                stack[depth++] = next;
            }
        }
    }
    return count;
}

int64_t census_parts(const double* value, const int32_t cells[3], double* largest) {
    const int64_t n = (int64_t)cells[0] * cells[1] * cells[2];
    unsigned char* seen = calloc((size_t)n, 1);
    int64_t* stack = malloc((size_t)n * sizeof *stack);
    int64_t parts = 0, all = 0, most = 0;
    if (seen == NULL || stack == NULL) {
        free(seen);
        free(stack);
        (void)say_no_memory();
        return -1;
    }
    for (int64_t i = 0; i < n; ++i) {
        int64_t count;
        if (seen[i] || !(value[i] > INSIDE)) continue;
        count = flood(value, cells, i, seen, stack);
        ++parts;
        all += count;
        if (count > most) most = count;
    }
    *largest = all > 0 ? (double)most / (double)all : 0.0;
    free(seen);
    free(stack);
    return parts;
}

double census_overlap(const double* a, const double* b, int64_t n) {
    int64_t both = 0, either = 0;
    for (int64_t i = 0; i < n; ++i) {
        both += a[i] > INSIDE && b[i] > INSIDE;
        either += a[i] > INSIDE || b[i] > INSIDE;
    }
    return either > 0 ? (double)both / (double)either : 1.0;
}
