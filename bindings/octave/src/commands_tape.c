/* SPDX-License-Identifier: MIT
 * Commands of tapes and adjoints, and the proof of a gradient. Names and arguments are those of diffaqua.h; outputs
 * become results. The shape of what depends on the design of a tape is an argument, which the library compares. */
#include "gateway.h"

static dqa_tape* tape_of(call* c) {
    return object(c, 0, "tape", TAPE);
}

static dqa_adjoint* adjoint_of(call* c) {
    return object(c, 0, "adjoint", ADJOINT);
}

/* One or two lengths. */
static shape shape_of(call* c, int argument) {
    const double most = 2147483647.0;
    const mxArray* lengths = c->in[argument];
    const size_t n = mxGetNumberOfElements(lengths);
    int64_t first, second;
    if (n != 1 && n != 2) refuse(c, DQA_ERROR_ARGUMENT, "shape: expected one or two lengths, got %d", (int)n);
    first = whole_element(c, lengths, 0, "shape", 0.0, most);
    if (n == 1) return axes1(first);
    second = whole_element(c, lengths, 1, "shape", 0.0, most);
    return axes2(first, second);
}

/* ------------------------------------------------------------------ tapes */
/* (simulator, options) */
static void create(call* c) {
    dqa_simulator* simulator = object(c, 0, "simulator", SIMULATOR);
    dqa_tape_options options;
    dqa_tape* tape;
    check(c, dqa_tape_options_init(&options, sizeof options));
    fill(c, 1, "dqa_tape_options", &options);
    check(c, dqa_tape_create(simulator, &options, &tape));
    give_object(c, TAPE, tape);
}

static void clear(call* c) {
    check(c, dqa_tape_clear(object_to_change(c, 0, "tape", TAPE)));
}

static void n_steps(call* c) {
    int64_t n = 0;
    check(c, dqa_tape_n_steps(tape_of(c), &n));
    give_number(c, (double)n);
}

/* (tape, step, [n_nodes, dims]) -> q, v */
static void get_state(call* c) {
    dqa_tape* tape = tape_of(c);
    const shape s = shape_of(c, 2);
    double *q = room(&s), *v = room(&s);
    check(c, dqa_tape_get_state(tape, whole(c, 1, "step"), q, count(&s), v, count(&s)));
    give_doubles(c, q, s);
    give_doubles(c, v, s);
}

/* (tape, step, n_signals) */
static void get_actuation(call* c) {
    dqa_tape* tape = tape_of(c);
    const shape s = shape_of(c, 2);
    double* values = room(&s);
    check(c, dqa_tape_get_actuation(tape, whole(c, 1, "step"), values, count(&s)));
    give_doubles(c, values, s);
}

/* (tape, step, dims) */
static void get_current(call* c) {
    dqa_tape* tape = tape_of(c);
    const shape s = shape_of(c, 2);
    double* values = room(&s);
    check(c, dqa_tape_get_current(tape, whole(c, 1, "step"), values, count(&s)));
    give_doubles(c, values, s);
}

/* (tape, step, [n_vertices, dims]) */
static void get_surface(call* c) {
    dqa_tape* tape = tape_of(c);
    const shape s = shape_of(c, 2);
    double* vertices = room(&s);
    check(c, dqa_tape_get_surface(tape, whole(c, 1, "step"), vertices, count(&s)));
    give_doubles(c, vertices, s);
}

static void stats(call* c) {
    dqa_tape_statistics statistics;
    check(c, dqa_tape_stats(tape_of(c), &statistics, sizeof statistics));
    give_record(c, "dqa_tape_statistics", &statistics);
}

/* (tape, terms) -> loss, per_term */
static void objective(call* c) {
    dqa_tape* tape = tape_of(c);
    int64_t n;
    const dqa_objective_term* terms = terms_of(c, 1, &n);
    const shape s = axes1(n);
    double loss = 0.0, *each = room(&s);
    check(c, dqa_tape_objective(tape, terms, n, &loss, each));
    give_number(c, loss);
    give_doubles(c, each, s);
}

/* ------------------------------------------------------------------ adjoints */
/* (tape) */
static void adjoint_create(call* c) {
    dqa_adjoint* adjoint;
    check(c, dqa_adjoint_create(tape_of(c), &adjoint));
    give_object(c, ADJOINT, adjoint);
}

/* (adjoint, step, quantity, bar, [n_nodes, dims]) */
static void seed(call* c) {
    dqa_adjoint* adjoint = object_to_change(c, 0, "adjoint", ADJOINT);
    shape s = shape_of(c, 4);
    const double* bar = doubles(c, 3, "bar", &s);
    check(c, dqa_adjoint_seed(adjoint, whole(c, 1, "step"), index_of(c, 2, "quantity"), bar, count(&s)));
}

/* (adjoint, terms) */
static void seed_objective(call* c) {
    dqa_adjoint* adjoint = object_to_change(c, 0, "adjoint", ADJOINT);
    int64_t n;
    const dqa_objective_term* terms = terms_of(c, 1, &n);
    check(c, dqa_adjoint_seed_objective(adjoint, terms, n));
}

/* (adjoint, to_step, progress) */
static void backward(call* c) {
    dqa_adjoint* adjoint = object_to_change(c, 0, "adjoint", ADJOINT);
    const int64_t id = whole(c, 2, "progress");
    check(c, dqa_adjoint_backward(adjoint, whole(c, 1, "to_step"), progress_of(id), user_data_of(id, 0)));
}

/* (adjoint, with_respect_to, shape) */
static void get(call* c) {
    dqa_adjoint* adjoint = adjoint_of(c);
    const shape s = shape_of(c, 2);
    double* values = room(&s);
    check(c, dqa_adjoint_get(adjoint, index_of(c, 1, "with_respect_to"), values, count(&s)));
    give_doubles(c, values, s);
}

/* ------------------------------------------------------------------ proof of the gradient */
/* (simulator, controller or [], terms, options) */
static void check_gradient(call* c) {
    dqa_simulator* simulator = object(c, 0, "simulator", SIMULATOR);
    dqa_controller* controller = optional_object(c, 1, "controller", CONTROLLER);
    int64_t n;
    const dqa_objective_term* terms = terms_of(c, 2, &n);
    dqa_gradient_check_options options;
    dqa_gradient_check_report report;
    check(c, dqa_gradient_check_options_init(&options, sizeof options));
    fill(c, 3, "dqa_gradient_check_options", &options);
    check(c, dqa_check_gradient(simulator, controller, terms, n, &options, &report, sizeof report));
    give_record(c, "dqa_gradient_check_report", &report);
}

/* clang-format off */
const command tape_commands[] = {
    {"tape_create", create, 1, 2},
    {"tape_clear", clear, 1, 1},
    {"tape_n_steps", n_steps, 1, 1},
    {"tape_get_state", get_state, 3, 3},
    {"tape_get_actuation", get_actuation, 3, 3},
    {"tape_get_current", get_current, 3, 3},
    {"tape_get_surface", get_surface, 3, 3},
    {"tape_stats", stats, 1, 1},
    {"tape_objective", objective, 2, 2},
    {"adjoint_create", adjoint_create, 1, 1},
    {"adjoint_seed", seed, 5, 5},
    {"adjoint_seed_objective", seed_objective, 2, 2},
    {"adjoint_backward", backward, 3, 3},
    {"adjoint_get", get, 3, 3},
    {"check_gradient", check_gradient, 3, 4},
    {NULL, NULL, 0, 0}};
