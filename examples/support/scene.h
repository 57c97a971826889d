/* SPDX-License-Identifier: MIT
 * The swimmer in its water: shape space, simulator, controller and tape, and the loss with its gradient. */
#ifndef DQA_EXAMPLES_SCENE_H
#define DQA_EXAMPLES_SCENE_H

#include "diffaqua.h"
#include "options.h"
#include "progress.h"
#include "run.h"

#define SCENE_PI 3.14159265358979323846
#define SCENE_OMEGA0 (5.0 * SCENE_PI) /* rad/s: a period of 12 steps of 1/30 s */

#define SCENE_PROOF_STEPS 5 /* of the rollout whose gradient is checked */

typedef struct scene {
    dqa_cancel_token* cancel;
    dqa_shape_space* space;
    dqa_simulator* simulator;
    dqa_controller* controller;
    dqa_tape* tape;
    int64_t n_weights;
    int64_t n_control;
    int32_t n_terms; /* of the loss */
    dqa_objective_term terms[OBJECTIVE_KINDS];
    int64_t steps;
    double time_step;     /* s */
    double network_scale; /* of a network's first weights, relative to the library's */
    double threshold;     /* of the simulated cells */
    double model_error;   /* its estimated error at the initial design; 0: none was asked for */
} scene;

/* Reads the meshes and builds everything. Every function here returns DONE, FAILED (said) or INTERRUPTED. */
int scene_create(scene* s, const options* o, progress* p);
void scene_free(scene* s);
/* Makes a network the controller, with the temporal encoding among its inputs or without, and with its first
 * parameters. */
int scene_use_network(scene* s, int temporal_encoding);
/* Steps and loss of these options from here on. */
int scene_take_task(scene* s, const options* o);
/* The water flows with this velocity (m/s) from here on. */
int scene_set_current(scene* s, const double velocity[3]);
/* Makes x = (weights, controller parameters) the current design, at rest. */
int scene_set(scene* s, const double* x, progress* p);
/* Swims: scene_set, then a recorded rollout. */
int scene_swim(scene* s, const double* x, progress* p);
/* The same; `watch` is called with `user_data` after every step and may read the simulator. */
int scene_swim_watched(scene* s, const double* x, progress* p, dqa_progress watch, void* user_data);
/* Tells sets of signals apart: two scenes of the same number have the same muscles to drive, in the same order, so that
 * the parameters of a controller mean the same in both. */
int scene_signals(const scene* s, uint64_t* number);
/* Loss of x alone: fills *row but its gradients, iteration, stage and simulations. A design whose simulation fails is
 * said and has an infinite loss. */
int scene_try(scene* s, const double* x, history_row* row, progress* p);
/* Loss of x and its gradient [n_weights + n_control]; fills all of *row but its iteration, stage and simulations. */
int scene_evaluate(scene* s, const double* x, double* gradient, history_row* row, progress* p);
/* Proves the gradient of the current design (DQA_WRT_WEIGHTS or _CONTROL, in words `of`) by the library's finite
 * differences, which want far tighter solves than an optimisation; if those fail it is said and noted in the proof, but
 * is no failure. */
int scene_prove(scene* s, int32_t with_respect_to, const char* of, gradient_proof* proof, progress* p);

#endif
