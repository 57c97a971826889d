/* SPDX-License-Identifier: MIT
 * Functions that the library calls: each asks diffaqua_callback.m, which calls the function of the given number. What
 * that one throws never crosses the library: diffaqua_callback keeps it and tells to stop, and it is thrown again where
 * the call returns (+diffaqua/+internal/call.m). user_data is the number, not a pointer. */
#include <pthread.h>
#include <string.h>

#include "gateway.h"

enum { MOST_ARGUMENTS = 8 };

void* user_data_of(int64_t id, int dims) {
    return (void*)(intptr_t)(id * 4 + dims); /* dims in [0, 3]: callbacks of the current are not told */
}

static int64_t id_of(const void* user_data) {
    return (int64_t)((intptr_t)user_data / 4);
}

static mxArray* vector(const double* values, int64_t n) {
    mxArray* array = mxCreateDoubleMatrix((mwSize)n, 1, mxREAL);
    if (n > 0 && values != NULL) memcpy(mxGetPr(array), values, (size_t)n * sizeof *values);
    return array;
}

/* Calls [stop, first, second] = diffaqua_callback(what, id, arguments ...), which returns vectors of the lengths that
 * are wanted. Copies them; 1 where it says to stop or fails. */
static int32_t ask(const char* what, int64_t id, mxArray** arguments, int n, double* first, int64_t n_first,
                   double* second, int64_t n_second) {
    mxArray *in[MOST_ARGUMENTS], *out[3] = {NULL, NULL, NULL};
    double* const to[3] = {NULL, first, second};
    const int64_t lengths[3] = {1, n_first, n_second};
    mxArray* problem;
    int32_t stop = 1;
    in[0] = mxCreateString(what);
    in[1] = mxCreateDoubleScalar((double)id);
    for (int k = 0; k < n; ++k) in[2 + k] = arguments[k];
    problem = mexCallMATLABWithTrap(3, out, 2 + n, in, "diffaqua_callback");
    if (problem == NULL && out[0] != NULL && mxIsDouble(out[0]) && mxGetNumberOfElements(out[0]) == 1) {
        stop = mxGetScalar(out[0]) != 0.0;
        for (int k = 1; k < 3 && !stop; ++k) {
            if (lengths[k] == 0) continue;
            if (out[k] == NULL || !mxIsDouble(out[k]) || (int64_t)mxGetNumberOfElements(out[k]) != lengths[k])
                stop = 1;
            else
                memcpy(to[k], mxGetPr(out[k]), (size_t)lengths[k] * sizeof(double));
        }
    }
    for (int k = 0; k < 2 + n; ++k) mxDestroyArray(in[k]);
    for (int k = 0; k < 3; ++k)
        if (out[k] != NULL) mxDestroyArray(out[k]);
    if (problem != NULL) mxDestroyArray(problem);
    return stop;
}

static int32_t on_progress(int64_t done, int64_t total, void* user_data) {
    mxArray* arguments[2] = {mxCreateDoubleScalar((double)done), mxCreateDoubleScalar((double)total)};
    return ask("progress", id_of(user_data), arguments, 2, NULL, 0, NULL, 0);
}

dqa_progress progress_of(int64_t id) {
    return id == 0 ? NULL : on_progress;
}

static int32_t on_current(double time, double* current, void* user_data) {
    const int dims = (int)((intptr_t)user_data % 4);
    mxArray* arguments[2] = {mxCreateDoubleScalar(dims), mxCreateDoubleScalar(time)};
    return ask("current", id_of(user_data), arguments, 2, current, dims, NULL, 0);
}

static int32_t on_current_pullback(double time, const double* current_bar, void* user_data) {
    mxArray* arguments[2] = {mxCreateDoubleScalar(time), vector(current_bar, (intptr_t)user_data % 4)};
    return ask("current_pullback", id_of(user_data), arguments, 2, NULL, 0, NULL, 0);
}

static int32_t on_evaluate(int64_t step, double time, const double* sensors, int64_t n_sensors, const double* theta,
                           int64_t n_parameters, double* actuation, int64_t n_signals, void* user_data) {
    mxArray* arguments[5] = {mxCreateDoubleScalar((double)n_signals), mxCreateDoubleScalar((double)step),
                             mxCreateDoubleScalar(time), vector(sensors, n_sensors), vector(theta, n_parameters)};
    return ask("evaluate", id_of(user_data), arguments, 5, actuation, n_signals, NULL, 0);
}

static int32_t on_pullback(int64_t step, double time, const double* sensors, int64_t n_sensors, const double* theta,
                           int64_t n_parameters, const double* actuation_bar, int64_t n_signals, double* theta_bar,
                           double* sensors_bar, void* user_data) {
    mxArray* arguments[5] = {mxCreateDoubleScalar((double)step), mxCreateDoubleScalar(time), vector(sensors, n_sensors),
                             vector(theta, n_parameters), vector(actuation_bar, n_signals)};
    return ask("pullback", id_of(user_data), arguments, 5, theta_bar, n_parameters, sensors_bar, n_sensors);
}

const dqa_current current_callback = on_current;
const dqa_current_pullback current_pullback_callback = on_current_pullback;
const dqa_control_evaluate evaluate_callback = on_evaluate;
const dqa_control_pullback pullback_callback = on_pullback;

/* ------------------------------------------------------------------ log */
static pthread_t log_thread;

/* The interpreter takes calls on its own thread alone: messages of others are left out. */
static void on_log(int32_t level, const char* message, void* user_data) {
    mxArray* arguments[2];
    if (!pthread_equal(pthread_self(), log_thread)) return;
    arguments[0] = mxCreateDoubleScalar(level);
    arguments[1] = mxCreateString(message);
    ask("log", id_of(user_data), arguments, 2, NULL, 0, NULL, 0);
}

void set_log(call* c, int64_t id, int32_t level) {
    log_thread = pthread_self();
    check(c, dqa_set_log_handler(id == 0 ? NULL : on_log, level, user_data_of(id, 0)));
}
