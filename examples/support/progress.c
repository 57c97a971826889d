/* SPDX-License-Identifier: MIT
 * A progress bar. The estimate of the time left is made of what each stage took the last time it ran. */
#define _POSIX_C_SOURCE 200809L
#include "progress.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "interrupt.h"
#include "say.h"

#define BAR_WIDTH 20
#define REDRAW_SECONDS 0.1

double progress_clock(void) {
    struct timespec now;
    if (clock_gettime(CLOCK_MONOTONIC, &now) != 0) return 0.0;
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double progress_cpu(void) {
    struct timespec now;
    if (clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now) != 0) return 0.0;
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void progress_begin(progress* p, int64_t iterations, int64_t extra) {
    memset(p, 0, sizeof *p);
    p->terminal = isatty(STDERR_FILENO);
    p->iterations = iterations;
    p->extra = extra;
    p->parts = p->part = 1;
    p->part_end = iterations;
    p->cost = 1.0;
    p->started = progress_clock();
    for (int i = 0; i < PROGRESS_STAGES; ++i) p->seconds[i] = -1.0;
}

void progress_part(progress* p, int32_t part, int32_t parts, int64_t end, double cost) {
    p->part = part;
    p->parts = parts;
    p->part_end = end;
    p->cost = cost;
    /* What was learned holds for the grid before. */
    for (int i = PROGRESS_SETUP; i <= PROGRESS_BACKWARD; ++i) p->seconds[i] = -1.0;
}

/* What a stage takes, from its running or its last time; < 0 when nobody knows. */
static double expected(const progress* p, int stage) {
    if (p->seconds[stage] >= 0.0) return p->seconds[stage];
    if (stage == p->stage && p->fraction > 0.05) return (progress_clock() - p->stage_started) / p->fraction;
    /* The sweep back has not run yet: it does about the work of the way forward. */
    if (stage == PROGRESS_BACKWARD) return expected(p, PROGRESS_FORWARD);
    return stage == PROGRESS_FORWARD ? -1.0 : 0.0;
}

/* Seconds left, or < 0 when nobody knows yet. */
static double seconds_left(const progress* p) {
    const double setup = expected(p, PROGRESS_SETUP), forward = expected(p, PROGRESS_FORWARD),
                 backward = expected(p, PROGRESS_BACKWARD);
    const int64_t end = p->part_end < p->iteration ? p->iteration : p->part_end;
    double left;
    if (forward < 0.0 || backward < 0.0) return -1.0;
    left = ((double)(end - p->iteration) + p->cost * (double)(p->iterations - end)) * (setup + forward + backward) +
           p->cost * (double)p->extra * (setup + forward);
    /* Take off what the running iteration, or the running extra rollout, has behind it. */
    if (p->stage == PROGRESS_SETUP) left -= p->fraction * setup;
    if (p->stage == PROGRESS_FORWARD) left -= setup + p->fraction * forward;
    if (p->stage == PROGRESS_BACKWARD) left -= setup + forward + p->fraction * backward;
    return left > 0.0 ? left : 0.0;
}

static void duration(double seconds, char* text, size_t size) {
    const long whole = (long)(seconds + 0.5);
    if (seconds < 0.0)
        (void)snprintf(text, size, "-:--");
    else if (whole >= 3600)
        (void)snprintf(text, size, "%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
    else
        (void)snprintf(text, size, "%ld:%02ld", whole / 60, whole % 60);
}

/* "  stage 1/2" or "  name", or nothing without a schedule. */
static void part_text(const progress* p, char* text, size_t size) {
    text[0] = '\0';
    if (p->part_name != NULL)
        (void)snprintf(text, size, "  %s", p->part_name);
    else if (p->parts > 1)
        (void)snprintf(text, size, "  stage %d/%d", (int)p->part, (int)p->parts);
}

static void draw(progress* p) {
    static const char* const activity[PROGRESS_STAGES] = {
        "shapes", "proving the gradient", "design", "forward", "backward", "writing"};
    const double now = progress_clock(), left = seconds_left(p);
    const double share = left < 0.0 ? 0.0 : (now - p->started) / (now - p->started + left + 1e-9);
    char bar[BAR_WIDTH + 1], remaining[32], losses[64], part[32], line[256];
    const int width = p->parts > 1 ? BAR_WIDTH / 2 : BAR_WIDTH, full = (int)floor(share * width);
    for (int i = 0; i < width; ++i) bar[i] = i < full ? '=' : i == full ? '>' : ' ';
    bar[width] = '\0';
    duration(left, remaining, sizeof remaining);
    losses[0] = '\0';
    if (p->iteration > 0 && !isnan(p->loss))
        (void)snprintf(losses, sizeof losses, "  loss %.5f  best %.5f", p->loss, p->best);
    part_text(p, part, sizeof part);
    (void)snprintf(line, sizeof line, "[%s] %lld/%lld%s%s  %s left  %s", bar, (long long)p->iteration,
                   (long long)p->iterations, part, losses, remaining, activity[p->stage]);
    fprintf(stderr, "\r%.79s\033[K", line); /* a longer line would wrap and not be redrawn */
    fflush(stderr);
    say_line_is_open(1);
    p->drawn = now;
}

void progress_stage(progress* p, int stage) {
    p->stage = stage;
    p->fraction = 0.0;
    p->stage_started = progress_clock();
    if (p->terminal && p->stage_started - p->drawn >= REDRAW_SECONDS) draw(p);
}

void progress_stage_done(progress* p) {
    p->seconds[p->stage] = progress_clock() - p->stage_started;
    p->fraction = 1.0;
}

void progress_iteration(progress* p, int64_t finished, double loss, double best, double seconds) {
    p->iteration = finished;
    p->loss = loss;
    p->best = best;
    p->stage = PROGRESS_SETUP;
    p->fraction = 0.0;
    if (p->terminal) {
        draw(p);
    } else {
        char remaining[32], part[32];
        duration(seconds_left(p), remaining, sizeof remaining);
        part_text(p, part, sizeof part);
        fprintf(stderr, "iteration %lld/%lld%s  loss %.6f  best %.6f  %.2f s  %s left\n", (long long)finished,
                (long long)p->iterations, part, loss, best, seconds, remaining);
    }
}

void progress_shape(progress* p, int64_t finished, double seconds) {
    char remaining[32];
    p->iteration = finished;
    p->loss = (double)NAN;
    p->seconds[PROGRESS_SETUP] = seconds;
    p->stage = PROGRESS_SETUP;
    p->fraction = 0.0;
    duration(seconds_left(p), remaining, sizeof remaining);
    if (p->terminal)
        draw(p);
    else
        fprintf(stderr, "shape %lld/%lld  %.2f s  %s left\n", (long long)finished, (long long)p->iterations, seconds,
                remaining);
}

void progress_end(progress* p) {
    if (p->terminal) {
        fputs("\r\033[K", stderr);
        fflush(stderr);
        say_line_is_open(0);
    }
}

int32_t progress_callback(int64_t done, int64_t total, void* user_data) {
    progress* p = user_data;
    p->fraction = total > 0 ? (double)done / (double)total : 0.0;
    if (p->terminal && progress_clock() - p->drawn >= REDRAW_SECONDS) draw(p);
    return interrupted();
}
