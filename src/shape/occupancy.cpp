// SPDX-License-Identifier: MIT
#include "shape/occupancy.hpp"

#include <algorithm>
#include <cmath>

namespace dqa {
namespace {

constexpr int kPower = 64;
constexpr double kGain = 0.1, kSlope = 1.0 / kGain - 2.0;

// x^64 by squaring: exact to rounding and without the cost of pow.
double power64(double x) {
    for (int k = 0; k < 6; ++k) x *= x;
    return x;
}

}  // namespace

double peak_of(const std::vector<double>& p, Peak kind) {
    const double top = *std::max_element(p.begin(), p.end());
    if (kind == Peak::paper || !(top > 0)) return top;
    double upper = 0.0, lower = 0.0;
    for (const double value : p) {
        const double t = power64(value / top);
        lower += t;
        upper += t * (value / top);
    }
    return top * upper / lower;
}

std::vector<double> normalise_pullback(const std::vector<double>& p, double peak, Peak kind, const double* p_hat_bar) {
    const std::size_t n = p.size();
    std::vector<double> bar(n);
    double peak_bar = 0.0;
    for (std::size_t c = 0; c < n; ++c) {
        bar[c] = p_hat_bar[c] / peak;
        peak_bar -= p_hat_bar[c] * p[c] / (peak * peak);
    }
    const auto top_at = std::max_element(p.begin(), p.end());
    if (kind == Peak::paper) {
        bar[static_cast<std::size_t>(top_at - p.begin())] += peak_bar;
        return bar;
    }
    // M = top A / B with A = sum s^65, B = sum s^64, s = p / top (top is only a scale: M does not depend on it).
    const double top = *top_at;
    double lower = 0.0;
    for (const double value : p) lower += power64(value / top);
    for (std::size_t c = 0; c < n; ++c) {
        const double s = p[c] / top;
        if (s <= 1e-8) continue;  // s^63 < 1e-504: exactly zero in double
        const double s64 = power64(s);
        bar[c] += peak_bar * ((kPower + 1) * s64 - kPower * (peak / top) * s64 / s) / lower;
    }
    return bar;
}

double gain(double t) {
    const double d = kSlope * (1.0 - 2.0 * t);
    return t < 0.5 ? t / (d + 1.0) : (d - t) / (d - 1.0);
}

double gain_derivative(double t) {
    const double d = kSlope * (1.0 - 2.0 * t), dd = -2.0 * kSlope;
    if (t < 0.5) return ((d + 1.0) - t * dd) / ((d + 1.0) * (d + 1.0));
    return ((dd - 1.0) * (d - 1.0) - (d - t) * dd) / ((d - 1.0) * (d - 1.0));
}

Occupancy::Occupancy(double threshold, double floor)
    : threshold_(threshold), floor_(floor), edge_(gain(threshold)), inv_norm_(1.0) {
    const double top = 1.0 - edge_;
    inv_norm_ = (top + edge_) / (top * top);
}

double Occupancy::value(double p_hat) const {
    const double x = std::max(0.0, gain(p_hat) - edge_);
    const double s = x > 0 ? x * x / (x + edge_) * inv_norm_ : 0.0;
    return floor_ + (1.0 - floor_) * s;
}

double Occupancy::derivative(double p_hat) const {
    const double x = gain(p_hat) - edge_;
    if (x < 0 || (x == 0 && edge_ > 0)) return 0.0;
    const double ds = edge_ > 0 ? (x * x + 2.0 * x * edge_) / ((x + edge_) * (x + edge_)) : 1.0;
    return (1.0 - floor_) * inv_norm_ * ds * gain_derivative(p_hat);
}

}  // namespace dqa
