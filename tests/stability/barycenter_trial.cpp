// SPDX-License-Identifier: MIT
#include "barycenter_trial.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <limits>
#include <optional>

#include "grid/random.hpp"
#include "oracle_run.hpp"
#include "shape/barycenter.hpp"

namespace stability {
namespace {

using Eigen::ArrayXd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::array<int, 3> kCells{32, 8, 1};
constexpr int kSize = kCells[0] * kCells[1];
constexpr double kShare = 0.6;      // of the first base
constexpr double kNudge = 2e-6;     // of the weights, for differences
constexpr double kBalance = 1e-12;  // of the oracle's marginals

Vector ellipse(double x, double y, double rx, double ry) {
    Vector p(kSize, 0.0);
    double sum = 0.0;
    for (int i = 0; i < kCells[0]; ++i)
        for (int j = 0; j < kCells[1]; ++j)
            for (int s = 0; s < 64; ++s) {
                const double dx = (i + (s / 8 + 0.5) / 8 - x) / rx, dy = (j + (s % 8 + 0.5) / 8 - y) / ry;
                if (dx * dx + dy * dy < 1.0) p[static_cast<std::size_t>(i * kCells[1] + j)] += 1.0, sum += 1.0;
            }
    for (double& value : p) value /= sum;
    return p;
}

std::vector<Vector> bases_of(double separation) {
    const double x = 0.5 * kCells[0], y = 0.5 * kCells[1];
    return {ellipse(x - 0.5 * separation, y, 3.9, 1.6), ellipse(x + 0.5 * separation, y, 2.7, 2.9)};
}

ArrayXd array(const Vector& a) {
    return Eigen::Map<const ArrayXd>(a.data(), static_cast<Eigen::Index>(a.size()));
}

// ---------------------------------------------------------------- the oracle

// Of z with x_1 = z / alpha, x_2 = -z / (1 - alpha).
class Dual {
public:
    Dual(const std::vector<Vector>& bases, double sigma, double alpha) : sigma_(sigma) {
        share_[0] = 1.0 / alpha, share_[1] = -1.0 / (1.0 - alpha);
        for (std::size_t b = 0; b < 2; ++b)
            for (int c = 0; c < kSize; ++c)
                if (bases[b][static_cast<std::size_t>(c)] > 0.0)
                    supports_[b].push_back(c), mass_[b].push_back(bases[b][static_cast<std::size_t>(c)]);
    }

    // The value; gradient: the difference of the marginals; marginals; and the Hessian where wanted.
    double evaluate(const ArrayXd& z, VectorXd& gradient, ArrayXd (&marginal)[2], MatrixXd* hessian) const {
        double value = 0.0;
        if (hessian) hessian->setZero(kSize, kSize);
        for (std::size_t b = 0; b < 2; ++b) {
            const ArrayXd x = share_[b] * z;
            marginal[b].setZero(kSize);
            for (std::size_t k = 0; k < supports_[b].size(); ++k) {
                // The plan's row of a cell of the base, from logarithms.
                ArrayXd row(kSize);
                const int from = supports_[b][k];
                for (int c = 0; c < kSize; ++c) row[c] = x[c] - 0.5 * distance2(from, c) / (sigma_ * sigma_);
                const double top = row.maxCoeff();
                row = (row - top).exp();
                const double sum = row.sum();
                row /= sum;
                value += mass_[b][k] * (top + std::log(sum)) / std::fabs(share_[b]);
                marginal[b] += mass_[b][k] * row;
                if (hessian)
                    hessian->selfadjointView<Eigen::Lower>().rankUpdate(row.matrix(),
                                                                        -mass_[b][k] * std::fabs(share_[b]));
            }
            if (hessian) hessian->diagonal() += std::fabs(share_[b]) * marginal[b].matrix();
        }
        gradient = (marginal[0] - marginal[1]).matrix();
        return value;
    }

private:
    static double distance2(int a, int b) {
        const int di = a / kCells[1] - b / kCells[1], dj = a % kCells[1] - b % kCells[1];
        return di * di + dj * dj;
    }
    double sigma_;
    double share_[2];
    std::vector<int> supports_[2];
    std::vector<double> mass_[2];
};

// Newton's method with the Hessian shifted by a share of its own diagonal. Returns the imbalance of the marginals.
double minimise(const Dual& dual, ArrayXd& z, int max_iterations, ArrayXd& density) {
    VectorXd gradient, next_gradient;
    ArrayXd marginal[2], next_marginal[2];
    MatrixXd hessian;
    double value = dual.evaluate(z, gradient, marginal, &hessian), shift = 1e-10;
    for (int k = 0; k < max_iterations && gradient.lpNorm<1>() > kBalance; ++k) {
        const VectorXd scale = (hessian.diagonal().array() + 1e-300).sqrt().inverse();
        bool moved = false;
        for (int trial = 0; trial < 30 && !moved; ++trial) {
            MatrixXd scaled =
                scale.asDiagonal() * MatrixXd(hessian.selfadjointView<Eigen::Lower>()) * scale.asDiagonal();
            scaled.diagonal().array() += shift;
            const Eigen::LLT<MatrixXd> factor(scaled);
            if (factor.info() == Eigen::Success) {
                const VectorXd step = -(scale.asDiagonal() * factor.solve(VectorXd(scale.asDiagonal() * gradient)));
                const ArrayXd there = z + step.array();
                const double next = dual.evaluate(there, next_gradient, next_marginal, nullptr);
                const double slope = gradient.dot(step), noise = 1e-13 * (1.0 + std::fabs(value));
                if (next <= value + 1e-3 * slope ||
                    (next <= value + noise && next_gradient.lpNorm<1>() < gradient.lpNorm<1>())) {
                    z = there, moved = true;
                    break;
                }
            }
            shift = std::max(1e-14, 10.0 * shift);
        }
        if (!moved) break;
        shift = std::max(1e-13, 0.1 * shift);
        value = dual.evaluate(z, gradient, marginal, &hessian);
    }
    density = 0.5 * (marginal[0] + marginal[1]);
    return gradient.lpNorm<1>();
}

struct OracleAnswer {
    double imbalance = std::numeric_limits<double>::infinity();
    ArrayXd density, potential;
    bool found() const { return imbalance <= 1e3 * kBalance; }
};

// Down from wider kernels, whose potentials sigma^2 x differ little; or from `start` alone.
OracleAnswer solve(const std::vector<Vector>& bases, double sigma, double alpha, const ArrayXd* start) {
    OracleAnswer out;
    ArrayXd z = start ? *start : ArrayXd::Zero(kSize);
    double width = sigma;
    while (!start && width < 6.0) width *= 1.25;
    for (;; width = std::max(sigma, width / 1.25)) {
        const bool last = width <= sigma * (1.0 + 1e-12);
        out.imbalance = minimise(Dual(bases, width, alpha), z, last ? 400 : 30, out.density);
        if (last) break;
        z *= std::pow(width / std::max(sigma, width / 1.25), 2);
    }
    out.potential = z;
    return out;
}

// ---------------------------------------------------------------- the textbook method

ArrayXd textbook(const std::vector<Vector>& bases, const dqa::GaussianKernel& kernel, double alpha, Result& out) {
    constexpr double kStill = 1e-9;
    constexpr int kIterations = 5000;
    const double share[2] = {alpha, 1.0 - alpha};
    ArrayXd v[2] = {ArrayXd::Ones(kSize), ArrayXd::Ones(kSize)}, d[2], p = ArrayXd::Zero(kSize);
    Vector scratch(kSize);
    const auto blurred = [&](ArrayXd a) {
        kernel.apply(a.data(), a.data(), scratch.data());
        return a;
    };
    out.outcome = Outcome::accurate;
    for (out.steps_done = 0; out.steps_done < kIterations; ++out.steps_done) {
        ArrayXd log_p = ArrayXd::Zero(kSize);
        for (std::size_t b = 0; b < 2; ++b) {
            d[b] = v[b] * blurred(array(bases[b]) / blurred(v[b]));
            log_p += share[b] * d[b].log();
        }
        const ArrayXd next = log_p.exp();
        if (!next.isFinite().all()) return p;
        for (std::size_t b = 0; b < 2; ++b) v[b] *= next / d[b];
        out.residual = (next - p).abs().sum();
        p = next;
        if (out.residual <= kStill) return p;
    }
    out.outcome = Outcome::reported;
    out.reason = dqa::format("the density still changes by %.1e after %d iterations", out.residual, kIterations);
    return p;
}

// ---------------------------------------------------------------- the comparison

// Density and derivative of <probe, density> by the first weight at the expense of the second.
struct Measured {
    ArrayXd density;
    double derivative = 0.0;
    std::optional<ArrayXd> potential;  // a start for the oracle
};

Measured by_library(const std::vector<Vector>& bases, const dqa::GaussianKernel& kernel, const Vector& probe,
                    Result& out) {
    Measured m;
    try {
        const dqa::BarycenterSettings settings;
        const dqa::Barycenter b = dqa::solve_barycenter(kernel, bases, {kShare, 1.0 - kShare}, settings);
        out.residual = b.marginal_error, out.steps_done = b.iterations + b.linear_iterations;
        m.density = array(b.p);
        m.potential = kShare * Eigen::Map<const ArrayXd>(b.log_v.data(), kSize);
        const Vector bar = dqa::barycenter_pullback(kernel, bases, b, probe.data(), settings);
        m.derivative = bar[0] - bar[1];
        out.outcome = Outcome::accurate;
    } catch (const dqa::Error& e) {
        report_error(e, out);
    }
    return m;
}

Measured by_textbook(const std::vector<Vector>& bases, const dqa::GaussianKernel& kernel, const Vector& probe,
                     Result& out) {
    Measured m;
    m.density = textbook(bases, kernel, kShare, out);
    Result unused;
    double value[2];
    for (int side = 0; side < 2; ++side)
        value[side] = (textbook(bases, kernel, kShare + (side ? kNudge : -kNudge), unused) * array(probe)).sum();
    m.derivative = (value[1] - value[0]) / (2.0 * kNudge);
    return m;
}

}  // namespace

Result run(const BarycenterTrial& trial) {
    Result out;
    const std::vector<Vector> bases = bases_of(trial.separation);
    const dqa::GaussianKernel kernel(kCells, trial.sigma);
    dqa::Random random{5};
    Vector probe(kSize);
    for (double& x : probe) x = random();
    const Measured got =
        trial.reference ? by_textbook(bases, kernel, probe, out) : by_library(bases, kernel, probe, out);
    OracleAnswer exact = solve(bases, trial.sigma, kShare, nullptr);
    if (!exact.found() && got.potential) exact = solve(bases, trial.sigma, kShare, &*got.potential);
    out.solvable = exact.found();
    if (out.outcome != Outcome::accurate) return out;
    if (!exact.found()) {
        out.outcome = Outcome::silent;
        out.reason = dqa::format("the oracle's marginals differ by %.1e", exact.imbalance);
        return out;
    }
    if (!got.density.isFinite().all() || !std::isfinite(got.derivative)) {
        out.outcome = Outcome::nan;
        return out;
    }
    out.state_error = (got.density - exact.density).abs().sum();
    double value[2];
    for (int side = 0; side < 2; ++side) {
        const double alpha = kShare + (side ? kNudge : -kNudge);
        const ArrayXd& start = exact.potential;
        value[side] = (solve(bases, trial.sigma, alpha, &start).density * array(probe)).sum();
    }
    const double derivative = (value[1] - value[0]) / (2.0 * kNudge);
    out.gradient_error = std::fabs(got.derivative - derivative) / std::max(std::fabs(derivative), 1e-2);
    if (!(out.state_error <= kStateBound) || !(out.gradient_error <= kGradientBound)) {
        out.outcome = Outcome::silent;
        out.reason = dqa::format("density %.1e off; derivative %.1e; mass %.4f", out.state_error, out.gradient_error,
                                 got.density.sum());
    }
    return out;
}

double check_oracle(const BarycenterTrial& trial) {
    return solve(bases_of(trial.separation), trial.sigma, kShare, nullptr).imbalance;
}

}  // namespace stability
