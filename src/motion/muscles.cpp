// SPDX-License-Identifier: MIT
#include "motion/muscles.hpp"

#include "shape/actuator_region.hpp"

namespace dqa {
namespace {

constexpr double kNegligibleMuscle = 1e-12;  // share below which a cell carries no fibre of a group

int n_groups(const ActuatorCategory& category) {
    return category.kind == ActuatorKind::caudal ? 2 : category.n_signals;
}

// Of a caudal muscle: independent of the actuator.
double caudal_side(int group, const Vec3& x, double dx) {
    return smooth_step((group == 0 ? x[1] : -x[1]) / dx + 0.5);
}

}  // namespace

Muscles::Muscles(const ShapeSpace& space, const ShapePoint& point, const ActiveSet& set,
                 const std::vector<double>& occupancy, const std::vector<double>& stiffness)
    : stiffness_(stiffness), fibres_turn_(space.fibres_turn()) {
    const Box& box = set.box;
    for (int s = 0; s < static_cast<int>(space.slots().size()); ++s) {
        const ActuatorSlot& slot = space.slots()[static_cast<std::size_t>(s)];
        const ActuatorCategory& category = space.categories()[static_cast<std::size_t>(slot.category)];
        const ActuatorPoint& actuator = point.actuators[static_cast<std::size_t>(s)];
        if (!(actuator.strength > 0)) continue;
        const bool caudal = category.kind == ActuatorKind::caudal;
        const ActuatorRegion region(actuator, box.dx);
        const Vec3 direction = caudal ? Vec3{1.0, 0.0, 0.0} : fibre_direction(actuator, slot.half);
        for (int a = 0; a < set.n_cells(); ++a) {
            const Vec3 x = box.cell_centre(set.cells[static_cast<std::size_t>(a)]);
            const double member = region.membership(x);
            if (member < kNegligibleMuscle) continue;
            for (int g = 0; g < n_groups(category); ++g) {
                const double share = caudal ? caudal_side(g, x, box.dx)
                                            : region.group_share(x, slot.half, category.layers, g / kBands, g % kBands);
                if (share < kNegligibleMuscle) continue;
                MuscleEntry m;
                m.cell = a;
                m.signal = category.first_signal + (caudal ? 0 : g);
                m.sign = caudal && g == 1 ? -1.0 : 1.0;
                m.direction = direction;
                const double of_stiffness = occupancy[static_cast<std::size_t>(a)] * member * share * actuator.strength;
                m.weight = stiffness[static_cast<std::size_t>(a)] * of_stiffness;
                entries_.push_back(m);
                origins_.push_back({s, g, of_stiffness});
            }
        }
    }
}

void Muscles::stiffness_pullback(const std::vector<double>& weight_bar, std::vector<double>& stiffness_bar) const {
    for (std::size_t e = 0; e < entries_.size(); ++e)
        stiffness_bar[static_cast<std::size_t>(entries_[e].cell)] += origins_[e].share * weight_bar[e];
}

void Muscles::pullback(const ShapeSpace& space, const ShapePoint& point, const ActiveSet& set,
                       const std::vector<double>& occupancy, const std::vector<double>& weight_bar,
                       const std::vector<Vec3>& direction_bar, std::vector<double>& occupancy_bar,
                       std::vector<ActuatorBar>& actuators_bar) const {
    const Box& box = set.box;
    std::vector<Vec3> slot_direction_bar(space.slots().size(), Vec3{});
    for (std::size_t e = 0; e < entries_.size(); ++e) {
        const std::size_t s = static_cast<std::size_t>(origins_[e].slot);
        const int g = origins_[e].group;
        const ActuatorSlot& slot = space.slots()[s];
        const ActuatorCategory& category = space.categories()[static_cast<std::size_t>(slot.category)];
        const ActuatorPoint& actuator = point.actuators[s];
        ActuatorBar& bar = actuators_bar[s];
        const bool caudal = category.kind == ActuatorKind::caudal;
        const ActuatorRegion region(actuator, box.dx);
        const std::size_t a = static_cast<std::size_t>(entries_[e].cell);
        const Vec3 x = box.cell_centre(set.cells[a]);
        const double member = region.membership(x);
        const double share = caudal ? caudal_side(g, x, box.dx)
                                    : region.group_share(x, slot.half, category.layers, g / kBands, g % kBands);
        const double scale = stiffness_[a] * weight_bar[e], g_strength = occupancy[a] * actuator.strength;
        occupancy_bar[a] += scale * member * share * actuator.strength;
        bar.strength += scale * member * share * occupancy[a];
        region.membership_pullback(x, scale * share * g_strength, bar);
        if (caudal) continue;
        region.group_share_pullback(x, slot.half, category.layers, g / kBands, g % kBands, scale * member * g_strength,
                                    bar);
        if (!direction_bar.empty())
            for (std::size_t k = 0; k < 3; ++k) slot_direction_bar[s][k] += direction_bar[e][k];
    }
    for (std::size_t s = 0; s < space.slots().size(); ++s)
        if (space.categories()[static_cast<std::size_t>(space.slots()[s].category)].kind == ActuatorKind::fins)
            fibre_direction_pullback(point.actuators[s], space.slots()[s].half, slot_direction_bar[s],
                                     actuators_bar[s]);
}

}  // namespace dqa
