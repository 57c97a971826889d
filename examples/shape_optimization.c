/* SPDX-License-Identifier: MIT
 *
 * shape_optimization — section 8.1 of Ma et al., "DiffAqua", 2021: a shark swims by beating its tail sideways and an
 * orca does not, so under a fixed sine a swimmer between the two has to become the shark, from the orca itself and from
 * the middle. `shape_optimization --help` lists the options.
 */
#include <math.h>

#include "support/experiment.h"
#include "support/plot.h"

enum { FROM_ORCA, FROM_MIDDLE };

/* Shares of shark and orca. */
static const double orca[] = {0.0, 1.0}, middle[] = {0.5, 0.5};

static const trial_plan trials[] = {
    {.name = "from_orca", .label = "from the orca", .moves = RUN_WEIGHTS, .weights = orca},
    {.name = "from_middle", .label = "from the middle", .moves = RUN_WEIGHTS, .weights = middle},
};

static const char about[] =
    "usage: shape_optimization [options] [shark orca]\n"
    "\n"
    "Finds the shape between the two meshes that travels farthest under a sine of amplitude 1 and a period of 12\n"
    "steps, from the orca (from_orca) and from the middle (from_middle); either ends earlier where it has converged.\n";

static const char* const words[] = {"--iterations", "--steps", "--only", NULL};
static const char* const shapes[] = {"great_white.stl", "orca.stl", NULL};

/* Sharper kernels make fins that flicker between cells, and the way from one animal to the other has a local minimum.
 */
static const options_form form = {.program = "shape_optimization",
                                  .about = about,
                                  .out = "shape_optimization-out",
                                  .words = words,
                                  .shapes = shapes,
                                  .quick = {{30, 8, 14}, 40, 24, 0, 1.0},
                                  .shipped = {{60, 16, 26}, 40, 100, 0, 0.7},
                                  .user = {{60, 16, 26}, 40, 100, 0, 0.7},
                                  .fixed_control = 1};

static void claim(experiment* e) {
    const run *from_orca = &e->trials[FROM_ORCA].r, *from_middle = &e->trials[FROM_MIDDLE].r;
    const double loss_of_orca = from_orca->rows[0].loss;
    experiment_claim_add(e, "shark_from_orca", "from the orca it becomes the shark", from_orca->best_x[0], 0.9,
                         FINDING_AT_LEAST);
    experiment_claim_add(e, "shark_from_middle", "from the middle it becomes the shark", from_middle->best_x[0], 0.9,
                         FINDING_AT_LEAST);
    experiment_claim_add(e, "lower_from_orca", "from the orca the loss ends below that of the orca",
                         from_orca->best_loss, loss_of_orca, FINDING_BELOW);
    experiment_claim_add(e, "lower_from_middle", "from the middle the loss ends below that of the orca",
                         from_middle->best_loss, loss_of_orca, FINDING_BELOW);
}

static void curves(const experiment* e, FILE* f) {
    fputs("set xlabel 'iteration' offset 0,0.5\n", f);
    plot_panel(f, "Loss: minus the distance travelled (m)", 0.075, 0.48);
    experiment_curves(e, f, "1", 2, 0);
    fputs("set yrange [-0.02:1.02]\n", f);
    plot_panel(f, "Share of the shark", 0.565, 0.98);
    experiment_curves(e, f, "1", experiment_column_weight(e, 0), 0);
    fputs("set autoscale y\n", f);
}

int main(int argc, char** argv) {
    const experiment_plan plan = {.form = &form,
                                  .trials = trials,
                                  .n_trials = (int)(sizeof trials / sizeof trials[0]),
                                  .theta = {1.0, SCENE_OMEGA0, 0.0},
                                  .picture = "shape_optimization.png",
                                  .script = "shape_optimization.gp",
                                  .shown = FROM_ORCA,
                                  .first_label = "Orca",
                                  .best_label = "Optimised from the orca",
                                  .claim = claim,
                                  .curves = curves};
    return experiment_main(&plan, argc, argv);
}
