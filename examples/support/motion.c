/* SPDX-License-Identifier: MIT
 * The surface of a swimmer over time, read from the tape of a rollout. */
#include "motion.h"

#include <stdlib.h>
#include <string.h>

#include "say.h"

static int allocate(motion* m) {
    if (m->n_vertices < 3 || m->n_triangles < 1) {
        say("the swimmer has no surface: its density is nowhere above half its peak");
        return FAILED;
    }
    m->triangles = malloc((size_t)m->n_triangles * 3 * sizeof *m->triangles);
    m->frames = malloc((size_t)m->n_frames * (size_t)m->n_vertices * 3 * sizeof *m->frames);
    return m->triangles != NULL && m->frames != NULL ? DONE : say_no_memory();
}

int motion_record(motion* m, scene* s, const double* x, progress* p) {
    dqa_objective_term term;
    int outcome;
    memset(m, 0, sizeof *m);
    m->n_frames = s->steps + 1;
    m->time_step = s->time_step;
    outcome = activity_begin(&m->work, s, p);
    if (outcome == DONE) outcome = scene_swim_watched(s, x, p, activity_watch, &m->work);
    if (outcome == DONE) outcome = say_status(dqa_objective_term_init(&term, sizeof term), "set up the objective");
    if (outcome == DONE) {
        term.kind = DQA_OBJECTIVE_TRAVEL;
        term.weight = 1.0;
        outcome = say_status(dqa_tape_objective(s->tape, &term, 1, &m->loss, NULL), "evaluate the loss");
    }
    if (outcome == DONE)
        outcome =
            say_status(dqa_tape_objective(s->tape, s->terms, s->n_terms, &m->objective, NULL), "evaluate the loss");
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_surface(s->simulator, NULL, 0, NULL, 0, &m->n_vertices, &m->n_triangles),
                             "measure the surface");
    if (outcome == DONE) outcome = allocate(m);
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_surface(s->simulator, m->frames, 3 * m->n_vertices, m->triangles,
                                                   3 * m->n_triangles, NULL, NULL),
                             "read the surface");
    for (int64_t k = 0; k < m->n_frames && outcome == DONE; ++k)
        outcome = say_status(dqa_tape_get_surface(s->tape, k, m->frames + k * m->n_vertices * 3, 3 * m->n_vertices),
                             "read the surface of a step");
    if (outcome == DONE) outcome = activity_end(&m->work, s, m->frames, m->n_vertices);
    if (outcome != DONE) motion_free(m);
    return outcome;
}

void motion_free(motion* m) {
    free(m->triangles);
    free(m->frames);
    activity_free(&m->work);
    memset(m, 0, sizeof *m);
}

const double* motion_frame(const motion* m, int64_t frame) {
    return m->frames + frame * m->n_vertices * 3;
}
