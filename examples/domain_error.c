/* SPDX-License-Identifier: MIT
 *
 * domain_error — what it does to a swimmer to simulate less than the whole box (Fig. "diff" of Ma et al., "DiffAqua",
 * 2021): an eel swims in all cells of its box, in those of more than some share of the peak density, and in those of
 * the body alone, and the places of its nodes are compared. `domain_error --help` lists the options.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/findings.h"
#include "support/options.h"
#include "support/output.h"
#include "support/plot.h"
#include "support/progress.h"
#include "support/say.h"
#include "support/scene.h"
#include "support/summary.h"

#define PICTURE "domain_error.png"
#define SCRIPT "domain_error.gp"
#define TABLE "domain_error.csv"
#define CURVES "history.csv"
#define TOLERANCE 1e-9 /* of a step: errors as small as that of the least threshold are to be those of the domain */
#define REPEATS 3      /* of a swim: the fastest tells the time */
#define DEFAULT_THRESHOLD 0.02         /* the library's: what is left out up to there counts as faint */
#define BELOW_HALF 0.49999999999999994 /* the largest threshold there is: the body is where the density exceeds 1/2 */

/* The body first, whose nodes all domains have; then the whole box, which the others are compared with. */
static const double thresholds[] = {BELOW_HALF, 0.0, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1};
enum { BODY, BOX, N_DOMAINS = sizeof thresholds / sizeof thresholds[0] };

static const char about[] =
    "usage: domain_error [options] [mesh]\n"
    "\n"
    "Lets an eel (or the mesh) swim with a sine of amplitude 1 and a period of 12 steps in the whole box, in the "
    "cells\n"
    "above several shares of the density, and without any cell outside of the body, and tells how far the places of\n"
    "its nodes are from those in the whole box, and the time of a step.\n";

static const char* const words[] = {"--steps", NULL};
static const char* const shapes[] = {"eel_vertical.stl", NULL};

static const options_form form = {.program = "domain_error",
                                  .about = about,
                                  .out = "domain_error-out",
                                  .brief = 1,
                                  .words = words,
                                  .shapes = shapes,
                                  .quick = {{30, 8, 8}, 1, 24, 0, 0.4},
                                  .shipped = {{40, 8, 8}, 1, 100, 0, 0.4},
                                  .user = {{40, 8, 8}, 1, 100, 0, 0.4},
                                  .fixed_control = 1};

/* A swim in one set of cells. */
typedef struct domain {
    int64_t n_cells, n_nodes;
    double travel;                  /* m */
    double seconds;                 /* of processor time a step, the median */
    double newton, linear;          /* iterations a step */
    double* places;                 /* [steps + 1][body nodes][3], m */
    double *nodes, *centre, *moved; /* errors [steps + 1], see measure() */
} domain;

typedef struct job {
    options o;
    progress p;
    domain domains[N_DOMAINS];
    int32_t* body; /* [n_body]: the body's nodes, as numbers in the box */
    int64_t n_body;
    double length;  /* m: of the body */
    double* clocks; /* [n_clocks], at most steps + 1: processor time after each step of the running swim */
    int64_t n_clocks;
} job;

/* ------------------------------------------------------------------ a swim */
static int32_t watch(int64_t done, int64_t total, void* user_data) {
    job* w = user_data;
    if (w->n_clocks <= w->o.steps) w->clocks[w->n_clocks++] = progress_cpu();
    return progress_callback(done, total, &w->p);
}

static int smaller_first(const void* a, const void* b) {
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* Processor time of the median step of the swim that was watched. */
static double median_step(job* w) {
    const int64_t n = w->n_clocks - 1;
    for (int64_t k = 0; k < n; ++k) w->clocks[k] = w->clocks[k + 1] - w->clocks[k];
    if (n < 1) return (double)NAN;
    qsort(w->clocks, (size_t)n, sizeof *w->clocks, smaller_first);
    return n % 2 == 1 ? w->clocks[n / 2] : 0.5 * (w->clocks[n / 2 - 1] + w->clocks[n / 2]);
}

static int read_body(job* w, const scene* s, int64_t n_nodes) {
    w->n_body = n_nodes;
    w->body = malloc((size_t)n_nodes * sizeof *w->body);
    if (w->body == NULL) return say_no_memory();
    return say_status(dqa_simulator_node_box_index(s->simulator, w->body, n_nodes), "read the nodes");
}

/* The rows [n_body] of the scene's nodes that are the body's. */
static int find_rows(const job* w, const scene* s, int64_t n_nodes, int64_t* rows) {
    int32_t* index = malloc((size_t)n_nodes * sizeof *index);
    int outcome = index != NULL ? DONE : say_no_memory();
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_node_box_index(s->simulator, index, n_nodes), "read the nodes");
    for (int64_t i = 0; i < w->n_body && outcome == DONE; ++i) {
        int64_t row = 0;
        while (row < n_nodes && index[row] != w->body[i]) ++row;
        rows[i] = row;
        if (row == n_nodes) {
            say("node %d of the body is missing in a larger domain", (int)w->body[i]);
            outcome = FAILED;
        }
    }
    free(index);
    return outcome;
}

/* The places of the body's nodes after every step of the scene's tape. */
static int read_places(const job* w, scene* s, domain* d) {
    const int64_t n = 3 * d->n_nodes;
    int64_t* rows = malloc((size_t)w->n_body * sizeof *rows);
    double* q = malloc((size_t)n * sizeof *q);
    int outcome;
    d->places = malloc((size_t)(w->o.steps + 1) * (size_t)w->n_body * 3 * sizeof *d->places);
    outcome = rows != NULL && q != NULL && d->places != NULL ? find_rows(w, s, d->n_nodes, rows) : say_no_memory();
    for (int64_t k = 0; k <= w->o.steps && outcome == DONE; ++k) {
        outcome = say_status(dqa_tape_get_state(s->tape, k, q, n, NULL, 0), "read a state");
        for (int64_t i = 0; i < w->n_body && outcome == DONE; ++i)
            memcpy(d->places + 3 * (k * w->n_body + i), q + 3 * rows[i], 3 * sizeof *q);
    }
    free(rows);
    free(q);
    return outcome;
}

static int swim(job* w, scene* s, domain* d) {
    const double x[4] = {1.0, 1.0, SCENE_OMEGA0, 0.0};
    int outcome = DONE;
    d->seconds = HUGE_VAL;
    for (int k = 0; k < REPEATS && outcome == DONE; ++k) {
        w->n_clocks = 0;
        outcome = scene_swim_watched(s, x, &w->p, watch, w);
        if (outcome == DONE) d->seconds = fmin(d->seconds, median_step(w));
    }
    return outcome;
}

static int run_domain(job* w, int k) {
    domain* d = &w->domains[k];
    options o = w->o;
    scene s;
    dqa_simulator_info info;
    dqa_tape_statistics work;
    int outcome;
    o.threshold = thresholds[k];
    o.tolerance = TOLERANCE;
    outcome = scene_create(&s, &o, &w->p);
    if (outcome == DONE && s.n_control != 3) {
        say("the muscles have %d signals; this experiment drives one", (int)(s.n_control / 3));
        outcome = FAILED;
    }
    if (outcome == DONE) outcome = swim(w, &s, d);
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_get_info(s.simulator, &info, sizeof info), "read the simulator");
    if (outcome == DONE) outcome = say_status(dqa_tape_stats(s.tape, &work, sizeof work), "read the tape's statistics");
    if (outcome == DONE) outcome = say_status(dqa_tape_objective(s.tape, s.terms, 1, &d->travel, NULL), "read the way");
    if (outcome == DONE) {
        d->travel = -d->travel;
        d->n_cells = info.n_active_cells;
        d->n_nodes = info.n_nodes;
        d->newton = (double)work.newton_iterations / (double)w->o.steps;
        d->linear = (double)work.linear_iterations / (double)w->o.steps;
        if (k == BODY) outcome = read_body(w, &s, info.n_nodes);
    }
    if (outcome == DONE) outcome = read_places(w, &s, d);
    scene_free(&s);
    return outcome;
}

/* ------------------------------------------------------------------ errors */
static const double* place(const job* w, int k, int64_t step, int64_t node) {
    return w->domains[k].places + 3 * (step * w->n_body + node);
}

static double distance(const double* a, const double* b) {
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

static void measure_length(job* w) {
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (int64_t i = 0; i < w->n_body; ++i) {
        least = fmin(least, place(w, BOX, 0, i)[0]);
        most = fmax(most, place(w, BOX, 0, i)[0]);
    }
    w->length = most - least;
}

/* Against the whole box, of the body's nodes after every step: the mean distance over the body's length, as the paper
 * has it; the distance of their middles over that length; and the root of the mean square of the distance over that of
 * the way that they have moved. */
static int measure(job* w, int k) {
    domain* d = &w->domains[k];
    const double n = (double)w->n_body;
    const size_t size = (size_t)(w->o.steps + 1) * sizeof(double);
    d->nodes = malloc(size);
    d->centre = malloc(size);
    d->moved = malloc(size);
    if (d->nodes == NULL || d->centre == NULL || d->moved == NULL) return say_no_memory();
    for (int64_t step = 0; step <= w->o.steps; ++step) {
        double sum = 0.0, squares = 0.0, moved = 0.0, own[3] = {0.0, 0.0, 0.0}, box[3] = {0.0, 0.0, 0.0};
        for (int64_t i = 0; i < w->n_body; ++i) {
            const double *q = place(w, k, step, i), *b = place(w, BOX, step, i);
            const double off = distance(q, b), way = distance(b, place(w, BOX, 0, i));
            sum += off;
            squares += off * off;
            moved += way * way;
            for (int c = 0; c < 3; ++c) {
                own[c] += q[c] / n;
                box[c] += b[c] / n;
            }
        }
        d->nodes[step] = sum / n / w->length;
        d->centre[step] = distance(own, box) / w->length;
        d->moved[step] = moved > 0.0 ? sqrt(squares / moved) : 0.0;
    }
    return DONE;
}

/* ------------------------------------------------------------------ results */
static const char* name_of(int k, char* text, size_t size) {
    if (k == BODY) return "no exterior cells";
    (void)snprintf(text, size, k == BOX ? "whole box" : "above %g", thresholds[k]);
    return text;
}

static int write_table(const job* w) {
    output_file file;
    if (output_open(&file, w->o.out, TABLE) != DONE) return FAILED;
    fputs(
        "domain,threshold,cells,nodes,error_nodes,error_centre,error_over_way,travel,seconds_per_step,"
        "newton_per_step,linear_per_step\n",
        file.stream);
    for (int k = 0; k < N_DOMAINS; ++k) {
        const domain* d = &w->domains[k];
        char name[32];
        fprintf(file.stream, "%s,%.17g,%lld,%lld,%.17g,%.17g,%.17g,%.17g,%.6g,%.4f,%.3f\n",
                name_of(k, name, sizeof name), thresholds[k], (long long)d->n_cells, (long long)d->n_nodes,
                d->nodes[w->o.steps], d->centre[w->o.steps], d->moved[w->o.steps], d->travel, d->seconds, d->newton,
                d->linear);
    }
    return output_commit(&file);
}

static int write_curves(const job* w) {
    output_file file;
    if (output_open(&file, w->o.out, CURVES) != DONE) return FAILED;
    fputs("step", file.stream);
    for (int k = 0; k < N_DOMAINS; ++k) fprintf(file.stream, ",error_%g", thresholds[k]);
    fputs("\n", file.stream);
    for (int64_t step = 0; step <= w->o.steps; ++step) {
        fprintf(file.stream, "%lld", (long long)step);
        for (int k = 0; k < N_DOMAINS; ++k) fprintf(file.stream, ",%.17g", w->domains[k].nodes[step]);
        fputs("\n", file.stream);
    }
    return output_commit(&file);
}

/* Error over time; the box itself, without error, cannot stand in powers of ten. */
static void draw_times(const job* w, FILE* f) {
    double fastest = w->domains[BODY].seconds, slowest = fastest, least = HUGE_VAL, most = 0.0;
    for (int k = 0; k < N_DOMAINS; ++k) {
        const domain* d = &w->domains[k];
        if (k == BOX) continue;
        fastest = fmin(fastest, d->seconds), slowest = fmax(slowest, d->seconds);
        least = fmin(least, d->nodes[w->o.steps]), most = fmax(most, d->nodes[w->o.steps]);
    }
    fprintf(f,
            "\nset lmargin at screen 0.56; set rmargin at screen 0.98\nunset key\n"
            "set title 'After %lld steps, against the time of a step (whole box: %.3g ms)' font ',16'\n"
            "set xlabel 'processor time of a step (ms)'\nset logscale x\n"
            "set xrange [%.4g:%.4g]\nset yrange [%.4g:%.4g]\n"
            "set xtics (1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, 200, 500, 1000)\n"
            "plot '%s' every ::3 using (1000*$9):(100*$5) with linespoints lt 1 pt 7 ps 1.2, \\\n"
            "     '' every ::1::1 using (1000*$9):(100*$5) with points lt 8 pt 5 ps 1.6, \\\n"
            "     '' every ::1::1 using (1000*$9):(100*$5):1 with labels right offset -1,0.8 font ',12', \\\n"
            "     '' every ::3 using (1000*$9):(100*$5):1 with labels left offset 0.9,0.3 font ',12'\n"
            "unset multiplot\nset output\n",
            (long long)w->o.steps, 1e3 * w->domains[BOX].seconds, 600.0 * fastest, 1600.0 * slowest, 70.0 * least,
            150.0 * most, TABLE);
}

static int draw(const job* w, int* drawn) {
    static const char* const styles[N_DOMAINS] = {"lt 8", "", "lt 1", "lt 2", "lt 3", "lt 4", "lt 5", "lt 6", "lt 7"};
    output_file file;
    FILE* f;
    int outcome = output_open(&file, w->o.out, SCRIPT);
    if (outcome != DONE) return outcome;
    f = file.stream;
    plot_page(f, PICTURE, SCRIPT, 1600, 640);
    plot_lines(f);
    fprintf(f,
            "set bmargin at screen 0.13; set tmargin at screen 0.90\nset logscale y\nset format y '%%g'\n"
            "set ytics (0.001, 0.01, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100)\n"
            "set lmargin at screen 0.075; set rmargin at screen 0.47\n"
            "set title 'How far the nodes are from those of the whole box' font ',16'\n"
            "set xlabel 'step'\nset ylabel 'mean distance, %% of the body length' offset 1,0\n"
            "set xrange [0:%lld]; set yrange [0.001:*]\n"
            "set key at graph 0.98,0.02 bottom right maxrows 4 font ',11' samplen 1.5\n",
            (long long)w->o.steps);
    for (int k = 0; k < N_DOMAINS; ++k) {
        char name[32];
        if (k == BOX) continue;
        fprintf(f, "%s'%s' every ::3 using 1:(100*$%d) with lines %s title '%s'", k > 0 ? ", \\\n     " : "plot ",
                CURVES, k + 2, styles[k], name_of(k, name, sizeof name));
    }
    draw_times(w, f);
    outcome = output_commit(&file);
    return outcome == DONE ? plot_draw(w->o.out, PICTURE, SCRIPT, drawn) : outcome;
}

/* What the experiment has to show. */
enum { N_FINDINGS = 2 };

static void find(const job* w, finding* found) {
    double faint = 0.0, ratio = 0.0;
    for (int k = BOX + 1; k < N_DOMAINS; ++k) {
        const double error = w->domains[k].nodes[w->o.steps];
        if (thresholds[k] > DEFAULT_THRESHOLD) continue;
        if (k > BOX + 1) ratio = fmax(ratio, w->domains[k - 1].nodes[w->o.steps] / error);
        faint = fmax(faint, error);
    }
    found[0] = (finding){"falls_with_threshold", "the error falls with the threshold (largest ratio to the next)",
                         ratio, 1.0, FINDING_BELOW};
    found[1] = (finding){"body_alone_is_worse", "faint cells left out do less harm than all exterior cells left out",
                         faint, w->domains[BODY].nodes[w->o.steps], FINDING_BELOW};
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
    json_open(&j, "domains", '[');
    for (int k = 0; k < N_DOMAINS; ++k) {
        const domain* d = &w->domains[k];
        char name[32];
        json_open(&j, NULL, '{');
        json_string(&j, "name", name_of(k, name, sizeof name));
        json_number(&j, "threshold", thresholds[k]);
        json_integer(&j, "cells", d->n_cells);
        json_integer(&j, "nodes", d->n_nodes);
        json_number(&j, "error_nodes", d->nodes[w->o.steps]);
        json_number(&j, "error_centre", d->centre[w->o.steps]);
        json_number(&j, "error_over_way", d->moved[w->o.steps]);
        json_number(&j, "travel", d->travel);
        json_number(&j, "seconds_per_step", d->seconds);
        json_number(&j, "newton_per_step", d->newton);
        json_number(&j, "linear_per_step", d->linear);
        json_close(&j, '}');
    }
    json_close(&j, ']');
    json_number(&j, "body_length", w->length);
    json_integer(&j, "steps", w->o.steps);
    json_number(&j, "sigma", w->o.sigma);
    summary_numbers(&j, "grid", (const double[3]){w->o.grid[0], w->o.grid[1], w->o.grid[2]}, 3);
    json_number(&j, "tolerance", TOLERANCE);
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
    printf("domain              cells  mean error   of centre   over way    travel   ms a step  CG a step\n");
    for (int k = 0; k < N_DOMAINS; ++k) {
        const domain* d = &w->domains[k];
        char name[32];
        printf("%-18s %6lld %9.4f %%  %9.4f %%  %8.4f %%  %8.5f m %8.2f %10.1f\n", name_of(k, name, sizeof name),
               (long long)d->n_cells, 100.0 * d->nodes[w->o.steps], 100.0 * d->centre[w->o.steps],
               100.0 * d->moved[w->o.steps], d->travel, 1e3 * d->seconds, d->linear);
    }
    findings_print(found, N_FINDINGS);
    printf("Files:\n");
    if (drawn) printf("  %s/%s  (made by %s)\n", w->o.out, PICTURE, SCRIPT);
    printf("  %s/%s\n  %s/%s\n  %s/%s\n", w->o.out, TABLE, w->o.out, CURVES, w->o.out, SUMMARY_FILE);
    if (fflush(stdout) == 0 && !ferror(stdout)) return DONE;
    say("cannot write to the standard output");
    return FAILED;
}

/* ------------------------------------------------------------------ all of it */
static int work(job* w) {
    int outcome = DONE, drawn = 0;
    progress_begin(&w->p, N_DOMAINS, 0);
    w->p.seconds[PROGRESS_FORWARD] = w->p.seconds[PROGRESS_BACKWARD] = 0.0;
    w->clocks = malloc((size_t)(w->o.steps + 1) * sizeof *w->clocks);
    if (w->clocks == NULL) return say_no_memory();
    for (int k = 0; k < N_DOMAINS && outcome == DONE; ++k) {
        const double started = progress_clock();
        outcome = run_domain(w, k);
        if (outcome == DONE) progress_shape(&w->p, k + 1, progress_clock() - started);
    }
    progress_end(&w->p);
    if (outcome != DONE) return outcome;
    measure_length(w);
    for (int k = 0; k < N_DOMAINS && outcome == DONE; ++k) outcome = measure(w, k);
    if (outcome == DONE) outcome = write_table(w);
    if (outcome == DONE) outcome = write_curves(w);
    if (outcome == DONE) outcome = draw(w, &drawn);
    if (outcome == DONE) outcome = write_summary(w);
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
        if (outcome == INTERRUPTED) say("interrupted");
        if (created) (void)rmdir(w.o.out);
    }
    for (int k = 0; k < N_DOMAINS; ++k) {
        free(w.domains[k].places);
        free(w.domains[k].nodes);
        free(w.domains[k].centre);
        free(w.domains[k].moved);
    }
    free(w.body);
    free(w.clocks);
    options_free(&w.o);
    return outcome;
}
