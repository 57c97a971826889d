// SPDX-License-Identifier: MIT
#include "motion/rigid_balance.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/pcg.hpp"

namespace dqa {
namespace {

constexpr double kConnecting = 0.05;  // occupancy of a cell that holds two parts together

constexpr int kGrain = 512;  // nodes a chunk

// Up to six sums over the nodes of each piece.
struct ByPiece {
    using Sums = std::array<double, 6>;
    std::vector<Sums> sums;
    explicit ByPiece(std::size_t count = 0) : sums(count, Sums{}) {}
    void operator+=(const ByPiece& o) {
        if (sums.empty()) sums.resize(o.sums.size(), Sums{});
        for (std::size_t p = 0; p < sums.size(); ++p)
            for (std::size_t k = 0; k < 6; ++k) sums[p][k] += o.sums[p][k];
    }
};

struct Largest {
    std::vector<double> of;
    void operator+=(const Largest& o) {
        of.resize(o.of.size());
        for (std::size_t k = 0; k < of.size(); ++k) of[k] = std::max(of[k], o.of[k]);
    }
};

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

RigidBalance::RigidBalance(Free free, const std::vector<double>& mass, const std::vector<int>& piece, const double* q,
                           Threads threads)
    : piece_(piece) {
    if (free == Free::none) return;
    position_.assign(q, q + 3 * mass.size());
    const std::size_t count = static_cast<std::size_t>(*std::max_element(piece.begin(), piece.end())) + 1;
    // f(node, sums of its piece) over the nodes.
    const auto gather = [&](auto&& f) {
        return parallel_total<ByPiece>(threads, static_cast<int>(mass.size()), kGrain, [&](int begin, int end) {
            ByPiece own(count);
            for (std::size_t n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n)
                f(n, own.sums[static_cast<std::size_t>(piece[n])]);
            return own;
        });
    };
    const ByPiece first = gather([&](std::size_t n, ByPiece::Sums& s) {
        s[0] += mass[n];
        for (std::size_t k = 0; k < 3; ++k) s[1 + k] += mass[n] * q[3 * n + k];
    });
    for (const auto& s : first.sums) centre_.push_back({s[1] / s[0], s[2] / s[0], s[3] / s[0]});
    const ByPiece second = gather([&](std::size_t n, ByPiece::Sums& s) {
        const Vec3& c = centre_[static_cast<std::size_t>(piece[n])];
        const double x = q[3 * n] - c[0], y = q[3 * n + 1] - c[1], z = q[3 * n + 2] - c[2];
        const double product[6] = {x * x, y * y, z * z, x * y, x * z, y * z};
        for (std::size_t k = 0; k < 6; ++k) s[k] += mass[n] * product[k];
    });
    for (std::size_t k = 0; k < count; ++k) add_piece(free, k, first.sums[k][0], second.sums[k]);
}

// Shifts along x, y, z, then turns about them, orthogonal to one another in the piece's inertia; about the centre of
// mass, shifts and turns are so anyway.
void RigidBalance::add_piece(Free free, std::size_t index, double mass, const std::array<double, 6>& second) {
    for (std::size_t k = 0; k < 3; ++k) {
        if (free == Free::plane && k == 2) continue;
        Motion m;
        m.piece = index, m.shift[k] = 1.0 / std::sqrt(mass);
        motions_.push_back(m);
    }
    const auto [xx, yy, zz, xy, xz, yz] = second;
    const double inertia[3][3] = {{yy + zz, -xy, -xz}, {-xy, xx + zz, -yz}, {-xz, -yz, xx + yy}};
    const auto product = [&](const Vec3& a, const Vec3& b) {
        double s = 0.0;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) s += a[i] * inertia[i][j] * b[j];
        return s;
    };
    const std::size_t turns = motions_.size();
    for (std::size_t k = 0; k < 3; ++k) {
        if (free == Free::plane && k != 2) continue;
        Motion m;
        m.piece = index, m.turn[k] = 1.0;
        for (int round = 0; round < 2; ++round)  // twice: slender pieces cancel much
            for (std::size_t o = turns; o < motions_.size(); ++o) {
                const double c = product(m.turn, motions_[o].turn);
                for (std::size_t a = 0; a < 3; ++a) m.turn[a] -= c * motions_[o].turn[a];
            }
        const double left = product(m.turn, m.turn);
        if (!(left > 1e-12 * inertia[k][k])) continue;
        for (double& x : m.turn) x /= std::sqrt(left);
        motions_.push_back(m);
    }
}

Vec3 RigidBalance::at(const Motion& m, std::size_t n) const {
    const Vec3& c = centre_[m.piece];
    const double* x = position_.data() + 3 * n;
    const Vec3 u = cross(m.turn, {x[0] - c[0], x[1] - c[1], x[2] - c[2]});
    return {m.shift[0] + u[0], m.shift[1] + u[1], m.shift[2] + u[2]};
}

std::vector<double> RigidBalance::field(std::size_t k) const {
    std::vector<double> out(position_.size(), 0.0);
    for (std::size_t n = 0; n < piece_.size(); ++n) {
        if (piece_[n] != static_cast<int>(motions_[k].piece)) continue;
        const Vec3 u = at(motions_[k], n);
        std::copy(u.begin(), u.end(), out.begin() + static_cast<std::ptrdiff_t>(3 * n));
    }
    return out;
}

// By the force and the torque on each piece.
std::vector<double> RigidBalance::sums(const double* force, Threads threads) const {
    const ByPiece whole =
        parallel_total<ByPiece>(threads, static_cast<int>(position_.size() / 3), kGrain, [&](int begin, int end) {
            ByPiece own(centre_.size());
            for (std::size_t n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
                const std::size_t piece = static_cast<std::size_t>(piece_[n]);
                const Vec3& c = centre_[piece];
                const double *x = position_.data() + 3 * n, *f = force + 3 * n;
                const Vec3 torque = cross({x[0] - c[0], x[1] - c[1], x[2] - c[2]}, {f[0], f[1], f[2]});
                for (std::size_t a = 0; a < 3; ++a) own.sums[piece][a] += f[a], own.sums[piece][3 + a] += torque[a];
            }
            return own;
        });
    std::vector<double> out;
    for (const Motion& m : motions_) {
        double s = 0.0;
        for (std::size_t a = 0; a < 3; ++a)
            s += m.shift[a] * whole.sums[m.piece][a] + m.turn[a] * whole.sums[m.piece][3 + a];
        out.push_back(s);
    }
    return out;
}

double RigidBalance::norm_of(const double* force, Threads threads) const {
    double s = 0.0;
    for (const double x : sums(force, threads)) s += x * x;
    return std::sqrt(s);
}

double RigidBalance::lever(Threads threads) const {
    const int n_nodes = static_cast<int>(position_.size() / 3);
    const Largest longest = parallel_total<Largest>(threads, n_nodes, kGrain, [&](int begin, int end) {
        Largest own;
        own.of.resize(motions_.size());
        for (std::size_t n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n)
            for (std::size_t k = 0; k < motions_.size(); ++k) {
                if (piece_[n] != static_cast<int>(motions_[k].piece)) continue;
                for (const double u : at(motions_[k], n)) own.of[k] = std::max(own.of[k], std::fabs(u));
            }
        return own;
    });
    return ordered_norm(longest.of.data(), longest.of.size());
}

std::array<Vec3, 2> RigidBalance::motion_of(std::size_t piece, const std::vector<double>& coefficients) const {
    std::array<Vec3, 2> sum{};
    for (std::size_t k = 0; k < motions_.size(); ++k)
        for (std::size_t a = 0; a < 3 && motions_[k].piece == piece; ++a) {
            sum[0][a] += coefficients[k] * motions_[k].shift[a];
            sum[1][a] += coefficients[k] * motions_[k].turn[a];
        }
    return sum;
}

double RigidBalance::turn_of(const std::vector<double>& coefficients) const {
    double largest = 0.0;
    for (std::size_t index = 0; index < centre_.size(); ++index) {
        const Vec3 turn = motion_of(index, coefficients)[1];
        largest = std::max(largest, std::sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]));
    }
    return largest;
}

void RigidBalance::subtract(const std::vector<double>& coefficients, double* out) const {
    for (std::size_t index = 0; index < centre_.size(); ++index) {
        const auto [shift, turn] = motion_of(index, coefficients);
        const Motion whole{index, shift, turn};
        for (std::size_t n = 0; n < piece_.size(); ++n) {
            if (piece_[n] != static_cast<int>(index)) continue;
            const Vec3 u = at(whole, n);
            for (std::size_t a = 0; a < 3; ++a) out[3 * n + a] -= u[a];
        }
    }
}

void RigidBalance::move(const std::vector<double>& coefficients, double* q) const {
    for (std::size_t index = 0; index < centre_.size(); ++index) {
        const auto [shift, turn] = motion_of(index, coefficients);
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
