/* SPDX-License-Identifier: MIT
 * Eels are 15 to 20 times as long as thick, with a dorsal fin that begins behind the head and runs around the tail into
 * the anal fin. These have a body of 1/14 and, with that fin, are 0.11 across their wide axis: 4 cells of 1/36 length,
 * as a box of 40 x 8 x 8 cells allows. Flag-like: the fin stands upright; pancake-like: it lies flat.
 * The muscle lies in the front of the trunk: what is behind it follows with a lag, as a wave that runs towards the tail,
 * and pushes the eel ahead. In the rear (at -0.15) it leaves the head to follow, and the eel swims tail first: under a
 * sine of full amplitude and 2.5 Hz by 0.18 m in 1.7 s, against 0.14 m ahead with this one. */
#include <string.h>

#include "animals.h"

static void eel(solid* s, int vertical) {
    /* x, half extent along the wide axis, along the narrow axis */
    static const double body[][3] = {{0.500, 0.006, 0.007},  {0.493, 0.014, 0.015},  {0.470, 0.024, 0.022},
                                     {0.430, 0.033, 0.028},  {0.380, 0.037, 0.030},  {0.300, 0.037, 0.030},
                                     {0.200, 0.037, 0.029},  {0.000, 0.037, 0.029},  {-0.150, 0.034, 0.027},
                                     {-0.300, 0.026, 0.023}, {-0.420, 0.017, 0.019}, {-0.470, 0.010, 0.012}};
    static const double fin[][3] = {{0.280, 0.024, 0.020},  {0.250, 0.034, 0.020},  {0.190, 0.046, 0.020},
                                    {0.110, 0.054, 0.020},  {0.000, 0.056, 0.020},  {-0.180, 0.054, 0.020},
                                    {-0.320, 0.048, 0.019}, {-0.420, 0.036, 0.018}, {-0.470, 0.024, 0.016},
                                    {-0.493, 0.013, 0.012}, {-0.500, 0.006, 0.009}};
    enum { BODY = sizeof(body) / sizeof(body[0]), FIN = sizeof(fin) / sizeof(fin[0]) };
    double rows[BODY + FIN][5];
    for (int i = 0; i < BODY + FIN; ++i) {
        const double* from = i < BODY ? body[i] : fin[i - BODY];
        const double up = from[vertical ? 1 : 2], across = from[vertical ? 2 : 1];
        const double row[5] = {from[0], up, 0.0, -up, across};
        memcpy(rows[i], row, sizeof(row));
    }
    add_body(s, (const double(*)[5])rows, BODY, 0.23, 0.0);
    add_body(s, (const double(*)[5])(rows + BODY), FIN, 0.85, 0.02);
}

static void eel_vertical(solid* s) {
    eel(s, 1);
}
static void eel_horizontal(solid* s) {
    eel(s, 0);
}

const animal eels[2] = {{"eel_vertical",
                         "eel with its fin upright",
                         eel_vertical,
                         35,
                         2400,
                         1,
                         {{0, {0.15, 0, 0}, {0.25, 0.028, 0.054}, {0, 0, 0}}}},
                        {"eel_horizontal",
                         "eel with its fin lying flat",
                         eel_horizontal,
                         35,
                         2400,
                         1,
                         {{0, {0.15, 0, 0}, {0.25, 0.054, 0.028}, {0, 0, 0}}}}};
