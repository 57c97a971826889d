/* SPDX-License-Identifier: MIT
 *
 * position_keeping — the large dataset of section 8.2 of Ma et al., "DiffAqua", 2021: a swimmer between four sharks,
 * seven goldfish and a submarine, and the perceptron that drives its tail, have to keep their place and heading in
 * water that flows at the head; and the perceptron alone, for each of the twelve. `position_keeping --help` lists the
 * options.
 *
 * The paper gives no number for its "fast-flowing water". Here it flows half as fast as the mean of the twelve swims in
 * still water, once the perceptron has learned to drive it straight ahead: that is a first stage, whose network all
 * optimisations begin with.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/experiment.h"
#include "support/json.h"
#include "support/plot.h"
#include "support/say.h"
#include "support/shapes.h"

#define N_BASES 12
#define CURRENT_SHARE 0.5 /* of the speed in still water */
#define SWIMMING_ITERATIONS 30
#define SWIMMING_STEPS 100
#define QUICK_ITERATIONS 12
#define QUICK_STEPS 30
/* A speed is measured over whole beats, after a start of as many steps. */
#define NETWORK_STEPS 50 /* two periods of the temporal encoding */
#define SINE_STEPS 60    /* five periods */

enum { OURS };

static const double alone[N_BASES][N_BASES] = {
    {1.0},       {[1] = 1.0}, {[2] = 1.0}, {[3] = 1.0}, {[4] = 1.0},  {[5] = 1.0},
    {[6] = 1.0}, {[7] = 1.0}, {[8] = 1.0}, {[9] = 1.0}, {[10] = 1.0}, {[11] = 1.0},
};

static const trial_plan trials[] = {
    {.name = "ours", .label = "ours", .moves = RUN_BOTH},
    {.name = "great_white", .label = "great white", .moves = RUN_CONTROL, .weights = alone[0]},
    {.name = "hammerhead", .label = "hammerhead", .moves = RUN_CONTROL, .weights = alone[1]},
    {.name = "thresher", .label = "thresher", .moves = RUN_CONTROL, .weights = alone[2]},
    {.name = "whale_shark", .label = "whale shark", .moves = RUN_CONTROL, .weights = alone[3]},
    {.name = "goldfish_common", .label = "goldfish", .moves = RUN_CONTROL, .weights = alone[4]},
    {.name = "goldfish_comet", .label = "comet", .moves = RUN_CONTROL, .weights = alone[5]},
    {.name = "goldfish_fantail", .label = "fantail", .moves = RUN_CONTROL, .weights = alone[6]},
    {.name = "goldfish_ryukin", .label = "ryukin", .moves = RUN_CONTROL, .weights = alone[7]},
    {.name = "goldfish_oranda", .label = "oranda", .moves = RUN_CONTROL, .weights = alone[8]},
    {.name = "goldfish_ranchu", .label = "ranchu", .moves = RUN_CONTROL, .weights = alone[9]},
    {.name = "goldfish_telescope", .label = "telescope", .moves = RUN_CONTROL, .weights = alone[10]},
    {.name = "submarine", .label = "submarine", .moves = RUN_CONTROL, .weights = alone[11]},
};

static const char about[] =
    "usage: position_keeping [options]\n"
    "\n"
    "Teaches the perceptron that drives the mean of four sharks, seven goldfish and a submarine to swim straight in\n"
    "still water. In water that flows at the head half as fast as that swimmer (unless --current says otherwise) it\n"
    "then co-optimises shape and perceptron to keep place and heading (ours), and the perceptron alone for each of\n"
    "the twelve (great_white, hammerhead, thresher, whale_shark, goldfish_common, goldfish_comet, goldfish_fantail,\n"
    "goldfish_ryukin, goldfish_oranda, goldfish_ranchu, goldfish_telescope, submarine). --iterations and --steps are\n"
    "those of the second stage; the first takes 30 iterations of 100 steps.\n";

static const char* const words[] = {"--iterations", "--steps", "--current", "--only", NULL};

/* The first network is nearly still; it learns to swim first (`swimming`), and then slowly to swim no faster than the
 * water. */
static const options_form form = {.program = "position_keeping",
                                  .about = about,
                                  .out = "position_keeping-out",
                                  .words = words,
                                  .shapes = shapes_twelve,
                                  .quick = {{24, 8, 12}, 5, 20, 0, 0.7},
                                  .shipped = {{60, 16, 26}, 40, 200, 0, 0.7},
                                  .user = {{60, 16, 26}, 40, 200, 0, 0.7},
                                  .objective = "keep",
                                  .mlp = 1,
                                  .network_rate = 0.0005,
                                  .weights_rate = 0.01,
                                  .network_scale = 0.3};

/* ------------------------------------------------------------------ swimming freely */
static const trial_plan swimming = {
    .name = "free_swimming", .label = "free swimming", .moves = RUN_CONTROL, .network_rate = 0.003};

static void swimming_options(options* o) {
    memset(o->laws.current, 0, sizeof o->laws.current);
    o->iterations = o->quick ? QUICK_ITERATIONS : SWIMMING_ITERATIONS;
    o->steps = o->quick ? QUICK_STEPS : SWIMMING_STEPS;
}

/* The task of the trials with another place, too far ahead to be reached. From so far away the distance is rounded, so
 * that the sway of a beat costs its square, and the heading counts for more: the fastest networks that distance alone
 * finds in 100 steps swim in circles, and so would hold no place. */
static void swimming_task(scene* s) {
    s->terms[0].target[0] = 4.0;
    s->terms[0].epsilon = 1.0;
    s->terms[0].gamma = 0.3;
}

/* Distance that the scene's swimmer has travelled so far on the tape, m. */
static int travelled(const scene* s, double* distance) {
    dqa_objective_term term;
    double loss = 0.0;
    int outcome = say_status(dqa_objective_term_init(&term, sizeof term), "set up the objective");
    if (outcome == DONE)
        outcome = say_status(dqa_tape_objective(s->tape, &term, 1, &loss, NULL), "evaluate the distance");
    *distance = -loss;
    return outcome;
}

static int swim_on(scene* s, dqa_controller* c, int64_t steps, progress* p, double* distance) {
    const int outcome =
        say_status(dqa_simulator_rollout(s->simulator, c, steps, s->tape, progress_callback, p), "measure the speed");
    return outcome == DONE ? travelled(s, distance) : outcome;
}

/* Speed (m/s) of the swimmer of the stage under a controller (NULL: its network), over `steps` after as many. */
static int measure_speed(experiment* e, dqa_controller* c, int64_t steps, double* speed) {
    scene* s = &e->s;
    double start = 0.0, end = 0.0;
    int outcome = scene_set(s, e->stage.r.best_x, &e->p);
    if (outcome == DONE) outcome = say_status(dqa_tape_clear(s->tape), "clear the tape");
    if (outcome == DONE) outcome = swim_on(s, c != NULL ? c : s->controller, steps, &e->p, &start);
    if (outcome == DONE) outcome = swim_on(s, c != NULL ? c : s->controller, steps, &e->p, &end);
    if (outcome == DONE) outcome = say_status(dqa_tape_clear(s->tape), "clear the tape");
    *speed = (end - start) / ((double)steps * s->time_step);
    return outcome;
}

enum { BY_NETWORK, BY_SINE };

static int measure_speeds(experiment* e) {
    static const double still[3] = {0.0, 0.0, 0.0};
    dqa_shape_space_info info;
    dqa_controller* sine = NULL;
    int outcome = say_status(dqa_shape_space_get_info(e->s.space, &info, sizeof info), "read the shape space");
    if (outcome == DONE) outcome = scene_set_current(&e->s, still);
    if (outcome == DONE) outcome = measure_speed(e, NULL, NETWORK_STEPS, &e->measured[BY_NETWORK]);
    if (outcome == DONE)
        outcome = say_status(dqa_controller_create_sinusoid(info.n_signals, e->s.time_step, &sine), "create the sine");
    if (outcome == DONE) outcome = measure_speed(e, sine, SINE_STEPS, &e->measured[BY_SINE]);
    dqa_controller_free(sine);
    return outcome;
}

static int let_water_flow(experiment* e) {
    double* current = e->o.laws.current;
    const int given = current[0] != 0.0 || current[1] != 0.0 || current[2] != 0.0;
    int outcome = measure_speeds(e);
    if (outcome != DONE) return outcome;
    /* On a grid so coarse that it swims tail first, the water still comes from ahead. */
    if (!given) current[0] = -CURRENT_SHARE * fabs(e->measured[BY_NETWORK]);
    say("the mean design swims at %.4g mm/s in still water (%.4g mm/s under a plain sine); the water flows at %.4g "
        "mm/s",
        1e3 * e->measured[BY_NETWORK], 1e3 * e->measured[BY_SINE], 1e3 * current[0]);
    return scene_set_current(&e->s, current);
}

static void tell(const experiment* e, json* j) {
    json_open(j, "free_swimming", '{');
    json_number(j, "speed", e->measured[BY_NETWORK]);
    json_number(j, "speed_under_sine", e->measured[BY_SINE]);
    json_number(j, "share_of_speed", CURRENT_SHARE);
    json_integer(j, "iterations", e->stage.r.iteration);
    json_number(j, "cpu_seconds", e->stage.r.cpu_before);
    json_close(j, '}');
}

/* ------------------------------------------------------------------ what it shows */
static void claim(experiment* e) {
    double least = HUGE_VAL;
    for (int k = OURS + 1; k < e->n_trials; ++k) least = fmin(least, e->trials[k].r.best_loss);
    experiment_claim_add(e, "below_control_only", "ours ends below control alone of every base",
                         e->trials[OURS].r.best_loss, least, FINDING_BELOW);
}

static void curves(const experiment* e, FILE* f) {
    fputs("set xlabel 'iteration' offset 0,0.5\n", f);
    plot_panel(f, "Loss: distances from the place less heading (m)", 0.075, 0.31);
    experiment_curves(e, f, "1", 2, 0);
    plot_panel(f, "Share of each base shape", 0.385, 0.64);
    experiment_shares(e, f);
    fputs("set yrange [-1.05:1.05]\nset xlabel 'time (s)' offset 0,0.5\n", f);
    plot_panel(f, "Signal of the optimised swimmer", 0.715, 0.98);
    experiment_signals(e, f);
    fputs("set autoscale y\n", f);
}

int main(int argc, char** argv) {
    const experiment_plan plan = {.form = &form,
                                  .trials = trials,
                                  .n_trials = (int)(sizeof trials / sizeof trials[0]),
                                  .picture = "position_keeping.png",
                                  .script = "position_keeping.gp",
                                  .shown = OURS,
                                  .first_label = "First swimmer",
                                  .best_label = "Ours, optimised",
                                  .crowd = "control alone of each base",
                                  .stage = &swimming,
                                  .stage_options = swimming_options,
                                  .stage_task = swimming_task,
                                  .before = let_water_flow,
                                  .tell = tell,
                                  .claim = claim,
                                  .curves = curves};
    return experiment_main(&plan, argc, argv);
}
