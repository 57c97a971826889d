/* SPDX-License-Identifier: MIT
 * What an experiment has to show: a number and the bound that it must keep. */
#ifndef DQA_EXAMPLES_FINDINGS_H
#define DQA_EXAMPLES_FINDINGS_H

#include "json.h"

typedef enum finding_kind { FINDING_BELOW, FINDING_AT_LEAST, FINDING_ABOVE, FINDING_EQUALS } finding_kind;

typedef struct finding {
    const char* name; /* key in summary.json */
    const char* says;
    double value, bound;
    finding_kind kind;
} finding;

/* 1 when all n of them hold. */
int findings_hold(const finding* found, int n);
/* As a member `claims` of the open object. */
void findings_write(json* j, const finding* found, int n);
/* A line each on the standard output. */
void findings_print(const finding* found, int n);

#endif
