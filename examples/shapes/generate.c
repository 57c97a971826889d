/* SPDX-License-Identifier: MIT
 *
 * Writes the base shapes of the examples: a binary STL file and a list of muscles for each.
 *
 *     generate OUTDIR [NAME ...]
 *
 * Every shape is one closed surface of length 1 along x with the head at +x, z up, and mirrors across y = 0. Fins are
 * 0.02 to 0.04 thick, several times their natural thickness, so that they cover whole cells of the boxes in README.md.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "animals.h"
#include "mesh.h"

#define STEP 0.0075 /* of marching tetrahedra, before edges are collapsed */

static void put_u32(unsigned char* to, uint32_t v) {
    for (int b = 0; b < 4; ++b) to[b] = (unsigned char)(v >> (8 * b) & 0xff);
}

static void put_float(unsigned char* to, double v) {
    const float f = (float)(v == 0.0 ? 0.0 : v); /* no negative zeros */
    uint32_t bits;
    memcpy(&bits, &f, sizeof(bits));
    put_u32(to, bits);
}

static FILE* opened(const char* folder, const char* name, const char* extension, char* path, size_t size) {
    FILE* file;
    if (snprintf(path, size, "%s/%s.%s", folder, name, extension) >= (int)size) {
        fprintf(stderr, "generate: the path of the folder is too long\n");
        return NULL;
    }
    file = fopen(path, "wb");
    if (file == NULL) perror(path);
    return file;
}

static int closed(FILE* file, const char* path, int good) {
    good = fclose(file) == 0 && good;
    if (!good) {
        fprintf(stderr, "%s: could not be written\n", path);
        (void)remove(path);
    }
    return good;
}

static int write_stl(const mesh* m, const char* folder, const char* name) {
    char path[4096];
    unsigned char record[84];
    FILE* file = opened(folder, name, "stl", path, sizeof(path));
    int good;
    if (file == NULL) return 0;
    memset(record, 0, sizeof(record));
    snprintf((char*)record, 80, "diffaqua example shape: %s; head +x, z up, length 1", name);
    put_u32(record + 80, (uint32_t)m->triangles);
    good = fwrite(record, 84, 1, file) == 1;
    for (int t = 0; t < m->triangles; ++t) {
        memset(record, 0, 50); /* a zero normal: readers compute it from the corners */
        for (int p = 0; p < 3; ++p) {
            const vec v = m->vertex[m->triangle[t][p]];
            put_float(record + 12 + 12 * p, v.x);
            put_float(record + 16 + 12 * p, v.y);
            put_float(record + 20 + 12 * p, v.z);
        }
        good = good && fwrite(record, 50, 1, file) == 1;
    }
    return closed(file, path, good);
}

/* Muscles are drawn beside the shape; lists count from the centre of mass. */
static int write_muscles(const animal* a, const char* folder, vec centre, double scale, double shift) {
    char path[4096];
    FILE* file = opened(folder, a->name, "txt", path, sizeof(path));
    int good;
    if (file == NULL) return 0;
    good = fprintf(file, "# %s: muscles for a body length of 1 m, from the centre of mass\nlengths own\nbase %s.stl\n",
                   a->what, a->name) > 0;
    for (int k = 0; k < a->muscles; ++k) {
        const muscle* m = &a->muscle[k];
        const double at[3] = {scale * m->mean[0] + shift - centre.x, scale * m->mean[1], scale * m->mean[2] - centre.z};
        good = good && fprintf(file, "  %s  mean %.3f %.3f %.3f  half %.3f %.3f %.3f", m->is_fin ? "fins  " : "caudal",
                               at[0], at[1], at[2], scale * m->half[0], scale * m->half[1], scale * m->half[2]) > 0;
        if (m->degrees[0] != 0.0 || m->degrees[1] != 0.0 || m->degrees[2] != 0.0)
            good = good && fprintf(file, "  angles %g %g %g", m->degrees[0], m->degrees[1], m->degrees[2]) > 0;
        good = good && fputc('\n', file) != EOF;
    }
    return closed(file, path, good);
}

static int generate(const animal* a, const char* folder) {
    static solid s;
    double scale, shift;
    mesh m;
    int good;
    s.parts = 0;
    s.thinnest = 0.66 / a->cells;
    a->build(&s);
    m = mesh_half(&s, STEP);
    mesh_relax(&m, &s, STEP);
    mesh_simplify(&m, a->triangles / 2);
    mesh_mirror(&m);
    mesh_fit(&m, &scale, &shift);
    good = write_stl(&m, folder, a->name) && write_muscles(a, folder, mesh_centre(&m), scale, shift);
    mesh_free(&m);
    return good;
}

static int wanted(const char* name, int argc, char** argv) {
    for (int k = 2; k < argc; ++k)
        if (strcmp(argv[k], name) == 0) return 1;
    return argc == 2;
}

int main(int argc, char** argv) {
    static const struct {
        const animal* first;
        int count;
    } groups[] = {{eels, 2}, {bony_fishes, 2}, {rays, 2}, {sharks, 4}, {goldfishes, 7}, {others, 2}};
    int found = 0;
    if (argc < 2) {
        fprintf(stderr, "usage: %s OUTDIR [NAME ...]\n", argv[0]);
        return 2;
    }
    for (size_t g = 0; g < sizeof(groups) / sizeof(groups[0]); ++g)
        for (int k = 0; k < groups[g].count; ++k) {
            const animal* a = &groups[g].first[k];
            if (!wanted(a->name, argc, argv)) continue;
            ++found;
            if (!generate(a, argv[1])) return 1;
        }
    if (argc > 2 && found < argc - 2) {
        fprintf(stderr, "%s: %d of the names are of no shape\n", argv[0], argc - 2 - found);
        return 2;
    }
    return 0;
}
