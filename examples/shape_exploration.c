/* SPDX-License-Identifier: MIT
 *
 * shape_exploration — the shape space of section 8.1 of Ma et al., "DiffAqua", 2021: three bases at the corners of a
 * triangle, twelve shapes between them, and the muscles of all of them, as one picture.
 * `shape_exploration --help` lists the options.
 */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "support/checkpoint.h"
#include "support/exhibit.h"
#include "support/findings.h"
#include "support/gallery.h"
#include "support/interrupt.h"
#include "support/options.h"
#include "support/output.h"
#include "support/plot.h"
#include "support/progress.h"
#include "support/say.h"
#include "support/scene.h"
#include "support/sealed_text.h"
#include "support/summary.h"

#define SIDE 4                                 /* steps along a side of the triangle */
#define N_SHAPES ((SIDE + 1) * (SIDE + 2) / 2) /* the bases and 12 between them */
#define PICTURE "shape_exploration.png"
#define SCRIPT "shape_exploration.gp"
#define SPACING 0.86 /* between neighbours on the page, in lengths of the longest base */
#define ROWS 0.68    /* between rows, relative to that */
#define ROOM 0.5     /* around the triangle, in lengths */
#define LEAST_OVERLAP 0.97
/* The widest that gives back fins one cell thick (0.38 does not). On the cells themselves so narrow a kernel makes
 * combs, whose teeth are parts of their own where the body is thin; on cells half as large it spans 0.74 of them, and
 * ripples by 4e-5. */
#define SIGMA 0.37
#define MAGIC "shape_exploration checkpoint 3\n"

static const char about[] =
    "usage: shape_exploration [options] [mesh mesh mesh]\n"
    "       shape_exploration [options] --bases-file FILE\n"
    "\n"
    "Interpolates between three meshes (clownfish, manta ray and stingray unless others are named) and draws the\n"
    "triangle of the twelve shapes between them, with their muscles.\n";

static const char* const words[] = {"--bases-file", "--refinement", NULL};
static const char* const shapes[] = {"clownfish.stl", "manta_ray.stl", "stingray.stl", NULL};

static const options_form form = {.program = "shape_exploration",
                                  .about = about,
                                  .out = "shape_exploration-out",
                                  .words = words,
                                  .shapes = shapes,
                                  .quick = {{30, 27, 8}, 1, 1, 0, 0.4},
                                  .shipped = {{60, 54, 14}, 1, 1, 0, SIGMA},
                                  .user = {{60, 54, 14}, 1, 1, 0, SIGMA},
                                  .refinement = 2,
                                  .lists = 1};

typedef struct job {
    options o;
    scene s;
    progress p;
    char* settings; /* that the checkpoint belongs to */
    exhibit shapes[N_SHAPES];
    int finished; /* of them */
} job;

/* ------------------------------------------------------------------ checkpoint */
/* The finished shapes, behind the settings they belong to. */
static int save_checkpoint(const job* w) {
    memory_text t;
    memory_text_begin(&t);
    memory_text_add(&t, "%s%s%s", MAGIC, w->settings, CHECKPOINT_SETTINGS_END);
    for (int k = 0; k < w->finished; ++k) {
        const exhibit* s = &w->shapes[k];
        memory_text_add(&t, "shape %a %a %a %a %a", s->volume, s->largest, s->largest_simulated, s->overlap,
                        s->seconds);
        memory_text_add(&t, " %" PRId64 " %" PRId64 " %" PRId64 " %" PRId64 " %" PRId64 "\n", s->body_cells, s->parts,
                        s->simulated_cells, s->parts_simulated, s->muscle_cells);
    }
    return sealed_text_write(&t, w->o.out, CHECKPOINT_FILE);
}

static int read_shapes(job* w, const char* at) {
    for (w->finished = 0; w->finished < N_SHAPES && strncmp(at, "shape ", 6) == 0; ++w->finished) {
        exhibit* s = &w->shapes[w->finished];
        double numbers[10];
        at += 6;
        for (int i = 0; i < 10; ++i) {
            char* end = NULL;
            numbers[i] = strtod(at, &end);
            /* Sizes, shares and counts that a double holds; the overlap is -1 where there is none. */
            if (end == at || !(numbers[i] >= (i == 3 ? -1.0 : 0.0) && numbers[i] <= 9007199254740992.0)) return FAILED;
            at = end;
        }
        s->volume = numbers[0], s->largest = numbers[1], s->largest_simulated = numbers[2];
        s->overlap = numbers[3], s->seconds = numbers[4];
        s->body_cells = (int64_t)numbers[5], s->parts = (int64_t)numbers[6];
        s->simulated_cells = (int64_t)numbers[7], s->parts_simulated = (int64_t)numbers[8];
        s->muscle_cells = (int64_t)numbers[9];
        at += strspn(at, "\n");
    }
    return *at == '\0' ? DONE : FAILED;
}

static int load_checkpoint(job* w) {
    char* text = sealed_text_read(w->o.out, CHECKPOINT_FILE, MAGIC);
    char* end = text != NULL ? strstr(text, CHECKPOINT_SETTINGS_END) : NULL;
    int outcome = FAILED;
    if (end != NULL) {
        *end = '\0';
        outcome = checkpoint_compare(text + strlen(MAGIC), w->settings);
    }
    if (outcome == DONE) outcome = read_shapes(w, end + strlen(CHECKPOINT_SETTINGS_END));
    if (outcome == FAILED && text != NULL)
        say("the checkpoint in %s does not hold what it should; start without --resume", w->o.out);
    free(text);
    if (outcome == DONE) say("continuing after shape %d", w->finished);
    return outcome;
}

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

/* ------------------------------------------------------------------ the triangle */
static int write_polygons(const job* w, int k, gallery* bodies, gallery* muscles) {
    char name[64];
    char* data = output_path(w->o.out, PLOT_FOLDER);
    int created = 0, outcome = data != NULL ? output_folder(data, &created) : FAILED;
    (void)snprintf(name, sizeof name, "body_%02d.dat", k + 1);
    if (outcome == DONE) outcome = gallery_write(bodies, data, name);
    (void)snprintf(name, sizeof name, "muscles_%02d.dat", k + 1);
    if (outcome == DONE) outcome = gallery_write(muscles, data, name);
    free(data);
    return outcome;
}

static int make_shape(job* w, int k) {
    exhibit* shape = &w->shapes[k];
    const double started = progress_clock();
    gallery bodies = {0}, muscles = {0};
    char stl[64];
    double place[2];
    int outcome;
    place_of(shape->weights, place);
    (void)snprintf(stl, sizeof stl, "shape_%02d.stl", k + 1);
    progress_stage(&w->p, PROGRESS_SETUP);
    outcome = say_status(dqa_simulator_set_weights(w->s.simulator, shape->weights, 3, progress_callback, &w->p),
                         "interpolate a shape");
    if (outcome == DONE) outcome = exhibit_measure(shape, &w->s, w->o.grid);
    if (outcome == DONE)
        outcome = exhibit_draw_body(&w->s, place, colour_of(shape->weights), &bodies, &muscles, w->o.out, stl);
    if (outcome == DONE) outcome = exhibit_draw_muscles(shape, &w->s, place, &muscles);
    if (outcome == DONE) outcome = write_polygons(w, k, &bodies, &muscles);
    gallery_free(&bodies);
    gallery_free(&muscles);
    if (outcome != DONE) return outcome;
    shape->seconds = progress_clock() - started;
    w->finished = k + 1;
    outcome = save_checkpoint(w);
    progress_shape(&w->p, k + 1, shape->seconds);
    return outcome == DONE && interrupted() ? INTERRUPTED : outcome;
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
    fputs(
        ",volume,body_cells,parts,largest_part,simulated_cells,parts_simulated,largest_part_simulated,overlap_with_"
        "base,muscle_cells,seconds\n",
        file.stream);
    for (int k = 0; k < N_SHAPES; ++k) {
        const exhibit* s = &w->shapes[k];
        fprintf(file.stream, "%d,%.17g,%.17g,%.17g,%.17g,%lld,%lld,%.17g,%lld,%lld,%.17g,", k + 1, s->weights[0],
                s->weights[1], s->weights[2], s->volume, (long long)s->body_cells, (long long)s->parts, s->largest,
                (long long)s->simulated_cells, (long long)s->parts_simulated, s->largest_simulated);
        if (s->overlap >= 0.0) fprintf(file.stream, "%.17g", s->overlap);
        fprintf(file.stream, ",%lld,%.3f\n", (long long)s->muscle_cells, s->seconds);
    }
    return output_commit(&file);
}

static int write_picture(job* w, int* drawn) {
    output_file file;
    int outcome = output_open(&file, w->o.out, SCRIPT);
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
            for (int k = 0; k < N_SHAPES; ++k)
                fprintf(f, "%s'" PLOT_FOLDER "/%s_%02d.dat' using 1:2:(0):3 with pm3d lc rgb variable",
                        k == 0 ? "splot " : ", \\\n      ", side == 0 ? "body" : "muscles", k + 1);
            fputc('\n', f);
        }
        fputs("unset multiplot\nset output\n", f);
        outcome = output_commit(&file);
    }
    return outcome == DONE ? plot_draw(w->o.out, PICTURE, SCRIPT, drawn) : outcome;
}

#define N_FINDINGS 3

/* What all shapes together show. */
static void find(const job* w, finding* found) {
    double overlap = HUGE_VAL, parts = 0.0, simulated = 0.0;
    for (int k = 0; k < w->finished; ++k) {
        const exhibit* s = &w->shapes[k];
        if (s->overlap >= 0.0) overlap = fmin(overlap, s->overlap);
        parts = fmax(parts, (double)s->parts);
        simulated = fmax(simulated, (double)s->parts_simulated);
    }
    found[0] = (finding){"bases_come_back", "the bases come back: their least overlap", overlap, LEAST_OVERLAP,
                         FINDING_AT_LEAST};
    found[1] = (finding){"one_part_each", "the solid of every shape is in one part: the most parts", parts, 1.0,
                         FINDING_EQUALS};
    found[2] = (finding){"one_part_each_simulated", "what is simulated of every shape is in one part: the most parts",
                         simulated, 1.0, FINDING_EQUALS};
}

static int write_summary(const job* w, const finding* found) {
    output_file file;
    json j;
    dqa_shape_space_info info;
    int outcome = say_status(dqa_shape_space_get_info(w->s.space, &info, sizeof info), "read the shape space");
    if (outcome == DONE) outcome = output_open(&file, w->o.out, SUMMARY_FILE);
    if (outcome != DONE) return outcome;
    json_begin(&j, file.stream);
    summary_program(&j, form.program);
    json_boolean(&j, "all_shown", findings_hold(found, N_FINDINGS));
    findings_write(&j, found, N_FINDINGS);
    json_open(&j, "bases", '[');
    for (int32_t b = 0; b < 3; ++b) json_string(&j, NULL, dqa_shape_space_base_name(w->s.space, b));
    json_close(&j, ']');
    json_open(&j, "shapes", '[');
    for (int k = 0; k < N_SHAPES; ++k) {
        const exhibit* s = &w->shapes[k];
        json_open(&j, NULL, '{');
        summary_numbers(&j, "weights", s->weights, 3);
        json_number(&j, "volume", s->volume);
        json_integer(&j, "body_cells", s->body_cells);
        json_integer(&j, "parts", s->parts);
        json_number(&j, "largest_part", s->largest);
        json_integer(&j, "simulated_cells", s->simulated_cells);
        json_integer(&j, "parts_simulated", s->parts_simulated);
        json_number(&j, "largest_part_simulated", s->largest_simulated);
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
    json_integer(&j, "refinement", w->o.refinement);
    json_open(&j, "machine", '{');
    summary_machine(&j, &w->o);
    json_close(&j, '}');
    json_end(&j);
    return output_commit(&file);
}

static int work(job* w) {
    finding found[N_FINDINGS];
    int drawn = 0, outcome;
    progress_begin(&w->p, N_SHAPES, 0);
    w->p.seconds[PROGRESS_FORWARD] = w->p.seconds[PROGRESS_BACKWARD] = 0.0;
    outcome = scene_create(&w->s, &w->o, &w->p);
    for (int k = w->finished; k < N_SHAPES && outcome == DONE; ++k) outcome = make_shape(w, k);
    find(w, found);
    progress_stage(&w->p, PROGRESS_OUTPUT);
    if (outcome == DONE) outcome = write_history(w);
    if (outcome == DONE) outcome = write_picture(w, &drawn);
    if (outcome == DONE) outcome = write_summary(w, found);
    progress_end(&w->p);
    if (outcome != DONE) return outcome;
    findings_print(found, N_FINDINGS);
    printf("Files:\n");
    if (drawn) printf("  %s/%s  (made by %s)\n", w->o.out, PICTURE, SCRIPT);
    printf("  %s/history.csv\n  %s/%s\n  %s/shape_01.stl ... shape_%02d.stl\n", w->o.out, w->o.out, SUMMARY_FILE,
           w->o.out, N_SHAPES);
    return fflush(stdout) == 0 && !ferror(stdout) ? DONE : FAILED;
}

static int prepare(job* w, int* created) {
    int outcome;
    /* Without muscles of the user's own, fins where the geometry has them. */
    if (w->o.list.n_actuators == 0) w->o.laws.automatic_fins = 1;
    w->settings = checkpoint_settings(&w->o);
    if (w->settings == NULL) return FAILED;
    lay_out(w);
    if (w->o.resume && !checkpoint_exists(w->o.out)) {
        say("there is no checkpoint in %s to resume from; start without --resume", w->o.out);
        return USAGE;
    }
    outcome = w->o.resume ? load_checkpoint(w) : output_folder(w->o.out, created);
    if (outcome == DONE) output_remove(w->o.out, SUMMARY_FILE);
    return outcome == DONE && !w->o.resume ? save_checkpoint(w) : outcome;
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
            say("interrupted after shape %d of %d", w.finished, N_SHAPES);
            options_say_resume(argc, argv);
        }
        scene_free(&w.s);
        if (created) (void)rmdir(w.o.out);
    }
    free(w.settings);
    options_free(&w.o);
    return outcome;
}
