/* SPDX-License-Identifier: MIT
 * Scripts for gnuplot: a page of panels with curves above and swimmers below. */
#ifndef DQA_EXAMPLES_PLOT_H
#define DQA_EXAMPLES_PLOT_H

#include <stddef.h>
#include <stdio.h>

#include "lanes.h"

#define PLOT_FOLDER "picture" /* the polygons that scripts draw */

/* Text in gnuplot's single quotes, cut after `most` bytes. */
void plot_quoted(FILE* f, const char* text, size_t most);
/* Beginning of the script `script` that draws `picture` of so many pixels. Afterwards it stands in a multiplot. */
void plot_page(FILE* f, const char* picture, const char* script, int width, int height);
/* The look of curves: the tables' separator, axes, colours. */
void plot_lines(FILE* f);
/* Both, for curves and swimmers. */
void plot_head(FILE* f, const char* picture, const char* script);
/* The panel between fractions left and right of the picture's width, in its upper part; its key goes below. */
void plot_panel(FILE* f, const char* title, double left, double right);
/* From here on the script draws swimmers in the box. */
void plot_scenery(FILE* f, const lanes_box* box);
/* One swimmer in its lanes, from PLOT_FOLDER/name.dat and name_shadow.dat; `left`: of its panel, as above. */
void plot_swimmer(FILE* f, const motion* m, const lanes_box* box, const char* what, const char* name, double left);
/* Runs the script in the folder; the picture appears whole or not at all. *drawn is 0 when gnuplot is missing, which is
 * said but is no failure. DONE, FAILED (said) or INTERRUPTED. */
int plot_draw(const char* folder, const char* picture, const char* script, int* drawn);

#endif
