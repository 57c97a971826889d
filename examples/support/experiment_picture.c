/* SPDX-License-Identifier: MIT
 * The picture of an experiment: curves of its trials from their tables, and the first and best swimmer of one. */
#include <stdlib.h>

#include "experiment.h"
#include "output.h"
#include "picture.h"
#include "plot.h"
#include "say.h"

#define COLOURS 8        /* of lines, after plot_head */
#define LEAST_SHARE 0.08 /* of a base that is named where there are many */
#define SIGNALS_FILE "signals.csv"

int experiment_column_weight(const experiment* e, int i) {
    (void)e;
    return 3 + i;
}

int experiment_column_after(const experiment* e, int k) {
    const run* r = &e->trials[0].r;
    return 2 + (int)(r->mlp ? r->n_weights : r->n) + 1 + k;
}

void experiment_curves(const experiment* e, FILE* f, const char* x, int y, int lowest) {
    const int crowd = e->n_trials > COLOURS;
    for (int k = 0; lowest && k < e->n_trials; ++k) fprintf(f, "least%d = 1e300\n", k);
    fputs("plot ", f);
    /* The first last, so that it lies above the crowd. */
    for (int i = 1; i <= e->n_trials; ++i) {
        const int k = i % e->n_trials;
        const trial* t = &e->trials[k];
        char value[96];
        if (lowest)
            (void)snprintf(value, sizeof value, "(least%d = ($%d < least%d ? $%d : least%d))", k, y, k, y, k);
        else
            (void)snprintf(value, sizeof value, "%d", y);
        fprintf(f, "%s'%s/history.csv' every ::1 using %s:%s with lines ", i > 1 ? ", \\\n     " : "", t->plan->name, x,
                value);
        if (crowd && k > 0) {
            fputs("lw 1.5 lc rgb '#a0b8c8' ", f);
            fputs(k == 1 ? "title " : "notitle", f);
            if (k == 1) plot_quoted(f, e->plan->crowd, 40);
        } else {
            fprintf(f, "lt %d title ", k + 1);
            plot_quoted(f, t->plan->label, 40);
        }
    }
    fputc('\n', f);
}

void experiment_shares(const experiment* e, FILE* f) {
    const trial* t = &e->trials[e->shown];
    int named = 0;
    for (int i = 0; i < (int)t->r.n_weights; ++i) {
        const int is_named = t->r.n_weights <= COLOURS || (t->r.best_x[i] > LEAST_SHARE && named < COLOURS);
        fprintf(f, "%s'%s/history.csv' every ::1 using 1:%d with lines ", i > 0 ? ", \\\n     " : "plot ",
                t->plan->name, experiment_column_weight(e, i));
        if (is_named) {
            fprintf(f, "lt %d title ", ++named);
            plot_quoted(f, dqa_shape_space_base_name(e->s.space, i), 24);
        } else {
            fputs("lw 1.5 lc rgb '#a0b8c8' notitle", f);
        }
    }
    fputc('\n', f);
}

void experiment_signals(const experiment* e, FILE* f) {
    dqa_shape_space_info info;
    if (say_status(dqa_shape_space_get_info(e->s.space, &info, sizeof info), "read the shape space") != DONE) return;
    fputs("plot ", f);
    for (int k = info.n_signals - 1; k >= 0; --k) {
        dqa_signal_info signal;
        if (say_status(dqa_shape_space_signal(e->s.space, k, &signal, sizeof signal), "read a signal") != DONE) return;
        fprintf(f, "'" PLOT_FOLDER "/" SIGNALS_FILE "' using 1:%d with lines ", k + 2);
        if (signal.kind == DQA_ACTUATOR_CAUDAL)
            fputs("lt 2 title 'tail'", f);
        else
            fprintf(f, "lw 1 lc rgb '#a0b8c8' %s", k + 1 == info.n_signals ? "title 'fins'" : "notitle");
        fputs(k > 0 ? ", \\\n     " : "\n", f);
    }
}

/* Rows of time and signals. */
static int write_signals(const motion* m, const char* folder) {
    output_file file;
    int outcome = output_open(&file, folder, SIGNALS_FILE);
    if (outcome != DONE) return outcome;
    for (int64_t step = 0; step < m->work.n_steps; ++step) {
        fprintf(file.stream, "%.9g", (double)step * m->time_step);
        for (int32_t k = 0; k < m->work.n_signals; ++k)
            fprintf(file.stream, ",%.9g", m->work.signals[step * m->work.n_signals + k]);
        fputc('\n', file.stream);
    }
    return output_commit(&file);
}

int experiment_draw(const experiment* e, const motion* first, const motion* best, int* drawn) {
    const motion* both[2];
    const experiment_plan* plan = e->plan;
    lanes_box box;
    output_file file;
    int created = 0;
    char* data = output_path(e->o.out, PLOT_FOLDER);
    int outcome = data != NULL ? output_folder(data, &created) : FAILED;
    both[0] = first;
    both[1] = best;
    lanes_measure(&box, both, 2);
    if (outcome == DONE)
        outcome = lanes_write(first, &box, PICTURE_FIRST_COLOUR, data, "first.dat", "first_shadow.dat");
    if (outcome == DONE) outcome = lanes_write(best, &box, PICTURE_BEST_COLOUR, data, "best.dat", "best_shadow.dat");
    if (outcome == DONE) outcome = write_signals(best, data);
    if (outcome == DONE) outcome = output_open(&file, e->o.out, plan->script);
    if (outcome == DONE) {
        plot_head(file.stream, plan->picture, plan->script);
        plan->curves(e, file.stream);
        plot_scenery(file.stream, &box);
        plot_swimmer(file.stream, first, &box, plan->first_label, "first", 0.01);
        plot_swimmer(file.stream, best, &box, plan->best_label, "best", 0.51);
        fputs("unset multiplot\nset output\n", file.stream);
        outcome = output_commit(&file);
    }
    if (outcome == DONE) outcome = plot_draw(e->o.out, plan->picture, plan->script, drawn);
    free(data);
    return outcome;
}
