/* SPDX-License-Identifier: MIT
 * Checkpoints. Text with hexadecimal floating-point numbers, which keep every bit and survive a change of machine;
 * the last line is a checksum of all before it, so that damage is found before anything is read. */
#include "checkpoint.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
    char* path;
    FILE* stream;
    if (path_of(folder, &path) != DONE) return 0;
    stream = fopen(path, "rb");
    free(path);
    if (stream == NULL) return 0;
    (void)fclose(stream);
    return 1;
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
/* A cursor over the text; `bad` stays set once anything was not as expected. */
typedef struct cursor {
    const char* at;
    int bad;
} cursor;

static void expect_word(cursor* c, const char* word) {
    const size_t length = strlen(word);
    if (c->bad) return;
    c->at += strspn(c->at, " \n");
    if (strncmp(c->at, word, length) != 0 || strchr(" \n", c->at[length]) == NULL)
        c->bad = 1;
    else
        c->at += length;
}

static int64_t next_integer(cursor* c) {
    char* end = NULL;
    const long long value = c->bad ? 0 : strtoll(c->at, &end, 10);
    if (end == c->at || end == NULL)
        c->bad = 1;
    else
        c->at = end;
    return c->bad ? 0 : (int64_t)value;
}

static void next_numbers(cursor* c, double* x, int64_t n) {
    for (int64_t i = 0; i < n && !c->bad; ++i) {
        char* end = NULL;
        x[i] = strtod(c->at, &end);
        if (end == c->at)
            c->bad = 1;
        else
            c->at = end;
    }
}

static void named_numbers(cursor* c, const char* name, double* x, int64_t n) {
    expect_word(c, name);
    next_numbers(c, x, n);
}

static void next_proof(cursor* c, const char* name, gradient_proof* proof) {
    double numbers[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    expect_word(c, name);
    memset(proof, 0, sizeof *proof);
    proof->state = (int)next_integer(c);
    proof->report.one_sided = (int32_t)next_integer(c);
    next_numbers(c, numbers, 6);
    proof->report.adjoint = numbers[0];
    proof->report.finite_difference = numbers[1];
    proof->report.relative_error = numbers[2];
    proof->report.taylor_slope = numbers[3];
    proof->report.gradient_norm = numbers[4];
    proof->report.step = numbers[5];
}

static int parse_state(run* r, const char* text) {
    cursor c = {text, 0};
    int64_t rows;
    expect_word(&c, "unknowns");
    if (next_integer(&c) != r->n_weights || next_integer(&c) != r->n_control) c.bad = 1;
    expect_word(&c, "iteration");
    rows = next_integer(&c);
    expect_word(&c, "best");
    r->best_iteration = next_integer(&c);
    expect_word(&c, "stage");
    r->stage = (int32_t)next_integer(&c);
    expect_word(&c, "from");
    r->stage_first = next_integer(&c);
    named_numbers(&c, "seconds", &r->seconds, 1);
    named_numbers(&c, "cpu-seconds", &r->cpu_before, 1);
    named_numbers(&c, "best-loss", &r->best_loss, 1);
    named_numbers(&c, "x", r->x, r->n);
    named_numbers(&c, "first-moment", r->first_moment, r->n);
    named_numbers(&c, "second-moment", r->second_moment, r->n);
    named_numbers(&c, "best-x", r->best_x, r->n);
    named_numbers(&c, "gradient", r->gradient, r->n);
    next_proof(&c, "proof-weights", &r->proof_weights);
    next_proof(&c, "proof-control", &r->proof_control);
    for (r->iteration = 0; r->iteration < rows && !c.bad; ++r->iteration) {
        double numbers[7] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
        history_row* row;
        if (run_reserve(r) != DONE) return FAILED;
        row = &r->rows[r->iteration];
        expect_word(&c, "row");
        row->iteration = next_integer(&c);
        row->stage = (int32_t)next_integer(&c);
        row->simulations = next_integer(&c);
        row->newton_iterations = next_integer(&c);
        row->linear_iterations = next_integer(&c);
        row->adjoint_iterations = next_integer(&c);
        next_numbers(&c, numbers, 7);
        row->loss = numbers[0];
        row->gradient_weights = numbers[1];
        row->gradient_control = numbers[2];
        row->seconds = numbers[3];
        row->cpu_seconds = numbers[4];
        row->place = numbers[5];
        row->heading = numbers[6];
        named_numbers(&c, "terms", row->terms, OBJECTIVE_KINDS);
        named_numbers(&c, "at", r->row_x + r->iteration * r->n, r->n);
    }
    if (c.bad) say("the checkpoint does not hold what it should; start without --resume");
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
