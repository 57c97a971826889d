// SPDX-License-Identifier: MIT
#include "motion/sensors.hpp"

#include <algorithm>
#include <cmath>

#include "grid/axis_line.hpp"
#include "grid/error.hpp"

namespace dqa {
MaterialPoint locate(const ActiveSet& set, const Vec3& x, int reach, bool extrapolate) {
    const Box& box = set.box;
    double g[3];
    int c[3];
    for (std::size_t k = 0; k < 3; ++k) {
        g[k] = x[k] / box.dx + 0.5 * box.cells[k];
        c[k] = std::clamp(static_cast<int>(std::floor(g[k])), 0, box.cells[k] - 1);
    }
    // On a face, edge or corner between cells the weights of the far nodes vanish, so any active neighbour that holds
    // the point serves; if none does, the nearest active cell along x holds its end (the derivative is then zero).
    int best[3] = {c[0], c[1], c[2]};
    double best_distance = 1e300;
    for (int i = std::max(0, c[0] - reach); i <= std::min(box.cells[0] - 1, c[0] + reach); ++i)
        for (int j = std::max(0, c[1] - 1); j <= std::min(box.cells[1] - 1, c[1] + 1); ++j)
            for (int k = std::max(0, c[2] - 1); k <= std::min(box.cells[2] - 1, c[2] + 1); ++k) {
                if (set.cell_to_active[static_cast<std::size_t>(box.cell(i, j, k))] < 0) continue;
                const int at[3] = {i, j, k};
                double distance = 0.0;
                for (int a = 0; a < 3; ++a) {
                    const double out = std::max({0.0, at[a] - g[a], g[a] - at[a] - 1.0});
                    distance += out * out;
                }
                if (distance < best_distance - 1e-14) best_distance = distance, best[0] = i, best[1] = j, best[2] = k;
            }
    if (best_distance > 1e299) fail(Status::ERROR_ARGUMENT, "no active cell near a material point");
    MaterialPoint p;
    p.rest = x;
    double t[3];
    for (int k = 0; k < 3; ++k) t[k] = extrapolate ? g[k] - best[k] : std::clamp(g[k] - best[k], 0.0, 1.0);
    const bool inside = extrapolate || (g[0] - best[0] >= 0.0 && g[0] - best[0] <= 1.0);
    const int active = set.cell_to_active[static_cast<std::size_t>(box.cell(best[0], best[1], best[2]))];
    for (int n = 0; n < 8; ++n) {
        const std::size_t s = static_cast<std::size_t>(n);
        const double wx = n >> 2 ? t[0] : 1 - t[0], wy = (n >> 1 & 1) ? t[1] : 1 - t[1], wz = (n & 1) ? t[2] : 1 - t[2];
        p.node[s] = set.cell_nodes[static_cast<std::size_t>(active)][s];
        p.weight[s] = wx * wy * wz;
        p.weight_by_x[s] = inside ? (n >> 2 ? 1.0 : -1.0) * wy * wz / box.dx : 0.0;
    }
    return p;
}

Sensors::Sensors(const ActiveSet& set, const std::vector<double>& p_hat, double axis_y, double axis_z) {
    const Box& box = set.box;
    const AxisLine line(box, axis_y, axis_z);
    const int nx = box.cells[0];
    std::vector<double> profile(static_cast<std::size_t>(nx), 0.0);
    for (int i = 0; i < nx; ++i) profile[static_cast<std::size_t>(i)] = line.value(p_hat.data(), i);
    const double top = *std::max_element(profile.begin(), profile.end());
    if (!(top > 0)) fail(Status::ERROR_ARGUMENT, "sensors: the sensor line misses the body");
    // Normally half of the peak; where the line runs through thin parts only, two thirds of its own maximum, so that a
    // design never loses its sensors.
    const double level = std::min(0.5, top * (2.0 / 3.0));
    const int top_at = static_cast<int>(std::max_element(profile.begin(), profile.end()) - profile.begin());
    const auto value = [&](int i) { return i < 0 || i >= nx ? 0.0 : profile[static_cast<std::size_t>(i)]; };
    const auto crossing = [&](int in, int out) {
        Crossing c;
        const double fi = value(in), fo = value(out), t = (fi - level) / (fi - fo);
        const double xi = (in + 0.5 - 0.5 * nx) * box.dx, xo = (out + 0.5 - 0.5 * nx) * box.dx;
        c.x = xi + t * (xo - xi);
        const double by_fi = (1.0 - t) / (fi - fo) * (xo - xi), by_fo = t / (fi - fo) * (xo - xi);
        line.for_each_cell(in, [&](int cell, double w) { c.by_density.emplace_back(cell, by_fi * w); });
        if (out >= 0 && out < nx)
            line.for_each_cell(out, [&](int cell, double w) { c.by_density.emplace_back(cell, by_fo * w); });
        if (level < 0.5)
            line.for_each_cell(top_at, [&](int cell, double w) {
                c.by_density.emplace_back(cell, -(2.0 / 3.0) * w * (xo - xi) / (fi - fo));
            });
        return c;
    };
    int first = 0, last = nx - 1;
    while (value(first) < level) ++first;
    while (value(last) < level) --last;
    head_ = crossing(last, last + 1);
    tail_ = crossing(first, first - 1);
    points_[head] = locate(set, {head_.x, axis_y, axis_z}, nx, false);
    points_[centre] = locate(set, {0.0, axis_y, axis_z}, nx, false);
    points_[tail] = locate(set, {tail_.x, axis_y, axis_z}, nx, false);
}

Vec3 Sensors::read(int which, const double* field) const {
    const MaterialPoint& p = point(which);
    Vec3 out{};
    for (std::size_t n = 0; n < 8; ++n)
        for (std::size_t k = 0; k < 3; ++k) out[k] += p.weight[n] * field[3 * static_cast<std::size_t>(p.node[n]) + k];
    return out;
}

void Sensors::read_pullback(int which, const Vec3& bar, double* field_bar) const {
    const MaterialPoint& p = point(which);
    for (std::size_t n = 0; n < 8; ++n)
        for (std::size_t k = 0; k < 3; ++k)
            field_bar[3 * static_cast<std::size_t>(p.node[n]) + k] += p.weight[n] * bar[k];
}

Vec3 Sensors::direction(const double* q) const {
    const Vec3 a = read(head, q), b = read(tail, q);
    Vec3 d{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + 1e-24);
    for (double& x : d) x /= length;
    return d;
}

void Sensors::direction_pullback(const double* q, const Vec3& bar, double* q_bar, double& head_x_bar,
                                 double& tail_x_bar) const {
    const Vec3 a = read(head, q), b = read(tail, q), s = direction(q);
    const double length = std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                                    (a[2] - b[2]) * (a[2] - b[2]) + 1e-24);
    const double along = s[0] * bar[0] + s[1] * bar[1] + s[2] * bar[2];
    Vec3 d_bar{}, minus{};
    for (std::size_t k = 0; k < 3; ++k) d_bar[k] = (bar[k] - s[k] * along) / length, minus[k] = -d_bar[k];
    read_pullback(head, d_bar, q_bar);
    read_pullback(tail, minus, q_bar);
    for (std::size_t n = 0; n < 8; ++n)
        for (std::size_t k = 0; k < 3; ++k) {
            const MaterialPoint &h = points_[head], &t = points_[tail];
            head_x_bar += h.weight_by_x[n] * q[3 * static_cast<std::size_t>(h.node[n]) + k] * d_bar[k];
            tail_x_bar -= t.weight_by_x[n] * q[3 * static_cast<std::size_t>(t.node[n]) + k] * d_bar[k];
        }
}

void Sensors::place_pullback(double head_x_bar, double tail_x_bar, double* p_hat_bar) const {
    for (const auto& [cell, d] : head_.by_density) p_hat_bar[cell] += head_x_bar * d;
    for (const auto& [cell, d] : tail_.by_density) p_hat_bar[cell] += tail_x_bar * d;
}

}  // namespace dqa
