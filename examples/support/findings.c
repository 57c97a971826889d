/* SPDX-License-Identifier: MIT
 * What an experiment has to show. */
#include "findings.h"

#include <stdio.h>

/* In the words of a person and of summary.json. */
static const char* const words[] = {"below", "at least", "above", "expected"};
static const char* const keys[] = {"below", "at_least", "above", "equals"};

static int finding_holds(const finding* c) {
    switch (c->kind) {
        case FINDING_BELOW:
            return c->value < c->bound;
        case FINDING_AT_LEAST:
            return c->value >= c->bound;
        case FINDING_ABOVE:
            return c->value > c->bound;
        case FINDING_EQUALS:
            return c->value == c->bound;
    }
    return 0;
}

int findings_hold(const finding* found, int n) {
    int held = 0;
    for (int k = 0; k < n; ++k) held += finding_holds(&found[k]);
    return held == n;
}

void findings_write(json* j, const finding* found, int n) {
    json_open(j, "claims", '{');
    for (int k = 0; k < n; ++k) {
        json_open(j, found[k].name, '{');
        json_boolean(j, "shown", finding_holds(&found[k]));
        json_string(j, "says", found[k].says);
        json_number(j, "value", found[k].value);
        json_number(j, keys[found[k].kind], found[k].bound);
        json_close(j, '}');
    }
    json_close(j, '}');
}

void findings_print(const finding* found, int n) {
    for (int k = 0; k < n; ++k)
        printf("%s: %s (%.6g, %s %.6g)\n", finding_holds(&found[k]) ? "shown    " : "NOT SHOWN", found[k].says,
               found[k].value, words[found[k].kind], found[k].bound);
}
