/* SPDX-License-Identifier: MIT
 * Checkpoints. Text with hexadecimal floating-point numbers, which keep every bit and survive a change of machine;
 * the last line is a checksum of all before it, so that damage is found before anything is read. */
#define _POSIX_C_SOURCE 200809L
#include "checkpoint.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "hash.h"
#include "memory_text.h"
#include "output.h"
#include "progress.h"
#include "say.h"
#include "sealed_text.h"

#define MAGIC "codesign checkpoint 6\n"

char* checkpoint_settings(const options* o) {
    memory_text t;
    memory_text_begin(&t);
    memory_text_add(
        &t, "library %s\ngrid %dx%dx%d\nsigma %.17g\nrefinement %d\nsteps %" PRId64 "\ncontrol %s\nrate %d\nbases %d\n",
        dqa_version(), (int)o->grid[0], (int)o->grid[1], (int)o->grid[2], o->sigma, (int)o->refinement, o->steps,
        o->mlp             ? "mlp"
        : o->fixed_control ? "fixed"
                           : "free",
        (int)o->rate, (int)o->n_meshes);
    physics_add_settings(&o->laws, &t);
    if (o->model_error > 0.0)
        memory_text_add(&t, "model-error %.17g\n", o->model_error);
    else if (o->threshold >= 0.0)
        memory_text_add(&t, "threshold %.17g\n", o->threshold);
    else
        memory_text_add(&t, "threshold default\n");
    schedule_add_settings(&o->plan, &t);
    for (int32_t k = 0; k < o->loss.n_terms; ++k)
        memory_text_add(&t, "objective %s %.17g\n", objective_name(o->loss.kinds[k]), o->loss.weights[k]);
    if (o->loss.n_path > 0)
        memory_text_add(&t, "path %016" PRIx64 "\n", hash_bytes(o->loss.path, (size_t)o->loss.n_path * sizeof(double)));
    for (int32_t i = 0; i < o->n_meshes; ++i) {
        const char* slash = strrchr(o->meshes[i], '/');
        size_t size = 0;
        char* content = memory_text_read(o->meshes[i], &size);
        if (content == NULL) {
            memory_text_end(&t);
            return NULL;
        }
        memory_text_add(&t, "base-%d %s (content %016" PRIx64 ")\nweight-%d %.17g\n", (int)i + 1,
                        slash != NULL ? slash + 1 : o->meshes[i], hash_bytes(content, size), (int)i + 1, o->weights[i]);
        free(content);
    }
    for (int32_t i = 0; i < o->list.n_actuators; ++i) {
        const dqa_actuator_options* a = &o->list.actuators[i].options;
        memory_text_add(&t, "actuator-%d base %d kind %d category %d side %d layers %d lengths %s", (int)i + 1,
                        (int)o->list.actuators[i].base + 1, (int)a->kind, (int)a->category, (int)a->side,
                        (int)a->layers, o->list.actuators[i].own ? "own" : "longest");
        for (int k = 0; k < 3; ++k) memory_text_add(&t, " %.17g %.17g %.17g", a->mean[k], a->variance[k], a->euler[k]);
        memory_text_add(&t, "\n");
    }
    if (t.failed) {
        memory_text_end(&t);
        (void)say_no_memory();
        return NULL;
    }
    return t.text;
}

static int path_of(const char* folder, char** path) {
    *path = output_path(folder, CHECKPOINT_FILE);
    return *path != NULL ? DONE : FAILED;
}

int checkpoint_exists(const char* folder) {
    struct stat found;
    char* path;
    int exists;
    if (path_of(folder, &path) != DONE) return 0;
    exists = stat(path, &found) == 0;
    free(path);
    return exists;
}

/* ------------------------------------------------------------------ writing */
static void put_numbers(memory_text* t, const char* name, const double* x, int64_t n) {
    memory_text_add(t, "%s", name);
    for (int64_t i = 0; i < n; ++i) memory_text_add(t, " %a", x[i]);
    memory_text_add(t, "\n");
}

static void put_proof(memory_text* t, const char* name, const gradient_proof* proof) {
    const dqa_gradient_check_report* c = &proof->report;
    const double numbers[6] = {c->adjoint,      c->finite_difference, c->relative_error,
                               c->taylor_slope, c->gradient_norm,     c->step};
    memory_text_add(t, "%s %d %d", name, proof->state, (int)c->one_sided);
    put_numbers(t, "", numbers, 6);
}

int checkpoint_save(const run* r, const char* settings, const char* folder) {
    memory_text t;
    const double cpu_seconds = r->cpu_before + progress_cpu();
    memory_text_begin(&t);
    memory_text_add(&t, "%s%s%s", MAGIC, settings, CHECKPOINT_SETTINGS_END);
    memory_text_add(
        &t, "unknowns %" PRId64 " %" PRId64 "\niteration %" PRId64 " best %" PRId64 " stage %d from %" PRId64 "\n",
        r->n_weights, r->n_control, r->iteration, r->best_iteration, (int)r->stage, r->stage_first);
    put_numbers(&t, "seconds", &r->seconds, 1);
    put_numbers(&t, "cpu-seconds", &cpu_seconds, 1);
    put_numbers(&t, "best-loss", &r->best_loss, 1);
    put_numbers(&t, "x", r->x, r->n);
    put_numbers(&t, "first-moment", r->first_moment, r->n);
    put_numbers(&t, "second-moment", r->second_moment, r->n);
    put_numbers(&t, "best-x", r->best_x, r->n);
    put_numbers(&t, "gradient", r->gradient, r->n);
    put_proof(&t, "proof-weights", &r->proof_weights);
    put_proof(&t, "proof-control", &r->proof_control);
    for (int64_t k = 0; k < r->iteration; ++k) {
        const history_row* row = &r->rows[k];
        const double numbers[7] = {row->loss,    row->gradient_weights, row->gradient_control,
                                   row->seconds, row->cpu_seconds,      row->place,
                                   row->heading};
        memory_text_add(&t, "row %" PRId64 " %d %" PRId64 " %" PRId64 " %" PRId64 " %" PRId64, row->iteration,
                        (int)row->stage, row->simulations, row->newton_iterations, row->linear_iterations,
                        row->adjoint_iterations);
        put_numbers(&t, "", numbers, 7);
        put_numbers(&t, "terms", row->terms, OBJECTIVE_KINDS);
        put_numbers(&t, "at", r->row_x + k * r->n, r->n);
    }
    return sealed_text_write(&t, folder, CHECKPOINT_FILE);
}

/* ------------------------------------------------------------------ reading */
/* A cursor over the text; `bad` stays set once anything was not as expected, which has then been said. */
typedef struct cursor {
    const char* at;
    int64_t row; /* that is being read, from 1; 0: what stands before the rows */
    int bad;
} cursor;

/* Says what came for `name` and what was expected; the line end is no part of what came. */
static void refuse(cursor* c, const char* name, const char* came, const char* expected) {
    const int length = (int)strcspn(came, " \n");
    if (c->bad) return;
    c->bad = 1;
    if (c->row > 0)
        say("the checkpoint's row %" PRId64 ": %s is \"%.*s\", expected %s; start without --resume", c->row, name,
            length < 40 ? length : 40, came, expected);
    else
        say("the checkpoint: %s is \"%.*s\", expected %s; start without --resume", name, length < 40 ? length : 40,
            came, expected);
}

static void expect_word(cursor* c, const char* word) {
    const size_t length = strlen(word);
    if (c->bad) return;
    c->at += strspn(c->at, " \n");
    if (strncmp(c->at, word, length) != 0 || c->at[length] == '\0' || strchr(" \n", c->at[length]) == NULL)
        refuse(c, "the next word", c->at, word);
    else
        c->at += length;
}

static int64_t next_integer(cursor* c, const char* name, int64_t least, int64_t most) {
    char expected[64];
    char* end = NULL;
    long long value;
    if (c->bad) return least;
    c->at += strspn(c->at, " \n");
    errno = 0;
    value = strtoll(c->at, &end, 10);
    if (end == c->at || strchr(" \n", *end) == NULL || errno != 0 || value < least || value > most) {
        (void)snprintf(expected, sizeof expected, "a whole number of %" PRId64 " ... %" PRId64, least, most);
        refuse(c, name, c->at, expected);
        return least;
    }
    c->at = end;
    return (int64_t)value;
}

#define NUMBER_ANY 0 /* also infinite or none, as a ratio to nothing is */
#define NUMBER_FINITE 1
#define NUMBER_NOT_NEGATIVE 2 /* and finite */

static void next_numbers(cursor* c, const char* name, double* x, int64_t n, int kind) {
    for (int64_t i = 0; i < n && !c->bad; ++i) {
        char* end = NULL;
        c->at += strspn(c->at, " \n");
        x[i] = strtod(c->at, &end);
        if (end == c->at || (kind != NUMBER_ANY && !isfinite(x[i])) || (kind == NUMBER_NOT_NEGATIVE && x[i] < 0.0))
            refuse(c, name, c->at, kind == NUMBER_NOT_NEGATIVE ? "a number >= 0" : "a finite number");
        else
            c->at = end;
    }
}

static void named_numbers(cursor* c, const char* name, double* x, int64_t n, int kind) {
    expect_word(c, name);
    next_numbers(c, name, x, n, kind);
}

/* A design has its weights on the simplex. */
static void next_design(cursor* c, const char* name, double* x, const run* r) {
    double sum = 0.0;
    const char* start;
    expect_word(c, name);
    start = c->bad ? NULL : c->at + strspn(c->at, " \n");
    next_numbers(c, name, x, r->n_weights, NUMBER_NOT_NEGATIVE);
    for (int64_t i = 0; i < r->n_weights && !c->bad; ++i) sum += x[i];
    if (!c->bad && fabs(sum - 1.0) > 1e-6) refuse(c, name, start, "weights that sum to one");
    next_numbers(c, name, x + r->n_weights, r->n_control, NUMBER_FINITE);
}

static void next_proof(cursor* c, const char* name, gradient_proof* proof) {
    double numbers[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    expect_word(c, name);
    memset(proof, 0, sizeof *proof);
    proof->state = (int)next_integer(c, name, PROOF_OPEN, PROOF_FAILED);
    proof->report.one_sided = (int32_t)next_integer(c, name, 0, 1);
    next_numbers(c, name, numbers, 6, NUMBER_ANY);
    proof->report.adjoint = numbers[0];
    proof->report.finite_difference = numbers[1];
    proof->report.relative_error = numbers[2];
    proof->report.taylor_slope = numbers[3];
    proof->report.gradient_norm = numbers[4];
    proof->report.step = numbers[5];
}

static void next_row(cursor* c, const run* r, history_row* row, double* x) {
    double numbers[7] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    static const int kinds[7] = {NUMBER_FINITE,       NUMBER_NOT_NEGATIVE, NUMBER_NOT_NEGATIVE, NUMBER_NOT_NEGATIVE,
                                 NUMBER_NOT_NEGATIVE, NUMBER_FINITE,       NUMBER_FINITE};
    static const char* const names[7] = {"the loss",
                                         "the gradient of the weights",
                                         "the gradient of the controller",
                                         "seconds",
                                         "cpu-seconds",
                                         "the place",
                                         "the heading"};
    expect_word(c, "row");
    row->iteration = next_integer(c, "the iteration", c->row, c->row);
    row->stage = (int32_t)next_integer(c, "the stage", 0, r->stage);
    row->simulations = next_integer(c, "simulations", 0, INT64_MAX);
    row->newton_iterations = next_integer(c, "Newton iterations", 0, INT64_MAX);
    row->linear_iterations = next_integer(c, "linear iterations", 0, INT64_MAX);
    row->adjoint_iterations = next_integer(c, "adjoint iterations", 0, INT64_MAX);
    for (int k = 0; k < 7; ++k) next_numbers(c, names[k], numbers + k, 1, kinds[k]);
    row->loss = numbers[0];
    row->gradient_weights = numbers[1];
    row->gradient_control = numbers[2];
    row->seconds = numbers[3];
    row->cpu_seconds = numbers[4];
    row->place = numbers[5];
    row->heading = numbers[6];
    named_numbers(c, "terms", row->terms, OBJECTIVE_KINDS, NUMBER_FINITE);
    next_design(c, "at", x, r);
}

/* Every field is checked, and against the others: a text may have the right checksum and have been written by anyone.
 */
static int parse_state(run* r, const char* text) {
    cursor c = {text, 0, 0};
    const char* best_at;
    int64_t rows;
    expect_word(&c, "unknowns");
    (void)next_integer(&c, "the number of weights", r->n_weights, r->n_weights);
    (void)next_integer(&c, "the number of controller parameters", r->n_control, r->n_control);
    expect_word(&c, "iteration");
    rows = next_integer(&c, "iteration", 0, INT32_MAX);
    expect_word(&c, "best");
    c.at += c.bad ? 0 : strspn(c.at, " \n");
    best_at = c.at;
    r->best_iteration = next_integer(&c, "best", 0, rows);
    expect_word(&c, "stage");
    r->stage = (int32_t)next_integer(&c, "stage", 0, r->n_stages - 1);
    expect_word(&c, "from");
    r->stage_first = next_integer(&c, "the first iteration of the stage", 0, rows);
    /* A best design there is once the stage has an iteration, and it is one of its own. */
    if (rows > r->stage_first ? r->best_iteration <= r->stage_first : r->best_iteration != 0)
        refuse(&c, "best", best_at, "an iteration of the last stage, 0 if it has none");
    named_numbers(&c, "seconds", &r->seconds, 1, NUMBER_NOT_NEGATIVE);
    named_numbers(&c, "cpu-seconds", &r->cpu_before, 1, NUMBER_NOT_NEGATIVE);
    named_numbers(&c, "best-loss", &r->best_loss, 1, r->best_iteration > 0 ? NUMBER_FINITE : NUMBER_ANY);
    if (r->best_iteration == 0) r->best_loss = HUGE_VAL;
    next_design(&c, "x", r->x, r);
    named_numbers(&c, "first-moment", r->first_moment, r->n, NUMBER_FINITE);
    named_numbers(&c, "second-moment", r->second_moment, r->n, NUMBER_NOT_NEGATIVE);
    named_numbers(&c, "best-x", r->best_x, r->n, NUMBER_FINITE);
    named_numbers(&c, "gradient", r->gradient, r->n, NUMBER_FINITE);
    next_proof(&c, "proof-weights", &r->proof_weights);
    next_proof(&c, "proof-control", &r->proof_control);
    for (r->iteration = 0; r->iteration < rows && !c.bad; ++r->iteration) {
        if (run_reserve(r) != DONE) return FAILED;
        c.row = r->iteration + 1;
        next_row(&c, r, &r->rows[r->iteration], r->row_x + r->iteration * r->n);
    }
    c.row = 0;
    if (!c.bad && c.at[strspn(c.at, " \n")] != '\0') refuse(&c, "what follows the rows", c.at + 1, "its end");
    if (!c.bad && r->best_iteration > 0 &&
        (r->best_loss != r->rows[r->best_iteration - 1].loss ||
         memcmp(r->best_x, r->row_x + (r->best_iteration - 1) * r->n, (size_t)r->n * sizeof(double)) != 0))
        refuse(&c, "best", best_at, "the iteration whose loss and design are best-loss and best-x");
    return c.bad ? FAILED : DONE;
}

/* Length of the line that begins at `text`, without its end. */
static size_t line_length(const char* text) {
    return strcspn(text, "\n");
}

int checkpoint_compare(const char* found, const char* wanted) {
    while (*found != '\0' && *wanted != '\0') {
        const size_t a = line_length(found), b = line_length(wanted);
        if (a != b || strncmp(found, wanted, a) != 0) {
            say("the checkpoint belongs to other settings: it has \"%.*s\", this run \"%.*s\"", (int)a, found, (int)b,
                wanted);
            return USAGE;
        }
        found += a + (found[a] == '\n');
        wanted += b + (wanted[b] == '\n');
    }
    if (*found != *wanted) {
        say("the checkpoint belongs to other settings");
        return USAGE;
    }
    return DONE;
}

int checkpoint_load(run* r, const char* settings, const char* folder) {
    char* text = sealed_text_read(folder, CHECKPOINT_FILE, MAGIC);
    char* end = text != NULL ? strstr(text, CHECKPOINT_SETTINGS_END) : NULL;
    int outcome = FAILED;
    if (end != NULL) {
        *end = '\0';
        outcome = checkpoint_compare(text + strlen(MAGIC), settings);
        if (outcome == DONE) outcome = parse_state(r, end + strlen(CHECKPOINT_SETTINGS_END));
    } else if (text != NULL) {
        say("the checkpoint in %s does not hold what it should; start without --resume", folder);
    }
    free(text);
    return outcome;
}
