// SPDX-License-Identifier: MIT
// Muscle regions as Gaussians: interpolation over the bases (the paper's: linear in mean, eigenvalues and Euler
// angles), membership of a point in the region, both with pullbacks; and automatic placement from the geometry.
#pragma once

#include <array>
#include <vector>

#include "grid/box.hpp"

namespace dqa {

enum class ActuatorCategory : int { caudal = 0 };

// Sigma = R^T diag(variance) R, R = Rx(e0) Ry(e1) Rz(e2); metres, radians, box frame.
struct Actuator {
    ActuatorCategory category = ActuatorCategory::caudal;
    Vec3 mean{};
    Vec3 variance{};
    Vec3 euler{};
};

// What the interpolation made of one category: geometry, and the factor by which its muscles are scaled: the share of
// bases that have the category, faded smoothly to zero below 5 %.
struct ActuatorPoint {
    ActuatorCategory category = ActuatorCategory::caudal;
    Vec3 mean{}, variance{}, euler{};
    double share = 0.0, strength = 0.0;
    std::vector<double> weights;  // of each base, renormalised over those that have the category
};

// Per base: NULL if it has no such actuator.
ActuatorPoint interpolate_actuator(const std::vector<const Actuator*>& of_base, const std::vector<double>& weights);
// Adds to weights_bar; `bar` holds cotangents in the fields of the same name (share and weights unused).
void interpolate_actuator_pullback(const std::vector<const Actuator*>& of_base, const ActuatorPoint& point,
                                   const ActuatorPoint& bar, std::vector<double>& weights_bar);

// Membership in [0, 1] of points in the box around the half-peak ellipsoid (semi-axes sqrt(2 ln 2 variance)), with a
// smooth ramp of width `ramp` (m) across each side; and in its left (y > 0) and right halves.
class ActuatorRegion {
public:
    ActuatorRegion(const ActuatorPoint& point, double ramp);
    double membership(const Vec3& x) const;
    // Adds membership_bar * d(membership)/d(mean, variance, euler) to bar.
    void membership_pullback(const Vec3& x, double membership_bar, ActuatorPoint& bar) const;

private:
    Vec3 mean_, variance_, half_;
    double rotation_[9], rotation_d_[3][9];  // R and dR/d(euler)
    double ramp_;
};

// C2 step from 0 at t = 0 to 1 at t = 1, and its derivative.
double smooth_step(double t);
double smooth_step_derivative(double t);

// A caudal muscle from covered fractions: from the peduncle (narrowest section of the rear) to the middle of the body.
Actuator place_caudal(const Box& box, const std::vector<double>& fractions);

}  // namespace dqa
