/* SPDX-License-Identifier: MIT
 *
 * open_loop — the open-loop co-optimisation of section 8.2 of Ma et al., "DiffAqua", 2021: an eel between a vertical,
 * flag-like one and a horizontal, pancake-like one, and the sine that drives it, for the distance travelled; and the
 * same task by the paper's baselines. `open_loop --help` lists the options.
 */
#include <math.h>

#include "support/experiment.h"
#include "support/plot.h"

enum { OURS, ALTERNATE, SHAPE_ONLY, CONTROL_ONLY, CMA_ES };

static const trial_plan trials[] = {
    {.name = "ours", .label = "ours", .moves = RUN_BOTH},
    /* As many steps of each as ours has. */
    {.name = "alternate", .label = "in turn", .moves = RUN_IN_TURN, .times = 2},
    {.name = "shape_only", .label = "shape only", .moves = RUN_WEIGHTS},
    {.name = "control_only", .label = "control only", .moves = RUN_CONTROL},
    {.name = "cma_es", .label = "CMA-ES", .moves = RUN_BOTH, .cma_es = 1},
};

static const char about[] =
    "usage: open_loop [options] [vertical-eel horizontal-eel]\n"
    "\n"
    "Co-optimises shape and sine of an eel for the distance travelled, from the middle between the two meshes and a\n"
    "sine of amplitude 0.5 (ours), and runs the baselines: shape and control in turn (alternate, twice as many\n"
    "iterations), shape_only, control_only, cma_es (8 simulations a generation).\n";

static const char* const words[] = {"--iterations", "--generations", "--steps", "--rate", "--only", NULL};
static const char* const shapes[] = {"eel_vertical.stl", "eel_horizontal.stl", NULL};

static const options_form form = {.program = "open_loop",
                                  .about = about,
                                  .out = "open_loop-out",
                                  .words = words,
                                  .shapes = shapes,
                                  .quick = {{40, 8, 8}, 10, 30, 6, 0.4},
                                  .shipped = {{40, 8, 8}, 20, 100, 250, 0.4},
                                  .user = {{40, 8, 8}, 20, 100, 250, 0.4}};

static void claim(experiment* e) {
    const run* ours = &e->trials[OURS].r;
    const trial* cma = &e->trials[CMA_ES];
    experiment_claim_add(e, "vertical_eel", "the optimised swimmer is a vertical eel", ours->best_x[0], 0.9,
                         FINDING_AT_LEAST);
    experiment_claim_add(e, "stronger_signal", "its signal is stronger than at the start",
                         ours->best_x[ours->n_weights], 1.2 * e->plan->theta[0], FINDING_AT_LEAST);
    experiment_claim_add(e, "below_shape_only", "ours ends below shape-only", ours->best_loss,
                         e->trials[SHAPE_ONLY].r.best_loss, FINDING_BELOW);
    experiment_claim_add(e, "below_control_only", "ours ends below control-only", ours->best_loss,
                         e->trials[CONTROL_ONLY].r.best_loss, FINDING_BELOW);
    experiment_claim_add(e, "below_alternate", "ours is below what alternating has after as many simulations",
                         ours->best_loss, trial_best_within(&e->trials[ALTERNATE], trial_simulations(&e->trials[OURS])),
                         FINDING_BELOW);
    experiment_claim_add(e, "below_cma_es_per_simulation",
                         "ours is below what CMA-ES has after ten times the simulations", ours->best_loss,
                         trial_best_within(cma, 10 * trial_simulations(&e->trials[OURS])), FINDING_BELOW);
    experiment_claim_add(e, "below_cma_es", "ours is below what CMA-ES reaches in all its generations", ours->best_loss,
                         cma->r.best_loss, FINDING_BELOW);
}

static void curves(const experiment* e, FILE* f) {
    const trial* shown = &e->trials[e->shown];
    char seconds[16], simulations[16];
    const int columns = experiment_column_after(e, 0);
    (void)snprintf(seconds, sizeof seconds, "%d", columns + EXPERIMENT_CPU_SECONDS);
    (void)snprintf(simulations, sizeof simulations, "%d", columns + EXPERIMENT_SIMULATIONS);
    fputs("set xlabel 'simulations' offset 0,0.5\nset logscale x\n", f);
    plot_panel(f, "Lowest loss so far (m) over simulations", 0.075, 0.31);
    experiment_curves(e, f, simulations, 2, 1);
    fputs("set xlabel 'processor time (s)' offset 0,0.5\n", f);
    plot_panel(f, "The same over processor time", 0.385, 0.64);
    experiment_curves(e, f, seconds, 2, 1);
    fputs("unset logscale x\nset xlabel 'iteration' offset 0,0.5\nset yrange [-0.02:1.02]\n", f);
    plot_panel(f, "Ours: design and signal", 0.715, 0.98);
    fprintf(f,
            "plot '%s/history.csv' every ::1 using 1:%d with linespoints lt 1 pt 7 ps 0.6 title 'vertical eel', \\\n"
            "     '' every ::1 using 1:%d with linespoints lt 2 pt 7 ps 0.6 title 'amplitude a', \\\n"
            "     '' every ::1 using 1:($%d/%.9g) with linespoints lt 3 pt 7 ps 0.6 title '\u03c9 / 2\u03c9\u2080'\n"
            "set autoscale y\n",
            shown->plan->name, experiment_column_weight(e, 0), 3 + (int)shown->r.n_weights, 4 + (int)shown->r.n_weights,
            2.0 * SCENE_OMEGA0);
}

int main(int argc, char** argv) {
    const experiment_plan plan = {.form = &form,
                                  .trials = trials,
                                  .n_trials = (int)(sizeof trials / sizeof trials[0]),
                                  .theta = {0.5, SCENE_OMEGA0, 0.0},
                                  .picture = "open_loop.png",
                                  .script = "open_loop.gp",
                                  .shown = OURS,
                                  .first_label = "First swimmer",
                                  .best_label = "Ours, optimised",
                                  .claim = claim,
                                  .curves = curves};
    return experiment_main(&plan, argc, argv);
}
