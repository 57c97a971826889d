/* SPDX-License-Identifier: MIT
 * What the program runs on. */
#ifndef DQA_EXAMPLES_MACHINE_H
#define DQA_EXAMPLES_MACHINE_H

#include <stddef.h>

/* The processor's model, from /proc/cpuinfo; "unknown" where that does not tell. */
void machine_processor(char* name, size_t size);
/* Processors online, >= 1. */
long machine_processors(void);

#endif
