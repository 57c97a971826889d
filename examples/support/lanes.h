/* SPDX-License-Identifier: MIT
 * A swimmer at several times as shaded polygons for gnuplot: one lane a time, as swimmers in a pool. */
#ifndef DQA_EXAMPLES_LANES_H
#define DQA_EXAMPLES_LANES_H

#include "motion.h"

#define LANES 4

/* Where gnuplot looks from (`set view`): the shading and the choice of visible triangles need to know. */
#define LANES_VIEW_X 54.0 /* degrees from the vertical */
#define LANES_VIEW_Z 12.0 /* degrees about it */

/* The common frame of all swimmers that are to be drawn at one scale. */
typedef struct lanes_box {
    double x_least, x_most, half_width, floor, top; /* m; half_width of the widest swimmer about y = 0 */
    double spacing;                                 /* m between lanes */
    double left, right, below, above; /* m: what the view covers, from the projection of the box's centre */
} lanes_box;

/* Frame shown in a lane: the first, the last, and evenly between. */
int64_t lanes_frame(const motion* m, int lane);
/* Lateral position of a lane's middle, m; the first lane lies farthest from the viewer. */
double lanes_y(const lanes_box* box, int lane);
/* Lateral distance of the outermost swimmers' outer sides from the middle, m. */
double lanes_edge(const lanes_box* box);
/* The box around n motions, with room before and behind the swimmers for the lines on the floor. */
void lanes_measure(lanes_box* box, const motion* const* motions, int n);
/* Foremost point of a frame, m. */
double lanes_nose(const motion* m, int64_t frame);
/* Writes the shadows on the floor to folder/shadow_name and the bodies to folder/name, as corners "x y z colour" for
 * `with pm3d`. `back` is the colour of the upper side, 0xRRGGBB. DONE or FAILED (said). */
int lanes_write(const motion* m, const lanes_box* box, unsigned back, const char* folder, const char* name,
                const char* shadow_name);

#endif
