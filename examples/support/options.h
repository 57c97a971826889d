/* SPDX-License-Identifier: MIT
 * The command lines of codesign and of the experiments. */
#ifndef DQA_EXAMPLES_OPTIONS_H
#define DQA_EXAMPLES_OPTIONS_H

#include <stdint.h>

#include "bases.h"
#include "objective.h"
#include "physics.h"
#include "schedule.h"

#define OPTIONS_MAX_BASES 64

typedef struct options {
    int32_t grid[3];     /* cells along x, y, z */
    int64_t iterations;  /* of the optimiser, >= 1 */
    int64_t steps;       /* of a rollout, >= 1 */
    int64_t generations; /* of CMA-ES, where the program runs it */
    int32_t rate;        /* time steps per second */
    const char* only;    /* the trials to run, with commas between them; NULL: all */
    int32_t threads;     /* >= 1 */
    double tolerance;    /* of a time step; 0: the library's */
    schedule plan;       /* of coarser grids and looser tolerances */
    double sigma;        /* width of the interpolation's kernel, in cells */
    int32_t refinement;  /* finer cells along the edge of a cell, between which it moves mass */
    int fixed_control;   /* only the weights are optimised */
    int mlp;             /* the controller is a perceptron, not a sine */
    objective loss;
    physics laws;
    double threshold;                  /* of the simulated cells; < 0: the library's, or as model_error asks */
    double model_error;                /* 0: not given */
    int64_t checkpoint_mib;            /* memory budget of the tape; 0: none */
    int quick;                         /* the coarse settings were asked for */
    int resume;                        /* continue from the checkpoint in `out` */
    const struct options_form* form;   /* what the command line is like */
    int shipped;                       /* the meshes are those that come with the program */
    const char* out;                   /* folder of the results */
    int32_t n_meshes;                  /* >= 1 */
    char* meshes[OPTIONS_MAX_BASES];   /* paths; owned */
    double weights[OPTIONS_MAX_BASES]; /* initial design, on the simplex */
    const char* bases_file;            /* the list that names the meshes; NULL: the command line does */
    bases list;                        /* its actuators; owned */
} options;

typedef struct options_preset {
    int32_t grid[3];
    int64_t iterations, steps, generations;
    double sigma;
} options_preset;

/* What the command line of a program is like. */
typedef struct options_form {
    const char* program;
    const char* help;          /* what --help answers; NULL: it is made from `about` and the options */
    const char* about;         /* lines of usage, and what the program does */
    const char* out;           /* folder of the results unless named */
    const char* const* words;  /* the options it knows beside those of all experiments, NULL at the end; NULL: all */
    const char* const* shapes; /* shipped meshes it takes unless others are named, NULL at the end, and it wants as
                                  many; NULL: all shipped ones, or any number of others */
    options_preset quick, shipped, user; /* with --quick, without meshes, with meshes of the user's own */
    const char* objective;               /* as --objective has it; NULL: travel */
    int fixed_control;                   /* the controller stays as it is */
    int brief;                           /* over in minutes: there is no --resume */
    int mlp;                             /* the controller is a perceptron */
    int32_t refinement;                  /* of the interpolation, but with --quick; 0 counts as 1 */
    double network_rate;                 /* of Adam for its parameters; 0: the usual one */
    double weights_rate;                 /* of Adam for the weights of the bases; 0: the usual one */
    double network_scale;                /* of its first weights, relative to Glorot's; 0 counts as 1 */
    int lists; /* shipped meshes bring their lists of muscles, instead of those placed from the geometry */
} options_form;

extern const options_form options_codesign;

/* 1 when an experiment of this form knows the option at the beginning of `word`. */
int options_known(const options_form* form, const char* word);
/* The refinement of a run without --refinement. */
int32_t options_refinement(const options_form* form, int quick);
/* Answers --help of an experiment on stdout. DONE or FAILED. */
int options_print_help(const options_form* form);

#define OPTIONS_RUN 0  /* go on */
#define OPTIONS_HELP 1 /* --help was answered: nothing more to do */

/* Reads the command line of the program of the form, which outlives the options. Returns DONE, or USAGE or FAILED
 * (said); *action is OPTIONS_*. */
int options_parse(options* o, const options_form* form, int argc, char** argv, int* action);
void options_free(options* o);
/* The command line in shell quoting, its program without a folder; owned. NULL (said) when memory ran out. */
char* options_command(int argc, char** argv);
/* The command line that continues this run, in shell quoting, on stderr through say(). */
void options_say_resume(int argc, char** argv);

#endif
