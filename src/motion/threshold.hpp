// SPDX-License-Identifier: MIT
// How far a threshold tau of the active set moves a design from the full box (tau = 0), told from its density alone.
//
// Occupancy fades to nothing at tau, which makes the rim of every cross-section softer and lighter. A swimmer is a beam
// along x: its displacements follow the bending stiffness sum E G r^2 of its cross-sections, and r^2 is largest where
// cells are faintest. With r the distance from the neutral axis of the section (of cells dx^2 / 12 more), and d(x) the
// part of the section's stiffness that tau takes, sum E |G_tau - G_0| r^2 / sum E G_0 r^2,
//   eta(tau) = kMargin * sqrt(sum_x m d^2 / sum_x m),
// m(x) the section's mass at tau = 0, of the two directions of bending the one that loses more. A mean over sections
// and not one sum over the body, because thick trunks would hide thin tails; a mean of squares because the measured
// error, too, is one. eta grows with tau, because |G_tau - G_0| does in every cell. kMargin is calibrated;
// threshold.cpp has the table.
#pragma once

#include <vector>

#include "motion/scene.hpp"

namespace dqa {

class ThresholdError {
public:
    // Of the scene: moduli by cell, the floor of occupancy, whether it is planar.
    ThresholdError(const Box& box, const std::vector<double>& p_hat, const SceneSettings& scene);
    double operator()(double threshold) const;  // eta; in [0, 0.5)

private:
    struct Cell {
        double p_hat, occupancy, young;
        double r2[2];  // distance from the neutral axis, squared, across y and across z (cells)
    };
    double floor_;
    std::size_t directions_;  // of bending: across y, and across z where anything moves there
    std::vector<Cell> cells_;
    std::vector<std::size_t> section_;  // first cell of each section, and the end
    std::vector<double> mass_;          // of sections
};

// The largest threshold whose eta is at most the tolerance, by bisection on its logarithm; 0, the full box, where none
// from kLeastThreshold on is small enough.
constexpr double kLeastThreshold = 1e-4, kMostThreshold = 0.499;
struct SuggestedThreshold {
    double threshold, error;  // error: eta of it
};
SuggestedThreshold suggest_threshold(const ThresholdError& error, double tolerance);

}  // namespace dqa
