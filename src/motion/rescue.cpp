// SPDX-License-Identifier: MIT
// The second way of a step to its answer, taken where the first one fails: Newton's method with the Hessian shifted by
// the preconditioner, H + s P, with s chosen by how well the model foretells the energy (Levenberg-Marquardt; a trust
// region in the norm d.P d: Conn, Gould & Toint 2000, chapter 7). It needs neither a convex model nor a direction along
// which a full step goes down. P stands for the stiffness of each cell, so that nearly empty cells may go far; and P d
// costs no product: conjugate gradients know it of all their vectors.
//
// A slender body that buckles, or snaps from one side to the other, moves along a curved valley of the energy: bending
// costs next to nothing, but the straight way along it stretches the tissue, and is turned down however well it was
// chosen. So a trial point first goes down to the floor of its valley by a few loose solves, and is judged there: the
// second-order correction of constrained optimisation (Fletcher 1982; the stiff strains stand for the constraints).
#include <algorithm>
#include <cmath>

#include "grid/error.hpp"
#include "grid/log.hpp"
#include "motion/stepper.hpp"

namespace dqa {
namespace {

constexpr int kPatience = 10;  // times max_newton - 1: iterations of each attempt
constexpr double kFirstShift = 0.01;
constexpr double kLeastShift = 1e-4;   // smaller ones count as none
constexpr double kLargestShift = 1e8;  // larger ones go nowhere
constexpr int kCorrections = 4;        // of a trial point
constexpr int kOfCorrection = 100;     // products: it is the stiff strains that are corrected, and they are found first

}  // namespace

// direction_ <- -(H + shift P)^-1 gradient_ by at most `limit` products. Returns the decrease that the model without
// the shift promises; 0 where the shifted Hessian is not positive.
double Stepper::shifted_direction(double forcing, double shift, int limit, StepReport& report) {
    std::vector<double>&d = direction_, &r = krylov_.exact.r, &z = krylov_.exact.z, &p = krylov_.exact.p,
    &hp = krylov_.exact.ap;
    std::vector<double>&pp = preconditioned_[0], &pd = preconditioned_[1];  // P p, P d
    for (auto* v : {&d, &p, &pp, &pd}) v->assign(size_, 0.0);
    r.resize(size_), z.resize(size_), hp.resize(size_);
    for (std::size_t i = 0; i < size_; ++i) r[i] = -gradient_[i];
    const double enough = forcing * std::sqrt(ordered_dot(r.data(), r.data(), size_));
    double rz = 0.0;
    for (int k = 0; k < limit; ++k) {
        precondition(r.data(), z.data());
        const double rz_new = ordered_dot(r.data(), z.data(), size_), beta = k == 0 ? 0.0 : rz_new / rz;
        rz = rz_new;
        for (std::size_t i = 0; i < size_; ++i) p[i] = z[i] + beta * p[i], pp[i] = r[i] + beta * pp[i];
        apply_hessian(p.data(), hp.data());
        ++report.linear_iterations;
        for (std::size_t i = 0; i < size_; ++i) hp[i] += shift * pp[i];
        const double curvature = ordered_dot(p.data(), hp.data(), size_);
        if (!(curvature > 0)) {
            ++report.indefinite;
            return 0.0;
        }
        const double step = rz / curvature;
        for (std::size_t i = 0; i < size_; ++i) d[i] += step * p[i], pd[i] += step * pp[i], r[i] -= step * hp[i];
        if (std::sqrt(ordered_dot(r.data(), r.data(), size_)) <= enough) break;
    }
    // H d = -g - r - shift P d.
    double decrease = 0.0;
    for (std::size_t i = 0; i < size_; ++i) decrease += 0.5 * d[i] * (r[i] + shift * pd[i] - gradient_[i]);
    return decrease;
}

// From x down; false where `limit` iterations do not do or no shift is large enough.
bool Stepper::descend_shifted(std::vector<double>& x, Evaluation& now, const double* signals, long step, int limit,
                              StepReport& report) {
    double shift = kFirstShift;
    candidate_.resize(size_);
    for (int k = 0; k < limit && shift < kLargestShift; ++k) {
        if (settled(x, now, signals)) return true;
        check_limits(step, now, report);
        ++report.newton_iterations;
        const double decrease = shifted_direction(forcing(now), shift, scene_.max_linear, report);
        if (!(decrease > 0)) {
            shift = std::max(kLeastShift, 4.0 * shift);
            continue;
        }
        move_along(path_along(x), x, 1.0);
        Evaluation next = evaluate(candidate_.data(), signals);
        const double noise = energy_noise(x, now);
        for (int c = 0; c < kCorrections && next.finite && decrease > noise; ++c) {
            const double missing = next.energy - (now.energy - 0.75 * decrease);
            if (!(missing > 0) || !(shifted_direction(0.1, shift, kOfCorrection, report) > 0.1 * missing)) break;
            for (std::size_t i = 0; i < size_; ++i) candidate_[i] += direction_[i];
            next = evaluate(candidate_.data(), signals);
        }
        const double ratio = next.finite ? (now.energy - next.energy) / decrease : -1.0;
        // Where rounding hides the energies' difference the residual decides.
        const bool alike = next.finite && decrease < noise && next.energy <= now.energy + noise;
        if (ratio > 0.1 || (alike && next.residual < now.residual)) {
            x.swap(candidate_);
            now = next;
            if (ratio > 0.75 || alike) shift = shift > kLeastShift ? 0.2 * shift : 0.0;
            continue;
        }
        // At the rounding of the positions, where steps no longer help, the answer is as exact as it can be.
        const bool stagnant = alike && now.residual <= kNoise * noise_;
        now = evaluate(x.data(), signals);
        if (alike && (stagnant || shift == 0.0)) return stagnant || settled(x, now, signals);
        shift = std::max(kLeastShift, 4.0 * shift);
    }
    return settled(x, now, signals);
}

// The scene's method failed at x: on from there, or from where the step began, in which case it was led astray.
void Stepper::rescue(const State& before, std::vector<double>& x, Evaluation& now, const double* signals, long step,
                     const char* why, StepReport& report) {
    const int iterations = report.newton_iterations;
    const double relative = now.residual / now.scale;
    const int limit = kPatience * (scene_.max_newton - 1);
    if (!descend_shifted(x, now, signals, step, limit, report)) {
        const Evaluation stopped = now;
        x = before.q;
        now = evaluate(x.data(), signals);
        if (!now.finite || !descend_shifted(x, now, signals, step, limit, report))
            fail_step(Status::NOT_CONVERGED, step, why, stopped);
    }
    report.rescued = true;
    log_message(LogLevel::warning,
                "step %ld: %s at a relative force residual of %.2g; a shifted Newton's method took over and found the "
                "answer after %d iterations",
                step, why, relative, report.newton_iterations - iterations);
}

}  // namespace dqa
