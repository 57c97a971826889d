// SPDX-License-Identifier: MIT
// The fibres of a design: one entry per active cell and fibre group, from the boxes of its actuators; and the way back
// from cotangents of their weights and directions to those of occupancy and actuators.
//
// weight = muscle stiffness * occupancy * membership * strength * share of the group. Caudal: two groups, left of the
// plane y = 0 (contracts for a positive signal) and right of it (its antagonist), fibres along x. Fins: the groups of
// actuator_region.hpp; all contract for a positive signal.
#pragma once

#include <vector>

#include "body/body.hpp"
#include "shape/shape_space.hpp"

namespace dqa {

class Muscles {
public:
    Muscles() = default;
    // occupancy and stiffness (Pa) [n_active_cells].
    Muscles(const ShapeSpace& space, const ShapePoint& point, const ActiveSet& set,
            const std::vector<double>& occupancy, const std::vector<double>& stiffness);

    const std::vector<MuscleEntry>& entries() const { return entries_; }
    // Whether directions depend on the weights alpha: only then are their cotangents of use.
    bool fibres_turn() const { return fibres_turn_; }

    // Adds to occupancy_bar [n_active_cells] and actuators_bar [n_slots]. direction_bar: [n_entries], or empty for
    // zero.
    void pullback(const ShapeSpace& space, const ShapePoint& point, const ActiveSet& set,
                  const std::vector<double>& occupancy, const std::vector<double>& weight_bar,
                  const std::vector<Vec3>& direction_bar, std::vector<double>& occupancy_bar,
                  std::vector<ActuatorBar>& actuators_bar) const;

    // Cotangents of the stiffness, added to [n_active_cells].
    void stiffness_pullback(const std::vector<double>& weight_bar, std::vector<double>& stiffness_bar) const;

private:
    struct Origin {
        int slot, group;
        double share;  // of the cell's stiffness
    };
    std::vector<double> stiffness_;
    bool fibres_turn_ = false;
    std::vector<MuscleEntry> entries_;
    std::vector<Origin> origins_;
};

}  // namespace dqa
