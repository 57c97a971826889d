/* SPDX-License-Identifier: MIT */
#include "bases.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "input.h"
#include "say.h"

#define LINE_SIZE 4096
#define DEGREE (3.14159265358979323846 / 180.0)
#define TWO_LN_2 1.3862943611198906 /* half length of a box: sqrt(2 ln 2 * variance) */

/* Where the parser stands. */
typedef struct reader {
    const char* path;
    int line;
    int32_t base; /* of the open block; -1 before the first */
    int own;      /* lengths are relative to those of each animal */
    bases* list;
    int (*add_mesh)(void* context, const char* mesh);
    void* context;
} reader;

static const char blanks[] = " \t\r\n";

/* The next word of *rest, ended by a zero; NULL at the end of the line. */
static char* next_word(char** rest) {
    char* word = *rest + strspn(*rest, blanks);
    char* end = word + strcspn(word, blanks);
    if (*word == '\0') return NULL;
    *rest = *end != '\0' ? end + 1 : end;
    *end = '\0';
    return word;
}

static int read_number(const reader* r, const char* field, char** rest, double* value) {
    char* end = NULL;
    const char* word = next_word(rest);
    if (word != NULL) *value = strtod(word, &end);
    if (word == NULL || end == word || *end != '\0' || !isfinite(*value)) {
        say("%s:%d: %s expects a number, not \"%s\"", r->path, r->line, field, word != NULL ? word : "end of line");
        return USAGE;
    }
    return DONE;
}

static int read_numbers(const reader* r, const char* field, char** rest, double values[3]) {
    int outcome = DONE;
    for (int k = 0; k < 3 && outcome == DONE; ++k) outcome = read_number(r, field, rest, &values[k]);
    return outcome;
}

static int read_integer(const reader* r, const char* field, char** rest, int32_t least, int32_t most, int32_t* value) {
    double number = 0.0;
    const int outcome = read_number(r, field, rest, &number);
    if (outcome != DONE) return outcome;
    if (!(number >= least && number <= most) || number != floor(number)) {
        say("%s:%d: %s expects a whole number from %d to %d, not %g", r->path, r->line, field, (int)least, (int)most,
            number);
        return USAGE;
    }
    *value = (int32_t)number;
    return DONE;
}

static int read_side(const reader* r, char** rest, int32_t* side) {
    const char* word = next_word(rest);
    if (word != NULL && strcmp(word, "left") == 0) {
        *side = DQA_SIDE_LEFT;
    } else if (word != NULL && strcmp(word, "right") == 0) {
        *side = DQA_SIDE_RIGHT;
    } else {
        say("%s:%d: side expects left or right, not \"%s\"", r->path, r->line, word != NULL ? word : "end of line");
        return USAGE;
    }
    return DONE;
}

/* The fields of an actuator, in any order. */
static int read_fields(const reader* r, char* rest, dqa_actuator_options* o) {
    double half[3] = {0.0, 0.0, 0.0}, degrees[3] = {0.0, 0.0, 0.0};
    const int fins = o->kind == DQA_ACTUATOR_FINS;
    int has_mean = 0, has_half = 0;
    const char* word;
    while ((word = next_word(&rest)) != NULL) {
        int outcome;
        if (strcmp(word, "mean") == 0) {
            outcome = read_numbers(r, word, &rest, o->mean);
            has_mean = 1;
        } else if (strcmp(word, "half") == 0) {
            outcome = read_numbers(r, word, &rest, half);
            has_half = 1;
        } else if (strcmp(word, "angles") == 0) {
            outcome = read_numbers(r, word, &rest, degrees);
        } else if (strcmp(word, "category") == 0) {
            outcome = read_integer(r, word, &rest, 0, 15, &o->category);
        } else if (fins && strcmp(word, "layers") == 0) {
            outcome = read_integer(r, word, &rest, 1, 4, &o->layers);
        } else if (fins && strcmp(word, "side") == 0) {
            outcome = read_side(r, &rest, &o->side);
        } else {
            say("%s:%d: expected mean, half, angles, category%s, not \"%s\"", r->path, r->line,
                fins ? ", layers or side" : "", word);
            outcome = USAGE;
        }
        if (outcome != DONE) return outcome;
    }
    if (!has_mean || !has_half) {
        say("%s:%d: the actuator needs \"%s\" with three lengths in metres", r->path, r->line,
            has_mean ? "half" : "mean");
        return USAGE;
    }
    for (int k = 0; k < 3; ++k) {
        if (!(half[k] > 0.0)) {
            say("%s:%d: half expects three lengths > 0, not %g", r->path, r->line, half[k]);
            return USAGE;
        }
        o->variance[k] = half[k] * half[k] / TWO_LN_2;
        o->euler[k] = degrees[k] * DEGREE;
    }
    return DONE;
}

static int read_actuator(reader* r, int32_t kind, char* rest) {
    bases* b = r->list;
    bases_actuator *grown, *a;
    int outcome;
    if (r->base < 0) {
        say("%s:%d: an actuator before the first base", r->path, r->line);
        return USAGE;
    }
    if (b->n_actuators == BASES_MAX_ACTUATORS) {
        say("%s:%d: more than %d actuators", r->path, r->line, BASES_MAX_ACTUATORS);
        return USAGE;
    }
    grown = realloc(b->actuators, ((size_t)b->n_actuators + 1) * sizeof *grown);
    if (grown == NULL) return say_no_memory();
    b->actuators = grown;
    a = &grown[b->n_actuators];
    a->base = r->base;
    a->line = r->line;
    a->own = r->own;
    outcome = say_status(dqa_actuator_options_init(&a->options, sizeof a->options), "set up an actuator");
    if (outcome != DONE) return outcome;
    a->options.kind = kind;
    a->options.category = kind == DQA_ACTUATOR_FINS ? 1 : 0;
    outcome = read_fields(r, rest, &a->options);
    if (outcome == DONE) ++b->n_actuators;
    return outcome;
}

/* The rest of the line is the path, so that it may hold blanks. */
static int read_base(reader* r, char* rest) {
    char* mesh = rest + strspn(rest, blanks);
    size_t length = strlen(mesh);
    const char* slash = strrchr(r->path, '/');
    const size_t folder = slash != NULL ? (size_t)(slash - r->path) + 1 : 0;
    char* whole;
    int outcome;
    while (length > 0 && strchr(blanks, mesh[length - 1]) != NULL) mesh[--length] = '\0';
    if (length == 0) {
        say("%s:%d: base expects the path of a mesh", r->path, r->line);
        return USAGE;
    }
    whole = malloc(folder + length + 1);
    if (whole == NULL) return say_no_memory();
    whole[0] = '\0';
    if (mesh[0] != '/') {
        memcpy(whole, r->path, folder);
        whole[folder] = '\0';
    }
    strcat(whole, mesh);
    outcome = r->add_mesh(r->context, whole);
    free(whole);
    ++r->base;
    return outcome;
}

static int read_lengths(reader* r, char* rest) {
    const char* word = next_word(&rest);
    if (word == NULL || (strcmp(word, "own") != 0 && strcmp(word, "longest") != 0) || next_word(&rest) != NULL) {
        say("%s:%d: lengths expects own or longest, not \"%s\"", r->path, r->line, word != NULL ? word : "end of line");
        return USAGE;
    }
    r->own = strcmp(word, "own") == 0;
    return DONE;
}

static int read_line(reader* r, char* line) {
    char *rest = line, *comment = strchr(line, '#');
    const char* word;
    if (comment != NULL) *comment = '\0';
    word = next_word(&rest);
    if (word == NULL) return DONE;
    if (strcmp(word, "base") == 0) return read_base(r, rest);
    if (strcmp(word, "caudal") == 0) return read_actuator(r, DQA_ACTUATOR_CAUDAL, rest);
    if (strcmp(word, "fins") == 0) return read_actuator(r, DQA_ACTUATOR_FINS, rest);
    if (strcmp(word, "lengths") == 0) return read_lengths(r, rest);
    say("%s:%d: expected base, caudal, fins or lengths, not \"%s\"", r->path, r->line, word);
    return USAGE;
}

int bases_read(bases* b, const char* path, int (*add_mesh)(void* context, const char* mesh), void* context) {
    reader r = {path, 0, b->n_bases - 1, 0, b, add_mesh, context};
    char line[LINE_SIZE];
    FILE* stream = input_open(path);
    int outcome = DONE;
    if (stream == NULL) return FAILED;
    while (outcome == DONE && fgets(line, sizeof line, stream) != NULL) {
        ++r.line;
        if (strchr(line, '\n') == NULL && !feof(stream)) {
            say("%s:%d: the line is longer than %d characters", path, r.line, LINE_SIZE - 2);
            outcome = USAGE;
        } else {
            outcome = read_line(&r, line);
        }
    }
    if (outcome == DONE && ferror(stream)) {
        say("cannot read the list %s", path);
        outcome = FAILED;
    }
    (void)fclose(stream);
    if (outcome == DONE && r.base < b->n_bases) {
        say("the list %s names no base; a block begins with a line \"base mesh.stl\"", path);
        outcome = USAGE;
    }
    b->n_bases = r.base + 1;
    return outcome;
}

int bases_add_actuators(const bases* b, const char* path, const double* lengths, dqa_shape_space* space) {
    int outcome = DONE;
    for (int32_t i = 0; i < b->n_actuators && outcome == DONE; ++i) {
        const bases_actuator* a = &b->actuators[i];
        const double length = a->own && lengths != NULL ? lengths[a->base] : 1.0;
        dqa_actuator_options options = a->options;
        char doing[512];
        for (int k = 0; k < 3; ++k) {
            options.mean[k] *= length;
            options.variance[k] *= length * length;
        }
        (void)snprintf(doing, sizeof doing, "use the actuator in line %d of %s", a->line, path);
        outcome = say_status(dqa_shape_space_add_actuator(space, a->base, &options), doing);
    }
    return outcome;
}

void bases_free(bases* b) {
    free(b->actuators);
    b->actuators = NULL;
    b->n_actuators = b->n_bases = 0;
}
