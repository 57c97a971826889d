/* SPDX-License-Identifier: MIT
 * The way through an experiment: options, scene, trials one after the other, results. */
#include "experiment.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "interrupt.h"
#include "motion.h"
#include "output.h"
#include "picture.h"
#include "plot.h"
#include "report_run.h"
#include "results.h"
#include "say.h"
#include "summary.h"

#define POPULATION 8      /* of CMA-ES with five unknowns: for the progress */
#define BACKWARD_COST 0.4 /* of a simulation with its sweep back, the share that one without saves */

void experiment_claim_add(experiment* e, const char* name, const char* says, double value, double bound, int at_least) {
    if (e->n_claims < EXPERIMENT_MAX_CLAIMS) {
        const experiment_claim claim = {name, says, value, bound, at_least};
        e->claims[e->n_claims++] = claim;
    }
}

int experiment_holds(const experiment_claim* claim) {
    return claim->at_least ? claim->value >= claim->bound : claim->value < claim->bound;
}

int experiment_column_weight(const experiment* e, int i) {
    (void)e;
    return 3 + i;
}

int experiment_column_after(const experiment* e, int k) {
    return 2 + (int)e->trials[0].r.n + 1 + k;
}

void experiment_curves(const experiment* e, FILE* f, const char* x, int y, int lowest) {
    for (int k = 0; lowest && k < e->n_trials; ++k) fprintf(f, "least%d = 1e300\n", k);
    fputs("plot ", f);
    for (int k = 0; k < e->n_trials; ++k) {
        const trial* t = &e->trials[k];
        char value[96];
        if (lowest)
            (void)snprintf(value, sizeof value, "(least%d = ($%d < least%d ? $%d : least%d))", k, y, k, y, k);
        else
            (void)snprintf(value, sizeof value, "%d", y);
        fprintf(f, "%s'%s/history.csv' every ::1 using %s:%s with lines lt %d title ", k > 0 ? ", \\\n     " : "",
                t->plan->name, x, value, k + 1);
        plot_quoted(f, t->plan->label, 40);
    }
    fputc('\n', f);
}

/* ------------------------------------------------------------------ trials */
/* Cost of a later simulation, relative to one of trial k. */
static double later_cost(const experiment_plan* plan, const options* o, int k) {
    double units = 0.0, cost = 0.0;
    for (int i = k + 1; i < plan->n_trials; ++i) {
        const double n = (double)trial_units(&plan->trials[i], o, POPULATION);
        units += n;
        cost += n * (plan->trials[i].cma_es ? 1.0 - BACKWARD_COST : 1.0);
    }
    return units > 0.0 ? cost / units / (plan->trials[k].cma_es ? 1.0 - BACKWARD_COST : 1.0) : 1.0;
}

static int run_trials(experiment* e) {
    const experiment_plan* plan = e->plan;
    int64_t before = 0;
    int outcome = DONE;
    for (int k = 0; k < plan->n_trials && outcome == DONE; ++k) {
        outcome = trial_open(&e->trials[k], &plan->trials[k], &e->o, &e->s, plan->theta);
        e->n_trials = k + 1;
    }
    for (int k = 0; k < plan->n_trials && outcome == DONE; ++k) {
        trial* t = &e->trials[k];
        const int64_t most = trial_units(t->plan, &e->o, POPULATION);
        progress_part(&e->p, k + 1, plan->n_trials, before + most, later_cost(plan, &e->o, k));
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
static int draw(const experiment* e, const motion* first, const motion* best, int* drawn) {
    const motion* both[2];
    const experiment_plan* plan = e->plan;
    lanes_box box;
    output_file file;
    int created = 0;
    char* data = output_path(e->o.out, PLOT_FOLDER);
    int outcome = data != NULL ? output_folder(data, &created) : FAILED;
    both[0] = first;
    both[1] = best;
    lanes_measure(&box, both, 2);
    if (outcome == DONE)
        outcome = lanes_write(first, &box, PICTURE_FIRST_COLOUR, data, "first.dat", "first_shadow.dat");
    if (outcome == DONE) outcome = lanes_write(best, &box, PICTURE_BEST_COLOUR, data, "best.dat", "best_shadow.dat");
    if (outcome == DONE) outcome = output_open(&file, e->o.out, plan->script);
    if (outcome == DONE) {
        plot_head(file.stream, plan->picture, plan->script);
        plan->curves(e, file.stream);
        plot_scenery(file.stream, &box);
        plot_swimmer(file.stream, first, &box, plan->first_label, "first", 0.01);
        plot_swimmer(file.stream, best, &box, plan->best_label, "best", 0.51);
        fputs("unset multiplot\nset output\n", file.stream);
        outcome = output_commit(&file);
    }
    if (outcome == DONE) outcome = plot_draw(e->o.out, plan->picture, plan->script, drawn);
    free(data);
    return outcome;
}

static void list(const experiment* e, int drawn) {
    const char* out = e->o.out;
    for (int k = 0; k < e->n_trials; ++k) {
        const run* r = &e->trials[k].r;
        printf("%-13s loss %9.6f -> %9.6f m, %5lld simulations, %7.1f s; design", e->trials[k].plan->name,
               r->rows[0].loss, r->best_loss, (long long)trial_simulations(&e->trials[k]), r->cpu_before);
        for (int64_t i = 0; i < r->n_weights; ++i) printf(" %.3f", r->best_x[i]);
        printf(", a %.3f\n", r->best_x[r->n_weights]);
    }
    for (int k = 0; k < e->n_claims; ++k) {
        const experiment_claim* c = &e->claims[k];
        printf("%s: %s (%.6g, %s %.6g)\n", experiment_holds(c) ? "shown    " : "NOT SHOWN", c->says, c->value,
               c->at_least ? "at least" : "below", c->bound);
    }
    printf("Files:\n  %s/%s  (opens in any browser)\n", out, REPORT_FILE);
    if (drawn) printf("  %s/%s  (made by %s)\n", out, e->plan->picture, e->plan->script);
    printf("  %s/%s\n", out, SUMMARY_FILE);
    for (int k = 0; k < e->n_trials; ++k) printf("  %s/%s/history.csv\n", out, e->trials[k].plan->name);
    printf("  %s/swimmer.pvd\n  %s/%s\n  %s/%s\n", out, out, DESIGN_FILE, out, CONTROLLER_FILE);
}

static int write_results(experiment* e, int* drawn) {
    motion first, best;
    int outcome;
    memset(&best, 0, sizeof best);
    outcome = motion_record(&first, &e->s, e->trials[e->plan->shown].r.row_x, &e->p);
    e->p.extra = 1;
    if (outcome == DONE) outcome = motion_record(&best, &e->s, e->trials[e->plan->shown].r.best_x, &e->p);
    e->p.extra = 0;
    progress_stage(&e->p, PROGRESS_OUTPUT);
    if (outcome == DONE) outcome = results_write(&e->s, &best, e->o.out);
    if (outcome == DONE) outcome = draw(e, &first, &best, drawn);
    if (outcome == DONE) {
        trial* shown = &e->trials[e->plan->shown];
        shown->r.first_loss = shown->r.rows[0].loss;
        outcome = report_run(e->plan->form->program, &shown->r, &shown->o, &e->s, &first, &best, e->command, e->o.out);
    }
    if (outcome == DONE) {
        e->plan->claim(e);
        outcome = experiment_summary(e);
    }
    motion_free(&first);
    motion_free(&best);
    return outcome;
}

/* ------------------------------------------------------------------ all of it */
static int prepare(experiment* e, int* created) {
    int found = 0, outcome;
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
    int64_t units = 0;
    int outcome, drawn = 0;
    for (int k = 0; k < e->plan->n_trials; ++k) units += trial_units(&e->plan->trials[k], &e->o, POPULATION);
    progress_begin(&e->p, units, 2);
    outcome = scene_create(&e->s, &e->o, &e->p);
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

static void remove_empty_folders(const experiment* e) {
    for (int k = 0; k < e->plan->n_trials; ++k) {
        char* folder = output_path(e->o.out, e->plan->trials[k].name);
        if (folder != NULL) (void)rmdir(folder);
        free(folder);
    }
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
        outcome = e->command != NULL ? prepare(e, &created) : FAILED;
        if (outcome == DONE) outcome = work(e);
        if (outcome == INTERRUPTED) {
            say("interrupted after %lld simulations", (long long)e->p.iteration);
            if (e->n_trials > 0) options_say_resume(argc, argv);
        }
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
