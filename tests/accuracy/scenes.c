/* SPDX-License-Identifier: MIT */
#include "scenes.h"

#include <unistd.h>

void scene_ok(dqa_status status, const char* call, const char* file, int line) {
    if (status == DQA_SUCCESS) return;
    print_error("%s: %s: %s\n", call, dqa_status_name(status), dqa_last_error());
    _fail(file, line);
}

static dqa_shape_space* space_of(const char* first, const char* second, int32_t nx, int32_t ny, int32_t nz,
                                 double tolerance) {
    dqa_shape_space_options o;
    dqa_shape_space* space;
    ok(dqa_shape_space_options_init(&o, sizeof o));
    o.cells_x = nx, o.cells_y = ny, o.cells_z = nz;
    o.tolerance = tolerance;
    ok(dqa_shape_space_create(&o, &space));
    ok(dqa_shape_space_add_mesh_file(space, first, NULL));
    ok(dqa_shape_space_add_mesh_file(space, second, NULL));
    ok(dqa_shape_space_build(space, NULL, NULL));
    return space;
}

dqa_shape_space* scene_real(int32_t nx, int32_t ny, int32_t nz, double tolerance) {
    const char* folder = getenv("DQA_TEST_DATA");
    char orca[4096], shark[4096];
    if (!folder) {
        print_message("skipped: DQA_TEST_DATA is not set; it names the folder of Orca.stl and GreatWhiteShark.stl\n");
        return NULL;
    }
    snprintf(orca, sizeof orca, "%s/Orca.stl", folder);
    snprintf(shark, sizeof shark, "%s/GreatWhiteShark.stl", folder);
    if (access(orca, R_OK) != 0 || access(shark, R_OK) != 0) {
        print_message("skipped: no Orca.stl and GreatWhiteShark.stl in %s\n", folder);
        return NULL;
    }
    return space_of(orca, shark, nx, ny, nz, tolerance);
}

dqa_shape_space* scene_shipped(int32_t nx, int32_t ny, int32_t nz, double tolerance) {
    return space_of(DQA_SHAPES_DIR "/clownfish.stl", DQA_SHAPES_DIR "/tuna.stl", nx, ny, nz, tolerance);
}

dqa_simulator* scene_simulator(dqa_shape_space* space, const dqa_simulator_options* options, double first_weight) {
    const double weights[2] = {first_weight, 1.0 - first_weight};
    dqa_simulator* simulator;
    ok(dqa_simulator_create(space, options, &simulator));
    ok(dqa_simulator_set_weights(simulator, weights, 2, NULL, NULL));
    return simulator;
}

dqa_objective_term scene_travel(void) {
    dqa_objective_term term;
    ok(dqa_objective_term_init(&term, sizeof term));
    return term;
}

double* scene_doubles(int64_t n) {
    double* p = calloc((size_t)(n > 0 ? n : 1), sizeof *p);
    assert_non_null(p);
    return p;
}

static int wanted_set(void) {
    const char* wanted = getenv("DQA_TEST_INSTRUCTION_SET");
    return wanted != NULL ? atoi(wanted) : 0;
}

dqa_simulator_options scene_options(void) {
    dqa_simulator_options options;
    ok(dqa_simulator_options_init(&options, sizeof options));
    options.instruction_set = wanted_set();
    return options;
}

int scene_skipped(void) {
    const int best = strstr(dqa_features(), "avx512") != NULL ? 3 : strstr(dqa_features(), "avx2") != NULL ? 2 : 1;
    return wanted_set() >= best;
}
