/* SPDX-License-Identifier: MIT
 * Marching tetrahedra on the half y >= 0 of a solid, its mirror image, and the centre of mass. The six tetrahedra of a
 * cube share its diagonal (Freudenthal); their surface is closed and manifold whatever the distances are. */
#include "mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK 6  /* cubes along the edge of a block that is left out when the surface is far from it */
#define SWEEPS 5 /* of mesh_relax */

void* shapes_memory(unsigned long count, unsigned long size) {
    void* p = calloc(count > 0 ? count : 1, size);
    if (p == NULL) {
        fprintf(stderr, "generate: out of memory\n");
        exit(1);
    }
    return p;
}

typedef struct {
    const solid* of;
    double step;
    vec low;
    int n[3];        /* nodes */
    float* distance; /* at nodes; never zero */
    int* edge;       /* vertex on the edge from a node to its neighbour number 1 .. 7, or -1 */
    int room_v, room_t;
    mesh out;
} lattice;

static long node_at(const lattice* g, int i, int j, int k) {
    return ((long)i * g->n[1] + j) * g->n[2] + k;
}

static vec position(const lattice* g, double i, double j, double k) {
    const vec p = {g->low.x + i * g->step, j * g->step, g->low.z + k * g->step};
    return p;
}

static double node_distance(const lattice* g, int i, int j, int k) {
    const float d = (float)solid_distance(g->of, position(g, i, j, k));
    return d == 0.0f ? 1e-12 : (double)d;
}

/* Distances are only of first order: a block counts as far at twice the distance of its corners from its middle. */
static void fill_distances(lattice* g) {
    const double reach = 2.0 * 0.5 * BLOCK * g->step * 1.7320508;
    for (int bi = 0; bi < g->n[0]; bi += BLOCK)
        for (int bj = 0; bj < g->n[1]; bj += BLOCK)
            for (int bk = 0; bk < g->n[2]; bk += BLOCK) {
                const double middle = solid_distance(
                    g->of, position(g, bi + 0.5 * (BLOCK - 1), bj + 0.5 * (BLOCK - 1), bk + 0.5 * (BLOCK - 1)));
                const int far = middle > reach || middle < -reach;
                for (int i = bi; i < bi + BLOCK && i < g->n[0]; ++i)
                    for (int j = bj; j < bj + BLOCK && j < g->n[1]; ++j)
                        for (int k = bk; k < bk + BLOCK && k < g->n[2]; ++k)
                            g->distance[node_at(g, i, j, k)] = (float)(far ? middle : node_distance(g, i, j, k));
            }
}

static void* grown(void* p, int count, int* room, unsigned long size) {
    if (count < *room) return p;
    *room = 2 * *room + 4096;
    p = realloc(p, (unsigned long)*room * size);
    if (p == NULL) {
        fprintf(stderr, "generate: out of memory\n");
        exit(1);
    }
    return p;
}

/* Roughly where the surface crosses an edge, but not beside its ends, where it would leave needles. */
static vec crossing(vec a, vec b, double fa, double fb) {
    double t = fa / (fa - fb);
    t = t < 0.2 ? 0.2 : t > 0.8 ? 0.8 : t;
    return (vec){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z)};
}

/* The vertex on the edge between two corners of the cube at node `at`; a corner is a number of which bit a says whether
 * it lies ahead along axis a. */
static int edge_vertex(lattice* g, const int at[3], int from, int to) {
    const int low = from & to, high = from | to;
    const int i = at[0] + (low & 1), j = at[1] + (low >> 1 & 1), k = at[2] + (low >> 2 & 1);
    const int di = (high ^ low) & 1, dj = (high ^ low) >> 1 & 1, dk = (high ^ low) >> 2 & 1;
    const long node = node_at(g, i, j, k);
    int* known = &g->edge[7 * node + (high ^ low) - 1];
    if (*known < 0) {
        const double fa = g->distance[node], fb = g->distance[node_at(g, i + di, j + dj, k + dk)];
        g->out.vertex = grown(g->out.vertex, g->out.vertices, &g->room_v, sizeof(vec));
        g->out.vertex[g->out.vertices] = crossing(position(g, i, j, k), position(g, i + di, j + dj, k + dk), fa, fb);
        *known = g->out.vertices++;
    }
    return *known;
}

static void put_triangle(lattice* g, int a, int b, int c) {
    g->out.triangle = grown(g->out.triangle, g->out.triangles, &g->room_t, sizeof(int[3]));
    g->out.triangle[g->out.triangles][0] = a;
    g->out.triangle[g->out.triangles][1] = b;
    g->out.triangle[g->out.triangles][2] = c;
    ++g->out.triangles;
}

static void swap(int* a, int* b) {
    const int c = *a;
    *a = *b;
    *b = c;
}

/* c: corners of a tetrahedron of positive volume. */
static void march(lattice* g, const int at[3], int c[4]) {
    int inside[4], n = 0, even = 1;
    for (int p = 0; p < 4; ++p) {
        const long node = node_at(g, at[0] + (c[p] & 1), at[1] + (c[p] >> 1 & 1), at[2] + (c[p] >> 2 & 1));
        inside[p] = g->distance[node] < 0.0f;
        n += inside[p];
    }
    if (n == 0 || n == 4) return;
    for (int p = 0; p < n; ++p) /* the corners inside first; every swap mirrors the order */
        for (int q = p + 1; q < 4 && !inside[p]; ++q)
            if (inside[q]) {
                swap(&c[p], &c[q]);
                swap(&inside[p], &inside[q]);
                even = !even;
            }
    if (!even && n != 3) swap(&c[2], &c[3]);
    if (!even && n == 3) swap(&c[0], &c[1]);
    if (n == 1) {
        put_triangle(g, edge_vertex(g, at, c[0], c[1]), edge_vertex(g, at, c[0], c[2]), edge_vertex(g, at, c[0], c[3]));
    } else if (n == 3) {
        put_triangle(g, edge_vertex(g, at, c[0], c[3]), edge_vertex(g, at, c[1], c[3]), edge_vertex(g, at, c[2], c[3]));
    } else {
        const int v02 = edge_vertex(g, at, c[0], c[2]), v03 = edge_vertex(g, at, c[0], c[3]);
        const int v13 = edge_vertex(g, at, c[1], c[3]), v12 = edge_vertex(g, at, c[1], c[2]);
        put_triangle(g, v02, v03, v13);
        put_triangle(g, v02, v13, v12);
    }
}

static int root_of(int* parent, int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
}

/* Leaves the piece with the most triangles; others are specks where a tip is thinner than the lattice. */
static void keep_largest_piece(mesh* m) {
    int* parent = shapes_memory((unsigned long)m->vertices, sizeof(int));
    int* size = shapes_memory((unsigned long)m->vertices, sizeof(int));
    int largest = 0, kept = 0, vertices = 0;
    for (int v = 0; v < m->vertices; ++v) parent[v] = v;
    for (int t = 0; t < m->triangles; ++t)
        for (int p = 1; p < 3; ++p) parent[root_of(parent, m->triangle[t][p])] = root_of(parent, m->triangle[t][0]);
    for (int t = 0; t < m->triangles; ++t) ++size[root_of(parent, m->triangle[t][0])];
    for (int v = 0; v < m->vertices; ++v)
        if (size[v] > size[largest]) largest = v;
    for (int t = 0; t < m->triangles; ++t)
        if (root_of(parent, m->triangle[t][0]) == largest) memmove(m->triangle[kept++], m->triangle[t], sizeof(int[3]));
    m->triangles = kept;
    for (int v = 0; v < m->vertices; ++v) size[v] = root_of(parent, v) == largest ? vertices++ : -1;
    for (int v = 0; v < m->vertices; ++v)
        if (size[v] >= 0) m->vertex[size[v]] = m->vertex[v];
    for (int c = 0; c < 3 * kept; ++c) m->triangle[c / 3][c % 3] = size[m->triangle[c / 3][c % 3]];
    m->vertices = vertices;
    free(parent);
    free(size);
}

mesh mesh_half(const solid* s, double step) {
    /* Orders of the axes on the way from corner 0 to corner 7; the second three are odd. */
    static const int ways[6][3] = {{1, 2, 4}, {2, 4, 1}, {4, 1, 2}, {2, 1, 4}, {1, 4, 2}, {4, 2, 1}};
    lattice g = {.of = s, .step = step, .low = {1e9, 0, 1e9}};
    vec high = {-1e9, -1e9, -1e9};
    long nodes;
    for (int p = 0; p < s->parts; ++p) {
        const part* q = &s->part[p];
        if (q->low.x < g.low.x) g.low.x = q->low.x;
        if (q->low.z < g.low.z) g.low.z = q->low.z;
        if (q->high.x > high.x) high.x = q->high.x;
        if (q->high.y > high.y) high.y = q->high.y;
        if (q->high.z > high.z) high.z = q->high.z;
    }
    g.low.x -= 3.3 * step, g.low.z -= 3.3 * step;
    g.n[0] = (int)((high.x - g.low.x) / step) + 5;
    g.n[1] = (int)(high.y / step) + 5;
    g.n[2] = (int)((high.z - g.low.z) / step) + 5;
    nodes = (long)g.n[0] * g.n[1] * g.n[2];
    g.distance = shapes_memory((unsigned long)nodes, sizeof(float));
    g.edge = shapes_memory((unsigned long)nodes, 7 * sizeof(int));
    for (long e = 0; e < 7 * nodes; ++e) g.edge[e] = -1;
    fill_distances(&g);
    for (int i = 0; i + 1 < g.n[0]; ++i)
        for (int j = 0; j + 1 < g.n[1]; ++j)
            for (int k = 0; k + 1 < g.n[2]; ++k)
                for (int w = 0; w < 6; ++w) {
                    const int at[3] = {i, j, k};
                    int c[4] = {0, ways[w][0], ways[w][0] | ways[w][1], 7};
                    if (w >= 3) swap(&c[1], &c[2]);
                    march(&g, at, c);
                }
    free(g.distance);
    free(g.edge);
    keep_largest_piece(&g.out);
    return g.out;
}

/* A step of Newton's method towards the surface, of at most half an edge of the lattice. */
static vec to_surface(const solid* s, vec p, double step) {
    const double e = 1e-5, d = solid_distance(s, p);
    const vec g = {(solid_distance(s, (vec){p.x + e, p.y, p.z}) - d) / e,
                   p.y == 0.0 ? 0.0 : (solid_distance(s, (vec){p.x, p.y + e, p.z}) - d) / e,
                   (solid_distance(s, (vec){p.x, p.y, p.z + e}) - d) / e};
    const double size = sqrt(g.x * g.x + g.y * g.y + g.z * g.z);
    double way = -d / (size > 0.3 ? size : 0.3);
    way = way > 0.5 * step ? 0.5 * step : way < -0.5 * step ? -0.5 * step : way;
    if (!(size > 1e-3)) return p;
    return (vec){p.x + way * g.x / size, p.y + way * g.y / size, p.z + way * g.z / size};
}

void mesh_relax(mesh* m, const solid* s, double step) {
    const unsigned long n = (unsigned long)m->vertices;
    vec* sum = shapes_memory(n, sizeof(vec));
    int* count = shapes_memory(n, sizeof(int));
    for (int sweep = 0; sweep < SWEEPS; ++sweep) {
        memset(sum, 0, n * sizeof(vec));
        memset(count, 0, n * sizeof(int));
        for (int c = 0; c < 3 * m->triangles; ++c) {
            const int u = m->triangle[c / 3][c % 3], v = m->triangle[c / 3][(c + 1) % 3];
            const vec a = m->vertex[u], b = m->vertex[v];
            sum[u] = (vec){sum[u].x + b.x, sum[u].y + b.y, sum[u].z + b.z};
            sum[v] = (vec){sum[v].x + a.x, sum[v].y + a.y, sum[v].z + a.z};
            ++count[u], ++count[v];
        }
        for (int v = 0; v < m->vertices; ++v) {
            const double w = sweep + 1 < SWEEPS ? 0.6 : 0.0; /* the last sweep only returns to the surface */
            vec* p = &m->vertex[v];
            const int flat = p->y == 0.0;
            *p = (vec){p->x + w * (sum[v].x / count[v] - p->x), p->y + w * (sum[v].y / count[v] - p->y),
                       p->z + w * (sum[v].z / count[v] - p->z)};
            if (flat) p->y = 0.0;
            *p = to_surface(s, *p, step);
            if (!flat && p->y < 0.05 * step) p->y = 0.05 * step;
        }
    }
    free(sum);
    free(count);
}

void mesh_mirror(mesh* m) {
    const int n = m->vertices, t = m->triangles;
    int* image = shapes_memory((unsigned long)n, sizeof(int));
    vec* vertex = shapes_memory(2 * (unsigned long)n, sizeof(vec));
    int(*triangle)[3] = shapes_memory(2 * (unsigned long)t, sizeof(int[3]));
    for (int v = 0; v < n; ++v) {
        vertex[v] = m->vertex[v];
        image[v] = v;
        if (vertex[v].y == 0.0) continue;
        image[v] = m->vertices++;
        vertex[image[v]] = (vec){vertex[v].x, -vertex[v].y, vertex[v].z};
    }
    for (int k = 0; k < t; ++k) {
        const int* c = m->triangle[k];
        for (int p = 0; p < 3; ++p) {
            triangle[k][p] = c[p];
            triangle[t + k][2 - p] = image[c[p]];
        }
    }
    m->triangles = 2 * t;
    free(image);
    free(m->vertex);
    free(m->triangle);
    m->vertex = vertex;
    m->triangle = triangle;
}

void mesh_fit(mesh* m, double* scale, double* shift) {
    double low = m->vertex[0].x, high = low;
    for (int v = 1; v < m->vertices; ++v) {
        if (m->vertex[v].x < low) low = m->vertex[v].x;
        if (m->vertex[v].x > high) high = m->vertex[v].x;
    }
    *scale = 1.0 / (high - low);
    *shift = 0.5 - *scale * high;
    for (int v = 0; v < m->vertices; ++v) {
        vec* p = &m->vertex[v];
        *p = (vec){*scale * p->x + *shift, *scale * p->y, *scale * p->z};
    }
}

vec mesh_centre(const mesh* m) {
    double volume = 0.0;
    vec sum = {0, 0, 0};
    for (int t = 0; t < m->triangles; ++t) {
        const vec a = m->vertex[m->triangle[t][0]], b = m->vertex[m->triangle[t][1]], c = m->vertex[m->triangle[t][2]];
        const double v = a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x);
        volume += v;
        sum = (vec){sum.x + v * (a.x + b.x + c.x), 0, sum.z + v * (a.z + b.z + c.z)};
    }
    return (vec){sum.x / (4 * volume), 0, sum.z / (4 * volume)};
}

void mesh_free(mesh* m) {
    free(m->vertex);
    free(m->triangle);
    m->vertex = NULL;
    m->triangle = NULL;
    m->vertices = m->triangles = 0;
}
