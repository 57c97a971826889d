/* SPDX-License-Identifier: MIT
 * Versions, status names and texts, the last error, the log handler, the cancel token. */
#include <pthread.h>
#include <stdio.h>

#include "support.h"

/* First in the list: nothing has failed on this thread yet. */
static void last_error_is_empty_at_first(void** state) {
    (void)state;
    assert_non_null(dqa_last_error());
    assert_string_equal(dqa_last_error(), "");
}

static void versions(void** state) {
    char expected[32];
    (void)state;
    snprintf(expected, sizeof expected, "%d.%d.%d", DQA_VERSION_MAJOR, DQA_VERSION_MINOR, DQA_VERSION_PATCH);
    assert_string_equal(dqa_version(), expected);
    assert_int_equal(dqa_abi_version(), DQA_ABI_VERSION);
    assert_non_null(dqa_features());
}

static void every_status_has_name_and_text(void** state) {
    static const struct {
        dqa_status status;
        const char* name;
    } known[] = {
        {DQA_SUCCESS, "DQA_SUCCESS"},
        {DQA_ERROR_ARGUMENT, "DQA_ERROR_ARGUMENT"},
        {DQA_ERROR_STATE, "DQA_ERROR_STATE"},
        {DQA_ERROR_FILE, "DQA_ERROR_FILE"},
        {DQA_ERROR_IO, "DQA_ERROR_IO"},
        {DQA_ERROR_MESH, "DQA_ERROR_MESH"},
        {DQA_ERROR_MEMORY, "DQA_ERROR_MEMORY"},
        {DQA_ERROR_UNSUPPORTED, "DQA_ERROR_UNSUPPORTED"},
        {DQA_NOT_CONVERGED, "DQA_NOT_CONVERGED"},
        {DQA_DIVERGED, "DQA_DIVERGED"},
        {DQA_CANCELLED, "DQA_CANCELLED"},
        {DQA_ERROR_INTERNAL, "DQA_ERROR_INTERNAL"},
    };
    size_t i, j;
    (void)state;
    for (i = 0; i < sizeof known / sizeof *known; ++i) {
        assert_string_equal(dqa_status_name(known[i].status), known[i].name);
        assert_true(strlen(dqa_status_text(known[i].status)) > 0);
        for (j = 0; j < i; ++j) {
            assert_int_not_equal(known[i].status, known[j].status);
            assert_string_not_equal(dqa_status_text(known[i].status), dqa_status_text(known[j].status));
        }
    }
    assert_string_equal(dqa_status_name(1), "unknown status");
    assert_string_equal(dqa_status_name(-1000), "unknown status");
    assert_string_equal(dqa_status_name(INT32_MIN), "unknown status");
    assert_non_null(dqa_status_text(INT32_MAX));
}

static void* other_thread(void* result) {
    *(int*)result = strcmp(dqa_last_error(), "") == 0;
    (void)dqa_project_simplex(NULL, 3); /* this thread's own message, which the first one must not see */
    return NULL;
}

static void last_error_belongs_to_its_thread(void** state) {
    double x[1] = {1.0};
    char before[512];
    pthread_t thread;
    int was_empty = 0;
    (void)state;
    refused(dqa_project_simplex(x, -7), DQA_ERROR_ARGUMENT, "n");
    snprintf(before, sizeof before, "%s", dqa_last_error());
    assert_int_equal(pthread_create(&thread, NULL, other_thread, &was_empty), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_true(was_empty);
    assert_string_equal(dqa_last_error(), before);
}

/* A success leaves the message of the last failure, which is what the header promises. */
static void success_keeps_the_message(void** state) {
    double x[1] = {1.0};
    char before[512];
    (void)state;
    refused(dqa_project_simplex(NULL, 1), DQA_ERROR_ARGUMENT, "x");
    snprintf(before, sizeof before, "%s", dqa_last_error());
    ok(dqa_project_simplex(x, 1));
    assert_string_equal(dqa_last_error(), before);
}

/* Numbers of messages by level, and whether one of them held the text that is looked for. */
typedef struct journal {
    const char* text;
    int seen;
    int count[DQA_LOG_DEBUG + 1];
} journal;

static void take_down(int32_t level, const char* message, void* user_data) {
    journal* j = user_data;
    assert_non_null(message);
    assert_true(level >= DQA_LOG_ERROR && level <= DQA_LOG_DEBUG);
    ++j->count[level];
    if (j->text && strstr(message, j->text)) j->seen = 1;
}

static void swim(int64_t steps) {
    dqa_shape_space* space = tiny_space();
    dqa_simulator* simulator = tiny_simulator(space);
    dqa_controller* controller = tiny_controller(simulator);
    ok(dqa_simulator_rollout(simulator, controller, steps, NULL, NULL, NULL));
    dqa_controller_free(controller);
    dqa_simulator_free(simulator);
    dqa_shape_space_free(space);
}

static void log_levels(void** state) {
    journal j = {"design set: ", 0, {0}}, steps = {"step 3: ", 0, {0}}, after = {NULL, 0, {0}};
    (void)state;
    ok(dqa_set_log_handler(take_down, DQA_LOG_INFO, &j));
    swim(3);
    assert_true(j.seen);
    assert_int_equal(j.count[DQA_LOG_INFO], 1);
    assert_int_equal(j.count[DQA_LOG_DEBUG], 0);
    ok(dqa_set_log_handler(take_down, DQA_LOG_DEBUG, &steps));
    swim(3);
    assert_true(steps.seen);
    assert_true(steps.count[DQA_LOG_DEBUG] >= 4); /* three steps and a barycentre */
    ok(dqa_set_log_handler(NULL, 0, &after));
    swim(1);
    assert_int_equal(j.count[DQA_LOG_INFO], 1);
    refused(dqa_set_log_handler(take_down, 0, &after), DQA_ERROR_ARGUMENT, "level");
    refused(dqa_set_log_handler(take_down, 5, &after), DQA_ERROR_ARGUMENT, "level");
    swim(1);
    assert_int_equal(after.count[DQA_LOG_INFO] + after.count[DQA_LOG_DEBUG], 0);
}

static void cancel_token_null(void** state) {
    (void)state;
    refused(dqa_cancel_token_create(NULL), DQA_ERROR_ARGUMENT, "token");
    refused(dqa_cancel_token_set(NULL), DQA_ERROR_ARGUMENT, "token");
    refused(dqa_cancel_token_reset(NULL), DQA_ERROR_ARGUMENT, "token");
    dqa_cancel_token_free(NULL);
}

static void cancel_token_stops_and_lets_go(void** state) {
    dqa_shape_space_options options = tiny_options();
    dqa_simulator_options scene;
    dqa_shape_space* space = NULL;
    dqa_simulator* simulator = NULL;
    dqa_cancel_token* token = NULL;
    double* cells = doubles(N_CELLS);
    double weight = 1.0;
    (void)state;
    ok(dqa_cancel_token_create(&token));
    options.cancel = token;
    ok(dqa_shape_space_create(&options, &space));
    ellipsoid(cells, 6.0, 2.0, 2.0);
    ok(dqa_shape_space_add_density(space, "a", cells, N_CELLS, NULL));
    ok(dqa_shape_space_build(space, NULL, NULL));
    ok(dqa_simulator_options_init(&scene, sizeof scene));
    scene.cancel = token;
    ok(dqa_simulator_create(space, &scene, &simulator));

    ok(dqa_cancel_token_set(token));
    assert_int_equal(dqa_simulator_set_weights(simulator, &weight, 1, NULL, NULL), DQA_CANCELLED);
    ok(dqa_cancel_token_reset(token));
    ok(dqa_simulator_set_weights(simulator, &weight, 1, NULL, NULL));

    dqa_simulator_free(simulator);
    dqa_shape_space_free(space);
    dqa_cancel_token_free(token);
    free(cells);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(last_error_is_empty_at_first),
        cmocka_unit_test(versions),
        cmocka_unit_test(every_status_has_name_and_text),
        cmocka_unit_test(last_error_belongs_to_its_thread),
        cmocka_unit_test(success_keeps_the_message),
        cmocka_unit_test(log_levels),
        cmocka_unit_test(cancel_token_null),
        cmocka_unit_test(cancel_token_stops_and_lets_go),
    };
    return cmocka_run_group_tests_name("status", tests, NULL, NULL);
}
