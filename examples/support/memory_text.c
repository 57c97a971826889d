/* SPDX-License-Identifier: MIT
 * A text that grows in memory, and a whole file read into memory. */
#include "memory_text.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "input.h"
#include "say.h"

#define MOST_BYTES (1 << 30)

void memory_text_begin(memory_text* t) {
    memset(t, 0, sizeof *t);
}

void memory_text_end(memory_text* t) {
    free(t->text);
    memset(t, 0, sizeof *t);
}

static int make_room(memory_text* t, size_t more) {
    if (t->capacity - t->length <= more) {
        const size_t capacity = 2 * (t->length + more) + 256;
        char* text = realloc(t->text, capacity);
        if (text == NULL) {
            t->failed = 1;
            return 0;
        }
        t->text = text;
        t->capacity = capacity;
    }
    return 1;
}

void memory_text_add(memory_text* t, const char* format, ...) {
    va_list arguments;
    int needed;
    if (t->failed) return;
    va_start(arguments, format);
    needed = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    if (needed < 0 || !make_room(t, (size_t)needed)) {
        t->failed = 1;
        return;
    }
    va_start(arguments, format);
    (void)vsnprintf(t->text + t->length, t->capacity - t->length, format, arguments);
    va_end(arguments);
    t->length += (size_t)needed;
}

char* memory_text_read(const char* path, size_t* size) {
    memory_text t;
    FILE* stream = input_open(path);
    if (stream == NULL) return NULL;
    memory_text_begin(&t);
    errno = 0;
    while (make_room(&t, 65536)) {
        const size_t got = fread(t.text + t.length, 1, 65536, stream);
        t.length += got;
        if (got < 65536) break;
        if (t.length > MOST_BYTES) {
            say("cannot read %s: it is longer than %d MiB", path, MOST_BYTES >> 20);
            memory_text_end(&t);
            (void)fclose(stream);
            return NULL;
        }
    }
    if (t.failed || ferror(stream)) {
        say("cannot read %s: %s", path, t.failed ? "out of memory" : strerror(errno));
        memory_text_end(&t);
    } else {
        t.text[t.length] = '\0';
        *size = t.length;
    }
    (void)fclose(stream);
    return t.text;
}
