// SPDX-License-Identifier: MIT
// Muscle regions as Gaussians and what the weights make of them: the box of a design's actuator, interpolated over the
// bases linearly (Ma et al. 2021, section 4.2) or as the Bures-Wasserstein barycentre (their future work), with its
// pullback.
//
// The region is the box around the half-peak ellipsoid. With L = sqrt(2 ln 2) Sigma^(1/2) and a reference frame R it is
// the image  mean + L R^T [-1, 1]^3  of the cube around the unit ball: the paper's box wherever R diagonalises Sigma
// (every base, and every linear interpolation), and a smooth function of Sigma and R everywhere else, since no
// eigenvalue is ever sorted. The Bures barycentre interpolates Sigma, and R from the same Euler angles as the paper.
#pragma once

#include <array>
#include <vector>

#include "grid/box.hpp"

namespace dqa {

enum class ActuatorKind : int {
    caudal = 0,  // one antagonistic pair, split at the plane y = 0, fibres along x: one signal
    fins = 1     // lateral fins, left and right sharing their signals: layers x 4 fibre groups each
};
enum class ActuatorHalf : int { whole = 0, left = 1, right = 2 };  // left: y > 0
enum class Interpolation : int { linear = 0, bures = 1 };

constexpr int kMaxCategories = 16;
constexpr int kMaxLayers = 4;
constexpr int kBands = 4;  // fibre groups of a layer

// Sigma = R^T diag(variance) R, R = Rx(e0) Ry(e1) Rz(e2); metres, radians, box frame.
struct Actuator {
    int category = 0;  // 0..15: actuators of different bases interpolate within their category
    ActuatorKind kind = ActuatorKind::caudal;
    ActuatorHalf half = ActuatorHalf::whole;  // of fins: left or right
    int layers = kMaxLayers;                  // of fins, across their thickness
    Vec3 mean{};
    Vec3 variance{};
    Vec3 euler{};
};

// The mirror image across y = 0: (left, right) and the Euler angles (e0, e2) change sign.
Actuator mirrored(const Actuator& actuator);

// What the interpolation made of one actuator: a box with faces normal[k] . (x - mean) = +-half[k] and edges along
// edge[k] (the same unit vectors where the box is rectangular), and the factor by which its muscles are scaled: the
// share of bases that have it, faded smoothly to zero below 5 %.
struct ActuatorPoint {
    Vec3 mean{}, half{};
    std::array<Vec3, 3> normal{}, edge{};
    double share = 0.0, strength = 0.0;
    std::array<double, 9> covariance{};  // row-major
    Vec3 variance{}, euler{};            // along the axes of the reference frame, and that frame
    std::vector<double> weights;         // of each base, renormalised over those that have the actuator
};

// Cotangents of an ActuatorPoint.
struct ActuatorBar {
    Vec3 mean{}, half{};
    std::array<Vec3, 3> normal{}, edge{};
    double strength = 0.0;
};

// Per base: NULL if it has no such actuator.
ActuatorPoint interpolate_actuator(const std::vector<const Actuator*>& of_base, const std::vector<double>& weights,
                                   Interpolation interpolation);
// Adds to weights_bar.
void interpolate_actuator_pullback(const std::vector<const Actuator*>& of_base, const ActuatorPoint& point,
                                   Interpolation interpolation, const ActuatorBar& bar,
                                   std::vector<double>& weights_bar);

// C2 step from 0 at t = 0 to 1 at t = 1, and its derivative.
double smooth_step(double t);
double smooth_step_derivative(double t);

constexpr double kTwoLn2 = 1.3862943611198906;  // semi-axis of the half-peak ellipsoid: sqrt(2 ln 2 variance)

}  // namespace dqa
