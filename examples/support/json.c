/* SPDX-License-Identifier: MIT
 * A small JSON writer. */
#include "json.h"

#include <math.h>

/* Whether every lead byte is followed by its continuation bytes. */
static int is_utf8(const char* text) {
    const unsigned char* c = (const unsigned char*)text;
    while (*c != '\0') {
        int follow = *c < 0x80                 ? 0
                     : *c >= 0xc2 && *c < 0xe0 ? 1
                     : (*c & 0xf0) == 0xe0     ? 2
                     : *c >= 0xf0 && *c < 0xf5 ? 3
                                               : -1;
        if (follow < 0) return 0;
        for (++c; follow > 0; --follow, ++c)
            if ((*c & 0xc0) != 0x80) return 0;
    }
    return 1;
}

static void quoted(FILE* stream, const char* text) {
    /* File names may be in any encoding; one that is not UTF-8 is shown as Latin-1, so that the file stays JSON. */
    const unsigned char limit = is_utf8(text) ? 0xff : 0x7f;
    fputc('"', stream);
    for (; *text != '\0'; ++text) {
        const unsigned char c = (unsigned char)*text;
        if (c == '"' || c == '\\')
            fprintf(stream, "\\%c", c);
        else if (c < 0x20 || c == '<' || c == 0x7f || c > limit) /* no "</script>" where HTML holds the JSON */
            fprintf(stream, "\\u%04x", (unsigned)c);
        else
            fputc(c, stream);
    }
    fputc('"', stream);
}

static void item(json* j, const char* key) {
    fputs(j->first ? "\n" : ",\n", j->stream);
    j->first = 0;
    for (int i = 0; i < j->depth; ++i) fputs("  ", j->stream);
    if (key != NULL) {
        quoted(j->stream, key);
        fputs(": ", j->stream);
    }
}

void json_begin(json* j, FILE* stream) {
    j->stream = stream;
    j->depth = 1;
    j->first = 1;
    fputc('{', stream);
}

void json_end(json* j) {
    fputs("\n}\n", j->stream);
}

void json_open(json* j, const char* key, char bracket) {
    item(j, key);
    fputc(bracket, j->stream);
    ++j->depth;
    j->first = 1;
}

void json_close(json* j, char bracket) {
    --j->depth;
    if (!j->first) {
        fputc('\n', j->stream);
        for (int i = 0; i < j->depth; ++i) fputs("  ", j->stream);
    }
    fputc(bracket, j->stream);
    j->first = 0;
}

void json_number(json* j, const char* key, double value) {
    item(j, key);
    if (isfinite(value))
        fprintf(j->stream, "%.17g", value);
    else
        fputs("null", j->stream);
}

void json_integer(json* j, const char* key, int64_t value) {
    item(j, key);
    fprintf(j->stream, "%lld", (long long)value);
}

void json_boolean(json* j, const char* key, int value) {
    item(j, key);
    fputs(value ? "true" : "false", j->stream);
}

void json_string(json* j, const char* key, const char* value) {
    item(j, key);
    if (value != NULL)
        quoted(j->stream, value);
    else
        fputs("null", j->stream);
}

FILE* json_value(json* j, const char* key) {
    item(j, key);
    return j->stream;
}

void json_numbers(json* j, const char* key, const double* x, int64_t n, int64_t stride) {
    item(j, key);
    fputc('[', j->stream);
    for (int64_t i = 0; i < n; ++i) {
        if (i > 0) fputc(',', j->stream);
        if (isfinite(x[i * stride]))
            fprintf(j->stream, "%.17g", x[i * stride]);
        else
            fputs("null", j->stream);
    }
    fputc(']', j->stream);
}
