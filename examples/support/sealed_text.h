/* SPDX-License-Identifier: MIT
 * Text files whose last line is a checksum of all before it, so that damage is found before anything is read. */
#ifndef DQA_EXAMPLES_SEALED_TEXT_H
#define DQA_EXAMPLES_SEALED_TEXT_H

#include "memory_text.h"

/* Seals the text and writes it to folder/name, whole or not at all; the text is gone afterwards. DONE or FAILED (said).
 */
int sealed_text_write(memory_text* t, const char* folder, const char* name);
/* The text of folder/name without its seal, which begins with `magic`; owned. NULL (said) where it cannot be read, is
 * damaged or begins otherwise. */
char* sealed_text_read(const char* folder, const char* name, const char* magic);

#endif
