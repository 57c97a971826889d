/* SPDX-License-Identifier: MIT
 * Command lines: numbers are read strictly, and every refusal says what was expected. */
#define _POSIX_C_SOURCE 200809L
#include "options.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "machine.h"
#include "say.h"
#include "shapes.h"

/* Wider than the library's own kernel: thin fins that cross cells as the weights change then fade in and out instead of
 * flickering, and the loss has fewer spurious minima on the way from one animal to another. */
#define SIGMA 0.7
#define RATE 30 /* time steps per second, of the paper's public code */

static const char help[] =
    "usage: codesign [options] [mesh...]\n"
    "       codesign [options] --bases-file FILE\n"
    "\n"
    "Optimises the shape of a soft swimmer, interpolated between closed triangle meshes (STL, OBJ, PLY),\n"
    "together with the sine or the neural network that drives its muscles, for the distance it travels or\n"
    "another objective.\n"
    "Without meshes it takes those that come with it, on a coarser grid.\n"
    "\n"
    "  --bases-file FILE meshes and their muscles from a list instead of the command line; see below\n"
    "  --grid NXxNYxNZ   cells of the box, each 8 to 512 (60x16x26; shipped shapes 40x12x20; quick 28x10x14)\n"
    "  --iterations N    of the optimiser (40; shipped shapes 15; quick 5)\n"
    "  --steps N         time steps of 1/30 s per rollout (100; shipped shapes 60; quick 30)\n"
    "  --sigma S         width of the interpolation's kernel in cells, 0.2 to 16 (0.7; sharper 0.4)\n"
    "  --refinement N    mass moves between cells 1 to 4 times finer (1)\n"
    "  --schedule S      none; coarse: half the cells along each axis and loose tolerances first, which is\n"
    "                    0.5:1e-4,1:1e-6; or stages of your own, grid:tolerance or grid:tolerance:share,\n"
    "                    where share is that of the iterations (0.6 before the last). A stage also ends when\n"
    "                    its loss stalls (none)\n"
    "  --fixed-control   optimise the weights only; the sine stays at amplitude 1\n"
    "  --controller C    sine, or mlp: a network that sees head, centre and tail (sine)\n"
    "  --objective LIST  travel, keep (its place), efficiency, effort, path, or a sum with weights like\n"
    "                    travel:1,effort:0.01; what is made smallest (travel)\n"
    "  --path FILE       of the objective path: lines of time (s) and x, y, z (m) where the centre should be\n"
    "  --automatic-fins  meshes without muscles also get fins where their geometry has them\n"
    "  --interpolation I  of muscles between the meshes: linear, or bures, the optimal transport of Gaussians "
    "(linear)\n"
    "  --material M      corotated; volume: it also resists changes of volume; neo-hookean (corotated)\n"
    "  --quadrature Q    full: eight points a cell, as the paper; reduced: one, with hourglass control (reduced)\n"
    "  --integrator I    euler, or bdf2: second order in time (euler)\n"
    "  --planar          nothing moves up or down\n"
    "  --current X,Y,Z   velocity of the water in m/s (still water)\n"
    "  --current-file FILE  the same over time: lines of time (s) and x, y, z (m/s), straight between them\n"
    "  --threshold T     cells with more than this share of the density are simulated, 0 (all) to below 0.5 (0.02)\n"
    "  --model-error E   instead the largest threshold, for the whole run, whose estimated error of the movements\n"
    "                    of the initial design is at most E, 0 to 1\n"
    "  --checkpoint-mib N  memory for the record of a rollout; what does not fit is computed again (no limit)\n"
    "  --weights a,b,... initial share of each mesh; they sum to 1 (equal shares)\n"
    "  --out DIR         folder of the results (./codesign-out)\n"
    "  --quick           a coarse version, within a minute\n"
    "  --resume          continue an interrupted run in DIR; give the other options again\n"
    "  --threads N       results do not depend on it (number of processors, at most 16)\n"
    "  --help            this text\n"
    "\n"
    "A list of bases has one block per mesh; what follows a # is a comment:\n"
    "\n"
    "  base shark.stl\n"
    "    caudal mean -0.25 0 0.01 half 0.18 0.08 0.09\n"
    "    fins mean 0.03 0.13 -0.06 half 0.08 0.05 0.02 angles 10 0 0 layers 4\n"
    "\n"
    "Paths are relative to the list. An actuator is a box of muscle: its middle and the half lengths of its\n"
    "edges in metres (the longest mesh is 1 m long, its centre of mass the origin, x ahead, z up), optionally\n"
    "Euler angles in degrees about x, y, z, and a category (0 to 15; 0 for caudal and 1 for fins unless given):\n"
    "actuators of one category are interpolated between the meshes. Fins are described on the left and mirrored\n"
    "to the right, or each by itself with \"side left\" and \"side right\"; they have 1 to 4 layers (4) with 4\n"
    "signals each. A base without actuators gets them from its geometry. After \"lengths own\" (shipped lists)\n"
    "each animal counts as 1 m long.\n"
    "\n"
    "Exit codes: 0 done, 1 failure, 2 wrong command line, 130 interrupted (and resumable).\n";

/* Chosen so that the shipped shapes end within two minutes on two cores, --quick within one; meshes of the user's own
 * get the resolution and length of the paper's open-loop experiments. */
const options_form options_codesign = {.program = "codesign",
                                       .help = help,
                                       .out = "codesign-out",
                                       .quick = {{28, 10, 14}, 5, 30, 0, SIGMA},
                                       .shipped = {{40, 12, 20}, 15, 60, 0, SIGMA},
                                       .user = {{60, 16, 26}, 40, 100, 0, SIGMA}};

static int parse_count(const char* option, const char* text, int64_t least, int64_t most, int64_t* value) {
    char* end = NULL;
    long long number;
    errno = 0;
    number = strtoll(text, &end, 10);
    if (end == text || *end != '\0' || errno != 0 || number < least || number > most) {
        say("%s expects a whole number from %lld to %lld, not \"%s\"", option, (long long)least, (long long)most, text);
        return USAGE;
    }
    *value = (int64_t)number;
    return DONE;
}

static int parse_grid(const char* text, int32_t grid[3]) {
    const char* rest = text;
    for (int axis = 0; axis < 3; ++axis) {
        char* end = NULL;
        const long cells = (*rest >= '0' && *rest <= '9') ? strtol(rest, &end, 10) : 0;
        if (cells < 8 || cells > 512 || *end != (axis < 2 ? 'x' : '\0')) {
            say("--grid expects three numbers of cells from 8 to 512 like 60x16x26, not \"%s\"", text);
            return USAGE;
        }
        grid[axis] = (int32_t)cells;
        rest = end + 1;
    }
    return DONE;
}

static int parse_weights(const char* text, double* weights, int32_t* n) {
    const char* rest = text;
    double sum = 0.0;
    *n = 0;
    for (;;) {
        char* end = NULL;
        const double weight = strtod(rest, &end);
        if (end == rest || (*end != ',' && *end != '\0') || !isfinite(weight) || weight < 0.0) {
            say("--weights expects numbers >= 0 separated by commas, not \"%s\"", text);
            return USAGE;
        }
        if (*n == OPTIONS_MAX_BASES) {
            say("--weights takes at most %d numbers", OPTIONS_MAX_BASES);
            return USAGE;
        }
        weights[(*n)++] = weight;
        sum += weight;
        if (*end == '\0') break;
        rest = end + 1;
    }
    if (fabs(sum - 1.0) > 1e-6) {
        say("--weights must sum to 1; \"%s\" sums to %.9g", text, sum);
        return USAGE;
    }
    /* The library wants the sum to round-off; a user writes 0.333333,0.333333,0.333334. */
    for (int32_t i = 0; i < *n; ++i) weights[i] /= sum;
    return DONE;
}

static int add_mesh(options* o, const char* path) {
    if (o->n_meshes == OPTIONS_MAX_BASES) {
        say("at most %d meshes can be combined", OPTIONS_MAX_BASES);
        return USAGE;
    }
    o->meshes[o->n_meshes] = strdup(path);
    if (o->meshes[o->n_meshes] == NULL) return say_no_memory();
    ++o->n_meshes;
    return DONE;
}

/* What the command line said before defaults are filled in; 0 or NULL where it was silent. */
typedef struct given {
    const char *grid, *iterations, *steps, *weights, *threads, *sigma, *refinement, *controller, *objective, *path,
        *checkpoint_mib, *bases_file, *threshold, *model_error, *schedule, *generations, *rate;
    physics_words laws;
} given;

static const char** value_slot(given* g, options* o, const char* name, size_t length) {
    const struct {
        const char* name;
        const char** slot;
    } table[] = {{"--grid", &g->grid},
                 {"--iterations", &g->iterations},
                 {"--steps", &g->steps},
                 {"--weights", &g->weights},
                 {"--threads", &g->threads},
                 {"--out", &o->out},
                 {"--sigma", &g->sigma},
                 {"--refinement", &g->refinement},
                 {"--controller", &g->controller},
                 {"--objective", &g->objective},
                 {"--path", &g->path},
                 {"--checkpoint-mib", &g->checkpoint_mib},
                 {"--bases-file", &g->bases_file},
                 {"--threshold", &g->threshold},
                 {"--model-error", &g->model_error},
                 {"--schedule", &g->schedule},
                 {"--generations", &g->generations},
                 {"--rate", &g->rate},
                 {"--only", &o->only},
                 {"--interpolation", &g->laws.interpolation},
                 {"--material", &g->laws.material},
                 {"--quadrature", &g->laws.quadrature},
                 {"--integrator", &g->laws.integrator},
                 {"--current", &g->laws.current},
                 {"--current-file", &g->laws.current_file}};
    for (size_t i = 0; i < sizeof table / sizeof table[0]; ++i)
        if (strlen(table[i].name) == length && strncmp(table[i].name, name, length) == 0) return table[i].slot;
    return NULL;
}

static int unknown(const options* o, const char* word) {
    say("unknown option %s; see %s --help", word, o->form->program);
    return USAGE;
}

static int parse_words(options* o, given* g, int argc, char** argv, int* action) {
    int only_meshes = 0;
    for (int i = 1; i < argc; ++i) {
        const char* word = argv[i];
        const char* equals = strchr(word, '=');
        const char** slot;
        int outcome = DONE;
        if (only_meshes || strncmp(word, "-", 1) != 0) {
            outcome = add_mesh(o, word);
        } else if (strcmp(word, "--") == 0) {
            only_meshes = 1;
        } else if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0) {
            *action = OPTIONS_HELP;
            return options_print_help(o->form);
        } else if (!options_known(o->form, word)) {
            return unknown(o, word);
        } else if (strcmp(word, "--fixed-control") == 0) {
            o->fixed_control = 1;
        } else if (strcmp(word, "--quick") == 0) {
            o->quick = 1;
        } else if (strcmp(word, "--resume") == 0) {
            o->resume = 1;
        } else if (strcmp(word, "--automatic-fins") == 0) {
            g->laws.automatic_fins = 1;
        } else if (strcmp(word, "--planar") == 0) {
            g->laws.planar = 1;
        } else if ((slot = value_slot(g, o, word, equals != NULL ? (size_t)(equals - word) : strlen(word))) != NULL) {
            if (equals == NULL && i + 1 == argc) {
                say("%s expects a value; see %s --help", word, o->form->program);
                return USAGE;
            }
            *slot = equals != NULL ? equals + 1 : argv[++i];
            if (**slot == '\0') {
                say("%s expects a value; see %s --help", word, o->form->program);
                return USAGE;
            }
        } else {
            return unknown(o, word);
        }
        if (outcome != DONE) return outcome;
    }
    return DONE;
}

int32_t options_refinement(const options_form* form, int quick) {
    return form->refinement > 0 && !quick ? form->refinement : 1;
}

static int resolve_refinement(options* o, const given* g) {
    int64_t count = options_refinement(o->form, o->quick);
    const int outcome = g->refinement != NULL ? parse_count("--refinement", g->refinement, 1, 4, &count) : DONE;
    o->refinement = (int32_t)count;
    return outcome;
}

static int parse_sigma(const char* text, double* sigma) {
    char* end = NULL;
    const double value = strtod(text, &end);
    if (end == text || *end != '\0' || !(value >= 0.2 && value <= 16.0)) {
        say("--sigma expects a number from 0.2 to 16, not \"%s\"", text);
        return USAGE;
    }
    *sigma = value;
    return DONE;
}

/* What decides which cells are simulated. */
static int resolve_cells(options* o, const given* g) {
    char* end = NULL;
    o->threshold = -1.0;
    if (g->threshold != NULL && g->model_error != NULL) {
        say("give either --threshold or --model-error, not both");
        return USAGE;
    }
    if (g->threshold != NULL) {
        o->threshold = strtod(g->threshold, &end);
        if (*end != '\0' || !(o->threshold >= 0.0 && o->threshold < 0.5)) {
            say("--threshold expects a number from 0 to below 0.5, not \"%s\"", g->threshold);
            return USAGE;
        }
    }
    if (g->model_error != NULL) {
        o->model_error = strtod(g->model_error, &end);
        if (*end != '\0' || !(o->model_error > 0.0 && o->model_error < 1.0)) {
            say("--model-error expects a number above 0 and below 1, not \"%s\"", g->model_error);
            return USAGE;
        }
    }
    return DONE;
}

static int resolve_task(options* o, const given* g) {
    const char* loss = g->objective;
    int64_t rate = RATE;
    int outcome = DONE;
    if (g->controller != NULL && strcmp(g->controller, "mlp") != 0 && strcmp(g->controller, "sine") != 0) {
        say("--controller expects sine or mlp, not \"%s\"", g->controller);
        return USAGE;
    }
    o->mlp = o->form->mlp || (g->controller != NULL && strcmp(g->controller, "mlp") == 0);
    if (o->mlp && o->fixed_control) {
        say("--fixed-control is for the sine; a network that does not learn drives nothing");
        return USAGE;
    }
    if (g->checkpoint_mib != NULL)
        outcome = parse_count("--checkpoint-mib", g->checkpoint_mib, 1, 1000000, &o->checkpoint_mib);
    if (outcome == DONE && g->rate != NULL) outcome = parse_count("--rate", g->rate, 1, 100000, &rate);
    o->rate = (int32_t)rate;
    if (loss == NULL) loss = o->form->objective != NULL ? o->form->objective : "travel";
    if (outcome == DONE) outcome = objective_parse(&o->loss, loss, g->path);
    if (outcome == DONE) outcome = physics_parse(&o->laws, &g->laws);
    if (outcome == DONE) outcome = schedule_parse(&o->plan, g->schedule);
    return outcome;
}

static int resolve_threads(options* o, const given* g) {
    int64_t threads = 0;
    int outcome = DONE;
    if (g->threads != NULL) {
        outcome = parse_count("--threads", g->threads, 1, 1024, &threads);
    } else {
        threads = machine_processors();
        if (threads > 16) threads = 16;
    }
    o->threads = (int32_t)threads;
    return outcome;
}

static int add_listed_mesh(void* context, const char* mesh) {
    return add_mesh(context, mesh);
}

static int read_list(options* o, const given* g) {
    if (g->bases_file == NULL) return DONE;
    if (o->n_meshes > 0) {
        say("give either --bases-file or meshes, not both");
        return USAGE;
    }
    o->bases_file = g->bases_file;
    return bases_read(&o->list, g->bases_file, add_listed_mesh, o);
}

static int add_shipped(options* o, char* path) {
    const int outcome = path != NULL ? add_mesh(o, path) : FAILED;
    free(path);
    return outcome;
}

/* A shipped mesh, with the muscles of the list of its name where there is one. */
static int add_shape(options* o, const char* name) {
    char list[64];
    char* path;
    int outcome;
    (void)snprintf(list, sizeof list, "%.*s.txt", (int)strcspn(name, "."), name);
    if (!o->form->lists || !shapes_has(list)) {
        ++o->list.n_bases;
        return add_shipped(o, shapes_named(name));
    }
    path = shapes_named(list);
    outcome = path != NULL ? bases_read(&o->list, path, add_listed_mesh, o) : FAILED;
    free(path);
    o->bases_file = "the list that comes with the shape";
    return outcome;
}

static int resolve_meshes(options* o, const given* g) {
    const char* const* shapes = o->form->shapes;
    int32_t n_weights = 0, n_shapes = shapes_count();
    int outcome = DONE;
    if (shapes != NULL)
        for (n_shapes = 0; shapes[n_shapes] != NULL;) ++n_shapes;
    if (o->n_meshes == 0) {
        o->shipped = 1;
        for (int32_t i = 0; i < n_shapes && outcome == DONE; ++i)
            outcome = shapes != NULL ? add_shape(o, shapes[i]) : add_shipped(o, shapes_path(i));
        if (outcome != DONE) return outcome;
    }
    if (shapes != NULL && o->n_meshes != n_shapes) {
        say("%s wants %d meshes, not %d; see %s --help", o->form->program, (int)n_shapes, (int)o->n_meshes,
            o->form->program);
        return USAGE;
    }
    if (g->weights == NULL) {
        for (int32_t i = 0; i < o->n_meshes; ++i) o->weights[i] = 1.0 / (double)o->n_meshes;
        return DONE;
    }
    outcome = parse_weights(g->weights, o->weights, &n_weights);
    if (outcome == DONE && n_weights != o->n_meshes) {
        say("--weights names %d weights for %d %s", (int)n_weights, (int)o->n_meshes,
            o->n_meshes == 1 ? "mesh" : "meshes");
        outcome = USAGE;
    }
    return outcome;
}

int options_parse(options* o, const options_form* form, int argc, char** argv, int* action) {
    given g;
    const options_preset* p;
    int outcome;
    memset(o, 0, sizeof *o);
    memset(&g, 0, sizeof g);
    o->form = form;
    o->out = form->out;
    o->fixed_control = form->fixed_control;
    *action = OPTIONS_RUN;
    outcome = parse_words(o, &g, argc, argv, action);
    if (outcome != DONE || *action == OPTIONS_HELP) return outcome;
    outcome = read_list(o, &g);
    if (outcome != DONE) return outcome;
    p = o->quick ? &form->quick : o->n_meshes == 0 ? &form->shipped : &form->user;
    memcpy(o->grid, p->grid, sizeof o->grid);
    o->iterations = p->iterations;
    o->steps = p->steps;
    o->generations = p->generations;
    if (g.grid != NULL) outcome = parse_grid(g.grid, o->grid);
    if (outcome == DONE && g.iterations != NULL)
        outcome = parse_count("--iterations", g.iterations, 1, 1000000, &o->iterations);
    if (outcome == DONE && g.steps != NULL) outcome = parse_count("--steps", g.steps, 1, 1000000, &o->steps);
    if (outcome == DONE && g.generations != NULL)
        outcome = parse_count("--generations", g.generations, 1, 1000000, &o->generations);
    o->sigma = p->sigma;
    if (outcome == DONE && g.sigma != NULL) outcome = parse_sigma(g.sigma, &o->sigma);
    if (outcome == DONE) outcome = resolve_refinement(o, &g);
    if (outcome == DONE) outcome = resolve_cells(o, &g);
    if (outcome == DONE) outcome = resolve_task(o, &g);
    if (outcome == DONE) outcome = resolve_threads(o, &g);
    if (outcome == DONE) outcome = resolve_meshes(o, &g);
    return outcome;
}

void options_free(options* o) {
    for (int32_t i = 0; i < o->n_meshes; ++i) free(o->meshes[i]);
    o->n_meshes = 0;
    objective_free(&o->loss);
    physics_free(&o->laws);
    bases_free(&o->list);
}

/* A word as a shell reads it back: in single quotes when it has anything but plain characters. */
static size_t quote(char* to, const char* word) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./=,:+-";
    char* start = to;
    if (*word != '\0' && word[strspn(word, plain)] == '\0') {
        const size_t length = strlen(word);
        memcpy(to, word, length);
        return length;
    }
    *to++ = '\'';
    for (; *word != '\0'; ++word) {
        if (*word == '\'') {
            memcpy(to, "'\\'", 3);
            to += 3;
        }
        *to++ = *word;
    }
    *to++ = '\'';
    return (size_t)(to - start);
}

static size_t quoted_size(int argc, char** argv) {
    size_t size = 1;
    for (int i = 0; i < argc; ++i) size += 4 * strlen(argv[i]) + 3;
    return size;
}

char* options_command(int argc, char** argv) {
    char* line = malloc(quoted_size(argc, argv));
    char* to = line;
    if (line == NULL) {
        (void)say_no_memory();
        return NULL;
    }
    for (int i = 0; i < argc; ++i) {
        const char* slash = i == 0 ? strrchr(argv[i], '/') : NULL;
        if (i > 0) *to++ = ' ';
        to += quote(to, slash != NULL ? slash + 1 : argv[i]);
    }
    *to = '\0';
    return line;
}

void options_say_resume(int argc, char** argv) {
    char *line, *to;
    int has_resume = 0;
    line = malloc(quoted_size(argc, argv) + sizeof " --resume");
    if (line == NULL) return;
    to = line;
    for (int i = 0; i < argc; ++i) {
        if (i > 0) *to++ = ' ';
        to += quote(to, argv[i]);
        /* Before the meshes, because an argument after "--" would be taken for one. */
        if (strcmp(argv[i], "--resume") == 0) has_resume = 1;
        if (i == 0) {
            static const char word[] = " --resume";
            memcpy(to, word, sizeof word - 1);
            to += sizeof word - 1;
        }
    }
    *to = '\0';
    if (has_resume) {
        /* It was given already: drop the one just added. */
        char* extra = strstr(line, " --resume");
        memmove(extra, extra + 9, strlen(extra + 9) + 1);
    }
    say("continue with:  %s", line);
    free(line);
}
