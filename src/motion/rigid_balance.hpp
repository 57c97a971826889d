// SPDX-License-Identifier: MIT
// The balance of a body as a whole. Internal forces drop out of its six sums (three forces, three torques), but not out
// of the norm that a solver's residual is compared with: in a stiff body, or over a long step, they are so much larger
// than inertia and water that a residual of 1e-6 of them leaves the body's own motion uncertain by several per cent.
//
// The motions u_k = t_k + w_k x (x - c) are orthonormal in the mass, sum_n m_n u_k.u_l = delta_kl, so that a residual g
// leaves |U^T g| b^2 of rigid motion where the mass alone resists, M/b^2 u = -g; drag only makes it smaller.
#pragma once

#include <array>
#include <vector>

#include "grid/active_set.hpp"
#include "grid/parallel.hpp"

namespace dqa {

// The piece that each node belongs to, numbered from 0: parts of the body that hang together by more than nearly empty
// cells, with the nearly empty cells around them.
std::vector<int> pieces_of(const ActiveSet& set, const std::vector<double>& occupancy);

class RigidBalance {
public:
    // Which motions nothing holds: all, those in the plane of x and y, or, if nodes are fixed, none.
    enum class Free { space, plane, none };

    // Motions of masses [n_nodes] about positions q [n_nodes][3], six of each piece (or fewer, where it is on a line or
    // a point); piece [n_nodes] tells which one a node belongs to.
    RigidBalance(Free free, const std::vector<double>& mass, const std::vector<int>& piece, const double* q,
                 Threads threads = 1);

    std::size_t size() const { return motions_.size(); }
    std::vector<double> field(std::size_t k) const;  // u_k, [n_nodes][3]
    // U^T force.
    std::vector<double> sums(const double* force, Threads threads = 1) const;
    // |U^T force|.
    double norm_of(const double* force, Threads threads = 1) const;
    // Root of the sum over the motions of the square of their largest entry.
    double lever(Threads threads = 1) const;
    // The turn of sum_k c_k u_k (rad), the largest of the pieces.
    double turn_of(const std::vector<double>& coefficients) const;
    // out -= sum_k c_k u_k.
    void subtract(const std::vector<double>& coefficients, double* out) const;
    // q moved by sum_k c_k u_k, its turn as a true rotation: no strain comes of it.
    void move(const std::vector<double>& coefficients, double* q) const;

private:
    struct Motion {
        std::size_t piece = 0;
        Vec3 shift{}, turn{};
    };
    void add_piece(Free free, std::size_t index, double mass, const std::array<double, 6>& second);
    Vec3 at(const Motion& m, std::size_t node) const;
    // sum_k c_k of the shifts and the turns of a piece.
    std::array<Vec3, 2> motion_of(std::size_t piece, const std::vector<double>& coefficients) const;

    std::vector<int> piece_;
    std::vector<double> position_;  // [n_nodes][3]
    std::vector<Vec3> centre_;      // of each piece
    std::vector<Motion> motions_;
};

}  // namespace dqa
