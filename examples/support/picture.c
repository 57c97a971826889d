/* SPDX-License-Identifier: MIT
 * codesign.png. gnuplot reads the numbers from history.csv and the swimmers from picture/, so that the script stays
 * short and can be changed and run again by hand: `gnuplot codesign.gp`. */
#include "picture.h"

#include <math.h>
#include <stdlib.h>

#include "history.h"
#include "lanes.h"
#include "output.h"
#include "plot.h"
#include "say.h"

#define FIRST_NAME "first"
#define BEST_NAME "best"

#define KEY_ENTRIES 8

/* The bases worth naming: those of which the best design has most, at most KEY_ENTRIES of them. */
static int has_title(const run* r, int64_t base) {
    int64_t larger = 0;
    for (int64_t i = 0; i < r->n_weights; ++i)
        if (r->best_x[i] > r->best_x[base] || (r->best_x[i] >= r->best_x[base] && i < base)) ++larger;
    return larger < KEY_ENTRIES;
}

static void weight_curves(FILE* f, const run* r, const dqa_shape_space* space) {
    fputs("set yrange [-0.02:1.02]\nplot ", f);
    for (int64_t i = 0; i < r->n_weights; ++i) {
        if (i > 0) fputs(", \\\n     ", f);
        fprintf(f, "'" HISTORY_FILE "' every ::1 using 1:%lld with linespoints lt %lld pt 7 ps 0.6 ", (long long)i + 3,
                (long long)i % 8 + 1);
        if (has_title(r, i)) {
            fputs("title ", f);
            plot_quoted(f, dqa_shape_space_base_name(space, (int32_t)i), 20);
        } else {
            fputs("notitle", f);
        }
    }
    fputs("\nset autoscale y\n", f);
}

static void control_curves(FILE* f, const run* r) {
    static const char* const names[3] = {"amplitude a", "\u03c9 / \u03c9\u2080", "phase \u03c6"};
    fputs("plot ", f);
    for (int64_t i = 0; i < r->n_control; ++i) {
        if (i > 0) fputs(", \\\n     ", f);
        fprintf(f, "'" HISTORY_FILE "' every ::1 using 1:($%lld/%.9g) with linespoints lt %lld pt 7 ps 0.6 ",
                (long long)(r->n_weights + i) + 3, i % 3 == 1 ? r->omega0 : 1.0, (long long)i % 3 + 1);
        if (i < 3)
            fprintf(f, "title '%s'", names[i]);
        else
            fputs("notitle", f);
    }
    fputc('\n', f);
}

/* A range with room around it also when the loss has not changed, where gnuplot's own tics become meaningless. */
static void loss_range(FILE* f, const run* r) {
    double least = HUGE_VAL, most = -HUGE_VAL, room;
    for (int64_t k = 0; k < r->iteration; ++k) {
        least = fmin(least, r->rows[k].loss);
        most = fmax(most, r->rows[k].loss);
    }
    room = fmax(0.06 * (most - least), fmax(0.01 * fabs(most), 1e-6));
    fprintf(f, "set yrange [%.9g:%.9g]\n", least - room, most + room);
}

static void curves(FILE* f, const run* r, const dqa_shape_space* space) {
    const int n_panels = r->moves == RUN_WEIGHTS || r->mlp ? 2 : 3;
    const double width = 1.0 / n_panels;
    const long long last = (long long)(r->iteration > 1 ? r->iteration : 2);
    fprintf(f, "set xrange [1:%lld]\nset xlabel 'iteration' offset 0,0.5\n", last);
    if (last <= 10) fputs("set xtics 1\n", f);
    plot_panel(f, objective_is_travel(r->loss) ? "Loss: minus the distance travelled (m)" : "Loss", 0.075,
               width - 0.02);
    loss_range(f, r);
    fputs("plot ", f);
    /* Coarser grids have losses of their own. */
    if (r->stage_first > 0)
        fprintf(
            f,
            "'" HISTORY_FILE
            "' every ::1::%lld using 1:2 with linespoints pt 7 ps 0.6 lw 2 lc rgb '#a0a0a0' title 'earlier stages', "
            "\\\n     ",
            (long long)r->stage_first);
    fprintf(f,
            "'" HISTORY_FILE
            "' every ::%lld using 1:2 with linespoints lt 1 pt 7 ps 0.8 title 'loss', \\\n"
            "     '+' every ::0::0 using (%lld):(%.9g) with points pt 6 ps 2.6 lw 2.5 lc rgb '#d55e00' title 'best'\n",
            (long long)r->stage_first + 1, (long long)r->best_iteration, r->best_loss);
    plot_panel(f, "Share of each base shape", width + 0.045, 2.0 * width - 0.02);
    weight_curves(f, r, space);
    if (n_panels == 3) {
        plot_panel(f, "Muscle signal a sin(\u03c9t + \u03c6)", 2.0 * width + 0.045, 1.0 - 0.02);
        control_curves(f, r);
    }
}

static int write_script(const run* r, const dqa_shape_space* space, const motion* first, const motion* best,
                        const lanes_box* box, const char* folder) {
    output_file file;
    if (output_open(&file, folder, PICTURE_SCRIPT) != DONE) return FAILED;
    plot_head(file.stream, PICTURE_FILE, PICTURE_SCRIPT);
    curves(file.stream, r, space);
    plot_scenery(file.stream, box);
    plot_swimmer(file.stream, first, box, "First swimmer", FIRST_NAME, 0.01);
    plot_swimmer(file.stream, best, box, "Optimised swimmer", BEST_NAME, 0.51);
    fputs("unset multiplot\nset output\n", file.stream);
    return output_commit(&file);
}

int picture_make(const run* r, const dqa_shape_space* space, const motion* first, const motion* best,
                 const char* folder, int* drawn) {
    const motion* both[2];
    lanes_box box;
    int created = 0;
    char* data = output_path(folder, PLOT_FOLDER);
    int outcome = data != NULL ? output_folder(data, &created) : FAILED;
    *drawn = 0;
    both[0] = first;
    both[1] = best;
    lanes_measure(&box, both, 2);
    if (outcome == DONE)
        outcome = lanes_write(first, &box, PICTURE_FIRST_COLOUR, data, FIRST_NAME ".dat", FIRST_NAME "_shadow.dat");
    if (outcome == DONE)
        outcome = lanes_write(best, &box, PICTURE_BEST_COLOUR, data, BEST_NAME ".dat", BEST_NAME "_shadow.dat");
    if (outcome == DONE) outcome = write_script(r, space, first, best, &box, folder);
    if (outcome == DONE) outcome = plot_draw(folder, PICTURE_FILE, PICTURE_SCRIPT, drawn);
    free(data);
    return outcome;
}
