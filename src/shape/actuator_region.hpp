// SPDX-License-Identifier: MIT
// Where a design's actuator acts: membership of points in its box, with smooth ramps; and how a fin's box divides into
// fibre groups: layers across its thickness (its third axis) times four bands of diagonal fibres, side by side. The
// shares of the groups sum to 1 at every point.
//
// A fin's axes keep their roles by identity, never by size: the first points ahead, the second towards +y, the third
// across its thickness. Fibres run back and outwards at 45 degrees to both edges of the fin: along -e0 + e1 in the left
// half and along its mirror image -e0 - e1 in the right one; bands follow one another across the fibres, from back
// inside to ahead outside, each a quarter of the box's width in that direction.
#pragma once

#include "shape/actuator.hpp"

namespace dqa {

class ActuatorRegion {
public:
    // Each boundary is a ramp of width `ramp` (m) centred on it.
    ActuatorRegion(const ActuatorPoint& point, double ramp) : point_(point), ramp_(ramp) {}

    double membership(const Vec3& x) const;
    // Adds membership_bar * d(membership)/d(mean, half, normal) to bar.
    void membership_pullback(const Vec3& x, double membership_bar, ActuatorBar& bar) const;

    // Share in [0, 1] of one group of a fin's half.
    double group_share(const Vec3& x, ActuatorHalf half, int layers, int layer, int band) const;
    void group_share_pullback(const Vec3& x, ActuatorHalf half, int layers, int layer, int band, double share_bar,
                              ActuatorBar& bar) const;

private:
    const ActuatorPoint& point_;
    double ramp_;
};

// Unit vector along the fibres of a fin's half, and its pullback: adds to bar.edge.
Vec3 fibre_direction(const ActuatorPoint& point, ActuatorHalf half);
void fibre_direction_pullback(const ActuatorPoint& point, ActuatorHalf half, const Vec3& direction_bar,
                              ActuatorBar& bar);

}  // namespace dqa
