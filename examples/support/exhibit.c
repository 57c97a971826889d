/* SPDX-License-Identifier: MIT
 * A design as an exhibit: numbers, surface, muscle cells. */
#include "exhibit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "census.h"
#include "say.h"
#include "stl.h"

#define MUSCLE_SHARE 0.25 /* of the stiffest cell of a category: what counts as muscle */
#define VEIL 0xccb0bcc4u

static int larger_first(const void* a, const void* b) {
    const double *x = a, *y = b;
    return (*x < *y) - (*x > *y);
}

/* 1 for the cells of the body and 0 for the others in inside [n], and the same of all that is simulated. The simulator
 * has the density already, as occupancy, which grows with it: the body is where the largest are, and interpolating
 * again would take as long as all the rest.
 */
static int find_body(const scene* s, const dqa_simulator_info* info, double* inside, double* simulated, int64_t n) {
    const int64_t n_active = info->n_active_cells;
    int32_t* cells = malloc((size_t)n_active * sizeof *cells);
    double* occupancy = malloc((size_t)n_active * 2 * sizeof *occupancy);
    int outcome = cells != NULL && occupancy != NULL ? DONE : say_no_memory();
    memset(inside, 0, (size_t)n * sizeof *inside);
    memset(simulated, 0, (size_t)n * sizeof *simulated);
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_mesh(s->simulator, NULL, 0, cells, n_active, occupancy, n_active),
                             "read the cells");
    for (int64_t c = 0; c < n_active && outcome == DONE; ++c) simulated[cells[c]] = 1.0;
    if (outcome == DONE && info->n_body_cells > 0) {
        double* sorted = occupancy + n_active;
        memcpy(sorted, occupancy, (size_t)n_active * sizeof *sorted);
        qsort(sorted, (size_t)n_active, sizeof *sorted, larger_first);
        for (int64_t c = 0; c < n_active; ++c) inside[cells[c]] = occupancy[c] >= sorted[info->n_body_cells - 1];
    }
    free(cells);
    free(occupancy);
    return outcome;
}

int exhibit_measure(exhibit* out, const scene* s, const int32_t cells[3]) {
    const int64_t n = (int64_t)cells[0] * cells[1] * cells[2];
    double* inside = malloc((size_t)n * sizeof *inside);
    double* other = malloc((size_t)n * sizeof *other); /* what is simulated, then a base */
    dqa_simulator_info info;
    int outcome = inside != NULL && other != NULL ? DONE : say_no_memory();
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_get_info(s->simulator, &info, sizeof info), "read the simulator");
    if (outcome == DONE) outcome = find_body(s, &info, inside, other, n);
    if (outcome == DONE) {
        out->volume = info.volume;
        out->body_cells = info.n_body_cells;
        out->simulated_cells = info.n_active_cells;
        out->parts = census_parts(inside, cells, &out->largest);
        out->parts_simulated = census_parts(other, cells, &out->largest_simulated);
        if (out->parts < 0 || out->parts_simulated < 0) outcome = FAILED;
    }
    out->overlap = -1.0;
    for (int32_t b = 0; b < 3 && outcome == DONE; ++b) {
        if (out->weights[b] < 1.0) continue;
        outcome = say_status(dqa_shape_space_get_base(s->space, b, other, n), "read a base");
        if (outcome == DONE) out->overlap = census_overlap(inside, other, n);
    }
    free(inside);
    free(other);
    return outcome;
}

int exhibit_draw_body(const scene* s, const double* place, uint32_t colour, gallery* bodies, gallery* veils,
                      const char* folder, const char* stl) {
    int64_t n_vertices = 0, n_triangles = 0;
    double* vertices = NULL;
    int32_t* triangles = NULL;
    int outcome = say_status(dqa_simulator_surface(s->simulator, NULL, 0, NULL, 0, &n_vertices, &n_triangles),
                             "read the surface");
    if (outcome != DONE) return outcome;
    vertices = malloc((size_t)n_vertices * 3 * sizeof *vertices);
    triangles = malloc((size_t)n_triangles * 3 * sizeof *triangles);
    if (vertices == NULL || triangles == NULL) outcome = say_no_memory();
    if (outcome == DONE)
        outcome = say_status(
            dqa_simulator_surface(s->simulator, vertices, 3 * n_vertices, triangles, 3 * n_triangles, NULL, NULL),
            "read the surface");
    if (outcome == DONE)
        outcome = gallery_add_surface(bodies, vertices, n_vertices, triangles, n_triangles, place, colour);
    /* Beside the muscles: a veil that lets them show through. */
    if (outcome == DONE)
        outcome = gallery_add_surface(veils, vertices, n_vertices, triangles, n_triangles, place, VEIL);
    if (outcome == DONE) outcome = stl_write(folder, stl, vertices, triangles, n_triangles);
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

static int read_muscles(const scene* s, muscle_cells* m) {
    dqa_simulator_info info;
    const dqa_simulator* simulator = s->simulator;
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
static int choose_cells(const scene* s, muscle_cells* m) {
    double most[16] = {0.0};
    for (int64_t c = 0; c < m->n_cells; ++c) m->category[c] = -1;
    for (int64_t k = 0; k < m->n_fibres; ++k) {
        dqa_signal_info signal;
        const int32_t c = m->cells[k];
        if (say_status(dqa_shape_space_signal(s->space, m->signals[k], &signal, sizeof signal), "read a signal") !=
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

int exhibit_draw_muscles(exhibit* of, const scene* s, const double* place, gallery* muscles) {
    /* Corner = 4 ix + 2 iy + iz; every face counter-clockwise from outside. */
    static const int faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    muscle_cells m;
    int outcome;
    memset(&m, 0, sizeof m);
    outcome = read_muscles(s, &m);
    if (outcome == DONE) outcome = choose_cells(s, &m);
    for (int64_t c = 0; c < m.n_cells && outcome == DONE; ++c) {
        const int32_t* nodes = m.nodes + 8 * c;
        const double y = 0.5 * (m.q[3 * nodes[0] + 1] + m.q[3 * nodes[7] + 1]);
        const uint32_t colour = m.category[c] == 0 ? 0xd0483cu : y > 0.0 ? 0x2f9e62u : 0x3a68c4u;
        if (m.category[c] < 0) continue;
        ++of->muscle_cells;
        for (int f = 0; f < 6 && outcome == DONE; ++f) {
            double corners[4][3];
            for (int k = 0; k < 4; ++k) memcpy(corners[k], m.q + 3 * nodes[faces[f][k]], sizeof corners[k]);
            outcome = gallery_add_face(muscles, (const double(*)[3])corners, place, colour);
        }
    }
    muscle_cells_free(&m);
    return outcome;
}
