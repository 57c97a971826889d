/* SPDX-License-Identifier: MIT
 * Messages on stderr, and the exit codes that the functions of the examples hand up to main. */
#ifndef DQA_EXAMPLES_SAY_H
#define DQA_EXAMPLES_SAY_H

#include "diffaqua.h"

#define DONE 0          /* went well */
#define FAILED 1        /* something went wrong and has been said */
#define USAGE 2         /* the command line was wrong and it has been said */
#define INTERRUPTED 130 /* stopped by SIGINT or SIGTERM; as shells report it */

#ifdef __GNUC__
#define SAY_FORMAT __attribute__((format(printf, 1, 2)))
#else
#define SAY_FORMAT
#endif

/* The name that starts every message; a string that outlives the program's messages. */
void say_program(const char* name);
/* One line "name: ..." on stderr. */
void say(const char* format, ...) SAY_FORMAT;
/* Says that memory ran out; returns FAILED. */
int say_no_memory(void);
/* DONE for DQA_SUCCESS, INTERRUPTED (silently) for DQA_CANCELLED; anything else is said with the library's own
 * message, "cannot <doing>: ...", and FAILED. */
int say_status(dqa_status status, const char* doing);
/* Tells whether an unfinished line (a progress bar) stands on the terminal, so that a message does not run into it. */
void say_line_is_open(int open);

#endif
