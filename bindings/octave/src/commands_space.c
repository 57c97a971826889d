/* SPDX-License-Identifier: MIT
 * Commands of cancel tokens and shape spaces. Names and arguments are those of diffaqua.h; outputs become results,
 * counts of elements are those of the arrays. */
#include "gateway.h"

/* ------------------------------------------------------------------ cancel tokens */
static void token_create(call* c) {
    dqa_cancel_token* token;
    check(c, dqa_cancel_token_create(&token));
    give_object(c, TOKEN, token);
}

static void token_set(call* c) {
    check(c, dqa_cancel_token_set(object(c, 0, "token", TOKEN)));
}

static void token_reset(call* c) {
    check(c, dqa_cancel_token_reset(object(c, 0, "token", TOKEN)));
}

/* ------------------------------------------------------------------ spaces: life */
static dqa_shape_space* space_of(call* c) {
    return object(c, 0, "space", SPACE);
}

static dqa_shape_space* open_space_of(call* c) {
    return object_to_change(c, 0, "space", SPACE);
}

static dqa_shape_space_info info_of(call* c, const dqa_shape_space* space) {
    dqa_shape_space_info info;
    check(c, dqa_shape_space_get_info(space, &info, sizeof info));
    return info;
}

static shape box_of(call* c, const dqa_shape_space* space) {
    const dqa_shape_space_info info = info_of(c, space);
    return axes3(info.cells_x, info.cells_y, info.cells_z);
}

/* (options, token) */
static void space_create(call* c) {
    dqa_shape_space_options options;
    dqa_shape_space* space;
    check(c, dqa_shape_space_options_init(&options, sizeof options));
    fill(c, 0, "dqa_shape_space_options", &options);
    options.cancel = optional_object(c, 1, "cancel", TOKEN);
    check(c, dqa_shape_space_create(&options, &space));
    give_object(c, SPACE, space);
}

static void space_load(call* c) {
    dqa_shape_space* space;
    check(c, dqa_shape_space_load(text(c, 0, "path"), &space));
    give_object(c, SPACE, space);
}

static void space_save(call* c) {
    check(c, dqa_shape_space_save(space_of(c), text(c, 1, "path")));
}

/* (space, progress) */
static void space_build(call* c) {
    dqa_shape_space* space = open_space_of(c);
    const int64_t id = whole(c, 1, "progress");
    check(c, dqa_shape_space_build(space, progress_of(id), user_data_of(id, 0)));
}

/* ------------------------------------------------------------------ bases */
/* (space, vertices, triangles, name) */
static void add_mesh(call* c) {
    dqa_shape_space* space = open_space_of(c);
    shape points = axes2(-1, 3), corners = axes2(-1, 3);
    const double* vertices = doubles(c, 1, "vertices", &points);
    const int32_t* triangles = integers(c, 2, "triangles", &corners);
    int32_t base = 0;
    check(c,
          dqa_shape_space_add_mesh(space, text(c, 3, "name"), vertices, points.n[0], triangles, corners.n[0], &base));
    give_number(c, base);
}

static void add_mesh_file(call* c) {
    dqa_shape_space* space = open_space_of(c);
    int32_t base = 0;
    check(c, dqa_shape_space_add_mesh_file(space, text(c, 1, "path"), &base));
    give_number(c, base);
}

/* (space, cells, name) */
static void add_density(call* c) {
    dqa_shape_space* space = open_space_of(c);
    shape s = box_of(c, space);
    const double* cells = doubles(c, 1, "cells", &s);
    int32_t base = 0;
    check(c, dqa_shape_space_add_density(space, text(c, 2, "name"), cells, count(&s), &base));
    give_number(c, base);
}

/* (space, corners, name) */
static void add_polygon(call* c) {
    dqa_shape_space* space = open_space_of(c);
    shape s = axes2(-1, 2);
    const double* corners = doubles(c, 1, "corners", &s);
    int32_t base = 0;
    check(c, dqa_shape_space_add_polygon(space, text(c, 2, "name"), corners, s.n[0], &base));
    give_number(c, base);
}

/* (space, pixels, name) */
static void add_image(call* c) {
    dqa_shape_space* space = open_space_of(c);
    shape s = axes2(-1, -1);
    const double* pixels = doubles(c, 1, "pixels", &s);
    int32_t base = 0;
    check(c, dqa_shape_space_add_image(space, text(c, 2, "name"), pixels, s.n[0], s.n[1], &base));
    give_number(c, base);
}

/* (space, base, options) */
static void add_actuator(call* c) {
    dqa_shape_space* space = open_space_of(c);
    dqa_actuator_options options;
    check(c, dqa_actuator_options_init(&options, sizeof options));
    fill(c, 2, "dqa_actuator_options", &options);
    check(c, dqa_shape_space_add_actuator(space, index_of(c, 1, "base"), &options));
}

/* (space, base, category, side) */
static void get_actuator(call* c) {
    dqa_shape_space* space = space_of(c);
    dqa_actuator_options options;
    check(c, dqa_actuator_options_init(&options, sizeof options));
    check(c, dqa_shape_space_get_actuator(space, index_of(c, 1, "base"), index_of(c, 2, "category"),
                                          index_of(c, 3, "side"), &options));
    give_record(c, "dqa_actuator_options", &options);
}

/* ------------------------------------------------------------------ questions */
static void get_info(call* c) {
    const dqa_shape_space_info info = info_of(c, space_of(c));
    give_record(c, "dqa_shape_space_info", &info);
}

/* (space, signal) */
static void space_signal(call* c) {
    dqa_shape_space* space = space_of(c);
    dqa_signal_info info;
    check(c, dqa_shape_space_signal(space, index_of(c, 1, "signal"), &info, sizeof info));
    give_record(c, "dqa_signal_info", &info);
}

/* (space, base) */
static void base_name(call* c) {
    dqa_shape_space* space = space_of(c);
    give(c, mxCreateString(dqa_shape_space_base_name(space, index_of(c, 1, "base"))));
}

/* (space, base) */
static void get_base(call* c) {
    dqa_shape_space* space = space_of(c);
    const shape s = box_of(c, space);
    double* cells = room(&s);
    check(c, dqa_shape_space_get_base(space, index_of(c, 1, "base"), cells, count(&s)));
    give_doubles(c, cells, s);
}

/* (space, weights) */
static void density(call* c) {
    dqa_shape_space* space = space_of(c);
    shape s = box_of(c, space), share = axes1(-1);
    const double* weights = doubles(c, 1, "weights", &share);
    double* values = room(&s);
    check(c, dqa_shape_space_density(space, weights, count(&share), values, count(&s)));
    give_doubles(c, values, s);
}

/* (space, weights, density_bar) */
static void pullback(call* c) {
    dqa_shape_space* space = space_of(c);
    shape s = box_of(c, space), share = axes1(-1);
    const double* weights = doubles(c, 1, "weights", &share);
    const double* bar = doubles(c, 2, "density_bar", &s);
    double* result = room(&share);
    check(c, dqa_shape_space_pullback(space, weights, count(&share), bar, count(&s), result));
    give_doubles(c, result, share);
}

/* clang-format off */
const command space_commands[] = {
    {"cancel_token_create", token_create, 0, 0},
    {"cancel_token_set", token_set, 1, 1},
    {"cancel_token_reset", token_reset, 1, 1},
    {"shape_space_create", space_create, 0, 2},
    {"shape_space_load", space_load, 1, 1},
    {"shape_space_save", space_save, 2, 2},
    {"shape_space_build", space_build, 2, 2},
    {"shape_space_add_mesh", add_mesh, 4, 4},
    {"shape_space_add_mesh_file", add_mesh_file, 2, 2},
    {"shape_space_add_density", add_density, 3, 3},
    {"shape_space_add_polygon", add_polygon, 3, 3},
    {"shape_space_add_image", add_image, 3, 3},
    {"shape_space_add_actuator", add_actuator, 3, 3},
    {"shape_space_get_actuator", get_actuator, 4, 4},
    {"shape_space_get_info", get_info, 1, 1},
    {"shape_space_signal", space_signal, 2, 2},
    {"shape_space_base_name", base_name, 2, 2},
    {"shape_space_get_base", get_base, 2, 2},
    {"shape_space_density", density, 2, 2},
    {"shape_space_pullback", pullback, 3, 3},
    {NULL, NULL, 0, 0}};
