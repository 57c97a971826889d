/* SPDX-License-Identifier: MIT
 * codesign.png. gnuplot reads the numbers from history.csv and the swimmers from picture/, so that the script stays
 * short and can be changed and run again by hand: `gnuplot codesign.gp`. */
#define _POSIX_C_SOURCE 200809L
#include "picture.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "history.h"
#include "interrupt.h"
#include "lanes.h"
#include "output.h"
#include "say.h"

#define FIRST_NAME "first"
#define BEST_NAME "best"
#define FIRST_COLOUR 0x5b6770u /* slate */
#define BEST_COLOUR 0x0b5c8au  /* deep blue */

/* Pixels. */
#define PICTURE_WIDTH 1600.0
#define PICTURE_HEIGHT 1200.0
#define PANEL_WIDTH 770.0 /* of the view of one swimmer, its time labels included */
#define PANEL_HEIGHT 610.0
#define TIME_LABEL 85.0
#define TICS 72.0
#define PANEL_BOTTOM 0.035 /* share of the picture's height */
#define KEY_ENTRIES 8

/* In gnuplot's single quotes, where only the quote itself is special. */
static void quoted(FILE* f, const char* text, size_t most) {
    fputc('\'', f);
    for (size_t i = 0; text[i] != '\0'; ++i) {
        if (i == most) {
            fputs("...", f);
            break;
        }
        if (text[i] == '\'') fputc('\'', f);
        fputc(text[i] == '\n' ? ' ' : text[i], f);
    }
    fputc('\'', f);
}

static void head(FILE* f) {
    fputs(
        "# Draws codesign.png from history.csv and picture/; run it in this folder: gnuplot codesign.gp\n"
        "if (!exists('out')) out = '" PICTURE_FILE
        "'\n"
        "if (strstrt(GPVAL_TERMINALS, 'pngcairo') > 0) \\\n"
        "    set terminal pngcairo size 1600,1200 font 'DejaVu Sans,14' background '#ffffff'; \\\n"
        "else set terminal png truecolor size 1600,1200 font 'DejaVu Sans,14'\n"
        "set output out\n"
        "set datafile separator ','\n"
        "set encoding utf8\n"
        "set border 3 lc rgb '#606060'\n"
        "set tics nomirror textcolor rgb '#303030'\n"
        "set grid lc rgb '#dddddd' lt 1 lw 1\n"
        "set linetype 1 lc rgb '#0072b2' lw 3\n"
        "set linetype 2 lc rgb '#d55e00' lw 3\n"
        "set linetype 3 lc rgb '#009e73' lw 3\n"
        "set linetype 4 lc rgb '#cc79a7' lw 3\n"
        "set linetype 5 lc rgb '#e69f00' lw 3\n"
        "set linetype 6 lc rgb '#56b4e9' lw 3\n"
        "set linetype 7 lc rgb '#7f3c8d' lw 3\n"
        "set linetype 8 lc rgb '#404040' lw 3\n"
        "set multiplot\n",
        f);
}

/* The panel between fractions left and right of the picture's width, in its upper part; its key goes below. */
static void panel(FILE* f, const char* title, double left, double right) {
    fprintf(f, "set lmargin at screen %.4f; set rmargin at screen %.4f\n", left, right);
    fputs("set tmargin at screen 0.95; set bmargin at screen 0.705\n", f);
    fprintf(f, "set title '%s' font ',16'\n", title);
    fprintf(f, "set key at screen %.4f,0.655 top center horizontal Left reverse noenhanced font ',12' samplen 1.5\n",
            0.5 * (left + right));
}

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
            quoted(f, dqa_shape_space_base_name(space, (int32_t)i), 20);
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
    const int n_panels = r->fixed_control || r->mlp ? 2 : 3;
    const double width = 1.0 / n_panels;
    const long long last = (long long)(r->iteration > 1 ? r->iteration : 2);
    fprintf(f, "set xrange [1:%lld]\nset xlabel 'iteration' offset 0,0.5\n", last);
    if (last <= 10) fputs("set xtics 1\n", f);
    panel(f, objective_is_travel(r->loss) ? "Loss: minus the distance travelled (m)" : "Loss", 0.075, width - 0.02);
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
    panel(f, "Share of each base shape", width + 0.045, 2.0 * width - 0.02);
    weight_curves(f, r, space);
    if (n_panels == 3) {
        panel(f, "Muscle signal a sin(\u03c9t + \u03c6)", 2.0 * width + 0.045, 1.0 - 0.02);
        control_curves(f, r);
    }
}

/* Pixels a metre at which all swimmers fill their panels. */
static double scale_of(const lanes_box* box) {
    return fmin((PANEL_WIDTH - TIME_LABEL) / (box->right - box->left), PANEL_HEIGHT / (box->above - box->below));
}

/* The zoom of `set view` that gives this scale: with `set view equal xyz` and no margins gnuplot maps the longest axis
 * to 4/7 of the smaller side of the plot, less what it keeps for tics. */
static double zoom_of(const lanes_box* box) {
    const double longest = fmax(fmax(box->x_most - box->x_least, 2.0 * lanes_edge(box)), box->top - box->floor);
    return scale_of(box) * longest / (4.0 / 7.0 * (fmin(PANEL_WIDTH, PANEL_HEIGHT) - TICS));
}

static void scenery(FILE* f, const lanes_box* box) {
    /* gnuplot drops what lies outside its ranges, be it by a rounded digit: the shadows lie on the very floor. */
    const double y = lanes_edge(box), slack = 0.001 * (box->top - box->floor);
    fprintf(f,
            "unset border; unset tics; unset grid; unset xlabel; unset ylabel; unset key; unset colorbox\n"
            "set datafile separator whitespace\n"
            "set view %g, %g, %.4f\nset view equal xyz\nset xyplane at %.6g\n"
            "set xrange [%.6g:%.6g]\nset yrange [%.6g:%.6g]\nset zrange [%.6g:%.6g]\n"
            "set pm3d depthorder corners2color c1\n",
            LANES_VIEW_X, LANES_VIEW_Z, zoom_of(box), box->floor, box->x_least, box->x_most, -y, y, box->floor - slack,
            box->top + slack);
}

/* A straight line on the floor. */
static void floor_line(FILE* f, const lanes_box* box, double x0, double y0, double x1, double y1, const char* style) {
    fprintf(f, "set arrow from %.6g,%.6g,%.6g to %.6g,%.6g,%.6g nohead %s\n", x0, y0, box->floor, x1, y1, box->floor,
            style);
}

static void swimmer(FILE* f, const motion* m, const lanes_box* box, const char* what, const char* name, double left) {
    const double y = lanes_edge(box), start = lanes_nose(m, 0);
    /* The view is centred where the box is; what it covers is to be in the middle of the panel. */
    const double scale = scale_of(box);
    const double middle =
        left + (0.5 * (PANEL_WIDTH - TIME_LABEL) - 0.5 * scale * (box->left + box->right)) / PICTURE_WIDTH;
    const double centre =
        PANEL_BOTTOM + (0.5 * PANEL_HEIGHT - 0.5 * scale * (box->below + box->above)) / PICTURE_HEIGHT;
    fprintf(f,
            "set origin %.4f,%.4f; set size %.4f,%.4f; set margins 0,0,0,0\n"
            "unset title; unset label; unset arrow\n"
            "set label '%s' at screen %.4f,0.605 center font ',16'\n"
            "set label 'travels %.2f mm in %.2f s (blue: its nose)' at screen %.4f,0.58 center font ',13' "
            "tc rgb '#505050'\n",
            middle - 0.5 * PANEL_WIDTH / PICTURE_WIDTH, centre - 0.5 * PANEL_HEIGHT / PICTURE_HEIGHT,
            PANEL_WIDTH / PICTURE_WIDTH, PANEL_HEIGHT / PICTURE_HEIGHT, what, left + 0.24, -1e3 * m->loss,
            (double)(m->n_frames - 1) * m->time_step, left + 0.24);
    for (int lane = 0; lane < LANES; ++lane) {
        /* The lane's middle line, where its swimmer's nose stands above the floor, and its time. */
        const double at = lanes_y(box, lane), nose = lanes_nose(m, lanes_frame(m, lane)), half = 0.2 * box->spacing;
        floor_line(f, box, box->x_least, at, box->x_most, at, "lc rgb '#c4d3da' lw 1.2 back");
        floor_line(f, box, nose, at - half, nose, at + half, "lc rgb '#0072b2' lw 4 back");
        fprintf(f, "set label 't = %.2f s' at %.6g,%.6g,%.6g left offset 0.5,0 font ',12' tc rgb '#303030'\n",
                (double)lanes_frame(m, lane) * m->time_step, box->x_most, at, box->floor);
    }
    floor_line(f, box, start, -y, start, y, "lc rgb '#d55e00' lw 2.5 back");
    fprintf(f, "set label 'start' at %.6g,%.6g,%.6g center offset 0,-0.7 font ',12' tc rgb '#d55e00'\n", start, -y,
            box->floor);
    fprintf(f,
            "splot '" PICTURE_FOLDER
            "/%s_shadow.dat' using 1:2:3:4 with pm3d lc rgb variable, \\\n"
            "      '" PICTURE_FOLDER "/%s.dat' using 1:2:3:4 with pm3d lc rgb variable\n",
            name, name);
}

static int write_script(const run* r, const dqa_shape_space* space, const motion* first, const motion* best,
                        const lanes_box* box, const char* folder) {
    output_file file;
    if (output_open(&file, folder, PICTURE_SCRIPT) != DONE) return FAILED;
    head(file.stream);
    curves(file.stream, r, space);
    scenery(file.stream, box);
    swimmer(file.stream, first, box, "First swimmer", FIRST_NAME, 0.01);
    swimmer(file.stream, best, box, "Optimised swimmer", BEST_NAME, 0.51);
    fputs("unset multiplot\nset output\n", file.stream);
    return output_commit(&file);
}

/* Runs `gnuplot` in the folder; its exit status, 127 when there is none, -1 (said) when it could not be started. */
static int run_gnuplot(const char* folder) {
    int status = 0;
    const pid_t child = fork();
    if (child < 0) {
        say("cannot start gnuplot: %s", strerror(errno));
        return -1;
    }
    if (child == 0) {
        if (chdir(folder) == 0)
            (void)execlp("gnuplot", "gnuplot", "-e", "out='" PICTURE_FILE ".part'", PICTURE_SCRIPT, (char*)NULL);
        _exit(errno == ENOENT ? 127 : 126);
    }
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

static int draw(const char* folder, int* drawn) {
    char* partial = output_path(folder, PICTURE_FILE ".part");
    char* final = output_path(folder, PICTURE_FILE);
    int outcome = partial != NULL && final != NULL ? DONE : FAILED;
    if (outcome == DONE) {
        const int status = run_gnuplot(folder);
        if (status == 0 && rename(partial, final) == 0) {
            *drawn = 1;
        } else {
            (void)unlink(partial);
            if (interrupted()) {
                outcome = INTERRUPTED;
            } else if (status == 127) {
                say("gnuplot is not installed, so there is no " PICTURE_FILE
                    "; with it:  cd %s && gnuplot " PICTURE_SCRIPT,
                    folder);
            } else {
                if (status >= 0) say("gnuplot could not draw " PICTURE_FILE " (exit status %d)", status);
                outcome = FAILED;
            }
        }
    }
    free(partial);
    free(final);
    return outcome;
}

int picture_make(const run* r, const dqa_shape_space* space, const motion* first, const motion* best,
                 const char* folder, int* drawn) {
    const motion* both[2];
    lanes_box box;
    int created = 0;
    char* data = output_path(folder, PICTURE_FOLDER);
    int outcome = data != NULL ? output_folder(data, &created) : FAILED;
    *drawn = 0;
    both[0] = first;
    both[1] = best;
    lanes_measure(&box, both, 2);
    if (outcome == DONE)
        outcome = lanes_write(first, &box, FIRST_COLOUR, data, FIRST_NAME ".dat", FIRST_NAME "_shadow.dat");
    if (outcome == DONE)
        outcome = lanes_write(best, &box, BEST_COLOUR, data, BEST_NAME ".dat", BEST_NAME "_shadow.dat");
    if (outcome == DONE) outcome = write_script(r, space, first, best, &box, folder);
    if (outcome == DONE) outcome = draw(folder, drawn);
    free(data);
    return outcome;
}
