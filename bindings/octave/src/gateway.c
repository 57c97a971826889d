/* SPDX-License-Identifier: MIT
 * Commands by name, objects behind handles, and errors. */
#include "gateway.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* ------------------------------------------------------------------ objects */
typedef struct entry {
    uint64_t number;
    int kind, users;
    void* pointer;
} entry;

static const char* const kind_names[N_KINDS] = {"cancel token", "shape space", "simulator", "controller",
                                                "tape",         "adjoint",     "search"};

enum { MOST_IN_USE = 256 };

/* Ordered by their numbers. Octave and MATLAB call from one thread only. */
static entry* entries;
static int n_entries, entries_room;
static uint64_t last_number; /* never used twice, not even after the gateway was unloaded and loaded again */
static uint64_t in_use[MOST_IN_USE];
static int n_in_use;

static void destroy(int kind, void* pointer) {
    switch (kind) {
        case TOKEN:
            dqa_cancel_token_free(pointer);
            break;
        case SPACE:
            dqa_shape_space_free(pointer);
            break;
        case SIMULATOR:
            dqa_simulator_free(pointer);
            break;
        case CONTROLLER:
            dqa_controller_free(pointer);
            break;
        case TAPE:
            dqa_tape_free(pointer);
            break;
        case ADJOINT:
            dqa_adjoint_free(pointer);
            break;
        default:
            dqa_cma_es_free(pointer);
    }
}

static entry* find(uint64_t number) {
    int low = 0, high = n_entries;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (entries[middle].number < number)
            low = middle + 1;
        else
            high = middle;
    }
    return low < n_entries && entries[low].number == number ? &entries[low] : NULL;
}

static void release(const call* c) {
    while (n_in_use > c->in_use_before) {
        entry* e = find(in_use[--n_in_use]);
        if (e != NULL) --e->users;
    }
}

static void close_all(void) {
    dqa_set_log_handler(NULL, 0, NULL);
    while (n_entries > 0) {
        --n_entries;
        destroy(entries[n_entries].kind, entries[n_entries].pointer);
    }
    free(entries);
    entries = NULL;
    entries_room = 0;
}

void give_object(call* c, int kind, void* pointer) {
    mxArray* handle;
    if (n_entries == entries_room) {
        const int more = 2 * entries_room + 16;
        entry* larger = realloc(entries, (size_t)more * sizeof *entries);
        if (larger == NULL) {
            destroy(kind, pointer);
            refuse(c, DQA_ERROR_MEMORY, "no memory for one more %s", kind_names[kind]);
        }
        entries = larger;
        entries_room = more;
    }
    if (last_number == 0) last_number = (uint64_t)time(NULL) << 24;
    entries[n_entries].number = ++last_number;
    entries[n_entries].kind = kind;
    entries[n_entries].users = 0;
    entries[n_entries].pointer = pointer;
    ++n_entries;
    handle = mxCreateNumericMatrix(1, 1, mxUINT64_CLASS, mxREAL);
    *(uint64_t*)mxGetData(handle) = last_number;
    give(c, handle);
}

static entry* entry_of(call* c, int argument, const char* name) {
    const mxArray* handle = argument < c->n_in ? c->in[argument] : NULL;
    if (handle == NULL || !mxIsUint64(handle) || mxGetNumberOfElements(handle) != 1)
        refuse(c, DQA_ERROR_ARGUMENT, "%s: expected a handle, got %s", name,
               handle == NULL ? "nothing" : mxGetClassName(handle));
    return find(*(const uint64_t*)mxGetData(handle));
}

void* object(call* c, int argument, const char* name, int kind) {
    entry* e = entry_of(c, argument, name);
    if (e == NULL) refuse(c, DQA_ERROR_STATE, "this %s is closed", kind_names[kind]);
    if (e->kind != kind)
        refuse(c, DQA_ERROR_ARGUMENT, "%s: expected a %s, got a %s", name, kind_names[kind], kind_names[e->kind]);
    if (n_in_use == MOST_IN_USE) refuse(c, DQA_ERROR_STATE, "callbacks call each other too deeply");
    in_use[n_in_use++] = e->number;
    ++e->users;
    return e->pointer;
}

void* object_to_change(call* c, int argument, const char* name, int kind) {
    void* pointer = object(c, argument, name, kind);
    if (entry_of(c, argument, name)->users > 1)
        refuse(c, DQA_ERROR_STATE, "this %s cannot be changed while a call uses it", kind_names[kind]);
    return pointer;
}

void* optional_object(call* c, int argument, const char* name, int kind) {
    return is_given(c, argument) ? object(c, argument, name, kind) : NULL;
}

/* Closes an object; nothing happens where it is closed already. */
static void run_free(call* c) {
    entry* e = entry_of(c, 0, "handle");
    entry gone;
    if (e == NULL) return;
    if (e->users > 0) refuse(c, DQA_ERROR_STATE, "this %s cannot be closed while a call uses it", kind_names[e->kind]);
    gone = *e;
    memmove(e, e + 1, (size_t)(&entries[n_entries] - (e + 1)) * sizeof *e);
    --n_entries;
    destroy(gone.kind, gone.pointer);
}

static void run_n_objects(call* c) {
    give_number(c, n_entries);
}

/* ------------------------------------------------------------------ errors */
void refuse(call* c, dqa_status status, const char* pattern, ...) {
    char id[64], message[4096];
    va_list arguments;
    va_start(arguments, pattern);
    vsnprintf(message, sizeof message, pattern, arguments);
    va_end(arguments);
    snprintf(id, sizeof id, "diffaqua:%s", dqa_status_name(status));
    release(c);
    mexErrMsgIdAndTxt(id, "%s", message);
}

void check(call* c, dqa_status status) {
    if (status == DQA_SUCCESS) return;
    /* Ctrl-C comes out of a callback as an exception, for which the library ends the call without knowing why. */
    if (status == DQA_ERROR_INTERNAL &&
        (strcmp(dqa_last_error(), "interrupt exception") == 0 || strcmp(dqa_last_error(), "unknown exception") == 0))
        refuse(c, DQA_CANCELLED, "interrupted in a callback");
    refuse(c, status, "%s", dqa_last_error());
}

/* ------------------------------------------------------------------ the library itself */
static void run_version(call* c) {
    give(c, mxCreateString(dqa_version()));
}

static void run_features(call* c) {
    give(c, mxCreateString(dqa_features()));
}

static void run_status_name(call* c) {
    give(c, mxCreateString(dqa_status_name(index_of(c, 0, "status"))));
}

static void run_status_text(call* c) {
    give(c, mxCreateString(dqa_status_text(index_of(c, 0, "status"))));
}

static void run_fields(call* c) {
    give_fields(c, text(c, 0, "struct"));
}

static void run_set_log_handler(call* c) {
    set_log(c, whole(c, 0, "id"), index_of(c, 1, "level"));
}

static void run_commands(call* c);

/* clang-format off */
static const command own_commands[] = {
    {"version", run_version, 0, 0},
    {"features", run_features, 0, 0},
    {"status_name", run_status_name, 1, 1},
    {"status_text", run_status_text, 1, 1},
    {"set_log_handler", run_set_log_handler, 2, 2},
    {"free", run_free, 1, 1},             /* dqa_..._free of what the handle stands for */
    {"n_objects", run_n_objects, 0, 0},   /* how many are open */
    {"fields", run_fields, 1, 1},         /* of a struct that goes in or out */
    {"commands", run_commands, 0, 0},     /* the names of all commands */
    {NULL, NULL, 0, 0}};
/* clang-format on */

static const command* const all_commands[] = {own_commands, space_commands, simulator_commands, controller_commands,
                                              tape_commands};
enum { N_LISTS = sizeof all_commands / sizeof *all_commands };

static void run_commands(call* c) {
    mxArray* names;
    mwSize n = 0;
    for (int l = 0; l < N_LISTS; ++l)
        for (const command* k = all_commands[l]; k->name != NULL; ++k) ++n;
    names = mxCreateCellMatrix(n, 1);
    n = 0;
    for (int l = 0; l < N_LISTS; ++l)
        for (const command* k = all_commands[l]; k->name != NULL; ++k) mxSetCell(names, n++, mxCreateString(k->name));
    give(c, names);
}

/* ------------------------------------------------------------------ entry */
void mexFunction(int n_out, mxArray** out, int n_in, const mxArray** in) {
    static int is_ready;
    call c = {"", n_out, 0, out, n_in - 1, in + 1, 0};
    char name[64];
    c.in_use_before = n_in_use;
    if (!is_ready) {
        if (dqa_abi_version() != DQA_ABI_VERSION)
            refuse(&c, DQA_ERROR_UNSUPPORTED, "the library has ABI %d; this gateway was made for %d",
                   (int)dqa_abi_version(), DQA_ABI_VERSION);
        mexAtExit(close_all);
        is_ready = 1;
    }
    if (n_in < 1 || !mxIsChar(in[0]) || mxGetString(in[0], name, sizeof name) != 0)
        refuse(&c, DQA_ERROR_ARGUMENT, "command: expected the name of one");
    c.command = name;
    for (int l = 0; l < N_LISTS; ++l)
        for (const command* k = all_commands[l]; k->name != NULL; ++k) {
            if (strcmp(k->name, name) != 0) continue;
            if (c.n_in < k->least || c.n_in > k->most)
                refuse(&c, DQA_ERROR_ARGUMENT, "%s: expected %d to %d arguments, got %d", name, k->least, k->most,
                       c.n_in);
            k->run(&c);
            release(&c);
            return;
        }
    refuse(&c, DQA_ERROR_ARGUMENT, "unknown command '%s'", name);
}
