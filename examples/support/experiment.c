/* SPDX-License-Identifier: MIT
 * The way through an experiment: options, scene, trials one after the other, results. */
#include "experiment.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "interrupt.h"
#include "motion.h"
#include "output.h"
#include "report_run.h"
#include "results.h"
#include "say.h"
#include "summary.h"

#define POPULATION 8      /* of CMA-ES with five unknowns: for the progress */
#define BACKWARD_COST 0.4 /* of a simulation with its sweep back, the share that one without saves */

void experiment_claim_add(experiment* e, const char* name, const char* says, double value, double bound,
                          finding_kind kind) {
    if (e->n_claims < EXPERIMENT_MAX_CLAIMS) {
        const finding added = {name, says, value, bound, kind};
        e->claims[e->n_claims++] = added;
    }
}

/* ------------------------------------------------------------------ the stage before the trials */
static int64_t stage_units(const experiment* e) {
    return e->plan->stage != NULL ? trial_units(e->plan->stage, &e->stage_o, POPULATION) : 0;
}

/* The stage, from its checkpoint if there is one; the scene then has the task of the trials. */
static int run_stage(experiment* e) {
    static const double still[3] = {0.0, 0.0, 0.0};
    const experiment_plan* plan = e->plan;
    trial* t = &e->stage;
    const int64_t most = stage_units(e);
    int outcome = scene_take_task(&e->s, &e->stage_o);
    if (outcome == DONE) outcome = scene_set_current(&e->s, still);
    if (outcome != DONE) return outcome;
    plan->stage_task(&e->s);
    outcome = trial_open(t, plan->stage, &e->stage_o, &e->s, plan->theta, NULL);
    e->has_stage = 1;
    if (outcome != DONE) return outcome;
    progress_part(&e->p, 1, e->n_asked + 1, most, (double)e->o.steps / (double)e->stage_o.steps);
    e->p.part_name = t->plan->name;
    e->p.iteration = trial_simulations(t);
    outcome = trial_run(t, &e->s, &e->p, 0, 0);
    e->p.iterations += t->r.iteration - e->p.part_end;
    if (outcome == DONE) outcome = scene_take_task(&e->s, &e->o);
    return outcome == DONE ? scene_set_current(&e->s, e->o.laws.current) : outcome;
}

/* ------------------------------------------------------------------ trials */
/* Cost of a later simulation, relative to one of trial k. */
static double later_cost(const experiment* e, int k) {
    double units = 0.0, cost = 0.0;
    for (int i = k + 1; i < e->n_asked; ++i) {
        const double n = (double)trial_units(e->asked[i], &e->o, POPULATION);
        units += n;
        cost += n * (e->asked[i]->cma_es ? 1.0 - BACKWARD_COST : 1.0);
    }
    return units > 0.0 ? cost / units / (e->asked[k]->cma_es ? 1.0 - BACKWARD_COST : 1.0) : 1.0;
}

/* 1 when the list of --only names the trial. */
static int is_listed(const char* list, const char* name) {
    const size_t length = strlen(name);
    for (; *list != '\0'; list += strcspn(list, ",") + (list[strcspn(list, ",")] == ','))
        if (strcspn(list, ",") == length && strncmp(list, name, length) == 0) return 1;
    return 0;
}

static int choose_trials(experiment* e) {
    const experiment_plan* plan = e->plan;
    int names = 1;
    for (int k = 0; k < plan->n_trials; ++k) {
        if (e->o.only != NULL && !is_listed(e->o.only, plan->trials[k].name)) continue;
        if (k == plan->shown) e->shown = e->n_asked;
        e->asked[e->n_asked++] = &plan->trials[k];
    }
    for (const char* at = e->o.only; at != NULL && *at != '\0'; ++at) names += *at == ',';
    if (e->o.only == NULL || e->n_asked == names) return DONE;
    say("--only expects some of the optimisations, each once, not \"%s\"; see %s --help", e->o.only,
        plan->form->program);
    return USAGE;
}

static int run_trials(experiment* e) {
    const int first = e->has_stage ? 2 : 1; /* number of the first trial for the progress */
    const double* network = e->has_stage ? e->stage.r.best_x + e->s.n_weights : NULL;
    int64_t before = e->has_stage ? e->stage.r.iteration : 0;
    int outcome = DONE;
    for (int k = 0; k < e->n_asked && outcome == DONE; ++k) {
        outcome = trial_open(&e->trials[k], e->asked[k], &e->o, &e->s, e->plan->theta, network);
        e->n_trials = k + 1;
    }
    for (int k = 0; k < e->n_asked && outcome == DONE; ++k) {
        trial* t = &e->trials[k];
        const int64_t most = trial_units(t->plan, &e->o, POPULATION);
        progress_part(&e->p, k + first, e->n_asked + first - 1, before + most, later_cost(e, k));
        e->p.part_name = t->plan->name;
        e->p.iteration = before + trial_simulations(t);
        if (t->plan->cma_es) e->p.seconds[PROGRESS_BACKWARD] = 0.0;
        outcome = trial_run(t, &e->s, &e->p, before, k == 0);
        /* A trial that ended early leaves less to do. */
        before += t->plan->cma_es ? trial_simulations(t) : t->r.iteration;
        e->p.iterations += before - e->p.part_end;
    }
    return outcome;
}

/* ------------------------------------------------------------------ results */
static void list_trial(const trial* t) {
    const run* r = &t->r;
    printf("%-18s loss %9.6f -> %9.6f%s, %5lld simulations, %7.1f s; design", t->plan->name, r->rows[0].loss,
           r->best_loss, objective_is_travel(r->loss) ? " m" : "", (long long)trial_simulations(t), r->cpu_before);
    for (int64_t i = 0; i < r->n_weights; ++i) printf(" %.3f", r->best_x[i]);
    if (!r->mlp) printf(", a %.3f", r->best_x[r->n_weights]);
    if (objective_keeps(r->loss))
        printf("; place %.4f, heading %.3f", r->rows[r->best_iteration - 1].place,
               r->rows[r->best_iteration - 1].heading);
    putchar('\n');
}

static void list(const experiment* e, int drawn) {
    const char* out = e->o.out;
    if (e->has_stage) list_trial(&e->stage);
    for (int k = 0; k < e->n_trials; ++k) list_trial(&e->trials[k]);
    findings_print(e->claims, e->n_claims);
    printf("Files:\n  %s/%s  (opens in any browser)\n", out, REPORT_FILE);
    if (drawn) printf("  %s/%s  (made by %s)\n", out, e->plan->picture, e->plan->script);
    printf("  %s/%s\n", out, SUMMARY_FILE);
    if (e->has_stage) printf("  %s/%s/history.csv\n", out, e->stage.plan->name);
    for (int k = 0; k < e->n_trials; ++k) printf("  %s/%s/history.csv\n", out, e->trials[k].plan->name);
    printf("  %s/swimmer.pvd\n  %s/%s\n  %s/%s\n", out, out, DESIGN_FILE, out, CONTROLLER_FILE);
}

static int write_results(experiment* e, int* drawn) {
    motion first, best;
    trial* shown = &e->trials[e->shown];
    int outcome;
    memset(&best, 0, sizeof best);
    memset(&first, 0, sizeof first);
    outcome = trial_enter(shown, &e->s);
    if (outcome == DONE) outcome = motion_record(&first, &e->s, shown->r.row_x, &e->p);
    e->p.extra = 1;
    if (outcome == DONE) outcome = motion_record(&best, &e->s, shown->r.best_x, &e->p);
    e->p.extra = 0;
    progress_stage(&e->p, PROGRESS_OUTPUT);
    if (outcome == DONE) outcome = results_write(&e->s, &best, e->o.out);
    if (outcome == DONE) outcome = experiment_draw(e, &first, &best, drawn);
    if (outcome == DONE) {
        shown->r.first_loss = shown->r.rows[0].loss;
        outcome = report_run(e->plan->form->program, &shown->r, &shown->o, &e->s, &first, &best, e->command, e->o.out);
    }
    if (outcome == DONE) {
        /* Of some of the optimisations nothing is to be shown. */
        if (e->n_trials == e->plan->n_trials) e->plan->claim(e);
        outcome = experiment_summary(e);
    }
    motion_free(&first);
    motion_free(&best);
    return outcome;
}

/* ------------------------------------------------------------------ all of it */
static int prepare(experiment* e, int* created) {
    int found = e->plan->stage != NULL && trial_exists(e->plan->stage, e->o.out), outcome;
    for (int k = 0; k < e->plan->n_trials; ++k) found = found || trial_exists(&e->plan->trials[k], e->o.out);
    if (e->o.resume && !found) {
        say("there is no checkpoint in %s to resume from; start without --resume", e->o.out);
        return USAGE;
    }
    outcome = output_folder(e->o.out, created);
    if (outcome == DONE && !e->o.resume && found)
        say("starting anew in %s; --resume would have continued the run that lies there", e->o.out);
    /* The summary is written last: while it is missing, the folder is known to be incomplete. */
    if (outcome == DONE) output_remove(e->o.out, SUMMARY_FILE);
    return outcome;
}

static int work(experiment* e) {
    int64_t units = stage_units(e);
    int outcome, drawn = 0;
    for (int k = 0; k < e->n_asked; ++k) units += trial_units(e->asked[k], &e->o, POPULATION);
    progress_begin(&e->p, units, 2);
    outcome = scene_create(&e->s, &e->o, &e->p);
    if (outcome == DONE && e->plan->stage != NULL) outcome = run_stage(e);
    if (outcome == DONE && e->plan->before != NULL) outcome = e->plan->before(e);
    if (outcome == DONE) outcome = run_trials(e);
    if (outcome == DONE) outcome = write_results(e, &drawn);
    progress_end(&e->p);
    if (outcome == DONE) list(e, drawn);
    if (outcome == DONE && (fflush(stdout) != 0 || ferror(stdout))) {
        say("cannot write to the standard output");
        outcome = FAILED;
    }
    return outcome;
}

static void remove_empty_folder(const experiment* e, const trial_plan* plan) {
    char* folder = output_path(e->o.out, plan->name);
    if (folder != NULL) (void)rmdir(folder);
    free(folder);
}

static void remove_empty_folders(const experiment* e) {
    if (e->plan->stage != NULL) remove_empty_folder(e, e->plan->stage);
    for (int k = 0; k < e->plan->n_trials; ++k) remove_empty_folder(e, &e->plan->trials[k]);
    (void)rmdir(e->o.out);
}

int experiment_main(const experiment_plan* plan, int argc, char** argv) {
    experiment* e = calloc(1, sizeof *e);
    int action = OPTIONS_RUN, created = 0, outcome;
    say_program(plan->form->program);
    if (e == NULL) return say_no_memory();
    if (dqa_abi_version() != DQA_ABI_VERSION) {
        say("the diffaqua library found has ABI %d; this program needs %d", (int)dqa_abi_version(), DQA_ABI_VERSION);
        free(e);
        return FAILED;
    }
    e->plan = plan;
    outcome = options_parse(&e->o, plan->form, argc, argv, &action);
    if (outcome == DONE && action == OPTIONS_RUN) {
        e->command = options_command(argc, argv);
        outcome = e->command != NULL ? choose_trials(e) : FAILED;
        e->stage_o = e->o;
        if (plan->stage != NULL) plan->stage_options(&e->stage_o);
        if (outcome == DONE) outcome = prepare(e, &created);
        if (outcome == DONE) outcome = work(e);
        if (outcome == INTERRUPTED) {
            say("interrupted after %lld simulations", (long long)e->p.iteration);
            if (e->has_stage || e->n_trials > 0) options_say_resume(argc, argv);
        }
        if (e->has_stage) trial_free(&e->stage);
        for (int k = 0; k < e->n_trials; ++k) trial_free(&e->trials[k]);
        scene_free(&e->s);
        /* Folders that were made for nothing go again. */
        if (created) remove_empty_folders(e);
    }
    options_free(&e->o);
    free(e->command);
    free(e);
    return outcome;
}
