/* SPDX-License-Identifier: MIT
 * A place or a velocity over time, from a text file: lines of four numbers, time in s and x, y, z, separated by spaces
 * or commas, with times that increase. */
#ifndef DQA_EXAMPLES_TABLE_H
#define DQA_EXAMPLES_TABLE_H

#include <stdint.h>

/* Reads `file` into *rows [*n / 4][4]; owned by the caller, also after a failure. `unit` is that of x, y, z in
 * messages. DONE, USAGE or FAILED (said). */
int table_read(const char* file, const char* unit, double** rows, int64_t* n);

#endif
