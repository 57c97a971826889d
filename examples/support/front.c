/* SPDX-License-Identifier: MIT */
#include "front.h"

#include <stdlib.h>

#include "say.h"

typedef struct entry {
    double f[2];
    int64_t index;
} entry;

static int first_loss_first(const void* a, const void* b) {
    const entry *x = a, *y = b;
    for (int k = 0; k < 2; ++k)
        if (x->f[k] != y->f[k]) return x->f[k] < y->f[k] ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

/* The points in rising order of the first loss, of equal ones in that of the second; NULL (said) without memory. */
static entry* sorted(const double* points, int64_t n) {
    entry* e = malloc((size_t)(n > 0 ? n : 1) * sizeof *e);
    if (e == NULL) {
        (void)say_no_memory();
        return NULL;
    }
    for (int64_t i = 0; i < n; ++i) e[i] = (entry){{points[2 * i], points[2 * i + 1]}, i};
    qsort(e, (size_t)n, sizeof *e, first_loss_first);
    return e;
}

int front_ranks(const double* points, int64_t n, int64_t* rank) {
    entry* e = sorted(points, n);
    /* The last point of each rank, which has its least second loss. */
    const entry** last = malloc((size_t)(n > 0 ? n : 1) * sizeof *last);
    int64_t ranks = 0;
    if (e == NULL || last == NULL) {
        free(e);
        free(last);
        return say_no_memory();
    }
    for (int64_t i = 0; i < n; ++i) {
        int64_t low = 0, high = ranks;
        /* Least second losses rise with the rank. */
        while (low < high) {
            const int64_t middle = (low + high) / 2;
            const entry* q = last[middle];
            const int equal = q->f[0] == e[i].f[0] && q->f[1] == e[i].f[1];
            if (q->f[1] <= e[i].f[1] && !equal)
                low = middle + 1;
            else
                high = middle;
        }
        if (low == ranks) ++ranks;
        last[low] = &e[i];
        rank[e[i].index] = low;
    }
    free(e);
    free(last);
    return DONE;
}

int front_chain(const double* points, int64_t n, int64_t* chain, int64_t* length) {
    entry* e = sorted(points, n);
    *length = 0;
    if (e == NULL) return FAILED;
    for (int64_t i = 0; i < n; ++i)
        if (*length == 0 || e[i].f[1] < points[2 * chain[*length - 1] + 1]) chain[(*length)++] = e[i].index;
    free(e);
    return DONE;
}

int front_hypervolume(const double* points, int64_t n, const double* reference, double* area) {
    entry* e = sorted(points, n);
    double least = reference[1];
    *area = 0.0;
    if (e == NULL) return FAILED;
    for (int64_t i = 0; i < n; ++i) {
        if (e[i].f[0] >= reference[0] || e[i].f[1] >= least) continue;
        *area += (reference[0] - e[i].f[0]) * (least - e[i].f[1]);
        least = e[i].f[1];
    }
    free(e);
    return DONE;
}
