// SPDX-License-Identifier: MIT
#include "shape/actuator_region.hpp"

#include <cmath>

namespace dqa {
namespace {

const double kRoot2 = std::sqrt(2.0);

double dot(const Vec3& a, const Vec3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vec3 difference(const Vec3& a, const Vec3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// A smooth indicator, and its derivatives by the coordinate and by the half width.
struct Slab {
    double value = 0.0, by_t = 0.0, by_half = 0.0;
};

// Whole slab |t| <= half.
Slab whole(double t, double half, double ramp) {
    const double up = (half - t) / ramp + 0.5, down = (half + t) / ramp + 0.5;
    const double su = smooth_step(up), sd = smooth_step(down);
    const double du = smooth_step_derivative(up) / ramp, dd = smooth_step_derivative(down) / ramp;
    return {su * sd, su * dd - du * sd, du * sd + su * dd};
}

// Part `part` of `parts` equal ones; the outermost are open towards outside, so that the parts always sum to 1.
Slab part_of(double t, double half, int part, int parts, double ramp) {
    Slab out;
    const auto add = [&](double sign, int boundary) {
        const double where = 2.0 * boundary / parts - 1.0, at = (t - where * half) / ramp + 0.5;
        const double slope = sign * smooth_step_derivative(at) / ramp;
        out.value += sign * smooth_step(at);
        out.by_t += slope, out.by_half -= where * slope;
    };
    if (part == 0) out.value = 1.0;
    if (part > 0) add(1.0, part);
    if (part < parts - 1) add(-1.0, part + 1);
    return out;
}

double outwards(ActuatorHalf half) {
    return half == ActuatorHalf::right ? -1.0 : 1.0;
}

}  // namespace

double ActuatorRegion::membership(const Vec3& x) const {
    const Vec3 offset = difference(x, point_.mean);
    double value = 1.0;
    for (std::size_t k = 0; k < 3; ++k) value *= whole(dot(point_.normal[k], offset), point_.half[k], ramp_).value;
    return value;
}

void ActuatorRegion::membership_pullback(const Vec3& x, double membership_bar, ActuatorBar& bar) const {
    const Vec3 offset = difference(x, point_.mean);
    Slab slab[3];
    for (std::size_t k = 0; k < 3; ++k) slab[k] = whole(dot(point_.normal[k], offset), point_.half[k], ramp_);
    for (std::size_t k = 0; k < 3; ++k) {
        const double others = membership_bar * slab[(k + 1) % 3].value * slab[(k + 2) % 3].value;
        bar.half[k] += others * slab[k].by_half;
        for (std::size_t j = 0; j < 3; ++j) {
            bar.mean[j] -= others * slab[k].by_t * point_.normal[k][j];
            bar.normal[k][j] += others * slab[k].by_t * offset[j];
        }
    }
}

double ActuatorRegion::group_share(const Vec3& x, ActuatorHalf half, int layers, int layer, int band) const {
    const Vec3 offset = difference(x, point_.mean);
    const double across = (dot(point_.normal[0], offset) + outwards(half) * dot(point_.normal[1], offset)) / kRoot2;
    return part_of(dot(point_.normal[2], offset), point_.half[2], layer, layers, ramp_).value *
           part_of(across, (point_.half[0] + point_.half[1]) / kRoot2, band, kBands, ramp_).value;
}

void ActuatorRegion::group_share_pullback(const Vec3& x, ActuatorHalf half, int layers, int layer, int band,
                                          double share_bar, ActuatorBar& bar) const {
    const Vec3 offset = difference(x, point_.mean);
    const double o = outwards(half);
    const double across = (dot(point_.normal[0], offset) + o * dot(point_.normal[1], offset)) / kRoot2;
    const Slab through = part_of(dot(point_.normal[2], offset), point_.half[2], layer, layers, ramp_);
    const Slab over = part_of(across, (point_.half[0] + point_.half[1]) / kRoot2, band, kBands, ramp_);
    const double t_bar[3] = {share_bar * through.value * over.by_t / kRoot2,
                             share_bar * through.value * over.by_t / kRoot2 * o, share_bar * over.value * through.by_t};
    bar.half[0] += share_bar * through.value * over.by_half / kRoot2;
    bar.half[1] += share_bar * through.value * over.by_half / kRoot2;
    bar.half[2] += share_bar * over.value * through.by_half;
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t j = 0; j < 3; ++j) {
            bar.mean[j] -= t_bar[k] * point_.normal[k][j];
            bar.normal[k][j] += t_bar[k] * offset[j];
        }
}

Vec3 fibre_direction(const ActuatorPoint& point, ActuatorHalf half) {
    Vec3 d;
    for (std::size_t j = 0; j < 3; ++j) d[j] = outwards(half) * point.edge[1][j] - point.edge[0][j];
    const double length = std::sqrt(dot(d, d));
    for (double& x : d) x /= length;
    return d;
}

void fibre_direction_pullback(const ActuatorPoint& point, ActuatorHalf half, const Vec3& direction_bar,
                              ActuatorBar& bar) {
    Vec3 d;
    for (std::size_t j = 0; j < 3; ++j) d[j] = outwards(half) * point.edge[1][j] - point.edge[0][j];
    const double length = std::sqrt(dot(d, d)), along = dot(d, direction_bar) / (length * length);
    for (std::size_t j = 0; j < 3; ++j) {
        const double d_bar = (direction_bar[j] - along * d[j]) / length;
        bar.edge[0][j] -= d_bar;
        bar.edge[1][j] += outwards(half) * d_bar;
    }
}

}  // namespace dqa
