/* SPDX-License-Identifier: MIT
 * One optimisation of an experiment. */
#include "trial.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "checkpoint.h"
#include "evolution.h"
#include "hash.h"
#include "interrupt.h"
#include "memory_text.h"
#include "output.h"
#include "say.h"

int trial_exists(const trial_plan* plan, const char* out) {
    char* folder = output_path(out, plan->name);
    const int found = folder != NULL && checkpoint_exists(folder);
    free(folder);
    return found;
}

static int64_t planned(const trial_plan* plan, const options* o) {
    return plan->cma_es ? o->generations : o->iterations * (plan->times > 0 ? plan->times : 1);
}

int64_t trial_units(const trial_plan* plan, const options* o, int64_t population) {
    return planned(plan, o) * (plan->cma_es ? population : 1);
}

/* What the checkpoint belongs to: the scene, its first design, and the method. */
static char* settings_of(const trial_plan* plan, const options* o, const scene* s, const double* theta,
                         const double* network) {
    char* common = checkpoint_settings(o);
    memory_text t;
    if (common == NULL) return NULL;
    memory_text_begin(&t);
    memory_text_add(&t, "%strial %s of %s: moves %d, %s, from %.17g %.17g %.17g%s\n", common, plan->name,
                    o->form->program, plan->moves, plan->cma_es ? "cma-es" : "adam", theta[0], theta[1], theta[2],
                    plan->no_encoding ? ", without encoding" : "");
    if (network != NULL)
        memory_text_add(&t, "network %016llx\n",
                        (unsigned long long)hash_bytes(network, (size_t)s->n_control * sizeof *network));
    free(common);
    if (t.failed) {
        memory_text_end(&t);
        (void)say_no_memory();
        return NULL;
    }
    return t.text;
}

static int create_run(trial* t, const scene* s, const double* theta, const double* network) {
    double* start = malloc((size_t)s->n_control * sizeof *start);
    int outcome = DONE;
    if (start == NULL) return say_no_memory();
    for (int64_t i = 0; i < s->n_control; ++i) start[i] = theta[i % 3];
    if (network != NULL)
        memcpy(start, network, (size_t)s->n_control * sizeof *start);
    else if (t->o.mlp)
        outcome = say_status(dqa_controller_get_parameters(s->controller, start, s->n_control), "read the controller");
    if (outcome == DONE) outcome = run_create(&t->r, &t->o, s->n_weights, start, s->n_control, SCENE_OMEGA0);
    free(start);
    if (outcome != DONE) return outcome;
    t->has_run = 1;
    t->r.moves = t->plan->moves;
    for (int64_t i = 0; i < s->n_control && t->o.mlp && t->plan->network_rate > 0.0; ++i)
        t->r.rates[s->n_weights + i] = t->plan->network_rate;
    return DONE;
}

int trial_enter(const trial* t, scene* s) {
    return t->o.mlp ? scene_use_network(s, !t->plan->no_encoding) : DONE;
}

int trial_open(trial* t, const trial_plan* plan, const options* o, scene* s, const double* theta,
               const double* network) {
    int outcome, created = 0;
    memset(t, 0, sizeof *t);
    t->plan = plan;
    t->o = *o;
    if (plan->weights != NULL) memcpy(t->o.weights, plan->weights, (size_t)s->n_weights * sizeof(double));
    outcome = trial_enter(t, s);
    if (outcome != DONE) return outcome;
    t->folder = output_path(o->out, plan->name);
    t->settings = settings_of(plan, &t->o, s, theta, network);
    if (t->folder == NULL || t->settings == NULL) return FAILED;
    outcome = output_folder(t->folder, &created);
    if (outcome == DONE) outcome = create_run(t, s, theta, network);
    if (outcome == DONE && o->resume && checkpoint_exists(t->folder)) {
        outcome = checkpoint_load(&t->r, t->settings, t->folder);
        if (outcome == DONE) say("%s continues after iteration %lld", plan->name, (long long)t->r.iteration);
    }
    return outcome;
}

int trial_run(trial* t, scene* s, progress* p, int64_t before, int proves) {
    const descent d = {&t->r, s, p, t->settings, t->folder, before};
    const int64_t end = planned(t->plan, &t->o);
    int outcome = trial_enter(t, s);
    /* The clock of this trial stands while others run. */
    t->r.cpu_before -= progress_cpu();
    if (t->plan->cma_es) {
        if (outcome == DONE) outcome = evolution_open(&d, &t->search);
        /* A checkpoint without a generation: a folder that cannot be written is found out early. */
        if (outcome == DONE && t->r.iteration == 0) outcome = checkpoint_save(&t->r, t->settings, t->folder);
        while (outcome == DONE && t->r.iteration < end && !(t->converged = evolution_converged(t->search)))
            outcome = interrupted() ? INTERRUPTED : evolution_generation(&d, t->search);
    } else {
        if (outcome == DONE && t->r.iteration == 0) outcome = checkpoint_save(&t->r, t->settings, t->folder);
        if (outcome == DONE && proves && t->r.iteration == 0) outcome = descent_prove(&d);
        /* The proof is no part of the optimisation. */
        if (t->r.iteration == 0) t->r.cpu_before = -progress_cpu();
        while (outcome == DONE && t->r.iteration < end && !(t->converged = run_converged(&t->r)))
            outcome = interrupted() ? INTERRUPTED : descent_iterate(&d);
    }
    /* So that nothing that follows counts as time of this trial. */
    t->r.cpu_before += progress_cpu();
    return outcome;
}

void trial_free(trial* t) {
    dqa_cma_es_free(t->search);
    if (t->has_run) run_free(&t->r);
    free(t->folder);
    free(t->settings);
    memset(t, 0, sizeof *t);
}

double trial_best_within(const trial* t, int64_t n) {
    double best = HUGE_VAL;
    for (int64_t k = 0; k < t->r.iteration && t->r.rows[k].simulations <= n; ++k) best = fmin(best, t->r.rows[k].loss);
    return best;
}

int64_t trial_simulations(const trial* t) {
    return t->r.iteration > 0 ? t->r.rows[t->r.iteration - 1].simulations : 0;
}
