/* SPDX-License-Identifier: MIT
 * The shipped shapes: closed, oriented, in one piece, free of needles and of triangles that cross; what `generate`
 * writes; in one piece with all their fins in the paper's boxes; and lists of muscles that lie in the body.
 * test_shapes GENERATE; the folder of the shapes is DQA_SHAPES_DIR, and files go to the working directory. */
#define _POSIX_C_SOURCE 200809L

/* cmocka.h needs the standard headers before it. */
/* clang-format off */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
/* clang-format on */

#include "diffaqua.h"
#include "support/bases.h"
#include "support/say.h"

static const char* generate;

/* The paper's box for each shape. */
static const struct {
    const char* name;
    int32_t cells[3];
} shapes[] = {
    {"eel_vertical", {40, 8, 8}},
    {"eel_horizontal", {40, 8, 8}},
    {"clownfish", {60, 54, 14}},
    {"manta_ray", {60, 54, 14}},
    {"stingray", {60, 54, 14}},
    {"tuna", {60, 16, 26}},
    {"orca", {60, 16, 26}},
    {"great_white", {60, 16, 26}},
    {"hammerhead", {60, 16, 26}},
    {"thresher", {60, 16, 26}},
    {"whale_shark", {60, 16, 26}},
    {"goldfish_common", {60, 16, 26}},
    {"goldfish_comet", {60, 16, 26}},
    {"goldfish_fantail", {60, 16, 26}},
    {"goldfish_ryukin", {60, 16, 26}},
    {"goldfish_oranda", {60, 16, 26}},
    {"goldfish_ranchu", {60, 16, 26}},
    {"goldfish_telescope", {60, 16, 26}},
    {"submarine", {60, 16, 26}},
};
#define SHAPES ((int)(sizeof shapes / sizeof shapes[0]))

typedef struct {
    double x[3];
} point;

typedef struct {
    int corners, vertices;
    point* corner; /* three a triangle */
    int* vertex;   /* of each corner, after points with equal coordinates were joined */
    point* at;     /* vertices */
} mesh;

static unsigned char* content(const char* path, size_t* size) {
    FILE* file = fopen(path, "rb");
    unsigned char* bytes = malloc(1 << 20);
    assert_non_null(bytes);
    if (file == NULL) fail_msg("cannot open %s", path);
    *size = fread(bytes, 1, 1 << 20, file);
    (void)fclose(file);
    return bytes;
}

static const point* sorted_points;
static int by_place(const void* pa, const void* pb) {
    const int a = *(const int*)pa, b = *(const int*)pb;
    for (int k = 0; k < 3; ++k) {
        const double x = sorted_points[a].x[k], y = sorted_points[b].x[k];
        if (x != y) return x < y ? -1 : 1;
    }
    return a - b;
}

static mesh read_mesh(const char* name) {
    char path[4096];
    mesh m;
    size_t size;
    unsigned char* bytes;
    int* order;
    uint32_t count;
    (void)snprintf(path, sizeof path, "%s/%s.stl", DQA_SHAPES_DIR, name);
    bytes = content(path, &size);
    memcpy(&count, bytes + 80, 4);
    assert_int_equal(size, 84 + 50 * (size_t)count);
    m.corners = 3 * (int)count;
    m.vertices = 0;
    m.corner = malloc((size_t)m.corners * sizeof *m.corner);
    m.at = malloc((size_t)m.corners * sizeof *m.at);
    m.vertex = malloc((size_t)m.corners * sizeof *m.vertex);
    order = malloc((size_t)m.corners * sizeof *order);
    assert_true(m.corner != NULL && m.at != NULL && m.vertex != NULL && order != NULL);
    for (int c = 0; c < m.corners; ++c) {
        float x[3];
        memcpy(x, bytes + 84 + 50 * (c / 3) + 12 + 12 * (c % 3), sizeof x);
        for (int k = 0; k < 3; ++k) m.corner[c].x[k] = (double)x[k];
        order[c] = c;
    }
    sorted_points = m.corner;
    qsort(order, (size_t)m.corners, sizeof *order, by_place);
    for (int c = 0; c < m.corners; ++c) {
        if (c == 0 || memcmp(&m.corner[order[c]], &m.corner[order[c - 1]], sizeof(point)) != 0)
            m.at[m.vertices++] = m.corner[order[c]];
        m.vertex[order[c]] = m.vertices - 1;
    }
    free(order);
    free(bytes);
    return m;
}

static void free_mesh(mesh* m) {
    free(m->corner);
    free(m->vertex);
    free(m->at);
}

static void cross_of(const double* a, const double* b, const double* c, double n[3]) {
    const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    n[0] = u[1] * v[2] - u[2] * v[1], n[1] = u[2] * v[0] - u[0] * v[2], n[2] = u[0] * v[1] - u[1] * v[0];
}

static double above(const double n[3], const double* a, const double* p) {
    return n[0] * (p[0] - a[0]) + n[1] * (p[1] - a[1]) + n[2] * (p[2] - a[2]);
}

typedef struct {
    int from, to;
} edge;
static int by_ends(const void* pa, const void* pb) {
    const edge *a = pa, *b = pb;
    return a->from != b->from ? a->from - b->from : a->to - b->to;
}

static int root_of(int* parent, int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
}

/* Closed, oriented, one piece, without holes through it, and every corner of every triangle at least about 2 degrees.
 */
static void test_meshes_are_closed_surfaces(void** state) {
    (void)state;
    for (int s = 0; s < SHAPES; ++s) {
        mesh m = read_mesh(shapes[s].name);
        edge* edges = malloc((size_t)m.corners * sizeof *edges);
        int* parent = malloc((size_t)m.vertices * sizeof *parent);
        double volume = 0.0, low[3] = {9, 9, 9}, high[3] = {-9, -9, -9};
        int pieces = 0;
        assert_true(edges != NULL && parent != NULL);
        for (int v = 0; v < m.vertices; ++v) parent[v] = v;
        for (int c = 0; c < m.corners; ++c) {
            edges[c].from = m.vertex[c];
            edges[c].to = m.vertex[c % 3 == 2 ? c - 2 : c + 1];
            assert_int_not_equal(edges[c].from, edges[c].to);
            parent[root_of(parent, edges[c].from)] = root_of(parent, edges[c].to);
            for (int k = 0; k < 3; ++k) {
                assert_true(isfinite(m.corner[c].x[k]));
                low[k] = fmin(low[k], m.corner[c].x[k]), high[k] = fmax(high[k], m.corner[c].x[k]);
            }
        }
        qsort(edges, (size_t)m.corners, sizeof *edges, by_ends);
        for (int c = 0; c < m.corners; ++c) {
            const edge back = {edges[c].to, edges[c].from};
            if (c > 0 && by_ends(&edges[c], &edges[c - 1]) == 0)
                fail_msg("%s: two triangles run the same way along an edge", shapes[s].name);
            if (bsearch(&back, edges, (size_t)m.corners, sizeof *edges, by_ends) == NULL)
                fail_msg("%s: open at (%g, %g, %g)", shapes[s].name, m.at[back.to].x[0], m.at[back.to].x[1],
                         m.at[back.to].x[2]);
        }
        for (int v = 0; v < m.vertices; ++v) pieces += root_of(parent, v) == v;
        assert_int_equal(pieces, 1);
        /* Euler: a sphere. Edges are half the corners, triangles a third. */
        if (m.vertices - m.corners / 2 + m.corners / 3 != 2)
            fail_msg("%s: Euler characteristic %d, not 2", shapes[s].name, m.vertices - m.corners / 2 + m.corners / 3);
        for (int t = 0; t < m.corners; t += 3) {
            const double *a = m.corner[t].x, *b = m.corner[t + 1].x, *c = m.corner[t + 2].x;
            const double* p[4] = {a, b, c, a};
            double n[3], longest = 0.0, twice;
            cross_of(a, b, c, n);
            twice = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
            for (int e = 0; e < 3; ++e)
                longest =
                    fmax(longest, hypot(hypot(p[e][0] - p[e + 1][0], p[e][1] - p[e + 1][1]), p[e][2] - p[e + 1][2]));
            if (!(twice > 0.02 * longest * longest))
                fail_msg("%s: a needle at (%g, %g, %g): twice its area is %g of its length squared", shapes[s].name,
                         a[0], a[1], a[2], twice / (longest * longest));
            volume += above(n, (const double[3]){0, 0, 0}, a) / 6;
        }
        assert_true(volume > 1e-3 && volume < 0.2);
        assert_true(fabs(low[0] + 0.5) < 1e-6 && fabs(high[0] - 0.5) < 1e-6);
        assert_true(fabs(low[1] + high[1]) < 1e-7 && high[1] < 0.6 && low[2] > -0.5 && high[2] < 0.5);
        free(parent);
        free(edges);
        free_mesh(&m);
    }
}

/* Whether the segment p q passes through the triangle a b c. */
static int pierces(const double* p, const double* q, const double* a, const double* b, const double* c) {
    double n[3], s[3];
    cross_of(a, b, c, n);
    if (above(n, a, p) * above(n, a, q) >= 0.0) return 0;
    cross_of(p, q, a, n), s[0] = above(n, p, b);
    cross_of(p, q, b, n), s[1] = above(n, p, c);
    cross_of(p, q, c, n), s[2] = above(n, p, a);
    return (s[0] > 0 && s[1] > 0 && s[2] > 0) || (s[0] < 0 && s[1] < 0 && s[2] < 0);
}

static int cross_each_other(const mesh* m, int t, int u) {
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
            if (m->vertex[t + a] == m->vertex[u + b]) return 0; /* neighbours: the fold check of the generator's */
    for (int e = 0; e < 3; ++e) {
        if (pierces(m->corner[t + e].x, m->corner[t + (e + 1) % 3].x, m->corner[u].x, m->corner[u + 1].x,
                    m->corner[u + 2].x))
            return 1;
        if (pierces(m->corner[u + e].x, m->corner[u + (e + 1) % 3].x, m->corner[t].x, m->corner[t + 1].x,
                    m->corner[t + 2].x))
            return 1;
    }
    return 0;
}

typedef struct {
    double low[3], high[3];
    int corner;
} bounds;
static int by_low(const void* pa, const void* pb) {
    const bounds *a = pa, *b = pb;
    if (a->low[0] != b->low[0]) return a->low[0] < b->low[0] ? -1 : 1;
    return a->corner - b->corner;
}

static void test_meshes_do_not_cross_themselves(void** state) {
    (void)state;
    for (int s = 0; s < SHAPES; ++s) {
        mesh m = read_mesh(shapes[s].name);
        const int n = m.corners / 3;
        bounds* box = malloc((size_t)n * sizeof *box);
        assert_non_null(box);
        for (int t = 0; t < n; ++t) {
            const bounds none = {{9, 9, 9}, {-9, -9, -9}, 3 * t};
            box[t] = none;
            for (int p = 0; p < 3; ++p)
                for (int k = 0; k < 3; ++k) {
                    box[t].low[k] = fmin(box[t].low[k], m.corner[3 * t + p].x[k]);
                    box[t].high[k] = fmax(box[t].high[k], m.corner[3 * t + p].x[k]);
                }
        }
        qsort(box, (size_t)n, sizeof *box, by_low);
        for (int t = 0; t < n; ++t)
            for (int u = t + 1; u < n && box[u].low[0] <= box[t].high[0]; ++u) {
                if (box[u].low[1] > box[t].high[1] || box[t].low[1] > box[u].high[1]) continue;
                if (box[u].low[2] > box[t].high[2] || box[t].low[2] > box[u].high[2]) continue;
                if (cross_each_other(&m, box[t].corner, box[u].corner))
                    fail_msg("%s crosses itself near (%g, %g, %g)", shapes[s].name, box[t].low[0], box[t].low[1],
                             box[t].low[2]);
            }
        free(box);
        free_mesh(&m);
    }
}

static void test_generate_writes_the_same_files(void** state) {
    static const char* const extensions[] = {"stl", "txt"};
    char command[4096], path[4096];
    (void)state;
    (void)snprintf(command, sizeof command, "'%s' .", generate);
    assert_int_equal(system(command), 0);
    for (int s = 0; s < SHAPES; ++s)
        for (int e = 0; e < 2; ++e) {
            size_t size, committed_size;
            unsigned char *written, *committed;
            (void)snprintf(path, sizeof path, "%s.%s", shapes[s].name, extensions[e]);
            written = content(path, &size);
            (void)remove(path);
            (void)snprintf(path, sizeof path, "%s/%s.%s", DQA_SHAPES_DIR, shapes[s].name, extensions[e]);
            committed = content(path, &committed_size);
            if (size != committed_size || memcmp(written, committed, size) != 0)
                fail_msg("%s is not what generate writes", path);
            free(written);
            free(committed);
        }
}

/* A space of one shape in its box, with the muscles of its list; cell is 0 for a body of 1 m. */
static int add_mesh(void* context, const char* path) {
    return dqa_shape_space_add_mesh_file(context, path, NULL) == DQA_SUCCESS ? DONE : FAILED;
}

static dqa_shape_space* space_of(int s, double cell, bases* list) {
    dqa_shape_space_options options;
    dqa_shape_space* space;
    char path[4096];
    assert_int_equal(dqa_shape_space_options_init(&options, sizeof options), DQA_SUCCESS);
    options.cells_x = shapes[s].cells[0], options.cells_y = shapes[s].cells[1], options.cells_z = shapes[s].cells[2];
    options.cell_size = cell;
    assert_int_equal(dqa_shape_space_create(&options, &space), DQA_SUCCESS);
    (void)snprintf(path, sizeof path, "%s/%s.txt", DQA_SHAPES_DIR, shapes[s].name);
    memset(list, 0, sizeof *list);
    assert_int_equal(bases_read(list, path, add_mesh, space), DONE);
    if (cell > 0.0) assert_int_equal(bases_add_actuators(list, path, NULL, space), DONE);
    if (dqa_shape_space_build(space, NULL, NULL) != DQA_SUCCESS) fail_msg("%s: %s", path, dqa_last_error());
    return space;
}

static double cell_of(int s) {
    bases list;
    dqa_shape_space* space = space_of(s, 0.0, &list);
    dqa_shape_space_info info;
    assert_int_equal(dqa_shape_space_get_info(space, &info, sizeof info), DQA_SUCCESS);
    dqa_shape_space_free(space);
    bases_free(&list);
    return info.cell_size;
}

static long cell_at(int s, int i, int j, int k) {
    const int32_t* n = shapes[s].cells;
    return i < 0 || j < 0 || k < 0 || i >= n[0] || j >= n[1] || k >= n[2] ? -1 : ((long)i * n[1] + j) * n[2] + k;
}

static double* density_of(const dqa_shape_space* space, int64_t* cells) {
    const double one = 1.0;
    dqa_shape_space_info info;
    double* density;
    assert_int_equal(dqa_shape_space_get_info(space, &info, sizeof info), DQA_SUCCESS);
    *cells = info.n_cells;
    density = malloc((size_t)info.n_cells * sizeof *density);
    assert_non_null(density);
    assert_int_equal(dqa_shape_space_density(space, &one, 1, density, info.n_cells), DQA_SUCCESS);
    return density;
}

/* Number of cells over one half that a walk through faces reaches from the first of them, and how many there are. */
static long reached(int s, const double* density, long cells, long* all) {
    const int32_t* n = shapes[s].cells;
    char* seen = calloc((size_t)cells, 1);
    long* stack = malloc((size_t)cells * sizeof *stack);
    long count = 0, height = 0;
    assert_true(seen != NULL && stack != NULL);
    *all = 0;
    for (long c = 0; c < cells; ++c) *all += density[c] > 0.5;
    for (long c = 0; c < cells && height == 0; ++c)
        if (density[c] > 0.5) seen[c] = 1, stack[height++] = c;
    while (height > 0) {
        const long c = stack[--height];
        const int k = (int)(c % n[2]), j = (int)(c / n[2] % n[1]), i = (int)(c / n[2] / n[1]);
        ++count;
        for (int side = 0; side < 6; ++side) {
            const int step = side % 2 == 0 ? 1 : -1;
            const long next = cell_at(s, i + (side / 2 == 0 ? step : 0), j + (side / 2 == 1 ? step : 0),
                                      k + (side / 2 == 2 ? step : 0));
            if (next < 0 || seen[next] || density[next] <= 0.5) continue;
            seen[next] = 1;
            stack[height++] = next;
        }
    }
    free(seen);
    free(stack);
    return count;
}

/* The centre of mass, to which spaces move a mesh. */
static void centre_of(const mesh* m, double centre[3]) {
    double volume = 0.0;
    centre[0] = centre[1] = centre[2] = 0.0;
    for (int t = 0; t < m->corners; t += 3) {
        double n[3], v;
        cross_of(m->corner[t].x, m->corner[t + 1].x, m->corner[t + 2].x, n);
        v = above(n, (const double[3]){0, 0, 0}, m->corner[t].x);
        volume += v;
        for (int k = 0; k < 3; ++k)
            centre[k] += v / 4 * (m->corner[t].x[k] + m->corner[t + 1].x[k] + m->corner[t + 2].x[k]);
    }
    for (int k = 0; k < 3; ++k) centre[k] /= volume;
}

/* Distance, in cells, from a point to the nearest cell over one half; at most 3. */
static double bare(int s, const double* density, const double at[3]) {
    double nearest = 3.0;
    const int i = (int)floor(at[0]), j = (int)floor(at[1]), k = (int)floor(at[2]);
    for (int a = i - 3; a <= i + 3; ++a)
        for (int b = j - 3; b <= j + 3; ++b)
            for (int c = k - 3; c <= k + 3; ++c) {
                const long cell = cell_at(s, a, b, c);
                if (cell < 0 || density[cell] <= 0.5) continue;
                nearest = fmin(nearest, sqrt(pow(fmax(fmax(a - at[0], at[0] - a - 1), 0), 2) +
                                             pow(fmax(fmax(b - at[1], at[1] - b - 1), 0), 2) +
                                             pow(fmax(fmax(c - at[2], at[2] - c - 1), 0), 2)));
            }
    return nearest;
}

/* One piece, and no fin is lost: hardly any of the surface is further than a cell from a cell of the body. */
static void test_fins_survive_in_cells(void** state) {
    int bad = 0;
    (void)state;
    for (int s = 0; s < SHAPES; ++s) {
        bases list;
        mesh m = read_mesh(shapes[s].name);
        const double cell = cell_of(s);
        dqa_shape_space* space = space_of(s, cell, &list);
        int64_t cells;
        double* density = density_of(space, &cells);
        double centre[3], area = 0.0, lost = 0.0;
        long all, walked = reached(s, density, (long)cells, &all);
        centre_of(&m, centre);
        for (int t = 0; t < m.corners; t += 3) {
            double n[3], at[3], twice;
            cross_of(m.corner[t].x, m.corner[t + 1].x, m.corner[t + 2].x, n);
            twice = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
            for (int k = 0; k < 3; ++k)
                at[k] = ((m.corner[t].x[k] + m.corner[t + 1].x[k] + m.corner[t + 2].x[k]) / 3 - centre[k]) / cell +
                        0.5 * shapes[s].cells[k];
            area += twice;
            if (bare(s, density, at) > 1.0) lost += twice;
        }
        printf("%-20s %.1f cells long, %ld cells, %ld of them in one piece, %.2f %% of the surface bare\n",
               shapes[s].name, 1 / cell, all, walked, 100 * lost / area);
        bad += walked != all || lost > 0.01 * area;
        free(density);
        dqa_shape_space_free(space);
        bases_free(&list);
        free_mesh(&m);
    }
    assert_int_equal(bad, 0);
}

/* Muscles: the middle in the body, and enough of the box for the muscle to have flesh on both sides. */
static void test_muscles_lie_in_the_body(void** state) {
    int bad = 0;
    (void)state;
    for (int s = 0; s < SHAPES; ++s) {
        bases list;
        const double cell = cell_of(s);
        dqa_shape_space* space = space_of(s, cell, &list);
        int64_t cells;
        double* density = density_of(space, &cells);
        assert_in_range(list.n_actuators, 1, 2);
        for (int a = 0; a < list.n_actuators; ++a) {
            const dqa_actuator_options* o = &list.actuators[a].options;
            const double cx = cos(o->euler[0]), sx = sin(o->euler[0]), cy = cos(o->euler[1]), sy = sin(o->euler[1]);
            const double cz = cos(o->euler[2]), sz = sin(o->euler[2]);
            const double axis[3][3] = {{cy * cz, -cy * sz, sy},
                                       {cx * sz + sx * sy * cz, cx * cz - sx * sy * sz, -sx * cy},
                                       {sx * sz - cx * sy * cz, sx * cz + cx * sy * sz, cx * cy}};
            int in = 0, middle = 0;
            for (int q = 0; q < 1000; ++q) {
                const double t[3] = {(q % 10 - 4.5) / 5, (q / 10 % 10 - 4.5) / 5, (q / 100 - 4.5) / 5};
                long c;
                double at[3];
                for (int k = 0; k < 3; ++k) {
                    at[k] = o->mean[k];
                    for (int e = 0; e < 3; ++e) at[k] += t[e] * sqrt(1.3862943611198906 * o->variance[e]) * axis[e][k];
                    at[k] = at[k] / cell + 0.5 * shapes[s].cells[k];
                }
                c = cell_at(s, (int)floor(at[0]), (int)floor(at[1]), (int)floor(at[2]));
                if (c >= 0 && density[c] > 0.5) ++in;
            }
            {
                const long c = cell_at(s, (int)floor(o->mean[0] / cell + 0.5 * shapes[s].cells[0]),
                                       (int)floor((o->mean[1] + 1e-9) / cell + 0.5 * shapes[s].cells[1]),
                                       (int)floor(o->mean[2] / cell + 0.5 * shapes[s].cells[2]));
                middle = c >= 0 && density[c] > 0.5;
            }
            printf("%-20s %s: %.0f %% of the box in the body, middle %s\n", shapes[s].name,
                   o->kind == DQA_ACTUATOR_FINS ? "fins  " : "caudal", in / 10.0, middle ? "in" : "OUT");
            bad += in < 350 || !middle;
        }
        free(density);
        dqa_shape_space_free(space);
        bases_free(&list);
    }
    assert_int_equal(bad, 0);
}

int main(int argc, char** argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_meshes_are_closed_surfaces),     cmocka_unit_test(test_meshes_do_not_cross_themselves),
        cmocka_unit_test(test_generate_writes_the_same_files), cmocka_unit_test(test_fins_survive_in_cells),
        cmocka_unit_test(test_muscles_lie_in_the_body),
    };
    if (argc != 2) {
        fprintf(stderr, "usage: %s GENERATE\n", argv[0]);
        return 2;
    }
    generate = argv[1];
    return cmocka_run_group_tests(tests, NULL, NULL);
}
