// SPDX-License-Identifier: MIT
// How well a step's positions are known. A residual alone does not say: where a body is soft, buckles or has nearly
// empty cells, a force that is small beside the others moves nodes far. Close to the answer the error is Newton's
// correction e = -H^-1 r, and a step ends only where one of two bounds says that it is small:
//   before a correction, by the preconditioner P in the place of H. As inertia is a part of H, H >= M / b^2 and
//     |e|_M <= b |e|_H = b sqrt(r . H^-1 r) ~ b sqrt(r . P^-1 r), and over all nodes alike |e| ~ |P^-1 r|;
//   after one, by the size of the correction itself, if it was a full step (the error-oriented test of Newton's method:
//     Deuflhard 2011, Newton Methods for Nonlinear Problems, sec. 2.1). What it leaves is smaller.
// The first costs one application of the preconditioner and does in usual scenes; where P is far from H, at large
// strains or strong drag, the second decides.
#include <cmath>
#include <limits>

#include "grid/error.hpp"
#include "motion/stepper.hpp"

namespace dqa {
namespace {

constexpr double kMassBound = 5.0;    // tolerances of the way moved, in the norm of the mass
constexpr double kNodeBound = 50.0;   // likewise over all nodes alike, those of nearly empty cells among them
constexpr double kStill = 1e-4;       // cells: a shorter way counts as that long
constexpr double kCorrection = 0.01;  // of its right-hand side: residual of a correction's linear system
constexpr int kCorrections = 12;      // at most; the stability map has no step that takes more than four

// Squared norms in the mass and over all nodes alike.
struct Squares {
    double mass = 0.0, nodes = 0.0;
    void operator+=(const Squares& o) { mass += o.mass, nodes += o.nodes; }
};

// Of f(i), i over the coordinates [n_nodes][3].
template <class F>
Squares squares_of(const std::vector<double>& node_mass, Threads threads, const F& f) {
    const int n = static_cast<int>(node_mass.size());
    return parallel_total<Squares>(threads, n, kNodeGrain, [&](int begin, int end) {
        Squares own;
        for (std::size_t i = 3 * static_cast<std::size_t>(begin); i < 3 * static_cast<std::size_t>(end); ++i) {
            const double x = f(i);
            own.mass += node_mass[i / 3] * x * x, own.nodes += x * x;
        }
        return own;
    });
}

}  // namespace

Stepper::Allowed Stepper::allowed_error(const std::vector<double>& q_old, const std::vector<double>& q_new) const {
    const double still = kStill * design_->space().box().dx;
    const Squares way =
        squares_of(design_->mass(), threads_, [&](std::size_t i) { return std::hypot(q_new[i] - q_old[i], still); });
    return {kMassBound * scene_.tolerance * std::sqrt(way.mass), kNodeBound * scene_.tolerance * std::sqrt(way.nodes)};
}

// The first bound, of the residual in gradient_.
bool Stepper::foreseen(const Allowed& allowed) {
    const double* r = gradient_.data();
    const double norm = ordered_norm(r, size_, threads_);
    if (!(norm > 0)) return true;
    std::vector<double>& z = trial_;
    const double rz = design_->preconditioner().solve(r, norm, false, r, z.data(), threads_, preconditioner_)[0];
    mask(z.data());
    return rz >= 0 && beta_ * std::sqrt(rz) <= allowed.mass && ordered_norm(z.data(), size_, threads_) <= allowed.nodes;
}

// The second, of the correction in direction_.
bool Stepper::small_correction(const Allowed& allowed) const {
    const Squares size = squares_of(design_->mass(), threads_, [&](std::size_t i) { return direction_[i]; });
    return std::sqrt(size.mass) <= allowed.mass && std::sqrt(size.nodes) <= allowed.nodes;
}

// From x, where all forces are in balance, on to a point that is known to be close to the answer.
void Stepper::locate(const std::vector<double>& q_old, std::vector<double>& x, Evaluation& now, const double* signals,
                     long step, StepReport& report) {
    const Allowed allowed = allowed_error(q_old, x);
    bool known = foreseen(allowed);
    double before = std::numeric_limits<double>::infinity();
    for (int k = 0; k < kCorrections && !(known && !loose(now)); ++k) {
        // At the rounding of the positions, where corrections no longer help, they are as exact as they can be.
        if (now.residual <= kNoise * noise_ && now.residual > 0.25 * before) return;
        before = now.residual;
        check_limits(step, now, report);
        ++report.newton_iterations;
        const int indefinite = report.indefinite;
        const double share = newton_direction(kCorrection, report) ? line_search(x, now, signals) : 0.0;
        if (share == 0.0) break;
        known =
            share == 1.0 && report.indefinite == indefinite && small_correction(allowed) && settled(x, now, signals);
    }
    if (!known && now.residual > kNoise * noise_)
        fail_step(Status::NOT_CONVERGED, step,
                  format("forces are in balance, but the last of %d corrections still moves nodes", kCorrections), now);
}

}  // namespace dqa
