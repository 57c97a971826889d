/* SPDX-License-Identifier: MIT
 * Files that appear whole or not at all: written under a temporary name, synchronised, then renamed. */
#ifndef DQA_EXAMPLES_OUTPUT_H
#define DQA_EXAMPLES_OUTPUT_H

#include <stdio.h>

typedef struct output_file {
    FILE* stream;  /* write here with stdio; errors are sticky in the stream and found by output_commit */
    char* path;    /* the final name */
    char* partial; /* the temporary name, beside it */
} output_file;

/* "folder/name" in new memory, or NULL (said) when memory ran out. */
char* output_path(const char* folder, const char* name);
/* Makes sure that `folder` exists and may be written to; *created says whether it had to be made. DONE or FAILED. */
int output_folder(const char* folder, int* created);
/* Removes folder/name if there is one. */
void output_remove(const char* folder, const char* name);
/* Opens folder/name for writing. DONE or FAILED (said). */
int output_open(output_file* file, const char* folder, const char* name);
/* Finishes the file: any error since output_open, also a full disk found late, is said, and then neither a new file
 * nor a temporary one remains and an older file of the name is untouched. Closes the file in either case. */
int output_commit(output_file* file);
/* Closes the file and leaves nothing of it; harmless after output_commit or a failed output_open. */
void output_discard(output_file* file);

#endif
