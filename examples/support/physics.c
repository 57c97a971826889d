/* SPDX-License-Identifier: MIT */
#include "physics.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hash.h"
#include "say.h"
#include "table.h"

/* The library's constants count from 0 in these orders. */
static const char* const interpolations[] = {"linear", "bures", NULL};
static const char* const quadratures[] = {"full", "reduced", NULL};
static const char* const materials[] = {"corotated", "volume", "neo-hookean", NULL};
static const char* const integrators[] = {"euler", "bdf2", NULL};

/* Index of `word` among `names`; the first, which is the default, without a word. */
static int parse_choice(const char* option, const char* const* names, const char* word, int32_t* choice) {
    *choice = 0;
    if (word == NULL) return DONE;
    for (int32_t i = 0; names[i] != NULL; ++i)
        if (strcmp(names[i], word) == 0) {
            *choice = i;
            return DONE;
        }
    if (names[2] == NULL)
        say("%s expects %s or %s, not \"%s\"", option, names[0], names[1], word);
    else
        say("%s expects %s, %s or %s, not \"%s\"", option, names[0], names[1], names[2], word);
    return USAGE;
}

static int parse_velocity(const char* text, double velocity[3]) {
    const char* rest = text;
    for (int axis = 0; axis < 3; ++axis) {
        char* end = NULL;
        const double value = strtod(rest, &end);
        if (end == rest || *end != (axis < 2 ? ',' : '\0') || !isfinite(value)) {
            say("--current expects the water's velocity in m/s as three numbers like -0.2,0,0, not \"%s\"", text);
            return USAGE;
        }
        velocity[axis] = value;
        rest = end + 1;
    }
    return DONE;
}

int physics_parse(physics* p, const physics_words* words) {
    int outcome;
    memset(p, 0, sizeof *p);
    p->automatic_fins = words->automatic_fins;
    p->planar = words->planar;
    p->current_file = words->current_file;
    outcome = parse_choice("--interpolation", interpolations, words->interpolation, &p->interpolation);
    if (outcome == DONE) outcome = parse_choice("--material", materials, words->material, &p->material);
    if (outcome == DONE)
        outcome = parse_choice("--quadrature", quadratures, words->quadrature != NULL ? words->quadrature : "reduced",
                               &p->quadrature);
    if (outcome == DONE) outcome = parse_choice("--integrator", integrators, words->integrator, &p->integrator);
    if (outcome != DONE) return outcome;
    if (words->current != NULL && words->current_file != NULL) {
        say("give either --current or --current-file, not both");
        return USAGE;
    }
    if (words->current != NULL) outcome = parse_velocity(words->current, p->current);
    if (words->current_file != NULL) outcome = table_read(words->current_file, "m/s", &p->table, &p->n_table);
    return outcome;
}

void physics_free(physics* p) {
    free(p->table);
    memset(p, 0, sizeof *p);
}

void physics_of_space(const physics* p, dqa_shape_space_options* options) {
    options->interpolation = p->interpolation;
    options->automatic_fins = p->automatic_fins;
}

void physics_of_simulator(const physics* p, dqa_simulator_options* options) {
    options->material = p->material;
    options->quadrature = p->quadrature;
    options->integrator = p->integrator;
    options->planar = p->planar;
    memcpy(options->current, p->current, sizeof options->current);
}

int physics_set_current(const physics* p, dqa_simulator* simulator) {
    const int64_t rows = p->n_table / 4;
    double *times, *velocities;
    int outcome;
    if (rows == 0) return DONE;
    times = malloc((size_t)rows * sizeof *times);
    velocities = malloc((size_t)(3 * rows) * sizeof *velocities);
    outcome = times != NULL && velocities != NULL ? DONE : say_no_memory();
    for (int64_t i = 0; i < rows && outcome == DONE; ++i) {
        times[i] = p->table[4 * i];
        memcpy(velocities + 3 * i, p->table + 4 * i + 1, 3 * sizeof *velocities);
    }
    if (outcome == DONE)
        outcome = say_status(dqa_simulator_set_current_table(simulator, times, rows, velocities, 3 * rows),
                             "set the water's current");
    free(times);
    free(velocities);
    return outcome;
}

void physics_add_settings(const physics* p, memory_text* t) {
    memory_text_add(t, "interpolation %s\nautomatic-fins %d\nmaterial %s\nquadrature %s\nintegrator %s\nplanar %d\n",
                    interpolations[p->interpolation], (int)p->automatic_fins, materials[p->material],
                    quadratures[p->quadrature], integrators[p->integrator], (int)p->planar);
    if (p->n_table > 0)
        memory_text_add(t, "current-file (content %016" PRIx64 ")\n",
                        hash_bytes(p->table, (size_t)p->n_table * sizeof(double)));
    else
        memory_text_add(t, "current %.17g %.17g %.17g\n", p->current[0], p->current[1], p->current[2]);
}

void physics_write(const physics* p, json* j) {
    json_string(j, "interpolation", interpolations[p->interpolation]);
    json_boolean(j, "automatic_fins", p->automatic_fins);
    json_string(j, "material", materials[p->material]);
    json_string(j, "quadrature", quadratures[p->quadrature]);
    json_string(j, "integrator", integrators[p->integrator]);
    json_boolean(j, "planar", p->planar);
    json_open(j, "current", '[');
    for (int i = 0; i < 3 && p->n_table == 0; ++i) json_number(j, NULL, p->current[i]);
    json_close(j, ']');
    json_string(j, "current_file", p->current_file);
}
