/* SPDX-License-Identifier: MIT */
#include "report_motion.h"

#include <math.h>
#include <string.h>

#include "base64.h"

#define LEVELS 16383.0
#define MOST_BYTES 1600000 /* of coded positions of a swimmer, before base64 adds a third */

typedef struct coding {
    double origin[3], quantum;
    int64_t stride; /* frames from one kept frame to the next */
} coding;

static int64_t kept_frames(const motion* m, const coding* c) {
    return (m->n_frames - 2 + c->stride) / c->stride + 1;
}

/* The frame behind kept frame k; the last one is always kept. */
static int64_t frame_of(const motion* m, const coding* c, int64_t k) {
    const int64_t frame = k * c->stride;
    return frame < m->n_frames ? frame : m->n_frames - 1;
}

static void measure(coding* c, const motion* m) {
    const int64_t n = m->n_frames * m->n_vertices;
    double most = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (int64_t i = 0; i < n; ++i) {
            low = fmin(low, m->frames[3 * i + axis]);
            high = fmax(high, m->frames[3 * i + axis]);
        }
        c->origin[axis] = low;
        most = fmax(most, high - low);
    }
    c->quantum = most > 0.0 ? most / LEVELS : 1.0;
    c->stride = 1;
}

/* Whole number i of kept frame k. */
static int64_t level(const motion* m, const coding* c, int64_t k, int64_t i) {
    const double x = motion_frame(m, frame_of(m, c, k))[i];
    return (int64_t)floor((x - c->origin[i % 3]) / c->quantum + 0.5);
}

/* Codes all positions into `b`, or only counts their bytes (NULL). */
static int64_t code(const motion* m, const coding* c, base64* b) {
    const int64_t n = 3 * m->n_vertices, frames = kept_frames(m, c);
    int64_t bytes = 0;
    for (int64_t k = 0; k < frames; ++k) {
        for (int64_t i = 0; i < n; ++i) {
            const int64_t now = level(m, c, k, i);
            int64_t guess = 0, left;
            uint64_t rest;
            if (k == 0 && i >= 3) guess = level(m, c, k, i - 3);
            if (k == 1) guess = level(m, c, 0, i);
            if (k >= 2) guess = 2 * level(m, c, k - 1, i) - level(m, c, k - 2, i);
            left = now - guess;
            rest = left < 0 ? 2 * (uint64_t)(-left) - 1 : 2 * (uint64_t)left;
            do {
                const unsigned char byte = (unsigned char)((rest & 0x7fu) | (rest > 0x7fu ? 0x80u : 0u));
                if (b != NULL) base64_put(b, &byte, 1);
                ++bytes;
                rest >>= 7;
            } while (rest != 0);
        }
    }
    return bytes;
}

static void write_triangles(json* j, const motion* m) {
    FILE* f = json_value(j, "triangles");
    base64 b;
    fputc('"', f);
    base64_begin(&b, f);
    for (int64_t i = 0; i < 3 * m->n_triangles; ++i) {
        const uint32_t index = (uint32_t)m->triangles[i];
        unsigned char bytes[4];
        for (int k = 0; k < 4; ++k) bytes[k] = (unsigned char)(index >> (8 * k));
        base64_put(&b, bytes, sizeof bytes);
    }
    base64_end(&b);
    fputc('"', f);
}

static void write_integers(json* j, const char* key, const int32_t* x, int64_t n) {
    FILE* f = json_value(j, key);
    for (int64_t i = 0; i < n; ++i) fprintf(f, i > 0 ? ",%d" : "[%d", (int)x[i]);
    fputs(n > 0 ? "]" : "[]", f);
}

static void write_pulls(json* j, const activity* a) {
    const int32_t n = a->first[a->n_vertices];
    FILE* f;
    write_integers(j, "first_pull", a->first, a->n_vertices + 1);
    write_integers(j, "pull_signal", a->signal, n);
    f = json_value(j, "pull");
    for (int32_t i = 0; i < n; ++i) fprintf(f, i > 0 ? ",%.3g" : "[%.3g", a->pull[i]);
    fputs(n > 0 ? "]" : "[]", f);
}

/* Rows of steps, `width` numbers each, as `width` lists of those steps that end at kept frames. */
static void write_steps(json* j, const char* key, const motion* m, const coding* c, const double* rows, int32_t width) {
    const int64_t frames = kept_frames(m, c);
    json_open(j, key, '[');
    for (int32_t i = 0; i < width; ++i) {
        FILE* f = json_value(j, NULL);
        fputc('[', f);
        for (int64_t k = 1; k < frames; ++k)
            fprintf(f, k > 1 ? ",%.6g" : "%.6g", rows[(frame_of(m, c, k) - 1) * width + i]);
        fputc(']', f);
    }
    json_close(j, ']');
}

void report_motion_write(json* j, const motion* m) {
    coding c;
    base64 b;
    FILE* f;
    measure(&c, m);
    while (c.stride < m->n_frames && code(m, &c, NULL) > MOST_BYTES) ++c.stride;
    json_integer(j, "vertices", m->n_vertices);
    json_integer(j, "elements", m->n_triangles);
    json_integer(j, "frames", m->n_frames);
    json_number(j, "travel", -m->loss);
    f = json_value(j, "times");
    for (int64_t k = 0; k < kept_frames(m, &c); ++k)
        fprintf(f, k > 0 ? ",%.9g" : "[%.9g", (double)frame_of(m, &c, k) * m->time_step);
    fputc(']', f);
    json_numbers(j, "origin", c.origin, 3, 1);
    json_number(j, "quantum", c.quantum);
    write_triangles(j, m);
    f = json_value(j, "positions");
    fputc('"', f);
    base64_begin(&b, f);
    (void)code(m, &c, &b);
    base64_end(&b);
    fputc('"', f);
    write_pulls(j, &m->work);
    write_steps(j, "signals", m, &c, m->work.signals, m->work.n_signals);
    write_steps(j, "current", m, &c, m->work.current, 3);
}
