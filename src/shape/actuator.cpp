// SPDX-License-Identifier: MIT
#include "shape/actuator.hpp"

#include <algorithm>
#include <cmath>

#include "grid/error.hpp"

namespace dqa {
namespace {

constexpr double kTwoLn2 = 1.3862943611198906;  // semi-axis of the half-peak ellipsoid: sqrt(2 ln 2 variance)
constexpr double kFadeShare = 0.05;

void multiply(const double a[9], const double b[9], double out[9]) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            double s = 0.0;
            for (int k = 0; k < 3; ++k) s += a[3 * i + k] * b[3 * k + j];
            out[3 * i + j] = s;
        }
}

// Rotation about one axis and its derivative by the angle.
void axis_rotation(int axis, double angle, double r[9], double d[9]) {
    const double c = std::cos(angle), s = std::sin(angle);
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (int k = 0; k < 9; ++k) r[k] = d[k] = 0.0;
    r[4 * axis] = 1.0;
    r[4 * a] = r[4 * b] = c, r[3 * a + b] = -s, r[3 * b + a] = s;
    d[4 * a] = d[4 * b] = -s, d[3 * a + b] = -c, d[3 * b + a] = c;
}

}  // namespace

double smooth_step(double t) {
    if (t <= 0) return 0.0;
    if (t >= 1) return 1.0;
    return t * t * t * (10.0 + t * (-15.0 + 6.0 * t));
}

double smooth_step_derivative(double t) {
    if (t <= 0 || t >= 1) return 0.0;
    const double u = t * (1.0 - t);
    return 30.0 * u * u;
}

ActuatorPoint interpolate_actuator(const std::vector<const Actuator*>& of_base, const std::vector<double>& weights) {
    ActuatorPoint out;
    out.weights.assign(weights.size(), 0.0);
    double count = 0.0;
    for (std::size_t i = 0; i < of_base.size(); ++i)
        if (of_base[i]) out.category = of_base[i]->category, out.share += weights[i], count += 1.0;
    for (std::size_t i = 0; i < of_base.size(); ++i) {
        if (!of_base[i]) continue;
        // With no share at all the geometry is immaterial (strength 0) but must be finite.
        const double w = out.share > 0 ? weights[i] / out.share : 1.0 / count;
        out.weights[i] = w;
        for (std::size_t k = 0; k < 3; ++k) {
            out.mean[k] += w * of_base[i]->mean[k];
            out.variance[k] += w * of_base[i]->variance[k];
            out.euler[k] += w * of_base[i]->euler[k];
        }
    }
    out.strength = smooth_step(out.share / kFadeShare);
    return out;
}

void interpolate_actuator_pullback(const std::vector<const Actuator*>& of_base, const ActuatorPoint& point,
                                   const ActuatorPoint& bar, std::vector<double>& weights_bar) {
    if (!(point.share > 0)) return;  // strength and its slope are zero there
    const double strength_bar = bar.strength * smooth_step_derivative(point.share / kFadeShare) / kFadeShare;
    for (std::size_t i = 0; i < of_base.size(); ++i) {
        if (!of_base[i]) continue;
        double s = 0.0;
        for (std::size_t k = 0; k < 3; ++k) {
            s += bar.mean[k] * (of_base[i]->mean[k] - point.mean[k]);
            s += bar.variance[k] * (of_base[i]->variance[k] - point.variance[k]);
            s += bar.euler[k] * (of_base[i]->euler[k] - point.euler[k]);
        }
        weights_bar[i] += s / point.share + strength_bar;
    }
}

ActuatorRegion::ActuatorRegion(const ActuatorPoint& point, double ramp)
    : mean_(point.mean), variance_(point.variance), half_{}, ramp_(ramp) {
    double r[3][9], d[3][9], t[9];
    for (int a = 0; a < 3; ++a) axis_rotation(a, point.euler[static_cast<std::size_t>(a)], r[a], d[a]);
    multiply(r[0], r[1], t), multiply(t, r[2], rotation_);
    multiply(d[0], r[1], t), multiply(t, r[2], rotation_d_[0]);
    multiply(r[0], d[1], t), multiply(t, r[2], rotation_d_[1]);
    multiply(r[0], r[1], t), multiply(t, d[2], rotation_d_[2]);
    for (std::size_t k = 0; k < 3; ++k) half_[k] = std::sqrt(kTwoLn2 * variance_[k]);
}

double ActuatorRegion::membership(const Vec3& x) const {
    double value = 1.0;
    for (int k = 0; k < 3; ++k) {
        const std::size_t a = static_cast<std::size_t>(k);
        double xi = 0.0;
        for (int j = 0; j < 3; ++j)
            xi += rotation_[3 * k + j] * (x[static_cast<std::size_t>(j)] - mean_[static_cast<std::size_t>(j)]);
        value *= smooth_step((half_[a] - xi) / ramp_ + 0.5) * smooth_step((half_[a] + xi) / ramp_ + 0.5);
    }
    return value;
}

void ActuatorRegion::membership_pullback(const Vec3& x, double membership_bar, ActuatorPoint& bar) const {
    double xi[3], value[3], by_xi[3], by_half[3];
    for (int k = 0; k < 3; ++k) {
        const std::size_t a = static_cast<std::size_t>(k);
        xi[k] = 0.0;
        for (int j = 0; j < 3; ++j)
            xi[k] += rotation_[3 * k + j] * (x[static_cast<std::size_t>(j)] - mean_[static_cast<std::size_t>(j)]);
        const double up = (half_[a] - xi[k]) / ramp_ + 0.5, down = (half_[a] + xi[k]) / ramp_ + 0.5;
        const double su = smooth_step(up), sd = smooth_step(down);
        const double du = smooth_step_derivative(up) / ramp_, dd = smooth_step_derivative(down) / ramp_;
        value[k] = su * sd;
        by_xi[k] = su * dd - du * sd;
        by_half[k] = du * sd + su * dd;
    }
    for (int k = 0; k < 3; ++k) {
        const std::size_t a = static_cast<std::size_t>(k);
        const double others = membership_bar * value[(k + 1) % 3] * value[(k + 2) % 3];
        const double xi_bar = others * by_xi[k];
        bar.variance[a] += others * by_half[k] * 0.5 * half_[a] / variance_[a];
        for (int j = 0; j < 3; ++j) {
            const std::size_t b = static_cast<std::size_t>(j);
            bar.mean[b] -= xi_bar * rotation_[3 * k + j];
            for (std::size_t e = 0; e < 3; ++e) bar.euler[e] += xi_bar * rotation_d_[e][3 * k + j] * (x[b] - mean_[b]);
        }
    }
}

Actuator place_caudal(const Box& box, const std::vector<double>& fractions) {
    const int nx = box.cells[0], ny = box.cells[1], nz = box.cells[2];
    std::vector<double> area(static_cast<std::size_t>(nx), 0.0);
    double largest = 0.0;
    for (int i = 0; i < nx; ++i) {
        for (int jk = 0; jk < ny * nz; ++jk)
            area[static_cast<std::size_t>(i)] += fractions[static_cast<std::size_t>(i * ny * nz + jk)];
        largest = std::max(largest, area[static_cast<std::size_t>(i)]);
    }
    int tail = 0, head = nx - 1;
    while (tail < head && area[static_cast<std::size_t>(tail)] < 0.02 * largest) ++tail;
    while (head > tail && area[static_cast<std::size_t>(head)] < 0.02 * largest) --head;
    const int length = head - tail + 1;
    // Peduncle: narrowest section between 8 % and 40 % of the length from the tail tip.
    int peduncle = tail + static_cast<int>(0.08 * length);
    for (int i = peduncle; i <= tail + static_cast<int>(0.40 * length); ++i)
        if (area[static_cast<std::size_t>(i)] < area[static_cast<std::size_t>(peduncle)]) peduncle = i;
    const int middle = std::max(peduncle + 2, tail + static_cast<int>(0.55 * length));
    double mass = 0.0, mean_z = 0.0, mean_zz = 0.0, mean_yy = 0.0;
    for (int i = peduncle; i < middle && i < nx; ++i)
        for (int j = 0; j < ny; ++j)
            for (int k = 0; k < nz; ++k) {
                const int c = box.cell(i, j, k);
                const double f = fractions[static_cast<std::size_t>(c)];
                const Vec3 x = box.cell_centre(c);
                mass += f, mean_z += f * x[2], mean_zz += f * x[2] * x[2], mean_yy += f * x[1] * x[1];
            }
    if (!(mass > 0))
        fail(Status::ERROR_ARGUMENT, "base shape: no body found between peduncle and middle to carry a muscle");
    mean_z /= mass, mean_zz /= mass, mean_yy /= mass;
    // A uniform section of half-width H has variance H^2/4 (ellipse): twice the deviation spans it. At least one cell.
    const double half_y = std::max(box.dx, 2.0 * std::sqrt(mean_yy));
    const double half_z = std::max(box.dx, 2.0 * std::sqrt(std::max(0.0, mean_zz - mean_z * mean_z)));
    const double x0 = (peduncle - 0.5 * nx) * box.dx, x1 = (std::min(middle, nx) - 0.5 * nx) * box.dx;
    Actuator out;
    out.mean = {0.5 * (x0 + x1), 0.0, mean_z};
    const Vec3 half = {0.5 * (x1 - x0), half_y, half_z};
    for (std::size_t k = 0; k < 3; ++k) out.variance[k] = half[k] * half[k] / kTwoLn2;
    return out;
}

}  // namespace dqa
