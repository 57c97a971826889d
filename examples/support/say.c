/* SPDX-License-Identifier: MIT
 * Messages on stderr. The state is process-wide because stderr is. */
#include "say.h"

#include <stdarg.h>
#include <stdio.h>

static const char* program = "diffaqua";
static int line_open = 0;

void say_program(const char* name) {
    program = name;
}

void say_line_is_open(int open) {
    line_open = open;
}

void say(const char* format, ...) {
    va_list arguments;
    if (line_open) fputs("\r\033[K", stderr);
    line_open = 0;
    fprintf(stderr, "%s: ", program);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

int say_no_memory(void) {
    say("out of memory");
    return FAILED;
}

int say_status(dqa_status status, const char* doing) {
    if (status == DQA_SUCCESS) return DONE;
    if (status == DQA_CANCELLED) return INTERRUPTED;
    say("cannot %s: %s (%s)", doing, dqa_last_error(), dqa_status_name(status));
    return FAILED;
}
