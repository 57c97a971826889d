/* SPDX-License-Identifier: MIT
 * A small JSON writer: indentation, commas and escapes; numbers with all their digits. Errors stay in the stream. */
#ifndef DQA_EXAMPLES_JSON_H
#define DQA_EXAMPLES_JSON_H

#include <stdint.h>
#include <stdio.h>

typedef struct json {
    FILE* stream;
    int depth;
    int first; /* nothing has been written into the open object or array yet */
} json;

void json_begin(json* j, FILE* stream); /* opens the outermost object */
void json_end(json* j);                 /* closes it */
/* `key` is NULL inside arrays. Strings are UTF-8. Numbers that are not finite become null, as JSON has none. */
void json_open(json* j, const char* key, char bracket); /* '{' or '[' */
void json_close(json* j, char bracket);                 /* '}' or ']' */
void json_number(json* j, const char* key, double value);
void json_integer(json* j, const char* key, int64_t value);
void json_boolean(json* j, const char* key, int value);
void json_string(json* j, const char* key, const char* value); /* NULL value: null */
/* n numbers on one line, `stride` apart in x. */
void json_numbers(json* j, const char* key, const double* x, int64_t n, int64_t stride);
/* The stream, for a value of the caller's own making to be written next. */
FILE* json_value(json* j, const char* key);

#endif
