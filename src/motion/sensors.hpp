// SPDX-License-Identifier: MIT
// Head, centre and tail sensors: points of the rest body on a line parallel to x, read trilinearly from the nodes.
// Head and tail sit where the density profile along the line crosses half of its peak at the largest and smallest x.
#pragma once

#include <array>
#include <vector>

#include "grid/active_set.hpp"

namespace dqa {

// A material point and its trilinear weights.
struct MaterialPoint {
    std::array<int, 8> node{};  // active nodes
    std::array<double, 8> weight{};
    std::array<double, 8> weight_by_x{};  // d(weight)/d(rest x), 1/m
    Vec3 rest{};
};

// The point of rest position x in the nearest active cell: within `reach` cells along x and one across. Outside that
// cell it is clamped to it, or extrapolated.
MaterialPoint locate(const ActiveSet& set, const Vec3& x, int reach, bool extrapolate);

class Sensors {
public:
    Sensors() = default;
    // p_hat [n_box_cells]; axis: the line (y, z) in m. Throws ERROR_ARGUMENT if the line misses the body.
    Sensors(const ActiveSet& set, const std::vector<double>& p_hat, double axis_y, double axis_z);

    static constexpr int head = 0, centre = 1, tail = 2;
    const MaterialPoint& point(int which) const { return points_[static_cast<std::size_t>(which)]; }
    // Value of a nodal vector field at a sensor.
    Vec3 read(int which, const double* field) const;
    void read_pullback(int which, const Vec3& bar, double* field_bar) const;
    // Unit vector from tail to head, and its pullback onto q and the sensors' places (head_x_bar, tail_x_bar added to).
    Vec3 direction(const double* q) const;
    void direction_pullback(const double* q, const Vec3& bar, double* q_bar, double& head_x_bar,
                            double& tail_x_bar) const;
    // Adds the dependence of head and tail places on the density to p_hat_bar [n_box_cells].
    void place_pullback(double head_x_bar, double tail_x_bar, double* p_hat_bar) const;

private:
    struct Crossing {
        double x = 0.0;
        std::vector<std::pair<int, double>> by_density;  // (box cell, dx/dp_hat)
    };
    std::array<MaterialPoint, 3> points_;
    Crossing head_, tail_;
};

}  // namespace dqa
