/* SPDX-License-Identifier: MIT
 * The front of two losses against brute force, on points of a small lattice, so that ties and equal points occur and
 * every area is a whole number. */
/* cmocka.h needs the standard headers before it. */
/* clang-format off */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>
/* clang-format on */

#include "support/front.h"
#include "support/say.h"

enum { MOST = 40, SIDE = 12 };

/* Numerical Recipes' quick generator: the same points on every machine. */
static uint32_t next_random(uint32_t* state) {
    *state = 1664525u * *state + 1013904223u;
    return *state >> 16;
}

static int dominates(const double* a, const double* b) {
    return a[0] <= b[0] && a[1] <= b[1] && (a[0] < b[0] || a[1] < b[1]);
}

/* Takes the points that nothing left dominates, again and again. */
static void peel(const double* points, int64_t n, int64_t* rank) {
    int64_t left = n;
    for (int64_t i = 0; i < n; ++i) rank[i] = -1;
    for (int64_t r = 0; left > 0; ++r) {
        int taken[MOST] = {0};
        for (int64_t i = 0; i < n; ++i) {
            int free_of = rank[i] < 0;
            for (int64_t j = 0; j < n && free_of; ++j)
                if (rank[j] < 0 && dominates(points + 2 * j, points + 2 * i)) free_of = 0;
            taken[i] = free_of;
        }
        for (int64_t i = 0; i < n; ++i)
            if (taken[i]) {
                rank[i] = r;
                --left;
            }
    }
}

/* Counts the lattice's squares whose lower corner some point dominates or is. */
static double count_squares(const double* points, int64_t n, const double* reference) {
    double area = 0.0;
    for (int x = -1; x < (int)reference[0]; ++x)
        for (int y = -1; y < (int)reference[1]; ++y) {
            int covered = 0;
            for (int64_t i = 0; i < n; ++i) covered = covered || (points[2 * i] <= x && points[2 * i + 1] <= y);
            area += covered;
        }
    return area;
}

static void test_brute_force(void** state) {
    uint32_t random = 7;
    (void)state;
    for (int trial = 0; trial < 400; ++trial) {
        const int64_t n = next_random(&random) % (MOST + 1);
        const double reference[2] = {(double)(next_random(&random) % SIDE), (double)(next_random(&random) % SIDE)};
        double points[2 * MOST], area = -1.0;
        int64_t rank[MOST], wanted[MOST], chain[MOST], length = -1, of_front = 0;
        for (int64_t i = 0; i < 2 * n; ++i) points[i] = (double)(next_random(&random) % SIDE);
        assert_int_equal(front_ranks(points, n, rank), DONE);
        peel(points, n, wanted);
        for (int64_t i = 0; i < n; ++i) assert_int_equal(rank[i], wanted[i]);
        assert_int_equal(front_hypervolume(points, n, reference, &area), DONE);
        assert_true(area == count_squares(points, n, reference));
        assert_int_equal(front_chain(points, n, chain, &length), DONE);
        for (int64_t k = 0; k < length; ++k) {
            assert_int_equal(wanted[chain[k]], 0);
            if (k > 0) assert_true(points[2 * chain[k]] > points[2 * chain[k - 1]]);
        }
        /* All of rank 0, but one of equal ones. */
        for (int64_t i = 0; i < n; ++i) {
            int first = wanted[i] == 0;
            for (int64_t j = 0; j < i; ++j)
                if (points[2 * j] == points[2 * i] && points[2 * j + 1] == points[2 * i + 1]) first = 0;
            of_front += first;
        }
        assert_int_equal(length, of_front);
    }
}

static void test_by_hand(void** state) {
    /* A staircase of three, one behind it, and one beyond the reference. */
    static const double points[] = {-3.0, -1.0, -2.0, -2.0, -1.0, -3.0, -1.5, -1.5, 1.0, -9.0};
    static const double origin[2] = {0.0, 0.0};
    static const int64_t wanted[] = {0, 0, 0, 1, 0};
    int64_t rank[5];
    double area = 0.0;
    (void)state;
    assert_int_equal(front_ranks(points, 5, rank), DONE);
    for (int i = 0; i < 5; ++i) assert_int_equal(rank[i], wanted[i]);
    assert_int_equal(front_hypervolume(points, 5, origin, &area), DONE);
    assert_true(area == 6.0);
    assert_int_equal(front_hypervolume(points, 0, origin, &area), DONE);
    assert_true(area == 0.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_brute_force), cmocka_unit_test(test_by_hand)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
