/* SPDX-License-Identifier: MIT
 * Ctrl-C and SIGTERM: ask the library to stop, so that the program can save its work. */
#ifndef DQA_EXAMPLES_INTERRUPT_H
#define DQA_EXAMPLES_INTERRUPT_H

#include "diffaqua.h"

/* From now on SIGINT and SIGTERM set `token` and the flag below; a second signal, of either kind, ends the process at
 * once. A write beyond a file-size limit or into a closed pipe becomes an ordinary error instead of a signal. DONE or
 * FAILED. */
int interrupt_install(dqa_cancel_token* token);
/* 1 after a signal. */
int interrupted(void);
/* To be called before `token` is freed. */
void interrupt_remove(void);

#endif
