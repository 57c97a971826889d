// SPDX-License-Identifier: MIT
#include "motion/rigid_balance.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/pcg.hpp"

namespace dqa {
namespace {

constexpr double kConnecting = 0.05;  // occupancy of a cell that holds two parts together

Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

std::vector<int> pieces_of(const ActiveSet& set, const std::vector<double>& occupancy) {
    std::vector<int> piece(static_cast<std::size_t>(set.n_nodes()), -1);
    int count = 0;
    // Grows a piece from cell to cell through their nodes, first through the fuller cells alone.
    const auto grow = [&](std::vector<std::size_t> front, double least) {
        for (std::size_t at = 0; at < front.size(); ++at)
            for (int s = set.node_cell_start[front[at]]; s < set.node_cell_start[front[at] + 1]; ++s) {
                const std::size_t c = static_cast<std::size_t>(set.node_cells[static_cast<std::size_t>(s)]);
                if (occupancy[c] < least) continue;
                for (const int n : set.cell_nodes[c]) {
                    const std::size_t node = static_cast<std::size_t>(n);
                    if (piece[node] >= 0) continue;
                    piece[node] = piece[front[at]];
                    front.push_back(node);
                }
            }
    };
    const auto seed = [&](double least) {
        for (std::size_t c = 0; c < set.cell_nodes.size(); ++c) {
            const std::size_t node = static_cast<std::size_t>(set.cell_nodes[c][0]);
            if (occupancy[c] < least || piece[node] >= 0) continue;
            piece[node] = count++;
            grow({node}, least);
        }
    };
    seed(kConnecting);
    std::vector<std::size_t> all;
    for (std::size_t n = 0; n < piece.size(); ++n)
        if (piece[n] >= 0) all.push_back(n);
    grow(all, 0.0);
    seed(0.0);
    return piece;
}

RigidBalance::RigidBalance(Free free, const std::vector<double>& mass, const std::vector<int>& piece, const double* q)
    : piece_(piece) {
    if (free == Free::none) return;
    const int count = *std::max_element(piece.begin(), piece.end()) + 1;
    for (int k = 0; k < count; ++k) add_piece(free, static_cast<std::size_t>(k), mass, q);
}

void RigidBalance::add_piece(Free free, std::size_t index, const std::vector<double>& mass, const double* q) {
    double total = 0.0;
    Vec3 centre{};
    const auto inside = [&](std::size_t n) { return piece_[n] == static_cast<int>(index); };
    for (std::size_t n = 0; n < mass.size(); ++n) {
        if (!inside(n)) continue;
        total += mass[n];
        for (std::size_t k = 0; k < 3; ++k) centre[k] += mass[n] * q[3 * n + k];
    }
    for (double& c : centre) c /= total;
    centre_.push_back(centre);
    // Shifts along x, y, z, then turns about them.
    for (std::size_t k = 0; k < 6; ++k) {
        if (free == Free::plane && k != 0 && k != 1 && k != 5) continue;
        Motion m;
        m.piece = index;
        (k < 3 ? m.shift : m.turn)[k % 3] = 1.0;
        m.field.assign(3 * mass.size(), 0.0);
        for (std::size_t n = 0; n < mass.size(); ++n) {
            if (!inside(n)) continue;
            const Vec3 u =
                k < 3 ? m.shift
                      : cross(m.turn, {q[3 * n] - centre[0], q[3 * n + 1] - centre[1], q[3 * n + 2] - centre[2]});
            for (std::size_t a = 0; a < 3; ++a) m.field[3 * n + a] = u[a];
        }
        const auto mass_product = [&](const std::vector<double>& a, const std::vector<double>& b) {
            double s = 0.0;
            for (std::size_t i = 0; i < a.size(); ++i) s += mass[i / 3] * a[i] * b[i];
            return s;
        };
        const double before = mass_product(m.field, m.field);
        for (const Motion& other : motions_) {
            if (other.piece != index) continue;
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
    for (std::size_t index = 0; index < centre_.size(); ++index) {
        Vec3 shift{}, turn{};
        for (std::size_t k = 0; k < motions_.size(); ++k)
            for (std::size_t a = 0; a < 3 && motions_[k].piece == index; ++a) {
                shift[a] += coefficients[k] * motions_[k].shift[a];
                turn[a] += coefficients[k] * motions_[k].turn[a];
            }
        // Rodrigues' formula, with the sines in the form that is exact for small angles.
        const double angle = std::sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]);
        const double half = 0.5 * angle, sinc_half = half > 1e-8 ? std::sin(half) / half : 1.0;
        const double first = sinc_half * std::cos(half), second = 0.5 * sinc_half * sinc_half;
        const Vec3& c = centre_[index];
        for (std::size_t n = 0; n < piece_.size(); ++n) {
            if (piece_[n] != static_cast<int>(index)) continue;
            double* x = q + 3 * n;
            const Vec3 r{x[0] - c[0], x[1] - c[1], x[2] - c[2]};
            const Vec3 wr = cross(turn, r), wwr = cross(turn, wr);
            for (std::size_t a = 0; a < 3; ++a) x[a] += shift[a] + first * wr[a] + second * wwr[a];
        }
    }
}

}  // namespace dqa
