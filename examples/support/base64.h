/* SPDX-License-Identifier: MIT
 * Base64 (RFC 4648) of bytes that come in pieces. */
#ifndef DQA_EXAMPLES_BASE64_H
#define DQA_EXAMPLES_BASE64_H

#include <stddef.h>
#include <stdio.h>

typedef struct base64 {
    FILE* stream; /* errors stay in it */
    unsigned char pending[3];
    int n_pending;
} base64;

void base64_begin(base64* b, FILE* stream);
void base64_put(base64* b, const void* data, size_t size);
/* Writes what is pending, with its padding. */
void base64_end(base64* b);

#endif
