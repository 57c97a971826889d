// SPDX-License-Identifier: MIT
// From density to material: smooth peak, Schlick gain, and the occupancy of a cell, each with its derivative.
//
//  - peak M = sum p^65 / sum p^64 instead of max p: an almost uniform interior has hundreds of near-ties, where a hard
//    maximum has no usable derivative (the paper's form stays available).
//  - gain G(t) with parameter 0.1 (Schlick 1994; the paper's E(c) = E0 G(p, 0.1)), G(1/2) = 1/2, continued a little
//    above t = 1 by its own formula.
//  - occupancy: with x = G(p) - G(tau), x^2 / (x + G(tau)), scaled to 1 at p = 1, above a small floor: both value and
//    slope vanish at the edge tau of the active set, so that a cell entering or leaving it does not kink the loss; the
//    remaining jump is the floor.
#pragma once

#include <vector>

namespace dqa {

enum class Peak : int { smooth = 0, paper = 1 };

double peak_of(const std::vector<double>& p, Peak kind);
// p_bar of p_hat = p / peak(p), from p_hat_bar.
std::vector<double> normalise_pullback(const std::vector<double>& p, double peak, Peak kind, const double* p_hat_bar);

double gain(double t);
double gain_derivative(double t);

class Occupancy {
public:
    Occupancy(double threshold, double floor);
    bool active(double p_hat) const { return threshold_ <= 0.0 || p_hat > threshold_; }
    double value(double p_hat) const;  // of an active cell
    double derivative(double p_hat) const;

private:
    double threshold_, floor_, edge_, inv_norm_;
};

}  // namespace dqa
