/* SPDX-License-Identifier: MIT
 * Parts and overlaps of sets of cells against a count by other means: labels that spread until nothing changes. */
/* cmocka.h needs the standard headers before it. */
/* clang-format off */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>
/* clang-format on */

#include "support/census.h"

enum { MOST = 6 * 7 * 5 };

static int64_t at(const int32_t cells[3], int i, int j, int k) {
    return ((int64_t)i * cells[1] + j) * cells[2] + k;
}

/* Every cell starts with a label of its own and takes the least among its neighbours, again and again. */
static int64_t count(const double* value, const int32_t cells[3], double* largest) {
    int64_t label[MOST], size[MOST] = {0}, parts = 0, all = 0, most = 0;
    int changed = 1;
    for (int64_t c = 0; c < MOST; ++c) label[c] = c;
    while (changed) {
        changed = 0;
        for (int i = 0; i < cells[0]; ++i)
            for (int j = 0; j < cells[1]; ++j)
                for (int k = 0; k < cells[2]; ++k) {
                    const int64_t here = at(cells, i, j, k);
                    const int64_t next[3] = {i + 1 < cells[0] ? at(cells, i + 1, j, k) : -1,
                                             j + 1 < cells[1] ? at(cells, i, j + 1, k) : -1,
                                             k + 1 < cells[2] ? at(cells, i, j, k + 1) : -1};
                    for (int n = 0; n < 3; ++n) {
                        if (next[n] < 0 || value[here] <= 0.5 || value[next[n]] <= 0.5 || label[here] == label[next[n]])
                            continue;
                        if (label[here] < label[next[n]])
                            label[next[n]] = label[here];
                        else
                            label[here] = label[next[n]];
                        changed = 1;
                    }
                }
    }
    for (int64_t c = 0; c < (int64_t)cells[0] * cells[1] * cells[2]; ++c)
        if (value[c] > 0.5) ++size[label[c]], ++all;
    for (int64_t c = 0; c < MOST; ++c) {
        parts += size[c] > 0;
        if (size[c] > most) most = size[c];
    }
    *largest = all > 0 ? (double)most / (double)all : 0.0;
    return parts;
}

static void random_sets(void** state) {
    static const int32_t boxes[][3] = {{6, 7, 5}, {1, 7, 5}, {6, 1, 1}, {3, 3, 3}};
    uint32_t seed = 7;
    int64_t several = 0;
    (void)state;
    for (size_t b = 0; b < sizeof boxes / sizeof boxes[0]; ++b)
        for (int trial = 0; trial < 300; ++trial) {
            double value[MOST], largest = -1.0, expected = -1.0;
            const uint32_t share = (uint32_t)trial % 10;
            for (int64_t c = 0; c < MOST; ++c) {
                seed = 1664525u * seed + 1013904223u; /* Numerical Recipes' quick generator */
                value[c] = (seed >> 16) % 10 < share ? 0.75 : 0.5;
            }
            assert_int_equal(census_parts(value, boxes[b], &largest), count(value, boxes[b], &expected));
            assert_true(largest == expected);
            several += expected < 1.0;
        }
    assert_true(several > 600);
}

/* A bar in the middle of a box, cut by one layer of cells, and a crumb that only touches its edge. */
static void known_set(void** state) {
    const int32_t cells[3] = {6, 7, 5};
    double value[MOST] = {0.0}, largest;
    (void)state;
    assert_int_equal(census_parts(value, cells, &largest), 0);
    assert_true(largest == 0.0);
    for (int i = 0; i < 6; ++i) value[at(cells, i, 3, 2)] = value[at(cells, i, 3, 3)] = 1.0;
    assert_int_equal(census_parts(value, cells, &largest), 1);
    assert_true(largest == 1.0);
    value[at(cells, 2, 3, 2)] = 0.5; /* one half is not more than one half; its neighbour holds the bar together */
    assert_int_equal(census_parts(value, cells, &largest), 1);
    value[at(cells, 2, 3, 3)] = 0.0;
    value[at(cells, 5, 4, 4)] = 1.0;
    assert_int_equal(census_parts(value, cells, &largest), 3);
    assert_true(largest == 6.0 / 11.0);
}

static void overlaps(void** state) {
    const double a[4] = {1.0, 0.6, 0.5, 0.0}, b[4] = {0.0, 0.7, 0.9, 0.2}, none[4] = {0.0};
    (void)state;
    assert_true(census_overlap(a, b, 4) == 1.0 / 3.0);
    assert_true(census_overlap(a, a, 4) == 1.0);
    assert_true(census_overlap(a, none, 4) == 0.0);
    assert_true(census_overlap(none, none, 4) == 1.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_sets),
        cmocka_unit_test(known_set),
        cmocka_unit_test(overlaps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
