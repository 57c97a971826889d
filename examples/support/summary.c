/* SPDX-License-Identifier: MIT
 * summary.json. */
#include "summary.h"

#include "machine.h"
#include "output.h"
#include "say.h"

static void write_schedule(json* j, const options* o) {
    json_open(j, "schedule", '[');
    /* Empty when all is done on one grid with the library's tolerances. */
    for (int32_t k = 0; k < o->plan.n_stages && o->plan.stages[k].tolerance > 0.0; ++k) {
        int32_t cells[3];
        schedule_grid(&o->plan, k, o->grid, cells);
        json_open(j, NULL, '{');
        json_open(j, "grid", '[');
        for (int i = 0; i < 3; ++i) json_integer(j, NULL, cells[i]);
        json_close(j, ']');
        json_number(j, "tolerance", o->plan.stages[k].tolerance);
        json_number(j, "share", o->plan.stages[k].share);
        json_close(j, '}');
    }
    json_close(j, ']');
}

void summary_settings(json* j, const options* o, const run* r, const scene* s) {
    json_open(j, "grid", '[');
    for (int i = 0; i < 3; ++i) json_integer(j, NULL, o->grid[i]);
    json_close(j, ']');
    json_integer(j, "iterations", o->iterations);
    json_integer(j, "steps", o->steps);
    json_number(j, "sigma", o->sigma);
    json_integer(j, "refinement", o->refinement);
    write_schedule(j, o);
    json_number(j, "time_step", s->time_step);
    json_boolean(j, "fixed_control", o->fixed_control);
    json_boolean(j, "quick", o->quick);
    json_boolean(j, "shipped_shapes", o->shipped);
    json_string(j, "controller", o->mlp ? "mlp" : "sine");
    if (objective_is_travel(&o->loss)) {
        json_string(j, "objective", "travel");
    } else {
        json_open(j, "objective", '{');
        for (int32_t k = 0; k < o->loss.n_terms; ++k)
            json_number(j, objective_name(o->loss.kinds[k]), o->loss.weights[k]);
        json_close(j, '}');
    }
    physics_write(&o->laws, j);
    json_number(j, "threshold", s->threshold);
    if (o->model_error > 0.0) {
        json_number(j, "model_error", o->model_error);
        json_number(j, "model_error_estimate", s->model_error);
    } else {
        json_string(j, "model_error", NULL);
    }
    json_integer(j, "checkpoint_mib", o->checkpoint_mib);
    json_string(j, "optimizer", "adam, weights projected onto the simplex");
    json_number(j, "rate_weights", r->rates[0]);
    if (r->mlp) {
        json_number(j, "rate_control", r->rates[r->n_weights]);
    } else {
        json_number(j, "rate_amplitude_phase", r->rates[0]);
        json_number(j, "rate_omega", r->n_control > 1 ? r->rates[r->n_weights + 1] : 0.0);
    }
    json_open(j, "meshes", '[');
    for (int32_t i = 0; i < o->n_meshes; ++i) json_string(j, NULL, o->meshes[i]);
    json_close(j, ']');
    json_string(j, "bases_file", o->bases_file);
    json_integer(j, "actuators_given", o->list.n_actuators);
    json_open(j, "initial_weights", '[');
    for (int32_t i = 0; i < o->n_meshes; ++i) json_number(j, NULL, o->weights[i]);
    json_close(j, ']');
}

void summary_numbers(json* j, const char* key, const double* x, int64_t n) {
    json_open(j, key, '[');
    for (int64_t i = 0; i < n; ++i) json_number(j, NULL, x[i]);
    json_close(j, ']');
}

void summary_design(json* j, const char* key, const run* r, int64_t iteration) {
    const double* x = r->row_x + (iteration - 1) * r->n;
    json_open(j, key, '{');
    json_integer(j, "iteration", iteration);
    json_integer(j, "stage", r->rows[iteration - 1].stage + 1);
    json_number(j, "loss", r->rows[iteration - 1].loss);
    for (int32_t k = 0; k < r->loss->n_terms && r->loss->n_terms > 1; ++k)
        json_number(j, objective_name(r->loss->kinds[k]), r->rows[iteration - 1].terms[k]);
    if (objective_keeps(r->loss)) {
        json_number(j, "place", r->rows[iteration - 1].place);
        json_number(j, "heading", r->rows[iteration - 1].heading);
    }
    summary_numbers(j, "weights", x, r->n_weights);
    summary_numbers(j, "control", x + r->n_weights, r->n_control);
    json_close(j, '}');
}

static void write_proof(json* j, const char* key, const gradient_proof* proof) {
    const dqa_gradient_check_report* c = &proof->report;
    if (proof->state == PROOF_OPEN) {
        json_string(j, key, NULL);
        return;
    }
    json_open(j, key, '{');
    json_boolean(j, "computed", proof->state == PROOF_MADE);
    if (proof->state == PROOF_FAILED) {
        json_string(j, "relative_error", NULL);
        json_close(j, '}');
        return;
    }
    json_number(j, "relative_error", c->relative_error);
    json_number(j, "adjoint", c->adjoint);
    json_number(j, "finite_difference", c->finite_difference);
    json_number(j, "taylor_slope", c->taylor_slope);
    json_number(j, "gradient_norm", c->gradient_norm);
    json_number(j, "step", c->step);
    json_boolean(j, "one_sided", c->one_sided);
    json_close(j, '}');
}

void summary_proofs(json* j, const run* r) {
    json_string(j, "design", r->stage_first > 0 ? "first of the last stage" : "initial");
    json_integer(j, "n_steps", SCENE_PROOF_STEPS);
    write_proof(j, "weights", &r->proof_weights);
    write_proof(j, "control", &r->proof_control);
}

void summary_program(json* j, const char* program) {
    json_string(j, "program", program);
    json_string(j, "library_version", dqa_version());
    json_integer(j, "abi_version", dqa_abi_version());
    json_string(j, "library_features", dqa_features());
}

void summary_machine(json* j, const options* o) {
    char processor[256];
    machine_processor(processor, sizeof processor);
    json_string(j, "processor", processor);
    json_integer(j, "processors", machine_processors());
    json_integer(j, "threads", o->threads);
}

void summary_cells(json* j, const options* o, const dqa_simulator_info* info) {
    json_open(j, "cells", '{');
    json_integer(j, "box", (int64_t)o->grid[0] * o->grid[1] * o->grid[2]);
    json_integer(j, "active", info->n_active_cells);
    json_integer(j, "body", info->n_body_cells);
    json_integer(j, "muscle", info->n_muscle_cells);
    json_integer(j, "nodes", info->n_nodes);
    json_number(j, "cell_size", info->cell_size);
    json_number(j, "total_mass", info->total_mass);
    json_number(j, "volume", info->volume);
    json_close(j, '}');
}

int summary_write(const run* r, const options* o, const scene* s, int converged, const char* folder) {
    dqa_simulator_info info;
    output_file file;
    json j;
    int outcome = say_status(dqa_simulator_get_info(s->simulator, &info, sizeof info), "read the simulator");
    if (outcome == DONE) outcome = output_open(&file, folder, SUMMARY_FILE);
    if (outcome != DONE) return outcome;
    json_begin(&j, file.stream);
    summary_program(&j, "codesign");
    json_string(&j, "status", converged ? "converged" : "all iterations done");
    json_integer(&j, "iterations", r->iteration);
    json_number(&j, "seconds", r->seconds);
    json_number(&j, "loss_first", r->first_loss);
    json_number(&j, "loss_last", r->rows[r->iteration - 1].loss);
    json_number(&j, "loss_best", r->best_loss);
    json_open(&j, "bases", '[');
    for (int64_t i = 0; i < r->n_weights; ++i) json_string(&j, NULL, dqa_shape_space_base_name(s->space, (int32_t)i));
    json_close(&j, ']');
    json_string(&j, "weights_of", "best design");
    summary_numbers(&j, "weights", r->best_x, r->n_weights);
    summary_numbers(&j, "control", r->best_x + r->n_weights, r->n_control);
    summary_design(&j, "first", r, 1);
    summary_design(&j, "best", r, r->best_iteration);
    summary_design(&j, "last", r, r->iteration);
    json_open(&j, "gradient_check", '{');
    summary_proofs(&j, r);
    json_close(&j, '}');
    summary_cells(&j, o, &info);
    json_open(&j, "machine", '{');
    summary_machine(&j, o);
    json_close(&j, '}');
    json_open(&j, "settings", '{');
    summary_settings(&j, o, r, s);
    json_close(&j, '}');
    json_end(&j);
    return output_commit(&file);
}
