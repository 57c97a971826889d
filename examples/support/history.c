/* SPDX-License-Identifier: MIT
 * history.csv: numbers with all their digits, names quoted as RFC 4180 asks. */
#include "history.h"

#include <stdio.h>
#include <string.h>

#include "output.h"
#include "say.h"

static void header(FILE* stream, const run* r, const dqa_shape_space* space) {
    static const char* const control[3] = {"a", "omega", "phi"};
    fputs("iteration,loss", stream);
    for (int64_t i = 0; i < r->n_weights; ++i) {
        const char* name = dqa_shape_space_base_name(space, (int32_t)i);
        const int quoted = strpbrk(name, ",\"\r\n") != NULL;
        fputs(quoted ? ",\"weight_" : ",weight_", stream);
        for (; *name != '\0'; ++name) {
            if (*name == '"') fputc('"', stream);
            fputc(*name, stream);
        }
        if (quoted) fputc('"', stream);
    }
    /* The thousands of parameters of a network are in the controller's file. */
    for (int64_t i = 0; i < r->n_control && !r->mlp; ++i) {
        fprintf(stream, ",%s", control[i % 3]);
        if (r->n_control > 3) fprintf(stream, "_%lld", (long long)(i / 3));
    }
    fputs(
        ",grad_norm_weights,grad_norm_control,seconds,cpu_seconds,newton_iterations,linear_iterations,adjoint_"
        "iterations,stage,simulations",
        stream);
    for (int32_t k = 0; k < r->loss->n_terms && r->loss->n_terms > 1; ++k)
        fprintf(stream, ",%s", objective_name(r->loss->kinds[k]));
    if (objective_keeps(r->loss)) fputs(",place,heading", stream);
    fputs("\n", stream);
}

int history_write(const run* r, const dqa_shape_space* space, const char* folder) {
    output_file file;
    if (output_open(&file, folder, HISTORY_FILE) != DONE) return FAILED;
    header(file.stream, r, space);
    for (int64_t k = 0; k < r->iteration; ++k) {
        const history_row* row = &r->rows[k];
        fprintf(file.stream, "%lld,%.17g", (long long)row->iteration, row->loss);
        for (int64_t i = 0; i < (r->mlp ? r->n_weights : r->n); ++i)
            fprintf(file.stream, ",%.17g", r->row_x[k * r->n + i]);
        fprintf(file.stream, ",%.17g,%.17g,%.3f,%.3f,%lld,%lld,%lld,%d,%lld", row->gradient_weights,
                row->gradient_control, row->seconds, row->cpu_seconds, (long long)row->newton_iterations,
                (long long)row->linear_iterations, (long long)row->adjoint_iterations, (int)row->stage + 1,
                (long long)row->simulations);
        for (int32_t t = 0; t < r->loss->n_terms && r->loss->n_terms > 1; ++t)
            fprintf(file.stream, ",%.17g", row->terms[t]);
        if (objective_keeps(r->loss)) fprintf(file.stream, ",%.17g,%.17g", row->place, row->heading);
        fputs("\n", file.stream);
    }
    return output_commit(&file);
}
