/* SPDX-License-Identifier: MIT
 * What a built space answers: density, its pullback, and the file that keeps it. */
#include <stdio.h>

#include "space.h"

static void arguments_are_checked(void** state) {
    static const double wrong[][N_BASES] = {{0.6, 0.5}, {-0.1, 1.1}, {NAN, 0.5}, {0.5, INFINITY}, {0.0, 0.0}};
    double* density = doubles(N_CELLS);
    double* bar = doubles(N_CELLS);
    double weights_bar[N_BASES];
    size_t i;
    (void)state;
    refused(dqa_shape_space_density(NULL, HALF, N_BASES, density, N_CELLS), DQA_ERROR_ARGUMENT, "space");
    refused(dqa_shape_space_density(space, NULL, N_BASES, density, N_CELLS), DQA_ERROR_ARGUMENT, "weights");
    refused(dqa_shape_space_density(space, HALF, N_BASES, NULL, N_CELLS), DQA_ERROR_ARGUMENT, "density");
    refused(dqa_shape_space_density(space, HALF, N_BASES - 1, density, N_CELLS), DQA_ERROR_ARGUMENT, "weights|m");
    refused(dqa_shape_space_density(space, HALF, -1, density, N_CELLS), DQA_ERROR_ARGUMENT, "weights|m");
    refused(dqa_shape_space_density(space, HALF, N_BASES, density, N_CELLS + 1), DQA_ERROR_ARGUMENT, "density|n");

    refused(dqa_shape_space_pullback(NULL, HALF, N_BASES, bar, N_CELLS, weights_bar), DQA_ERROR_ARGUMENT, "space");
    refused(dqa_shape_space_pullback(space, NULL, N_BASES, bar, N_CELLS, weights_bar), DQA_ERROR_ARGUMENT, "weights");
    refused(dqa_shape_space_pullback(space, HALF, N_BASES, NULL, N_CELLS, weights_bar), DQA_ERROR_ARGUMENT,
            "density_bar");
    refused(dqa_shape_space_pullback(space, HALF, N_BASES, bar, N_CELLS, NULL), DQA_ERROR_ARGUMENT, "weights_bar");
    refused(dqa_shape_space_pullback(space, HALF, N_BASES + 1, bar, N_CELLS, weights_bar), DQA_ERROR_ARGUMENT,
            "weights|m");
    refused(dqa_shape_space_pullback(space, HALF, N_BASES, bar, 0, weights_bar), DQA_ERROR_ARGUMENT, "density_bar|n");
    bar[5] = NAN;
    refused(dqa_shape_space_pullback(space, HALF, N_BASES, bar, N_CELLS, weights_bar), DQA_ERROR_ARGUMENT,
            "density_bar");
    bar[5] = 0.0;
    for (i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        refused(dqa_shape_space_density(space, wrong[i], N_BASES, density, N_CELLS), DQA_ERROR_ARGUMENT, "weights");
        refused(dqa_shape_space_pullback(space, wrong[i], N_BASES, bar, N_CELLS, weights_bar), DQA_ERROR_ARGUMENT,
                "weights");
    }
    free(density);
    free(bar);
}

static void needs_a_built_space(void** state) {
    dqa_shape_space* open = tiny_space_open();
    double* density = doubles(N_CELLS);
    double weights_bar[N_BASES];
    (void)state;
    assert_int_equal(dqa_shape_space_density(open, HALF, N_BASES, density, N_CELLS), DQA_ERROR_STATE);
    assert_int_equal(dqa_shape_space_pullback(open, HALF, N_BASES, density, N_CELLS, weights_bar), DQA_ERROR_STATE);
    assert_int_equal(dqa_shape_space_save(open, "open.dqa"), DQA_ERROR_STATE);
    dqa_shape_space_free(open);
    free(density);
}

/* Finite, non-negative, about 1 at its peak, and a body of plausible volume: between those of the two bases. */
static void density_is_plausible(void** state) {
    static const double corners[3][N_BASES] = {{1.0, 0.0}, {0.0, 1.0}, {0.5, 0.5}};
    double* density = doubles(N_CELLS);
    int body[3];
    int i, c;
    (void)state;
    for (i = 0; i < 3; ++i) {
        double peak = 0.0;
        ok(dqa_shape_space_density(space, corners[i], N_BASES, density, N_CELLS));
        body[i] = 0;
        for (c = 0; c < N_CELLS; ++c) {
            assert_true(density[c] >= 0.0 && density[c] < 2.0);
            peak = density[c] > peak ? density[c] : peak;
            body[i] += density[c] > 0.5;
        }
        assert_true(peak > 0.9 && peak < 1.1);
        assert_true(body[i] > 40 && body[i] < N_CELLS / 3);
    }
    free(density);
}

/* <bar, density(w + e d) - density(w - e d)> / 2e against <pullback, d> with d = (1, -1). */
static void pullback_agrees_with_differences(void** state) {
    const double e = 1e-4;
    const double plus[N_BASES] = {0.4 + 1e-4, 0.6 - 1e-4};
    const double minus[N_BASES] = {0.4 - 1e-4, 0.6 + 1e-4};
    const double here[N_BASES] = {0.4, 0.6};
    double* density = doubles(N_CELLS);
    double* bar = doubles(N_CELLS);
    double weights_bar[N_BASES] = {NAN, NAN};
    double difference = 0.0;
    double adjoint;
    int c;
    (void)state;
    for (c = 0; c < N_CELLS; ++c) bar[c] = sin(0.37 * c);
    ok(dqa_shape_space_density(space, plus, N_BASES, density, N_CELLS));
    for (c = 0; c < N_CELLS; ++c) difference += bar[c] * density[c] / (2.0 * e);
    ok(dqa_shape_space_density(space, minus, N_BASES, density, N_CELLS));
    for (c = 0; c < N_CELLS; ++c) difference -= bar[c] * density[c] / (2.0 * e);
    ok(dqa_shape_space_pullback(space, here, N_BASES, bar, N_CELLS, weights_bar));
    adjoint = weights_bar[0] - weights_bar[1];
    assert_true(fabs(weights_bar[0] + weights_bar[1]) <= 1e-9 * fabs(adjoint));
    assert_true(fabs(difference) > 1e-3);
    if (!(fabs(adjoint - difference) <= 1e-4 * fabs(difference)))
        fail_msg("pullback %.12g, differences %.12g", adjoint, difference);
    free(density);
    free(bar);
}

static void file_keeps_every_bit(void** state) {
    dqa_shape_space* loaded = NULL;
    dqa_shape_space_info info, info_loaded;
    dqa_actuator_options actuator, actuator_loaded;
    double* density = doubles(N_CELLS);
    double* density_loaded = doubles(N_CELLS);
    int32_t base;
    (void)state;
    ok(dqa_shape_space_save(space, "space.dqa"));
    ok(dqa_shape_space_load("space.dqa", &loaded));
    ok(dqa_shape_space_get_info(space, &info, sizeof info));
    ok(dqa_shape_space_get_info(loaded, &info_loaded, sizeof info_loaded));
    assert_memory_equal(&info, &info_loaded, sizeof info);
    ok(dqa_shape_space_density(space, HALF, N_BASES, density, N_CELLS));
    ok(dqa_shape_space_density(loaded, HALF, N_BASES, density_loaded, N_CELLS));
    assert_memory_equal(density, density_loaded, N_CELLS * sizeof *density);
    for (base = 0; base < N_BASES; ++base) {
        assert_string_equal(dqa_shape_space_base_name(space, base), dqa_shape_space_base_name(loaded, base));
        ok(dqa_shape_space_get_base(space, base, density, N_CELLS));
        ok(dqa_shape_space_get_base(loaded, base, density_loaded, N_CELLS));
        assert_memory_equal(density, density_loaded, N_CELLS * sizeof *density);
        ok(dqa_actuator_options_init(&actuator, sizeof actuator));
        ok(dqa_actuator_options_init(&actuator_loaded, sizeof actuator_loaded));
        ok(dqa_shape_space_get_actuator(space, base, 0, DQA_SIDE_BOTH, &actuator));
        ok(dqa_shape_space_get_actuator(loaded, base, 0, DQA_SIDE_BOTH, &actuator_loaded));
        assert_memory_equal(&actuator, &actuator_loaded, sizeof actuator);
    }
    assert_int_equal(dqa_shape_space_build(loaded, NULL, NULL), DQA_ERROR_STATE);
    dqa_shape_space_free(loaded);
    free(density);
    free(density_loaded);
}

static long read_file(const char* path, unsigned char** bytes) {
    FILE* file = fopen(path, "rb");
    long length;
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    length = ftell(file);
    assert_true(length > 0);
    rewind(file);
    *bytes = malloc((size_t)length);
    assert_non_null(*bytes);
    assert_int_equal(fread(*bytes, 1, (size_t)length, file), length);
    fclose(file);
    return length;
}

static void write_file(const char* path, const unsigned char* bytes, long length) {
    FILE* file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, (size_t)length, file), length);
    fclose(file);
}

/* Cut anywhere or with any of a sample of bytes turned: an error or a space, never a crash; *space NULL on error. */
static void broken_files_are_refused(void** state) {
    dqa_shape_space* loaded = NULL;
    unsigned char* bytes = NULL;
    long length, at;
    (void)state;
    refused(dqa_shape_space_save(NULL, "x.dqa"), DQA_ERROR_ARGUMENT, "space");
    refused(dqa_shape_space_save(space, NULL), DQA_ERROR_ARGUMENT, "path");
    refused(dqa_shape_space_load(NULL, &loaded), DQA_ERROR_ARGUMENT, "path");
    refused(dqa_shape_space_load("space.dqa", NULL), DQA_ERROR_ARGUMENT, "space");
    assert_int_equal(dqa_shape_space_save(space, "no/such/folder/space.dqa"), DQA_ERROR_IO);
    assert_int_equal(dqa_shape_space_load("no/such/file.dqa", &loaded), DQA_ERROR_IO);
    assert_null(loaded);

    ok(dqa_shape_space_save(space, "whole.dqa"));
    length = read_file("whole.dqa", &bytes);
    for (at = 0; at < length; at += 1 + length / 97) {
        loaded = space;
        write_file("cut.dqa", bytes, at);
        assert_int_equal(dqa_shape_space_load("cut.dqa", &loaded), DQA_ERROR_FILE);
        assert_null(loaded);
    }
    for (at = 0; at < length; at += at < 64 ? 1 : 1 + length / 97) {
        bytes[at] ^= 0xff;
        write_file("turned.dqa", bytes, length);
        bytes[at] ^= 0xff;
        if (dqa_shape_space_load("turned.dqa", &loaded) != DQA_SUCCESS) assert_null(loaded);
        dqa_shape_space_free(loaded);
        loaded = NULL;
    }
    free(bytes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arguments_are_checked), cmocka_unit_test(needs_a_built_space),
        cmocka_unit_test(density_is_plausible),  cmocka_unit_test(pullback_agrees_with_differences),
        cmocka_unit_test(file_keeps_every_bit),  cmocka_unit_test(broken_files_are_refused),
    };
    return cmocka_run_group_tests_name("shape_density", tests, open_space, close_space);
}
