/* SPDX-License-Identifier: MIT
 *
 * codesign — from closed meshes of animals to an optimised soft swimmer.
 *
 * Interpolates between the meshes (Wasserstein barycentre), lets the shape swim under a sine or a network that drives
 * its muscles, and follows the gradient of the distance travelled (or of another objective) with respect to both, as in
 * sections 5 to 8 of Ma et al., "DiffAqua", 2021. `codesign --help` lists the options. Only diffaqua.h, the C library
 * and POSIX are used.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "diffaqua.h"
#include "support/checkpoint.h"
#include "support/descent.h"
#include "support/history.h"
#include "support/interrupt.h"
#include "support/motion.h"
#include "support/options.h"
#include "support/output.h"
#include "support/picture.h"
#include "support/progress.h"
#include "support/report_run.h"
#include "support/results.h"
#include "support/run.h"
#include "support/say.h"
#include "support/scene.h"
#include "support/summary.h"
#include "support/vtu.h"

/* A job: the run, where it stands in its scene, and what its checkpoint belongs to. */
typedef struct job {
    options o;
    char* settings;
    char* command; /* the line that started it */
    options stage; /* o with the grid and tolerances of the running stage of the schedule; borrows from o */
    scene s;
    run r;
    progress p;
    int has_run;    /* r is set up */
    int drawn;      /* the picture was made */
    int64_t frames; /* written */
} job;

/* ------------------------------------------------------------------ start */
/* The layers of a fin start as antagonists, the upper half against the lower: in unison they would not bend it, and
 * from there no gradient would tell them apart. */
static int phase_of(const dqa_shape_space* space, int32_t signal, int32_t n_signals, double* phase) {
    dqa_signal_info own, other;
    int32_t layers = 1;
    int outcome = say_status(dqa_shape_space_signal(space, signal, &own, sizeof own), "read a signal");
    for (int32_t k = 0; k < n_signals && outcome == DONE; ++k) {
        outcome = say_status(dqa_shape_space_signal(space, k, &other, sizeof other), "read a signal");
        if (outcome == DONE && other.category == own.category && other.layer >= layers) layers = other.layer + 1;
    }
    if (outcome == DONE && 2 * own.layer >= layers && layers > 1) *phase = SCENE_PI;
    return outcome;
}

static int start_run(job* w) {
    const int64_t n = w->s.n_control;
    double* theta = malloc((size_t)n * sizeof *theta);
    int outcome = DONE;
    if (theta == NULL) return say_no_memory();
    for (int64_t i = 0; i < n && !w->o.mlp; i += 3) {
        /* Full swing when only the shape is to be found; otherwise half of it, so that there is a way up and down. */
        theta[i] = w->o.fixed_control ? 1.0 : 0.5;
        theta[i + 1] = SCENE_OMEGA0;
        theta[i + 2] = 0.0;
        outcome = phase_of(w->s.space, (int32_t)(i / 3), (int32_t)(n / 3), &theta[i + 2]);
        if (outcome != DONE) break;
    }
    if (outcome == DONE && w->o.mlp)
        outcome = say_status(dqa_controller_get_parameters(w->s.controller, theta, n), "read the controller");
    if (outcome == DONE) outcome = run_create(&w->r, &w->o, w->s.n_weights, theta, n, SCENE_OMEGA0);
    free(theta);
    if (outcome == DONE) w->has_run = 1;
    if (outcome == DONE && w->o.resume) {
        outcome = checkpoint_load(&w->r, w->settings, w->o.out);
        if (outcome == DONE) say("continuing after iteration %lld", (long long)w->r.iteration);
    }
    return outcome;
}

/* ------------------------------------------------------------------ stages of the schedule */
static int last_stage(const job* w) {
    return w->r.stage + 1 == w->o.plan.n_stages;
}

static int64_t stage_end(const job* w) {
    return w->r.stage_first + schedule_budget(&w->o.plan, w->r.stage, w->o.iterations, w->r.stage_first);
}

/* Builds the scene of stage k anew from the meshes. */
static int build_stage(job* w, int32_t k) {
    const schedule_stage* at = &w->o.plan.stages[k];
    w->stage = w->o;
    schedule_grid(&w->o.plan, k, w->o.grid, w->stage.grid);
    w->stage.tolerance = at->tolerance;
    /* The kernel keeps its width in metres, as far as the library can make it narrow. */
    w->stage.sigma = at->grid * w->o.sigma > 0.2 ? at->grid * w->o.sigma : 0.2;
    scene_free(&w->s);
    return scene_create(&w->s, &w->stage, &w->p);
}

/* Builds the scenes from the last stage to the first, which stays: every unknown has to mean the same in all, and a
 * grid that is too coarse to find the same muscles is refused before any work goes into it. */
static int check_stages(job* w) {
    uint64_t wanted = 0, found = 0;
    int outcome = DONE;
    for (int32_t k = w->o.plan.n_stages - 1; k >= 0 && outcome == DONE; --k) {
        outcome = build_stage(w, k);
        if (outcome == DONE) outcome = scene_signals(&w->s, &found);
        if (k + 1 == w->o.plan.n_stages) wanted = found;
        if (outcome == DONE && found != wanted) {
            say("--schedule: on %dx%dx%d cells the meshes have other muscles than on the grid asked for; take a finer "
                "stage, or give the actuators with --bases-file",
                (int)w->stage.grid[0], (int)w->stage.grid[1], (int)w->stage.grid[2]);
            outcome = FAILED;
        }
    }
    return outcome;
}

/* The gradient is proven at the first design of the last stage. */
static int prove(job* w) {
    const descent d = {&w->r, &w->s, &w->p, w->settings, w->o.out, 0};
    return w->r.iteration > w->r.stage_first || !last_stage(w) ? DONE : descent_prove(&d);
}

/* ------------------------------------------------------------------ the optimisation */
static int optimise(job* w, int* converged) {
    const descent d = {&w->r, &w->s, &w->p, w->settings, w->o.out, 0};
    for (;;) {
        const int64_t end = stage_end(w);
        int outcome;
        /* The cost of an iteration goes with the number of cells. */
        progress_part(&w->p, w->r.stage + 1, w->o.plan.n_stages, end, pow(w->o.plan.stages[w->r.stage].grid, -3.0));
        outcome = prove(w);
        *converged = run_converged(&w->r);
        while (outcome == DONE && w->r.iteration < end && !*converged && (last_stage(w) || !run_stalled(&w->r))) {
            outcome = interrupted() ? INTERRUPTED : descent_iterate(&d);
            if (outcome == DONE) *converged = run_converged(&w->r);
        }
        if (outcome != DONE || last_stage(w)) return outcome;
        run_next_stage(&w->r);
        outcome = build_stage(w, w->r.stage);
        if (outcome != DONE) return outcome;
    }
}

/* ------------------------------------------------------------------ results */
static int write_results(job* w, int converged) {
    const double started = progress_clock();
    motion first, best;
    int outcome;
    memset(&best, 0, sizeof best);
    outcome = motion_record(&first, &w->s, w->r.row_x, &w->p);
    w->p.extra = 1;
    if (outcome == DONE) outcome = motion_record(&best, &w->s, w->r.best_x, &w->p);
    w->p.extra = 0;
    w->r.first_loss = w->r.rows[0].stage == w->r.stage ? w->r.rows[0].loss : first.objective;
    progress_stage(&w->p, PROGRESS_OUTPUT);
    if (outcome == DONE) outcome = history_write(&w->r, w->s.space, w->o.out);
    /* The best design swam last: it is the scene's. */
    if (outcome == DONE) outcome = results_write(&w->s, &best, w->o.out);
    if (outcome == DONE) outcome = picture_make(&w->r, w->s.space, &first, &best, w->o.out, &w->drawn);
    w->r.seconds += progress_clock() - started;
    if (outcome == DONE) outcome = report_run("codesign", &w->r, &w->o, &w->s, &first, &best, w->command, w->o.out);
    if (outcome == DONE) outcome = summary_write(&w->r, &w->o, &w->s, converged, w->o.out);
    w->frames = best.n_frames;
    motion_free(&first);
    motion_free(&best);
    return outcome;
}

static int list_results(const job* w, int converged) {
    const run* r = &w->r;
    const char* out = w->o.out;
    printf("%s after %lld iterations and %.1f s: ", converged ? "Converged" : "Done", (long long)r->iteration,
           r->seconds);
    if (objective_is_travel(r->loss))
        printf("the swimmer travels %.2f mm (first %.2f mm)\n", -1e3 * r->best_loss, -1e3 * r->first_loss);
    else
        printf("loss %.6g (first %.6g)\n", r->best_loss, r->first_loss);
    for (int64_t i = 0; i < r->n_weights; ++i)
        printf("  %6.1f %%  %s\n", 100.0 * r->best_x[i], dqa_shape_space_base_name(w->s.space, (int32_t)i));
    printf("Files:\n  %s/%s  (opens in any browser)\n", out, REPORT_FILE);
    if (w->drawn) printf("  %s/%s  (made by %s and %s/ there)\n", out, PICTURE_FILE, PICTURE_SCRIPT, PLOT_FOLDER);
    printf("  %s/%s\n  %s/%s\n", out, HISTORY_FILE, out, SUMMARY_FILE);
    printf("  %s/%s  (%lld frames in %s/)\n", out, VTU_INDEX, (long long)w->frames, VTU_FOLDER);
    printf("  %s/%s\n  %s/%s\n  %s/%s\n", out, DESIGN_FILE, out, CONTROLLER_FILE, out, CHECKPOINT_FILE);
    if (fflush(stdout) != 0 || ferror(stdout)) {
        say("cannot write to the standard output");
        return FAILED;
    }
    return DONE;
}

/* ------------------------------------------------------------------ all of it */
static int work(job* w) {
    int converged = 0;
    int outcome = check_stages(w);
    if (outcome == DONE) outcome = start_run(w);
    /* The summary is written last: while it is missing, the folder is known to be incomplete. */
    if (outcome == DONE) output_remove(w->o.out, SUMMARY_FILE);
    /* From here on there is something to come back to, and a folder that cannot be written is found out early. */
    if (outcome == DONE) outcome = checkpoint_save(&w->r, w->settings, w->o.out);
    w->p.iteration = w->r.iteration;
    if (outcome == DONE && w->r.stage > 0) outcome = build_stage(w, w->r.stage);
    if (outcome == DONE) outcome = optimise(w, &converged);
    w->p.iterations = w->r.iteration;
    if (outcome == DONE) outcome = write_results(w, converged);
    progress_end(&w->p);
    if (outcome == DONE) outcome = list_results(w, converged);
    return outcome;
}

static int prepare(job* w, int* created) {
    int outcome;
    w->settings = checkpoint_settings(&w->o);
    if (w->settings == NULL) return FAILED;
    if (w->o.resume && !checkpoint_exists(w->o.out)) {
        say("there is no checkpoint in %s to resume from; start without --resume", w->o.out);
        return USAGE;
    }
    outcome = output_folder(w->o.out, created);
    if (outcome == DONE && !w->o.resume && checkpoint_exists(w->o.out))
        say("starting anew in %s; --resume would have continued the run that lies there", w->o.out);
    return outcome;
}

int main(int argc, char** argv) {
    job w;
    int action = OPTIONS_RUN, created = 0;
    int outcome;
    memset(&w, 0, sizeof w);
    say_program("codesign");
    if (dqa_abi_version() != DQA_ABI_VERSION) {
        say("the diffaqua library found has ABI %d; this program needs %d", (int)dqa_abi_version(), DQA_ABI_VERSION);
        return FAILED;
    }
    outcome = options_parse(&w.o, &options_codesign, argc, argv, &action);
    if (outcome == DONE && action == OPTIONS_RUN) {
        w.command = options_command(argc, argv);
        outcome = w.command != NULL ? prepare(&w, &created) : FAILED;
        if (outcome == DONE) {
            progress_begin(&w.p, w.o.iterations, 2);
            outcome = work(&w);
            if (outcome == INTERRUPTED) {
                say("interrupted after iteration %lld of %lld", (long long)w.r.iteration, (long long)w.o.iterations);
                if (w.has_run) options_say_resume(argc, argv);
            }
        }
        scene_free(&w.s);
        if (w.has_run) run_free(&w.r);
        /* A folder that was made for nothing goes again; one with anything in it stays. */
        if (created) (void)rmdir(w.o.out);
    }
    free(w.settings);
    free(w.command);
    options_free(&w.o);
    return outcome;
}
