/* SPDX-License-Identifier: MIT
 * The first signal asks the examples to stop; a second one, of the same or of the other kind, ends them even where
 * nothing looks at the flag. */
#define _POSIX_C_SOURCE 200809L
/* cmocka.h needs the standard headers before it. */
/* clang-format off */
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>
/* clang-format on */

#include "support/interrupt.h"
#include "support/say.h"

/* A child that gets the signals one after the other; its wait status. */
static int status_after(int first, int second) {
    int status = 0;
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        dqa_cancel_token* token = NULL;
        if (dqa_cancel_token_create(&token) != DQA_SUCCESS || interrupt_install(token) != DONE) _exit(3);
        if (interrupted()) _exit(4);
        raise(first);
        if (!interrupted()) _exit(5);
        if (second != 0) raise(second);
        _exit(0);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    return status;
}

static void first_sets_the_flag(void** state) {
    (void)state;
    assert_int_equal(status_after(SIGINT, 0), 0);
    assert_int_equal(status_after(SIGTERM, 0), 0);
}

static void second_ends(void** state) {
    static const int pairs[][2] = {{SIGINT, SIGINT}, {SIGINT, SIGTERM}, {SIGTERM, SIGINT}, {SIGTERM, SIGTERM}};
    size_t k;
    (void)state;
    for (k = 0; k < sizeof pairs / sizeof pairs[0]; ++k) {
        const int status = status_after(pairs[k][0], pairs[k][1]);
        assert_true(WIFSIGNALED(status));
        assert_int_equal(WTERMSIG(status), pairs[k][1]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_sets_the_flag),
        cmocka_unit_test(second_ends),
    };
    return cmocka_run_group_tests_name("interrupt", tests, NULL, NULL);
}
