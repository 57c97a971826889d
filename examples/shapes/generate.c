/* SPDX-License-Identifier: MIT
 *
 * Writes the base shapes of the examples as binary STL files: two eels, a clownfish and a tuna.
 *
 *     generate OUTDIR
 *
 * Every shape has length 1 along x with the head at +x, z up, and mirrors across y = 0. It is a union of closed lofts
 * (superellipse cross-sections along a line): one for the body, one for each fin, the fins' roots inside the body.
 * Lengths are in body lengths. Fins are 0.02 to 0.045 thick, several times their natural thickness, so that they cover
 * whole cells of a 60 x 16 x 26 box.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_TRIANGLES 8000
#define MAX_SECTIONS 64
#define MAX_RING 32

typedef struct {
    double x, y, z;
} vec;

/* Cross-section: centre + u * cos + w * sin, with the exponent of a superellipse (2: ellipse, larger: boxier). */
typedef struct {
    vec centre, u, w;
    double exponent;
} section;

typedef struct {
    vec corner[MAX_TRIANGLES][3];
    int count;
} shape;

static void add_triangle(shape* s, vec a, vec b, vec c) {
    if (s->count == MAX_TRIANGLES) {
        fprintf(stderr, "generate: more than %d triangles\n", MAX_TRIANGLES);
        exit(1);
    }
    s->corner[s->count][0] = a;
    s->corner[s->count][1] = b;
    s->corner[s->count][2] = c;
    s->count++;
}

static double six_volumes(const vec* t) {
    return t[0].x * (t[1].y * t[2].z - t[1].z * t[2].y) + t[0].y * (t[1].z * t[2].x - t[1].x * t[2].z) +
           t[0].z * (t[1].x * t[2].y - t[1].y * t[2].x);
}

/* cos and sin of ring point i, from the first octant, so that mirrored points have exactly mirrored coordinates. */
static void ring_point(int i, int ring, double* c, double* s) {
    const double pi = 3.14159265358979323846;
    const int quarter = ring / 4, quadrant = i / quarter, k = i % quarter;
    const double a = 2 * k <= quarter ? cos(2 * pi * k / ring) : sin(2 * pi * (quarter - k) / ring);
    const double b = 2 * k <= quarter ? sin(2 * pi * k / ring) : cos(2 * pi * (quarter - k) / ring);
    *c = quadrant == 0 ? a : quadrant == 1 ? -b : quadrant == 2 ? -a : b;
    *s = quadrant == 0 ? b : quadrant == 1 ? a : quadrant == 2 ? -b : -a;
    if (k == 0) *(quadrant % 2 ? c : s) = 0.0;
}

static vec section_point(const section* q, int i, int ring) {
    double c, s;
    vec p;
    ring_point(i, ring, &c, &s);
    c = copysign(pow(fabs(c), 2.0 / q->exponent), c);
    s = copysign(pow(fabs(s), 2.0 / q->exponent), s);
    p.x = q->centre.x + c * q->u.x + s * q->w.x;
    p.y = q->centre.y + c * q->u.y + s * q->w.y;
    p.z = q->centre.z + c * q->u.z + s * q->w.z;
    return p;
}

/* Closed surface through the sections; `ring` points each, a multiple of 4. Mirrored quadrants are cut along mirrored
 * diagonals, so that the triangles mirror as the points do. */
static void add_loft(shape* s, const section* sections, int n, int ring) {
    const int first = s->count;
    double volume = 0.0;
    int k, i;
    for (i = 0; i < ring; ++i) {
        const int j = (i + 1) % ring, odd = (i / (ring / 4)) % 2;
        add_triangle(s, sections[0].centre, section_point(&sections[0], j, ring), section_point(&sections[0], i, ring));
        add_triangle(s, sections[n - 1].centre, section_point(&sections[n - 1], i, ring),
                     section_point(&sections[n - 1], j, ring));
        for (k = 0; k + 1 < n; ++k) {
            const vec a = section_point(&sections[k], i, ring), b = section_point(&sections[k], j, ring);
            const vec c = section_point(&sections[k + 1], j, ring), d = section_point(&sections[k + 1], i, ring);
            if (odd) {
                add_triangle(s, a, b, d);
                add_triangle(s, b, c, d);
            } else {
                add_triangle(s, a, b, c);
                add_triangle(s, a, c, d);
            }
        }
    }
    for (i = first; i < s->count; ++i) volume += six_volumes(s->corner[i]);
    for (i = first; volume < 0.0 && i < s->count; ++i) {
        const vec b = s->corner[i][1];
        s->corner[i][1] = s->corner[i][2];
        s->corner[i][2] = b;
    }
}

/* Repeats the triangles from `first` on, mirrored across y = 0. */
static void add_mirrored(shape* s, int first) {
    const int end = s->count;
    int i, p;
    for (i = first; i < end; ++i) {
        vec t[3];
        for (p = 0; p < 3; ++p) {
            t[p] = s->corner[i][p];
            t[p].y = -t[p].y;
        }
        add_triangle(s, t[0], t[2], t[1]);
    }
}

/* Catmull-Rom interpolation of a table of `columns` numbers a row: `parts` pieces per interval. */
static int refine(const double* table, int rows, int columns, int parts, double* out) {
    int n = 0, r, p, c;
    for (r = 0; r + 1 < rows; ++r)
        for (p = 0; p < parts || (p == parts && r + 2 == rows); ++p, ++n)
            for (c = 0; c < columns; ++c) {
                const double t = (double)p / parts;
                const double b = table[r * columns + c], d = table[(r + 1) * columns + c];
                const double a = r > 0 ? table[(r - 1) * columns + c] : 2 * b - d;
                const double e = r + 2 < rows ? table[(r + 2) * columns + c] : 2 * d - b;
                out[n * columns + c] =
                    b + 0.5 * t * (d - a + t * (2 * a - 5 * b + 4 * d - e + t * (3 * (b - d) + e - a)));
            }
    return n;
}

/* Body or median fin along x. Rows: x, top z, bottom z, half width in y. */
static void add_along_x(shape* s, const double (*rows)[4], int n_rows, int parts, int ring, double exponent) {
    double fine[MAX_SECTIONS * 4];
    section sections[MAX_SECTIONS];
    const int n = refine(rows[0], n_rows, 4, parts, fine);
    int i;
    for (i = 0; i < n; ++i) {
        const double* r = fine + 4 * i;
        const section q = {{r[0], 0, 0.5 * (r[1] + r[2])}, {0, r[3], 0}, {0, 0, 0.5 * (r[1] - r[2])}, exponent};
        sections[i] = q;
    }
    add_loft(s, sections, n, ring);
}

/* Median fin along z. Rows: z, leading x, trailing x, half thickness in y. */
static void add_along_z(shape* s, const double (*rows)[4], int n_rows, int parts, int ring) {
    double fine[MAX_SECTIONS * 4];
    section sections[MAX_SECTIONS];
    const int n = refine(rows[0], n_rows, 4, parts, fine);
    int i;
    for (i = 0; i < n; ++i) {
        const double* r = fine + 4 * i;
        const section q = {{0.5 * (r[1] + r[2]), 0, r[0]}, {0.5 * (r[1] - r[2]), 0, 0}, {0, r[3], 0}, 2.5};
        sections[i] = q;
    }
    add_loft(s, sections, n, ring);
}

/* Paired fins along a line in space. Rows: x, y, z of the middle of the chord, half chord along x, half chord along z,
 * half thickness in y. Adds both sides. */
static void add_pair(shape* s, const double (*rows)[6], int n_rows, int parts, int ring) {
    const int first = s->count;
    double fine[MAX_SECTIONS * 6];
    section sections[MAX_SECTIONS];
    const int n = refine(rows[0], n_rows, 6, parts, fine);
    int i;
    for (i = 0; i < n; ++i) {
        const double* r = fine + 6 * i;
        const section q = {{r[0], r[1], r[2]}, {r[3], 0, r[4]}, {0, r[5], 0}, 2.5};
        sections[i] = q;
    }
    add_loft(s, sections, n, ring);
    add_mirrored(s, first);
}

#define ROWS(table) (table), (int)(sizeof(table) / sizeof((table)[0]))

/* Eels are 15 to 20 times as long as thick, with a dorsal fin that begins behind the head and runs around the tail into
 * the anal fin. These have a body of 1/14 and, with that fin, are 0.11 across their wide axis: 4 cells of 1/36 length,
 * as a box of 40 x 8 x 8 cells allows. Flag-like: the fin stands upright; pancake-like: it lies flat. */
static void eel(shape* s, int vertical) {
    /* x, half extent along the wide axis, along the narrow axis */
    static const double body[][3] = {{0.500, 0.006, 0.007},  {0.493, 0.014, 0.015},  {0.470, 0.024, 0.022},
                                     {0.430, 0.033, 0.028},  {0.380, 0.037, 0.030},  {0.300, 0.037, 0.030},
                                     {0.200, 0.037, 0.029},  {0.000, 0.037, 0.029},  {-0.150, 0.034, 0.027},
                                     {-0.300, 0.026, 0.023}, {-0.420, 0.017, 0.019}, {-0.470, 0.010, 0.012}};
    static const double fin[][3] = {{0.280, 0.024, 0.017},  {0.250, 0.034, 0.017},  {0.190, 0.046, 0.017},
                                    {0.110, 0.053, 0.017},  {0.000, 0.055, 0.017},  {-0.180, 0.054, 0.017},
                                    {-0.320, 0.048, 0.016}, {-0.420, 0.036, 0.015}, {-0.470, 0.024, 0.014},
                                    {-0.493, 0.013, 0.012}, {-0.500, 0.006, 0.009}};
    enum { BODY = sizeof(body) / sizeof(body[0]), FIN = sizeof(fin) / sizeof(fin[0]) };
    double rows[BODY + FIN][4];
    int i;
    for (i = 0; i < BODY + FIN; ++i) {
        const double* from = i < BODY ? body[i] : fin[i - BODY];
        const double up = from[vertical ? 1 : 2], across = from[vertical ? 2 : 1];
        const double row[4] = {from[0], up, -up, across};
        memcpy(rows[i], row, sizeof(row));
    }
    add_along_x(s, (const double(*)[4])rows, BODY, 3, 20, 2.2);
    add_along_x(s, (const double(*)[4])(rows + BODY), FIN, 3, 16, 3.0);
}

/* Amphiprion ocellaris: body depth 2.1 to 2.4 times in the standard length, caudal fin rounded, one long dorsal fin of
 * 10-11 spines and 13-17 soft rays with a dip between them (FishBase, www.fishbase.org, Amphiprion ocellaris); large
 * rounded pectoral fins. Here the standard length is 0.83 and the body 0.35 deep, about 2.4 times. */
static void clownfish(shape* s) {
    static const double body[][4] = {
        {0.500, 0.016, -0.036, 0.018},  {0.494, 0.046, -0.066, 0.038},  {0.470, 0.086, -0.096, 0.058},
        {0.420, 0.130, -0.126, 0.076},  {0.330, 0.166, -0.152, 0.090},  {0.220, 0.182, -0.168, 0.095},
        {0.100, 0.182, -0.170, 0.090},  {-0.020, 0.166, -0.158, 0.077}, {-0.130, 0.132, -0.130, 0.060},
        {-0.220, 0.100, -0.100, 0.045}, {-0.280, 0.084, -0.084, 0.035}, {-0.330, 0.076, -0.076, 0.026},
        {-0.350, 0.062, -0.062, 0.020}};
    static const double caudal[][4] = {{-0.290, 0.060, -0.060, 0.021}, {-0.335, 0.090, -0.090, 0.020},
                                       {-0.380, 0.117, -0.117, 0.019}, {-0.425, 0.126, -0.126, 0.018},
                                       {-0.460, 0.115, -0.115, 0.017}, {-0.485, 0.086, -0.086, 0.016},
                                       {-0.500, 0.040, -0.040, 0.014}};
    static const double dorsal[][4] = {
        {0.330, 0.140, 0.110, 0.018},  {0.290, 0.200, 0.115, 0.019},  {0.220, 0.228, 0.120, 0.019},
        {0.130, 0.232, 0.120, 0.019},  {0.050, 0.222, 0.115, 0.018},  {-0.010, 0.212, 0.105, 0.018},
        {-0.080, 0.222, 0.085, 0.018}, {-0.150, 0.230, 0.065, 0.017}, {-0.210, 0.222, 0.055, 0.016},
        {-0.260, 0.188, 0.050, 0.016}, {-0.285, 0.140, 0.050, 0.015}, {-0.292, 0.100, 0.050, 0.014}};
    static const double anal[][4] = {{0.000, -0.120, -0.150, 0.018},  {-0.050, -0.100, -0.192, 0.018},
                                     {-0.110, -0.085, -0.222, 0.018}, {-0.170, -0.070, -0.228, 0.017},
                                     {-0.225, -0.060, -0.208, 0.016}, {-0.265, -0.055, -0.165, 0.015},
                                     {-0.285, -0.055, -0.115, 0.014}};
    static const double pectoral[][6] = {
        {0.230, 0.066, -0.040, 0.0, 0.034, 0.020}, {0.190, 0.098, -0.043, 0.0, 0.058, 0.019},
        {0.145, 0.116, -0.046, 0.0, 0.078, 0.018}, {0.095, 0.126, -0.049, 0.0, 0.084, 0.016},
        {0.058, 0.130, -0.051, 0.0, 0.066, 0.014}, {0.038, 0.131, -0.052, 0.0, 0.034, 0.012}};
    static const double pelvic[][6] = {{0.220, 0.028, -0.120, 0.044, 0.0, 0.018},
                                       {0.190, 0.031, -0.175, 0.048, 0.0, 0.018},
                                       {0.145, 0.034, -0.212, 0.052, 0.0, 0.017},
                                       {0.105, 0.036, -0.232, 0.044, 0.0, 0.015},
                                       {0.080, 0.037, -0.240, 0.022, 0.0, 0.012}};
    add_along_x(s, ROWS(body), 3, 20, 2.2);
    add_along_x(s, ROWS(caudal), 2, 12, 3.0);
    add_along_x(s, ROWS(dorsal), 2, 12, 3.0);
    add_along_x(s, ROWS(anal), 2, 12, 3.0);
    add_pair(s, ROWS(pectoral), 2, 12);
    add_pair(s, ROWS(pelvic), 1, 12);
}

/* Thunnus: a streamlined body of depth/length 0.25, deepest before the middle; two dorsal fins close together, the
 * second and the anal fin sickle-shaped and opposite each other; pectoral fins of about a quarter of the length; a very
 * slender peduncle that its keels make wider than tall, and a lunate caudal fin of high aspect ratio with a span of
 * about a third of the length (after Collette and Nauen 1983, FAO Species Catalogue vol. 2, Scombrids of the world).
 * The finlets are below the size of a cell and left out. */
static void tuna(shape* s) {
    static const double body[][4] = {
        {0.500, 0.006, -0.008, 0.006},  {0.485, 0.019, -0.020, 0.015},  {0.440, 0.046, -0.044, 0.035},
        {0.350, 0.083, -0.082, 0.061},  {0.240, 0.112, -0.113, 0.078},  {0.120, 0.123, -0.127, 0.084},
        {0.000, 0.115, -0.120, 0.079},  {-0.120, 0.092, -0.096, 0.066}, {-0.220, 0.063, -0.065, 0.050},
        {-0.300, 0.038, -0.039, 0.036}, {-0.360, 0.022, -0.022, 0.030}, {-0.400, 0.018, -0.018, 0.022},
        {-0.420, 0.012, -0.012, 0.014}};
    static const double caudal[][4] = {
        {-0.172, -0.476, -0.500, 0.011}, {-0.150, -0.452, -0.493, 0.012}, {-0.115, -0.420, -0.472, 0.014},
        {-0.075, -0.392, -0.452, 0.016}, {-0.035, -0.368, -0.436, 0.018}, {0.000, -0.350, -0.430, 0.019},
        {0.035, -0.368, -0.436, 0.018},  {0.075, -0.392, -0.452, 0.016},  {0.115, -0.420, -0.472, 0.014},
        {0.150, -0.452, -0.493, 0.012},  {0.172, -0.476, -0.500, 0.011}};
    static const double first_dorsal[][4] = {{0.180, 0.115, 0.090, 0.016}, {0.165, 0.165, 0.090, 0.016},
                                             {0.140, 0.188, 0.090, 0.016}, {0.100, 0.172, 0.090, 0.016},
                                             {0.050, 0.150, 0.085, 0.015}, {0.000, 0.126, 0.080, 0.014}};
    static const double second_dorsal[][4] = {{0.070, -0.030, -0.130, 0.017},
                                              {0.110, -0.055, -0.135, 0.016},
                                              {0.150, -0.090, -0.145, 0.014},
                                              {0.180, -0.122, -0.160, 0.012},
                                              {0.196, -0.145, -0.170, 0.011}};
    static const double anal[][4] = {{-0.070, -0.055, -0.150, 0.017},
                                     {-0.110, -0.080, -0.155, 0.016},
                                     {-0.150, -0.115, -0.165, 0.014},
                                     {-0.180, -0.147, -0.180, 0.012},
                                     {-0.196, -0.170, -0.190, 0.011}};
    static const double pectoral[][6] = {{0.235, 0.060, -0.010, 0.0, 0.026, 0.018},
                                         {0.180, 0.082, -0.016, 0.0, 0.026, 0.017},
                                         {0.110, 0.096, -0.024, 0.0, 0.023, 0.016},
                                         {0.040, 0.101, -0.032, 0.0, 0.019, 0.015},
                                         {0.000, 0.102, -0.036, 0.0, 0.012, 0.012}};
    static const double pelvic[][6] = {{0.190, 0.022, -0.100, 0.026, 0.0, 0.016},
                                       {0.165, 0.025, -0.145, 0.022, 0.0, 0.014},
                                       {0.140, 0.027, -0.168, 0.012, 0.0, 0.011}};
    add_along_x(s, ROWS(body), 3, 20, 2.0);
    add_along_z(s, ROWS(caudal), 2, 12);
    add_along_x(s, ROWS(first_dorsal), 2, 12, 3.0);
    add_along_z(s, ROWS(second_dorsal), 2, 12);
    add_along_z(s, ROWS(anal), 2, 12);
    add_pair(s, ROWS(pectoral), 2, 12);
    add_pair(s, ROWS(pelvic), 1, 12);
}

static void put_u32(unsigned char* to, uint32_t v) {
    int b;
    for (b = 0; b < 4; ++b) to[b] = (unsigned char)(v >> (8 * b) & 0xff);
}

static void put_float(unsigned char* to, double v) {
    const float f = (float)v;
    uint32_t bits;
    memcpy(&bits, &f, sizeof(bits));
    put_u32(to, bits);
}

static int write_stl(const shape* s, const char* folder, const char* name) {
    char path[4096];
    unsigned char record[84];
    FILE* file;
    int i, p, good;
    if (snprintf(path, sizeof(path), "%s/%s.stl", folder, name) >= (int)sizeof(path)) return 0;
    file = fopen(path, "wb");
    if (!file) {
        perror(path);
        return 0;
    }
    memset(record, 0, sizeof(record));
    snprintf((char*)record, 80, "diffaqua example shape: %s; head +x, z up, length 1", name);
    put_u32(record + 80, (uint32_t)s->count);
    good = fwrite(record, 84, 1, file) == 1;
    for (i = 0; i < s->count; ++i) {
        const vec* t = s->corner[i];
        memset(record, 0, 50); /* a zero normal: readers compute it from the corners */
        for (p = 0; p < 3; ++p) {
            put_float(record + 12 + 12 * p, t[p].x);
            put_float(record + 16 + 12 * p, t[p].y);
            put_float(record + 20 + 12 * p, t[p].z);
        }
        good = good && fwrite(record, 50, 1, file) == 1;
    }
    if (fclose(file) != 0) good = 0;
    if (!good) fprintf(stderr, "%s: could not be written\n", path);
    return good;
}

int main(int argc, char** argv) {
    static const char* const names[] = {"eel_vertical", "eel_horizontal", "clownfish", "tuna"};
    static shape s;
    int k;
    if (argc != 2) {
        fprintf(stderr, "usage: %s OUTDIR\n", argv[0]);
        return 2;
    }
    for (k = 0; k < 4; ++k) {
        s.count = 0;
        if (k < 2) eel(&s, k == 0);
        if (k == 2) clownfish(&s);
        if (k == 3) tuna(&s);
        if (!write_stl(&s, argv[1], names[k])) return 1;
    }
    return 0;
}
