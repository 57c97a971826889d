/* SPDX-License-Identifier: MIT
 * What all pictures drawn by gnuplot share: page, panels for curves, swimmers in their lanes, and the call of gnuplot.
 * gnuplot reads the numbers from the tables and the swimmers from files beside them, so that a script stays short and
 * can be changed and run again by hand. */
#define _POSIX_C_SOURCE 200809L
#include "plot.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "interrupt.h"
#include "output.h"
#include "say.h"

/* Pixels. */
#define PICTURE_WIDTH 1600.0
#define PICTURE_HEIGHT 1200.0
#define PANEL_WIDTH 770.0 /* of the view of one swimmer, its time labels included */
#define PANEL_HEIGHT 610.0
#define TIME_LABEL 85.0
#define TICS 72.0
#define PANEL_BOTTOM 0.035 /* share of the picture's height */

/* In gnuplot's single quotes, where only the quote itself is special. */
void plot_quoted(FILE* f, const char* text, size_t most) {
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

void plot_page(FILE* f, const char* picture, const char* script, int width, int height) {
    fprintf(f,
            "# Draws %s from the tables and picture/; run it in this folder: gnuplot %s\n"
            "if (!exists('out')) out = '%s'\n"
            "if (strstrt(GPVAL_TERMINALS, 'pngcairo') > 0) \\\n"
            "    set terminal pngcairo size %d,%d font 'DejaVu Sans,14' background '#ffffff'; \\\n"
            "else set terminal png truecolor size %d,%d font 'DejaVu Sans,14'\n"
            "set output out\nset encoding utf8\nset multiplot\n",
            picture, script, picture, width, height, width, height);
}

void plot_lines(FILE* f) {
    fputs(
        "set datafile separator ','\n"
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
        "set linetype 8 lc rgb '#404040' lw 3\n",
        f);
}

void plot_head(FILE* f, const char* picture, const char* script) {
    plot_page(f, picture, script, (int)PICTURE_WIDTH, (int)PICTURE_HEIGHT);
    plot_lines(f);
}

/* The panel between fractions left and right of the picture's width, in its upper part; its key goes below. */
void plot_panel(FILE* f, const char* title, double left, double right) {
    fprintf(f, "set lmargin at screen %.4f; set rmargin at screen %.4f\n", left, right);
    fputs("set tmargin at screen 0.95; set bmargin at screen 0.705\n", f);
    fprintf(f, "set title '%s' font ',16'\n", title);
    fprintf(f, "set key at screen %.4f,0.655 top center horizontal Left reverse noenhanced font ',12' samplen 1.5\n",
            0.5 * (left + right));
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

void plot_scenery(FILE* f, const lanes_box* box) {
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

void plot_swimmer(FILE* f, const motion* m, const lanes_box* box, const char* what, const char* name, double left) {
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
            "splot '" PLOT_FOLDER
            "/%s_shadow.dat' using 1:2:3:4 with pm3d lc rgb variable, \\\n"
            "      '" PLOT_FOLDER "/%s.dat' using 1:2:3:4 with pm3d lc rgb variable\n",
            name, name);
}

/* Runs `gnuplot` in the folder; its exit status, 127 when there is none, -1 (said) when it could not be started. */
static int run_gnuplot(const char* folder, const char* out, const char* script) {
    int status = 0;
    const pid_t child = fork();
    if (child < 0) {
        say("cannot start gnuplot: %s", strerror(errno));
        return -1;
    }
    if (child == 0) {
        /* gnuplot can hang in its own handler of SIGINT: it is not to see a Ctrl-C of the terminal. */
        sigset_t keys;
        (void)sigemptyset(&keys);
        (void)sigaddset(&keys, SIGINT);
        (void)sigprocmask(SIG_BLOCK, &keys, NULL);
        if (chdir(folder) == 0) (void)execlp("gnuplot", "gnuplot", "-e", out, script, (char*)NULL);
        _exit(errno == ENOENT ? 127 : 126);
    }
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

int plot_draw(const char* folder, const char* picture, const char* script, int* drawn) {
    char name[64], set_out[80];
    char *partial, *final;
    int outcome;
    (void)snprintf(name, sizeof name, "%s.part", picture);
    (void)snprintf(set_out, sizeof set_out, "out='%s'", name);
    partial = output_path(folder, name);
    final = output_path(folder, picture);
    outcome = partial != NULL && final != NULL ? DONE : FAILED;
    *drawn = 0;
    if (outcome == DONE) {
        const int status = run_gnuplot(folder, set_out, script);
        if (status == 0 && rename(partial, final) == 0) {
            *drawn = 1;
        } else {
            (void)unlink(partial);
            if (interrupted()) {
                outcome = INTERRUPTED;
            } else if (status == 127) {
                say("gnuplot is not installed, so there is no %s; with it:  cd %s && gnuplot %s", picture, folder,
                    script);
            } else {
                if (status >= 0) say("gnuplot could not draw %s (exit status %d)", picture, status);
                outcome = FAILED;
            }
        }
    }
    free(partial);
    free(final);
    return outcome;
}
