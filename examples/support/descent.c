/* SPDX-License-Identifier: MIT
 * Going down the gradient. */
#include "descent.h"

#include <stdlib.h>
#include <string.h>

#include "checkpoint.h"
#include "history.h"
#include "say.h"

/* The gradient is proven once, before it is trusted. */
static int prove_one(const descent* d, int32_t with_respect_to, const char* of, gradient_proof* proof) {
    const double started = progress_clock();
    int outcome;
    if (proof->state != PROOF_OPEN) return DONE;
    outcome = scene_prove(d->s, with_respect_to, of, proof, d->p);
    if (outcome != DONE) return outcome;
    if (proof->state == PROOF_MADE && !(proof->report.relative_error <= 1e-6))
        say("warning: the gradient of the %s differs from finite differences by a relative %.1e", of,
            proof->report.relative_error);
    d->r->seconds += progress_clock() - started;
    return checkpoint_save(d->r, d->settings, d->out);
}

int descent_prove(const descent* d) {
    gradient_proof *weights = &d->r->proof_weights, *control = &d->r->proof_control;
    int outcome = scene_set(d->s, d->r->x, d->p);
    /* A single base cannot vary. */
    if (outcome == DONE && d->r->n_weights > 1) outcome = prove_one(d, DQA_WRT_WEIGHTS, "weights", weights);
    if (outcome == DONE) outcome = prove_one(d, DQA_WRT_CONTROL, "controller", control);
    return outcome;
}

int descent_finish(const descent* d, const history_row* row, int64_t units) {
    const run* r = d->r;
    int outcome;
    d->r->seconds += row->seconds;
    /* The table first: a checkpoint never claims an iteration that the table lacks. */
    outcome = history_write(r, d->s->space, d->out);
    if (outcome == DONE) outcome = checkpoint_save(r, d->settings, d->out);
    if (outcome == DONE) progress_iteration(d->p, d->before + units, row->loss, r->best_loss, row->seconds);
    return outcome;
}

int descent_iterate(const descent* d) {
    run* r = d->r;
    history_row row = {0};
    double* gradient = malloc((size_t)r->n * sizeof *gradient);
    int outcome = gradient != NULL ? DONE : say_no_memory();
    if (outcome == DONE && run_repeats(r, &row)) {
        memcpy(gradient, r->gradient, (size_t)r->n * sizeof *gradient);
    } else if (outcome == DONE) {
        outcome = scene_evaluate(d->s, r->x, gradient, &row, d->p);
        row.simulations = 1 + (r->iteration > 0 ? r->rows[r->iteration - 1].simulations : 0);
    }
    if (outcome == DONE) {
        row.iteration = r->iteration + 1;
        row.stage = r->stage;
        row.cpu_seconds = r->cpu_before + progress_cpu();
        outcome = run_advance(r, &row, gradient);
    }
    free(gradient);
    return outcome == DONE ? descent_finish(d, &row, r->iteration) : outcome;
}
