/* SPDX-License-Identifier: MIT
 * Signal handling. Only async-signal-safe calls stand in the handler: dqa_cancel_token_set is documented to be one. */
#define _POSIX_C_SOURCE 200809L
#include "interrupt.h"

#include <errno.h>
#include <signal.h>
#include <string.h>

#include "say.h"

static volatile sig_atomic_t signalled = 0;
static dqa_cancel_token* volatile watched = NULL;

/* The first one asks; the second, of either kind, ends the program, wherever it is: whoever sends two means it, and a
 * call that never returns to look at the token must not be what keeps a program alive. */
static void on_signal(int number) {
    const int saved = errno;
    dqa_cancel_token* token = watched;
    (void)number;
    (void)signal(SIGINT, SIG_DFL);
    (void)signal(SIGTERM, SIG_DFL);
    signalled = 1;
    if (token != NULL) (void)dqa_cancel_token_set(token);
    errno = saved;
}

static int set_action(int number, void (*handler)(int), int flags) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = handler;
    action.sa_flags = flags;
    sigemptyset(&action.sa_mask);
    return sigaction(number, &action, NULL);
}

int interrupt_install(dqa_cancel_token* token) {
    const int flags = SA_RESTART; /* a write under way is finished, not torn */
    watched = token;
    if (set_action(SIGINT, on_signal, flags) != 0 || set_action(SIGTERM, on_signal, flags) != 0 ||
        set_action(SIGXFSZ, SIG_IGN, 0) != 0 || set_action(SIGPIPE, SIG_IGN, 0) != 0) {
        say("cannot install the signal handlers: %s", strerror(errno));
        return FAILED;
    }
    return DONE;
}

int interrupted(void) {
    return signalled != 0;
}

void interrupt_remove(void) {
    watched = NULL;
}
