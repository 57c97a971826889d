// SPDX-License-Identifier: MIT
// The balance of a body as a whole. Internal forces drop out of its six sums (three forces, three torques), but not out
// of the norm that a solver's residual is compared with: in a stiff body, or over a long step, they are so much larger
// than inertia and water that a residual of 1e-6 of them leaves the body's own motion uncertain by several per cent.
//
// The motions u_k = t_k + w_k x (x - c) are orthonormal in the mass, sum_n m_n u_k.u_l = delta_kl, so that a residual g
// leaves |U^T g| b^2 of rigid motion where the mass alone resists, M/b^2 u = -g; drag only makes it smaller.
#pragma once

#include <vector>

#include "grid/box.hpp"

namespace dqa {

class RigidBalance {
public:
    // Which motions nothing holds: all, those in the plane of x and y, or, if nodes are fixed, none.
    enum class Free { space, plane, none };

    // Motions of masses [n_nodes] about positions q [n_nodes][3]; fewer than six where these are on a line or a point.
    RigidBalance(Free free, const std::vector<double>& mass, const double* q);

    std::size_t size() const { return motions_.size(); }
    const std::vector<double>& field(std::size_t k) const { return motions_[k].field; }  // [n_nodes][3]
    // U^T force.
    std::vector<double> sums(const double* force) const;
    // |U^T force|.
    double norm_of(const double* force) const;
    // q moved by sum_k c_k u_k, its turn as a true rotation: no strain comes of it.
    void move(const std::vector<double>& coefficients, double* q) const;

private:
    struct Motion {
        Vec3 shift{}, turn{};
        std::vector<double> field;
    };
    Vec3 centre_{};
    std::vector<Motion> motions_;
};

}  // namespace dqa
