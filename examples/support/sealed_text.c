/* SPDX-License-Identifier: MIT */
#include "sealed_text.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "hash.h"
#include "output.h"
#include "say.h"

int sealed_text_write(memory_text* t, const char* folder, const char* name) {
    output_file file;
    int outcome = DONE;
    memory_text_add(t, "checksum %016" PRIx64 "\n", t->failed ? 0 : hash_bytes(t->text, t->length));
    if (t->failed) outcome = say_no_memory();
    if (outcome == DONE) outcome = output_open(&file, folder, name);
    if (outcome == DONE) {
        (void)fwrite(t->text, 1, t->length, file.stream);
        outcome = output_commit(&file);
    }
    memory_text_end(t);
    return outcome;
}

/* Cuts the seal off where it is right and the text begins as it must. */
static int open_seal(char* text, size_t size, const char* magic) {
    char line[32];
    const size_t tail = (size_t)snprintf(line, sizeof line, "checksum %016x\n", 0u);
    if (size < tail || strncmp(text, magic, strlen(magic)) != 0) return 0;
    (void)snprintf(line, sizeof line, "checksum %016" PRIx64 "\n", hash_bytes(text, size - tail));
    if (memcmp(text + size - tail, line, tail) != 0) return 0;
    text[size - tail] = '\0';
    return 1;
}

char* sealed_text_read(const char* folder, const char* name, const char* magic) {
    char* path = output_path(folder, name);
    size_t size = 0;
    char* text = path != NULL ? memory_text_read(path, &size) : NULL;
    if (text != NULL && !open_seal(text, size, magic)) {
        say("%s is damaged or not a checkpoint of this version; start without --resume", path);
        free(text);
        text = NULL;
    }
    free(path);
    return text;
}
