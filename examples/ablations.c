/* SPDX-License-Identifier: MIT
 *
 * ablations — section 8.4 of Ma et al., "DiffAqua", 2021: what the scale of parameters and the first design do to the
 * co-optimisation of twelve bases and a network. `ablations --help` lists the
 * options.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/checkpoint.h"
#include "support/findings.h"
#include "support/leg.h"
#include "support/options.h"
#include "support/output.h"
#include "support/plot.h"
#include "support/progress.h"
#include "support/say.h"
#include "support/scene.h"
#include "support/shapes.h"
#include "support/summary.h"

#define PICTURE "ablations.png"
#define SCRIPT "ablations.gp"
#define CLEARLY 0.05 /* by which losses differ, as a share of what was gained */
#define N_SCALES 3
#define N_STARTS 10
#define N_LEGS (N_SCALES + N_STARTS)

static const char about[] =
    "usage: ablations [options] [12 meshes]\n"
    "\n"
    "Co-optimises shape and network of a swimmer between four sharks, seven goldfish and a submarine (unless others "
    "are\n"
    "named) for the distance travelled or another objective: with rates of shape and network as everywhere, equal, "
    "and\n"
    "exchanged; and from ten random shapes and networks.\n";

static const char* const words[] = {"--iterations", "--steps", "--objective", "--current", NULL};

static const options_form form = {.program = "ablations",
                                  .about = about,
                                  .out = "ablations-out",
                                  .mlp = 1,
                                  .words = words,
                                  .shapes = shapes_twelve,
                                  .quick = {{28, 8, 12}, 3, 12, 0, 0.7},
                                  .shipped = {{60, 16, 26}, 20, 100, 0, 0.7},
                                  .user = {{60, 16, 26}, 20, 100, 0, 0.7}};

/* Rates of weights and network, relative to 0.05 and 0.01: as they are, both their geometric mean, and exchanged. */
#define ROOT_5 2.23606797749979
static const struct {
    const char *name, *label;
    double rates[2];
} scales[N_SCALES] = {{"default", "default", {1.0, 1.0}},
                      {"balanced", "balanced", {1.0 / ROOT_5, ROOT_5}},
                      {"reversed", "reversed", {0.2, 5.0}}};

typedef struct job {
    options o;
    scene s;
    progress p;
    leg legs[N_LEGS]; /* the scales, then the starts */
    int n_legs;
    double *common, *start; /* [unknowns]: the first design of the scales, and that of the next run */
} job;

/* ------------------------------------------------------------------ first designs */
/* 53 random bits of a multiplicative generator (Knuth's MMIX), in (0, 1). */
static double uniform(uint64_t* state) {
    *state = 6364136223846793005u * *state + 1442695040888963407u;
    return ((double)(*state >> 11) + 0.5) / 9007199254740992.0;
}

/* Weights uniform on the simplex, and the network of the seed. */
static int random_start(job* w, uint64_t seed) {
    dqa_mlp_options net;
    dqa_shape_space_info info;
    dqa_controller* network = NULL;
    uint64_t state = seed;
    double sum = 0.0;
    int outcome = say_status(dqa_shape_space_get_info(w->s.space, &info, sizeof info), "read the shape space");
    if (outcome == DONE) outcome = say_status(dqa_mlp_options_init(&net, sizeof net), "set up a network");
    if (outcome != DONE) return outcome;
    for (int k = 0; k < 8; ++k) (void)uniform(&state); /* small seeds differ in few bits */
    for (int64_t i = 0; i < w->s.n_weights; ++i) sum += w->start[i] = -log(uniform(&state));
    for (int64_t i = 0; i < w->s.n_weights; ++i) w->start[i] /= sum;
    net.n_signals = info.n_signals;
    net.seed = seed;
    outcome = say_status(dqa_controller_create_mlp(&net, &network), "create a network");
    if (outcome == DONE)
        outcome = say_status(dqa_controller_get_parameters(network, w->start + w->s.n_weights, w->s.n_control),
                             "read a network");
    dqa_controller_free(network);
    return outcome;
}

/* The mean of the bases, and the network as the library makes it: to be read before any run changes it. */
static int common_start(job* w) {
    const size_t n = (size_t)(w->s.n_weights + w->s.n_control);
    w->common = malloc(n * sizeof *w->common);
    w->start = malloc(n * sizeof *w->start);
    if (w->common == NULL || w->start == NULL) return say_no_memory();
    memcpy(w->common, w->o.weights, (size_t)w->s.n_weights * sizeof *w->common);
    return say_status(dqa_controller_get_parameters(w->s.controller, w->common + w->s.n_weights, w->s.n_control),
                      "read the controller");
}

/* ------------------------------------------------------------------ runs */
static int run_leg(job* w, int k) {
    leg* l = &w->legs[k];
    char what[64];
    const int is_scale = k < N_SCALES;
    const double* rates = is_scale ? scales[k].rates : NULL;
    int outcome = is_scale ? DONE : random_start(w, (uint64_t)(k - N_SCALES + 1));
    if (outcome != DONE) return outcome;
    if (is_scale)
        (void)snprintf(l->name, sizeof l->name, "%s", scales[k].name);
    else
        (void)snprintf(l->name, sizeof l->name, "start_%02d", k - N_SCALES + 1);
    (void)snprintf(what, sizeof what, "rates %.17g %.17g", is_scale ? rates[0] : 1.0, is_scale ? rates[1] : 1.0);
    ++w->n_legs;
    return leg_descend(l, &w->o, &w->s, &w->p, what, is_scale ? w->common : w->start, rates, w->o.iterations,
                       k * w->o.iterations);
}

/* ------------------------------------------------------------------ what it shows */
enum { N_FINDINGS = 3 };

static double gain(const leg* l) {
    return l->r.rows[0].loss - l->r.best_loss;
}

static void find(const job* w, finding* found) {
    double apart = 0.0, largest = 0.0, least = HUGE_VAL, low = HUGE_VAL, high = -HUGE_VAL, mean = 0.0;
    for (int k = 0; k < N_SCALES; ++k) {
        largest = fmax(largest, gain(&w->legs[k]));
        for (int other = 0; other < k; ++other)
            for (int64_t i = 0; i < w->o.iterations; ++i)
                apart = fmax(apart, fabs(w->legs[k].r.rows[i].loss - w->legs[other].r.rows[i].loss));
    }
    for (int k = N_SCALES; k < N_LEGS; ++k) {
        const leg* l = &w->legs[k];
        least = fmin(least, gain(l) / fabs(l->r.rows[0].loss));
        low = fmin(low, l->r.best_loss);
        high = fmax(high, l->r.best_loss);
        mean += gain(l) / N_STARTS;
    }
    found[0] = (finding){"scales_differ", "the curves of the scales are apart (share of the largest gain)",
                         largest > 0.0 ? apart / largest : 0.0, CLEARLY, FINDING_AT_LEAST};
    found[1] = (finding){"falls_from_every_start", "the loss falls from every start (least share of its first value)",
                         least, CLEARLY, FINDING_AT_LEAST};
    found[2] = (finding){"starts_end_apart", "not all starts end at the same loss (spread, share of the mean gain)",
                         mean > 0.0 ? (high - low) / mean : 0.0, CLEARLY, FINDING_AT_LEAST};
}

/* ------------------------------------------------------------------ results */
/* Columns: iteration, the loss of each scale, of each start, and the mean of the starts. */
static int write_history(const job* w) {
    output_file file;
    if (output_open(&file, w->o.out, "history.csv") != DONE) return FAILED;
    fputs("iteration", file.stream);
    for (int k = 0; k < N_LEGS; ++k) fprintf(file.stream, ",%s", w->legs[k].name);
    fputs(",mean_of_starts\n", file.stream);
    for (int64_t i = 0; i < w->o.iterations; ++i) {
        double mean = 0.0;
        fprintf(file.stream, "%lld", (long long)i + 1);
        for (int k = 0; k < N_LEGS; ++k) {
            fprintf(file.stream, ",%.17g", w->legs[k].r.rows[i].loss);
            if (k >= N_SCALES) mean += w->legs[k].r.rows[i].loss / N_STARTS;
        }
        fprintf(file.stream, ",%.17g\n", mean);
    }
    return output_commit(&file);
}

static int draw(const job* w, int* drawn) {
    output_file file;
    FILE* f;
    int outcome = output_open(&file, w->o.out, SCRIPT);
    if (outcome != DONE) return outcome;
    f = file.stream;
    plot_page(f, PICTURE, SCRIPT, 1600, 640);
    plot_lines(f);
    fputs(
        "set bmargin at screen 0.13; set tmargin at screen 0.90\nset xlabel 'simulations'\nset ylabel 'loss'\nset key "
        "bottom left\n"
        "set lmargin at screen 0.075; set rmargin at screen 0.47\n"
        "set title 'Rates of shape and network: as everywhere, equal, exchanged' font ',16'\n",
        f);
    for (int k = 0; k < N_SCALES; ++k)
        fprintf(f, "%s'history.csv' every ::1 using 1:%d with lines lt %d title '%s'", k > 0 ? ", \\\n     " : "plot ",
                k + 2, k + 1, scales[k].label);
    fputs(
        "\nset lmargin at screen 0.57; set rmargin at screen 0.98\n"
        "set title 'Ten random shapes and networks' font ',16'\n",
        f);
    for (int k = 0; k < N_STARTS; ++k)
        fprintf(f, "%s'history.csv' every ::1 using 1:%d with lines lw 1.5 lc rgb '#8fb8d8' %s",
                k > 0 ? ", \\\n     " : "plot ", N_SCALES + k + 2, k > 0 ? "notitle" : "title 'each'");
    fprintf(f, ", \\\n     '' every ::1 using 1:%d with lines lt 2 dt 2 title 'mean'\nunset multiplot\nset output\n",
            N_LEGS + 2);
    outcome = output_commit(&file);
    return outcome == DONE ? plot_draw(w->o.out, PICTURE, SCRIPT, drawn) : outcome;
}

static void write_leg(const job* w, int k, json* j) {
    const leg* l = &w->legs[k];
    const run* r = &l->r;
    json_open(j, l->name, '{');
    if (k < N_SCALES) summary_numbers(j, "rates", (const double[2]){r->rates[0], r->rates[r->n_weights]}, 2);
    json_integer(j, "iterations", r->iteration);
    json_integer(j, "simulations", leg_simulations(l));
    json_number(j, "loss_first", r->rows[0].loss);
    json_number(j, "loss_best", r->best_loss);
    json_number(j, "loss_last", r->rows[r->iteration - 1].loss);
    summary_numbers(j, "first_weights", r->row_x, r->n_weights);
    summary_numbers(j, "best_weights", r->best_x, r->n_weights);
    json_number(j, "seconds", r->seconds);
    json_number(j, "cpu_seconds", r->cpu_before);
    json_close(j, '}');
}

/* Mean size of the gradient by a weight over that by a parameter of the network, at the common start: 2-norms of the
 * groups over the roots of their numbers. */
static double gradient_ratio(const job* w) {
    const run* r = &w->legs[0].r;
    return r->rows[0].gradient_weights / r->rows[0].gradient_control *
           sqrt((double)r->n_control / (double)r->n_weights);
}

static int write_summary(const job* w) {
    finding found[N_FINDINGS];
    double cpu_seconds = 0.0;
    output_file file;
    json j;
    find(w, found);
    for (int k = 0; k < N_LEGS; ++k) cpu_seconds += w->legs[k].r.cpu_before;
    if (output_open(&file, w->o.out, SUMMARY_FILE) != DONE) return FAILED;
    json_begin(&j, file.stream);
    summary_program(&j, form.program);
    json_boolean(&j, "all_shown", findings_hold(found, N_FINDINGS));
    findings_write(&j, found, N_FINDINGS);
    json_number(&j, "cpu_seconds", cpu_seconds);
    json_integer(&j, "parameters", w->s.n_weights + w->s.n_control);
    json_number(&j, "gradient_ratio", gradient_ratio(w));
    json_open(&j, "bases", '[');
    for (int64_t b = 0; b < w->s.n_weights; ++b)
        json_string(&j, NULL, dqa_shape_space_base_name(w->s.space, (int32_t)b));
    json_close(&j, ']');
    json_open(&j, "scales", '{');
    for (int k = 0; k < N_SCALES; ++k) write_leg(w, k, &j);
    json_close(&j, '}');
    json_open(&j, "starts", '{');
    for (int k = N_SCALES; k < N_LEGS; ++k) write_leg(w, k, &j);
    json_close(&j, '}');
    json_open(&j, "machine", '{');
    summary_machine(&j, &w->o);
    json_close(&j, '}');
    json_open(&j, "settings", '{');
    summary_settings(&j, &w->o, &w->legs[0].r, &w->s);
    json_close(&j, '}');
    json_end(&j);
    return output_commit(&file);
}

static int list(const job* w, int drawn) {
    finding found[N_FINDINGS];
    find(w, found);
    for (int k = 0; k < N_LEGS; ++k)
        printf("%-9s loss %9.6f -> %9.6f\n", w->legs[k].name, w->legs[k].r.rows[0].loss, w->legs[k].r.best_loss);
    findings_print(found, N_FINDINGS);
    printf("Files:\n");
    if (drawn) printf("  %s/%s  (made by %s)\n", w->o.out, PICTURE, SCRIPT);
    printf("  %s/history.csv\n  %s/%s\n", w->o.out, w->o.out, SUMMARY_FILE);
    if (fflush(stdout) == 0 && !ferror(stdout)) return DONE;
    say("cannot write to the standard output");
    return FAILED;
}

/* ------------------------------------------------------------------ all of it */
static int work(job* w) {
    int outcome, drawn = 0;
    progress_begin(&w->p, N_LEGS * w->o.iterations, 0);
    progress_part(&w->p, 1, 2, w->p.iterations, 1.0);
    outcome = scene_create(&w->s, &w->o, &w->p);
    if (outcome == DONE) outcome = common_start(w);
    for (int k = 0; k < N_LEGS && outcome == DONE; ++k) outcome = run_leg(w, k);
    progress_stage(&w->p, PROGRESS_OUTPUT);
    if (outcome == DONE) outcome = write_history(w);
    if (outcome == DONE) outcome = draw(w, &drawn);
    if (outcome == DONE) outcome = write_summary(w);
    progress_end(&w->p);
    return outcome == DONE ? list(w, drawn) : outcome;
}

static int prepare(job* w, int* created) {
    char* first = output_path(w->o.out, scales[0].name);
    const int found = first != NULL && checkpoint_exists(first);
    int outcome = first != NULL ? DONE : FAILED;
    free(first);
    if (outcome == DONE && w->o.resume && !found) {
        say("there is no checkpoint in %s to resume from; start without --resume", w->o.out);
        return USAGE;
    }
    if (outcome == DONE) outcome = output_folder(w->o.out, created);
    if (outcome == DONE && !w->o.resume && found)
        say("starting anew in %s; --resume would have continued the run that lies there", w->o.out);
    /* The summary is written last: while it is missing, the folder is known to be incomplete. */
    if (outcome == DONE) output_remove(w->o.out, SUMMARY_FILE);
    return outcome;
}

int main(int argc, char** argv) {
    static job w;
    int action = OPTIONS_RUN, created = 0, outcome;
    say_program(form.program);
    outcome = options_parse(&w.o, &form, argc, argv, &action);
    if (outcome == DONE && action == OPTIONS_RUN) {
        outcome = prepare(&w, &created);
        if (outcome == DONE) outcome = work(&w);
        if (outcome == INTERRUPTED) {
            say("interrupted after %lld simulations", (long long)w.p.iteration);
            if (w.n_legs > 0) options_say_resume(argc, argv);
        }
        for (int k = 0; k < w.n_legs; ++k) leg_free(&w.legs[k]);
        scene_free(&w.s);
        if (created) (void)rmdir(w.o.out);
    }
    free(w.common);
    free(w.start);
    options_free(&w.o);
    return outcome;
}
