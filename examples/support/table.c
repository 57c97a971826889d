/* SPDX-License-Identifier: MIT */
#include "table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "memory_text.h"
#include "say.h"

int table_read(const char* file, const char* unit, double** rows, int64_t* n) {
    size_t size = 0;
    char* text = memory_text_read(file, &size);
    const char* at = text;
    int64_t capacity = 0;
    int bad = 0;
    *rows = NULL;
    *n = 0;
    if (text == NULL) return FAILED;
    while (!bad && *(at += strspn(at, " \t\r\n,;")) != '\0') {
        char* end = NULL;
        const double value = strtod(at, &end);
        if (*n == capacity) {
            double* more = realloc(*rows, (size_t)(capacity = 2 * capacity + 64) * sizeof *more);
            if (more == NULL) {
                free(text);
                return say_no_memory();
            }
            *rows = more;
        }
        bad = end == at || !isfinite(value) || (*n % 4 == 0 && *n >= 4 && !(value > (*rows)[*n - 4]));
        if (!bad) (*rows)[(*n)++] = value;
        at = end;
    }
    free(text);
    if (bad || *n == 0 || *n % 4 != 0) {
        say("%s: expected lines of four numbers, time in s and x, y, z in %s, with times that increase", file, unit);
        return USAGE;
    }
    return DONE;
}
