/* SPDX-License-Identifier: MIT
 *
 * closed_loop — the closed-loop co-optimisation of section 8.2 of Ma et al., "DiffAqua", 2021: a swimmer between
 * clownfish, manta ray and stingray, and the perceptron that senses its motion and drives its 17 muscles, for the
 * distance travelled; the same without the temporal encoding of time; and perceptrons alone, for each of the three
 * animals. `closed_loop --help` lists the options.
 */
#include <math.h>

#include "support/experiment.h"
#include "support/plot.h"

enum { OURS, NO_ENCODING, CLOWNFISH, MANTA_RAY, STINGRAY };

static const double animals[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};

static const trial_plan trials[] = {
    {.name = "ours", .label = "ours", .moves = RUN_BOTH},
    {.name = "no_encoding", .label = "no encoding", .moves = RUN_BOTH, .no_encoding = 1},
    {.name = "clownfish", .label = "clownfish", .moves = RUN_CONTROL, .weights = animals[0]},
    {.name = "manta_ray", .label = "manta ray", .moves = RUN_CONTROL, .weights = animals[1]},
    {.name = "stingray", .label = "stingray", .moves = RUN_CONTROL, .weights = animals[2]},
};

static const char about[] =
    "usage: closed_loop [options]\n"
    "\n"
    "Co-optimises the shape between clownfish, manta ray and stingray and the perceptron that drives it for the\n"
    "distance travelled (ours), the same without temporal encoding (no_encoding), and the perceptron alone for each\n"
    "of the animals (clownfish, manta_ray, stingray).\n";

static const char* const words[] = {"--iterations", "--steps", "--only", NULL};
static const char* const shapes[] = {"clownfish.stl", "manta_ray.stl", "stingray.stl", NULL};

/* Networks that begin nearly still: loud ones mislead the shape before it can swim. */
static const options_form form = {.program = "closed_loop",
                                  .about = about,
                                  .out = "closed_loop-out",
                                  .words = words,
                                  .shapes = shapes,
                                  .quick = {{30, 27, 8}, 8, 30, 0, 0.7},
                                  .shipped = {{60, 54, 14}, 40, 200, 0, 0.7},
                                  .user = {{60, 54, 14}, 40, 200, 0, 0.7},
                                  .mlp = 1,
                                  .network_rate = 0.01,
                                  .network_scale = 0.3,
                                  .lists = 1};

static void claim(experiment* e) {
    const double ours = e->trials[OURS].r.best_loss;
    experiment_claim_add(e, "below_clownfish", "ours ends below control alone of the clownfish", ours,
                         e->trials[CLOWNFISH].r.best_loss, FINDING_BELOW);
    experiment_claim_add(e, "below_manta_ray", "ours ends below control alone of the manta ray", ours,
                         e->trials[MANTA_RAY].r.best_loss, FINDING_BELOW);
    experiment_claim_add(e, "below_stingray", "ours ends below control alone of the stingray", ours,
                         e->trials[STINGRAY].r.best_loss, FINDING_BELOW);
    experiment_claim_add(e, "below_no_encoding", "ours ends below the same without temporal encoding", ours,
                         e->trials[NO_ENCODING].r.best_loss, FINDING_BELOW);
}

static void curves(const experiment* e, FILE* f) {
    fputs("set xlabel 'iteration' offset 0,0.5\n", f);
    plot_panel(f, "Loss: minus the distance travelled (m)", 0.075, 0.31);
    experiment_curves(e, f, "1", 2, 0);
    fputs("set yrange [-0.02:1.02]\n", f);
    plot_panel(f, "Share of each base shape", 0.385, 0.64);
    experiment_shares(e, f);
    fputs("set yrange [-1.05:1.05]\nset xlabel 'time (s)' offset 0,0.5\n", f);
    plot_panel(f, "Signals of the optimised swimmer", 0.715, 0.98);
    experiment_signals(e, f);
    fputs("set autoscale y\n", f);
}

int main(int argc, char** argv) {
    const experiment_plan plan = {.form = &form,
                                  .trials = trials,
                                  .n_trials = (int)(sizeof trials / sizeof trials[0]),
                                  .picture = "closed_loop.png",
                                  .script = "closed_loop.gp",
                                  .shown = OURS,
                                  .first_label = "First swimmer",
                                  .best_label = "Ours, optimised",
                                  .claim = claim,
                                  .curves = curves};
    return experiment_main(&plan, argc, argv);
}
