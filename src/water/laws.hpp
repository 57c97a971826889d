// SPDX-License-Identifier: MIT
// Drag and thrust coefficients of a surface element over the sine x = n.u/|u| of the angle of attack Phi, smooth
// everywhere. Cubic Bezier curves in the angle as in DiffAqua (2021), eqs. drag and thrust.
//
// Head-on (|x| = 1) the angle asin(x) has infinite slope: a cone in the velocity. It is rounded by
//   Phi = asin(x cos eps) * (pi/2) / asin(cos eps),
// odd, analytic on [-1, 1], exact at 0 and +-pi/2; the angle changes by at most about eps. The odd powers of
// t = |Phi|/(pi/2) in Cd are rounded at tangential flow: |t| -> sqrt(t^2 + eps^2) - eps, |t|^3 -> t^2 sqrt(t^2 +
// eps^2).
#pragma once

#include <array>

namespace dqa {

struct LawValue {
    double value = 0.0;
    double derivative = 0.0;  // with respect to x
};

// Cotangents of the laws' coefficients; the laws are linear in them.
struct LawsBar {
    std::array<double, 4> drag{}, thrust{};  // of the power series
};

// Throws ERROR_ARGUMENT unless Cd, rounded as below, is >= 0 at every angle and Ct nowhere falls: on the curves
// themselves, not on their ordinates. Both make the dissipation of a face convex. Differences of rounding size pass.
void check_water_curves(const std::array<double, 4>& drag, const std::array<double, 4>& thrust, double epsilon);

class WaterLaws {
public:
    WaterLaws(const std::array<double, 4>& drag, const std::array<double, 4>& thrust, double epsilon);

    // What both laws make of x; the arc sine in it is their price, and they share it.
    struct Angle {
        LawValue phi, slope;         // Phi, and Phi / x
        double t = 0.0, root = 0.0;  // Phi / (pi/2), and |t| rounded
    };
    Angle angle(double x) const;
    LawValue drag(const Angle& at) const;              // Cd(|Phi|)
    LawValue thrust_slope(const Angle& at) const;      // (Ct(Phi) - Ct(0)) / x, >= 0 for a monotone Ct; finite at x = 0
    double thrust_rest() const { return thrust_[0]; }  // Ct(0)
    LawValue drag(double x) const { return drag(angle(x)); }
    LawValue thrust_slope(double x) const { return thrust_slope(angle(x)); }

    // Cotangents of the three, to the coefficients of the curves' power series: added to `bar`.
    void pullback(const Angle& at, double drag_bar, double slope_bar, double rest_bar, LawsBar& bar) const;
    void pullback(double x, double drag_bar, double slope_bar, double rest_bar, LawsBar& bar) const {
        pullback(angle(x), drag_bar, slope_bar, rest_bar, bar);
    }
    // From there to the ordinates of the Bezier curves: added to drag_bar and thrust_bar.
    static void ordinates_pullback(const LawsBar& bar, std::array<double, 4>& drag_bar,
                                   std::array<double, 4>& thrust_bar);

private:
    double drag_[4];    // power series in t = |Phi| / (pi/2)
    double thrust_[4];  // power series in Phi
    double epsilon_, kappa_, scale_;
};

}  // namespace dqa
