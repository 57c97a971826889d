// SPDX-License-Identifier: MIT
#include "motion/rigid_balance.hpp"

#include <cmath>

#include "linalg/pcg.hpp"

namespace dqa {
namespace {

Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

RigidBalance::RigidBalance(Free free, const std::vector<double>& mass, const double* q) {
    if (free == Free::none) return;
    double total = 0.0;
    for (std::size_t n = 0; n < mass.size(); ++n) {
        total += mass[n];
        for (std::size_t k = 0; k < 3; ++k) centre_[k] += mass[n] * q[3 * n + k];
    }
    for (double& c : centre_) c /= total;
    // Shifts along x, y, z, then turns about them.
    for (std::size_t k = 0; k < 6; ++k) {
        if (free == Free::plane && k != 0 && k != 1 && k != 5) continue;
        Motion m;
        (k < 3 ? m.shift : m.turn)[k % 3] = 1.0;
        m.field.resize(3 * mass.size());
        for (std::size_t n = 0; n < mass.size(); ++n) {
            const Vec3 u =
                k < 3 ? m.shift
                      : cross(m.turn, {q[3 * n] - centre_[0], q[3 * n + 1] - centre_[1], q[3 * n + 2] - centre_[2]});
            for (std::size_t a = 0; a < 3; ++a) m.field[3 * n + a] = u[a];
        }
        const auto mass_product = [&](const std::vector<double>& a, const std::vector<double>& b) {
            double s = 0.0;
            for (std::size_t i = 0; i < a.size(); ++i) s += mass[i / 3] * a[i] * b[i];
            return s;
        };
        const double before = mass_product(m.field, m.field);
        for (const Motion& other : motions_) {
            const double c = mass_product(m.field, other.field);
            for (std::size_t i = 0; i < m.field.size(); ++i) m.field[i] -= c * other.field[i];
            for (std::size_t a = 0; a < 3; ++a) m.shift[a] -= c * other.shift[a], m.turn[a] -= c * other.turn[a];
        }
        const double left = mass_product(m.field, m.field);
        if (!(left > 1e-12 * before)) continue;
        const double scale = 1.0 / std::sqrt(left);
        for (double& x : m.field) x *= scale;
        for (std::size_t a = 0; a < 3; ++a) m.shift[a] *= scale, m.turn[a] *= scale;
        motions_.push_back(std::move(m));
    }
}

std::vector<double> RigidBalance::sums(const double* force) const {
    std::vector<double> out;
    for (const Motion& m : motions_) out.push_back(ordered_dot(m.field.data(), force, m.field.size()));
    return out;
}

double RigidBalance::norm_of(const double* force) const {
    double s = 0.0;
    for (const double x : sums(force)) s += x * x;
    return std::sqrt(s);
}

void RigidBalance::move(const std::vector<double>& coefficients, double* q) const {
    if (motions_.empty()) return;
    Vec3 shift{}, turn{};
    for (std::size_t k = 0; k < motions_.size(); ++k)
        for (std::size_t a = 0; a < 3; ++a) {
            shift[a] += coefficients[k] * motions_[k].shift[a];
            turn[a] += coefficients[k] * motions_[k].turn[a];
        }
    // Rodrigues' formula, with the sines in the form that is exact for small angles.
    const double angle = std::sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]);
    const double half = 0.5 * angle, sinc_half = half > 1e-8 ? std::sin(half) / half : 1.0;
    const double first = sinc_half * std::cos(half), second = 0.5 * sinc_half * sinc_half;
    for (std::size_t i = 0; i < motions_[0].field.size(); i += 3) {
        const Vec3 r{q[i] - centre_[0], q[i + 1] - centre_[1], q[i + 2] - centre_[2]};
        const Vec3 wr = cross(turn, r), wwr = cross(turn, wr);
        for (std::size_t a = 0; a < 3; ++a) q[i + a] += shift[a] + first * wr[a] + second * wwr[a];
    }
}

}  // namespace dqa
