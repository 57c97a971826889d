/* SPDX-License-Identifier: MIT
 *
 * plane — co-design in two dimensions, in seconds.
 *
 *   plane [FILE]     writes its picture to FILE (default plane.svg)
 *
 * Three fish seen from above, each drawn by a short formula, span a space of outlines. A sine bends the swimmer's tail.
 * Adam moves the shares of the three and the sine's amplitude, frequency and phase together, for the distance travelled
 * in two seconds; before that, finite differences prove the gradient that it follows. Descent finds the nearest
 * optimum, a fish between the three, not the best of all: the eel alone would go further. The picture is an SVG written
 * without any library: the loss, the shares, and the first and the best swimmer on their way. Only diffaqua.h, the C
 * library and POSIX's stat are used. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "diffaqua.h"

#define PI 3.14159265358979323846
#define TIME_STEP (1.0 / 30.0)         /* s */
#define OMEGA (PI / (6.0 * TIME_STEP)) /* rad/s: a period of twelve steps */
/* Pa: softer than the library's defaults, because a slab that is as deep as it is wide hardly bends sideways */
#define YOUNG_MODULUS 5e5
#define MUSCLE_STIFFNESS 1e6
#define RATE 0.05 /* of Adam; frequencies move in units of OMEGA */

enum { N_BASES = 3, N_CONTROL = 3, N = N_BASES + N_CONTROL, STEPS = 60, ITERATIONS = 30, PROOF_STEPS = 5 };
enum { OUTLINE = 120 };                                  /* corners of one side of a base */
enum { FRAMES = 5, FRAME_STEPS = STEPS / (FRAMES - 1) }; /* instants drawn */

/* The contour of a swimmer at FRAMES instants, and the path of its centre over all steps. */
typedef struct motion {
    int64_t n_vertices;
    double* frames; /* [FRAMES][n_vertices][2] */
    int32_t* next;  /* [n_vertices]: the contour goes on there */
    double path[STEPS + 1][2];
} motion;

typedef struct row {
    double loss; /* minus the distance travelled, m */
    double x[N]; /* shares of the bases, then amplitude, frequency and phase */
} row;

typedef struct plane {
    dqa_shape_space* space;
    dqa_simulator* simulator;
    dqa_controller* sine;
    dqa_tape* tape;
    dqa_objective_term travel;
    dqa_gradient_check_report proof[2]; /* of the weights, of the control */
    row rows[ITERATIONS];
    int best;
    motion first_motion, best_motion;
} plane;

static int failed(dqa_status status, const char* doing) {
    if (status == DQA_SUCCESS) return 0;
    fprintf(stderr, "plane: cannot %s: %s (%s)\n", doing, dqa_last_error(), dqa_status_name(status));
    return 1;
}

/* ------------------------------------------------------------------ the fish */
/* Half width at s in [0, 1] from the nose to the tip of the tail, for a body one unit long: a trunk that thins out to a
 * peduncle, and a tail fin behind it. */
typedef struct outline {
    const char* name;
    double trunk; /* largest half width */
    double nose;  /* exponent of the nose: small is blunt */
    double rear;  /* exponent of the taper */
    double fin;   /* half width of the tail fin */
    double start; /* where the fin begins */
} outline;

static const outline fish[N_BASES] = {
    {"trout", 0.075, 0.55, 1.6, 0.035, 0.72},
    {"eel", 0.036, 0.30, 0.30, 0.024, 0.85},
    {"disc", 0.150, 0.50, 1.3, 0.045, 0.70},
};

static double half_width(const outline* f, double s) {
    const double top = f->nose / (f->nose + f->rear); /* where the trunk is widest */
    const double trunk = s < 0.93 ? f->trunk * pow(s / top, f->nose) * pow((1.0 - s) / (1.0 - top), f->rear) : 0.0;
    const double t = (s - f->start) / (1.0 - f->start);
    const double fin = t > 0.0 ? f->fin * t * (2.0 - t) : 0.0;
    const double peduncle = s > 0.02 ? 0.018 : 0.0;
    return fmax(fmax(trunk, fin), peduncle);
}

static int add_fish(dqa_shape_space* space, const outline* f) {
    double corners[2 * OUTLINE][2];
    for (int i = 0; i < OUTLINE; ++i) {
        const double s = (i + 0.5) / OUTLINE, w = half_width(f, s);
        corners[i][0] = corners[2 * OUTLINE - 1 - i][0] = 0.5 - s;
        corners[i][1] = w;
        corners[2 * OUTLINE - 1 - i][1] = -w;
    }
    return failed(dqa_shape_space_add_polygon(space, f->name, &corners[0][0], 2 * OUTLINE, NULL), "add a fish");
}

static int make_space(plane* p) {
    dqa_shape_space_options options;
    if (failed(dqa_shape_space_options_init(&options, sizeof options), "set up the space")) return 1;
    options.dims = 2;
    options.cells_x = 48;
    options.cells_y = 18;
    options.sigma = 0.7; /* a soft kernel: thin fins fade instead of flickering while the shares move */
    if (failed(dqa_shape_space_create(&options, &p->space), "create the space")) return 1;
    for (int i = 0; i < N_BASES; ++i)
        if (add_fish(p->space, &fish[i])) return 1;
    return failed(dqa_shape_space_build(p->space, NULL, NULL), "build the space");
}

static int make_scene(plane* p) {
    dqa_simulator_options options;
    dqa_simulator_info info;
    if (make_space(p) || failed(dqa_simulator_options_init(&options, sizeof options), "set up the simulator")) return 1;
    options.time_step = TIME_STEP;
    options.young_modulus = YOUNG_MODULUS;
    options.muscle_stiffness = MUSCLE_STIFFNESS;
    if (failed(dqa_simulator_create(p->space, &options, &p->simulator), "create the simulator") ||
        failed(dqa_simulator_get_info(p->simulator, &info, sizeof info), "read the simulator") ||
        failed(dqa_controller_create_sinusoid(info.n_signals, TIME_STEP, &p->sine), "create the sine") ||
        failed(dqa_tape_create(p->simulator, NULL, &p->tape), "create the tape") ||
        failed(dqa_objective_term_init(&p->travel, sizeof p->travel), "set up the objective"))
        return 1;
    if (info.n_signals != 1) {
        fprintf(stderr, "plane: expected one signal, that of the tail, not %d\n", (int)info.n_signals);
        return 1;
    }
    p->travel.kind = DQA_OBJECTIVE_TRAVEL;
    return 0;
}

/* ------------------------------------------------------------------ loss and gradient */
static int set_design(plane* p, const double* x) {
    return failed(dqa_simulator_set_weights(p->simulator, x, N_BASES, NULL, NULL), "set the design") ||
           failed(dqa_controller_set_parameters(p->sine, x + N_BASES, N_CONTROL), "set the sine");
}

static int swim(plane* p, const double* x) {
    return set_design(p, x) || failed(dqa_tape_clear(p->tape), "clear the tape") ||
           failed(dqa_simulator_rollout(p->simulator, p->sine, STEPS, p->tape, NULL, NULL), "swim");
}

static int evaluate(plane* p, const double* x, double* loss, double* gradient) {
    dqa_adjoint* adjoint = NULL;
    const int bad =
        swim(p, x) || failed(dqa_tape_objective(p->tape, &p->travel, 1, loss, NULL), "evaluate the loss") ||
        failed(dqa_adjoint_create(p->tape, &adjoint), "create the adjoint") ||
        failed(dqa_adjoint_seed_objective(adjoint, &p->travel, 1), "seed the adjoint") ||
        failed(dqa_adjoint_backward(adjoint, 0, NULL, NULL), "sweep back") ||
        failed(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, gradient, N_BASES), "read the gradient of the weights") ||
        failed(dqa_adjoint_get(adjoint, DQA_WRT_CONTROL, gradient + N_BASES, N_CONTROL),
               "read the gradient of the control");
    dqa_adjoint_free(adjoint);
    return bad;
}

static int prove(plane* p, const double* x) {
    static const int32_t of[2] = {DQA_WRT_WEIGHTS, DQA_WRT_CONTROL};
    static const char* const names[2] = {"weights", "control"};
    dqa_gradient_check_options options;
    if (set_design(p, x) || failed(dqa_gradient_check_options_init(&options, sizeof options), "set up the proof"))
        return 1;
    options.n_steps = PROOF_STEPS;
    for (int k = 0; k < 2; ++k) {
        dqa_gradient_check_report* report = &p->proof[k];
        options.with_respect_to = of[k];
        if (failed(dqa_check_gradient(p->simulator, p->sine, &p->travel, 1, &options, report, sizeof *report),
                   "prove the gradient"))
            return 1;
        printf("gradient of the %s: adjoint %.9e, finite difference %.9e, relative error %.1e\n", names[k],
               report->adjoint, report->finite_difference, report->relative_error);
        if (!(report->relative_error <= 1e-6)) {
            fprintf(stderr, "plane: the gradient of the %s is not proven\n", names[k]);
            return 1;
        }
    }
    return 0;
}

static double clamp(double value, double least, double most) {
    return fmin(fmax(value, least), most);
}

static int optimise(plane* p) {
    const double rates[N] = {RATE, RATE, RATE, RATE, RATE * OMEGA, RATE};
    double x[N] = {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.5, OMEGA, 0.0};
    double gradient[N], first[N] = {0.0}, second[N] = {0.0};
    if (prove(p, x)) return 1;
    printf("iteration   travel    %-8s%-8s%-8samplitude  omega   phase\n", fish[0].name, fish[1].name, fish[2].name);
    for (int k = 0; k < ITERATIONS; ++k) {
        row* now = &p->rows[k];
        memcpy(now->x, x, sizeof x);
        if (evaluate(p, x, &now->loss, gradient)) return 1;
        if (now->loss < p->rows[p->best].loss) p->best = k;
        printf("%6d   %8.2f mm %5.1f %%%6.1f %%%6.1f %% %7.3f%10.2f%8.3f\n", k + 1, -1e3 * now->loss, 100.0 * x[0],
               100.0 * x[1], 100.0 * x[2], x[3], x[4], x[5]);
        if (failed(dqa_adam_step(x, gradient, rates, first, second, N, k + 1), "take an Adam step") ||
            failed(dqa_project_simplex(x, N_BASES), "project onto the simplex"))
            return 1;
        x[3] = clamp(x[3], 0.0, 1.0);
        x[4] = clamp(x[4], 0.1 * OMEGA, 3.0 * OMEGA);
    }
    return 0;
}

/* ------------------------------------------------------------------ what the picture shows */
/* Centre of the area that the contour encloses. */
static void centre_of(const motion* m, const double* at, double* centre) {
    double area = 0.0, sum[2] = {0.0, 0.0};
    for (int64_t i = 0; i < m->n_vertices; ++i) {
        const double *a = at + 2 * i, *b = at + 2 * (int64_t)m->next[i];
        const double cross = a[0] * b[1] - a[1] * b[0];
        area += cross;
        for (int k = 0; k < 2; ++k) sum[k] += cross * (a[k] + b[k]) / 3.0;
    }
    for (int k = 0; k < 2; ++k) centre[k] = sum[k] / area;
}

static int record(plane* p, const double* x, motion* m) {
    int64_t n_segments = 0;
    int32_t* segments;
    double* at;
    int bad;
    if (swim(p, x) || failed(dqa_simulator_surface(p->simulator, NULL, 0, NULL, 0, &m->n_vertices, &n_segments),
                             "measure the contour"))
        return 1;
    m->frames = malloc((size_t)(FRAMES * 2 * m->n_vertices) * sizeof *m->frames);
    m->next = calloc((size_t)m->n_vertices, sizeof *m->next);
    at = malloc((size_t)(2 * m->n_vertices) * sizeof *at);
    segments = malloc((size_t)(2 * n_segments) * sizeof *segments);
    bad = m->frames == NULL || m->next == NULL || at == NULL || segments == NULL;
    if (bad) fprintf(stderr, "plane: out of memory\n");
    bad =
        bad || failed(dqa_simulator_surface(p->simulator, at, 2 * m->n_vertices, segments, 2 * n_segments, NULL, NULL),
                      "read the contour");
    /* Contours are closed: at every vertex one segment ends and one begins. */
    for (int64_t i = 0; i < n_segments && !bad; ++i) m->next[segments[2 * i]] = segments[2 * i + 1];
    for (int64_t k = 0; k <= STEPS && !bad; ++k) {
        bad = failed(dqa_tape_get_surface(p->tape, k, at, 2 * m->n_vertices), "read the contour of a step");
        if (bad) break;
        centre_of(m, at, m->path[k]);
        if (k % FRAME_STEPS == 0)
            memcpy(m->frames + k / FRAME_STEPS * 2 * m->n_vertices, at, (size_t)(2 * m->n_vertices) * sizeof *at);
    }
    free(segments);
    free(at);
    return bad;
}

/* ------------------------------------------------------------------ the picture */
/* Two columns: charts above, the first and the best swimmer below, an instant a row. */
enum { WIDTH = 960, LEFT = 70, COLUMN = 380, GAP = 60, CHART_TOP = 76, CHART_BOTTOM = 226, LANES = 300 };

static const char* const colours[N_BASES] = {"#0b7285", "#c2410c", "#6b4fa0"};

/* The map from metres to the picture, with what it has to hold. */
typedef struct view {
    double least[2], most[2]; /* m */
    double scale;             /* picture x = left + scale (x - least x), picture y = row's middle - scale y */
    double row;               /* distance of the rows */
} view;

static void include(view* v, const motion* m) {
    for (int64_t i = 0; i < FRAMES * m->n_vertices; ++i)
        for (int k = 0; k < 2; ++k) {
            v->least[k] = fmin(v->least[k], m->frames[2 * i + k]);
            v->most[k] = fmax(v->most[k], m->frames[2 * i + k]);
        }
}

/* A round step that divides `range` into at most `parts`. */
static double tick_of(double range, double parts) {
    const double raw = range / parts, unit = pow(10.0, floor(log10(raw)));
    return unit * (raw > 5.0 * unit ? 10.0 : raw > 2.0 * unit ? 5.0 : raw > unit ? 2.0 : 1.0);
}

/* A chart over the iterations, of values from low to high. */
typedef struct chart {
    double left, low, high;
} chart;

static double chart_x(const chart* c, int k) {
    return c->left + k * (double)COLUMN / (ITERATIONS - 1);
}

static double chart_y(const chart* c, double value) {
    return CHART_BOTTOM - (value - c->low) / (c->high - c->low) * (CHART_BOTTOM - CHART_TOP);
}

static void chart_axes(FILE* f, const chart* c, const char* title, double tick, double unit) {
    fprintf(f, "<text x=\"%.0f\" y=\"%d\" class=\"title\">%s</text>\n", c->left, CHART_TOP - 16, title);
    for (int k = 0; c->low + k * tick < c->high + 0.5 * tick; ++k) {
        const double value = c->low + k * tick;
        fprintf(f, "<path class=\"grid\" d=\"M%.1f %.1fh%d\"/>", c->left, chart_y(c, value), COLUMN);
        fprintf(f, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%.4g</text>\n", c->left - 8.0,
                chart_y(c, value) + 4.0, fabs(value) < 1e-9 * tick ? 0.0 : value / unit);
    }
    for (int k = 0; k < ITERATIONS; k += k == 0 ? 4 : 5)
        fprintf(f, "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%d</text>\n", chart_x(c, k), CHART_BOTTOM + 18,
                k + 1);
    fprintf(f, "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">iteration</text>\n", c->left + 0.5 * COLUMN,
            CHART_BOTTOM + 36);
}

static void loss_chart(FILE* f, const plane* p) {
    chart c = {LEFT, 0.0, 0.0};
    double tick;
    for (int k = 0; k < ITERATIONS; ++k) {
        c.low = fmin(c.low, p->rows[k].loss);
        c.high = fmax(c.high, p->rows[k].loss);
    }
    tick = tick_of(c.high - c.low, 4.0);
    c.low = tick * floor(c.low / tick);
    c.high = tick * ceil(c.high / tick);
    chart_axes(f, &c, "loss: minus the distance travelled in 2 s (mm)", tick, 1e-3);
    fprintf(f, "<path class=\"line\" stroke=\"#1f2933\" d=\"");
    for (int k = 0; k < ITERATIONS; ++k)
        fprintf(f, "%c%.1f %.1f", k == 0 ? 'M' : 'L', chart_x(&c, k), chart_y(&c, p->rows[k].loss));
    fprintf(f, "\"/>\n<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" fill=\"#1f2933\"/>\n", chart_x(&c, p->best),
            chart_y(&c, p->rows[p->best].loss));
}

static void share_chart(FILE* f, const plane* p) {
    const chart c = {LEFT + COLUMN + GAP, 0.0, 1.0};
    const double* last = p->rows[ITERATIONS - 1].x;
    int order[N_BASES] = {0, 1, 2}; /* by rising share at the end: names must not run into one another */
    double lowest = HUGE_VAL;
    chart_axes(f, &c, "share of each fish (%)", 0.25, 0.01);
    for (int i = 0; i < N_BASES; ++i) {
        fprintf(f, "<path class=\"line\" stroke=\"%s\" d=\"", colours[i]);
        for (int k = 0; k < ITERATIONS; ++k)
            fprintf(f, "%c%.1f %.1f", k == 0 ? 'M' : 'L', chart_x(&c, k), chart_y(&c, p->rows[k].x[i]));
        fprintf(f, "\"/>\n");
        for (int k = i; k > 0 && last[order[k]] < last[order[k - 1]]; --k) {
            const int swapped = order[k];
            order[k] = order[k - 1];
            order[k - 1] = swapped;
        }
    }
    for (int k = 0; k < N_BASES; ++k) {
        const int i = order[k];
        const double y = fmin(chart_y(&c, last[i]) + 4.0, lowest - 15.0);
        fprintf(f, "<text x=\"%.1f\" y=\"%.1f\" style=\"fill:%s\">%s</text>\n", chart_x(&c, ITERATIONS - 1) + 6.0, y,
                colours[i], fish[i].name);
        lowest = y;
    }
}

/* The contour at an instant, one closed loop after the other; `seen` [n_vertices] is scratch. */
static void contour(FILE* f, const motion* m, const view* v, int frame, double left, double middle, char* seen) {
    const double* at = m->frames + (int64_t)frame * 2 * m->n_vertices;
    memset(seen, 0, (size_t)m->n_vertices);
    fprintf(f, "<path class=\"body\" d=\"");
    for (int64_t start = 0; start < m->n_vertices; ++start) {
        char command = 'M';
        if (seen[start]) continue;
        for (int64_t i = start; !seen[i]; i = m->next[i], command = 'L') {
            seen[i] = 1;
            fprintf(f, "%c%.1f %.1f", command, left + v->scale * (at[2 * i] - v->least[0]),
                    middle - v->scale * at[2 * i + 1]);
        }
        fprintf(f, "Z");
    }
    fprintf(f, "\"/>\n");
}

/* A swimmer, an instant a row, with the path of its centre up to then. */
static int lanes(FILE* f, const motion* m, const view* v, const char* title, double left) {
    const double foot = LANES + 20.0 + FRAMES * v->row, tick = tick_of(v->most[0] - v->least[0], 8.0);
    char* seen = malloc((size_t)m->n_vertices);
    if (seen == NULL) return 1;
    fprintf(f, "<text x=\"%.0f\" y=\"%d\" class=\"title\">%s</text>\n", left, LANES, title);
    fprintf(f, "<path class=\"start\" d=\"M%.1f %dV%.1f\"/>\n", left + v->scale * (m->path[0][0] - v->least[0]),
            LANES + 20, foot);
    for (int k = 0; k < FRAMES; ++k) {
        const double middle = LANES + 20.0 + (k + 0.5) * v->row;
        const int steps = k * FRAME_STEPS;
        contour(f, m, v, k, left, middle, seen);
        fprintf(f, "<path class=\"path\" d=\"");
        for (int i = 0; i <= steps; ++i)
            fprintf(f, "%c%.2f %.2f", i == 0 ? 'M' : 'L', left + v->scale * (m->path[i][0] - v->least[0]),
                    middle - v->scale * m->path[i][1]);
        fprintf(f, "\"/><circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\" fill=\"#c2410c\"/>\n",
                left + v->scale * (m->path[steps][0] - v->least[0]), middle - v->scale * m->path[steps][1]);
        if (left == LEFT)
            fprintf(f, "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%.1f s</text>\n", LEFT - 14, middle + 4.0,
                    steps * TIME_STEP);
    }
    for (double x = tick * ceil(v->least[0] / tick); x <= v->most[0]; x += tick)
        fprintf(f,
                "<path class=\"grid\" d=\"M%.1f %.1fv6\"/>"
                "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%.2g</text>\n",
                left + v->scale * (x - v->least[0]), foot, left + v->scale * (x - v->least[0]), foot + 20.0,
                fabs(x) < 1e-9 ? 0.0 : x);
    fprintf(f, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">x (m)</text>\n", left + 0.5 * COLUMN, foot + 38.0);
    free(seen);
    return 0;
}

static int draw(const plane* p, const char* path) {
    view v = {{HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}, 0.0, 0.0};
    double height;
    char title[80];
    FILE* f = fopen(path, "w");
    int bad;
    if (f == NULL) {
        fprintf(stderr, "plane: cannot write %s\n", path);
        return 1;
    }
    include(&v, &p->first_motion);
    include(&v, &p->best_motion);
    v.scale = COLUMN / (v.most[0] - v.least[0]);
    v.row = v.scale * 2.0 * fmax(v.most[1], -v.least[1]) + 10.0;
    height = LANES + 70.0 + FRAMES * v.row;
    fprintf(f, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%.0f\" viewBox=\"0 0 %d %.0f\">\n",
            WIDTH, height, WIDTH, height);
    fprintf(f,
            "<style>text{font:13px sans-serif;fill:#1f2933}.title{font-weight:bold}.grid{stroke:#d9dee3}"
            ".name{font-size:17px;font-weight:bold}.line{fill:none;stroke-width:2;stroke-linejoin:round}"
            ".body{fill:#a5d3dd;stroke:#0b5563;stroke-linejoin:round}.path{fill:none;stroke:#c2410c}"
            ".start{stroke:#98a4ae;stroke-dasharray:3 3}</style>\n");
    fprintf(f, "<rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n");
    fprintf(f, "<text x=\"%d\" y=\"30\" class=\"name\">A plane swimmer: outline and beat improve together</text>\n",
            LEFT);
    loss_chart(f, p);
    share_chart(f, p);
    (void)snprintf(title, sizeof title, "first swimmer: %.1f mm in 2 s", -1e3 * p->rows[0].loss);
    bad = lanes(f, &p->first_motion, &v, title, LEFT);
    (void)snprintf(title, sizeof title, "best swimmer: %.1f mm in 2 s", -1e3 * p->rows[p->best].loss);
    bad = lanes(f, &p->best_motion, &v, title, LEFT + COLUMN + GAP) || bad;
    fprintf(f, "</svg>\n");
    bad = ferror(f) != 0 || bad;
    bad = fclose(f) != 0 || bad;
    if (bad) {
        struct stat written;
        fprintf(stderr, "plane: cannot write %s: the disk is full or failing\n", path);
        if (stat(path, &written) == 0 && S_ISREG(written.st_mode)) (void)remove(path); /* half of it is of no use */
    }
    return bad;
}

/* ------------------------------------------------------------------ all of it */
static int work(plane* p, const char* path) {
    if (make_scene(p) || optimise(p) || record(p, p->rows[0].x, &p->first_motion) ||
        record(p, p->rows[p->best].x, &p->best_motion) || draw(p, path))
        return 1;
    printf("travel in %.0f s: first %.2f mm, best %.2f mm (iteration %d)\n", STEPS * TIME_STEP, -1e3 * p->rows[0].loss,
           -1e3 * p->rows[p->best].loss, p->best + 1);
    printf("picture: %s\n", path);
    return fflush(stdout) != 0;
}

int main(int argc, char** argv) {
    plane p;
    int bad;
    if (argc > 2 || (argc == 2 && (argv[1][0] == '-' || argv[1][0] == '\0'))) {
        fprintf(stderr, "usage: plane [FILE]\n");
        return 2;
    }
    memset(&p, 0, sizeof p);
    bad = work(&p, argc == 2 ? argv[1] : "plane.svg");
    free(p.first_motion.frames);
    free(p.first_motion.next);
    free(p.best_motion.frames);
    free(p.best_motion.next);
    dqa_tape_free(p.tape);
    dqa_controller_free(p.sine);
    dqa_simulator_free(p.simulator);
    dqa_shape_space_free(p.space);
    return bad;
}
