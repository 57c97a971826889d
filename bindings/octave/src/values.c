/* SPDX-License-Identifier: MIT
 * Numbers, texts and arrays on their way in and out. Octave keeps arrays by columns, the library by rows: an array of
 * several axes is turned, one of a single axis goes in as it lies. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "gateway.h"

/* ------------------------------------------------------------------ single values */
int is_given(const call* c, int argument) {
    return argument < c->n_in && !mxIsEmpty(c->in[argument]);
}

static void must_be_numbers(call* c, const mxArray* array, const char* name) {
    if (array == NULL) refuse(c, DQA_ERROR_ARGUMENT, "%s: expected numbers, got nothing", name);
    if (mxIsSparse(array) || mxIsComplex(array) || !(mxIsNumeric(array) || mxIsLogical(array)))
        refuse(c, DQA_ERROR_ARGUMENT, "%s: expected real numbers, got %s%s", name,
               mxIsSparse(array)    ? "sparse "
               : mxIsComplex(array) ? "complex "
                                    : "",
               mxGetClassName(array));
}

double number_element(call* c, const mxArray* array, size_t k, const char* name) {
    const void* data;
    must_be_numbers(c, array, name);
    data = mxGetData(array);
    switch (mxGetClassID(array)) {
        case mxDOUBLE_CLASS:
            return ((const double*)data)[k];
        case mxSINGLE_CLASS:
            return ((const float*)data)[k];
        case mxINT8_CLASS:
            return ((const int8_t*)data)[k];
        case mxUINT8_CLASS:
            return ((const uint8_t*)data)[k];
        case mxINT16_CLASS:
            return ((const int16_t*)data)[k];
        case mxUINT16_CLASS:
            return ((const uint16_t*)data)[k];
        case mxINT32_CLASS:
            return ((const int32_t*)data)[k];
        case mxUINT32_CLASS:
            return ((const uint32_t*)data)[k];
        case mxINT64_CLASS:
            return (double)((const int64_t*)data)[k];
        case mxUINT64_CLASS:
            return (double)((const uint64_t*)data)[k];
        default: /* logical */
            return ((const mxLogical*)data)[k];
    }
}

int64_t whole_element(call* c, const mxArray* array, size_t k, const char* name, double low, double high) {
    const double value = number_element(c, array, k, name);
    if (!(floor(value) == value)) refuse(c, DQA_ERROR_ARGUMENT, "%s: expected a whole number, got %.17g", name, value);
    if (value < low || value > high)
        refuse(c, DQA_ERROR_ARGUMENT, "%s: expected a number in [%.0f, %.0f], got %.17g", name, low, high, value);
    return mxIsInt64(array) || mxIsUint64(array) ? ((const int64_t*)mxGetData(array))[k] : (int64_t)value;
}

static const mxArray* scalar(call* c, int argument, const char* name) {
    const mxArray* array = argument < c->n_in ? c->in[argument] : NULL;
    must_be_numbers(c, array, name);
    if (mxGetNumberOfElements(array) != 1)
        refuse(c, DQA_ERROR_ARGUMENT, "%s: expected one number, got %.0f", name, (double)mxGetNumberOfElements(array));
    return array;
}

double number(call* c, int argument, const char* name) {
    return number_element(c, scalar(c, argument, name), 0, name);
}

int64_t whole(call* c, int argument, const char* name) {
    const double limit = 9007199254740992.0; /* what doubles hold exactly */
    return whole_element(c, scalar(c, argument, name), 0, name, -limit, limit);
}

int32_t index_of(call* c, int argument, const char* name) {
    return (int32_t)whole_element(c, scalar(c, argument, name), 0, name, INT32_MIN, INT32_MAX);
}

const char* text(call* c, int argument, const char* name) {
    const mxArray* array = argument < c->n_in ? c->in[argument] : NULL;
    char* copy;
    if (array == NULL || !mxIsChar(array) || (mxGetM(array) > 1 && !mxIsEmpty(array)))
        refuse(c, DQA_ERROR_ARGUMENT, "%s: expected a text, got %s", name,
               array == NULL     ? "nothing"
               : mxIsChar(array) ? "several rows"
                                 : mxGetClassName(array));
    copy = mxArrayToString(array);
    return copy != NULL ? copy : "";
}

/* ------------------------------------------------------------------ arrays */
shape axes1(int64_t n) {
    const shape s = {1, {n, 1, 1}};
    return s;
}

shape axes2(int64_t n, int64_t m) {
    const shape s = {2, {n, m, 1}};
    return s;
}

shape axes3(int64_t n, int64_t m, int64_t l) {
    const shape s = {3, {n, m, l}};
    return s;
}

int64_t count(const shape* s) {
    return s->n[0] * s->n[1] * s->n[2];
}

/* "[any, 2]" */
static const char* words(const shape* s) {
    char* out = mxMalloc(128);
    size_t n = 0;
    for (int a = 0; a < s->rank; ++a) {
        n += (size_t)snprintf(out + n, 128 - n, "%s", a == 0 ? "[" : ", ");
        if (s->n[a] < 0)
            n += (size_t)snprintf(out + n, 128 - n, "any");
        else
            n += (size_t)snprintf(out + n, 128 - n, "%lld", (long long)s->n[a]);
    }
    snprintf(out + n, 128 - n, "]");
    return out;
}

/* Compares what came with the lengths that are wanted, and fills in those that were open. */
static void match(call* c, const mxArray* array, const char* name, shape* s) {
    const mwSize* sizes;
    const int64_t n = array == NULL ? 0 : (int64_t)mxGetNumberOfElements(array);
    shape came = {0, {1, 1, 1}};
    int fits;
    must_be_numbers(c, array, name);
    sizes = mxGetDimensions(array);
    came.rank = (int)mxGetNumberOfDimensions(array);
    for (int a = 0; a < came.rank && a < 3; ++a) came.n[a] = (int64_t)sizes[a];
    if (s->rank == 1) {
        fits = came.rank == 2 && (came.n[0] == 1 || came.n[1] == 1 || n == 0) && (s->n[0] < 0 || s->n[0] == n);
        if (fits) s->n[0] = n;
    } else {
        /* Octave drops axes of length 1 at the end. Nothing (0 x 0) is no rows. */
        fits = came.rank <= 3;
        for (int a = 0; a < 3 && fits; ++a)
            fits = s->n[a] == came.n[a] || (a < s->rank && s->n[a] < 0) || (n == 0 && s->n[0] <= 0);
        for (int a = 0; a < s->rank && fits; ++a)
            if (s->n[a] < 0) s->n[a] = came.n[a];
    }
    if (fits) return;
    if (came.rank > 3) came.rank = 3;
    refuse(c, DQA_ERROR_ARGUMENT, "%s: expected shape %s, got %s", name, words(s), words(&came));
}

/* Index in Octave's array of element `k` of C's. */
static size_t turned(const shape* s, int64_t k) {
    const int64_t z = k % s->n[2], y = k / s->n[2] % s->n[1], x = k / s->n[2] / s->n[1];
    return (size_t)(x + s->n[0] * (y + s->n[1] * z));
}

double* room(const shape* s) {
    return mxCalloc((size_t)(count(s) > 0 ? count(s) : 1), sizeof(double));
}

int32_t* room_for_integers(const shape* s) {
    return mxCalloc((size_t)(count(s) > 0 ? count(s) : 1), sizeof(int32_t));
}

const double* doubles(call* c, int argument, const char* name, shape* s) {
    const mxArray* array = argument < c->n_in ? c->in[argument] : NULL;
    double* values;
    match(c, array, name, s);
    if (mxIsDouble(array) && s->rank == 1 && count(s) > 0) return mxGetPr(array);
    values = room(s);
    for (int64_t k = 0; k < count(s); ++k)
        values[k] = number_element(c, array, s->rank == 1 ? (size_t)k : turned(s, k), name);
    return values;
}

const int32_t* integers(call* c, int argument, const char* name, shape* s) {
    const mxArray* array = argument < c->n_in ? c->in[argument] : NULL;
    int32_t* values;
    match(c, array, name, s);
    values = room_for_integers(s);
    for (int64_t k = 0; k < count(s); ++k)
        values[k] =
            (int32_t)whole_element(c, array, s->rank == 1 ? (size_t)k : turned(s, k), name, INT32_MIN, INT32_MAX);
    return values;
}

const double* optional_doubles(call* c, int argument, const char* name, shape* s) {
    if (is_given(c, argument)) return doubles(c, argument, name, s);
    *s = axes1(0);
    return NULL;
}

/* ------------------------------------------------------------------ results */
void give(call* c, mxArray* value) {
    if (c->given < (c->n_out > 1 ? c->n_out : 1))
        c->out[c->given++] = value;
    else
        mxDestroyArray(value);
}

static mxArray* empty_of(const shape* s) {
    const mwSize sizes[3] = {(mwSize)s->n[0], (mwSize)s->n[1], (mwSize)s->n[2]};
    return mxCreateNumericArray(s->rank == 3 ? 3 : 2, sizes, mxDOUBLE_CLASS, mxREAL);
}

void give_doubles(call* c, const double* values, shape s) {
    mxArray* array = empty_of(&s);
    double* to = mxGetPr(array);
    for (int64_t k = 0; k < count(&s); ++k) to[turned(&s, k)] = values[k];
    give(c, array);
}

void give_integers(call* c, const int32_t* values, shape s) {
    mxArray* array = empty_of(&s);
    double* to = mxGetPr(array);
    for (int64_t k = 0; k < count(&s); ++k) to[turned(&s, k)] = values[k];
    give(c, array);
}

void give_number(call* c, double value) {
    give(c, mxCreateDoubleScalar(value));
}
