/* SPDX-License-Identifier: MIT
 * Options and records as structs of Octave, by the names of their fields; losses. */
#include <string.h>

#include "gateway.h"

enum { INT32, INT64, UINT64, DOUBLE };

typedef struct field {
    const char* name;
    int type;
    size_t offset, size; /* bytes */
} field;

#define ROW(type, name, kind) \
    { #name, kind, offsetof(type, name), sizeof(((type*)0)->name) }
#define END \
    { NULL, 0, 0, 0 }

/* What means something to a caller; a test compares the names with those of the header. */
/* clang-format off */
static const field shape_space_options_fields[] = {
    ROW(dqa_shape_space_options, dims, INT32), ROW(dqa_shape_space_options, cells_x, INT32),
    ROW(dqa_shape_space_options, cells_y, INT32), ROW(dqa_shape_space_options, cells_z, INT32),
    ROW(dqa_shape_space_options, margin, INT32), ROW(dqa_shape_space_options, margin_across, INT32),
    ROW(dqa_shape_space_options, up, INT32), ROW(dqa_shape_space_options, subsamples, INT32),
    ROW(dqa_shape_space_options, peak, INT32), ROW(dqa_shape_space_options, max_iterations, INT32),
    ROW(dqa_shape_space_options, threads, INT32), ROW(dqa_shape_space_options, body_length, DOUBLE),
    ROW(dqa_shape_space_options, cell_size, DOUBLE), ROW(dqa_shape_space_options, sigma, DOUBLE),
    ROW(dqa_shape_space_options, tolerance, DOUBLE), ROW(dqa_shape_space_options, interpolation, INT32),
    ROW(dqa_shape_space_options, automatic_fins, INT32), ROW(dqa_shape_space_options, refinement, INT64), END};
static const field actuator_options_fields[] = {
    ROW(dqa_actuator_options, category, INT32), ROW(dqa_actuator_options, kind, INT32),
    ROW(dqa_actuator_options, mean, DOUBLE), ROW(dqa_actuator_options, variance, DOUBLE),
    ROW(dqa_actuator_options, euler, DOUBLE), ROW(dqa_actuator_options, side, INT32),
    ROW(dqa_actuator_options, layers, INT32), END};
static const field shape_space_info_fields[] = {
    ROW(dqa_shape_space_info, dims, INT32), ROW(dqa_shape_space_info, cells_x, INT32),
    ROW(dqa_shape_space_info, cells_y, INT32), ROW(dqa_shape_space_info, cells_z, INT32),
    ROW(dqa_shape_space_info, n_bases, INT32), ROW(dqa_shape_space_info, n_signals, INT32),
    ROW(dqa_shape_space_info, is_built, INT32), ROW(dqa_shape_space_info, n_cells, INT64),
    ROW(dqa_shape_space_info, cell_size, DOUBLE), END};
static const field signal_info_fields[] = {
    ROW(dqa_signal_info, category, INT32), ROW(dqa_signal_info, kind, INT32), ROW(dqa_signal_info, layer, INT32),
    ROW(dqa_signal_info, group, INT32), END};
static const field simulator_options_fields[] = {
    ROW(dqa_simulator_options, threads, INT32), ROW(dqa_simulator_options, method, INT32),
    ROW(dqa_simulator_options, water, INT32), ROW(dqa_simulator_options, max_newton, INT32),
    ROW(dqa_simulator_options, max_linear, INT32), ROW(dqa_simulator_options, instruction_set, INT32),
    ROW(dqa_simulator_options, integrator, INT32), ROW(dqa_simulator_options, material, INT32),
    ROW(dqa_simulator_options, planar, INT32), ROW(dqa_simulator_options, preconditioner, INT32),
    ROW(dqa_simulator_options, time_step, DOUBLE), ROW(dqa_simulator_options, young_modulus, DOUBLE),
    ROW(dqa_simulator_options, poisson_ratio, DOUBLE), ROW(dqa_simulator_options, density, DOUBLE),
    ROW(dqa_simulator_options, muscle_stiffness, DOUBLE), ROW(dqa_simulator_options, contraction, DOUBLE),
    ROW(dqa_simulator_options, threshold, DOUBLE), ROW(dqa_simulator_options, occupancy_floor, DOUBLE),
    ROW(dqa_simulator_options, tolerance, DOUBLE), ROW(dqa_simulator_options, adjoint_tolerance, DOUBLE),
    ROW(dqa_simulator_options, water_density, DOUBLE), ROW(dqa_simulator_options, current, DOUBLE),
    ROW(dqa_simulator_options, drag_coefficients, DOUBLE), ROW(dqa_simulator_options, thrust_coefficients, DOUBLE),
    ROW(dqa_simulator_options, speed_smoothing, DOUBLE), ROW(dqa_simulator_options, angle_smoothing, DOUBLE),
    ROW(dqa_simulator_options, surface_smoothing, DOUBLE), ROW(dqa_simulator_options, water_faces, INT32),
    ROW(dqa_simulator_options, linear_precision, INT32), ROW(dqa_simulator_options, quadrature, INT32),
    ROW(dqa_simulator_options, max_products, INT64), END};
static const field simulator_info_fields[] = {
    ROW(dqa_simulator_info, dims, INT32), ROW(dqa_simulator_info, n_bases, INT32),
    ROW(dqa_simulator_info, n_signals, INT32), ROW(dqa_simulator_info, n_sensors, INT32),
    ROW(dqa_simulator_info, has_design, INT32), ROW(dqa_simulator_info, n_nodes, INT64),
    ROW(dqa_simulator_info, n_active_cells, INT64), ROW(dqa_simulator_info, n_body_cells, INT64),
    ROW(dqa_simulator_info, n_faces, INT64), ROW(dqa_simulator_info, n_muscle_cells, INT64),
    ROW(dqa_simulator_info, factor_entries, INT64), ROW(dqa_simulator_info, steps, INT64),
    ROW(dqa_simulator_info, newton_iterations, INT64), ROW(dqa_simulator_info, linear_iterations, INT64),
    ROW(dqa_simulator_info, adjoint_iterations, INT64), ROW(dqa_simulator_info, time, DOUBLE),
    ROW(dqa_simulator_info, total_mass, DOUBLE), ROW(dqa_simulator_info, volume, DOUBLE),
    ROW(dqa_simulator_info, cell_size, DOUBLE), ROW(dqa_simulator_info, last_residual, DOUBLE),
    ROW(dqa_simulator_info, setup_seconds, DOUBLE), ROW(dqa_simulator_info, barycenter_seconds, DOUBLE), END};
static const field actuator_info_fields[] = {
    ROW(dqa_actuator_info, category, INT32), ROW(dqa_actuator_info, kind, INT32), ROW(dqa_actuator_info, side, INT32),
    ROW(dqa_actuator_info, layers, INT32), ROW(dqa_actuator_info, n_signals, INT32),
    ROW(dqa_actuator_info, first_signal, INT32), ROW(dqa_actuator_info, mean, DOUBLE),
    ROW(dqa_actuator_info, covariance, DOUBLE), ROW(dqa_actuator_info, half, DOUBLE),
    ROW(dqa_actuator_info, normal, DOUBLE), ROW(dqa_actuator_info, edge, DOUBLE),
    ROW(dqa_actuator_info, share, DOUBLE), ROW(dqa_actuator_info, strength, DOUBLE), END};
static const field mlp_options_fields[] = {
    ROW(dqa_mlp_options, n_signals, INT32), ROW(dqa_mlp_options, dims, INT32), ROW(dqa_mlp_options, n_hidden, INT32),
    ROW(dqa_mlp_options, hidden, INT32), ROW(dqa_mlp_options, temporal_encoding, INT32),
    ROW(dqa_mlp_options, period_steps, INT32), ROW(dqa_mlp_options, seed, UINT64),
    ROW(dqa_mlp_options, scale, DOUBLE), END};
static const field callback_controller_options_fields[] = {
    ROW(dqa_callback_controller_options, n_signals, INT32), ROW(dqa_callback_controller_options, n_sensors, INT32),
    ROW(dqa_callback_controller_options, time_step, DOUBLE), END};
static const field controller_info_fields[] = {
    ROW(dqa_controller_info, kind, INT32), ROW(dqa_controller_info, n_signals, INT32),
    ROW(dqa_controller_info, n_sensors, INT32), ROW(dqa_controller_info, has_pullback, INT32),
    ROW(dqa_controller_info, n_parameters, INT64), END};
static const field tape_options_fields[] = {
    ROW(dqa_tape_options, memory_bytes, INT64), END};
static const field tape_statistics_fields[] = {
    ROW(dqa_tape_statistics, steps, INT64), ROW(dqa_tape_statistics, bytes, INT64),
    ROW(dqa_tape_statistics, newton_iterations, INT64), ROW(dqa_tape_statistics, linear_iterations, INT64),
    ROW(dqa_tape_statistics, adjoint_iterations, INT64), ROW(dqa_tape_statistics, worst_residual, DOUBLE),
    ROW(dqa_tape_statistics, worst_adjoint_residual, DOUBLE), ROW(dqa_tape_statistics, checkpoints, INT64),
    ROW(dqa_tape_statistics, recomputed_steps, INT64), ROW(dqa_tape_statistics, rescued_steps, INT64),
    ROW(dqa_tape_statistics, indefinite_steps, INT64), END};
static const field objective_term_fields[] = {
    ROW(dqa_objective_term, kind, INT32), ROW(dqa_objective_term, weight, DOUBLE),
    ROW(dqa_objective_term, target, DOUBLE), ROW(dqa_objective_term, gamma, DOUBLE),
    ROW(dqa_objective_term, epsilon, DOUBLE), END};
static const field gradient_check_options_fields[] = {
    ROW(dqa_gradient_check_options, with_respect_to, INT32), ROW(dqa_gradient_check_options, n_steps, INT32),
    ROW(dqa_gradient_check_options, seed, UINT64), ROW(dqa_gradient_check_options, step, DOUBLE), END};
static const field gradient_check_report_fields[] = {
    ROW(dqa_gradient_check_report, one_sided, INT32), ROW(dqa_gradient_check_report, adjoint, DOUBLE),
    ROW(dqa_gradient_check_report, finite_difference, DOUBLE), ROW(dqa_gradient_check_report, relative_error, DOUBLE),
    ROW(dqa_gradient_check_report, taylor_slope, DOUBLE), ROW(dqa_gradient_check_report, gradient_norm, DOUBLE),
    ROW(dqa_gradient_check_report, step, DOUBLE), END};
static const field cma_es_options_fields[] = {
    ROW(dqa_cma_es_options, population, INT64), ROW(dqa_cma_es_options, seed, UINT64),
    ROW(dqa_cma_es_options, sigma, DOUBLE), END};
static const field cma_es_info_fields[] = {
    ROW(dqa_cma_es_info, asked, INT32), ROW(dqa_cma_es_info, n, INT64), ROW(dqa_cma_es_info, population, INT64),
    ROW(dqa_cma_es_info, generation, INT64), ROW(dqa_cma_es_info, evaluations, INT64),
    ROW(dqa_cma_es_info, sigma, DOUBLE), ROW(dqa_cma_es_info, widest, DOUBLE),
    ROW(dqa_cma_es_info, axis_ratio, DOUBLE), END};

static const struct {
    const char* name;
    const field* fields;
} structs[] = {
    {"dqa_shape_space_options", shape_space_options_fields},
    {"dqa_actuator_options", actuator_options_fields},
    {"dqa_shape_space_info", shape_space_info_fields},
    {"dqa_signal_info", signal_info_fields},
    {"dqa_simulator_options", simulator_options_fields},
    {"dqa_simulator_info", simulator_info_fields},
    {"dqa_actuator_info", actuator_info_fields},
    {"dqa_mlp_options", mlp_options_fields},
    {"dqa_callback_controller_options", callback_controller_options_fields},
    {"dqa_controller_info", controller_info_fields},
    {"dqa_tape_options", tape_options_fields},
    {"dqa_tape_statistics", tape_statistics_fields},
    {"dqa_objective_term", objective_term_fields},
    {"dqa_gradient_check_options", gradient_check_options_fields},
    {"dqa_gradient_check_report", gradient_check_report_fields},
    {"dqa_cma_es_options", cma_es_options_fields},
    {"dqa_cma_es_info", cma_es_info_fields},
};
/* clang-format on */

enum { N_STRUCTS = sizeof structs / sizeof *structs };

static const field* fields_of(call* c, const char* name) {
    for (int s = 0; s < N_STRUCTS; ++s)
        if (strcmp(structs[s].name, name) == 0) return structs[s].fields;
    refuse(c, DQA_ERROR_ARGUMENT, "struct: there is no %s", name);
    return NULL;
}

static size_t length(const field* f) {
    return f->size / (f->type == INT32 ? sizeof(int32_t) : sizeof(double));
}

void give_fields(call* c, const char* struct_name) {
    const field* fields = fields_of(c, struct_name);
    mxArray* names;
    mwSize n = 0;
    while (fields[n].name != NULL) ++n;
    names = mxCreateCellMatrix(n, 1);
    for (mwSize k = 0; k < n; ++k) mxSetCell(names, k, mxCreateString(fields[k].name));
    give(c, names);
}

/* ------------------------------------------------------------------ in */
static void set_field(call* c, const field* f, const mxArray* value, char* filled) {
    const double whole_limit = 9007199254740992.0; /* what doubles hold exactly */
    const size_t n = length(f);
    char* to = filled + f->offset;
    if (mxGetNumberOfElements(value) != n)
        refuse(c, DQA_ERROR_ARGUMENT, "%s: expected %d number%s, got %.0f", f->name, (int)n, n == 1 ? "" : "s",
               (double)mxGetNumberOfElements(value));
    for (size_t k = 0; k < n; ++k) switch (f->type) {
            case INT32:
                ((int32_t*)to)[k] = (int32_t)whole_element(c, value, k, f->name, INT32_MIN, INT32_MAX);
                break;
            case INT64:
                ((int64_t*)to)[k] = whole_element(c, value, k, f->name, -whole_limit, whole_limit);
                break;
            case UINT64:
                ((uint64_t*)to)[k] = (uint64_t)whole_element(c, value, k, f->name, 0.0,
                                                             mxIsUint64(value) ? 18446744073709551615.0 : whole_limit);
                break;
            default:
                ((double*)to)[k] = number_element(c, value, k, f->name);
        }
}

static void unknown(call* c, const char* name, const field* fields) {
    char list[1024] = "";
    for (const field* f = fields; f->name != NULL; ++f) {
        if (f != fields) strncat(list, ", ", sizeof list - strlen(list) - 1);
        strncat(list, f->name, sizeof list - strlen(list) - 1);
    }
    refuse(c, DQA_ERROR_ARGUMENT, "unknown option '%s', expected one of %s", name, list);
}

/* Writes the fields of element `index` of a struct array; empty ones, and the one called `besides`, are left out. */
static void fill_from(call* c, const mxArray* given, mwIndex index, const field* fields, void* filled,
                      const char* besides) {
    const int n = mxGetNumberOfFields(given);
    for (int k = 0; k < n; ++k) {
        const char* name = mxGetFieldNameByNumber(given, k);
        const mxArray* value = mxGetFieldByNumber(given, index, k);
        const field* f = fields;
        if (besides != NULL && strcmp(name, besides) == 0) continue;
        while (f->name != NULL && strcmp(f->name, name) != 0) ++f;
        if (f->name == NULL) unknown(c, name, fields);
        if (value != NULL && !mxIsEmpty(value)) set_field(c, f, value, filled);
    }
}

void fill(call* c, int argument, const char* struct_name, void* filled) {
    if (!is_given(c, argument)) return;
    if (!mxIsStruct(c->in[argument]) || mxGetNumberOfElements(c->in[argument]) != 1)
        refuse(c, DQA_ERROR_ARGUMENT, "options: expected a struct, got %s",
               mxIsStruct(c->in[argument]) ? "several" : mxGetClassName(c->in[argument]));
    fill_from(c, c->in[argument], 0, fields_of(c, struct_name), filled, NULL);
}

/* One term; its path [n][1 + dims] is turned into C's order. */
static void fill_term(call* c, const mxArray* given, mwIndex index, dqa_objective_term* term) {
    const mxArray* path = mxGetField(given, index, "path");
    check(c, dqa_objective_term_init(term, sizeof *term));
    fill_from(c, given, index, fields_of(c, "dqa_objective_term"), term, "path");
    if (path != NULL && !mxIsEmpty(path)) {
        call inner = *c;
        shape s = axes2(-1, -1);
        inner.n_in = 1;
        inner.in = &path;
        term->path = doubles(&inner, 0, "path", &s);
        term->n_path = count(&s);
    }
}

const dqa_objective_term* terms_of(call* c, int argument, int64_t* n_terms) {
    const mxArray* loss = argument < c->n_in ? c->in[argument] : NULL;
    const int is_list = loss != NULL && mxIsCell(loss);
    const mwIndex n = loss == NULL ? 0 : (mwIndex)mxGetNumberOfElements(loss);
    dqa_objective_term* terms;
    if (loss == NULL || !(is_list || mxIsStruct(loss)))
        refuse(c, DQA_ERROR_ARGUMENT, "loss: expected a struct, or a cell array of structs, got %s",
               loss == NULL ? "nothing" : mxGetClassName(loss));
    terms = mxCalloc(n > 0 ? (size_t)n : 1, sizeof *terms);
    for (mwIndex k = 0; k < n; ++k) {
        const mxArray* term = is_list ? mxGetCell(loss, k) : loss;
        if (term == NULL || !mxIsStruct(term) || (is_list && mxGetNumberOfElements(term) != 1))
            refuse(c, DQA_ERROR_ARGUMENT, "loss: term %d: expected a struct", (int)k + 1);
        fill_term(c, term, is_list ? 0 : k, &terms[k]);
    }
    *n_terms = (int64_t)n;
    return terms;
}

/* ------------------------------------------------------------------ out */
void give_record(call* c, const char* struct_name, const void* filled) {
    const field* fields = fields_of(c, struct_name);
    mxArray* record = mxCreateStructMatrix(1, 1, 0, NULL);
    for (const field* f = fields; f->name != NULL; ++f) {
        const char* from = (const char*)filled + f->offset;
        const size_t n = length(f);
        mxArray* value = mxCreateDoubleMatrix(1, (mwSize)n, mxREAL);
        double* to = mxGetPr(value);
        for (size_t k = 0; k < n; ++k)
            to[k] = f->type == INT32    ? (double)((const int32_t*)from)[k]
                    : f->type == INT64  ? (double)((const int64_t*)from)[k]
                    : f->type == UINT64 ? (double)((const uint64_t*)from)[k]
                                        : ((const double*)from)[k];
        mxSetFieldByNumber(record, 0, mxAddField(record, f->name), value);
    }
    give(c, record);
}
