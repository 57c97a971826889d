/* SPDX-License-Identifier: MIT
 * The search without gradients, as a C program uses it. */
#include "support.h"

enum { N = 3 };

static double bowl(const double* x) {
    double s = 0.0;
    int i;
    for (i = 0; i < N; ++i) s += (i + 1.0) * (x[i] - i) * (x[i] - i);
    return s;
}

static void generation(dqa_cma_es* search) {
    double x[8 * N], values[8];
    int k;
    ok(dqa_cma_es_ask(search, x, 7 * N));
    for (k = 0; k < 7; ++k) values[k] = bowl(x + N * k);
    ok(dqa_cma_es_tell(search, values, 7));
}

static void arguments_are_checked(void** state) {
    static const double mean[N] = {0.0, 0.0, 0.0}, wrong_mean[N] = {0.0, NAN, 0.0}, wrong_scales[N] = {1.0, 1.0, 0.0};
    dqa_cma_es_options options;
    dqa_cma_es_info info;
    dqa_cma_es* search = (dqa_cma_es*)&search;
    double x[7 * N], values[7] = {0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0}, value;
    (void)state;
    refused(dqa_cma_es_options_init(NULL, sizeof options), DQA_ERROR_ARGUMENT, "options");
    ok(dqa_cma_es_options_init(&options, sizeof options));
    refused(dqa_cma_es_create(&options, mean, NULL, N, NULL), DQA_ERROR_ARGUMENT, "search");
    refused(dqa_cma_es_create(&options, NULL, NULL, N, &search), DQA_ERROR_ARGUMENT, "mean");
    assert_null(search);
    refused(dqa_cma_es_create(&options, wrong_mean, NULL, N, &search), DQA_ERROR_ARGUMENT, "mean");
    refused(dqa_cma_es_create(&options, mean, wrong_scales, N, &search), DQA_ERROR_ARGUMENT, "scales");
    refused(dqa_cma_es_create(&options, mean, NULL, 0, &search), DQA_ERROR_ARGUMENT, "n");
    refused(dqa_cma_es_create(&options, mean, NULL, 4000, &search), DQA_ERROR_ARGUMENT, "n");
    options.population = 1;
    refused(dqa_cma_es_create(&options, mean, NULL, N, &search), DQA_ERROR_ARGUMENT, "population");
    options.population = (int64_t)1 << 40;
    refused(dqa_cma_es_create(&options, mean, NULL, N, &search), DQA_ERROR_ARGUMENT, "population");
    options.population = 0;
    options.sigma = 0.0;
    refused(dqa_cma_es_create(&options, mean, NULL, N, &search), DQA_ERROR_ARGUMENT, "sigma");
    options.sigma = NAN;
    refused(dqa_cma_es_create(&options, mean, NULL, N, &search), DQA_ERROR_ARGUMENT, "sigma");
    options.sigma = 0.3;
    options.flags = 1;
    refused(dqa_cma_es_create(&options, mean, NULL, N, &search), DQA_ERROR_ARGUMENT, "flags");
    assert_null(search);
    ok(dqa_cma_es_create(NULL, mean, NULL, N, &search));
    ok(dqa_cma_es_get_info(search, &info, sizeof info));
    assert_int_equal(info.population, 7); /* 4 + floor(3 ln 3) */
    assert_int_equal(info.asked, 0);
    refused(dqa_cma_es_tell(search, values, 7), DQA_ERROR_STATE, "asked");
    refused(dqa_cma_es_best(search, x, N, &value), DQA_ERROR_STATE, "best");
    refused(dqa_cma_es_ask(NULL, x, 7 * N), DQA_ERROR_ARGUMENT, "search");
    refused(dqa_cma_es_ask(search, NULL, 7 * N), DQA_ERROR_ARGUMENT, "candidates");
    refused(dqa_cma_es_ask(search, x, N), DQA_ERROR_ARGUMENT, "count");
    ok(dqa_cma_es_ask(search, x, 7 * N));
    refused(dqa_cma_es_tell(search, values, 6), DQA_ERROR_ARGUMENT, "population");
    values[2] = NAN;
    refused(dqa_cma_es_tell(search, values, 7), DQA_ERROR_ARGUMENT, "values");
    values[2] = -INFINITY;
    refused(dqa_cma_es_tell(search, values, 7), DQA_ERROR_ARGUMENT, "values");
    values[2] = INFINITY;
    ok(dqa_cma_es_tell(search, values, 7));
    refused(dqa_cma_es_tell(search, values, 7), DQA_ERROR_STATE, "asked");
    refused(dqa_cma_es_best(search, x, N - 1, &value), DQA_ERROR_ARGUMENT, "n");
    refused(dqa_cma_es_mean(search, NULL, N), DQA_ERROR_ARGUMENT, "mean");
    refused(dqa_cma_es_save(search, "no/such/folder/search.dqa"), DQA_ERROR_IO, "folder");
    dqa_cma_es_free(search);
    search = (dqa_cma_es*)&search;
    assert_int_equal(dqa_cma_es_load("no_such_file.dqa", &search), DQA_ERROR_IO);
    assert_null(search);
    dqa_cma_es_free(NULL);
}

/* Sums and squares must not leave the range of doubles where the answer does not. */
static void projections_of_extreme_numbers(void** state) {
    static const double huge[][3] = {{1e308, 1e308, -1e308}, {1e308, -1e308, 0.0}, {-1e308, -1e308, -1e308},
                                     {1e-308, 0.0, -1e-308}, {3.0, 3.0, 3.0},      {1e16, 1e16 + 2.0, 0.0}};
    static const double expected[][3] = {{0.5, 0.5, 0.0},
                                         {1.0, 0.0, 0.0},
                                         {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0},
                                         {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0},
                                         {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0},
                                         {0.0, 1.0, 0.0}};
    size_t k, i;
    (void)state;
    for (k = 0; k < sizeof huge / sizeof *huge; ++k) {
        double x[3];
        memcpy(x, huge[k], sizeof x);
        ok(dqa_project_simplex(x, 3));
        for (i = 0; i < 3; ++i) assert_true(fabs(x[i] - expected[k][i]) <= 1e-15);
    }
}

static void steps_of_extreme_numbers(void** state) {
    double x = 1.0, gradient = 1e308, rate = 0.1, first = 0.0, second = 0.0;
    (void)state;
    refused(dqa_adam_step(&x, &gradient, &rate, &first, &second, 1, 1), DQA_DIVERGED, "x[0]");
    assert_true(x == 1.0 && first == 0.0 && second == 0.0);
    gradient = 1e150;
    ok(dqa_adam_step(&x, &gradient, &rate, &first, &second, 1, 1));
    assert_true(fabs(x - 0.9) <= 1e-12 && isfinite(first) && isfinite(second));
    x = 1e308, rate = 1e308, gradient = -1.0, first = second = 0.0;
    refused(dqa_adam_step(&x, &gradient, &rate, &first, &second, 1, 1), DQA_DIVERGED, "x[0]");
    gradient = 1e-308, rate = 0.1, x = 1.0;
    ok(dqa_adam_step(&x, &gradient, &rate, &first, &second, 1, 1));
    assert_true(x == 1.0 || fabs(x - 1.0) < 1e-12);
}

static void a_minimum_is_found_and_a_saved_search_goes_on(void** state) {
    static const double start[N] = {3.0, 3.0, 3.0}, scales[N] = {1.0, 2.0, 0.5};
    dqa_cma_es *search, *again;
    dqa_cma_es_info info;
    double x[N], mean[N], other[N], value, other_value;
    int g, i;
    (void)state;
    ok(dqa_cma_es_create(NULL, start, scales, N, &search));
    for (g = 0; g < 40; ++g) generation(search);
    ok(dqa_cma_es_save(search, "search.dqa"));
    ok(dqa_cma_es_load("search.dqa", &again));
    for (g = 0; g < 160; ++g) {
        generation(search);
        generation(again);
    }
    ok(dqa_cma_es_best(search, x, N, &value));
    ok(dqa_cma_es_best(again, other, N, &other_value));
    assert_memory_equal(x, other, sizeof x);
    assert_memory_equal(&value, &other_value, sizeof value);
    assert_true(value < 1e-16);
    assert_true(bowl(x) == value);
    ok(dqa_cma_es_mean(search, mean, N));
    for (i = 0; i < N; ++i) assert_true(fabs(mean[i] - i) < 1e-7);
    ok(dqa_cma_es_best(search, NULL, 0, &value));
    ok(dqa_cma_es_get_info(again, &info, sizeof info));
    assert_int_equal(info.struct_size, sizeof info);
    assert_int_equal(info.generation, 200);
    assert_int_equal(info.evaluations, 1400);
    assert_true(info.sigma > 0.0 && info.widest < 1e-6 && info.axis_ratio >= 1.0);
    dqa_cma_es_free(search);
    dqa_cma_es_free(again);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arguments_are_checked), cmocka_unit_test(projections_of_extreme_numbers),
        cmocka_unit_test(steps_of_extreme_numbers), cmocka_unit_test(a_minimum_is_found_and_a_saved_search_goes_on)};
    return cmocka_run_group_tests_name("optimize", tests, NULL, NULL);
}
