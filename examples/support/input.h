/* SPDX-License-Identifier: MIT
 * Files to read. */
#ifndef DQA_EXAMPLES_INPUT_H
#define DQA_EXAMPLES_INPUT_H

#include <stdio.h>

/* A regular file opened to be read; NULL (said) where there is none, or where the path names a folder, a device or a
 * pipe, which could be endless or never begin. */
FILE* input_open(const char* path);

#endif
