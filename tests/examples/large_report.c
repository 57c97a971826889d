/* SPDX-License-Identifier: MIT
 * large_report FOLDER VERTICES FRAMES writes a report with two swimmers of any size, whose vertex i is at frame k at
 *   x = s + k / 100, y = 0.1 s^2 sin(0.5 k - 5 s), z = 0.05 cos i,  s = i / vertices;
 * a simulation of that size would take minutes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/report.h"
#include "support/say.h"

static int fill(motion* m, int64_t n_vertices, int64_t n_frames) {
    memset(m, 0, sizeof *m);
    m->n_vertices = n_vertices;
    m->n_triangles = n_vertices - 2;
    m->n_frames = n_frames;
    m->time_step = 1.0 / 30.0;
    m->triangles = malloc((size_t)m->n_triangles * 3 * sizeof *m->triangles);
    m->frames = malloc((size_t)(n_frames * n_vertices) * 3 * sizeof *m->frames);
    m->work.n_steps = n_frames - 1;
    m->work.n_vertices = n_vertices;
    m->work.current = calloc((size_t)n_frames * 3, sizeof *m->work.current);
    m->work.first = calloc((size_t)n_vertices + 1, sizeof *m->work.first);
    if (m->triangles == NULL || m->frames == NULL || m->work.current == NULL || m->work.first == NULL)
        return say_no_memory();
    for (int64_t t = 0; t < m->n_triangles; ++t)
        for (int c = 0; c < 3; ++c) m->triangles[3 * t + c] = (int32_t)(t + c);
    for (int64_t k = 0; k < n_frames; ++k) {
        for (int64_t i = 0; i < n_vertices; ++i) {
            const double s = (double)i / (double)n_vertices;
            double* x = m->frames + 3 * (k * n_vertices + i);
            x[0] = s + 0.01 * (double)k;
            x[1] = 0.1 * s * s * sin(0.5 * (double)k - 5.0 * s);
            x[2] = 0.05 * cos((double)i);
        }
    }
    return DONE;
}

int main(int argc, char** argv) {
    motion m;
    report page;
    int outcome;
    say_program("large_report");
    if (argc != 4 || atoi(argv[2]) < 3 || atoi(argv[3]) < 2) {
        say("usage: large_report FOLDER VERTICES FRAMES");
        return USAGE;
    }
    outcome = fill(&m, atoi(argv[2]), atoi(argv[3]));
    if (outcome == DONE) outcome = report_open(&page, argv[1], "large_report", "A large report", "", NULL);
    if (outcome == DONE) {
        report_swimmer(&page, "initial", &m);
        report_swimmer(&page, "optimised", &m);
        outcome = report_close(&page);
    }
    motion_free(&m);
    return outcome;
}
