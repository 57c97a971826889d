/* SPDX-License-Identifier: MIT
 * The state of an optimisation and its step: Adam, then projection. The rates are those of the paper's experiments;
 * omega is measured in units of its natural frequency, because 0.05 rad/s against 15.7 rad/s would move nothing. */
#include "run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "say.h"

#define RATE 0.05
#define RATE_MLP 0.01     /* of a network, thousands of whose parameters act together */
#define CALM_ITERATIONS 4 /* consecutive small changes that count as convergence */
#define CALM_CHANGE 1e-6
#define STALL_ITERATIONS 4 /* without a gain: what a coarser stage had to tell has been told */
#define STALL_GAIN 0.01    /* relative to the best loss */

static double* new_numbers(int64_t n) {
    return calloc((size_t)(n > 0 ? n : 1), sizeof(double));
}

int run_create(run* r, const options* o, int64_t n_weights, const double* theta, int64_t n_control, double omega0) {
    const double network_rate = o->form->network_rate > 0.0 ? o->form->network_rate : RATE_MLP;
    const double weights_rate = o->form->weights_rate > 0.0 ? o->form->weights_rate : RATE;
    memset(r, 0, sizeof *r);
    r->n_weights = n_weights;
    r->n_control = n_control;
    r->n = n_weights + n_control;
    r->moves = o->fixed_control ? RUN_WEIGHTS : RUN_BOTH;
    r->mlp = o->mlp;
    r->loss = &o->loss;
    r->n_stages = o->plan.n_stages > 0 ? o->plan.n_stages : 1;
    r->omega0 = omega0;
    r->best_loss = HUGE_VAL;
    r->x = new_numbers(r->n);
    r->first_moment = new_numbers(r->n);
    r->second_moment = new_numbers(r->n);
    r->rates = new_numbers(r->n);
    r->units = new_numbers(r->n);
    r->best_x = new_numbers(r->n);
    r->gradient = new_numbers(r->n);
    if (r->units == NULL || r->x == NULL || r->first_moment == NULL || r->second_moment == NULL || r->rates == NULL ||
        r->best_x == NULL || r->gradient == NULL) {
        run_free(r);
        return say_no_memory();
    }
    memcpy(r->x, o->weights, (size_t)n_weights * sizeof(double));
    memcpy(r->x + n_weights, theta, (size_t)n_control * sizeof(double));
    for (int64_t i = 0; i < n_weights; ++i) r->rates[i] = weights_rate;
    for (int64_t i = 0; i < r->n; ++i)
        r->units[i] = !r->mlp && i >= n_weights && (i - n_weights) % 3 == 1 ? omega0 : 1.0;
    for (int64_t i = 0; i < n_control; ++i)
        r->rates[n_weights + i] = r->mlp ? network_rate : i % 3 == 1 ? RATE * omega0 : RATE;
    return DONE;
}

void run_free(run* r) {
    free(r->x);
    free(r->first_moment);
    free(r->second_moment);
    free(r->rates);
    free(r->units);
    free(r->best_x);
    free(r->gradient);
    free(r->rows);
    free(r->row_x);
    memset(r, 0, sizeof *r);
}

int run_reserve(run* r) {
    if (r->iteration >= r->capacity) {
        const int64_t capacity = r->capacity > 0 ? 2 * r->capacity : 32;
        history_row* rows = realloc(r->rows, (size_t)capacity * sizeof *rows);
        double* row_x;
        if (rows == NULL) return say_no_memory();
        r->rows = rows;
        row_x = realloc(r->row_x, (size_t)(capacity * r->n) * sizeof *row_x);
        if (row_x == NULL) return say_no_memory();
        r->row_x = row_x;
        r->capacity = capacity;
    }
    return DONE;
}

static double clamp(double value, double least, double most) {
    return value < least ? least : value > most ? most : value;
}

int run_record(run* r, const history_row* row) {
    int outcome = run_reserve(r);
    if (outcome != DONE) return outcome;
    r->rows[r->iteration] = *row;
    memcpy(r->row_x + r->iteration * r->n, r->x, (size_t)r->n * sizeof(double));
    ++r->iteration;
    if (row->loss < r->best_loss) {
        r->best_loss = row->loss;
        r->best_iteration = r->iteration;
        memcpy(r->best_x, r->x, (size_t)r->n * sizeof(double));
    }
    return DONE;
}

int run_project(const run* r, double* x) {
    int outcome = say_status(dqa_project_simplex(x, r->n_weights), "project the weights onto the simplex");
    for (int64_t i = 0; i < r->n_control && !r->mlp; i += 3) {
        double* theta = x + r->n_weights + i;
        theta[0] = clamp(theta[0], 0.0, 1.0);
        /* Beyond half the sampling rate a sine is another, slower sine; zero would stop the swimmer for good. */
        theta[1] = clamp(theta[1], 0.05 * r->omega0, 6.0 * r->omega0);
    }
    return outcome;
}

/* One Adam step of the unknowns that this iteration moves. */
static int move(run* r, const double* gradient) {
    const int64_t finished = r->iteration - r->stage_first;
    const int in_turn = r->moves == RUN_IN_TURN;
    const int control = r->moves == RUN_CONTROL || (in_turn && finished % 2 == 0);
    const int64_t first = control ? r->n_weights : 0;
    const int64_t end = r->moves == RUN_WEIGHTS || (in_turn && !control) ? r->n_weights : r->n;
    return say_status(dqa_adam_step(r->x + first, gradient + first, r->rates + first, r->first_moment + first,
                                    r->second_moment + first, end - first, in_turn ? (finished + 1) / 2 : finished),
                      "take an Adam step");
}

int run_advance(run* r, const history_row* row, const double* gradient) {
    int outcome = run_record(r, row);
    if (outcome != DONE) return outcome;
    if (gradient != r->gradient) memcpy(r->gradient, gradient, (size_t)r->n * sizeof(double));
    outcome = move(r, gradient);
    return outcome == DONE ? run_project(r, r->x) : outcome;
}

int run_repeats(const run* r, history_row* row) {
    if (r->iteration == r->stage_first) return 0;
    /* The design stays while the other group has its turn, or where a projection holds it. */
    if (memcmp(r->x, r->row_x + (r->iteration - 1) * r->n, (size_t)r->n * sizeof(double)) != 0) return 0;
    *row = r->rows[r->iteration - 1];
    row->seconds = 0.0;
    row->newton_iterations = row->linear_iterations = row->adjoint_iterations = 0;
    return 1;
}

int run_stalled(const run* r) {
    double before = HUGE_VAL;
    const int64_t last = r->iteration - STALL_ITERATIONS;
    if (last <= r->stage_first) return 0;
    for (int64_t k = r->stage_first; k < last; ++k) before = fmin(before, r->rows[k].loss);
    return before - r->best_loss <= STALL_GAIN * fabs(before);
}

void run_next_stage(run* r) {
    if (r->best_iteration > 0) memcpy(r->x, r->best_x, (size_t)r->n * sizeof(double));
    /* What Adam has learned about the size of gradients holds for the coarser grid alone. */
    memset(r->first_moment, 0, (size_t)r->n * sizeof(double));
    memset(r->second_moment, 0, (size_t)r->n * sizeof(double));
    r->best_loss = HUGE_VAL;
    r->best_iteration = 0;
    r->stage_first = r->iteration;
    ++r->stage;
}

int run_converged(const run* r) {
    if (r->iteration - r->stage_first <= CALM_ITERATIONS) return 0;
    for (int64_t k = r->iteration - CALM_ITERATIONS; k < r->iteration; ++k) {
        const double *now = r->row_x + k * r->n, *before = now - r->n;
        if (fabs(r->rows[k].loss - r->rows[k - 1].loss) > CALM_CHANGE) return 0;
        for (int64_t i = 0; i < r->n; ++i) {
            const double unit = r->rates[i] / RATE;
            if (fabs(now[i] - before[i]) > CALM_CHANGE * unit) return 0;
        }
    }
    return 1;
}
