// SPDX-License-Identifier: MIT
// A ragged body in water, for the tests of its forces.
#pragma once

#include "motion_fixtures.hpp"

namespace fixtures {

constexpr double kStep = 1.0 / 30.0;

// A ragged piece of body with random occupancy, displaced, in a current.
struct Sample {
    ActiveSet set;
    Vector occupancy, rest, q, v;
    Vec3 spine{0.8, 0.6, 0.0};
    WaterSettings settings;

    explicit Sample(const std::array<int, 3>& cells = {5, 4, 3}, std::uint64_t seed = 1) {
        Random random{seed};
        const Box box{cells, 0.1};
        std::vector<char> mask(static_cast<std::size_t>(box.n_cells()));
        for (char& m : mask) m = random() > -0.5;
        set = make_active_set(box, mask);
        for (int c = 0; c < set.n_cells(); ++c) occupancy.push_back(between(random, 0, 1));
        rest = set.rest_positions();
        q = plus(mapped(rest, random_rotation(random)), 0.02, random_vector(rest.size(), random));
        v = random_vector(rest.size(), random, 0.5);
        settings.current = {-0.3, 0.1, 0.2};
    }
    Water water() const { return Water(set, occupancy, settings); }
    // Gradient of the potential with respect to q_new.
    Vector gradient(const Vector& q_new, const Vector& q_old, const Vector& vel, const Vec3& s, const Vector& g) const {
        const Water w(set, g, settings);
        WaterWorkspace ws;
        w.lag(ws, q_old.data(), vel.data(), s, w.settings().current, 1);
        Vector out(q_old.size(), 0.0);
        w.gradient(ws, q_new.data(), q_old.data(), kStep, 1, out.data());
        return out;
    }
};

// The force is linear in density and ordinates: a direction in them, the settings moved along it, and the derivative
// that a pullback gives for it.
struct ParameterDirection {
    double density = 300.0;
    std::array<double, 4> drag{0.1, -0.3, 0.7, 0.4}, thrust{-0.5, 0.2, 0.6, -0.8};

    WaterSettings moved(const WaterSettings& from, double e) const {
        WaterSettings s = from;
        s.density += e * density;
        for (std::size_t k = 0; k < 4; ++k) s.drag[k] += e * drag[k], s.thrust[k] += e * thrust[k];
        return s;
    }
    double slope(const WaterParameterBar& bar) const {
        std::array<double, 4> drag_bar{}, thrust_bar{};
        WaterLaws::ordinates_pullback(bar.laws, drag_bar, thrust_bar);
        double sum = bar.density * density;
        for (std::size_t k = 0; k < 4; ++k) sum += drag_bar[k] * drag[k] + thrust_bar[k] * thrust[k];
        return sum;
    }
};

inline Vec3 cross_of(const Vec3& a, const Vec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double dot3(const Vec3& a, const Vec3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace fixtures
