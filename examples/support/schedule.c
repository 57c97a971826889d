/* SPDX-License-Identifier: MIT
 * The schedule of an optimisation. */
#include "schedule.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "say.h"

#define LEAST_CELLS 8 /* along an axis, as the library asks */
#define COARSE "0.5:1e-4,1:1e-6"
#define SHARE_BEFORE_LAST 0.6 /* of all stages but the last together, unless given */

static int refuse(const char* text) {
    say("--schedule expects none, coarse or stages like " COARSE
        " (share of the cells along an axis, 0.1 to 1 and 1 in the last; tolerance, 1e-10 to 1e-2; and if wanted the "
        "share of the iterations, above 0, together below 1), not \"%s\"",
        text);
    return USAGE;
}

/* The number at *rest, which moves past it; NaN where there is none. */
static double next_number(const char** rest) {
    char* end = NULL;
    const double value = strtod(*rest, &end);
    const int found = end != *rest;
    *rest = end;
    return found ? value : (double)NAN;
}

static int next_stage(const char** rest, schedule_stage* stage) {
    stage->grid = next_number(rest);
    if (!(stage->grid >= 0.1 && stage->grid <= 1.0) || *(*rest)++ != ':') return 0;
    stage->tolerance = next_number(rest);
    stage->share = 0.0;
    if (!(stage->tolerance >= 1e-10 && stage->tolerance <= 1e-2)) return 0;
    if (**rest != ':') return 1;
    ++*rest;
    stage->share = next_number(rest);
    return stage->share > 0.0 && stage->share < 1.0;
}

int schedule_parse(schedule* s, const char* text) {
    const char* rest = text != NULL && strcmp(text, "coarse") == 0 ? COARSE : text;
    double sum = 0.0;
    memset(s, 0, sizeof *s);
    if (text == NULL || strcmp(text, "none") == 0) {
        s->n_stages = 1;
        s->stages[0].grid = 1.0;
        return DONE;
    }
    for (;;) {
        if (s->n_stages == SCHEDULE_MAX_STAGES) {
            say("--schedule takes at most %d stages", SCHEDULE_MAX_STAGES);
            return USAGE;
        }
        if (!next_stage(&rest, &s->stages[s->n_stages++])) return refuse(text);
        if (*rest == '\0') break;
        if (*rest++ != ',') return refuse(text);
    }
    if (s->stages[s->n_stages - 1].grid < 1.0 || s->stages[s->n_stages - 1].share > 0.0) return refuse(text);
    for (int32_t k = 0; k + 1 < s->n_stages; ++k) {
        if (!(s->stages[k].share > 0.0)) s->stages[k].share = SHARE_BEFORE_LAST / (double)(s->n_stages - 1);
        sum += s->stages[k].share;
    }
    return sum < 1.0 ? DONE : refuse(text);
}

void schedule_add_settings(const schedule* s, memory_text* t) {
    if (s->n_stages == 1 && !(s->stages[0].tolerance > 0.0)) {
        memory_text_add(t, "schedule none\n");
        return;
    }
    memory_text_add(t, "schedule");
    for (int32_t k = 0; k < s->n_stages; ++k)
        memory_text_add(t, " %.17g:%.17g:%.17g", s->stages[k].grid, s->stages[k].tolerance, s->stages[k].share);
    memory_text_add(t, "\n");
}

void schedule_grid(const schedule* s, int32_t k, const int32_t grid[3], int32_t cells[3]) {
    for (int axis = 0; axis < 3; ++axis) {
        const int32_t n = (int32_t)floor(s->stages[k].grid * (double)grid[axis] + 0.5);
        cells[axis] = n < LEAST_CELLS ? LEAST_CELLS : n;
    }
}

int64_t schedule_budget(const schedule* s, int32_t k, int64_t iterations, int64_t before) {
    const int64_t left = iterations - before;
    int64_t own;
    if (k + 1 == s->n_stages) return left > 1 ? left : 1;
    own = (int64_t)floor(s->stages[k].share * (double)iterations + 1e-9);
    return own < left ? own : left > 1 ? left - 1 : 0;
}
