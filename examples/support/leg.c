/* SPDX-License-Identifier: MIT */
#include "leg.h"

#include <stdlib.h>
#include <string.h>

#include "checkpoint.h"
#include "hash.h"
#include "interrupt.h"
#include "memory_text.h"
#include "output.h"
#include "say.h"

static char* settings_of(const leg* l, const options* o, const char* what, const double* x, int64_t n) {
    char* common = checkpoint_settings(o);
    memory_text t;
    if (common == NULL) return NULL;
    memory_text_begin(&t);
    memory_text_add(&t, "%sleg %s of %s: %s from design %016llx\n", common, l->name, o->form->program, what,
                    (unsigned long long)hash_bytes(x, (size_t)n * sizeof *x));
    free(common);
    if (!t.failed) return t.text;
    memory_text_end(&t);
    (void)say_no_memory();
    return NULL;
}

static int open_leg(leg* l, const options* o, const scene* s, const char* what, const double* x, const double* rates) {
    const int64_t n_weights = s->n_weights, n = n_weights + s->n_control;
    int created = 0, outcome;
    l->folder = output_path(o->out, l->name);
    l->settings = settings_of(l, o, what, x, n);
    if (l->folder == NULL || l->settings == NULL) return FAILED;
    outcome = output_folder(l->folder, &created);
    if (outcome == DONE) outcome = run_create(&l->r, o, n_weights, x + n_weights, s->n_control, SCENE_OMEGA0);
    if (outcome != DONE) return outcome;
    l->has_run = 1;
    memcpy(l->r.x, x, (size_t)n_weights * sizeof *x);
    for (int64_t i = 0; i < n && rates != NULL; ++i) l->r.rates[i] *= rates[i < n_weights ? 0 : 1];
    if (!o->resume || !checkpoint_exists(l->folder)) return checkpoint_save(&l->r, l->settings, l->folder);
    outcome = checkpoint_load(&l->r, l->settings, l->folder);
    if (outcome == DONE) say("%s continues after iteration %lld", l->name, (long long)l->r.iteration);
    return outcome;
}

int leg_descend(leg* l, const options* o, scene* s, progress* p, const char* what, const double* x, const double* rates,
                int64_t iterations, int64_t before) {
    descent d = {&l->r, s, p, NULL, NULL, before};
    int outcome = open_leg(l, o, s, what, x, rates);
    d.settings = l->settings;
    d.out = l->folder;
    p->part_name = l->name;
    /* The clock of this leg stands while others run. */
    l->r.cpu_before -= progress_cpu();
    while (outcome == DONE && l->r.iteration < iterations) outcome = interrupted() ? INTERRUPTED : descent_iterate(&d);
    l->r.cpu_before += progress_cpu();
    return outcome;
}

void leg_free(leg* l) {
    if (l->has_run) run_free(&l->r);
    free(l->folder);
    free(l->settings);
    memset(l, 0, sizeof *l);
}

int64_t leg_simulations(const leg* l) {
    return l->r.iteration > 0 ? l->r.rows[l->r.iteration - 1].simulations : 0;
}
