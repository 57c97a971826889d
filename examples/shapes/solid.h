/* SPDX-License-Identifier: MIT
 * Solids as signed distances: lofted bodies, fins cut from plates, and ellipsoids, joined with fillets. Every solid
 * mirrors across y = 0 and is asked for points with y >= 0 only. Lengths in body lengths; negative inside.
 *
 * Only + - * / and sqrt are used here and in all that follows from it, which IEEE 754 rounds the same everywhere: the
 * meshes come out the same, byte for byte, on every machine. */
#ifndef DQA_SHAPES_SOLID_H
#define DQA_SHAPES_SOLID_H

#define SOLID_MAX_PARTS 24
#define LOFT_MAX_ROWS 24
#define PLATE_MAX_CORNERS 128

typedef struct {
    double x, y, z;
} vec;

/* Sections along an axis s, superellipses in (u, v): u within its centre +- half, v between low and high, widest at
 * mid. Extents are interpolated so that an end of zero extent is round. */
typedef struct {
    int axis; /* 0: (s, u, v) = (x, y, z); 1: (y, z, x) */
    int rows;
    double squareness; /* of the sections: 0 ellipse, 1 rectangle; negative: pinched */
    double s[LOFT_MAX_ROWS];
    double value[5][LOFT_MAX_ROWS],
        slope[5][LOFT_MAX_ROWS]; /* u centre, half^2, v mid, (high - mid)^2, (mid - low)^2 */
} loft;

/* A plate with a curved outline in the plane of the unit vectors a and b, rounded edges, and a thickness that changes
 * along b. The plate rises out of that plane by bend * b^2. */
typedef struct {
    vec origin, a, b, normal;
    double bend, b0, b1, half0, half1; /* half thickness at b0 and b1 */
    int corners;
    double outline[PLATE_MAX_CORNERS][2];
} plate;

typedef struct {
    vec centre, radii;
} ball;

typedef enum { PART_LOFT, PART_PLATE, PART_BALL } part_kind;

typedef struct {
    part_kind kind;
    double fillet; /* radius scale of the blend with the parts before it; 0: sharp */
    vec low, high; /* bounds */
    union {
        loft loft;
        plate plate;
        ball ball;
    } of;
} part;

typedef struct {
    double thinnest; /* least half thickness of plates */
    int parts;
    part part[SOLID_MAX_PARTS];
} solid;

#define ROWS(table) (table), (int)(sizeof(table) / sizeof((table)[0]))

/* Body. Rows: x, top, z of the greatest width, bottom, half width; in rising or falling x. */
void add_body(solid* s, const double (*rows)[5], int n, double squareness, double fillet);
/* Wing at y >= 0 and its mirror image. Rows: y, x of the leading edge, of the thickest place, of the trailing edge, z,
 * half thickness. */
void add_wing(solid* s, const double (*rows)[6], int n, double squareness, double fillet);
/* Fin in the plane y = 0, its outline drawn from the side. Points: x, z; a point given twice is a corner. The half
 * thickness goes from half0 at z0 to half1 at z1. */
void add_median_fin(solid* s, const double (*outline)[2], int n, double z0, double half0, double z1, double half1,
                    double fillet);
/* Fin at y >= 0 and its mirror image, drawn in its own plane. Points: along `chord`, along `span` (made orthogonal to
 * it), from the origin. The half thickness goes from half0 at the root to half1 at `length` along the span. */
typedef struct {
    vec origin, chord, span;
    double bend, length, half0, half1;
} fin_frame;
void add_fin(solid* s, const double (*outline)[2], int n, const fin_frame* frame, double fillet);
void add_ball(solid* s, vec centre, vec radii, double fillet);

double solid_distance(const solid* s, vec p);

#endif
