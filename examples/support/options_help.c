/* SPDX-License-Identifier: MIT
 * The options of the experiments and the text of their --help. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "options.h"
#include "say.h"

/* The default that is named with an option. */
enum { NOTHING, GRID, ITERATIONS, GENERATIONS, STEPS, SIGMA, REFINEMENT, OUT };

static const struct {
    const char *word, *value, *says;
    int common; /* all experiments know it */
    int names;
} table[] = {
    {"--bases-file", "FILE", "meshes and their muscles from a list; see codesign --help", 0, NOTHING},
    {"--grid", "NXxNYxNZ", "cells of the box, each 8 to 512", 1, GRID},
    {"--iterations", "N", "of Adam, at most", 0, ITERATIONS},
    {"--generations", "N", "of CMA-ES", 0, GENERATIONS},
    {"--steps", "N", "time steps", 0, STEPS},
    {"--rate", "R", "time steps per second (30)", 0, NOTHING},
    {"--sigma", "S", "width of the interpolation's kernel in cells, 0.2 to 16", 1, SIGMA},
    {"--refinement", "N", "finer cells along a cell's edge, between which mass moves, 1 to 4", 0, REFINEMENT},
    {"--only", "LIST", "only these of the optimisations above, with commas between them", 0, NOTHING},
    {"--objective", "LIST", "what is made smallest; see codesign --help (travel)", 0, NOTHING},
    {"--current", "X,Y,Z", "velocity of the water in m/s (still; position_keeping measures it)", 0, NOTHING},
    {"--out", "DIR", "folder of the results", 1, OUT},
    {"--quick", "", "a coarse version, within a minute", 1, NOTHING},
    {"--resume", "", "continue an interrupted run in DIR; give the other options again", 1, NOTHING},
    {"--threads", "N", "results do not depend on it (number of processors, at most 16)", 1, NOTHING},
    {"--help", "", "this text", 1, NOTHING},
};

static int is_word(const char* name, const char* word, size_t length) {
    return strlen(name) == length && strncmp(name, word, length) == 0;
}

int options_known(const options_form* form, const char* word) {
    const size_t length = strcspn(word, "=");
    /* codesign has all but what is for the experiments alone. */
    if (form->words == NULL)
        return !is_word("--generations", word, length) && !is_word("--rate", word, length) &&
               !is_word("--only", word, length);
    /* A help of its own tells of all that the program knows. */
    for (size_t i = 0; i < sizeof table / sizeof table[0] && form->help == NULL; ++i)
        if (table[i].common && is_word(table[i].word, word, length))
            return !form->brief || !is_word("--resume", word, length);
    for (size_t i = 0; form->words[i] != NULL; ++i)
        if (is_word(form->words[i], word, length)) return 1;
    return 0;
}

static void default_text(const options_form* form, const options_preset* p, int which, char* text, size_t size) {
    text[0] = '\0';
    if (which == GRID) (void)snprintf(text, size, "%dx%dx%d", (int)p->grid[0], (int)p->grid[1], (int)p->grid[2]);
    if (which == ITERATIONS) (void)snprintf(text, size, "%" PRId64, p->iterations);
    if (which == GENERATIONS) (void)snprintf(text, size, "%" PRId64, p->generations);
    if (which == STEPS) (void)snprintf(text, size, "%" PRId64, p->steps);
    if (which == SIGMA) (void)snprintf(text, size, "%g", p->sigma);
    if (which == REFINEMENT) (void)snprintf(text, size, "%d", (int)options_refinement(form, p == &form->quick));
    if (which == OUT) (void)snprintf(text, size, "./%s", form->out);
}

int options_print_help(const options_form* form) {
    fputs(form->help != NULL ? form->help : form->about, stdout);
    if (form->help == NULL) fputc('\n', stdout);
    for (size_t i = 0; i < sizeof table / sizeof table[0] && form->help == NULL; ++i) {
        char option[40], usual[64], quick[64];
        if (!options_known(form, table[i].word)) continue;
        (void)snprintf(option, sizeof option, "%s %s", table[i].word, table[i].value);
        default_text(form, &form->shipped, table[i].names, usual, sizeof usual);
        default_text(form, &form->quick, table[i].names, quick, sizeof quick);
        printf("  %-17s %s", option, table[i].says);
        if (usual[0] != '\0' && strcmp(usual, quick) != 0)
            printf(" (%s; quick %s)", usual, quick);
        else if (usual[0] != '\0')
            printf(" (%s)", usual);
        putchar('\n');
    }
    if (form->help == NULL)
        printf("\nExit codes: 0 done, 1 failure, 2 wrong command line, 130 interrupted%s.\n",
               form->brief ? "" : " (and resumable)");
    return fflush(stdout) == 0 && !ferror(stdout) ? DONE : FAILED;
}
