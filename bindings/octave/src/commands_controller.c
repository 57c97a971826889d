/* SPDX-License-Identifier: MIT
 * Commands of controllers, and those that help optimisers. Names and arguments are those of diffaqua.h; outputs become
 * results, counts of elements are those of the arrays. */
#include <string.h>

#include "gateway.h"

/* ------------------------------------------------------------------ controllers */
static dqa_controller* controller_of(call* c) {
    return object(c, 0, "controller", CONTROLLER);
}

static dqa_controller_info info_of(call* c, const dqa_controller* controller) {
    dqa_controller_info info;
    check(c, dqa_controller_get_info(controller, &info, sizeof info));
    return info;
}

/* (n_signals, time_step) */
static void create_sinusoid(call* c) {
    dqa_controller* controller;
    check(c, dqa_controller_create_sinusoid(index_of(c, 0, "n_signals"), number(c, 1, "time_step"), &controller));
    give_object(c, CONTROLLER, controller);
}

/* (options) */
static void create_mlp(call* c) {
    dqa_mlp_options options;
    dqa_controller* controller;
    check(c, dqa_mlp_options_init(&options, sizeof options));
    fill(c, 0, "dqa_mlp_options", &options);
    check(c, dqa_controller_create_mlp(&options, &controller));
    give_object(c, CONTROLLER, controller);
}

/* (options, theta, id, whether there is a pullback) */
static void create_callback(call* c) {
    dqa_callback_controller_options options;
    dqa_controller* controller;
    shape s = axes1(-1);
    const double* theta = optional_doubles(c, 1, "theta", &s);
    check(c, dqa_callback_controller_options_init(&options, sizeof options));
    fill(c, 0, "dqa_callback_controller_options", &options);
    options.evaluate = evaluate_callback;
    options.pullback = whole(c, 3, "has_pullback") ? pullback_callback : NULL;
    options.user_data = user_data_of(whole(c, 2, "id"), 0);
    check(c, dqa_controller_create_callback(&options, theta, count(&s), &controller));
    give_object(c, CONTROLLER, controller);
}

static void load(call* c) {
    dqa_controller* controller;
    check(c, dqa_controller_load(text(c, 0, "path"), &controller));
    give_object(c, CONTROLLER, controller);
}

static void save(call* c) {
    check(c, dqa_controller_save(controller_of(c), text(c, 1, "path")));
}

static void get_info(call* c) {
    const dqa_controller_info info = info_of(c, controller_of(c));
    give_record(c, "dqa_controller_info", &info);
}

static void n_parameters(call* c) {
    int64_t n = 0;
    check(c, dqa_controller_n_parameters(controller_of(c), &n));
    give_number(c, (double)n);
}

static void get_parameters(call* c) {
    dqa_controller* controller = controller_of(c);
    const shape s = axes1(info_of(c, controller).n_parameters);
    double* theta = room(&s);
    check(c, dqa_controller_get_parameters(controller, theta, count(&s)));
    give_doubles(c, theta, s);
}

/* (controller, theta) */
static void set_parameters(call* c) {
    dqa_controller* controller = object_to_change(c, 0, "controller", CONTROLLER);
    shape s = axes1(-1);
    const double* theta = doubles(c, 1, "theta", &s);
    check(c, dqa_controller_set_parameters(controller, theta, count(&s)));
}

/* (controller, step, sensors) */
static void evaluate(call* c) {
    dqa_controller* controller = controller_of(c);
    const dqa_controller_info info = info_of(c, controller);
    shape seen = axes1(info.n_sensors);
    const shape s = axes1(info.n_signals);
    const double* sensors = optional_doubles(c, 2, "sensors", &seen);
    double* actuation = room(&s);
    check(c, dqa_controller_evaluate(controller, whole(c, 1, "step"), sensors, count(&seen), actuation, count(&s)));
    give_doubles(c, actuation, s);
}

/* ------------------------------------------------------------------ helpers of optimisers */
static double* copy_of(call* c, int argument, const char* name, shape* s) {
    const double* from = doubles(c, argument, name, s);
    double* to = room(s);
    memcpy(to, from, (size_t)count(s) * sizeof *to);
    return to;
}

/* (x, gradient, rates, first_moment, second_moment, iteration) -> x, first_moment, second_moment */
static void adam_step(call* c) {
    shape s = axes1(-1);
    double* x = copy_of(c, 0, "x", &s);
    const double* gradient = doubles(c, 1, "gradient", &s);
    const double* rates = doubles(c, 2, "rates", &s);
    double* first = copy_of(c, 3, "first_moment", &s);
    double* second = copy_of(c, 4, "second_moment", &s);
    check(c, dqa_adam_step(x, gradient, rates, first, second, count(&s), whole(c, 5, "iteration")));
    give_doubles(c, x, s);
    give_doubles(c, first, s);
    give_doubles(c, second, s);
}

static void project_simplex(call* c) {
    shape s = axes1(-1);
    double* x = copy_of(c, 0, "x", &s);
    check(c, dqa_project_simplex(x, count(&s)));
    give_doubles(c, x, s);
}

/* ------------------------------------------------------------------ search without gradients */
static dqa_cma_es* search_of(call* c) {
    return object(c, 0, "search", SEARCH);
}

static dqa_cma_es_info search_info_of(call* c, const dqa_cma_es* search) {
    dqa_cma_es_info info;
    check(c, dqa_cma_es_get_info(search, &info, sizeof info));
    return info;
}

/* (options, mean, scales) */
static void search_create(call* c) {
    dqa_cma_es_options options;
    dqa_cma_es* search;
    shape s = axes1(-1), units;
    const double *mean = doubles(c, 1, "mean", &s), *scales;
    units = s;
    scales = optional_doubles(c, 2, "scales", &units);
    check(c, dqa_cma_es_options_init(&options, sizeof options));
    fill(c, 0, "dqa_cma_es_options", &options);
    check(c, dqa_cma_es_create(&options, mean, scales, count(&s), &search));
    give_object(c, SEARCH, search);
}

static void search_load(call* c) {
    dqa_cma_es* search;
    check(c, dqa_cma_es_load(text(c, 0, "path"), &search));
    give_object(c, SEARCH, search);
}

static void search_save(call* c) {
    check(c, dqa_cma_es_save(search_of(c), text(c, 1, "path")));
}

static void search_info(call* c) {
    const dqa_cma_es_info info = search_info_of(c, search_of(c));
    give_record(c, "dqa_cma_es_info", &info);
}

static void ask(call* c) {
    dqa_cma_es* search = object_to_change(c, 0, "search", SEARCH);
    const dqa_cma_es_info info = search_info_of(c, search);
    const shape s = axes2(info.population, info.n);
    double* candidates = room(&s);
    check(c, dqa_cma_es_ask(search, candidates, count(&s)));
    give_doubles(c, candidates, s);
}

/* (search, values) */
static void tell(call* c) {
    dqa_cma_es* search = object_to_change(c, 0, "search", SEARCH);
    shape s = axes1(-1);
    const double* values = doubles(c, 1, "values", &s);
    check(c, dqa_cma_es_tell(search, values, count(&s)));
}

/* -> x, value */
static void best(call* c) {
    dqa_cma_es* search = search_of(c);
    const shape s = axes1(search_info_of(c, search).n);
    double *x = room(&s), value = 0.0;
    check(c, dqa_cma_es_best(search, x, count(&s), &value));
    give_doubles(c, x, s);
    give_number(c, value);
}

static void mean(call* c) {
    dqa_cma_es* search = search_of(c);
    const shape s = axes1(search_info_of(c, search).n);
    double* x = room(&s);
    check(c, dqa_cma_es_mean(search, x, count(&s)));
    give_doubles(c, x, s);
}

/* clang-format off */
const command controller_commands[] = {
    {"controller_create_sinusoid", create_sinusoid, 2, 2},
    {"controller_create_mlp", create_mlp, 0, 1},
    {"controller_create_callback", create_callback, 4, 4},
    {"controller_load", load, 1, 1},
    {"controller_save", save, 2, 2},
    {"controller_get_info", get_info, 1, 1},
    {"controller_n_parameters", n_parameters, 1, 1},
    {"controller_get_parameters", get_parameters, 1, 1},
    {"controller_set_parameters", set_parameters, 2, 2},
    {"controller_evaluate", evaluate, 2, 3},
    {"adam_step", adam_step, 6, 6},
    {"project_simplex", project_simplex, 1, 1},
    {"cma_es_create", search_create, 2, 3},
    {"cma_es_load", search_load, 1, 1},
    {"cma_es_save", search_save, 2, 2},
    {"cma_es_get_info", search_info, 1, 1},
    {"cma_es_ask", ask, 1, 1},
    {"cma_es_tell", tell, 2, 2},
    {"cma_es_best", best, 1, 1},
    {"cma_es_mean", mean, 1, 1},
    {NULL, NULL, 0, 0}};
