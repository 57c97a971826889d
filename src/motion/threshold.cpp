// SPDX-License-Identifier: MIT
// How kMargin was chosen: eta, and the displacements' error as a share of it, after ten steps from rest in water, as
// `bench_step --indicator --steps 10 [--sigma 0.7] [--grid 40x12x20]` prints them (rays: 40x36x10, scene `three`).
//
//                                tau = 0.2      0.05          0.02          0.005
//   eel         sigma 0.4        0.38  0.48     0.14   0.42   0.070  0.39   0.025  0.30
//   eel         sigma 0.7        0.50  0.63     0.22   0.50   0.14   0.49   0.057  0.43
//   two fish    sigma 0.4        0.092 0.39     0.035  0.37   0.020  0.35   0.0089 0.30
//   two fish    sigma 0.7        0.16  0.30     0.073  0.31   0.042  0.33   0.018  0.32
//   two fish    0.7, 40x12x20    0.25  0.48     0.12   0.30   0.074  0.42   0.032  0.53
//   orca, shark sigma 0.4        0.12  0.28     0.049  0.31   0.027  0.33   0.012  0.27
//   orca, shark sigma 0.7        0.16  0.36     0.074  0.42   0.045  0.41   0.019  0.39
//   orca, shark 0.7, 40x12x20    0.25  0.36     0.12   0.55   0.075  0.61   0.033  0.58
//   rays        sigma 0.4        0.12  0.12     0.050  0.10   0.029  0.10   0.012  0.09
//   rays        sigma 0.7        0.25  0.11     0.11   0.10   0.061  0.09   0.026  0.08
//
// Rays row with their wings and bend little. Errors grow along a rollout: on the eel of sigma 0.7 after thirty steps to
// 0.91, 0.78 and 0.69 of eta (tau = 0.1, 0.02, 0.005), on that of 0.4 after sixty to 1.4, 1.02 and 0.77. A margin of 1
// would bound all of the first ten steps, and no more. One sum over the body in place of sections misses thin
// tails (on 40x12x20 the measured error of the fish was 1 to 2.3 times it), and so does a mean without squares (0.5 to
// 1.8 times).
#include "motion/threshold.hpp"

#include <algorithm>
#include <cmath>

#include "shape/occupancy.hpp"

namespace dqa {
namespace {

constexpr double kMargin = 1.5;
constexpr int kBisections = 24;  // of a range of e^8.5: the threshold to 1e-6 of itself

}  // namespace

ThresholdError::ThresholdError(const Box& box, const std::vector<double>& p_hat, const SceneSettings& scene)
    : floor_(scene.occupancy_floor), directions_(box.dims == 2 || scene.planar ? 1 : 2) {
    const Occupancy full(0.0, floor_);
    const int in_section = box.cells[1] * box.cells[2];
    section_.push_back(0);
    for (int i = 0; i < box.cells[0]; ++i) {
        double mass = 0.0, stiffness = 0.0, axis[2] = {0.0, 0.0};
        for (int c = i * in_section; c < (i + 1) * in_section; ++c) {
            const double p = p_hat[static_cast<std::size_t>(c)], g = full.value(p), young = scene.young(c);
            const auto ijk = box.cell_ijk(c);
            cells_.push_back({p, g, young, {ijk[1] + 0.0, ijk[2] + 0.0}});
            mass += g, stiffness += young * g;
            for (std::size_t k = 0; k < 2; ++k) axis[k] += young * g * ijk[k + 1];
        }
        mass_.push_back(mass);
        section_.push_back(cells_.size());
        for (std::size_t c = section_[static_cast<std::size_t>(i)]; c < cells_.size(); ++c)
            for (std::size_t k = 0; k < 2; ++k) {
                const double r = cells_[c].r2[k] - axis[k] / stiffness;
                cells_[c].r2[k] = r * r + 1.0 / 12.0;
            }
    }
}

double ThresholdError::operator()(double threshold) const {
    const Occupancy law(threshold, floor_);
    double mass = 0.0, squares[2] = {0.0, 0.0};
    for (std::size_t i = 0; i < mass_.size(); ++i) {
        double whole[2] = {0.0, 0.0}, taken[2] = {0.0, 0.0};
        for (std::size_t c = section_[i]; c < section_[i + 1]; ++c) {
            const Cell& cell = cells_[c];
            const double g = law.active(cell.p_hat) ? law.value(cell.p_hat) : 0.0;
            const double change = cell.young * std::fabs(g - cell.occupancy), all = cell.young * cell.occupancy;
            for (std::size_t k = 0; k < directions_; ++k) taken[k] += change * cell.r2[k], whole[k] += all * cell.r2[k];
        }
        mass += mass_[i];
        for (std::size_t k = 0; k < directions_; ++k)
            squares[k] += mass_[i] * (taken[k] / whole[k]) * (taken[k] / whole[k]);
    }
    return kMargin * std::sqrt(std::max(squares[0], squares[1]) / mass);
}

SuggestedThreshold suggest_threshold(const ThresholdError& error, double tolerance) {
    if (const double eta = error(kMostThreshold); eta <= tolerance) return {kMostThreshold, eta};
    SuggestedThreshold best{kLeastThreshold, error(kLeastThreshold)};
    if (best.error > tolerance) return {0.0, 0.0};
    double low = std::log(kLeastThreshold), high = std::log(kMostThreshold);
    for (int k = 0; k < kBisections; ++k) {
        const double middle = 0.5 * (low + high), tau = std::exp(middle), eta = error(tau);
        if (eta <= tolerance)
            low = middle, best = {tau, eta};
        else
            high = middle;
    }
    return best;
}

}  // namespace dqa
