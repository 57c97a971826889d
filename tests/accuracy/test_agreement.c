/* SPDX-License-Identifier: MIT
 * Ways that must lead to the same answer: numbers of threads to the same bits, solvers to the tolerance, instruction
 * sets to rounding. On the real meshes at half resolution, or on shipped shapes where they are absent. */
#include "scenes.h"

enum { STEPS = 12 };

typedef struct outcome {
    int64_t n;
    double *q, *v, *q_bar;
    double loss, weights_bar[2], control_bar[3];
} outcome;

static dqa_shape_space* space;

static int open_space(void** state) {
    (void)state;
    space = scene_real(30, 8, 14, 1e-9);
    if (!space) space = scene_shipped(28, 10, 14, 1e-9);
    return 0;
}

static int close_space(void** state) {
    (void)state;
    dqa_shape_space_free(space);
    return 0;
}

static outcome run(const dqa_simulator_options* options, double share) {
    outcome out;
    dqa_simulator* simulator = scene_simulator(space, options, share);
    dqa_simulator_info info;
    dqa_controller* controller;
    dqa_tape* tape;
    dqa_adjoint* adjoint;
    const dqa_objective_term term = scene_travel();
    ok(dqa_simulator_get_info(simulator, &info, sizeof info));
    out.n = 3 * info.n_nodes;
    out.q = scene_doubles(out.n), out.v = scene_doubles(out.n), out.q_bar = scene_doubles(out.n);
    ok(dqa_controller_create_sinusoid(1, options->time_step, &controller));
    ok(dqa_tape_create(simulator, NULL, &tape));
    ok(dqa_simulator_rollout(simulator, controller, STEPS, tape, NULL, NULL));
    ok(dqa_simulator_get_state(simulator, out.q, out.n, out.v, out.n));
    ok(dqa_tape_objective(tape, &term, 1, &out.loss, NULL));
    ok(dqa_adjoint_create(tape, &adjoint));
    ok(dqa_adjoint_seed_objective(adjoint, &term, 1));
    ok(dqa_adjoint_backward(adjoint, 0, NULL, NULL));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, out.weights_bar, 2));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_CONTROL, out.control_bar, 3));
    ok(dqa_adjoint_get(adjoint, DQA_WRT_INITIAL_POSITION, out.q_bar, out.n));
    dqa_adjoint_free(adjoint);
    dqa_tape_free(tape);
    dqa_controller_free(controller);
    dqa_simulator_free(simulator);
    return out;
}

static void release(outcome* o) {
    free(o->q);
    free(o->v);
    free(o->q_bar);
}

static dqa_simulator_options defaults(void) {
    dqa_simulator_options o;
    ok(dqa_simulator_options_init(&o, sizeof o));
    return o;
}

static void threads_give_the_same_bits(void** state) {
    static const int32_t COUNTS[] = {2, 3, 4, 8};
    dqa_simulator_options o = defaults();
    outcome one = run(&o, 0.5);
    size_t k;
    (void)state;
    assert_true(one.loss != 0.0 && one.weights_bar[0] != 0.0);
    for (k = 0; k < sizeof COUNTS / sizeof *COUNTS; ++k) {
        outcome many;
        const size_t bytes = (size_t)one.n * sizeof *one.q;
        o.threads = COUNTS[k];
        many = run(&o, 0.5);
        assert_int_equal(many.n, one.n);
        assert_memory_equal(many.q, one.q, bytes);
        assert_memory_equal(many.v, one.v, bytes);
        assert_memory_equal(many.q_bar, one.q_bar, bytes);
        assert_memory_equal(&many.loss, &one.loss, sizeof one.loss);
        assert_memory_equal(many.weights_bar, one.weights_bar, sizeof one.weights_bar);
        assert_memory_equal(many.control_bar, one.control_bar, sizeof one.control_bar);
        release(&many);
    }
    release(&one);
}

static double distance(const double* a, const double* b, int64_t n) {
    double worst = 0.0, size = 0.0;
    int64_t i;
    for (i = 0; i < n; ++i) {
        worst = fmax(worst, fabs(a[i] - b[i]));
        size = fmax(size, fabs(b[i]));
    }
    return worst / size;
}

/* A run against a reference; prints the errors of state and gradient. */
static void compare(const char* name, const dqa_simulator_options* o, const outcome* reference, double state_tolerance,
                    double gradient_tolerance) {
    outcome a = run(o, 0.5);
    const double state_error = distance(a.q, reference->q, a.n);
    const double gradient_error =
        fmax(distance(a.weights_bar, reference->weights_bar, 2),
             fmax(distance(a.control_bar, reference->control_bar, 3), distance(a.q_bar, reference->q_bar, a.n)));
    print_message("  %-34s state error %.1e (<= %.0e)  gradient error %.1e (<= %.0e)\n", name, state_error,
                  state_tolerance, gradient_error, gradient_tolerance);
    assert_true(state_error <= state_tolerance);
    assert_true(gradient_error <= gradient_tolerance);
    release(&a);
}

static void solvers_agree(void** state) {
    dqa_simulator_options o = defaults();
    outcome reference;
    (void)state;
    o.method = DQA_METHOD_NEWTON_DIRECT;
    o.tolerance = 1e-12, o.adjoint_tolerance = 1e-12;
    reference = run(&o, 0.5);
    o.method = DQA_METHOD_NEWTON_PCG;
    compare("newton_pcg, 1e-12", &o, &reference, 1e-10, 1e-8);
    release(&reference);
}

/* At the default tolerances. Somewhere between two animals the loss is stationary, and an error relative to the
 * gradient there says nothing: the error is measured against the largest gradient of three places. */
static void default_tolerances_suffice(void** state) {
    static const double SHARES[] = {0.2, 0.5, 0.8};
    double error[3] = {0.0, 0.0, 0.0}, size[3] = {0.0, 0.0, 0.0};
    size_t s;
    (void)state;
    for (s = 0; s < sizeof SHARES / sizeof *SHARES; ++s) {
        dqa_simulator_options o = defaults();
        outcome reference, a = run(&o, SHARES[s]);
        const double* values[3];
        const double* exact[3];
        int64_t k, i, counts[3];
        o.method = DQA_METHOD_NEWTON_DIRECT;
        o.tolerance = 1e-12, o.adjoint_tolerance = 1e-12;
        reference = run(&o, SHARES[s]);
        values[0] = a.q, values[1] = a.weights_bar, values[2] = a.control_bar;
        exact[0] = reference.q, exact[1] = reference.weights_bar, exact[2] = reference.control_bar;
        counts[0] = a.n, counts[1] = 2, counts[2] = 3;
        for (k = 0; k < 3; ++k)
            for (i = 0; i < counts[k]; ++i) {
                error[k] = fmax(error[k], fabs(values[k][i] - exact[k][i]));
                size[k] = fmax(size[k], fabs(exact[k][i]));
            }
        release(&a);
        release(&reference);
    }
    print_message("  default tolerances: error of the state %.1e, of the gradient by weights %.1e, by control %.1e\n",
                  error[0] / size[0], error[1] / size[1], error[2] / size[2]);
    assert_true(error[0] <= 1e-4 * size[0]);
    assert_true(error[1] <= 1e-4 * size[1]);
    assert_true(error[2] <= 1e-4 * size[2]);
}

static void instruction_sets_agree(void** state) {
    dqa_simulator_options o = defaults();
    outcome reference;
    int32_t set;
    (void)state;
    o.tolerance = 1e-12, o.adjoint_tolerance = 1e-12;
    o.instruction_set = 1;
    reference = run(&o, 0.5);
    for (set = 2; set <= 3; ++set) {
        o.instruction_set = set;
        compare(set == 2 ? "AVX2 against baseline" : "AVX-512 against baseline", &o, &reference, 1e-10, 1e-8);
    }
    release(&reference);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_give_the_same_bits),
        cmocka_unit_test(solvers_agree),
        cmocka_unit_test(default_tolerances_suffice),
        cmocka_unit_test(instruction_sets_agree),
    };
    return cmocka_run_group_tests_name("agreement", tests, open_space, close_space);
}
