/* SPDX-License-Identifier: MIT
 * Signed distances of lofts, plates and ellipsoids. Sections of lofts are interpolated by monotone cubics (Fritsch and
 * Butland 1984), outlines by Catmull-Rom curves; parts are joined by the polynomial smooth minimum. Distances are
 * exact on the surface and of first order near it, which is all that a surface needs. */
#include "solid.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define CURVE_PIECES 4 /* of an outline, between two of its points */
#define BEVEL 0.008    /* cut from corners of outlines */
#define FAR 0.08       /* beyond this from a part's bounds their distance stands for the part's */

static double least(double a, double b) {
    return a < b ? a : b;
}
static double most(double a, double b) {
    return a > b ? a : b;
}
static double dot(vec a, vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static vec minus(vec a, vec b) {
    const vec d = {a.x - b.x, a.y - b.y, a.z - b.z};
    return d;
}
static vec scaled(vec a, double t) {
    const vec d = {a.x * t, a.y * t, a.z * t};
    return d;
}
static vec unit(vec a) {
    return scaled(a, 1.0 / sqrt(dot(a, a)));
}

static part* new_part(solid* s, part_kind kind, double fillet) {
    part* p = &s->part[s->parts];
    if (s->parts == SOLID_MAX_PARTS) {
        fprintf(stderr, "generate: more than %d parts\n", SOLID_MAX_PARTS);
        exit(1);
    }
    ++s->parts;
    p->kind = kind;
    p->fillet = fillet;
    return p;
}

static double hermite(const double* x, const double* y, const double* slope, int k, double at) {
    const double h = x[k + 1] - x[k], t = (at - x[k]) / h;
    const double rise = y[k + 1] - y[k], a = slope[k] * h - rise, b = rise - slope[k + 1] * h;
    return y[k] + t * rise + t * (1 - t) * ((1 - t) * a + t * b);
}

static void monotone_slopes(const double* x, const double* y, double* slope, int n) {
    for (int k = 0; k < n; ++k) {
        const double before = k > 0 ? (y[k] - y[k - 1]) / (x[k] - x[k - 1]) : 0.0;
        const double after = k + 1 < n ? (y[k + 1] - y[k]) / (x[k + 1] - x[k]) : 0.0;
        if (k == 0 || k + 1 == n) {
            slope[k] = before + after;
        } else if (before * after <= 0.0) {
            slope[k] = 0.0;
        } else {
            const double h0 = x[k] - x[k - 1], h1 = x[k + 1] - x[k], w = (h0 + 2 * h1) / (3 * (h0 + h1));
            slope[k] = before * after / (w * after + (1 - w) * before);
        }
    }
}

static void finish_loft(part* p) {
    loft* l = &p->of.loft;
    const int n = l->rows;
    double low[3], high[3];
    for (int c = 0; c < 5; ++c) monotone_slopes(l->s, l->value[c], l->slope[c], n);
    low[0] = l->s[0], high[0] = l->s[n - 1];
    low[1] = low[2] = 1e9, high[1] = high[2] = -1e9;
    for (int k = 0; k < n; ++k) {
        const double half = sqrt(l->value[1][k]);
        low[1] = least(low[1], l->value[0][k] - half), high[1] = most(high[1], l->value[0][k] + half);
        low[2] = least(low[2], l->value[2][k] - sqrt(l->value[4][k]));
        high[2] = most(high[2], l->value[2][k] + sqrt(l->value[3][k]));
    }
    if (l->axis == 0) {
        p->low = (vec){low[0], low[1], low[2]}, p->high = (vec){high[0], high[1], high[2]};
    } else {
        p->low = (vec){low[2], low[0], low[1]}, p->high = (vec){high[2], high[0], high[1]};
    }
}

static void set_row(loft* l, int k, double at, double centre, double half, double high, double mid, double low) {
    l->s[k] = at;
    l->value[0][k] = centre;
    l->value[1][k] = half * half;
    l->value[2][k] = mid;
    l->value[3][k] = (high - mid) * (high - mid);
    l->value[4][k] = (mid - low) * (mid - low);
}

void add_body(solid* s, const double (*rows)[5], int n, double squareness, double fillet) {
    part* p = new_part(s, PART_LOFT, fillet);
    loft* l = &p->of.loft;
    const int falling = rows[0][0] > rows[n - 1][0];
    l->axis = 0, l->rows = n, l->squareness = squareness;
    for (int k = 0; k < n; ++k) {
        const double* r = rows[falling ? n - 1 - k : k];
        set_row(l, k, r[0], 0.0, r[4], r[1], r[2], r[3]);
    }
    finish_loft(p);
}

void add_wing(solid* s, const double (*rows)[6], int n, double squareness, double fillet) {
    part* p = new_part(s, PART_LOFT, fillet);
    loft* l = &p->of.loft;
    l->axis = 1, l->rows = n, l->squareness = squareness;
    for (int k = 0; k < n; ++k) set_row(l, k, rows[k][0], rows[k][4], rows[k][5], rows[k][1], rows[k][2], rows[k][3]);
    finish_loft(p);
}

/* The point at a small distance from a on the way to b. */
static void beside(const double a[2], const double b[2], double to[2]) {
    const double u = b[0] - a[0], v = b[1] - a[1], way = BEVEL / sqrt(u * u + v * v + 1e-30);
    to[0] = a[0] + way * u, to[1] = a[1] + way * v;
}

/* Closed Catmull-Rom curve through the points; one given twice becomes a bevelled corner, as a sharper one would be
 * lost between the nodes of the lattice. */
static void draw_outline(plate* q, const double (*given)[2], int n) {
    double points[PLATE_MAX_CORNERS][2];
    for (int k = 0; k < n; ++k) {
        const double *a = given[(k + n - 1) % n], *b = given[k], *c = given[(k + 1) % n];
        points[k][0] = b[0], points[k][1] = b[1];
        if (b[0] == c[0] && b[1] == c[1]) beside(b, a, points[k]);
        if (b[0] == a[0] && b[1] == a[1]) beside(b, c, points[k]);
    }
    q->corners = 0;
    for (int k = 0; k < n; ++k) {
        const double *a = points[(k + n - 1) % n], *b = points[k], *c = points[(k + 1) % n], *d = points[(k + 2) % n];
        for (int i = 0; i < CURVE_PIECES; ++i) {
            const double t = (double)i / CURVE_PIECES;
            if (q->corners == PLATE_MAX_CORNERS) {
                fprintf(stderr, "generate: an outline of more than %d corners\n", PLATE_MAX_CORNERS);
                exit(1);
            }
            for (int x = 0; x < 2; ++x)
                q->outline[q->corners][x] =
                    b[x] + 0.5 * t *
                               (c[x] - a[x] +
                                t * (2 * a[x] - 5 * b[x] + 4 * c[x] - d[x] + t * (3 * (b[x] - c[x]) + d[x] - a[x])));
            ++q->corners;
        }
    }
}

static void finish_plate(part* p, const double (*outline)[2], int n, double thinnest) {
    plate* q = &p->of.plate;
    double half;
    q->half0 = most(q->half0, thinnest), q->half1 = most(q->half1, thinnest);
    half = most(q->half0, q->half1);
    draw_outline(q, outline, n);
    p->low = (vec){1e9, 1e9, 1e9}, p->high = (vec){-1e9, -1e9, -1e9};
    for (int k = 0; k < q->corners; ++k)
        for (int side = -1; side <= 1; side += 2) {
            const double *c = q->outline[k], rise = q->bend * c[1] * c[1] + side * half;
            const vec at = {q->origin.x + c[0] * q->a.x + c[1] * q->b.x + rise * q->normal.x,
                            q->origin.y + c[0] * q->a.y + c[1] * q->b.y + rise * q->normal.y,
                            q->origin.z + c[0] * q->a.z + c[1] * q->b.z + rise * q->normal.z};
            p->low = (vec){least(p->low.x, at.x), least(p->low.y, at.y), least(p->low.z, at.z)};
            p->high = (vec){most(p->high.x, at.x), most(p->high.y, at.y), most(p->high.z, at.z)};
        }
}

void add_median_fin(solid* s, const double (*outline)[2], int n, double z0, double half0, double z1, double half1,
                    double fillet) {
    part* p = new_part(s, PART_PLATE, fillet);
    plate* q = &p->of.plate;
    q->origin = (vec){0, 0, 0}, q->a = (vec){1, 0, 0}, q->b = (vec){0, 0, 1}, q->normal = (vec){0, 1, 0};
    q->bend = 0.0, q->b0 = z0, q->b1 = z1, q->half0 = half0, q->half1 = half1;
    finish_plate(p, outline, n, s->thinnest);
}

void add_fin(solid* s, const double (*outline)[2], int n, const fin_frame* f, double fillet) {
    part* p = new_part(s, PART_PLATE, fillet);
    plate* q = &p->of.plate;
    q->origin = f->origin;
    q->a = unit(f->chord);
    q->b = unit(minus(f->span, scaled(q->a, dot(f->span, q->a))));
    q->normal =
        (vec){q->a.y * q->b.z - q->a.z * q->b.y, q->a.z * q->b.x - q->a.x * q->b.z, q->a.x * q->b.y - q->a.y * q->b.x};
    q->bend = f->bend, q->b0 = 0.0, q->b1 = f->length, q->half0 = f->half0, q->half1 = f->half1;
    finish_plate(p, outline, n, s->thinnest);
}

void add_ball(solid* s, vec centre, vec radii, double fillet) {
    part* p = new_part(s, PART_BALL, fillet);
    p->of.ball.centre = centre, p->of.ball.radii = radii;
    p->low = minus(centre, radii);
    p->high = (vec){centre.x + radii.x, centre.y + radii.y, centre.z + radii.z};
}

typedef struct {
    double centre, half, mid, up, down;
} section;

static section section_at(const loft* l, double s) {
    section q;
    double value[5];
    int k = 0;
    while (k + 2 < l->rows && s > l->s[k + 1]) ++k;
    for (int c = 0; c < 5; ++c) value[c] = hermite(l->s, l->value[c], l->slope[c], k, s);
    q.centre = value[0], q.mid = value[2];
    q.half = sqrt(most(value[1], 1e-8)), q.up = sqrt(most(value[3], 1e-8)), q.down = sqrt(most(value[4], 1e-8));
    return q;
}

/* The point's size relative to the section: the section is where it is 1 (a squircle of Fernandez Guasti 1992). */
static double relative_size(const section* q, double squareness, double u, double v) {
    const double a = (u - q->centre) / q->half, b = (v - q->mid) / (v > q->mid ? q->up : q->down);
    const double sum = a * a + b * b, product = squareness * a * a * b * b;
    return sqrt(0.5 * (sum + sqrt(most(sum * sum - 4 * product, 0.0))));
}

static double loft_distance(const loft* l, vec p) {
    const double s = l->axis == 0 ? p.x : p.y, u = l->axis == 0 ? p.y : p.z, v = l->axis == 0 ? p.z : p.x;
    const double first = l->s[0], last = l->s[l->rows - 1];
    const double at = least(most(s, first), last), beyond = s < first ? first - s : s > last ? s - last : 0.0;
    const double e = at + 1e-5 > last ? -1e-5 : 1e-5;
    const section here = section_at(l, at), near = section_at(l, at + e);
    const double size = relative_size(&here, l->squareness, u, v);
    const double gs = (relative_size(&near, l->squareness, u, v) - size) / e;
    const double gu = (relative_size(&here, l->squareness, u + 1e-5, v) - size) / 1e-5;
    const double gv = (relative_size(&here, l->squareness, u, v + 1e-5) - size) / 1e-5;
    const double across = sqrt((u - here.centre) * (u - here.centre) + (v - here.mid) * (v - here.mid));
    /* First order says little beside a tip, where the section changes fast: the way to the section bounds it there. */
    const double d =
        most((size - 1) / sqrt(gs * gs + gu * gu + gv * gv + 1e-12), size > 1 ? 0.6 * across * (1 - 1 / size) : -1e9);
    if (beyond > 0.0) return sqrt(beyond * beyond + most(d, 0.0) * most(d, 0.0));
    return most(d, most(first - s, s - last));
}

/* Signed distance of a polygon: the nearest edge, and the parity of edges crossed by a ray. */
static double outline_distance(const plate* q, double a, double b) {
    double nearest = 1e9;
    int inside = 0;
    for (int k = 0, before = q->corners - 1; k < q->corners; before = k++) {
        const double *p = q->outline[k], *o = q->outline[before];
        const double ea = o[0] - p[0], eb = o[1] - p[1], wa = a - p[0], wb = b - p[1];
        const double t = least(most((wa * ea + wb * eb) / (ea * ea + eb * eb + 1e-30), 0.0), 1.0);
        const double da = wa - t * ea, db = wb - t * eb;
        nearest = least(nearest, da * da + db * db);
        if ((p[1] > b) != (o[1] > b) && a < p[0] + (b - p[1]) * ea / eb) inside = !inside;
    }
    return inside ? -sqrt(nearest) : sqrt(nearest);
}

static double plate_distance(const plate* q, vec p) {
    const vec w = minus(p, q->origin);
    const double a = dot(w, q->a), b = dot(w, q->b);
    const double t = least(most((b - q->b0) / (q->b1 - q->b0), 0.0), 1.0);
    const double half = q->half0 + t * (q->half1 - q->half0);
    const double rise = dot(w, q->normal) - q->bend * b * b, tilt = 2 * q->bend * b;
    const double n = rise / sqrt(1 + tilt * tilt);
    const double edge = most(outline_distance(q, a, b) + half, 0.0);
    return sqrt(edge * edge + n * n) - half;
}

static double ball_distance(const ball* q, vec p) {
    const vec w = minus(p, q->centre);
    const vec a = {w.x / q->radii.x, w.y / q->radii.y, w.z / q->radii.z};
    const vec b = {a.x / q->radii.x, a.y / q->radii.y, a.z / q->radii.z};
    const double size = sqrt(dot(a, a));
    return size * (size - 1) / (sqrt(dot(b, b)) + 1e-9);
}

static double part_distance(const part* q, vec p) {
    const vec out = {most(most(q->low.x - p.x, p.x - q->high.x), 0), most(most(q->low.y - p.y, p.y - q->high.y), 0),
                     most(most(q->low.z - p.z, p.z - q->high.z), 0)};
    const double away = sqrt(dot(out, out));
    if (away > FAR) return away;
    return q->kind == PART_LOFT    ? loft_distance(&q->of.loft, p)
           : q->kind == PART_PLATE ? plate_distance(&q->of.plate, p)
                                   : ball_distance(&q->of.ball, p);
}

double solid_distance(const solid* s, vec p) {
    double d = part_distance(&s->part[0], p);
    for (int k = 1; k < s->parts; ++k) {
        const double e = part_distance(&s->part[k], p), r = s->part[k].fillet;
        const double overlap = r > 0.0 ? most(r - (d < e ? e - d : d - e), 0.0) / r : 0.0;
        d = least(d, e) - 0.25 * r * overlap * overlap;
    }
    return d;
}
