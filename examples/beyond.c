/* SPDX-License-Identifier: MIT
 *
 * beyond — two things that "DiffAqua" (Ma et al. 2021) leaves open, on the eel of its open-loop co-optimisation
 * (section 8.2): Young's modulus along the body as one more unknown, and searches that get out of local minima, which
 * its section 8.4 names as future work. `beyond --help` lists the options.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/findings.h"
#include "support/interrupt.h"
#include "support/options.h"
#include "support/output.h"
#include "support/plot.h"
#include "support/progress.h"
#include "support/say.h"
#include "support/scene.h"
#include "support/summary.h"

#define PICTURE "beyond.png"
#define SCRIPT "beyond.gp"
#define KNOTS 5                /* of the stiffness along the body, straight between them */
#define LIMIT 1.38629436111989 /* ln 4: how far the logarithm of E over E0 may go */
#define RATE 0.1               /* of that logarithm */
#define STARTS 4               /* of the search from several */
#define POPULATION 8
#define PENALTY 1.0 /* m: of a distance of one unit from the bounds */

static const char about[] =
    "usage: beyond [options] [vertical-eel horizontal-eel]\n"
    "\n"
    "Co-optimises shape and sine of an eel for the distance travelled, with a body of uniform stiffness as given, of "
    "one\n"
    "that is optimised too, and of a profile of it along the body; and searches for shape and sine in three ways in "
    "as\n"
    "many simulations: one descent, several descents from other starts, and CMA-ES followed by a descent.\n";

static const char* const words[] = {"--iterations", "--steps", NULL};
static const char* const shapes[] = {"eel_vertical.stl", "eel_horizontal.stl", NULL};

static const options_form form = {.program = "beyond",
                                  .about = about,
                                  .out = "beyond-out",
                                  .brief = 1,
                                  .words = words,
                                  .shapes = shapes,
                                  .quick = {{24, 8, 8}, 6, 20, 0, 0.4},
                                  .shipped = {{40, 8, 8}, 20, 60, 0, 0.4},
                                  .user = {{40, 8, 8}, 20, 60, 0, 0.4}};

enum { GIVEN, UNIFORM, PROFILE, DESCENT, SEVERAL, CMA_ES, N_METHODS };

static const struct {
    const char *name, *label;
} methods[N_METHODS] = {{"given", "E as given"},    {"uniform", "one E"},         {"profile", "E along the body"},
                        {"descent", "one descent"}, {"several", "four descents"}, {"cma_es", "CMA-ES, then a descent"}};

/* What a method has found. */
typedef struct record {
    double* losses; /* of each simulation in order */
    int64_t n;
    double loss;           /* the lowest */
    double x[8], s[KNOTS]; /* its unknowns: shape and sine, and logarithms of E over E0 */
    int n_s;
} record;

typedef struct job {
    options o;
    scene s;
    progress p;
    double young;   /* Pa: E0 */
    double* moduli; /* [cells] */
    double* bar;    /* [cells] */
    record found[N_METHODS];
    int64_t simulations;   /* of all methods */
    double gradient_error; /* of the loss by the stiffness, relative */
} job;

/* ------------------------------------------------------------------ the loss and its gradient */
/* Hat function of knot k of n at the share t of the box's length. */
static double hat(int k, int n, double t) {
    return n == 1 ? 1.0 : fmax(0.0, 1.0 - fabs(t * (n - 1) - k));
}

static int64_t n_cells(const job* w) {
    return (int64_t)w->o.grid[0] * w->o.grid[1] * w->o.grid[2];
}

/* Share of the box's length at the middle of a cell. */
static double along(const job* w, int64_t cell) {
    const int64_t slice = (int64_t)w->o.grid[1] * w->o.grid[2];
    return ((double)(cell / slice) + 0.5) / (double)w->o.grid[0];
}

static int set_stiffness(job* w, const double* s, int n_s) {
    for (int64_t c = 0; c < n_cells(w); ++c) {
        double sum = 0.0;
        for (int k = 0; k < n_s; ++k) sum += s[k] * hat(k, n_s, along(w, c));
        w->moduli[c] = w->young * exp(sum);
    }
    return say_status(dqa_simulator_set_material(w->s.simulator, w->moduli, NULL, n_cells(w)), "set the stiffness");
}

static int sweep_back(job* w, double* gx, double* gs, int n_s) {
    dqa_adjoint* a = NULL;
    const int64_t n = n_cells(w);
    int outcome = say_status(dqa_adjoint_create(w->s.tape, &a), "create the adjoint");
    progress_stage(&w->p, PROGRESS_BACKWARD);
    if (outcome == DONE)
        outcome = say_status(dqa_adjoint_seed_objective(a, w->s.terms, w->s.n_terms), "seed the adjoint");
    if (outcome == DONE) outcome = say_status(dqa_adjoint_backward(a, 0, progress_callback, &w->p), "go back");
    if (outcome == DONE)
        outcome = say_status(dqa_adjoint_get(a, DQA_WRT_WEIGHTS, gx, w->s.n_weights), "read a gradient");
    if (outcome == DONE)
        outcome =
            say_status(dqa_adjoint_get(a, DQA_WRT_CONTROL, gx + w->s.n_weights, w->s.n_control), "read a gradient");
    if (outcome == DONE && n_s > 0)
        outcome = say_status(dqa_adjoint_get(a, DQA_WRT_YOUNGS_MODULUS, w->bar, n), "read a gradient");
    for (int k = 0; k < n_s && outcome == DONE; ++k) {
        gs[k] = 0.0;
        for (int64_t c = 0; c < n; ++c) gs[k] += w->bar[c] * w->moduli[c] * hat(k, n_s, along(w, c));
    }
    if (outcome == DONE) progress_stage_done(&w->p);
    dqa_adjoint_free(a);
    return outcome;
}

/* Loss of x and s, with its gradient unless gx is NULL. */
static int evaluate(job* w, const double* x, const double* s, int n_s, double* loss, double* gx, double* gs) {
    int outcome = set_stiffness(w, s, n_s);
    if (outcome == DONE) outcome = scene_swim(&w->s, x, &w->p);
    if (outcome == DONE)
        outcome = say_status(dqa_tape_objective(w->s.tape, w->s.terms, w->s.n_terms, loss, NULL), "evaluate the loss");
    return outcome == DONE && gx != NULL ? sweep_back(w, gx, gs, n_s) : outcome;
}

static void keep(job* w, record* r, const double* x, const double* s, double loss) {
    if (r->n == 0 || loss < r->loss) {
        r->loss = loss;
        memcpy(r->x, x, (size_t)(w->s.n_weights + w->s.n_control) * sizeof *x);
        if (s != NULL) memcpy(r->s, s, (size_t)r->n_s * sizeof *s);
    }
    r->losses[r->n++] = loss;
    ++w->simulations;
}

/* ------------------------------------------------------------------ a descent */
/* Adam from x, and from the given stiffness. */
static int descend(job* w, record* r, const double* x, int64_t iterations) {
    const int64_t n_control = w->s.n_control;
    double s[KNOTS] = {0.0}, first[KNOTS] = {0.0}, second[KNOTS] = {0.0}, rates[KNOTS], gx[8], gs[KNOTS];
    run u;
    int outcome = run_create(&u, &w->o, w->s.n_weights, x + w->s.n_weights, n_control, SCENE_OMEGA0);
    if (outcome != DONE) return outcome;
    memcpy(u.x, x, (size_t)w->s.n_weights * sizeof *x);
    for (int k = 0; k < KNOTS; ++k) rates[k] = RATE;
    for (int64_t i = 0; i < iterations && outcome == DONE; ++i) {
        history_row row = {0};
        const double started = progress_clock();
        outcome = interrupted() ? INTERRUPTED : evaluate(w, u.x, s, r->n_s, &row.loss, gx, gs);
        if (outcome != DONE) break;
        keep(w, r, u.x, s, row.loss);
        progress_iteration(&w->p, w->simulations, row.loss, r->loss, progress_clock() - started);
        outcome = run_advance(&u, &row, gx);
        if (outcome == DONE && r->n_s > 0)
            outcome = say_status(dqa_adam_step(s, gs, rates, first, second, r->n_s, i + 1), "take an Adam step");
        for (int k = 0; k < r->n_s; ++k) s[k] = fmin(LIMIT, fmax(-LIMIT, s[k]));
    }
    run_free(&u);
    return outcome;
}

/* ------------------------------------------------------------------ searches */
static double uniform(uint64_t* state, double from, double to) {
    *state = 6364136223846793005u * *state + 1442695040888963407u;
    return from + (to - from) * (((double)(*state >> 11) + 0.5) / 9007199254740992.0);
}

/* The middle first, then designs and signals at random. */
static int search_from_several(job* w, record* r, const double* middle, int64_t simulations) {
    uint64_t state = 1;
    int outcome = DONE;
    for (int k = 0; k < STARTS && outcome == DONE; ++k) {
        const int64_t share = simulations * (k + 1) / STARTS - simulations * k / STARTS;
        double x[8];
        memcpy(x, middle, sizeof x);
        if (k > 0) {
            x[0] = uniform(&state, 0.0, 1.0);
            x[1] = 1.0 - x[0];
            x[2] = uniform(&state, 0.2, 1.0);
            x[3] = uniform(&state, 0.5, 2.0) * SCENE_OMEGA0;
            x[4] = uniform(&state, -0.5, 0.5) * SCENE_PI;
        }
        if (share > 0) outcome = descend(w, r, x, share);
    }
    return outcome;
}

/* One generation: candidates at the nearest design within the bounds, with the squared distance as a penalty. */
static int generation(job* w, record* r, const run* u, dqa_cma_es* search) {
    double x[8 * POPULATION], values[POPULATION];
    int outcome = say_status(dqa_cma_es_ask(search, x, POPULATION * u->n), "ask for candidates");
    for (int k = 0; k < POPULATION && outcome == DONE; ++k) {
        double nearest[8], loss = 0.0;
        const double started = progress_clock();
        memcpy(nearest, x + k * u->n, (size_t)u->n * sizeof *nearest);
        outcome = interrupted() ? INTERRUPTED : run_project(u, nearest);
        if (outcome == DONE) outcome = evaluate(w, nearest, NULL, 0, &loss, NULL, NULL);
        if (outcome != DONE) break;
        keep(w, r, nearest, NULL, loss);
        progress_iteration(&w->p, w->simulations, loss, r->loss, progress_clock() - started);
        values[k] = loss;
        for (int64_t i = 0; i < u->n; ++i) {
            const double distance = (x[k * u->n + i] - nearest[i]) / u->units[i];
            values[k] += PENALTY * distance * distance;
        }
    }
    return outcome == DONE ? say_status(dqa_cma_es_tell(search, values, POPULATION), "tell their losses") : outcome;
}

/* CMA-ES for about half of the simulations, then a descent from its best. */
static int search_globally(job* w, record* r, const double* middle, int64_t simulations) {
    const int64_t generations = simulations / (2 * POPULATION) > 0 ? simulations / (2 * POPULATION) : 1;
    dqa_cma_es_options settings;
    dqa_cma_es* search = NULL;
    run u;
    int outcome = run_create(&u, &w->o, w->s.n_weights, middle + w->s.n_weights, w->s.n_control, SCENE_OMEGA0);
    if (outcome == DONE) outcome = say_status(dqa_cma_es_options_init(&settings, sizeof settings), "set up the search");
    if (outcome == DONE) {
        settings.population = POPULATION;
        outcome = say_status(dqa_cma_es_create(&settings, middle, u.units, u.n, &search), "create the search");
    }
    for (int64_t k = 0; k < generations && outcome == DONE; ++k) outcome = generation(w, r, &u, search);
    dqa_cma_es_free(search);
    run_free(&u);
    if (outcome == DONE && simulations > r->n) {
        double best[8];
        memcpy(best, r->x, sizeof best);
        outcome = descend(w, r, best, simulations - r->n);
    }
    return outcome;
}

/* ------------------------------------------------------------------ proof */
/* The gradient by the stiffness against a central difference along itself, at the first design. */
static int prove(job* w, const double* middle) {
    const double step = 0.02;
    double s[KNOTS] = {0.0}, gx[8], gs[KNOTS], loss[2] = {0.0, 0.0}, square = 0.0;
    int outcome = evaluate(w, middle, s, KNOTS, &loss[0], gx, gs);
    for (int k = 0; k < KNOTS; ++k) square += gs[k] * gs[k];
    for (int side = 0; side < 2 && outcome == DONE; ++side) {
        for (int k = 0; k < KNOTS; ++k) s[k] = (side == 0 ? -step : step) * gs[k] / sqrt(square);
        outcome = evaluate(w, middle, s, KNOTS, &loss[side], NULL, NULL);
    }
    w->gradient_error = fabs((loss[1] - loss[0]) / (2.0 * step) / sqrt(square) - 1.0);
    return outcome;
}

/* ------------------------------------------------------------------ what it shows */
enum { N_FINDINGS = 4 };

static void find(const job* w, finding* found) {
    const record* r = w->found;
    found[0] = (finding){"gradient_of_stiffness", "the gradient by the stiffness agrees with a difference (relative)",
                         w->gradient_error, 0.01, FINDING_BELOW};
    found[1] = (finding){"stiffness_pays", "a stiffness that is optimised too swims farther than the given one",
                         fmin(r[UNIFORM].loss, r[PROFILE].loss), r[GIVEN].loss, FINDING_BELOW};
    found[2] = (finding){"several_starts_pay", "several descents end below one of as many simulations", r[SEVERAL].loss,
                         r[DESCENT].loss, FINDING_BELOW};
    found[3] = (finding){"cma_es_first_pays", "CMA-ES and then a descent ends below one of as many simulations",
                         r[CMA_ES].loss, r[DESCENT].loss, FINDING_BELOW};
}

/* ------------------------------------------------------------------ results */
static int write_history(const job* w) {
    output_file file;
    if (output_open(&file, w->o.out, "history.csv") != DONE) return FAILED;
    fputs("method,simulation,loss,lowest\n", file.stream);
    for (int m = 0; m < N_METHODS; ++m) {
        double lowest = HUGE_VAL;
        for (int64_t i = 0; i < w->found[m].n; ++i) {
            lowest = fmin(lowest, w->found[m].losses[i]);
            fprintf(file.stream, "%s,%lld,%.17g,%.17g\n", methods[m].name, (long long)i + 1, w->found[m].losses[i],
                    lowest);
        }
    }
    return output_commit(&file);
}

static int write_profile(const job* w) {
    output_file file;
    if (output_open(&file, w->o.out, "profile.csv") != DONE) return FAILED;
    fputs("share_from_tail,given,uniform,profile\n", file.stream);
    for (int k = 0; k < KNOTS; ++k)
        fprintf(file.stream, "%.17g,1,%.17g,%.17g\n", (double)k / (KNOTS - 1), exp(w->found[UNIFORM].s[0]),
                exp(w->found[PROFILE].s[k]));
    return output_commit(&file);
}

static void draw_losses(FILE* f, int first, int end) {
    for (int m = first; m < end; ++m)
        fprintf(f, "%s'history.csv' every ::1 using (strcol(1) eq '%s' ? $2 : NaN):4 with lines lt %d title '%s'",
                m > first ? ", \\\n     " : "plot ", methods[m].name, m - first + 1, methods[m].label);
    fputs("\n", f);
}

static int draw(const job* w, int* drawn) {
    output_file file;
    FILE* f;
    int outcome = output_open(&file, w->o.out, SCRIPT);
    if (outcome != DONE) return outcome;
    f = file.stream;
    plot_page(f, PICTURE, SCRIPT, 1600, 560);
    plot_lines(f);
    fputs(
        "set bmargin at screen 0.13; set tmargin at screen 0.90\nset key top right\n"
        "set lmargin at screen 0.06; set rmargin at screen 0.33\nset xlabel 'simulations'\n"
        "set title 'Lowest loss so far (m)' font ',16'\n",
        f);
    draw_losses(f, GIVEN, PROFILE + 1);
    fputs(
        "set lmargin at screen 0.39; set rmargin at screen 0.65\nset title 'Stiffness E / E₀ along the body' font "
        "',16'\nset xlabel 'tail to head'\nset logscale y 2\nset yrange [0.22:4.5]\n"
        "plot 'profile.csv' every ::1 using 1:2 with lines lt 1 title 'as given', '' every ::1 using 1:3 with lines lt "
        "2 "
        "title 'one E', '' every ::1 using 1:4 with linespoints lt 3 pt 7 title 'E along the body'\n"
        "unset logscale y\nset autoscale y\nset lmargin at screen 0.71; set rmargin at screen 0.985\n"
        "set title 'Searches: lowest loss so far (m)' font ',16'\nset xlabel 'simulations'\n",
        f);
    draw_losses(f, DESCENT, N_METHODS);
    fputs("unset multiplot\nset output\n", f);
    outcome = output_commit(&file);
    return outcome == DONE ? plot_draw(w->o.out, PICTURE, SCRIPT, drawn) : outcome;
}

static int write_summary(const job* w) {
    finding found[N_FINDINGS];
    output_file file;
    json j;
    find(w, found);
    if (output_open(&file, w->o.out, SUMMARY_FILE) != DONE) return FAILED;
    json_begin(&j, file.stream);
    summary_program(&j, form.program);
    json_boolean(&j, "all_shown", findings_hold(found, N_FINDINGS));
    findings_write(&j, found, N_FINDINGS);
    json_open(&j, "methods", '{');
    for (int m = 0; m < N_METHODS; ++m) {
        const record* r = &w->found[m];
        json_open(&j, methods[m].name, '{');
        json_integer(&j, "simulations", r->n);
        json_number(&j, "loss_first", r->losses[0]);
        json_number(&j, "loss_best", r->loss);
        summary_numbers(&j, "weights", r->x, w->s.n_weights);
        summary_numbers(&j, "control", r->x + w->s.n_weights, w->s.n_control);
        summary_numbers(&j, "log_stiffness", r->s, r->n_s);
        json_close(&j, '}');
    }
    json_close(&j, '}');
    json_number(&j, "young_modulus", w->young);
    json_integer(&j, "iterations", w->o.iterations);
    json_integer(&j, "steps", w->o.steps);
    json_number(&j, "sigma", w->o.sigma);
    summary_numbers(&j, "grid", (const double[3]){w->o.grid[0], w->o.grid[1], w->o.grid[2]}, 3);
    json_number(&j, "cpu_seconds", progress_cpu());
    json_open(&j, "machine", '{');
    summary_machine(&j, &w->o);
    json_close(&j, '}');
    json_end(&j);
    return output_commit(&file);
}

static int list(const job* w, int drawn) {
    finding found[N_FINDINGS];
    find(w, found);
    for (int m = 0; m < N_METHODS; ++m) {
        const record* r = &w->found[m];
        printf("%-8s loss %9.6f -> %9.6f m, %3lld simulations; %.3f of the first eel, a %.3f, omega %.3f omega0",
               methods[m].name, r->losses[0], r->loss, (long long)r->n, r->x[0], r->x[2], r->x[3] / SCENE_OMEGA0);
        for (int k = 0; k < r->n_s; ++k) printf("%s%.3f", k > 0 ? ", " : "; E/E0 ", exp(r->s[k]));
        printf("\n");
    }
    findings_print(found, N_FINDINGS);
    printf("Files:\n");
    if (drawn) printf("  %s/%s  (made by %s)\n", w->o.out, PICTURE, SCRIPT);
    printf("  %s/history.csv\n  %s/profile.csv\n  %s/%s\n", w->o.out, w->o.out, w->o.out, SUMMARY_FILE);
    if (fflush(stdout) == 0 && !ferror(stdout)) return DONE;
    say("cannot write to the standard output");
    return FAILED;
}

/* ------------------------------------------------------------------ all of it */
static int run_methods(job* w) {
    const double middle[8] = {w->o.weights[0], w->o.weights[1], 0.5, SCENE_OMEGA0, 0.0, 0.0, 0.0, 0.0};
    const int64_t n = w->o.iterations;
    int outcome = DONE;
    for (int m = 0; m < N_METHODS && outcome == DONE; ++m) {
        record* r = &w->found[m];
        w->p.part_name = methods[m].name;
        r->n_s = m == UNIFORM ? 1 : m == PROFILE ? KNOTS : 0;
        r->losses = malloc((size_t)(2 * n + POPULATION) * sizeof *r->losses);
        if (r->losses == NULL) return say_no_memory();
        if (m == GIVEN) outcome = prove(w, middle);
        if (outcome != DONE) return outcome;
        if (m <= PROFILE)
            outcome = descend(w, r, middle, n);
        else if (m == DESCENT)
            outcome = descend(w, r, middle, 2 * n);
        else
            outcome = m == SEVERAL ? search_from_several(w, r, middle, 2 * n) : search_globally(w, r, middle, 2 * n);
    }
    return outcome;
}

static int begin(job* w) {
    dqa_simulator_options settings;
    const int outcome = say_status(dqa_simulator_options_init(&settings, sizeof settings), "read the defaults");
    if (outcome != DONE) return outcome;
    if (w->s.n_weights != 2 || w->s.n_control != 3) {
        say("the meshes have %d signals; this program drives one", (int)(w->s.n_control / 3));
        return FAILED;
    }
    w->young = settings.young_modulus;
    w->moduli = malloc((size_t)n_cells(w) * sizeof *w->moduli);
    w->bar = malloc((size_t)n_cells(w) * sizeof *w->bar);
    return w->moduli != NULL && w->bar != NULL ? DONE : say_no_memory();
}

static int work(job* w) {
    int outcome, drawn = 0;
    progress_begin(&w->p, 9 * w->o.iterations, 0);
    progress_part(&w->p, 1, 2, w->p.iterations, 1.0);
    outcome = scene_create(&w->s, &w->o, &w->p);
    if (outcome == DONE) outcome = begin(w);
    if (outcome == DONE) outcome = run_methods(w);
    progress_stage(&w->p, PROGRESS_OUTPUT);
    if (outcome == DONE) outcome = write_history(w);
    if (outcome == DONE) outcome = write_profile(w);
    if (outcome == DONE) outcome = draw(w, &drawn);
    if (outcome == DONE) outcome = write_summary(w);
    progress_end(&w->p);
    return outcome == DONE ? list(w, drawn) : outcome;
}

int main(int argc, char** argv) {
    static job w;
    int action = OPTIONS_RUN, created = 0, outcome;
    say_program(form.program);
    outcome = options_parse(&w.o, &form, argc, argv, &action);
    if (outcome == DONE && action == OPTIONS_RUN) {
        outcome = output_folder(w.o.out, &created);
        /* The summary is written last: while it is missing, the folder is known to be incomplete. */
        if (outcome == DONE) output_remove(w.o.out, SUMMARY_FILE);
        if (outcome == DONE) outcome = work(&w);
        if (outcome == INTERRUPTED) say("interrupted after %lld simulations", (long long)w.simulations);
        scene_free(&w.s);
        if (created) (void)rmdir(w.o.out);
    }
    for (int m = 0; m < N_METHODS; ++m) free(w.found[m].losses);
    free(w.moduli);
    free(w.bar);
    options_free(&w.o);
    return outcome;
}
