/* SPDX-License-Identifier: MIT */
#include "report_run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "say.h"
#include "summary.h"

#define FIRST_NAME "initial"
#define BEST_NAME "optimised"
#define ITERATION "iteration"
#define TIME "time t (s)"

/* ------------------------------------------------------------------ headline */
/* Extent along x of the swimmer at rest, m. */
static double length_of(const motion* m) {
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (int64_t i = 0; i < m->n_vertices; ++i) {
        least = fmin(least, m->frames[3 * i]);
        most = fmax(most, m->frames[3 * i]);
    }
    return most - least;
}

static double speed_of(const motion* m) {
    return -m->loss / ((double)(m->n_frames - 1) * m->time_step * length_of(m));
}

static void facts(report* to, const run* r, const motion* first, const motion* best) {
    const int travel = objective_is_travel(r->loss);
    report_fact(to, "Distance, " BEST_NAME, travel ? "loss_best" : NULL, travel ? r->best_loss : best->loss, -1e3, 1,
                "mm");
    report_fact(to, "Distance, " FIRST_NAME, travel ? "loss_first" : NULL, travel ? r->first_loss : first->loss, -1e3,
                1, "mm");
    report_fact(to, "Speed, " BEST_NAME, NULL, speed_of(best), 1.0, 4, "lengths/s");
    report_fact(to, "Speed, " FIRST_NAME, NULL, speed_of(first), 1.0, 4, "lengths/s");
    if (!travel) {
        report_fact(to, "Loss, " BEST_NAME, "loss_best", r->best_loss, 1.0, 5, "");
        report_fact(to, "Loss, " FIRST_NAME, "loss_first", r->first_loss, 1.0, 5, "");
    }
    report_fact(to, "Iterations", "iterations", (double)r->iteration, 1.0, 0, "");
    report_fact(to, "Time", "seconds", r->seconds, 1.0, 1, "s");
}

/* ------------------------------------------------------------------ over iterations */
static void mark_best(report* to, const run* r, double value) {
    const double iteration = (double)r->best_iteration;
    report_series(to, "best", REPORT_MARK, &iteration, &value, 1, 1);
}

/* A column of the history; the rows of a struct are as far apart as its size. */
static void column(report* to, const run* r, const char* name, int style, const double* first_value, int64_t from,
                   int64_t rows, double* numbers, double* at) {
    const char* bytes = (const char*)first_value;
    for (int64_t k = 0; k < rows; ++k) {
        memcpy(&numbers[k], bytes + (size_t)(from + k) * sizeof *r->rows, sizeof(double));
        at[k] = (double)(from + k + 1);
    }
    report_series(to, name, style, at, numbers, rows, 1);
}

static void loss_charts(report* to, const run* r, double* numbers, double* at) {
    const int travel = objective_is_travel(r->loss);
    report_chart(to, REPORT_LINES, travel ? "Loss: minus the distance travelled" : "Loss", ITERATION,
                 travel ? "loss (m)" : "loss",
                 r->stage_first > 0 ? "Earlier stages of the schedule (grey) have coarser grids, so that their losses "
                                      "are not comparable."
                                    : NULL);
    if (r->stage_first > 0)
        column(to, r, "earlier stages", REPORT_FAINT, &r->rows[0].loss, 0, r->stage_first, numbers, at);
    column(to, r, "loss", REPORT_PLAIN, &r->rows[0].loss, r->stage_first, r->iteration - r->stage_first, numbers, at);
    if (r->best_iteration > 0) mark_best(to, r, r->best_loss);
    report_chart_end(to);
    if (r->loss->n_terms > 1) {
        report_chart(to, REPORT_LINES, "Terms of the loss, without their weights", ITERATION, "term", NULL);
        for (int32_t k = 0; k < r->loss->n_terms; ++k)
            column(to, r, objective_name(r->loss->kinds[k]), REPORT_PLAIN, &r->rows[0].terms[k], 0, r->iteration,
                   numbers, at);
        report_chart_end(to);
    }
}

static void weight_charts(report* to, const run* r, const dqa_shape_space* space) {
    const char** names = malloc((size_t)r->n_weights * sizeof *names);
    if (names == NULL) return;
    for (int64_t i = 0; i < r->n_weights; ++i) names[i] = dqa_shape_space_base_name(space, (int32_t)i);
    if (r->n_weights > 1) {
        report_chart(to, REPORT_LINES, "Share of each base shape", ITERATION, "share", NULL);
        for (int64_t i = 0; i < r->n_weights; ++i)
            report_series(to, names[i], REPORT_PLAIN, NULL, r->row_x + i, r->iteration, r->n);
        report_chart_end(to);
    }
    if (r->n_weights > 2) { /* below three axes there is nothing to span */
        report_chart(to, REPORT_RADAR, "Mix of base shapes", NULL, NULL, NULL);
        report_axes(to, names, r->n_weights);
        report_series(to, FIRST_NAME, REPORT_PLAIN, NULL, r->row_x, r->n_weights, 1);
        report_series(to, BEST_NAME, REPORT_PLAIN, NULL, r->best_x, r->n_weights, 1);
        report_chart_end(to);
    }
    free((void*)names);
}

/* One chart of all three numbers of a single sine, or one for each number of several. */
static void sine_charts(report* to, const run* r, double* numbers) {
    static const char* const titles[3] = {"Amplitudes", "Frequencies", "Phases"};
    static const char* const axes[3] = {"amplitude a", "\u03c9 / \u03c9\u2080", "phase \u03c6 (rad)"};
    const int64_t signals = r->n_control / 3;
    char title[96], name[96];
    if (signals == 1)
        report_chart(to, REPORT_LINES, "Muscle signal a sin(\u03c9t + \u03c6)", ITERATION,
                     "a, \u03c9/\u03c9\u2080, \u03c6", NULL);
    for (int part = 0; part < 3; ++part) {
        (void)snprintf(title, sizeof title, "%s of the muscle signals a sin(\u03c9t + \u03c6)", titles[part]);
        if (signals > 1) report_chart(to, REPORT_LINES, title, ITERATION, axes[part], NULL);
        for (int64_t k = 0; k < signals; ++k) {
            (void)snprintf(name, sizeof name, "signal %lld", (long long)k + 1);
            for (int64_t i = 0; i < r->iteration; ++i)
                numbers[i] = r->row_x[i * r->n + r->n_weights + 3 * k + part] / (part == 1 ? r->omega0 : 1.0);
            report_series(to, signals > 1 ? name : axes[part], REPORT_PLAIN, NULL, numbers, r->iteration, 1);
        }
        if (signals > 1) report_chart_end(to);
    }
    if (signals == 1) report_chart_end(to);
}

static int iteration_charts(report* to, const run* r, const dqa_shape_space* space) {
    double* numbers = malloc((size_t)(2 * r->iteration) * sizeof *numbers);
    double* at = numbers + r->iteration;
    if (numbers == NULL) return say_no_memory();
    loss_charts(to, r, numbers, at);
    weight_charts(to, r, space);
    if (!r->mlp && r->moves != RUN_WEIGHTS && r->n_control > 0) sine_charts(to, r, numbers);
    report_chart(to, REPORT_LOG, "Gradient of the loss", ITERATION, "2-norm", NULL);
    column(to, r, "by weights", REPORT_PLAIN, &r->rows[0].gradient_weights, 0, r->iteration, numbers, at);
    if (r->moves != RUN_WEIGHTS)
        column(to, r, "by controller", REPORT_PLAIN, &r->rows[0].gradient_control, 0, r->iteration, numbers, at);
    report_chart_end(to);
    free(numbers);
    return DONE;
}

/* ------------------------------------------------------------------ over time */
/* `width` columns of rows that belong to the ends of steps. */
static void step_series(report* to, const char* name, int style, const double* times, const double* rows, int64_t n,
                        int64_t width, double* numbers) {
    for (int64_t k = 0; k < n; ++k) numbers[k] = rows[k * width];
    report_series(to, name, style, times, numbers, n, 1);
}

/* Way of the surface's mean point along x, mm, at every frame. */
static void way(const motion* m, double* numbers) {
    for (int64_t k = 0; k < m->n_frames; ++k) {
        double sum = 0.0;
        for (int64_t i = 0; i < m->n_vertices; ++i) sum += motion_frame(m, k)[3 * i] - m->frames[3 * i];
        numbers[k] = 1e3 * sum / (double)m->n_vertices;
    }
}

static void current_chart(report* to, const motion* m, const double* times, double* numbers) {
    static const char* const axes[3] = {"along x", "along y", "along z"};
    double most = 0.0;
    for (int64_t i = 0; i < 3 * m->work.n_steps; ++i) most = fmax(most, fabs(m->work.current[i]));
    if (!(most > 0.0)) return;
    report_chart(to, REPORT_LINES, "Current of the water", TIME, "velocity (m/s)", NULL);
    for (int axis = 0; axis < 3; ++axis)
        step_series(to, axes[axis], REPORT_PLAIN, times, m->work.current + axis, m->work.n_steps, 3, numbers);
    report_chart_end(to);
}

static int time_charts(report* to, const motion* first, const motion* best) {
    static const char* const names[2] = {FIRST_NAME, BEST_NAME};
    const motion* both[2];
    const int64_t n = best->n_frames;
    double* times = malloc((size_t)(2 * n) * sizeof *times);
    double* numbers = times + n;
    char name[96];
    both[0] = first;
    both[1] = best;
    if (times == NULL) return say_no_memory();
    for (int64_t k = 0; k < n; ++k) times[k] = (double)k * best->time_step;
    report_chart(to, REPORT_LINES, "Way along x", TIME, "way (mm)", "Of the mean point of the surface.");
    for (int k = 0; k < 2; ++k) {
        way(both[k], numbers);
        report_series(to, names[k], REPORT_PLAIN, times, numbers, n, 1);
    }
    report_chart_end(to);
    for (int k = 0; k < 2 && best->work.n_signals > 0; ++k) {
        (void)snprintf(name, sizeof name, "Muscle signals, %s", names[k]);
        report_chart(to, REPORT_LINES, name, TIME, "signal u",
                     k == 0 ? NULL : "A muscle of signal u asks for its rest length times 1 \u2212 cu.");
        for (int32_t i = 0; i < both[k]->work.n_signals; ++i) {
            (void)snprintf(name, sizeof name, "signal %d", (int)i + 1);
            step_series(to, name, REPORT_PLAIN, times + 1, both[k]->work.signals + i, n - 1, both[k]->work.n_signals,
                        numbers);
        }
        report_chart_end(to);
    }
    for (int k = 0; k < 2; ++k) {
        (void)snprintf(name, sizeof name, "Forces of the water along x, %s", names[k]);
        report_chart(to, REPORT_LINES, name, TIME, "force (N)", k == 0 ? NULL : "On the swimmer; ahead is positive.");
        step_series(to, "drag", REPORT_PLAIN, times + 1, both[k]->work.forces, n - 1, 6, numbers);
        step_series(to, "thrust", REPORT_PLAIN, times + 1, both[k]->work.forces + 3, n - 1, 6, numbers);
        report_chart_end(to);
    }
    current_chart(to, best, times + 1, numbers);
    free(times);
    return DONE;
}

/* ------------------------------------------------------------------ all of it */
static void tables(report* to, const run* r, const options* o, const scene* s) {
    summary_settings(report_table(to, "Settings"), o, r, s);
    report_table_end(to);
    summary_proofs(report_table(to, "Proof of the gradient by finite differences"), r);
    report_table_end(to);
    summary_machine(report_table(to, "Machine"), o);
    report_table_end(to);
}

int report_run(const char* program, const run* r, const options* o, const scene* s, const motion* first,
               const motion* best, const char* command, const char* folder) {
    report to;
    char subtitle[256];
    int outcome;
    (void)snprintf(subtitle, sizeof subtitle,
                   "%lld base shape%s on %d\u00d7%d\u00d7%d cells, %lld iteration%s of %lld steps (%.2f s of swimming)",
                   (long long)r->n_weights, r->n_weights == 1 ? "" : "s", (int)o->grid[0], (int)o->grid[1],
                   (int)o->grid[2], (long long)r->iteration, r->iteration == 1 ? "" : "s", (long long)o->steps,
                   (double)o->steps * s->time_step);
    outcome = report_open(&to, folder, program, "An optimised swimmer", subtitle, command);
    if (outcome != DONE) return outcome;
    facts(&to, r, first, best);
    report_swimmer(&to, FIRST_NAME, first);
    report_swimmer(&to, BEST_NAME, best);
    outcome = iteration_charts(&to, r, s->space);
    if (outcome == DONE) outcome = time_charts(&to, first, best);
    if (outcome != DONE) {
        report_discard(&to);
        return outcome;
    }
    tables(&to, r, o, s);
    return report_close(&to);
}
