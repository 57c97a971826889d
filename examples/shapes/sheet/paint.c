/* SPDX-License-Identifier: MIT
 * Patterns as functions of the place on the body: countershading, bands, patches, eyes, gills. */
#include "paint.h"

#include <math.h>

static colour rgb(int hex) {
    const colour c = {(hex >> 16 & 255) / 255.0, (hex >> 8 & 255) / 255.0, (hex & 255) / 255.0};
    return c;
}

/* From 0 to 1 as x goes from a to b, smoothly. */
static double step(double a, double b, double x) {
    const double t = fmin(fmax((x - a) / (b - a), 0.0), 1.0);
    return t * t * (3 - 2 * t);
}

static colour mix(colour a, colour b, double t) {
    const colour c = {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
    return c;
}

/* 1 inside an ellipse of the side view, 0 outside. */
static double patch(const double p[3], double x, double z, double rx, double rz) {
    const double a = (p[0] - x) / rx, b = (p[2] - z) / rz;
    return 1 - step(0.85, 1.1, sqrt(a * a + b * b));
}

static colour with_eye(colour c, const double p[3], double x, double z, double radius, int iris) {
    const double d = sqrt((p[0] - x) * (p[0] - x) + (p[2] - z) * (p[2] - z)) / radius;
    if (d < 0.6) return rgb(0x0a0a0c);
    return d < 1 ? rgb(iris) : c;
}

/* Five slits that lean back, between x1 and x0. */
static colour with_gills(colour c, const double p[3], double x0, double x1, double low, double high) {
    for (int k = 0; k < 5; ++k) {
        const double x = x0 + (x1 - x0) * k / 4.0 - 0.15 * (p[2] - low);
        if (fabs(p[0] - x) < 0.0026 && p[2] > low && p[2] < high && fabs(p[1]) > 0.02)
            return mix(c, rgb(0x101418), 0.6);
    }
    return c;
}

colour paint_eel(const double p[3], const double n[3]) {
    colour c = mix(rgb(0xd9c98a), rgb(0x5d6138), step(-0.5, 0.35, n[2]));
    const double wide = fmax(fabs(p[1]), fabs(p[2])),
                 spots = sin(70 * p[0] + 2 * sin(90 * p[1])) * sin(90 * p[2] + 60 * p[1]);
    c = mix(c, rgb(0x3d3f22), 0.7 * step(0.25, 0.5, spots));
    if (wide > 0.0385 && p[0] < 0.27) c = mix(c, rgb(0xe9dfae), 0.85);
    return with_eye(c, p, 0.466, 0.009, 0.0085, 0xe8d890);
}

/* White bands bordered in black. */
static colour band(colour c, double x, double middle, double half) {
    const double d = fabs(x - middle) - half;
    if (d < 0) return rgb(0xfbfbf7);
    return d < 0.016 ? rgb(0x181412) : c;
}

colour paint_clownfish(const double p[3], const double n[3]) {
    const double up = p[2];
    colour c = rgb(0xf2741c);
    (void)n;
    if (up > 0.226 || up < -0.222 || p[0] < -0.478 || (p[0] < -0.38 && fabs(up) > 0.108)) c = rgb(0x1c1614);
    if (fabs(p[1]) < 0.118) {
        c = band(c, p[0], 0.265 - 0.25 * up * up, 0.036);
        if (up < 0.23 && up > -0.22) c = band(c, p[0], -0.010 + 0.055 * (1 - step(0.0, 0.16, fabs(up))), 0.044);
        c = band(c, p[0], -0.290, 0.026);
    } else if (fabs(p[1]) > 0.155) {
        c = rgb(0x1c1614);
    }
    return with_eye(c, p, 0.392, 0.045, 0.024, 0xe8b070);
}

colour paint_tuna(const double p[3], const double n[3]) {
    colour c = mix(rgb(0xdfe5ea), rgb(0x1c3a63), step(0.005, 0.06, p[2] + 0.02 * n[2]));
    if (p[0] < -0.04 && p[0] > -0.20 && fabs(p[2]) > 0.122) c = rgb(0xe9b92e);
    if (p[0] < -0.36) c = rgb(0x2a3f5c);
    return with_eye(c, p, 0.432, 0.010, 0.017, 0xf2efdc);
}

colour paint_manta(const double p[3], const double n[3]) {
    const double x = p[0], y = fabs(p[1]);
    colour c = rgb(0x23272e);
    if (n[2] > 0) { /* white shoulders, hooked like two facing sevens */
        const double a = (x - 0.245) / 0.040, b = (y - 0.150) / 0.105;
        const double front = 0.262 - 0.35 * (y - 0.1);
        if (a * a + b * b < 1 && x < front) c = rgb(0xe9edf0);
    } else if (x < 0.37) {
        c = mix(rgb(0xf1f3f4), rgb(0x50565e), step(-0.02, 0.10, y - 0.42 - 0.6 * x) * 0.8);
    }
    if (x > 0.40 && y < 0.095 && fabs(p[2]) < 0.020) c = rgb(0x0b0c0f); /* the mouth */
    if (fabs(x - 0.345) < 0.012 && fabs(p[2] - 0.004) < 0.010 && y > 0.10 && y < 0.16) c = rgb(0xd8d8d0);
    return c;
}

colour paint_stingray(const double p[3], const double n[3]) {
    const double y = fabs(p[1]), x = p[0];
    colour c = rgb(0x8d7550);
    const double spots = sin(61 * x + 2 * sin(37 * y)) * sin(67 * y + 2 * cos(41 * x));
    c = mix(c, rgb(0x6a5538), step(0.35, 0.6, spots) * 0.75);
    c = mix(c, rgb(0x5d4a33), step(0.02, -0.08, x) * 0.7);
    if (n[2] < -0.15 && x > 0.0) c = rgb(0xf1ede2);
    if (hypot(x - 0.352, p[2] - 0.068) < 0.013 && y > 0.050) c = rgb(0x14110c);
    return c;
}

static colour shark(const double p[3], int back, int belly, double line) {
    return mix(rgb(belly), rgb(back), step(line - 0.010, line + 0.010, p[2]));
}

colour paint_great_white(const double p[3], const double n[3]) {
    colour c = shark(p, 0x6b7681, 0xf4f5f3, -0.012 + 0.012 * sin(22 * p[0]));
    if (fabs(p[1]) > 0.085) c = n[2] > 0 ? rgb(0x66717c) : rgb(0xe8eaea);
    if (p[0] < -0.34) c = rgb(0x66717c);
    c = with_gills(c, p, 0.300, 0.246, -0.060, 0.030);
    if (p[0] > 0.375 && p[0] < 0.445 && fabs(p[2] + 0.026 + 0.22 * (0.445 - p[0])) < 0.0032) c = rgb(0x2c1d20);
    return with_eye(c, p, 0.432, 0.016, 0.011, 0x0a0a0c);
}

colour paint_hammerhead(const double p[3], const double n[3]) {
    colour c = shark(p, 0x857d68, 0xf3f1ea, -0.014);
    if (p[0] > 0.39 || fabs(p[1]) > 0.07) c = n[2] > -0.2 ? rgb(0x857d68) : rgb(0xf3f1ea);
    if (p[0] < -0.22) c = rgb(0x7d7562);
    c = with_gills(c, p, 0.305, 0.250, -0.042, 0.020);
    if (fabs(p[1]) > 0.126 && fabs(p[0] - 0.448) < 0.015 && p[2] > -0.012 && p[2] < 0.020) c = rgb(0x0a0a0c);
    return c;
}

colour paint_thresher(const double p[3], const double n[3]) {
    colour c = shark(p, 0x47506f, 0xf1f2f2, -0.020);
    if (fabs(p[1]) > 0.065) c = n[2] > 0 ? rgb(0x424b69) : rgb(0xd5d8de);
    if (p[0] < -0.03) c = rgb(0x414a66);
    c = with_gills(c, p, 0.345, 0.310, -0.045, 0.015);
    return with_eye(c, p, 0.452, 0.012, 0.0145, 0x0a0a0c);
}

colour paint_whale_shark(const double p[3], const double n[3]) {
    const double along = p[0], around = atan2(p[2] + 0.005, fabs(p[1]) + 0.01);
    colour c = rgb(0x4a5d70);
    const int row = (int)floor(around * 4.6 + 100), column = (int)floor(along * 27 + 100 + 0.5 * (row & 1));
    const double a = (along * 27 + 100 + 0.5 * (row & 1) - column - 0.5) / 27,
                 b = (around * 4.6 + 100 - row - 0.5) / 55;
    const double size = along > 0.34 ? 0.0062 : 0.0086;
    if (sqrt(a * a + b * b) < size && p[0] > -0.36) c = rgb(0xeef2ee);
    if (along < 0.33 && along > -0.3 && fabs(a) > 0.0170 && fabs(p[1]) < 0.12) c = mix(c, rgb(0xd8e0e0), 0.55);
    if (p[2] < -0.035 && n[2] < 0.1 && fabs(p[1]) < 0.105 && p[0] > -0.3) c = rgb(0xf2f1ea);
    c = with_gills(c, p, 0.320, 0.250, -0.030, 0.030);
    if (p[0] > 0.484 && fabs(p[2]) < 0.006) c = rgb(0x10161c); /* the mouth, at the very front */
    return with_eye(c, p, 0.455, -0.006, 0.0085, 0x0a0a0c);
}

/* Rays of a fin, as faint stripes along lines from (x, z). */
static colour rays(colour c, const double p[3], double x, double z, double strength) {
    const double angle = atan2(p[2] - z, p[0] - x);
    return mix(c, rgb(0xfff4e0), strength * (0.5 + 0.5 * sin(60 * angle)));
}

static colour scales(colour c, const double p[3], int light, double strength) {
    const double a = sin(95 * p[0] + 60 * p[2]) * sin(95 * p[0] - 60 * p[2]);
    return mix(c, rgb(light), strength * step(0.2, 0.9, a));
}

colour paint_common(const double p[3], const double n[3]) {
    colour c = mix(rgb(0xffb347), rgb(0xf06a12), step(-0.10, 0.03, p[2]));
    (void)n;
    c = p[0] > -0.27 && fabs(p[2]) < 0.15 ? scales(c, p, 0xffc766, p[0] < 0.33 ? 0.35 : 0) : c;
    if (p[0] < -0.285) c = rays(c, p, -0.2, 0, 0.3);
    if (p[2] > 0.158) c = rays(c, p, 0.05, 0.0, 0.3);
    return with_eye(c, p, 0.425, 0.026, 0.020, 0xffe9b0);
}

colour paint_comet(const double p[3], const double n[3]) {
    colour c = rgb(0xe8431c);
    (void)n;
    /* red and white: "sarasa" */
    if (p[2] < -0.035 + 0.02 * sin(30 * p[0]) || (p[2] < 0.062 && fabs(p[0] - 0.03 - 0.4 * p[2]) < 0.045))
        c = rgb(0xfbf3ea);
    if (p[0] < -0.12) c = rays(mix(rgb(0xe8431c), rgb(0xfbf3ea), step(-0.26, -0.44, p[0])), p, -0.02, 0, 0.2);
    if (p[2] > 0.11) c = rays(rgb(0xe8431c), p, 0.1, 0.0, 0.3);
    c = p[0] > -0.1 && p[0] < 0.36 ? scales(c, p, 0xffb090, 0.2) : c;
    return with_eye(c, p, 0.445, 0.022, 0.0155, 0xffe9b0);
}

colour paint_fantail(const double p[3], const double n[3]) {
    colour c = mix(rgb(0xffc45a), rgb(0xf58a1f), step(-0.16, 0.06, p[2]));
    (void)n;
    if (p[0] < -0.22) c = rays(mix(c, rgb(0xffe2a8), step(-0.26, -0.48, p[0])), p, -0.12, 0, 0.3);
    if (p[2] > 0.21) c = rays(c, p, 0.0, 0.0, 0.35);
    c = p[0] > -0.2 && p[0] < 0.34 && fabs(p[2]) < 0.20 ? scales(c, p, 0xffdc92, 0.35) : c;
    return with_eye(c, p, 0.428, 0.020, 0.021, 0xfff2cc);
}

colour paint_ryukin(const double p[3], const double n[3]) {
    const double blot = sin(9 * p[0] + 1.2) + sin(11 * p[2] + 6 * p[0] - 0.4) + 0.8 * sin(5 * p[0] - 13 * p[2]);
    colour c = mix(rgb(0xfaf4ec), rgb(0xdc2f1e), step(-0.12, 0.12, blot + 0.15));
    (void)n;
    if (p[0] < -0.14) c = rays(mix(c, rgb(0xfdf6ee), step(-0.15, -0.42, p[0]) * 0.8), p, -0.04, 0, 0.3);
    if (p[0] > 0.40) c = rgb(0xdc2f1e);
    c = p[0] > -0.1 && p[0] < 0.34 ? scales(c, p, 0xfff0e4, 0.25) : c;
    return with_eye(c, p, 0.438, -0.018, 0.019, 0xfff2cc);
}

/* White with a red cap: "tancho". */
colour paint_oranda(const double p[3], const double n[3]) {
    colour c = rgb(0xf7f2ea);
    (void)n;
    if (p[0] > 0.305 && p[2] > -0.022 + 0.9 * (0.33 - fmin(p[0], 0.33))) c = rgb(0xd9281a);
    if (p[0] < -0.10) c = rays(c, p, -0.02, 0, 0.2);
    c = p[0] > -0.1 && p[0] < 0.27 ? scales(c, p, 0xe9d9c4, 0.4) : c;
    if (p[0] < -0.13 || p[2] > 0.20) c = mix(c, rgb(0xe9d7c6), 0.35 + 0.35 * sin(90 * atan2(p[2], p[0] + 0.02)));
    return with_eye(c, p, 0.412, -0.046, 0.018, 0xfff2cc);
}

colour paint_ranchu(const double p[3], const double n[3]) {
    colour c = mix(rgb(0xffa640), rgb(0xe9581a), step(-0.14, 0.02, p[2]));
    (void)n;
    if (p[0] > 0.30) c = mix(c, rgb(0xd93a10), 0.6);
    c = p[0] > -0.30 && p[0] < 0.26 ? scales(c, p, 0xffc880, 0.35) : c;
    if (p[0] < -0.36) c = rays(rgb(0xf58a3a), p, -0.28, 0, 0.4);
    return with_eye(c, p, 0.412, -0.040, 0.018, 0xfff2cc);
}

colour paint_telescope(const double p[3], const double n[3]) {
    colour c = mix(rgb(0x55483e), rgb(0x26242a), step(-0.16, 0.0, p[2]));
    (void)n;
    c = p[0] > -0.1 && p[0] < 0.33 && fabs(p[2]) < 0.19 ? scales(c, p, 0x6f665c, 0.4) : c;
    if (p[0] < -0.13) c = rays(c, p, -0.04, 0, 0.15);
    if (fabs(p[1]) > 0.128 && p[0] > 0.34) {
        const double d = hypot(p[0] - 0.422, p[2] - 0.034);
        c = d < 0.020 ? rgb(0x050506) : d < 0.034 ? rgb(0xc9a24a) : rgb(0x1d1b20);
    }
    return c;
}

colour paint_orca(const double p[3], const double n[3]) {
    const double x = p[0], z = p[2], y = fabs(p[1]);
    colour c = rgb(0x1b1e24);
    double belly = -0.058 + 0.03 * step(0.30, 0.45, x);
    if (x < 0.34 && x > 0.20) belly -= 0.035;
    if (y < 0.11 && x > -0.30 && z < belly) c = rgb(0xf6f7f7);
    /* The lobe that rises on the flank, and the saddle. */
    if (y < 0.11 && z < -0.050 + 0.055 * step(-0.04, -0.17, x) * step(-0.245, -0.20, x) && x < -0.04 && x > -0.245)
        c = rgb(0xf6f7f7);
    if (y > 0.020) c = mix(c, rgb(0xf6f7f7), patch(p, 0.372, 0.034, 0.050, 0.019));
    c = mix(c, rgb(0x858b93), patch(p, -0.070, 0.100, 0.070, 0.030) * (z < 0.112 ? 1 : 0));
    if (x < -0.40 && n[2] < -0.3) c = rgb(0xe9ebec);
    if (hypot(x - 0.432, z - 0.008) < 0.007) c = rgb(0x000000);
    return c;
}

colour paint_submarine(const double p[3], const double n[3]) {
    colour c = p[2] < -0.014 ? rgb(0x7c3a33) : rgb(0x4c535b);
    (void)n;
    if (fabs(p[2] + 0.014) < 0.0022 && p[0] > -0.4) c = rgb(0xe8e8e4);
    if (p[0] < -0.452 && hypot(p[1], p[2]) > 0.010) c = rgb(0xb98a3c);
    if (p[2] > 0.062 && p[0] > 0.12 && p[0] < 0.26) c = rgb(0x434a52);
    if (fabs(p[1]) > 0.017 && p[2] > 0.120 && p[2] < 0.132 && p[0] > 0.232 && p[0] < 0.244) c = rgb(0xd8e4ea);
    return c;
}
