/* SPDX-License-Identifier: MIT
 * The gateway between Octave or MATLAB and libdiffaqua: diffaqua_mex(command, arguments ...), where a command is the
 * name of a function of diffaqua.h without dqa_. Shared by its parts:
 *   gateway.c   the table of commands, objects behind handles, errors
 *   values.c    numbers, texts and arrays on their way in and out
 *   structs.c   options and records by the names of their fields, losses
 *   callbacks.c functions that the library calls
 *   commands_*.c  the commands
 * Temporary memory comes from mxMalloc and the like, which is given back when a call ends, also by an error. */
#ifndef DQA_GATEWAY_H
#define DQA_GATEWAY_H

#include <mex.h>
#include <stddef.h>
#include <stdint.h>

#include "diffaqua.h"

/* One call of diffaqua_mex. Arguments count from 0, without the command. */
typedef struct call {
    const char* command;
    int n_out, given; /* results wanted and handed over so far */
    mxArray** out;
    int n_in;
    const mxArray** in;
    int in_use_before; /* objects in use when the call began: some, if it comes from a callback */
} call;

typedef struct command {
    const char* name;
    void (*run)(call*);
    int least, most; /* arguments */
} command;

extern const command space_commands[], simulator_commands[], controller_commands[], tape_commands[]; /* end: no name */

/* ------------------------------------------------------------------ errors (gateway.c) */
/* Ends the call with the error diffaqua:<name of the status>. */
void refuse(call* c, dqa_status status, const char* pattern, ...);
/* The same for what the library refused, if it did. */
void check(call* c, dqa_status status);

/* ------------------------------------------------------------------ objects (gateway.c) */
enum { TOKEN, SPACE, SIMULATOR, CONTROLLER, TAPE, ADJOINT, SEARCH, N_KINDS };

/* Hands a new object over as a handle: a uint64 that is never used again. */
void give_object(call* c, int kind, void* pointer);
/* The object of a handle, which cannot be closed until the call ends. Refuses handles of closed or other objects. */
void* object(call* c, int argument, const char* name, int kind);
/* The same for a call that changes the object. Refused while another call that uses it waits for a callback: what that
 * one goes on to compute would be neither of the two. */
void* object_to_change(call* c, int argument, const char* name, int kind);
/* NULL where the argument is missing or empty. */
void* optional_object(call* c, int argument, const char* name, int kind);

/* ------------------------------------------------------------------ values (values.c) */
int is_given(const call* c, int argument); /* there and not empty */
double number(call* c, int argument, const char* name);
int64_t whole(call* c, int argument, const char* name);
int32_t index_of(call* c, int argument, const char* name);
const char* text(call* c, int argument, const char* name);

/* A whole number in [low, high] out of element k of an array of numbers; `name` for the message. */
int64_t whole_element(call* c, const mxArray* array, size_t k, const char* name, double low, double high);
double number_element(call* c, const mxArray* array, size_t k, const char* name);

/* Lengths of the axes of an array in C, row-major; -1 where any will do, replaced by what came. Octave's array has the
 * same axes and another order of its elements. One axis: a row or a column. */
typedef struct shape {
    int rank;
    int64_t n[3];
} shape;

shape axes1(int64_t n);
shape axes2(int64_t n, int64_t m);
shape axes3(int64_t n, int64_t m, int64_t l);
int64_t count(const shape* s);

/* Elements in C's order; Octave's own memory where the order is the same. Never NULL. */
const double* doubles(call* c, int argument, const char* name, shape* s);
const int32_t* integers(call* c, int argument, const char* name, shape* s);
/* NULL, and no elements, where the argument is missing or empty. */
const double* optional_doubles(call* c, int argument, const char* name, shape* s);
/* Zeros. */
double* room(const shape* s);
int32_t* room_for_integers(const shape* s);

/* Results, in their order. */
void give(call* c, mxArray* value);
void give_doubles(call* c, const double* values, shape s);
void give_integers(call* c, const int32_t* values, shape s); /* as doubles */
void give_number(call* c, double value);

/* ------------------------------------------------------------------ structs (structs.c) */
/* Writes the fields of an argument (a struct; missing or empty: none) over a struct of the library, by name. */
void fill(call* c, int argument, const char* struct_name, void* filled);
void give_record(call* c, const char* struct_name, const void* filled);
/* The terms of a loss: a struct array, or a cell array of structs. */
const dqa_objective_term* terms_of(call* c, int argument, int64_t* n_terms);
void give_fields(call* c, const char* struct_name); /* names of the fields, as a cell array */

/* ------------------------------------------------------------------ callbacks (callbacks.c) */
/* What stands for the function with a number of diffaqua_callback.m; 0: none, NULL. */
dqa_progress progress_of(int64_t id);
void* user_data_of(int64_t id, int dims);
void set_log(call* c, int64_t id, int32_t level);
extern const dqa_current current_callback;
extern const dqa_current_pullback current_pullback_callback;
extern const dqa_control_evaluate evaluate_callback;
extern const dqa_control_pullback pullback_callback;

#endif
