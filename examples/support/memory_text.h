/* SPDX-License-Identifier: MIT
 * A text that grows in memory, and a whole file read into memory. */
#ifndef DQA_EXAMPLES_MEMORY_TEXT_H
#define DQA_EXAMPLES_MEMORY_TEXT_H

#include <stddef.h>

typedef struct memory_text {
    char* text; /* zero-terminated once anything was added */
    size_t length;
    size_t capacity;
    int failed; /* memory ran out; stays set */
} memory_text;

void memory_text_begin(memory_text* t);
#ifdef __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
void memory_text_add(memory_text *t, const char *format, ...);
void memory_text_end(memory_text* t);
/* The file's content in new memory with a zero byte behind it; NULL (said) on failure. */
char* memory_text_read(const char* path, size_t* size);

#endif
