/* SPDX-License-Identifier: MIT
 * A triangle surface as a binary STL file. */
#ifndef DQA_EXAMPLES_STL_H
#define DQA_EXAMPLES_STL_H

#include <stdint.h>

/* Writes folder/name, whole or not at all. vertices [n_vertices][3] in m; triangles [n_triangles][3].
 * DONE or FAILED (said). */
int stl_write(const char* folder, const char* name, const double* vertices, const int32_t* triangles,
              int64_t n_triangles);

#endif
