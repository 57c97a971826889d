// SPDX-License-Identifier: MIT
#include "water/laws.hpp"

#include <algorithm>
#include <cmath>

#include "grid/error.hpp"

namespace dqa {
namespace {

constexpr double kHalfPi = 1.57079632679489661923;
constexpr double kPi = 3.14159265358979323846;

// Power series of a cubic Bezier curve over t in [0, 1].
void bezier_to_power(const std::array<double, 4>& b, double out[4]) {
    out[0] = b[0];
    out[1] = 3.0 * (b[1] - b[0]);
    out[2] = 3.0 * (b[0] - 2.0 * b[1] + b[2]);
    out[3] = b[3] - 3.0 * b[2] + 3.0 * b[1] - b[0];
}

// Its transpose: adds to the cotangents of the ordinates.
void bezier_to_power_pullback(const double bar[4], std::array<double, 4>& b_bar) {
    b_bar[0] += bar[0] - 3.0 * bar[1] + 3.0 * bar[2] - bar[3];
    b_bar[1] += 3.0 * bar[1] - 6.0 * bar[2] + 3.0 * bar[3];
    b_bar[2] += 3.0 * bar[2] - 3.0 * bar[3];
    b_bar[3] += bar[3];
}

// Least value of c0 + c1 r + c2 r^2 + c3 r^3 over [low, high]: at an end, or where the slope vanishes.
double least_of_cubic(const double c[4], double low, double high, double* where) {
    const auto value = [&](double r) { return c[0] + r * (c[1] + r * (c[2] + r * c[3])); };
    double places[4] = {low, high, low, low};
    const double discriminant = c[2] * c[2] - 3.0 * c[1] * c[3];
    if (discriminant >= 0.0) {  // roots of c1 + 2 c2 r + 3 c3 r^2, without cancellation
        const double q = -(c[2] + std::copysign(std::sqrt(discriminant), c[2]));
        if (c[3] != 0.0) places[2] = q / (3.0 * c[3]);
        if (q != 0.0) places[3] = c[1] / q;
    }
    *where = low;
    for (const double r : places)
        if (r >= low && r <= high && value(r) < value(*where)) *where = r;
    return value(*where);
}

}  // namespace

void check_water_curves(const std::array<double, 4>& drag, const std::array<double, 4>& thrust, double epsilon) {
    constexpr double rounding = 1e-13;
    double size = 0.0;
    for (const double b : drag) {
        if (!std::isfinite(b)) fail(Status::ERROR_ARGUMENT, "drag_coefficients hold %g, expected finite numbers", b);
        size = std::max(size, std::fabs(b));
    }
    // With r = sqrt(t^2 + eps^2) the rounded Cd is the cubic d0 + d1 (r - eps) + (d2 + d3 r) (r^2 - eps^2).
    double d[4];
    bezier_to_power(drag, d);
    const double e2 = epsilon * epsilon;
    const double c[4] = {d[0] - d[1] * epsilon - d[2] * e2, d[1] - d[3] * e2, d[2], d[3]};
    double r = 0.0;
    const double least = least_of_cubic(c, epsilon, std::sqrt(1.0 + e2), &r);
    if (least < -rounding * size)
        fail(Status::ERROR_ARGUMENT,
             "drag_coefficients give Cd = %.3g at an angle of %.3g rad (rounded by angle_smoothing), expected a curve "
             "that is >= 0 from 0 to pi/2",
             least, kHalfPi * std::sqrt(std::max(0.0, r * r - e2)));
    // dCt/ds = 3 ((1-s)^2 a + 2 s (1-s) b + s^2 c) >= 0 on [0, 1] exactly where a, c >= 0 and b >= -sqrt(a c).
    for (const double b : thrust)
        if (!std::isfinite(b)) fail(Status::ERROR_ARGUMENT, "thrust_coefficients hold %g, expected finite numbers", b);
    const double a = thrust[1] - thrust[0], b = thrust[2] - thrust[1], last = thrust[3] - thrust[2];
    const double slack =
        rounding * std::max({std::fabs(thrust[0]), std::fabs(thrust[1]), std::fabs(thrust[2]), std::fabs(thrust[3])});
    if (a < -slack || last < -slack || b < -std::sqrt(std::max(0.0, a) * std::max(0.0, last)) - slack)
        fail(Status::ERROR_ARGUMENT,
             "thrust_coefficients are %g, %g, %g, %g: their curve Ct falls somewhere, expected one that never does "
             "from -pi/2 to pi/2",
             thrust[0], thrust[1], thrust[2], thrust[3]);
}

WaterLaws::WaterLaws(const std::array<double, 4>& drag, const std::array<double, 4>& thrust, double epsilon)
    : epsilon_(epsilon), kappa_(std::cos(epsilon)), scale_(0.0) {
    scale_ = kHalfPi / std::asin(kappa_);
    bezier_to_power(drag, drag_);
    // Ct over s = Phi/pi + 1/2, re-expanded about Phi = 0 (s = 1/2).
    double c[4];
    bezier_to_power(thrust, c);
    thrust_[0] = c[0] + 0.5 * c[1] + 0.25 * c[2] + 0.125 * c[3];
    thrust_[1] = (c[1] + c[2] + 0.75 * c[3]) / kPi;
    thrust_[2] = (c[2] + 1.5 * c[3]) / (kPi * kPi);
    thrust_[3] = c[3] / (kPi * kPi * kPi);
}

WaterLaws::Angle WaterLaws::angle(double x) const {
    Angle at;
    const double y = kappa_ * x, y2 = y * y;
    at.phi = {scale_ * std::asin(y), scale_ * kappa_ / std::sqrt(1.0 - y2)};
    if (y2 < 1e-4) {  // asin(y)/y = 1 + y^2/6 + 3 y^4/40 + 15 y^6/336 + 105 y^8/3456: below 1e-18 of error
        const double v = 1.0 + y2 * (1.0 / 6 + y2 * (3.0 / 40 + y2 * (15.0 / 336 + y2 * 105.0 / 3456)));
        const double d = y * (2.0 / 6 + y2 * (12.0 / 40 + y2 * (90.0 / 336 + y2 * 840.0 / 3456)));
        at.slope = {scale_ * kappa_ * v, scale_ * kappa_ * kappa_ * d};
    } else {
        at.slope.value = at.phi.value / x;
        at.slope.derivative = (at.phi.derivative - at.slope.value) / x;
    }
    at.t = at.phi.value / kHalfPi;
    at.root = std::sqrt(at.t * at.t + epsilon_ * epsilon_);
    return at;
}

LawValue WaterLaws::drag(const Angle& at) const {
    const double t = at.t, dt = at.phi.derivative / kHalfPi, root = at.root;
    const double odd1 = root - epsilon_, odd3 = t * t * root;  // |t| and |t|^3
    return {drag_[0] + drag_[1] * odd1 + drag_[2] * t * t + drag_[3] * odd3,
            (drag_[1] * t / root + 2.0 * drag_[2] * t + drag_[3] * (2.0 * t * root + t * t * t / root)) * dt};
}

LawValue WaterLaws::thrust_slope(const Angle& at) const {
    const LawValue &phi = at.phi, &g = at.slope;
    const double poly = thrust_[1] + phi.value * (thrust_[2] + phi.value * thrust_[3]);
    const double dpoly = (thrust_[2] + 2.0 * phi.value * thrust_[3]) * phi.derivative;
    return {poly * g.value, dpoly * g.value + poly * g.derivative};
}

void WaterLaws::pullback(const Angle& at, double drag_bar, double slope_bar, double rest_bar, LawsBar& bar) const {
    const double phi = at.phi.value, g = at.slope.value, t = at.t;
    bar.drag[0] += drag_bar;
    bar.drag[1] += drag_bar * (at.root - epsilon_);
    bar.drag[2] += drag_bar * t * t;
    bar.drag[3] += drag_bar * t * t * at.root;
    bar.thrust[0] += rest_bar;
    bar.thrust[1] += slope_bar * g;
    bar.thrust[2] += slope_bar * g * phi;
    bar.thrust[3] += slope_bar * g * phi * phi;
}

void WaterLaws::ordinates_pullback(const LawsBar& bar, std::array<double, 4>& drag_bar,
                                   std::array<double, 4>& thrust_bar) {
    bezier_to_power_pullback(bar.drag.data(), drag_bar);
    // Of the re-expansion about Phi = 0.
    const double b0 = bar.thrust[0], b1 = bar.thrust[1] / kPi, b2 = bar.thrust[2] / (kPi * kPi),
                 b3 = bar.thrust[3] / (kPi * kPi * kPi);
    const double power[4] = {b0, 0.5 * b0 + b1, 0.25 * b0 + b1 + b2, 0.125 * b0 + 0.75 * b1 + 1.5 * b2 + b3};
    bezier_to_power_pullback(power, thrust_bar);
}

}  // namespace dqa
