// SPDX-License-Identifier: MIT
// Rows of the muscles: weights and directions of the fibres by what they are made of, and two winged bodies whose
// fibres turn with the weights.
#include "actuator_vector.hpp"
#include "table.hpp"
#include "winged_space.hpp"

namespace table {

using namespace dqa;

std::shared_ptr<const ShapeSpace> winged_space(Interpolation interpolation) {
    const std::array<int, 3> cells{14, 10, 6};
    const auto box = [](const Vec3& mean, const Vec3& half, const Vec3& euler) {
        Actuator a;
        a.mean = mean, a.euler = euler;
        for (std::size_t k = 0; k < 3; ++k) a.variance[k] = half[k] * half[k] / kTwoLn2;
        return a;
    };
    ShapeSettings s;
    s.cells = cells, s.cell_size = 0.06, s.sigma = 0.7, s.interpolation = interpolation;
    auto space = std::make_shared<ShapeSpace>(s);
    space->add_fractions("disc", fixtures::ellipsoid_fractions(cells, {5.5, 4.3, 1.9}).data());
    space->add_fractions("ball", fixtures::ellipsoid_fractions(cells, {4.4, 3.8, 2.3}, {0.5, 0, 0.2}).data());
    Actuator fins[] = {box({0.05, 0.13, 0}, {0.16, 0.12, 0.09}, {0.2, 0, 0.1}),
                       box({0.0, 0.11, 0.02}, {0.13, 0.13, 0.1}, {-0.1, 0.15, 0})};
    for (int base = 0; base < 2; ++base) {
        fins[base].kind = ActuatorKind::fins, fins[base].category = 1, fins[base].layers = 2;
        space->add_actuator(base, fins[base]);
        space->add_actuator(base, box({base ? -0.14 : -0.17, 0, 0}, {0.12, 0.11, 0.11}, {}));
    }
    space->build(nullptr);
    return space;
}

namespace {

// Weight and weight times direction of each fibre, by cell, signal and sign: fibres come and go, these do not.
constexpr std::size_t kNumbers = 4;

std::size_t place(const MuscleEntry& m, int n_signals) {
    return kNumbers * static_cast<std::size_t>(2 * (m.cell * n_signals + m.signal) + (m.sign > 0));
}

}  // namespace

void muscle_rows(Table& t) {
    for (const Interpolation way : {Interpolation::linear, Interpolation::bures}) {
        const auto space = winged_space(way);
        const ShapePoint at = space->evaluate({0.6, 0.4}, 1e-10, 1, nullptr);
        std::vector<char> mask;
        for (const double p : at.p_hat) mask.push_back(p > 0.1);
        const ActiveSet set = make_active_set(space->box(), mask);
        const std::size_t n = static_cast<std::size_t>(set.n_cells()), n_slots = space->slots().size();
        const auto point_of = [&](const Inputs& in) {
            ShapePoint p = at;
            for (std::size_t s = 0; s < n_slots; ++s)
                p.actuators[s] = actuator_of(
                    Vector(in[2].begin() + static_cast<long>(25 * s), in[2].begin() + static_cast<long>(25 * (s + 1))),
                    at.actuators[s]);
            return p;
        };
        derivative::Random random(5);
        Vector boxes;
        for (const ActuatorPoint& p : at.actuators)
            for (const double x : actuator_vector(p)) boxes.push_back(x);
        const std::vector<Field> fields{{"occupancy", random.vector(n, 0.2, 1.0), 0.1, true},
                                        {"stiffness of each cell", random.vector(n, 1.0, 3.0), 0.1, true},
                                        {"boxes of the actuators", boxes, 1e-4}};
        t.prove(
            way == Interpolation::linear ? "muscles of tail and fins, linear" : "muscles of tail and fins, Bures",
            fields,
            [&](const Inputs& in) {
                const Muscles muscles(*space, point_of(in), set, in[0], in[1]);
                Vector out(2 * kNumbers * n * static_cast<std::size_t>(space->n_signals()), 0.0);
                for (const MuscleEntry& m : muscles.entries()) {
                    double* to = &out[place(m, space->n_signals())];
                    to[0] += m.weight;
                    for (std::size_t k = 0; k < 3; ++k) to[1 + k] += m.weight * m.direction[k];
                }
                return out;
            },
            [&](const Inputs& in, const Vector& bar) {
                const ShapePoint p = point_of(in);
                const Muscles muscles(*space, p, set, in[0], in[1]);
                Vector weight_bar, occupancy_bar(n, 0.0), stiffness_bar(n, 0.0), boxes_bar;
                std::vector<Vec3> direction_bar;
                for (const MuscleEntry& m : muscles.entries()) {
                    const double* from = &bar[place(m, space->n_signals())];
                    weight_bar.push_back(from[0]);
                    direction_bar.emplace_back();
                    for (std::size_t k = 0; k < 3; ++k) {
                        weight_bar.back() += from[1 + k] * m.direction[k];
                        direction_bar.back()[k] = from[1 + k] * m.weight;
                    }
                }
                std::vector<ActuatorBar> actuators_bar(n_slots);
                muscles.pullback(*space, p, set, in[0], weight_bar, direction_bar, occupancy_bar, actuators_bar);
                muscles.stiffness_pullback(weight_bar, stiffness_bar);
                for (const ActuatorBar& b : actuators_bar)
                    for (const double x : actuator_vector(b)) boxes_bar.push_back(x);
                return Inputs{occupancy_bar, stiffness_bar, boxes_bar};
            });
    }
}

}  // namespace table
