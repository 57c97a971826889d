/* SPDX-License-Identifier: MIT
 * The swimmer in its water. What the command line does not name keeps the library's defaults. */
#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "hash.h"
#include "interrupt.h"
#include "say.h"

#define DEFAULT_TOLERANCE 1e-6 /* of a step: the library's */

static int add_meshes(scene* s, const options* o) {
    int outcome = DONE;
    for (int32_t i = 0; i < o->n_meshes && outcome == DONE; ++i) {
        char doing[512];
        (void)snprintf(doing, sizeof doing, "use the mesh %s", o->meshes[i]);
        outcome = say_status(dqa_shape_space_add_mesh_file(s->space, o->meshes[i], NULL), doing);
        if (outcome == DONE && interrupted()) outcome = INTERRUPTED;
    }
    return outcome;
}

/* Length of a base along x, to a fraction of a cell: slices count as far as their fullest cell is covered. */
static int length_of(const dqa_shape_space* space, int32_t base, const dqa_shape_space_info* info, double* length) {
    double* cells = malloc((size_t)info->n_cells * sizeof *cells);
    const int64_t slice = info->n_cells / info->cells_x;
    int outcome = cells != NULL ? DONE : say_no_memory();
    if (outcome == DONE)
        outcome = say_status(dqa_shape_space_get_base(space, base, cells, info->n_cells), "read a base");
    *length = 0.0;
    for (int64_t x = 0; x < info->cells_x && outcome == DONE; ++x) {
        double most = 0.0;
        for (int64_t k = 0; k < slice; ++k) most = fmax(most, cells[x * slice + k]);
        *length += most * info->cell_size;
    }
    free(cells);
    return outcome;
}

/* Lengths of actuators need the size of a cell, and in lists like those that come with the shapes the length of each
 * animal in its box [n_meshes]; both follow from the meshes: a first space finds them. */
static int find_sizes(scene* s, const options* o, dqa_shape_space_options* settings, double* lengths) {
    dqa_shape_space_info info;
    int outcome = say_status(dqa_shape_space_create(settings, &s->space), "create the shape space");
    if (outcome == DONE) outcome = add_meshes(s, o);
    if (outcome == DONE) outcome = say_status(dqa_shape_space_build(s->space, NULL, NULL), "build the shape space");
    if (outcome == DONE)
        outcome = say_status(dqa_shape_space_get_info(s->space, &info, sizeof info), "read the shape space");
    if (outcome == DONE) settings->cell_size = info.cell_size;
    for (int32_t i = 0; i < o->n_meshes && outcome == DONE; ++i) outcome = length_of(s->space, i, &info, &lengths[i]);
    dqa_shape_space_free(s->space);
    s->space = NULL;
    return outcome;
}

static int build_space(scene* s, const options* o, progress* p) {
    dqa_shape_space_options settings;
    double lengths[OPTIONS_MAX_BASES];
    int outcome = say_status(dqa_shape_space_options_init(&settings, sizeof settings), "set up the shape space");
    if (outcome != DONE) return outcome;
    settings.cells_x = o->grid[0];
    settings.cells_y = o->grid[1];
    settings.cells_z = o->grid[2];
    settings.sigma = o->sigma;
    settings.refinement = o->refinement;
    settings.threads = o->threads;
    settings.cancel = s->cancel;
    /* Looser steps need no tighter shapes: both keep the ratio of their defaults. */
    if (o->tolerance > 0.0) settings.tolerance *= o->tolerance / DEFAULT_TOLERANCE;
    physics_of_space(&o->laws, &settings);
    progress_stage(p, PROGRESS_SPACE);
    if (o->list.n_actuators > 0) outcome = find_sizes(s, o, &settings, lengths);
    if (outcome == DONE) outcome = say_status(dqa_shape_space_create(&settings, &s->space), "create the shape space");
    if (outcome == DONE) outcome = add_meshes(s, o);
    if (outcome == DONE) outcome = bases_add_actuators(&o->list, o->bases_file, lengths, s->space);
    if (outcome == DONE)
        outcome = say_status(dqa_shape_space_build(s->space, progress_callback, p), "build the shape space");
    if (outcome == DONE) progress_stage_done(p);
    return outcome;
}

static int build_controller(scene* s, const options* o, int32_t n_signals) {
    int outcome;
    if (o->mlp) return scene_use_network(s, 1);
    outcome =
        say_status(dqa_controller_create_sinusoid(n_signals, s->time_step, &s->controller), "create the controller");
    if (outcome == DONE)
        outcome = say_status(dqa_controller_n_parameters(s->controller, &s->n_control), "read the controller");
    return outcome;
}

/* The threshold that keeps the error asked for at the initial design. The library asks a simulator, for its material;
 * the threshold of that one does not matter, and the one that swims takes its place. */
static int choose_threshold(scene* s, const options* o, dqa_simulator_options* settings) {
    dqa_simulator* judge = NULL;
    int outcome = say_status(dqa_simulator_create(s->space, settings, &judge), "create the simulator");
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_suggest_threshold(judge, o->weights, s->n_weights, o->model_error,
                                                             &settings->threshold, &s->model_error),
                             "choose the threshold");
    dqa_simulator_free(judge);
    if (outcome == DONE)
        say("simulating cells of density above %.4g: an estimated error of %.2g %% in the movements",
            settings->threshold, 100.0 * s->model_error);
    return outcome;
}

static int build_simulator(scene* s, const options* o) {
    dqa_shape_space_info info;
    dqa_simulator_options settings;
    dqa_tape_options record;
    int outcome = say_status(dqa_shape_space_get_info(s->space, &info, sizeof info), "read the shape space");
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_options_init(&settings, sizeof settings), "set up the simulator");
    if (outcome != DONE) return outcome;
    s->n_weights = info.n_bases;
    s->network_scale = o->form->network_scale > 0.0 ? o->form->network_scale : 1.0;
    settings.time_step = s->time_step = 1.0 / (double)o->rate;
    settings.threads = o->threads;
    settings.cancel = s->cancel;
    if (o->threshold >= 0.0) settings.threshold = o->threshold;
    if (o->tolerance > 0.0) settings.tolerance = o->tolerance;
    physics_of_simulator(&o->laws, &settings);
    if (o->model_error > 0.0) outcome = choose_threshold(s, o, &settings);
    if (outcome != DONE) return outcome;
    s->threshold = settings.threshold;
    outcome = say_status(dqa_simulator_create(s->space, &settings, &s->simulator), "create the simulator");
    if (outcome == DONE) outcome = physics_set_current(&o->laws, s->simulator);
    if (outcome == DONE) outcome = build_controller(s, o, info.n_signals);
    if (outcome == DONE) outcome = say_status(dqa_tape_options_init(&record, sizeof record), "set up the tape");
    if (outcome != DONE) return outcome;
    record.memory_bytes = o->checkpoint_mib * 1024 * 1024;
    outcome = say_status(dqa_tape_create(s->simulator, &record, &s->tape), "create the tape");
    return outcome == DONE ? scene_take_task(s, o) : outcome;
}

int scene_create(scene* s, const options* o, progress* p) {
    int outcome;
    memset(s, 0, sizeof *s);
    outcome = say_status(dqa_cancel_token_create(&s->cancel), "create the cancel token");
    if (outcome == DONE) outcome = interrupt_install(s->cancel);
    if (outcome == DONE) outcome = build_space(s, o, p);
    if (outcome == DONE) outcome = build_simulator(s, o);
    return outcome;
}

void scene_free(scene* s) {
    interrupt_remove();
    dqa_tape_free(s->tape);
    dqa_controller_free(s->controller);
    dqa_simulator_free(s->simulator);
    dqa_shape_space_free(s->space);
    dqa_cancel_token_free(s->cancel);
    memset(s, 0, sizeof *s);
}

int scene_use_network(scene* s, int temporal_encoding) {
    dqa_shape_space_info info;
    dqa_mlp_options net;
    dqa_controller* network = NULL;
    int outcome = say_status(dqa_shape_space_get_info(s->space, &info, sizeof info), "read the shape space");
    if (outcome == DONE) outcome = say_status(dqa_mlp_options_init(&net, sizeof net), "set up the controller");
    if (outcome != DONE) return outcome;
    net.n_signals = info.n_signals;
    net.temporal_encoding = temporal_encoding;
    net.scale *= s->network_scale;
    outcome = say_status(dqa_controller_create_mlp(&net, &network), "create the controller");
    if (outcome == DONE)
        outcome = say_status(dqa_controller_n_parameters(network, &s->n_control), "read the controller");
    if (outcome != DONE) {
        dqa_controller_free(network);
        return outcome;
    }
    dqa_controller_free(s->controller);
    s->controller = network;
    return DONE;
}

int scene_take_task(scene* s, const options* o) {
    s->steps = o->steps;
    s->n_terms = o->loss.n_terms;
    return objective_terms(&o->loss, s->terms);
}

int scene_set_current(scene* s, const double velocity[3]) {
    const double start = 0.0;
    return say_status(dqa_simulator_set_current_table(s->simulator, &start, 1, velocity, 3), "set the water's current");
}

int scene_set(scene* s, const double* x, progress* p) {
    int outcome;
    progress_stage(p, PROGRESS_SETUP);
    outcome =
        say_status(dqa_simulator_set_weights(s->simulator, x, s->n_weights, progress_callback, p), "set the design");
    if (outcome == DONE)
        outcome = say_status(dqa_controller_set_parameters(s->controller, x + s->n_weights, s->n_control),
                             "set the controller");
    if (outcome == DONE) progress_stage_done(p);
    return outcome;
}

/* *status: of the rollout, when DONE. */
static int roll(scene* s, const double* x, dqa_status* status, progress* p, dqa_progress watch, void* user_data) {
    int outcome = scene_set(s, x, p);
    if (outcome == DONE) outcome = say_status(dqa_tape_clear(s->tape), "clear the tape");
    if (outcome != DONE) return outcome;
    progress_stage(p, PROGRESS_FORWARD);
    *status = dqa_simulator_rollout(s->simulator, s->controller, s->steps, s->tape, watch, user_data);
    if (*status == DQA_SUCCESS) progress_stage_done(p);
    return DONE;
}

int scene_swim(scene* s, const double* x, progress* p) {
    return scene_swim_watched(s, x, p, progress_callback, p);
}

int scene_swim_watched(scene* s, const double* x, progress* p, dqa_progress watch, void* user_data) {
    dqa_status status = DQA_SUCCESS;
    const int outcome = roll(s, x, &status, p, watch, user_data);
    return outcome == DONE ? say_status(status, "swim") : outcome;
}

int scene_signals(const scene* s, uint64_t* number) {
    dqa_shape_space_info info;
    int outcome = say_status(dqa_shape_space_get_info(s->space, &info, sizeof info), "read the shape space");
    *number = 0;
    for (int32_t k = 0; outcome == DONE && k < info.n_signals; ++k) {
        dqa_signal_info signal;
        outcome = say_status(dqa_shape_space_signal(s->space, k, &signal, sizeof signal), "read a signal");
        if (outcome == DONE) {
            const int32_t words[4] = {signal.category, signal.kind, signal.layer, signal.group};
            uint64_t both[2] = {*number, 0};
            both[1] = hash_bytes(words, sizeof words);
            *number = hash_bytes(both, sizeof both);
        }
    }
    return outcome;
}

static int statistics_of(const scene* s, dqa_tape_statistics* statistics) {
    return say_status(dqa_tape_stats(s->tape, statistics, sizeof *statistics), "read the tape's statistics");
}

static int sweep_back(scene* s, double* gradient, progress* p) {
    dqa_adjoint* adjoint = NULL;
    int outcome = say_status(dqa_adjoint_create(s->tape, &adjoint), "create the adjoint");
    progress_stage(p, PROGRESS_BACKWARD);
    if (outcome == DONE)
        outcome = say_status(dqa_adjoint_seed_objective(adjoint, s->terms, s->n_terms), "seed the adjoint");
    if (outcome == DONE)
        outcome = say_status(dqa_adjoint_backward(adjoint, 0, progress_callback, p), "compute the gradient");
    if (outcome == DONE)
        outcome = say_status(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, gradient, s->n_weights),
                             "read the gradient of the weights");
    if (outcome == DONE)
        outcome = say_status(dqa_adjoint_get(adjoint, DQA_WRT_CONTROL, gradient + s->n_weights, s->n_control),
                             "read the gradient of the controller");
    if (outcome == DONE) progress_stage_done(p);
    dqa_adjoint_free(adjoint);
    return outcome;
}

static double norm(const double* x, int64_t n) {
    double sum = 0.0;
    for (int64_t i = 0; i < n; ++i) sum += x[i] * x[i];
    return sqrt(sum);
}

static int loss_of(scene* s, history_row* row) {
    int outcome =
        say_status(dqa_tape_objective(s->tape, s->terms, s->n_terms, &row->loss, row->terms), "evaluate the loss");
    for (int32_t k = 0; k < s->n_terms && outcome == DONE; ++k) {
        dqa_objective_term place = s->terms[k];
        if (place.kind != DQA_OBJECTIVE_POSITION_KEEPING) continue;
        place.weight = 1.0;
        place.gamma = 0.0;
        outcome = say_status(dqa_tape_objective(s->tape, &place, 1, &row->place, NULL), "evaluate the loss");
        /* Without a share of it the heading is not known; 0. */
        if (s->terms[k].gamma != 0.0) row->heading = (row->place - row->terms[k]) / s->terms[k].gamma;
    }
    return outcome;
}

int scene_try(scene* s, const double* x, history_row* row, progress* p) {
    const double started = progress_clock();
    dqa_status status = DQA_SUCCESS;
    dqa_tape_statistics statistics;
    int outcome;
    memset(row, 0, sizeof *row);
    outcome = roll(s, x, &status, p, progress_callback, p);
    if (outcome != DONE) return outcome;
    if (status == DQA_DIVERGED || status == DQA_NOT_CONVERGED) {
        say("a candidate is left out, its simulation fails: %s", dqa_last_error());
        row->loss = HUGE_VAL;
    } else {
        outcome = say_status(status, "swim");
        if (outcome == DONE) outcome = loss_of(s, row);
        if (outcome == DONE) outcome = statistics_of(s, &statistics);
        if (outcome != DONE) return outcome;
        row->newton_iterations = statistics.newton_iterations;
        row->linear_iterations = statistics.linear_iterations;
    }
    row->seconds = progress_clock() - started;
    return DONE;
}

int scene_evaluate(scene* s, const double* x, double* gradient, history_row* row, progress* p) {
    const double started = progress_clock();
    dqa_tape_statistics before, after; /* the adjoint's count adds up over all sweeps of a tape */
    int outcome;
    memset(row, 0, sizeof *row);
    outcome = scene_swim(s, x, p);
    if (outcome == DONE) outcome = loss_of(s, row);
    if (outcome == DONE) outcome = statistics_of(s, &before);
    if (outcome == DONE) outcome = sweep_back(s, gradient, p);
    if (outcome == DONE) outcome = statistics_of(s, &after);
    if (outcome != DONE) return outcome;
    row->gradient_weights = norm(gradient, s->n_weights);
    row->gradient_control = norm(gradient + s->n_weights, s->n_control);
    row->newton_iterations = after.newton_iterations;
    row->linear_iterations = after.linear_iterations;
    row->adjoint_iterations = after.adjoint_iterations - before.adjoint_iterations;
    row->seconds = progress_clock() - started;
    row->cpu_seconds = progress_cpu();
    if (!isfinite(row->loss) || !isfinite(row->gradient_weights) || !isfinite(row->gradient_control)) {
        say("the loss or its gradient is not a finite number");
        return FAILED;
    }
    return DONE;
}

int scene_prove(scene* s, int32_t with_respect_to, const char* of, gradient_proof* proof, progress* p) {
    dqa_gradient_check_options settings;
    char doing[64];
    int outcome;
    (void)snprintf(doing, sizeof doing, "check the gradient of the %s", of);
    outcome = say_status(dqa_gradient_check_options_init(&settings, sizeof settings), "set up the gradient check");
    if (outcome != DONE) return outcome;
    progress_stage(p, PROGRESS_PROOF);
    settings.with_respect_to = with_respect_to;
    settings.n_steps = SCENE_PROOF_STEPS;
    memset(&proof->report, 0, sizeof proof->report);
    outcome = say_status(dqa_check_gradient(s->simulator, s->controller, s->terms, s->n_terms, &settings,
                                            &proof->report, sizeof proof->report),
                         doing);
    if (outcome == DONE && interrupted()) outcome = INTERRUPTED;
    if (outcome == INTERRUPTED) return outcome;
    proof->state = outcome == DONE ? PROOF_MADE : PROOF_FAILED;
    progress_stage_done(p);
    return DONE;
}
