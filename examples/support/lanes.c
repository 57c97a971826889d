/* SPDX-License-Identifier: MIT
 * Shaded polygons. The colours are worked out here and not by gnuplot, because they belong to the body: a fish is dark
 * above and light below at rest, and stays so when it bends. Light falls from above and from the viewer's left. */
#include "lanes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "output.h"
#include "say.h"

#define ROOM 0.04 /* of the floor's lines before and behind the swimmers, in lengths */

static const double belly[3] = {0.93, 0.94, 0.92};

int64_t lanes_frame(const motion* m, int lane) {
    return (m->n_frames - 1) * lane / (LANES - 1);
}

double lanes_y(const lanes_box* box, int lane) {
    return box->spacing * (0.5 * (LANES - 1) - lane);
}

double lanes_edge(const lanes_box* box) {
    return 0.5 * (LANES - 1) * box->spacing + fmax(1.02 * box->half_width, 0.3 * box->spacing);
}

double lanes_nose(const motion* m, int64_t frame) {
    const double* q = motion_frame(m, frame);
    double most = q[0];
    for (int64_t i = 1; i < m->n_vertices; ++i) most = fmax(most, q[3 * i]);
    return most;
}

/* Widens what the view covers by the point (x, y, z), projected as gnuplot's `set view` does. */
static void cover(lanes_box* box, double x, double y, double z) {
    const double degree = SCENE_PI / 180.0, a = LANES_VIEW_X * degree, b = LANES_VIEW_Z * degree;
    const double dx = x - 0.5 * (box->x_least + box->x_most), dz = z - 0.5 * (box->floor + box->top);
    const double across = dx * cos(b) + y * sin(b), upward = (y * cos(b) - dx * sin(b)) * cos(a) + dz * sin(a);
    box->left = fmin(box->left, across);
    box->right = fmax(box->right, across);
    box->below = fmin(box->below, upward);
    box->above = fmax(box->above, upward);
}

/* What the view has to cover: the swimmers in their lanes, the lanes' lines, and the start line. */
static void measure_view(lanes_box* box, const motion* const* motions, int n) {
    box->left = box->below = HUGE_VAL;
    box->right = box->above = -HUGE_VAL;
    for (int lane = 0; lane < LANES; ++lane) {
        const double y = lanes_y(box, lane);
        cover(box, box->x_least, y, box->floor);
        cover(box, box->x_most, y, box->floor);
        for (int k = 0; k < n; ++k) {
            const double* q = motion_frame(motions[k], lanes_frame(motions[k], lane));
            for (int64_t i = 0; i < motions[k]->n_vertices; ++i) cover(box, q[3 * i], q[3 * i + 1] + y, q[3 * i + 2]);
        }
    }
    for (int k = 0; k < n; ++k) {
        cover(box, lanes_nose(motions[k], 0), -lanes_edge(box), box->floor);
        cover(box, lanes_nose(motions[k], 0), lanes_edge(box), box->floor);
    }
}

void lanes_measure(lanes_box* box, const motion* const* motions, int n) {
    double bottom = HUGE_VAL, length;
    box->x_least = HUGE_VAL;
    box->x_most = box->top = -HUGE_VAL;
    box->half_width = 0.0;
    for (int k = 0; k < n; ++k) {
        for (int lane = 0; lane < LANES; ++lane) {
            const double* q = motion_frame(motions[k], lanes_frame(motions[k], lane));
            for (int64_t i = 0; i < motions[k]->n_vertices; ++i) {
                box->x_least = fmin(box->x_least, q[3 * i]);
                box->x_most = fmax(box->x_most, q[3 * i]);
                box->half_width = fmax(box->half_width, fabs(q[3 * i + 1]));
                bottom = fmin(bottom, q[3 * i + 2]);
                box->top = fmax(box->top, q[3 * i + 2]);
            }
        }
    }
    length = box->x_most - box->x_least;
    box->floor = bottom - 0.03 * length;
    /* A tall swimmer must not hide the one behind it: what its height covers on the slanted floor counts too. */
    box->spacing = fmax(2.2 * box->half_width, 1.0 * (box->top - box->floor));
    box->spacing = fmax(box->spacing, 0.22 * length);
    box->x_least -= ROOM * length;
    box->x_most += ROOM * length;
    measure_view(box, motions, n);
}

static void subtract(const double* a, const double* b, double* d) {
    for (int i = 0; i < 3; ++i) d[i] = a[i] - b[i];
}

static void cross(const double* a, const double* b, double* c) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double* a, const double* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalise(double* a) {
    const double length = sqrt(dot(a, a));
    for (int i = 0; i < 3 && length > 0.0; ++i) a[i] /= length;
}

static void triangle_normal(const double* q, const int32_t* corner, double* n) {
    double u[3], v[3];
    subtract(q + 3 * corner[1], q + 3 * corner[0], u);
    subtract(q + 3 * corner[2], q + 3 * corner[0], v);
    cross(u, v, n);
}

/* Unit normals at the vertices, weighted by area: they make a coarse surface look round. */
static void vertex_normals(const motion* m, const double* q, double* normals) {
    memset(normals, 0, (size_t)m->n_vertices * 3 * sizeof *normals);
    for (int64_t t = 0; t < m->n_triangles; ++t) {
        double n[3];
        triangle_normal(q, m->triangles + 3 * t, n);
        for (int c = 0; c < 3; ++c)
            for (int i = 0; i < 3; ++i) normals[3 * m->triangles[3 * t + c] + i] += n[i];
    }
    for (int64_t i = 0; i < m->n_vertices; ++i) normalise(normals + 3 * i);
}

static unsigned channel(double value) {
    return (unsigned)(255.0 * fmin(1.0, fmax(0.0, value)) + 0.5);
}

static unsigned shade(const double* rest_normal, const double* normal, const double* view, unsigned back) {
    static const double sun[3] = {-0.25, -0.45, 0.857};
    const double upward = fmin(1.0, fmax(0.0, 0.5 + 1.1 * rest_normal[2]));
    const double side = upward * upward * (3.0 - 2.0 * upward);
    const double light = 0.45 + 0.55 * fmax(0.0, 0.3 + 0.7 * dot(normal, sun));
    double half[3], gleam;
    unsigned colour = 0;
    for (int i = 0; i < 3; ++i) half[i] = sun[i] + view[i];
    normalise(half);
    gleam = 0.22 * pow(fmax(0.0, dot(normal, half)), 24.0);
    for (int i = 0; i < 3; ++i) {
        const double dark = (double)(back >> (16 - 8 * i) & 0xffu) / 255.0;
        colour = colour << 8 | channel((side * dark + (1.0 - side) * belly[i]) * light + gleam);
    }
    return colour;
}

/* A triangle as a quadrangle with two equal corners, which every gnuplot draws `with pm3d` in a colour of its own (its
 * `with polygons` learned that only after 5.4): two scans of two points, then two empty lines. */
static void triangle(FILE* stream, const double* q, const int32_t* corner, double y, const double* flat,
                     unsigned colour) {
    for (int c = 0; c < 4; ++c) {
        const double* p = q + 3 * corner[c < 3 ? c : 2];
        fprintf(stream, c == 1 ? "%.5g %.5g %.5g %u\n\n" : "%.5g %.5g %.5g %u\n", p[0], p[1] + y,
                flat != NULL ? *flat : p[2], colour);
    }
    fputs("\n\n", stream);
}

static void write_shadows(FILE* stream, const motion* m, const lanes_box* box) {
    for (int lane = 0; lane < LANES; ++lane) {
        const double* q = motion_frame(m, lanes_frame(m, lane));
        for (int64_t t = 0; t < m->n_triangles; ++t) {
            double n[3];
            triangle_normal(q, m->triangles + 3 * t, n);
            if (n[2] > 0.0) triangle(stream, q, m->triangles + 3 * t, lanes_y(box, lane), &box->floor, 0xd2dde2u);
        }
    }
}

static void write_bodies(FILE* stream, const motion* m, const lanes_box* box, unsigned back, const double* rest_normals,
                         double* normals) {
    const double degree = SCENE_PI / 180.0, a = LANES_VIEW_X * degree, b = LANES_VIEW_Z * degree;
    const double view[3] = {sin(a) * sin(b), -sin(a) * cos(b), cos(a)};
    for (int lane = 0; lane < LANES; ++lane) {
        const double* q = motion_frame(m, lanes_frame(m, lane));
        vertex_normals(m, q, normals);
        for (int64_t t = 0; t < m->n_triangles; ++t) {
            const int32_t* corner = m->triangles + 3 * t;
            double facing[3], rest[3] = {0.0, 0.0, 0.0}, mean[3] = {0.0, 0.0, 0.0};
            triangle_normal(q, corner, facing);
            if (dot(facing, view) <= 0.0) continue; /* its far side */
            for (int c = 0; c < 3; ++c) {
                for (int i = 0; i < 3; ++i) {
                    rest[i] += rest_normals[3 * corner[c] + i];
                    mean[i] += normals[3 * corner[c] + i];
                }
            }
            normalise(rest);
            normalise(mean);
            triangle(stream, q, corner, lanes_y(box, lane), NULL, shade(rest, mean, view, back));
        }
    }
}

int lanes_write(const motion* m, const lanes_box* box, unsigned back, const char* folder, const char* name,
                const char* shadow_name) {
    double* rest_normals = malloc((size_t)m->n_vertices * 3 * sizeof(double));
    double* normals = malloc((size_t)m->n_vertices * 3 * sizeof(double));
    output_file file;
    int outcome;
    if (rest_normals == NULL || normals == NULL) {
        free(rest_normals);
        free(normals);
        return say_no_memory();
    }
    outcome = output_open(&file, folder, shadow_name);
    if (outcome == DONE) {
        write_shadows(file.stream, m, box);
        outcome = output_commit(&file);
    }
    if (outcome == DONE) outcome = output_open(&file, folder, name);
    if (outcome == DONE) {
        vertex_normals(m, motion_frame(m, 0), rest_normals);
        write_bodies(file.stream, m, box, back, rest_normals, normals);
        outcome = output_commit(&file);
    }
    free(rest_normals);
    free(normals);
    return outcome;
}
