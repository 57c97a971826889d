/* SPDX-License-Identifier: MIT
 * Where the shapes that come with the examples lie. */
#ifndef DQA_EXAMPLES_SHAPES_H
#define DQA_EXAMPLES_SHAPES_H

#include <stdint.h>

/* Names of the twelve of the paper's large dataset: four sharks, seven goldfish, a submarine; NULL ends them. */
extern const char* const shapes_twelve[];

int32_t shapes_count(void);
/* Path of a shipped mesh in new memory; NULL (said) when the folder cannot be found. Looks into the environment
 * variable DQA_SHAPES_DIR, then shapes and ../share/diffaqua/shapes, seen from the folder of the executable. */
char* shapes_path(int32_t index);
/* The same of a file in that folder. */
char* shapes_named(const char* name);
/* 1 when the folder has the file. */
int shapes_has(const char* name);

#endif
