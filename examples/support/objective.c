/* SPDX-License-Identifier: MIT */
#include "objective.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "say.h"
#include "table.h"

static const char* const names[OBJECTIVE_KINDS] = {"travel", "keep", "efficiency", "effort", "path"};

const char* objective_name(int32_t kind) {
    return names[kind];
}

int objective_keeps(const objective* o) {
    int keeps = 0;
    for (int32_t k = 0; k < o->n_terms; ++k) keeps = keeps || o->kinds[k] == DQA_OBJECTIVE_POSITION_KEEPING;
    return keeps;
}

int objective_is_travel(const objective* o) {
    return o->n_terms == 1 && o->kinds[0] == DQA_OBJECTIVE_TRAVEL && o->weights[0] == 1.0;
}

static int wrong(const char* text) {
    say("--objective expects travel, keep, efficiency, effort or path, each once and with a weight if it is not 1, "
        "like "
        "travel:1,effort:0.01, not \"%s\"",
        text);
    return USAGE;
}

static int parse_terms(objective* o, const char* text) {
    const char* rest = text;
    for (;;) {
        const size_t length = strcspn(rest, ":,");
        int32_t kind = 0;
        double weight = 1.0;
        while (kind < OBJECTIVE_KINDS && (strlen(names[kind]) != length || strncmp(names[kind], rest, length) != 0))
            ++kind;
        if (kind == OBJECTIVE_KINDS) return wrong(text);
        for (int32_t k = 0; k < o->n_terms; ++k)
            if (o->kinds[k] == kind) return wrong(text);
        rest += length;
        if (*rest == ':') {
            char* end = NULL;
            weight = strtod(rest + 1, &end);
            if (end == rest + 1 || !isfinite(weight) || (*end != ',' && *end != '\0')) return wrong(text);
            rest = end;
        }
        o->kinds[o->n_terms] = kind;
        o->weights[o->n_terms++] = weight;
        if (*rest == '\0') return DONE;
        ++rest;
    }
}

int objective_parse(objective* o, const char* text, const char* path_file) {
    int has_path = 0;
    int outcome;
    memset(o, 0, sizeof *o);
    outcome = parse_terms(o, text);
    if (outcome != DONE) return outcome;
    for (int32_t k = 0; k < o->n_terms; ++k) has_path = has_path || o->kinds[k] == DQA_OBJECTIVE_PATH;
    if (has_path != (path_file != NULL)) {
        say(has_path ? "--objective path needs --path FILE with its points" : "--path is only for --objective path");
        return USAGE;
    }
    return has_path ? table_read(path_file, "m", &o->path, &o->n_path) : DONE;
}

void objective_free(objective* o) {
    free(o->path);
    memset(o, 0, sizeof *o);
}

int objective_terms(const objective* o, dqa_objective_term* terms) {
    for (int32_t k = 0; k < o->n_terms; ++k) {
        const int outcome = say_status(dqa_objective_term_init(&terms[k], sizeof terms[k]), "set up the objective");
        if (outcome != DONE) return outcome;
        terms[k].kind = o->kinds[k];
        terms[k].weight = o->weights[k];
        if (o->kinds[k] == DQA_OBJECTIVE_PATH) {
            terms[k].path = o->path;
            terms[k].n_path = o->n_path;
        }
    }
    return DONE;
}
