/* SPDX-License-Identifier: MIT
 * What a host may do around the library: fork after threads have run, call from threads of little stack. */
#define _POSIX_C_SOURCE 200809L
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support.h"

#if defined(__SANITIZE_ADDRESS__)
#define STACK (1024 * 1024) /* the sanitizer's frames are much larger */
#else
#define STACK (256 * 1024)
#endif
enum { CHAIN_NO_MEMORY = 3 }; /* exit status */
enum { LONG = 20, WIDE = 8, HIGH = 8, STEPS = 2 };

/* A loss and its gradient, over the full box, so that there are cells for several threads. */
typedef struct answer {
    dqa_status status;
    double loss, gradient[2];
} answer;

static dqa_status on(dqa_status status, answer* a) {
    if (a->status == DQA_SUCCESS) a->status = status;
    return a->status;
}

static void whole_chain(int threads, int method, answer* a) {
    dqa_shape_space_options so;
    dqa_simulator_options o;
    dqa_objective_term term;
    dqa_shape_space* space = NULL;
    dqa_simulator* simulator = NULL;
    dqa_controller* controller = NULL;
    dqa_tape* tape = NULL;
    dqa_adjoint* adjoint = NULL;
    dqa_cma_es* search = NULL;
    double* cells = calloc(LONG * WIDE * HIGH, sizeof *cells);
    const double weights[2] = {0.4, 0.6}, start[2] = {0.0, 1.0};
    int base, i, j, k;
    memset(a, 0, sizeof *a);
    if (cells == NULL) return;
    on(dqa_shape_space_options_init(&so, sizeof so), a);
    so.cells_x = LONG, so.cells_y = WIDE, so.cells_z = HIGH, so.sigma = 0.7, so.threads = threads, so.tolerance = 1e-7;
    on(dqa_shape_space_create(&so, &space), a);
    for (base = 0; base < 2 && a->status == DQA_SUCCESS; ++base) {
        for (i = 0; i < LONG; ++i)
            for (j = 0; j < WIDE; ++j)
                for (k = 0; k < HIGH; ++k) {
                    const double x = i - 9.5, y = j - 3.5, z = k - 3.5;
                    const double r = x * x / 64 + y * y / (5 + base) + z * z / (7 - base);
                    cells[(i * WIDE + j) * HIGH + k] = r > 1 ? 0 : r < 0.5 ? 1 : 2 * (1 - r);
                }
        on(dqa_shape_space_add_density(space, "body", cells, LONG * WIDE * HIGH, NULL), a);
    }
    free(cells);
    on(dqa_shape_space_build(space, NULL, NULL), a);
    on(dqa_simulator_options_init(&o, sizeof o), a);
    o.threads = threads, o.threshold = 0.0, o.method = method;
    if (a->status == DQA_SUCCESS) on(dqa_simulator_create(space, &o, &simulator), a);
    if (a->status == DQA_SUCCESS) on(dqa_simulator_set_weights(simulator, weights, 2, NULL, NULL), a);
    on(dqa_controller_create_sinusoid(1, 1.0 / 30.0, &controller), a);
    if (a->status == DQA_SUCCESS) on(dqa_tape_create(simulator, NULL, &tape), a);
    if (a->status == DQA_SUCCESS) on(dqa_simulator_rollout(simulator, controller, STEPS, tape, NULL, NULL), a);
    on(dqa_objective_term_init(&term, sizeof term), a);
    if (a->status == DQA_SUCCESS) on(dqa_tape_objective(tape, &term, 1, &a->loss, NULL), a);
    if (a->status == DQA_SUCCESS) on(dqa_adjoint_create(tape, &adjoint), a);
    if (a->status == DQA_SUCCESS) on(dqa_adjoint_seed_objective(adjoint, &term, 1), a);
    if (a->status == DQA_SUCCESS) on(dqa_adjoint_backward(adjoint, 0, NULL, NULL), a);
    if (a->status == DQA_SUCCESS) on(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, a->gradient, 2), a);
    on(dqa_cma_es_create(NULL, start, NULL, 2, &search), a);
    dqa_cma_es_free(search);
    dqa_adjoint_free(adjoint);
    dqa_tape_free(tape);
    dqa_controller_free(controller);
    dqa_simulator_free(simulator);
    dqa_shape_space_free(space);
}

static int same(const answer* a, const answer* b) {
    return a->status == DQA_SUCCESS && memcmp(a, b, sizeof *a) == 0;
}

/* The child gets the parent's bits, whichever of the two used threads, and does not wait for ones that fork left. */
static void a_child_computes(void** state) {
    static const int threads[][2] = {{1, 4}, {4, 1}, {2, 2}};
    size_t k;
    (void)state;
    for (k = 0; k < sizeof threads / sizeof *threads; ++k) {
        answer parent;
        int ended = 0;
        pid_t child;
        whole_chain(threads[k][0], DQA_METHOD_NEWTON_PCG, &parent);
        ok(parent.status);
        child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            answer own;
            alarm(120); /* a child that hangs is ended by a signal */
            whole_chain(threads[k][1], DQA_METHOD_NEWTON_PCG, &own);
            _exit(same(&own, &parent) ? 0 : 1);
        }
        assert_int_equal(waitpid(child, &ended, 0), child);
        assert_true(WIFEXITED(ended) && WEXITSTATUS(ended) == 0);
    }
}

typedef struct work {
    int method;
    answer result;
} work;

/* Meshes and saved objects are read and written with as little. */
static void files(answer* a) {
    dqa_shape_space_options so;
    dqa_mlp_options mlp;
    dqa_shape_space *space = NULL, *loaded = NULL;
    dqa_controller *network = NULL, *read = NULL;
    on(dqa_shape_space_options_init(&so, sizeof so), a);
    so.cells_x = 40, so.cells_y = 12, so.cells_z = 20;
    on(dqa_shape_space_create(&so, &space), a);
    on(dqa_shape_space_add_mesh_file(space, DQA_SHAPES_DIR "/tuna.stl", NULL), a);
    on(dqa_shape_space_build(space, NULL, NULL), a);
    on(dqa_shape_space_save(space, "host.space"), a);
    on(dqa_shape_space_load("host.space", &loaded), a);
    on(dqa_mlp_options_init(&mlp, sizeof mlp), a);
    mlp.n_signals = 2;
    on(dqa_controller_create_mlp(&mlp, &network), a);
    on(dqa_controller_save(network, "host.controller"), a);
    on(dqa_controller_load("host.controller", &read), a);
    dqa_controller_free(network);
    dqa_controller_free(read);
    dqa_shape_space_free(space);
    dqa_shape_space_free(loaded);
    (void)remove("host.space");
    (void)remove("host.controller");
}

static void* in_thread(void* data) {
    work* w = data;
    whole_chain(1, w->method, &w->result);
    files(&w->result);
    return NULL;
}

/* The header promises that this much stack will do. */
static void little_stack_is_enough(void** state) {
    int method;
    (void)state;
    for (method = DQA_METHOD_NEWTON_PCG; method <= DQA_METHOD_PROJECTIVE; ++method) {
        work w;
        answer expected;
        pthread_attr_t attributes;
        pthread_t thread;
        w.method = method;
        whole_chain(1, method, &expected);
        assert_int_equal(pthread_attr_init(&attributes), 0);
        assert_int_equal(pthread_attr_setstacksize(&attributes, STACK), 0);
        assert_int_equal(pthread_create(&thread, &attributes, in_thread, &w), 0);
        assert_int_equal(pthread_join(thread, NULL), 0);
        assert_int_equal(pthread_attr_destroy(&attributes), 0);
        assert_true(same(&w.result, &expected));
    }
}

#if !defined(__SANITIZE_ADDRESS__)
/* How a process ends that computes the whole chain with so many MiB of address space, loading the library included. */
static int ended_with(const char* program, int mebibytes) {
    int ended = 0;
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        const struct rlimit most = {(rlim_t)mebibytes << 20, (rlim_t)mebibytes << 20};
        char* const arguments[] = {(char*)program, (char*)"--chain", NULL};
        /* Threads that OpenBLAS starts as it is loaded, and what they ask for, are nobody's to refuse: none of them. */
        if (setenv("OPENBLAS_NUM_THREADS", "1", 1) != 0 || setrlimit(RLIMIT_AS, &most) != 0 ||
            freopen("/dev/null", "w", stderr) == NULL)
            _exit(126);
        execv(program, arguments);
        _exit(127);
    }
    assert_int_equal(waitpid(child, &ended, 0), child);
    return ended;
}
#endif

/* OpenBLAS asks for its buffers without end where there is no room for them: the library looks before. */
static void little_address_space_is_an_error(void** state) {
#if defined(__SANITIZE_ADDRESS__)
    (void)state;
    skip(); /* its shadow takes terabytes */
#else
    const char* program = *state;
    int mebibytes, succeeded = 0, refused_memory = 0;
    for (mebibytes = 64; mebibytes <= 1536; mebibytes += mebibytes < 640 ? 16 : 128) {
        const int ended = ended_with(program, mebibytes);
        if (WIFSIGNALED(ended) && WTERMSIG(ended) == SIGALRM) fail_msg("%d MiB: it hangs", mebibytes);
        if (!WIFEXITED(ended)) fail_msg("%d MiB: ended by signal %d", mebibytes, WTERMSIG(ended));
        succeeded += WEXITSTATUS(ended) == 0;
        refused_memory += WEXITSTATUS(ended) == CHAIN_NO_MEMORY;
        /* 127: not even the loader had room. */
        if (WEXITSTATUS(ended) != 0 && WEXITSTATUS(ended) != CHAIN_NO_MEMORY && WEXITSTATUS(ended) != 127)
            fail_msg("%d MiB: it ended with %d", mebibytes, WEXITSTATUS(ended));
    }
    assert_true(succeeded > 0 && refused_memory > 0);
#endif
}

static int chain_alone(void) {
    answer a;
    alarm(60);
    whole_chain(1, DQA_METHOD_NEWTON_PCG, &a);
    return a.status == DQA_SUCCESS ? 0 : a.status == DQA_ERROR_MEMORY ? CHAIN_NO_MEMORY : 1;
}

int main(int argc, char** argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_child_computes),
        cmocka_unit_test_prestate(little_address_space_is_an_error, argv[0]),
        cmocka_unit_test(little_stack_is_enough),
    };
    if (argc > 1) return chain_alone();
    return cmocka_run_group_tests_name("host", tests, NULL, NULL);
}
