/* SPDX-License-Identifier: MIT
 *
 * position_keeping — the large dataset of section 8.2 of Ma et al., "DiffAqua", 2021: a swimmer between four sharks,
 * seven goldfish and a submarine, and the perceptron that drives its tail, have to keep their place and heading in
 * water that flows at the head; and the perceptron alone, for each of the twelve. `position_keeping --help` lists the
 * options.
 *
 * The paper gives no number for its "fast-flowing water". Here it flows half as fast as the mean of the twelve swims in
 * still water under a sine of full amplitude and a period of 12 steps, which is measured first.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/experiment.h"
#include "support/plot.h"
#include "support/say.h"
#include "support/shapes.h"

#define N_BASES 12
#define CURRENT_SHARE 0.5 /* of the speed in still water */
#define MEASURED_STEPS 60 /* a start of as many steps, whose speed does not count, and then five beats */

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
    "Co-optimises a swimmer between four sharks, seven goldfish and a submarine and the perceptron that drives its\n"
    "tail to keep its place and heading in water that flows at its head (ours), and the perceptron alone for each of\n"
    "the twelve (great_white, hammerhead, thresher, whale_shark, goldfish_common, goldfish_comet, goldfish_fantail,\n"
    "goldfish_ryukin, goldfish_oranda, goldfish_ranchu, goldfish_telescope, submarine).\n";

static const char* const words[] = {"--iterations", "--steps", "--current", "--only", NULL};

/* The place is lost by a beat too strong: networks begin nearly still and learn slowly. */
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
                                  .network_rate = 0.003,
                                  .network_scale = 0.1};

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

static int swim_on(scene* s, dqa_controller* sine, progress* p, double* distance) {
    const int outcome = say_status(
        dqa_simulator_rollout(s->simulator, sine, MEASURED_STEPS, s->tape, progress_callback, p), "measure the speed");
    return outcome == DONE ? travelled(s, distance) : outcome;
}

static int measure_speed(scene* s, const options* o, progress* p, double* speed) {
    dqa_shape_space_info info;
    dqa_controller* sine = NULL;
    double start = 0.0, end = 0.0;
    int outcome = say_status(dqa_shape_space_get_info(s->space, &info, sizeof info), "read the shape space");
    progress_stage(p, PROGRESS_SETUP);
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_set_weights(s->simulator, o->weights, s->n_weights, progress_callback, p),
                             "set the mean design");
    if (outcome == DONE)
        outcome = say_status(dqa_controller_create_sinusoid(info.n_signals, s->time_step, &sine), "create the sine");
    if (outcome == DONE) outcome = say_status(dqa_tape_clear(s->tape), "clear the tape");
    if (outcome == DONE) outcome = swim_on(s, sine, p, &start);
    if (outcome == DONE) outcome = swim_on(s, sine, p, &end);
    dqa_controller_free(sine);
    if (outcome == DONE) outcome = say_status(dqa_tape_clear(s->tape), "clear the tape");
    *speed = (end - start) / (MEASURED_STEPS * s->time_step);
    return outcome;
}

static int let_water_flow(experiment* e) {
    double* current = e->o.laws.current;
    double speed = 0.0;
    int outcome;
    if (current[0] != 0.0 || current[1] != 0.0 || current[2] != 0.0) return DONE; /* the user's own */
    outcome = measure_speed(&e->s, &e->o, &e->p, &speed);
    if (outcome != DONE) return outcome;
    /* On a grid so coarse that it swims tail first, the water still comes from ahead. */
    current[0] = -CURRENT_SHARE * fabs(speed);
    say("the mean design swims at %.4g mm/s in still water; the water flows at %.4g mm/s", 1e3 * speed,
        1e3 * current[0]);
    return scene_set_current(&e->s, current);
}

static void claim(experiment* e) {
    double least = HUGE_VAL;
    for (int k = OURS + 1; k < e->n_trials; ++k) least = fmin(least, e->trials[k].r.best_loss);
    experiment_claim_add(e, "below_control_only", "ours ends below control alone of every base",
                         e->trials[OURS].r.best_loss, least, FINDING_BELOW);
}

static void curves(const experiment* e, FILE* f) {
    fputs("set xlabel 'iteration' offset 0,0.5\n", f);
    plot_panel(f, "Loss: sum of the distances from the place (m)", 0.075, 0.31);
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
                                  .before = let_water_flow,
                                  .claim = claim,
                                  .curves = curves};
    return experiment_main(&plan, argc, argv);
}
