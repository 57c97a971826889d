/* SPDX-License-Identifier: MIT
 * Colours of the animals in the contact sheet; the meshes have none. */
#ifndef DQA_SHAPES_PAINT_H
#define DQA_SHAPES_PAINT_H

typedef struct {
    double r, g, b; /* in [0, 1] */
} colour;

/* Colour of the point p of a shape's surface with outward normal n. */
typedef colour (*paint)(const double p[3], const double n[3]);

colour paint_eel(const double p[3], const double n[3]);
colour paint_clownfish(const double p[3], const double n[3]);
colour paint_tuna(const double p[3], const double n[3]);
colour paint_manta(const double p[3], const double n[3]);
colour paint_stingray(const double p[3], const double n[3]);
colour paint_great_white(const double p[3], const double n[3]);
colour paint_hammerhead(const double p[3], const double n[3]);
colour paint_thresher(const double p[3], const double n[3]);
colour paint_whale_shark(const double p[3], const double n[3]);
colour paint_common(const double p[3], const double n[3]);
colour paint_comet(const double p[3], const double n[3]);
colour paint_fantail(const double p[3], const double n[3]);
colour paint_ryukin(const double p[3], const double n[3]);
colour paint_oranda(const double p[3], const double n[3]);
colour paint_ranchu(const double p[3], const double n[3]);
colour paint_telescope(const double p[3], const double n[3]);
colour paint_orca(const double p[3], const double n[3]);
colour paint_submarine(const double p[3], const double n[3]);

#endif
