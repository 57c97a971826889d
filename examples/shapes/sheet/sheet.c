/* SPDX-License-Identifier: MIT
 *
 * Draws the contact sheet: all shapes of a folder, shaded and named, on one picture.
 *
 *     sheet SHAPES_DIR OUT.png [three-quarter|side|top|front]
 *
 * Triangles are drawn into a depth buffer, three samples a pixel and axis; gnuplot writes the names and the file.
 */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "paint.h"

#define COLUMNS 5
#define ROWS 4
#define PANEL_WIDTH 288 /* pixels */
#define PANEL_HEIGHT 236
#define NAME_HEIGHT 30 /* of the panel, below the shape */
#define SAMPLES 3      /* a pixel and axis */
#define WIDE (PANEL_WIDTH * SAMPLES)
#define HIGH ((PANEL_HEIGHT - NAME_HEIGHT) * SAMPLES)
#define BACKGROUND 0xf3f7faU
#define DEGREE (3.14159265358979323846 / 180.0)

typedef struct {
    double x, y, z;
} vec;

typedef struct {
    const char* file;
    const char* name;
    paint paint;
    double azimuth, elevation; /* degrees: towards the head, upwards */
} subject;

static const subject subjects[] = {
    {"great_white", "great white shark", paint_great_white, 35, 14},
    {"hammerhead", "great hammerhead", paint_hammerhead, 44, 32},
    {"thresher", "common thresher", paint_thresher, 22, 14},
    {"whale_shark", "whale shark", paint_whale_shark, 42, 22},
    {"orca", "orca", paint_orca, 32, 16},
    {"manta_ray", "manta ray", paint_manta, 52, 42},
    {"stingray", "stingray", paint_stingray, 20, 60},
    {"clownfish", "clownfish", paint_clownfish, 28, 14},
    {"tuna", "tuna", paint_tuna, 26, 14},
    {"submarine", "submarine", paint_submarine, 36, 20},
    {"goldfish_common", "goldfish: common", paint_common, 28, 14},
    {"goldfish_comet", "goldfish: comet", paint_comet, 26, 14},
    {"goldfish_fantail", "goldfish: fantail", paint_fantail, 32, 20},
    {"goldfish_ryukin", "goldfish: ryukin", paint_ryukin, 28, 16},
    {"goldfish_oranda", "goldfish: oranda", paint_oranda, 34, 16},
    {"goldfish_ranchu", "goldfish: ranchu", paint_ranchu, 34, 18},
    {"goldfish_telescope", "goldfish: telescope", paint_telescope, 42, 20},
    {"eel_vertical", "eel, fin upright", paint_eel, 26, 24},
    {"eel_horizontal", "eel, fin flat", paint_eel, 26, 24},
};
#define SUBJECTS ((int)(sizeof(subjects) / sizeof(subjects[0])))

static vec minus(vec a, vec b) {
    return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}
static double dot(vec a, vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static vec cross(vec a, vec b) {
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static vec unit(vec a) {
    const double l = sqrt(dot(a, a)) + 1e-300;
    return (vec){a.x / l, a.y / l, a.z / l};
}

typedef struct {
    int count;
    vec (*corner)[3];
    vec (*normal)[3]; /* at corners */
    int (*vertex)[3];
} shape;

static void* memory(size_t count, size_t size) {
    void* p = calloc(count, size);
    if (p == NULL) {
        fprintf(stderr, "sheet: out of memory\n");
        exit(1);
    }
    return p;
}

static uint32_t u32_at(const unsigned char* p) {
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static double float_at(const unsigned char* p) {
    const uint32_t bits = u32_at(p);
    float f;
    memcpy(&f, &bits, sizeof(f));
    return (double)f;
}

static int read_stl(const char* path, shape* s) {
    unsigned char record[84];
    FILE* file = fopen(path, "rb");
    int good;
    if (file == NULL) {
        perror(path);
        return 0;
    }
    good = fread(record, 84, 1, file) == 1;
    s->count = good ? (int)u32_at(record + 80) : 0;
    good = good && s->count > 0 && s->count < 1000000;
    if (good) {
        s->corner = memory((size_t)s->count, sizeof(*s->corner));
        s->normal = memory((size_t)s->count, sizeof(*s->normal));
        s->vertex = memory((size_t)s->count, sizeof(*s->vertex));
    }
    for (int t = 0; good && t < s->count; ++t) {
        good = fread(record, 50, 1, file) == 1;
        for (int p = 0; p < 3; ++p) {
            const unsigned char* at = record + 12 + 12 * p;
            s->corner[t][p] = (vec){float_at(at), float_at(at + 4), float_at(at + 8)};
        }
    }
    (void)fclose(file);
    if (!good) fprintf(stderr, "%s: no binary STL file\n", path);
    return good;
}

typedef struct {
    vec at;
    int corner;
} place;

static int by_place(const void* pa, const void* pb) {
    const place *a = pa, *b = pb;
    if (a->at.x != b->at.x) return a->at.x < b->at.x ? -1 : 1;
    if (a->at.y != b->at.y) return a->at.y < b->at.y ? -1 : 1;
    if (a->at.z != b->at.z) return a->at.z < b->at.z ? -1 : 1;
    return a->corner - b->corner;
}

/* Normals at corners: the mean over the triangles of the vertex that turn from this one by less than 50 degrees. */
static void smooth_normals(shape* s) {
    const size_t n = 3 * (size_t)s->count;
    place* places = memory(n, sizeof(place));
    vec* face = memory((size_t)s->count, sizeof(vec));
    for (int t = 0; t < s->count; ++t) {
        face[t] = cross(minus(s->corner[t][1], s->corner[t][0]), minus(s->corner[t][2], s->corner[t][0]));
        for (int p = 0; p < 3; ++p) places[3 * t + p] = (place){s->corner[t][p], 3 * t + p};
    }
    qsort(places, n, sizeof(place), by_place);
    for (size_t i = 0, end; i < n; i = end) {
        for (end = i; end < n && memcmp(&places[end].at, &places[i].at, sizeof(vec)) == 0; ++end) continue;
        for (size_t a = i; a < end; ++a) {
            const vec own = unit(face[places[a].corner / 3]);
            vec sum = {0, 0, 0};
            for (size_t b = i; b < end; ++b) {
                const vec f = face[places[b].corner / 3];
                if (dot(unit(f), own) > 0.64) sum = (vec){sum.x + f.x, sum.y + f.y, sum.z + f.z};
            }
            s->normal[places[a].corner / 3][places[a].corner % 3] = unit(sum);
        }
    }
    free(places);
    free(face);
}

typedef struct {
    vec right, up, to;  /* to the viewer */
    double scale, x, y; /* samples per length, and of the origin */
} camera;

typedef struct {
    float depth[HIGH][WIDE]; /* towards the viewer; -1e9: nothing */
    colour shade[HIGH][WIDE];
} canvas;

static camera look(const shape* s, double azimuth, double elevation) {
    const double a = azimuth * DEGREE, e = elevation * DEGREE;
    camera c;
    double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9}, sx, sy;
    c.right = (vec){-cos(a), sin(a), 0};
    c.to = (vec){cos(e) * sin(a), cos(e) * cos(a), sin(e)};
    c.up = (vec){-sin(e) * sin(a), -sin(e) * cos(a), cos(e)};
    for (int t = 0; t < s->count; ++t)
        for (int p = 0; p < 3; ++p) {
            const double x = dot(c.right, s->corner[t][p]), y = dot(c.up, s->corner[t][p]);
            low[0] = fmin(low[0], x), high[0] = fmax(high[0], x), low[1] = fmin(low[1], y), high[1] = fmax(high[1], y);
        }
    sx = 0.92 * WIDE / (high[0] - low[0]), sy = 0.92 * HIGH / (high[1] - low[1]);
    c.scale = fmin(sx, sy);
    c.x = 0.5 * WIDE - 0.5 * c.scale * (low[0] + high[0]);
    c.y = 0.5 * HIGH + 0.5 * c.scale * (low[1] + high[1]);
    return c;
}

/* Sky above, sand below, a sun over the viewer's left shoulder, and its glint. */
static colour lit(colour c, vec n, const camera* from) {
    const vec sun = unit((vec){0.55 * from->to.x - 0.45 * from->right.x + 0.70 * from->up.x,
                               0.55 * from->to.y - 0.45 * from->right.y + 0.70 * from->up.y,
                               0.55 * from->to.z - 0.45 * from->right.z + 0.70 * from->up.z});
    const vec half = unit((vec){sun.x + from->to.x, sun.y + from->to.y, sun.z + from->to.z});
    const double sky = 0.5 + 0.5 * n.z, direct = fmax(dot(n, sun), 0.0), glint = pow(fmax(dot(n, half), 0.0), 40.0);
    const double light = 0.34 + 0.22 * sky + 0.58 * direct;
    c.r = fmin(c.r * light + 0.16 * glint, 1.0);
    c.g = fmin(c.g * light + 0.16 * glint, 1.0);
    c.b = fmin(c.b * (light + 0.02 * sky) + 0.17 * glint, 1.0);
    return c;
}

static void draw_triangle(canvas* v, const camera* c, const shape* s, int t, paint paint_of) {
    double x[3], y[3], z[3], area;
    int x0, x1, y0, y1;
    for (int p = 0; p < 3; ++p) {
        x[p] = c->x + c->scale * dot(c->right, s->corner[t][p]);
        y[p] = c->y - c->scale * dot(c->up, s->corner[t][p]);
        z[p] = dot(c->to, s->corner[t][p]);
    }
    area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    if (area >= 0.0) return; /* seen from inside: y grows downwards */
    x0 = (int)fmax(floor(fmin(fmin(x[0], x[1]), x[2])), 0),
    x1 = (int)fmin(ceil(fmax(fmax(x[0], x[1]), x[2])), WIDE - 1);
    y0 = (int)fmax(floor(fmin(fmin(y[0], y[1]), y[2])), 0),
    y1 = (int)fmin(ceil(fmax(fmax(y[0], y[1]), y[2])), HIGH - 1);
    for (int j = y0; j <= y1; ++j)
        for (int i = x0; i <= x1; ++i) {
            const double px = i + 0.5, py = j + 0.5;
            const double a = ((x[1] - px) * (y[2] - py) - (x[2] - px) * (y[1] - py)) / area;
            const double b = ((x[2] - px) * (y[0] - py) - (x[0] - px) * (y[2] - py)) / area, d = 1 - a - b;
            const double depth = a * z[0] + b * z[1] + d * z[2];
            double at[3], normal[3];
            const vec* q = s->corner[t];
            vec n;
            if (a < 0 || b < 0 || d < 0 || depth <= (double)v->depth[j][i]) continue;
            v->depth[j][i] = (float)depth;
            at[0] = a * q[0].x + b * q[1].x + d * q[2].x;
            at[1] = a * q[0].y + b * q[1].y + d * q[2].y;
            at[2] = a * q[0].z + b * q[1].z + d * q[2].z;
            q = s->normal[t];
            n = unit((vec){a * q[0].x + b * q[1].x + d * q[2].x, a * q[0].y + b * q[1].y + d * q[2].y,
                           a * q[0].z + b * q[1].z + d * q[2].z});
            normal[0] = n.x, normal[1] = n.y, normal[2] = n.z;
            v->shade[j][i] = lit(paint_of(at, normal), n, c);
        }
}

/* A line where what lies behind is far behind. */
static int on_outline(const canvas* v, int i, int j) {
    static const int around[8][2] = {{2, 0}, {-2, 0}, {0, 2}, {0, -2}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}};
    for (int k = 0; k < 8; ++k) {
        const int x = i + around[k][0], y = j + around[k][1];
        const float d = x < 0 || y < 0 || x >= WIDE || y >= HIGH ? -1e9f : v->depth[y][x];
        if (v->depth[j][i] - d > 0.035f) return 1;
    }
    return 0;
}

static unsigned char byte_of(double sum) {
    /* Steps of 4: nobody sees them, and the file is smaller by a third. */
    const int value = 4 * (int)(sum / (SAMPLES * SAMPLES) * 255 / 4 + 0.5);
    return (unsigned char)(value > 255 ? 255 : value);
}

static void resolve(const canvas* v, unsigned char* picture, int column, int row) {
    for (int py = 0; py < HIGH / SAMPLES; ++py)
        for (int px = 0; px < PANEL_WIDTH; ++px) {
            double sum[3] = {0, 0, 0};
            int covered = 0;
            unsigned char* to = picture + 3 * ((size_t)(row * PANEL_HEIGHT + py) * (COLUMNS * PANEL_WIDTH) +
                                               (size_t)(column * PANEL_WIDTH + px));
            for (int k = 0; k < SAMPLES * SAMPLES; ++k) {
                const int i = px * SAMPLES + k % SAMPLES, j = py * SAMPLES + k / SAMPLES;
                const double line = v->depth[j][i] > -1e8f && on_outline(v, i, j) ? 0.35 : 1.0;
                colour c = v->shade[j][i];
                if (v->depth[j][i] > -1e8f)
                    ++covered;
                else
                    c = (colour){(BACKGROUND >> 16) / 255.0, (BACKGROUND >> 8 & 255) / 255.0,
                                 (BACKGROUND & 255) / 255.0};
                sum[0] += line * c.r, sum[1] += line * c.g, sum[2] += line * c.b;
            }
            for (int b = 0; covered > 0 && b < 3; ++b) to[b] = byte_of(sum[b]);
        }
}

static int draw_subject(const subject* q, const char* folder, const char* view, unsigned char* picture, int number) {
    static canvas v;
    char path[4096];
    shape s = {0, NULL, NULL, NULL};
    camera c;
    double azimuth = q->azimuth, elevation = q->elevation;
    if (strcmp(view, "side") == 0) azimuth = elevation = 0;
    if (strcmp(view, "top") == 0) azimuth = 0, elevation = 90;
    if (strcmp(view, "front") == 0) azimuth = 88, elevation = 2;
    if (snprintf(path, sizeof(path), "%s/%s.stl", folder, q->file) >= (int)sizeof(path)) return 0;
    if (!read_stl(path, &s)) return 0;
    smooth_normals(&s);
    c = look(&s, azimuth, elevation);
    for (int j = 0; j < HIGH; ++j)
        for (int i = 0; i < WIDE; ++i) v.depth[j][i] = -1e9f;
    for (int t = 0; t < s.count; ++t) draw_triangle(&v, &c, &s, t, q->paint);
    resolve(&v, picture, number % COLUMNS, number / COLUMNS);
    free(s.corner);
    free(s.normal);
    free(s.vertex);
    return 1;
}

/* gnuplot's binary images begin at the bottom left unless told; flipy turns them. */
static int label(const unsigned char* picture, const char* out) {
    const int width = COLUMNS * PANEL_WIDTH, height = ROWS * PANEL_HEIGHT;
    char raw[4096];
    FILE *file, *gnuplot;
    int good;
    if (snprintf(raw, sizeof(raw), "%s.rgb", out) >= (int)sizeof(raw) || strchr(out, '\'') != NULL) {
        fprintf(stderr, "sheet: cannot use the path %s\n", out);
        return 0;
    }
    file = fopen(raw, "wb");
    if (file == NULL) {
        perror(raw);
        return 0;
    }
    good = fwrite(picture, 3 * (size_t)width * (size_t)height, 1, file) == 1;
    good = fclose(file) == 0 && good;
    gnuplot = good ? popen("gnuplot", "w") : NULL;
    if (gnuplot != NULL) {
        fprintf(gnuplot,
                "set terminal pngcairo size %d,%d font 'sans,12' background '#%06x'\nset output '%s'\n"
                "set lmargin at screen 0\nset rmargin at screen 1\nset bmargin at screen 0\nset tmargin at screen 1\n"
                "unset border\nunset tics\nunset key\nset xrange [-0.5:%g]\nset yrange [-0.5:%g]\n",
                width, height, BACKGROUND, out, width - 0.5, height - 0.5);
        for (int k = 0; k < SUBJECTS; ++k)
            fprintf(gnuplot, "set label '%s' at first %g,%g center front textcolor rgb '#22303c'\n", subjects[k].name,
                    (k % COLUMNS + 0.5) * PANEL_WIDTH, height - (k / COLUMNS + 1) * PANEL_HEIGHT + 0.5 * NAME_HEIGHT);
        fprintf(gnuplot, "plot '%s' binary array=(%d,%d) flipy format='%%uchar' with rgbimage\n", raw, width, height);
        good = pclose(gnuplot) == 0;
    }
    if (gnuplot == NULL || !good) fprintf(stderr, "sheet: gnuplot did not draw %s\n", out);
    (void)remove(raw);
    return gnuplot != NULL && good;
}

int main(int argc, char** argv) {
    const size_t pixels = (size_t)COLUMNS * PANEL_WIDTH * ROWS * PANEL_HEIGHT;
    unsigned char* picture;
    int good = 1;
    if (argc < 3 || argc > 4) {
        fprintf(stderr, "usage: %s SHAPES_DIR OUT.png [three-quarter|side|top|front]\n", argv[0]);
        return 2;
    }
    picture = memory(pixels, 3);
    for (size_t i = 0; i < pixels; ++i)
        for (int b = 0; b < 3; ++b) picture[3 * i + (size_t)b] = (unsigned char)(BACKGROUND >> (16 - 8 * b) & 255);
    for (int k = 0; k < SUBJECTS && good; ++k)
        good = draw_subject(&subjects[k], argv[1], argc == 4 ? argv[3] : "three-quarter", picture, k);
    good = good && label(picture, argv[2]);
    free(picture);
    return good ? 0 : 1;
}
