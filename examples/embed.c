/* SPDX-License-Identifier: MIT
 *
 * embed — the library inside a program that already has a main loop, a logger and signal handling of its own.
 *
 *   embed [STEPS]     each of two swimmers takes STEPS steps (default 300, ten seconds of its time)
 *
 * What to look at:
 *  - the library's messages go through the program's logger (from_library), with its levels and its time stamps;
 *  - one shape space is shared by two simulators, each used by one thread alone;
 *  - the main loop goes on ticking meanwhile and reads positions that the threads publish under the program's own lock;
 *  - Ctrl-C sets a cancel token from the signal handler: steps under way stop, every state stays whole, and the program
 *    leaves through its ordinary exit with code 0.
 * Only diffaqua.h, the C library and POSIX are used. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "diffaqua.h"

/* ------------------------------------------------------------------ the program's logger */
typedef struct logger {
    pthread_mutex_t lock;
    struct timespec start;
    FILE* out;
} logger;

static logger journal = {PTHREAD_MUTEX_INITIALIZER, {0, 0}, NULL};

static void note(const char* who, const char* pattern, ...) __attribute__((format(printf, 2, 3)));

static void note(const char* who, const char* pattern, ...) {
    struct timespec now;
    va_list arguments;
    clock_gettime(CLOCK_MONOTONIC, &now);
    pthread_mutex_lock(&journal.lock);
    fprintf(journal.out, "[%7.3f] %-8s ",
            (double)(now.tv_sec - journal.start.tv_sec) + 1e-9 * (double)(now.tv_nsec - journal.start.tv_nsec), who);
    va_start(arguments, pattern);
    vfprintf(journal.out, pattern, arguments);
    va_end(arguments);
    fputc('\n', journal.out);
    fflush(journal.out);
    pthread_mutex_unlock(&journal.lock);
}

/* Called by the library from whichever thread has something to say. */
static void from_library(int32_t level, const char* message, void* user_data) {
    static const char* const names[] = {"?", "error", "warning", "info", "debug"};
    (void)user_data;
    note(level >= 1 && level <= 4 ? names[level] : names[0], "%s", message);
}

/* ------------------------------------------------------------------ signals */
static dqa_cancel_token* token = NULL; /* set before the handler is installed, freed after it is removed */
static volatile sig_atomic_t asked_to_stop = 0;

static void on_signal(int number) {
    const int saved = errno;
    (void)number;
    (void)signal(SIGINT, SIG_DFL); /* a second one ends the program */
    (void)signal(SIGTERM, SIG_DFL);
    asked_to_stop = 1;
    (void)dqa_cancel_token_set(token); /* documented as async-signal-safe */
    errno = saved;
}

static int handle_signals(void (*handler)(int)) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = handler;
    sigemptyset(&action.sa_mask);
    return sigaction(SIGINT, &action, NULL) == 0 && sigaction(SIGTERM, &action, NULL) == 0;
}

/* ------------------------------------------------------------------ swimmers */
enum { NX = 30, NY = 10, NZ = 12, N_CELLS = NX * NY * NZ, N_BASES = 2, N_SWIMMERS = 2, DIMS = 3 };

/* What a thread works with, and below `lock` what it publishes. */
typedef struct swimmer {
    const char* name;
    dqa_shape_space* space;
    double weights[N_BASES];
    double period; /* s, of its tail beat */
    long steps;
    pthread_mutex_t lock;
    long taken;
    double head; /* m, position of the head along x */
    int finished;
    dqa_status status;
    char message[512];
} swimmer;

static void publish(swimmer* s, long taken, double head) {
    pthread_mutex_lock(&s->lock);
    s->taken = taken, s->head = head;
    pthread_mutex_unlock(&s->lock);
}

/* The program's own control loop: every step it decides on the actuation and looks at the sensors. */
static dqa_status swim(swimmer* s, dqa_simulator* simulator) {
    dqa_simulator_info info;
    double actuation[8] = {0}, sensors[6 * DIMS];
    dqa_status status = dqa_simulator_set_weights(simulator, s->weights, N_BASES, NULL, NULL);
    if (status == DQA_SUCCESS) status = dqa_simulator_get_info(simulator, &info, sizeof info);
    if (status == DQA_SUCCESS && info.n_signals > (int32_t)(sizeof actuation / sizeof actuation[0]))
        return DQA_ERROR_UNSUPPORTED;
    for (long k = 0; k < s->steps && status == DQA_SUCCESS; ++k) {
        status = dqa_simulator_get_info(simulator, &info, sizeof info);
        for (int32_t a = 0; a < info.n_signals; ++a) actuation[a] = sin(6.283185307179586 * info.time / s->period);
        if (status == DQA_SUCCESS) status = dqa_simulator_step(simulator, actuation, info.n_signals, NULL);
        if (status == DQA_SUCCESS) status = dqa_simulator_sensors(simulator, sensors, info.n_sensors);
        if (status == DQA_SUCCESS) publish(s, k + 1, sensors[0]);
    }
    return status;
}

static void* thread_main(void* argument) {
    swimmer* s = argument;
    dqa_simulator_options options;
    dqa_simulator* simulator = NULL;
    dqa_status status = dqa_simulator_options_init(&options, sizeof options);
    options.cancel = token;
    if (status == DQA_SUCCESS) status = dqa_simulator_create(s->space, &options, &simulator);
    if (status == DQA_SUCCESS) status = swim(s, simulator);
    pthread_mutex_lock(&s->lock);
    s->finished = 1;
    s->status = status;
    /* The message belongs to this thread: take it along before the thread ends. */
    snprintf(s->message, sizeof s->message, "%s", status == DQA_SUCCESS ? "" : dqa_last_error());
    pthread_mutex_unlock(&s->lock);
    dqa_simulator_free(simulator);
    return NULL;
}

/* A spindle with a tail blade, as covered fractions; `slenderness` tells the two bases apart. */
static dqa_status add_fish(dqa_shape_space* space, const char* name, double slenderness) {
    double* cells = calloc(N_CELLS, sizeof *cells);
    dqa_status status;
    if (cells == NULL) return DQA_ERROR_MEMORY;
    for (int i = 0; i < NX; ++i)
        for (int j = 0; j < NY; ++j)
            for (int k = 0; k < NZ; ++k) {
                const double x = (i + 0.5 - 0.5 * NX) / (0.43 * NX), y = j + 0.5 - 0.5 * NY, z = k + 0.5 - 0.5 * NZ;
                const double width = 2.6 / slenderness * (1.0 - x * x), blade = x < -0.55 ? 3.5 * (-0.3 - x) : 0.0;
                if (fabs(x) < 1.0 && (y * y + 0.6 * z * z < width * width || (fabs(y) < 1.0 && fabs(z) < blade + 1.0)))
                    cells[(i * NY + j) * NZ + k] = 1.0;
            }
    status = dqa_shape_space_add_density(space, name, cells, N_CELLS, NULL);
    free(cells);
    return status;
}

static dqa_status make_space(dqa_shape_space** space) {
    dqa_shape_space_options options;
    dqa_status status = dqa_shape_space_options_init(&options, sizeof options);
    options.cells_x = NX, options.cells_y = NY, options.cells_z = NZ;
    options.body_length = 0.6;
    options.cancel = token;
    if (status == DQA_SUCCESS) status = dqa_shape_space_create(&options, space);
    if (status == DQA_SUCCESS) status = add_fish(*space, "stout", 1.0);
    if (status == DQA_SUCCESS) status = add_fish(*space, "slender", 1.4);
    if (status == DQA_SUCCESS) status = dqa_shape_space_build(*space, NULL, NULL);
    return status;
}

/* ------------------------------------------------------------------ the main loop */
/* Ticks until both threads are done; this is where a real program would draw, serve and listen. */
static void main_loop(swimmer* swimmers) {
    const struct timespec tick = {0, 50 * 1000 * 1000};
    int running = N_SWIMMERS;
    for (long ticks = 0; running > 0; ++ticks) {
        nanosleep(&tick, NULL); /* a signal may cut it short, which is welcome */
        running = 0;
        for (int k = 0; k < N_SWIMMERS; ++k) {
            swimmer* s = &swimmers[k];
            pthread_mutex_lock(&s->lock);
            const long taken = s->taken;
            const double head = s->head;
            running += !s->finished;
            pthread_mutex_unlock(&s->lock);
            if (ticks % 10 == 0 && taken > 0)
                note("program", "%s: %ld steps, head at x = %.3f m", s->name, taken, head);
        }
    }
}

static int report(const swimmer* swimmers) {
    int failures = 0;
    for (int k = 0; k < N_SWIMMERS; ++k) {
        const swimmer* s = &swimmers[k];
        failures += s->status != DQA_SUCCESS && s->status != DQA_CANCELLED;
        note("program", "%s: %s after %ld of %ld steps%s%s", s->name, dqa_status_name(s->status), s->taken, s->steps,
             s->message[0] ? ": " : "", s->message);
    }
    note("program", asked_to_stop ? "stopped by a signal" : "finished");
    return failures;
}

int main(int argc, char** argv) {
    swimmer swimmers[N_SWIMMERS] = {
        {"stout", NULL, {1.0, 0.0}, 0.5, 0, PTHREAD_MUTEX_INITIALIZER, 0, 0.0, 0, DQA_SUCCESS, ""},
        {"between", NULL, {0.4, 0.6}, 0.4, 0, PTHREAD_MUTEX_INITIALIZER, 0, 0.0, 0, DQA_SUCCESS, ""},
    };
    pthread_t threads[N_SWIMMERS];
    dqa_shape_space* space = NULL;
    char* end = NULL;
    const long steps = argc > 1 ? strtol(argv[1], &end, 10) : 300;
    int started = 0, failures = 1;
    if (argc > 2 || (end != NULL && *end != '\0') || steps < 1 || steps == LONG_MAX) {
        fprintf(stderr, "usage: embed [STEPS], STEPS >= 1\n");
        return 2;
    }
    journal.out = stdout;
    clock_gettime(CLOCK_MONOTONIC, &journal.start);
    if (dqa_set_log_handler(from_library, DQA_LOG_INFO, NULL) != DQA_SUCCESS ||
        dqa_cancel_token_create(&token) != DQA_SUCCESS || !handle_signals(on_signal) ||
        make_space(&space) != DQA_SUCCESS) {
        if (asked_to_stop)
            note("program", "stopped by a signal");
        else
            note("program", "cannot start: %s", dqa_last_error());
        failures = !asked_to_stop;
    } else {
        note("program", "two swimmers of %ld steps each", steps);
        while (started < N_SWIMMERS) {
            swimmers[started].space = space;
            swimmers[started].steps = steps;
            if (pthread_create(&threads[started], NULL, thread_main, &swimmers[started]) != 0) break;
            ++started;
        }
        for (int k = started; k < N_SWIMMERS; ++k) swimmers[k].finished = 1, swimmers[k].status = DQA_ERROR_MEMORY;
        main_loop(swimmers);
        for (int k = 0; k < started; ++k) pthread_join(threads[k], NULL);
        failures = report(swimmers);
    }
    dqa_shape_space_free(space);
    handle_signals(SIG_DFL);
    dqa_cancel_token_free(token);
    dqa_set_log_handler(NULL, 0, NULL);
    return failures != 0;
}
