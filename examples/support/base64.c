/* SPDX-License-Identifier: MIT */
#include "base64.h"

#include <string.h>

static void triple(base64* b) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned group = (unsigned)b->pending[0] << 16 | (unsigned)b->pending[1] << 8 | (unsigned)b->pending[2];
    char text[4];
    for (int i = 0; i < 4; ++i) text[i] = i <= b->n_pending ? digits[group >> (18 - 6 * i) & 63u] : '=';
    (void)fwrite(text, 1, 4, b->stream);
    memset(b->pending, 0, 3);
    b->n_pending = 0;
}

void base64_begin(base64* b, FILE* stream) {
    memset(b, 0, sizeof *b);
    b->stream = stream;
}

void base64_put(base64* b, const void* data, size_t size) {
    const unsigned char* bytes = data;
    for (size_t i = 0; i < size; ++i) {
        b->pending[b->n_pending++] = bytes[i];
        if (b->n_pending == 3) triple(b);
    }
}

void base64_end(base64* b) {
    if (b->n_pending > 0) triple(b);
}
