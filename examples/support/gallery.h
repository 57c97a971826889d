/* SPDX-License-Identifier: MIT
 * Designs side by side on one page, seen from above and ahead of the side: polygons for gnuplot, already projected,
 * sorted from back to front, and shaded. */
#ifndef DQA_EXAMPLES_GALLERY_H
#define DQA_EXAMPLES_GALLERY_H

#include <stdint.h>
#include <stdio.h>

typedef struct gallery_polygon {
    double corners[4][2]; /* on the page; a triangle repeats its last */
    double depth;         /* towards the viewer */
    uint32_t colour;      /* 0xAARRGGBB, AA: how much shows through */
} gallery_polygon;

typedef struct gallery {
    gallery_polygon* polygons;
    int64_t n, capacity;
} gallery;

void gallery_free(gallery* g);
/* Adds what the viewer sees of a closed surface, vertices [n_vertices][3], with its origin at `place` [2] of the page.
 * DONE or FAILED (said). */
int gallery_add_surface(gallery* g, const double* vertices, int64_t n_vertices, const int32_t* triangles,
                        int64_t n_triangles, const double* place, uint32_t colour);
/* Adds a flat quadrangle with corners [4][3] in the order around it, if it faces the viewer. */
int gallery_add_face(gallery* g, const double corners[4][3], const double* place, uint32_t colour);
/* Writes folder/name, as corners "x y colour" for `splot ... with pm3d`. DONE or FAILED (said). */
int gallery_write(gallery* g, const char* folder, const char* name);

#endif
