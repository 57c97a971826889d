/* SPDX-License-Identifier: MIT
 * Polygons of designs side by side. */
#include "gallery.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "output.h"
#include "say.h"

#define SEAM 0.002 /* of the page's unit: less than a pixel of most pictures */

/* The page's right and up, and the way to the viewer, who stands 40 degrees above, ahead of the right side: the animals
 * look to the lower right. */
static const double right[3] = {0.8192, 0.5736, 0.0}, upward[3] = {-0.3687, 0.5266, 0.7660},
                    viewer[3] = {0.4394, -0.6275, 0.6428};

void gallery_free(gallery* g) {
    free(g->polygons);
    memset(g, 0, sizeof *g);
}

static double dot(const double* a, const double* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normal_of(const double* a, const double* b, const double* c, double* n) {
    const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    n[0] = u[1] * v[2] - u[2] * v[1];
    n[1] = u[2] * v[0] - u[0] * v[2];
    n[2] = u[0] * v[1] - u[1] * v[0];
}

static void normalise(double* a) {
    const double length = sqrt(dot(a, a));
    for (int i = 0; i < 3 && length > 0.0; ++i) a[i] /= length;
}

static uint32_t shade(uint32_t colour, const double* normal) {
    static const double sun[3] = {-0.10, -0.35, 0.9314};
    const double light = 0.42 + 0.62 * fmax(0.0, 0.25 + 0.75 * dot(normal, sun));
    uint32_t out = colour >> 24;
    for (int i = 0; i < 3; ++i) {
        const double value = (double)(colour >> (16 - 8 * i) & 0xffu) * light;
        out = out << 8 | (uint32_t)(fmin(255.0, value) + 0.5);
    }
    return out;
}

/* A little more of an opaque polygon closes the seams that smoothed edges leave between neighbours. */
static void grow(gallery_polygon* p) {
    double middle[2] = {0.0, 0.0};
    for (int c = 0; c < 4; ++c)
        for (int i = 0; i < 2; ++i) middle[i] += 0.25 * p->corners[c][i];
    for (int c = 0; c < 4; ++c) {
        double out[2] = {p->corners[c][0] - middle[0], p->corners[c][1] - middle[1]};
        const double length = sqrt(out[0] * out[0] + out[1] * out[1]);
        for (int i = 0; i < 2 && length > 0.0; ++i) p->corners[c][i] += SEAM * out[i] / length;
    }
}

static int add(gallery* g, const double* const corners[4], const double* place, uint32_t colour) {
    gallery_polygon* p;
    if (g->n == g->capacity) {
        const int64_t capacity = g->capacity > 0 ? 2 * g->capacity : 4096;
        gallery_polygon* grown = realloc(g->polygons, (size_t)capacity * sizeof *grown);
        if (grown == NULL) return say_no_memory();
        g->polygons = grown;
        g->capacity = capacity;
    }
    p = &g->polygons[g->n++];
    p->colour = colour;
    p->depth = 0.0;
    for (int c = 0; c < 4; ++c) {
        p->corners[c][0] = place[0] + dot(right, corners[c]);
        p->corners[c][1] = place[1] + dot(upward, corners[c]);
        p->depth += 0.25 * dot(viewer, corners[c]);
    }
    if (colour >> 24 == 0) grow(p);
    return DONE;
}

int gallery_add_surface(gallery* g, const double* vertices, int64_t n_vertices, const int32_t* triangles,
                        int64_t n_triangles, const double* place, uint32_t colour) {
    double* normals = calloc((size_t)n_vertices * 3, sizeof *normals);
    int outcome = normals != NULL ? DONE : say_no_memory();
    for (int64_t t = 0; t < n_triangles && outcome == DONE; ++t) {
        const int32_t* v = triangles + 3 * t;
        double n[3];
        normal_of(vertices + 3 * v[0], vertices + 3 * v[1], vertices + 3 * v[2], n);
        for (int c = 0; c < 3; ++c)
            for (int i = 0; i < 3; ++i) normals[3 * v[c] + i] += n[i];
    }
    for (int64_t t = 0; t < n_triangles && outcome == DONE; ++t) {
        const int32_t* v = triangles + 3 * t;
        const double* const corners[4] = {vertices + 3 * v[0], vertices + 3 * v[1], vertices + 3 * v[2],
                                          vertices + 3 * v[2]};
        double n[3], smooth[3] = {0.0, 0.0, 0.0};
        normal_of(corners[0], corners[1], corners[2], n);
        if (dot(n, viewer) <= 0.0) continue;
        for (int c = 0; c < 3; ++c) {
            double own[3];
            memcpy(own, normals + 3 * v[c], sizeof own);
            normalise(own);
            for (int i = 0; i < 3; ++i) smooth[i] += own[i];
        }
        normalise(smooth);
        outcome = add(g, corners, place, shade(colour, smooth));
    }
    free(normals);
    return outcome;
}

int gallery_add_face(gallery* g, const double corners[4][3], const double* place, uint32_t colour) {
    const double* const all[4] = {corners[0], corners[1], corners[2], corners[3]};
    double n[3];
    normal_of(corners[0], corners[1], corners[2], n);
    if (dot(n, viewer) <= 0.0) return DONE;
    normalise(n);
    return add(g, all, place, shade(colour, n));
}

static int farther_first(const void* a, const void* b) {
    const gallery_polygon *p = a, *q = b;
    return (p->depth > q->depth) - (p->depth < q->depth);
}

int gallery_write(gallery* g, const char* folder, const char* name) {
    output_file file;
    if (output_open(&file, folder, name) != DONE) return FAILED;
    if (g->n > 0) qsort(g->polygons, (size_t)g->n, sizeof *g->polygons, farther_first);
    for (int64_t k = 0; k < g->n; ++k) {
        /* Two scans of two points: the second runs against the order around the polygon. */
        static const int order[4] = {0, 1, 3, 2};
        const gallery_polygon* p = &g->polygons[k];
        for (int c = 0; c < 4; ++c)
            fprintf(file.stream, c == 1 ? "%.5g %.5g %u\n\n" : "%.5g %.5g %u\n", p->corners[order[c]][0],
                    p->corners[order[c]][1], (unsigned)p->colour);
        fputs("\n\n", file.stream);
    }
    return output_commit(&file);
}
