/* SPDX-License-Identifier: MIT
 * VTK XML unstructured grids with inline binary data: each array is a 64-bit byte count followed by the numbers, both
 * in base64 as one stream, in the byte order of this machine (named in the file). */
#define _POSIX_C_SOURCE 200809L
#include "vtu.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base64.h"
#include "interrupt.h"
#include "output.h"
#include "say.h"

#define VTK_TRIANGLE 5

static void array(FILE* stream, const char* type, const char* name, int components, const void* data, size_t size) {
    const uint64_t bytes = size;
    base64 b;
    fprintf(stream, "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"binary\">", type, name,
            components);
    base64_begin(&b, stream);
    base64_put(&b, &bytes, sizeof bytes);
    base64_put(&b, data, size);
    base64_end(&b);
    fputs("</DataArray>\n", stream);
}

/* Scratch arrays of one frame; the cells are the same in all. */
typedef struct buffers {
    float* points;
    int32_t* offsets;
    unsigned char* types;
} buffers;

static void buffers_free(buffers* b) {
    free(b->points);
    free(b->offsets);
    free(b->types);
}

static int buffers_create(buffers* b, const motion* m) {
    b->points = malloc((size_t)m->n_vertices * 3 * sizeof *b->points);
    b->offsets = malloc((size_t)m->n_triangles * sizeof *b->offsets);
    b->types = malloc((size_t)m->n_triangles);
    if (b->points == NULL || b->offsets == NULL || b->types == NULL) {
        buffers_free(b);
        (void)say_no_memory();
        return FAILED;
    }
    for (int64_t t = 0; t < m->n_triangles; ++t) b->offsets[t] = (int32_t)(3 * (t + 1));
    memset(b->types, VTK_TRIANGLE, (size_t)m->n_triangles);
    return DONE;
}

/* (now - before) * scale, before == NULL: now. */
static void points_array(FILE* stream, buffers* b, const motion* m, const char* name, const double* now,
                         const double* before, double scale) {
    const int64_t n = 3 * m->n_vertices;
    for (int64_t i = 0; i < n; ++i) b->points[i] = (float)((before != NULL ? now[i] - before[i] : now[i]) * scale);
    array(stream, "Float32", name, 3, b->points, (size_t)n * sizeof *b->points);
}

static const char* byte_order(void) {
    const uint16_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    return first == 1 ? "LittleEndian" : "BigEndian";
}

static int write_frame(const motion* m, int64_t frame, buffers* b, const char* folder, const char* name) {
    const double *now = motion_frame(m, frame), *rest = motion_frame(m, 0);
    /* Implicit Euler: the velocity after a step is the change of position over it; the first frame is at rest. */
    const double* before = frame > 0 ? motion_frame(m, frame - 1) : now;
    const size_t cell_bytes = (size_t)m->n_triangles * 3 * sizeof *m->triangles;
    output_file file;
    FILE* f;
    if (output_open(&file, folder, name) != DONE) return FAILED;
    f = file.stream;
    fprintf(f,
            "<?xml version=\"1.0\"?>\n"
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"%s\" header_type=\"UInt64\">\n"
            "<UnstructuredGrid>\n<Piece NumberOfPoints=\"%lld\" NumberOfCells=\"%lld\">\n"
            "<PointData Vectors=\"displacement\">\n",
            byte_order(), (long long)m->n_vertices, (long long)m->n_triangles);
    points_array(f, b, m, "displacement", now, rest, 1.0);
    points_array(f, b, m, "velocity", now, before, 1.0 / m->time_step);
    fputs("</PointData>\n<Points>\n", f);
    points_array(f, b, m, "Points", now, NULL, 1.0);
    fputs("</Points>\n<Cells>\n", f);
    array(f, "Int32", "connectivity", 1, m->triangles, cell_bytes);
    array(f, "Int32", "offsets", 1, b->offsets, (size_t)m->n_triangles * sizeof *b->offsets);
    array(f, "UInt8", "types", 1, b->types, (size_t)m->n_triangles);
    fputs("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n", f);
    return output_commit(&file);
}

static void frame_name(char* name, size_t size, const char* prefix, int64_t frame) {
    (void)snprintf(name, size, "%sswimmer_%04lld.vtu", prefix, (long long)frame);
}

static int write_index(const motion* m, const char* folder) {
    output_file file;
    if (output_open(&file, folder, VTU_INDEX) != DONE) return FAILED;
    fprintf(file.stream,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"%s\">\n<Collection>\n",
            byte_order());
    for (int64_t k = 0; k < m->n_frames; ++k) {
        char name[64];
        frame_name(name, sizeof name, VTU_FOLDER "/", k);
        fprintf(file.stream, "<DataSet timestep=\"%.9g\" part=\"0\" file=\"%s\"/>\n", (double)k * m->time_step, name);
    }
    fputs("</Collection>\n</VTKFile>\n", file.stream);
    return output_commit(&file);
}

/* Frames are numbered without gaps, so the first missing one ends an older run. */
static void remove_older(const char* folder, int64_t first) {
    for (int64_t k = first;; ++k) {
        char name[64];
        char* path;
        int gone;
        frame_name(name, sizeof name, "", k);
        path = output_path(folder, name);
        gone = path == NULL || unlink(path) != 0;
        free(path);
        if (gone) return;
    }
}

int vtu_write_motion(const motion* m, const char* folder) {
    buffers b;
    int created = 0;
    char* frames = output_path(folder, VTU_FOLDER);
    int outcome = frames != NULL ? output_folder(frames, &created) : FAILED;
    if (outcome != DONE) {
        free(frames);
        return outcome;
    }
    outcome = buffers_create(&b, m);
    if (outcome == DONE) {
        for (int64_t k = 0; k < m->n_frames && outcome == DONE; ++k) {
            char name[64];
            frame_name(name, sizeof name, "", k);
            outcome = interrupted() ? INTERRUPTED : write_frame(m, k, &b, frames, name);
        }
        buffers_free(&b);
    }
    if (outcome == DONE) outcome = write_index(m, folder);
    if (outcome == DONE) remove_older(frames, m->n_frames);
    free(frames);
    return outcome;
}
