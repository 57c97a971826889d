/* SPDX-License-Identifier: MIT
 * Binary STL: 80 bytes of header, a 32-bit count, then 50 bytes a triangle (normal, three corners, attribute), all
 * little-endian whatever the machine. */
#include "stl.h"

#include <math.h>
#include <string.h>

#include "output.h"
#include "say.h"

static void put_u32(unsigned char* to, uint32_t value) {
    for (int i = 0; i < 4; ++i) to[i] = (unsigned char)(value >> (8 * i));
}

static void put_float(unsigned char* to, double value) {
    const float single = (float)value;
    uint32_t bits;
    memcpy(&bits, &single, sizeof bits);
    put_u32(to, bits);
}

static void triangle_record(unsigned char record[50], const double* a, const double* b, const double* c) {
    double u[3], v[3], n[3], length;
    for (int i = 0; i < 3; ++i) {
        u[i] = b[i] - a[i];
        v[i] = c[i] - a[i];
    }
    for (int i = 0; i < 3; ++i) n[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
    length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int i = 0; i < 3; ++i) {
        put_float(record + 4 * i, length > 0.0 ? n[i] / length : 0.0);
        put_float(record + 12 + 4 * i, a[i]);
        put_float(record + 24 + 4 * i, b[i]);
        put_float(record + 36 + 4 * i, c[i]);
    }
    record[48] = record[49] = 0;
}

int stl_write(const char* folder, const char* name, const double* vertices, const int32_t* triangles,
              int64_t n_triangles) {
    /* Must not begin with "solid": readers would take the file for the ASCII form. */
    unsigned char header[84] = "Rest surface of a diffaqua design, in metres; heading +x, z up";
    output_file file;
    if (output_open(&file, folder, name) != DONE) return FAILED;
    put_u32(header + 80, (uint32_t)n_triangles);
    (void)fwrite(header, 1, sizeof header, file.stream);
    for (int64_t t = 0; t < n_triangles; ++t) {
        unsigned char record[50];
        triangle_record(record, vertices + 3 * triangles[3 * t], vertices + 3 * triangles[3 * t + 1],
                        vertices + 3 * triangles[3 * t + 2]);
        (void)fwrite(record, 1, sizeof record, file.stream);
    }
    return output_commit(&file);
}
