/* SPDX-License-Identifier: MIT
 *
 * shape_exploration — the shape space of section 8.1 of Ma et al., "DiffAqua", 2021: three bases at the corners of a
 * triangle, twelve shapes between them, and the muscles of all of them, as one picture.
 * `shape_exploration --help` lists the options.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/census.h"
#include "support/gallery.h"
#include "support/interrupt.h"
#include "support/options.h"
#include "support/output.h"
#include "support/plot.h"
#include "support/progress.h"
#include "support/say.h"
#include "support/scene.h"
#include "support/stl.h"
#include "support/summary.h"

#define SIDE 4                                 /* steps along a side of the triangle */
#define N_SHAPES ((SIDE + 1) * (SIDE + 2) / 2) /* the bases and 12 between them */
#define PICTURE "shape_exploration.png"
#define SCRIPT "shape_exploration.gp"
#define SPACING 0.86 /* between neighbours on the page, in lengths of the longest base */
#define ROWS 0.68    /* between rows, relative to that */
#define ROOM 0.5     /* around the triangle, in lengths */
#define LEAST_OVERLAP 0.97
#define MUSCLE_SHARE 0.25 /* of the stiffest cell of a category: what counts as muscle in the picture */

static const char help[] =
    "usage: shape_exploration [options] [mesh mesh mesh]\n"
    "       shape_exploration [options] --bases-file FILE\n"
    "\n"
    "Interpolates between three meshes (clownfish, manta ray and stingray unless others are named) and draws the\n"
    "triangle of the twelve shapes between them, with their muscles.\n"
    "\n"
    "  --bases-file FILE meshes and their muscles from a list; see codesign --help\n"
    "  --grid NXxNYxNZ   cells of the box (60x54x14; quick 30x27x8)\n"
    "  --sigma S         width of the interpolation's kernel in cells, 0.2 to 16 (0.4)\n"
    "  --out DIR         folder of the results (./shape_exploration-out)\n"
    "  --quick           a coarse version, within a minute\n"
    "  --threads N       results do not depend on it (number of processors, at most 16)\n"
    "  --help            this text\n"
    "\n"
    "Exit codes: 0 done, 1 failure, 2 wrong command line, 130 interrupted.\n";

static const char* const words[] = {"--bases-file", "--grid", "--sigma", "--out", "--quick", "--threads", NULL};
static const char* const shapes[] = {"clownfish.stl", "manta_ray.stl", "stingray.stl", NULL};

static const options_form form = {.program = "shape_exploration",
                                  .help = help,
                                  .out = "shape_exploration-out",
                                  .words = words,
                                  .shapes = shapes,
                                  .quick = {{30, 27, 8}, 1, 1, 0, 0.4},
                                  .shipped = {{60, 54, 14}, 1, 1, 0, 0.4},
                                  .user = {{60, 54, 14}, 1, 1, 0, 0.4}};

/* What is known of a shape. */
typedef struct shape {
    double weights[3];
    double volume;  /* m^3 */
    double largest; /* share of its largest part */
    double overlap; /* with the base that it should give back; negative: it is none */
    double seconds;
    int64_t body_cells, parts, muscle_cells;
} shape;

typedef struct job {
    options o;
    scene s;
    progress p;
    shape shapes[N_SHAPES];
    gallery bodies, muscles;
} job;

/* ------------------------------------------------------------------ a shape */
/* The first base at the top, the second at the lower left, the third at the lower right. */
static void place_of(const double* weights, double* place) {
    place[0] = SPACING * SIDE * (0.5 * weights[0] + weights[2]);
    place[1] = ROWS * SPACING * SIDE * weights[0];
}

/* Red, green and blue at the corners, mixed between them and never dark. */
static uint32_t colour_of(const double* weights) {
    static const double corners[3][3] = {{216, 84, 60}, {60, 160, 84}, {58, 104, 196}};
    uint32_t colour = 0;
    for (int i = 0; i < 3; ++i) {
        double value = 0.0;
        for (int b = 0; b < 3; ++b) value += weights[b] * corners[b][i];
        colour = colour << 8 | (uint32_t)(1.12 * value + 0.5);
    }
    return colour;
}

static int measure(job* w, shape* out) {
    const int32_t* cells = w->o.grid;
    const int64_t n = (int64_t)cells[0] * cells[1] * cells[2];
    double* density = malloc((size_t)n * sizeof *density);
    double* base = malloc((size_t)n * sizeof *base);
    int outcome = density != NULL && base != NULL ? DONE : say_no_memory();
    if (outcome == DONE)
        outcome = say_status(dqa_shape_space_density(w->s.space, out->weights, 3, density, n), "interpolate a shape");
    if (outcome == DONE) {
        out->parts = census_parts(density, cells, &out->largest);
        if (out->parts < 0) outcome = FAILED;
    }
    out->overlap = -1.0;
    for (int32_t b = 0; b < 3 && outcome == DONE; ++b) {
        if (out->weights[b] < 1.0) continue;
        outcome = say_status(dqa_shape_space_get_base(w->s.space, b, base, n), "read a base");
        if (outcome == DONE) out->overlap = census_overlap(density, base, n);
    }
    free(density);
    free(base);
    return outcome;
}

static int draw_body(job* w, const shape* of, const char* name) {
    int64_t n_vertices = 0, n_triangles = 0;
    double place[2], *vertices = NULL;
    int32_t* triangles = NULL;
    int outcome = say_status(dqa_simulator_surface(w->s.simulator, NULL, 0, NULL, 0, &n_vertices, &n_triangles),
                             "read the surface");
    if (outcome != DONE) return outcome;
    vertices = malloc((size_t)n_vertices * 3 * sizeof *vertices);
    triangles = malloc((size_t)n_triangles * 3 * sizeof *triangles);
    if (vertices == NULL || triangles == NULL) outcome = say_no_memory();
    if (outcome == DONE)
        outcome = say_status(
            dqa_simulator_surface(w->s.simulator, vertices, 3 * n_vertices, triangles, 3 * n_triangles, NULL, NULL),
            "read the surface");
    place_of(of->weights, place);
    if (outcome == DONE)
        outcome = gallery_add_surface(&w->bodies, vertices, n_vertices, triangles, n_triangles, place,
                                      colour_of(of->weights));
    /* Beside the muscles: a veil that lets them show through. */
    if (outcome == DONE)
        outcome = gallery_add_surface(&w->muscles, vertices, n_vertices, triangles, n_triangles, place, 0xccb0bcc4u);
    if (outcome == DONE) outcome = stl_write(w->o.out, name, vertices, triangles, n_triangles);
    free(vertices);
    free(triangles);
    return outcome;
}

/* ------------------------------------------------------------------ muscles */
typedef struct muscle_cells {
    int64_t n_nodes, n_cells, n_fibres;
    double *q, *stiffness, *of_cell;
    int32_t *nodes, *cells, *signals, *category;
} muscle_cells;

static void muscle_cells_free(muscle_cells* m) {
    free(m->q);
    free(m->stiffness);
    free(m->of_cell);
    free(m->nodes);
    free(m->cells);
    free(m->signals);
    free(m->category);
}

static int read_muscles(const job* w, muscle_cells* m) {
    dqa_simulator_info info;
    const dqa_simulator* simulator = w->s.simulator;
    int outcome = say_status(dqa_simulator_get_info(simulator, &info, sizeof info), "read the simulator");
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_muscles(simulator, NULL, NULL, NULL, 0, NULL, 0, NULL, 0, &m->n_fibres),
                             "count the muscles");
    if (outcome != DONE) return outcome;
    m->n_nodes = info.n_nodes;
    m->n_cells = info.n_active_cells;
    m->q = malloc((size_t)m->n_nodes * 3 * sizeof *m->q);
    m->nodes = malloc((size_t)m->n_cells * 8 * sizeof *m->nodes);
    m->of_cell = calloc((size_t)m->n_cells, sizeof *m->of_cell);
    m->category = malloc((size_t)m->n_cells * sizeof *m->category);
    m->cells = malloc((size_t)(m->n_fibres + 1) * sizeof *m->cells);
    m->signals = malloc((size_t)(m->n_fibres + 1) * sizeof *m->signals);
    m->stiffness = malloc((size_t)(m->n_fibres + 1) * sizeof *m->stiffness);
    if (m->q == NULL || m->nodes == NULL || m->of_cell == NULL || m->category == NULL || m->cells == NULL ||
        m->signals == NULL || m->stiffness == NULL)
        return say_no_memory();
    outcome = say_status(dqa_simulator_get_state(simulator, m->q, 3 * m->n_nodes, NULL, 0), "read the nodes");
    if (outcome == DONE)
        outcome =
            say_status(dqa_simulator_mesh(simulator, m->nodes, 8 * m->n_cells, NULL, 0, NULL, 0), "read the cells");
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_muscles(simulator, m->cells, m->signals, NULL, m->n_fibres, NULL, 0,
                                                   m->stiffness, m->n_fibres, NULL),
                             "read the muscles");
    return outcome;
}

/* The cells that are muscle, with the category of most of their stiffness (-1: no muscle). */
static int choose_cells(const job* w, muscle_cells* m) {
    double most[16] = {0.0};
    for (int64_t c = 0; c < m->n_cells; ++c) m->category[c] = -1;
    for (int64_t k = 0; k < m->n_fibres; ++k) {
        dqa_signal_info signal;
        const int32_t c = m->cells[k];
        if (say_status(dqa_shape_space_signal(w->s.space, m->signals[k], &signal, sizeof signal), "read a signal") !=
            DONE)
            return FAILED;
        if (m->stiffness[k] > m->of_cell[c]) {
            m->of_cell[c] = m->stiffness[k];
            m->category[c] = signal.category;
        }
        most[signal.category] = fmax(most[signal.category], m->stiffness[k]);
    }
    for (int64_t c = 0; c < m->n_cells; ++c)
        if (m->category[c] >= 0 && m->of_cell[c] < MUSCLE_SHARE * most[m->category[c]]) m->category[c] = -1;
    return DONE;
}

static int draw_muscles(job* w, shape* of) {
    /* Corner = 4 ix + 2 iy + iz; every face counter-clockwise from outside. */
    static const int faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    muscle_cells m;
    double place[2];
    int outcome;
    memset(&m, 0, sizeof m);
    outcome = read_muscles(w, &m);
    if (outcome == DONE) outcome = choose_cells(w, &m);
    place_of(of->weights, place);
    for (int64_t c = 0; c < m.n_cells && outcome == DONE; ++c) {
        const int32_t* nodes = m.nodes + 8 * c;
        const double y = 0.5 * (m.q[3 * nodes[0] + 1] + m.q[3 * nodes[7] + 1]);
        const uint32_t colour = m.category[c] == 0 ? 0xd0483cu : y > 0.0 ? 0x2f9e62u : 0x3a68c4u;
        if (m.category[c] < 0) continue;
        ++of->muscle_cells;
        for (int f = 0; f < 6 && outcome == DONE; ++f) {
            double corners[4][3];
            for (int k = 0; k < 4; ++k) memcpy(corners[k], m.q + 3 * nodes[faces[f][k]], sizeof corners[k]);
            outcome = gallery_add_face(&w->muscles, (const double(*)[3])corners, place, colour);
        }
    }
    muscle_cells_free(&m);
    return outcome;
}

/* ------------------------------------------------------------------ the triangle */
static int make_shape(job* w, int k) {
    shape* out = &w->shapes[k];
    const double started = progress_clock();
    char name[64];
    dqa_simulator_info info;
    int outcome;
    progress_stage(&w->p, PROGRESS_SETUP);
    outcome = say_status(dqa_simulator_set_weights(w->s.simulator, out->weights, 3, progress_callback, &w->p),
                         "interpolate a shape");
    if (outcome == DONE) outcome = measure(w, out);
    (void)snprintf(name, sizeof name, "shape_%02d.stl", k + 1);
    if (outcome == DONE) outcome = draw_body(w, out, name);
    if (outcome == DONE) outcome = draw_muscles(w, out);
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_get_info(w->s.simulator, &info, sizeof info), "read the simulator");
    if (outcome != DONE) return outcome;
    out->volume = info.volume;
    out->body_cells = info.n_body_cells;
    out->seconds = progress_clock() - started;
    return interrupted() ? INTERRUPTED : DONE;
}

static void lay_out(job* w) {
    int k = 0;
    for (int first = SIDE; first >= 0; --first)
        for (int third = 0; third <= SIDE - first; ++third, ++k) {
            w->shapes[k].weights[0] = (double)first / SIDE;
            w->shapes[k].weights[1] = (double)(SIDE - first - third) / SIDE;
            w->shapes[k].weights[2] = (double)third / SIDE;
        }
}

/* ------------------------------------------------------------------ results */
static int write_history(const job* w) {
    output_file file;
    if (output_open(&file, w->o.out, "history.csv") != DONE) return FAILED;
    fputs("shape", file.stream);
    for (int b = 0; b < 3; ++b) fprintf(file.stream, ",weight_%d", b + 1);
    fputs(",volume,body_cells,parts,largest_part,overlap_with_base,muscle_cells,seconds\n", file.stream);
    for (int k = 0; k < N_SHAPES; ++k) {
        const shape* s = &w->shapes[k];
        fprintf(file.stream, "%d,%.17g,%.17g,%.17g,%.17g,%lld,%lld,%.17g,", k + 1, s->weights[0], s->weights[1],
                s->weights[2], s->volume, (long long)s->body_cells, (long long)s->parts, s->largest);
        if (s->overlap >= 0.0) fprintf(file.stream, "%.17g", s->overlap);
        fprintf(file.stream, ",%lld,%.3f\n", (long long)s->muscle_cells, s->seconds);
    }
    return output_commit(&file);
}

static int write_picture(job* w, int* drawn) {
    output_file file;
    int created = 0;
    char* data = output_path(w->o.out, PLOT_FOLDER);
    int outcome = data != NULL ? output_folder(data, &created) : FAILED;
    if (outcome == DONE) outcome = gallery_write(&w->bodies, data, "bodies.dat");
    if (outcome == DONE) outcome = gallery_write(&w->muscles, data, "muscles.dat");
    if (outcome == DONE) outcome = output_open(&file, w->o.out, SCRIPT);
    if (outcome == DONE) {
        FILE* f = file.stream;
        const double most = SPACING * SIDE + ROOM, high = ROWS * SPACING * SIDE + ROOM;
        plot_page(f, PICTURE, SCRIPT, 2400, 960);
        fprintf(f,
                "unset border; unset tics; unset grid; unset key; unset colorbox\n"
                "set view map\nset xrange [%.4g:%.4g]\nset yrange [%.4g:%.4g]\nset pm3d explicit corners2color c1\n"
                "set size ratio -1\nset tmargin at screen 1; set bmargin at screen 0\n",
                -ROOM, most, -ROOM, high);
        for (int side = 0; side < 2; ++side) {
            fprintf(f, "set lmargin at screen %g; set rmargin at screen %g\nunset label\n", 0.5 * side,
                    0.5 * side + 0.5);
            fprintf(f, "set label '%s' at %.4g,%.4g,0 left font ',20'\n", side == 0 ? "Shapes" : "Muscles", -0.9 * ROOM,
                    high - 0.2);
            for (int32_t b = 0; b < 3 && side == 0; ++b) {
                double weights[3] = {0.0, 0.0, 0.0}, place[2];
                weights[b] = 1.0;
                place_of(weights, place);
                fputs("set label ", f);
                plot_quoted(f, dqa_shape_space_base_name(w->s.space, b), 30);
                fprintf(f, " at %.4g,%.4g,0 center noenhanced font ',16' tc rgb '#404040'\n",
                        place[0] + (b == 0 ? 0.85 : 0.0), place[1] - (b == 0 ? 0.0 : 0.42));
            }
            fprintf(f, "splot '" PLOT_FOLDER "/%s.dat' using 1:2:(0):3 with pm3d lc rgb variable\n",
                    side == 0 ? "bodies" : "muscles");
        }
        fputs("unset multiplot\nset output\n", f);
        outcome = output_commit(&file);
    }
    if (outcome == DONE) outcome = plot_draw(w->o.out, PICTURE, SCRIPT, drawn);
    free(data);
    return outcome;
}

static int write_summary(const job* w, double least_overlap, int64_t most_parts) {
    output_file file;
    json j;
    dqa_shape_space_info info;
    int outcome = say_status(dqa_shape_space_get_info(w->s.space, &info, sizeof info), "read the shape space");
    if (outcome == DONE) outcome = output_open(&file, w->o.out, SUMMARY_FILE);
    if (outcome != DONE) return outcome;
    json_begin(&j, file.stream);
    summary_program(&j, form.program);
    json_boolean(&j, "all_shown", least_overlap >= LEAST_OVERLAP && most_parts == 1);
    json_open(&j, "claims", '{');
    json_open(&j, "bases_come_back", '{');
    json_boolean(&j, "shown", least_overlap >= LEAST_OVERLAP);
    json_number(&j, "value", least_overlap);
    json_number(&j, "at_least", LEAST_OVERLAP);
    json_close(&j, '}');
    json_open(&j, "one_part_each", '{');
    json_boolean(&j, "shown", most_parts == 1);
    json_integer(&j, "value", most_parts);
    json_integer(&j, "equals", 1);
    json_close(&j, '}');
    json_close(&j, '}');
    json_open(&j, "bases", '[');
    for (int32_t b = 0; b < 3; ++b) json_string(&j, NULL, dqa_shape_space_base_name(w->s.space, b));
    json_close(&j, ']');
    json_open(&j, "shapes", '[');
    for (int k = 0; k < N_SHAPES; ++k) {
        const shape* s = &w->shapes[k];
        json_open(&j, NULL, '{');
        summary_numbers(&j, "weights", s->weights, 3);
        json_number(&j, "volume", s->volume);
        json_integer(&j, "body_cells", s->body_cells);
        json_integer(&j, "parts", s->parts);
        json_number(&j, "largest_part", s->largest);
        if (s->overlap >= 0.0) json_number(&j, "overlap_with_base", s->overlap);
        json_integer(&j, "muscle_cells", s->muscle_cells);
        json_number(&j, "seconds", s->seconds);
        json_close(&j, '}');
    }
    json_close(&j, ']');
    json_number(&j, "cpu_seconds", progress_cpu());
    json_number(&j, "cell_size", info.cell_size);
    json_integer(&j, "signals", info.n_signals);
    summary_numbers(&j, "grid", (const double[3]){w->o.grid[0], w->o.grid[1], w->o.grid[2]}, 3);
    json_number(&j, "sigma", w->o.sigma);
    json_open(&j, "machine", '{');
    summary_machine(&j, &w->o);
    json_close(&j, '}');
    json_end(&j);
    return output_commit(&file);
}

static int work(job* w) {
    double least = HUGE_VAL;
    int64_t most = 0;
    int drawn = 0, outcome;
    progress_begin(&w->p, N_SHAPES, 0);
    w->p.seconds[PROGRESS_FORWARD] = w->p.seconds[PROGRESS_BACKWARD] = 0.0;
    lay_out(w);
    outcome = scene_create(&w->s, &w->o, &w->p);
    for (int k = 0; k < N_SHAPES && outcome == DONE; ++k) {
        outcome = make_shape(w, k);
        if (outcome != DONE) break;
        if (w->shapes[k].overlap >= 0.0) least = fmin(least, w->shapes[k].overlap);
        if (w->shapes[k].parts > most) most = w->shapes[k].parts;
        progress_shape(&w->p, k + 1, w->shapes[k].seconds);
    }
    progress_stage(&w->p, PROGRESS_OUTPUT);
    if (outcome == DONE) outcome = write_history(w);
    if (outcome == DONE) outcome = write_picture(w, &drawn);
    if (outcome == DONE) outcome = write_summary(w, least, most);
    progress_end(&w->p);
    if (outcome != DONE) return outcome;
    printf("%s: the bases come back (least overlap %.4f, at least %.2f)\n",
           least >= LEAST_OVERLAP ? "shown    " : "NOT SHOWN", least, LEAST_OVERLAP);
    printf("%s: every shape is in one part (most parts %lld)\n", most == 1 ? "shown    " : "NOT SHOWN",
           (long long)most);
    printf("Files:\n");
    if (drawn) printf("  %s/%s  (made by %s)\n", w->o.out, PICTURE, SCRIPT);
    printf("  %s/history.csv\n  %s/%s\n  %s/shape_01.stl ... shape_%02d.stl\n", w->o.out, w->o.out, SUMMARY_FILE,
           w->o.out, N_SHAPES);
    return fflush(stdout) == 0 && !ferror(stdout) ? DONE : FAILED;
}

int main(int argc, char** argv) {
    static job w;
    int action = OPTIONS_RUN, created = 0, outcome;
    say_program(form.program);
    outcome = options_parse(&w.o, &form, argc, argv, &action);
    if (outcome == DONE && action == OPTIONS_RUN) {
        /* Without muscles of the user's own, fins where the geometry has them. */
        if (w.o.list.n_actuators == 0) w.o.laws.automatic_fins = 1;
        outcome = output_folder(w.o.out, &created);
        if (outcome == DONE) output_remove(w.o.out, SUMMARY_FILE);
        if (outcome == DONE) outcome = work(&w);
        if (outcome == INTERRUPTED) say("interrupted; nothing is kept, as all of it takes a minute");
        scene_free(&w.s);
        gallery_free(&w.bodies);
        gallery_free(&w.muscles);
        if (created) (void)rmdir(w.o.out);
    }
    options_free(&w.o);
    return outcome;
}
