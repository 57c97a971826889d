/* SPDX-License-Identifier: MIT
 *
 * pareto — fast against efficient swimming, section 8.3 of Ma et al., "DiffAqua", 2021: weighted sums of the two losses
 * over twelve bases and a network, the gamut of all designs that they come by and its front; and a method that the
 * paper does not have, which bisects the front. `pareto --help` lists the options.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/checkpoint.h"
#include "support/findings.h"
#include "support/front.h"
#include "support/gamut.h"
#include "support/motion.h"
#include "support/options.h"
#include "support/output.h"
#include "support/picture.h"
#include "support/plot.h"
#include "support/progress.h"
#include "support/report.h"
#include "support/say.h"
#include "support/scene.h"
#include "support/shapes.h"
#include "support/summary.h"

#define PICTURE "pareto.png"
#define SCRIPT "pareto.gp"
#define N_WEIGHTS 11 /* of the sweep: 0, 0.1 ... 1 */
#define QUICK_WEIGHTS 6
#define N_GAPS 4    /* that the other method closes */
#define CLEARLY 0.1 /* by which the ends of the front differ, as a share of what was gained from the first design */

static const char about[] =
    "usage: pareto [options] [12 meshes]\n"
    "\n"
    "Optimises shape and network for w speed + (1 - w) efficiency, w = 0, 0.1 ... 1, each divided by the size of its\n"
    "initial value, from the mean of four sharks, seven goldfish and a submarine (unless others are named), and once\n"
    "more by bisecting the front of what was found, from designs found before, in fewer simulations. --quick has 6 "
    "weights.\n";

static const char* const words[] = {"--iterations", "--steps", NULL};

static const options_form form = {.program = "pareto",
                                  .about = about,
                                  .out = "pareto-out",
                                  .objective = "travel,efficiency",
                                  .mlp = 1,
                                  .words = words,
                                  .shapes = shapes_twelve,
                                  .quick = {{28, 8, 12}, 4, 16, 0, 0.7},
                                  .shipped = {{60, 16, 26}, 20, 100, 0, 0.7},
                                  .user = {{60, 16, 26}, 20, 100, 0, 0.7}};

enum { SWEEP, BISECT, N_METHODS };

typedef struct job {
    options o;
    char* command;
    scene s;
    progress p;
    double* start;     /* [unknowns]: mean of the bases, and the network as the library makes it */
    double initial[2]; /* its losses: travel (m) and efficiency */
    gamut methods[N_METHODS];
    double reference[2];      /* of hypervolumes: the first design */
    double volume[N_METHODS]; /* of all designs of a method */
    double volume_at_par;     /* of the sweep's, after as many simulations as bisecting took */
    int64_t ends[2];          /* fastest and most efficient design of the sweep */
    motion swimmers[2];       /* the same of all */
    const double* designs[2]; /* theirs */
} job;

/* ------------------------------------------------------------------ fronts */
/* Losses [n][2] of the designs of the first `rows` rows of each leg; *n of them and the simulations they took. */
static double* points_within(const gamut* g, int64_t rows, int64_t* n, int64_t* simulations) {
    double* points = malloc((size_t)(gamut_size(g) > 0 ? gamut_size(g) : 1) * 2 * sizeof *points);
    *n = *simulations = 0;
    if (points == NULL) {
        (void)say_no_memory();
        return NULL;
    }
    for (int64_t i = 0; i < gamut_size(g); ++i) {
        int64_t row = 0;
        int of = 0;
        gamut_place(g, i, &of, &row);
        if (row >= rows) continue;
        gamut_point(g, i, points + 2 * (*n)++);
        if (row + 1 == rows || row + 1 == g->legs[of].r.iteration) *simulations += g->legs[of].r.rows[row].simulations;
    }
    return points;
}

/* Rows "simulations,hypervolume": the sweep's legs side by side, since their order would favour one end, and those that
 * build on each other in their order. */
static int write_volumes(job* w, int method, FILE* f) {
    const gamut* g = &w->methods[method];
    const int64_t most = method == SWEEP ? w->o.iterations : gamut_size(g);
    int outcome = DONE;
    for (int64_t k = 1; k <= most && outcome == DONE; ++k) {
        int64_t n = k, simulations = 0;
        double volume = 0.0, *points = points_within(g, method == SWEEP ? k : INT64_MAX, &n, &simulations);
        if (points == NULL) return FAILED;
        if (method == BISECT) n = simulations = k;
        outcome = front_hypervolume(points, n, w->reference, &volume);
        free(points);
        fprintf(f, "%s,%lld,%.17g\n", g->name, (long long)simulations, volume);
        if (method == SWEEP && simulations <= gamut_simulations(&w->methods[BISECT])) w->volume_at_par = volume;
        w->volume[method] = volume;
    }
    return outcome;
}

static int write_hypervolumes(job* w) {
    output_file file;
    int outcome = output_open(&file, w->o.out, "hypervolume.csv");
    if (outcome != DONE) return outcome;
    fputs("method,simulations,hypervolume\n", file.stream);
    for (int method = 0; method < N_METHODS && outcome == DONE; ++method)
        outcome = write_volumes(w, method, file.stream);
    if (outcome == DONE) return output_commit(&file);
    output_discard(&file);
    return outcome;
}

/* All designs, with their ranks among those of their method, and the front's alone, in order. */
static int write_designs(const job* w, int method, FILE* all) {
    const gamut* g = &w->methods[method];
    const int64_t size = gamut_size(g);
    int64_t n = 0, simulations = 0, length = 0;
    double* points = points_within(g, INT64_MAX, &n, &simulations);
    int64_t* rank = malloc((size_t)size * 2 * sizeof *rank);
    int64_t* chain = rank + size;
    output_file file;
    char name[64];
    int outcome = points != NULL && rank != NULL ? front_ranks(points, size, rank) : FAILED;
    if (outcome == DONE) outcome = front_chain(points, size, chain, &length);
    for (int64_t i = 0; i < size && outcome == DONE; ++i) {
        int64_t row = 0;
        int of = 0;
        gamut_place(g, i, &of, &row);
        fprintf(all, "%s,%d,%.17g,%lld,%.17g,%.17g,%lld", g->name, of, g->legs[of].w, (long long)row + 1,
                g->legs[of].r.rows[row].terms[0], g->legs[of].r.rows[row].terms[1], (long long)rank[i]);
        for (int64_t b = 0; b < w->s.n_weights; ++b) fprintf(all, ",%.17g", gamut_design(g, i)[b]);
        fputs("\n", all);
    }
    (void)snprintf(name, sizeof name, "front_%s.csv", g->name);
    if (outcome == DONE) outcome = output_open(&file, w->o.out, name);
    if (outcome == DONE) {
        fputs("travel,efficiency\n", file.stream);
        for (int64_t k = 0; k < length; ++k)
            fprintf(file.stream, "%.17g,%.17g\n", points[2 * chain[k]] * fabs(w->initial[0]),
                    points[2 * chain[k] + 1] * fabs(w->initial[1]));
        outcome = output_commit(&file);
    }
    free(points);
    free(rank);
    return outcome;
}

static int write_gamut(const job* w) {
    output_file file;
    int outcome = output_open(&file, w->o.out, "gamut.csv");
    if (outcome != DONE) return outcome;
    fputs("method,leg,w,iteration,travel,efficiency,rank", file.stream);
    for (int32_t b = 0; b < w->s.n_weights; ++b)
        fprintf(file.stream, ",weight_%s", dqa_shape_space_base_name(w->s.space, b));
    fputs("\n", file.stream);
    for (int method = 0; method < N_METHODS && outcome == DONE; ++method)
        outcome = write_designs(w, method, file.stream);
    if (outcome == DONE) return output_commit(&file);
    output_discard(&file);
    return outcome;
}

/* The ends of the sweep's front, and of all designs. */
static void find_ends(job* w) {
    double least[2] = {HUGE_VAL, HUGE_VAL};
    for (int method = 0; method < N_METHODS; ++method) {
        double of_sweep[2] = {HUGE_VAL, HUGE_VAL};
        for (int64_t i = 0; i < gamut_size(&w->methods[method]); ++i) {
            double f[2];
            gamut_point(&w->methods[method], i, f);
            for (int k = 0; k < 2; ++k) {
                if (f[k] < of_sweep[k]) {
                    of_sweep[k] = f[k];
                    if (method == SWEEP) w->ends[k] = i;
                }
                if (f[k] < least[k]) {
                    least[k] = f[k];
                    w->designs[k] = gamut_design(&w->methods[method], i);
                }
            }
        }
    }
}

/* ------------------------------------------------------------------ what it shows */
enum { N_FINDINGS = 3 };

static void find(const job* w, finding* found) {
    static const char* const names[2] = {"ends_differ_in_speed", "ends_differ_in_efficiency"};
    static const char* const says[2] = {
        "the ends of the front differ in speed (share of the gain from the first design)",
        "the ends of the front differ in efficiency (share of the gain from the first design)"};
    for (int k = 0; k < 2; ++k) {
        double own[2], other[2];
        gamut_point(&w->methods[SWEEP], w->ends[k], own);
        gamut_point(&w->methods[SWEEP], w->ends[1 - k], other);
        found[k] =
            (finding){names[k], says[k], (other[k] - own[k]) / (w->reference[k] - own[k]), CLEARLY, FINDING_AT_LEAST};
    }
    found[2] = (finding){"more_volume_per_simulation",
                         "bisecting has more hypervolume than the sweep after as many simulations", w->volume[BISECT],
                         w->volume_at_par, FINDING_ABOVE};
}

/* ------------------------------------------------------------------ picture and report */
static const char* const titles[2] = {"Fastest", "Most efficient"};

static int write_signals(const job* w) {
    output_file file;
    int outcome = output_open(&file, w->o.out, "signals.csv");
    if (outcome != DONE) return outcome;
    fputs("step,fastest,efficient\n", file.stream);
    for (int64_t k = 0; k < w->o.steps; ++k) {
        fprintf(file.stream, "%lld", (long long)k + 1);
        for (int e = 0; e < 2; ++e)
            fprintf(file.stream, ",%.17g", w->swimmers[e].work.signals[k * w->swimmers[e].work.n_signals]);
        fputs("\n", file.stream);
    }
    return output_commit(&file);
}

static void draw_curves(const job* w, FILE* f) {
    fputs("set xlabel 'loss of speed: minus the distance (m)' offset 0,0.5\n", f);
    plot_panel(f, "Loss of efficiency over loss of speed", 0.06, 0.37);
    fprintf(f,
            "plot 'gamut.csv' every ::1 using (strcol(1) eq 'sweep' ? $5 : NaN):6 with points pt 7 ps 0.6 lc rgb "
            "'#b8b8b8' title 'sweep', \\\n"
            "     '' every ::1 using (strcol(1) eq 'bisect' ? $5 : NaN):6 with points pt 7 ps 0.6 lc rgb '#f0b890' "
            "title 'bisecting', \\\n"
            "     'front_sweep.csv' every ::1 using 1:2 with linespoints lt 1 lw 1.5 pt 6 title 'front of the sweep', "
            "\\\n"
            "     'front_bisect.csv' every ::1 using 1:2 with linespoints lt 2 lw 1.5 pt 6 title 'front of bisecting', "
            "\\\n"
            "     '-' using 1:2 with points pt 9 ps 1.6 lc rgb '#404040' title 'first design'\n%.9g,%.9g\ne\n",
            w->initial[0], w->initial[1]);
    fputs("set xlabel 'simulations' offset 0,0.5\n", f);
    plot_panel(f, "Hypervolume over simulations", 0.435, 0.68);
    fputs("set key maxrows 1\n", f);
    fputs(
        "plot 'hypervolume.csv' every ::1 using (strcol(1) eq 'sweep' ? $2 : NaN):3 with linespoints lt 1 pt 7 ps 0.6 "
        "title 'sweep', \\\n"
        "     '' every ::1 using (strcol(1) eq 'bisect' ? $2 : NaN):3 with linespoints lt 2 pt 7 ps 0.6 title "
        "'bisecting'\n"
        "set xlabel 'step' offset 0,0.5\nset yrange [-1.05:1.05]\n",
        f);
    plot_panel(f, "Signal of the muscle", 0.735, 0.985);
    fputs(
        "plot 'signals.csv' every ::1 using 1:2 with lines lt 3 title 'fastest', '' every ::1 using 1:3 with lines lt "
        "4 "
        "title 'most efficient'\nset autoscale y\nset key maxrows auto\n",
        f);
}

static int draw(const job* w, int* drawn) {
    static const uint32_t colours[2] = {PICTURE_BEST_COLOUR, PICTURE_FIRST_COLOUR};
    static const char* const files[2][2] = {{"fastest.dat", "fastest_shadow.dat"},
                                            {"efficient.dat", "efficient_shadow.dat"}};
    const motion* both[2];
    lanes_box box;
    output_file file;
    int created = 0;
    char* data = output_path(w->o.out, PLOT_FOLDER);
    int outcome = data != NULL ? output_folder(data, &created) : FAILED;
    for (int e = 0; e < 2; ++e) both[e] = &w->swimmers[e];
    lanes_measure(&box, both, 2);
    for (int e = 0; e < 2 && outcome == DONE; ++e)
        outcome = lanes_write(both[e], &box, colours[e], data, files[e][0], files[e][1]);
    if (outcome == DONE) outcome = output_open(&file, w->o.out, SCRIPT);
    if (outcome == DONE) {
        plot_head(file.stream, PICTURE, SCRIPT);
        draw_curves(w, file.stream);
        plot_scenery(file.stream, &box);
        plot_swimmer(file.stream, both[0], &box, titles[0], "fastest", 0.01);
        plot_swimmer(file.stream, both[1], &box, titles[1], "efficient", 0.51);
        fputs("unset multiplot\nset output\n", file.stream);
        outcome = output_commit(&file);
    }
    if (outcome == DONE) outcome = plot_draw(w->o.out, PICTURE, SCRIPT, drawn);
    free(data);
    return outcome;
}

static void gamut_series(report* to, const job* w, int method, const char* name) {
    const gamut* g = &w->methods[method];
    int64_t n = 0, simulations = 0;
    double* points = points_within(g, INT64_MAX, &n, &simulations);
    for (int64_t i = 0; i < n && points != NULL; ++i)
        for (int k = 0; k < 2; ++k) points[2 * i + k] *= fabs(w->initial[k]);
    if (points != NULL) report_series(to, name, REPORT_PLAIN, points, points + 1, n, 2);
    free(points);
}

static int write_report(const job* w) {
    const char* names[OPTIONS_MAX_BASES];
    report to;
    int outcome = report_open(&to, w->o.out, form.program, "Fast against efficient swimmers",
                              "All designs that weighted sums of speed and efficiency came by", w->command);
    if (outcome != DONE) return outcome;
    report_fact(&to, "Distance of the fastest", NULL, w->swimmers[0].loss, -1e3, 1, "mm");
    report_fact(&to, "Distance of the most efficient", NULL, w->swimmers[1].loss, -1e3, 1, "mm");
    report_fact(&to, "Hypervolume, sweep", "methods.sweep.hypervolume", w->volume[SWEEP], 1.0, 1, "");
    report_fact(&to, "Hypervolume, bisecting", "methods.bisect.hypervolume", w->volume[BISECT], 1.0, 1, "");
    for (int e = 0; e < 2; ++e) report_swimmer(&to, titles[e], &w->swimmers[e]);
    report_chart(&to, REPORT_POINTS, "Gamut", "minus the distance travelled (m)", "loss of efficiency", NULL);
    gamut_series(&to, w, SWEEP, "sweep");
    gamut_series(&to, w, BISECT, "bisecting");
    report_series(&to, "first design", REPORT_MARK, &w->initial[0], &w->initial[1], 1, 1);
    report_chart_end(&to);
    for (int64_t b = 0; b < w->s.n_weights; ++b) names[b] = dqa_shape_space_base_name(w->s.space, (int32_t)b);
    report_chart(&to, REPORT_RADAR, "Mix of base shapes", NULL, NULL, NULL);
    report_axes(&to, names, w->s.n_weights);
    for (int e = 0; e < 2; ++e) report_series(&to, titles[e], REPORT_PLAIN, NULL, w->designs[e], w->s.n_weights, 1);
    report_chart_end(&to);
    summary_settings(report_table(&to, "Settings"), &w->o, &w->methods[SWEEP].legs[0].r, &w->s);
    report_table_end(&to);
    summary_machine(report_table(&to, "Machine"), &w->o);
    report_table_end(&to);
    return report_close(&to);
}

/* ------------------------------------------------------------------ summary */
static void write_method(const job* w, int method, json* j) {
    const gamut* g = &w->methods[method];
    double seconds = 0.0, cpu_seconds = 0.0;
    json_open(j, g->name, '{');
    json_integer(j, "simulations", gamut_simulations(g));
    json_number(j, "hypervolume", w->volume[method]);
    json_number(j, "hypervolume_per_simulation", w->volume[method] / (double)gamut_simulations(g));
    if (method == SWEEP) json_number(j, "hypervolume_after_as_many_as_bisecting", w->volume_at_par);
    json_open(j, "legs", '[');
    for (int k = 0; k < g->n_legs; ++k) {
        const run* r = &g->legs[k].r;
        const history_row* best = &r->rows[r->best_iteration - 1];
        seconds += r->seconds;
        cpu_seconds += r->cpu_before;
        json_open(j, NULL, '{');
        json_string(j, "name", g->legs[k].name);
        json_number(j, "w", g->legs[k].w);
        json_integer(j, "iterations", r->iteration);
        json_number(j, "travel", best->terms[0]);
        json_number(j, "efficiency", best->terms[1]);
        json_close(j, '}');
    }
    json_close(j, ']');
    json_number(j, "seconds", seconds);
    json_number(j, "cpu_seconds", cpu_seconds);
    json_close(j, '}');
}

static int write_summary(const job* w) {
    const run* r = &w->methods[SWEEP].legs[0].r;
    finding found[N_FINDINGS];
    double cpu_seconds = 0.0;
    output_file file;
    json j;
    find(w, found);
    for (int method = 0; method < N_METHODS; ++method)
        for (int k = 0; k < w->methods[method].n_legs; ++k) cpu_seconds += w->methods[method].legs[k].r.cpu_before;
    if (output_open(&file, w->o.out, SUMMARY_FILE) != DONE) return FAILED;
    json_begin(&j, file.stream);
    summary_program(&j, form.program);
    json_boolean(&j, "all_shown", findings_hold(found, N_FINDINGS));
    findings_write(&j, found, N_FINDINGS);
    json_number(&j, "cpu_seconds", cpu_seconds);
    json_integer(&j, "parameters", w->s.n_weights + w->s.n_control);
    json_open(&j, "bases", '[');
    for (int64_t b = 0; b < w->s.n_weights; ++b)
        json_string(&j, NULL, dqa_shape_space_base_name(w->s.space, (int32_t)b));
    json_close(&j, ']');
    summary_numbers(&j, "initial", w->initial, 2);
    summary_numbers(&j, "reference", w->reference, 2);
    json_open(&j, "methods", '{');
    for (int method = 0; method < N_METHODS; ++method) write_method(w, method, &j);
    json_close(&j, '}');
    json_open(&j, "ends", '{');
    for (int e = 0; e < 2; ++e) {
        json_open(&j, e == 0 ? "fastest" : "most_efficient", '{');
        json_number(&j, "travel", w->swimmers[e].loss);
        summary_numbers(&j, "weights", w->designs[e], w->s.n_weights);
        json_close(&j, '}');
    }
    json_close(&j, '}');
    json_open(&j, "machine", '{');
    summary_machine(&j, &w->o);
    json_close(&j, '}');
    json_open(&j, "settings", '{');
    summary_settings(&j, &w->o, r, &w->s);
    json_close(&j, '}');
    json_end(&j);
    return output_commit(&file);
}

static int list(const job* w, int drawn) {
    finding found[N_FINDINGS];
    find(w, found);
    for (int method = 0; method < N_METHODS; ++method)
        printf("%-7s %5lld simulations, hypervolume %9.3f\n", w->methods[method].name,
               (long long)gamut_simulations(&w->methods[method]), w->volume[method]);
    findings_print(found, N_FINDINGS);
    printf("Files:\n  %s/%s  (opens in any browser)\n", w->o.out, REPORT_FILE);
    if (drawn) printf("  %s/%s  (made by %s)\n", w->o.out, PICTURE, SCRIPT);
    printf("  %s/%s\n", w->o.out, SUMMARY_FILE);
    printf("  %s/gamut.csv\n  %s/hypervolume.csv\n", w->o.out, w->o.out);
    if (fflush(stdout) == 0 && !ferror(stdout)) return DONE;
    say("cannot write to the standard output");
    return FAILED;
}

/* ------------------------------------------------------------------ all of it */
/* The losses of the first design, which those of all others are divided by. */
static int begin(job* w) {
    static const char* const names[N_METHODS] = {"sweep", "bisect"};
    history_row row;
    int outcome;
    w->start = malloc((size_t)(w->s.n_weights + w->s.n_control) * sizeof *w->start);
    if (w->start == NULL) return say_no_memory();
    memcpy(w->start, w->o.weights, (size_t)w->s.n_weights * sizeof *w->start);
    outcome = say_status(dqa_controller_get_parameters(w->s.controller, w->start + w->s.n_weights, w->s.n_control),
                         "read the controller");
    if (outcome == DONE) outcome = scene_try(&w->s, w->start, &row, &w->p);
    if (outcome != DONE) return outcome;
    for (int k = 0; k < 2; ++k) {
        w->initial[k] = row.terms[k];
        w->reference[k] = row.terms[k] < 0.0 ? -1.0 : 1.0;
        if (!isfinite(row.loss) || row.terms[k] == 0.0) {
            say("the first design does not swim, so that there is nothing to measure others by");
            return FAILED;
        }
    }
    for (int method = 0; method < N_METHODS; ++method) {
        gamut* g = &w->methods[method];
        g->name = names[method];
        g->o = &w->o;
        g->s = &w->s;
        g->p = &w->p;
        g->start = w->start;
        g->initial = w->initial;
    }
    return DONE;
}

static int write_results(job* w) {
    int outcome = DONE, drawn = 0;
    find_ends(w);
    for (int e = 0; e < 2 && outcome == DONE; ++e)
        outcome = motion_record(&w->swimmers[e], &w->s, w->designs[e], &w->p);
    progress_stage(&w->p, PROGRESS_OUTPUT);
    if (outcome == DONE) outcome = write_hypervolumes(w);
    if (outcome == DONE) outcome = write_gamut(w);
    if (outcome == DONE) outcome = write_signals(w);
    if (outcome == DONE) outcome = draw(w, &drawn);
    if (outcome == DONE) outcome = write_report(w);
    if (outcome == DONE) outcome = write_summary(w);
    progress_end(&w->p);
    return outcome == DONE ? list(w, drawn) : outcome;
}

static int work(job* w) {
    const int n_weights = w->o.quick ? QUICK_WEIGHTS : N_WEIGHTS;
    const int64_t of_sweep = n_weights * w->o.iterations;
    int outcome;
    progress_begin(&w->p, of_sweep + gamut_bisect_budget(N_GAPS, w->o.iterations), 2);
    progress_part(&w->p, 1, 2, w->p.iterations, 1.0);
    outcome = scene_create(&w->s, &w->o, &w->p);
    if (outcome == DONE) outcome = begin(w);
    if (outcome == DONE) outcome = gamut_sweep(&w->methods[SWEEP], n_weights, w->o.iterations, 0);
    if (outcome == DONE) outcome = gamut_bisect(&w->methods[BISECT], N_GAPS, w->o.iterations, of_sweep);
    if (outcome == DONE) outcome = write_results(w);
    progress_end(&w->p);
    return outcome;
}

static int prepare(job* w, int* created) {
    char* first = output_path(w->o.out, "sweep_0");
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
        w.command = options_command(argc, argv);
        outcome = w.command != NULL ? prepare(&w, &created) : FAILED;
        if (outcome == DONE) outcome = work(&w);
        if (outcome == INTERRUPTED) {
            say("interrupted after %lld simulations", (long long)w.p.iteration);
            if (w.methods[SWEEP].n_legs > 0) options_say_resume(argc, argv);
        }
        for (int e = 0; e < 2; ++e) motion_free(&w.swimmers[e]);
        for (int method = 0; method < N_METHODS; ++method) gamut_free(&w.methods[method]);
        scene_free(&w.s);
        if (created) (void)rmdir(w.o.out);
    }
    free(w.start);
    free(w.command);
    options_free(&w.o);
    return outcome;
}
