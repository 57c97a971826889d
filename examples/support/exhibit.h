/* SPDX-License-Identifier: MIT
 * A design to look at: what is known of it as a set of cells, and its body and muscles as polygons of a gallery. */
#ifndef DQA_EXAMPLES_EXHIBIT_H
#define DQA_EXAMPLES_EXHIBIT_H

#include "gallery.h"
#include "scene.h"

typedef struct exhibit {
    double weights[3];
    double volume;  /* m^3 */
    double largest; /* share of its largest part, of the solid: what is more than half full */
    double largest_simulated;
    double overlap; /* with the base that it should give back; negative: it is none */
    double seconds;
    int64_t body_cells, parts, muscle_cells;
    int64_t simulated_cells, parts_simulated; /* of all that is simulated: the solid and the soft cells around it */
} exhibit;

/* All of the following concern the current design of the scene's simulator, which has the weights of the exhibit, three
 * bases and a box of [3] cells. DONE, FAILED (said) or INTERRUPTED. */
int exhibit_measure(exhibit* out, const scene* s, const int32_t cells[3]);
/* Draws the surface at `place` [2] into `bodies`, and as a veil into `veils`; writes it to folder/stl. */
int exhibit_draw_body(const scene* s, const double* place, uint32_t colour, gallery* bodies, gallery* veils,
                      const char* folder, const char* stl);
/* Draws the cells that are muscle, tail red and fins green (left) and blue (right), and counts them. */
int exhibit_draw_muscles(exhibit* of, const scene* s, const double* place, gallery* muscles);

#endif
