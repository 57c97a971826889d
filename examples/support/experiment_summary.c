/* SPDX-License-Identifier: MIT
 * summary.json of an experiment: what was asked, what each trial reached at which cost, and what that shows. */
#include "experiment.h"
#include "json.h"
#include "output.h"
#include "say.h"
#include "summary.h"

static void write_trial(json* j, const trial* t) {
    const run* r = &t->r;
    int64_t newton = 0, linear = 0, adjoint = 0;
    for (int64_t k = 0; k < r->iteration; ++k) {
        newton += r->rows[k].newton_iterations;
        linear += r->rows[k].linear_iterations;
        adjoint += r->rows[k].adjoint_iterations;
    }
    json_open(j, t->plan->name, '{');
    json_string(j, "method", t->plan->cma_es ? "cma-es" : "adam");
    json_string(j, "status", t->converged ? "converged" : "all iterations done");
    json_integer(j, "iterations", r->iteration);
    json_integer(j, "simulations", trial_simulations(t));
    json_boolean(j, "simulations_with_gradient", !t->plan->cma_es);
    json_number(j, "seconds", r->seconds);
    json_number(j, "cpu_seconds", r->cpu_before);
    json_integer(j, "newton_iterations", newton);
    json_integer(j, "linear_iterations", linear);
    json_integer(j, "adjoint_iterations", adjoint);
    json_number(j, "loss_first", r->rows[0].loss);
    json_number(j, "loss_last", r->rows[r->iteration - 1].loss);
    json_number(j, "loss_best", r->best_loss);
    summary_design(j, "first", r, 1);
    summary_design(j, "best", r, r->best_iteration);
    summary_design(j, "last", r, r->iteration);
    json_close(j, '}');
}

int experiment_summary(const experiment* e) {
    const trial* t = &e->trials[0];
    dqa_simulator_info info;
    output_file file;
    json j;
    double seconds = e->has_stage ? e->stage.r.seconds : 0.0;
    double cpu_seconds = e->has_stage ? e->stage.r.cpu_before : 0.0;
    int outcome = say_status(dqa_simulator_get_info(e->s.simulator, &info, sizeof info), "read the simulator");
    if (outcome == DONE) outcome = output_open(&file, e->o.out, SUMMARY_FILE);
    if (outcome != DONE) return outcome;
    for (int k = 0; k < e->n_trials; ++k) {
        seconds += e->trials[k].r.seconds;
        cpu_seconds += e->trials[k].r.cpu_before;
    }
    json_begin(&j, file.stream);
    summary_program(&j, e->plan->form->program);
    if (e->n_trials < e->plan->n_trials)
        json_string(&j, "all_shown", NULL);
    else
        json_boolean(&j, "all_shown", findings_hold(e->claims, e->n_claims));
    findings_write(&j, e->claims, e->n_claims);
    json_number(&j, "seconds", seconds);
    json_number(&j, "cpu_seconds", cpu_seconds);
    if (e->has_stage) {
        json_open(&j, "before", '{');
        write_trial(&j, &e->stage);
        json_close(&j, '}');
    }
    if (e->plan->tell != NULL) e->plan->tell(e, &j);
    json_open(&j, "bases", '[');
    for (int64_t i = 0; i < t->r.n_weights; ++i)
        json_string(&j, NULL, dqa_shape_space_base_name(e->s.space, (int32_t)i));
    json_close(&j, ']');
    json_open(&j, "trials", '{');
    for (int k = 0; k < e->n_trials; ++k) write_trial(&j, &e->trials[k]);
    json_close(&j, '}');
    json_open(&j, "gradient_check", '{');
    summary_proofs(&j, &t->r);
    json_close(&j, '}');
    summary_cells(&j, &e->o, &info);
    json_open(&j, "machine", '{');
    summary_machine(&j, &e->o);
    json_close(&j, '}');
    json_open(&j, "settings", '{');
    summary_settings(&j, &e->o, &t->r, &e->s);
    json_close(&j, '}');
    json_end(&j);
    return output_commit(&file);
}
