// SPDX-License-Identifier: MIT
// A body with varied moduli and muscles, and short forms of its evaluation.
#pragma once

#include "motion_fixtures.hpp"

namespace fixtures {

// A body with a modulus of its own in every cell, and fibres in several directions, some cells with two.
struct Sample {
    ActiveSet set;
    Vector rest, mu, signals{0.3, -0.8};
    std::vector<MuscleEntry> muscles;

    explicit Sample(const std::array<int, 3>& cells, int n_muscles = 13, std::uint64_t seed = 1)
        : set(full_set(cells, 0.1)), rest(set.rest_positions()) {
        Random random{seed};
        for (int c = 0; c < set.n_cells(); ++c) mu.push_back(between(random, 0.2, 2.0) * 1e6);
        for (int e = 0; e < n_muscles; ++e) {
            MuscleEntry m;
            m.cell = (5 * e) % set.n_cells();
            m.signal = e % 2, m.sign = e % 3 ? 1.0 : -1.0;
            double n = 0.0;
            for (double& x : m.direction) x = random(), n += x * x;
            for (double& x : m.direction) x /= std::sqrt(n);
            m.weight = between(random, 0.5, 2.0) * 1e6;
            muscles.push_back(m);
        }
    }
    Body body(InstructionSet instructions = InstructionSet::automatic, Quadrature quadrature = Quadrature::full) const {
        return Body(set, {Material::corotated, mu, {}, quadrature}, muscles, 0.2, instructions);
    }
    // Rest state displaced at random by this part of a cell.
    Vector displaced(double part, std::uint64_t seed = 2) const {
        Random random{seed};
        return plus(rest, part * set.box.dx, random_vector(rest.size(), random));
    }
};

struct Result {
    double energy = 0.0;
    Vector elastic, muscle, total;
};

inline Result evaluate(const Body& body, BodyWorkspace& ws, const Vector& q, const Vector& signals, int threads = 1) {
    Result r;
    r.elastic.resize(q.size()), r.muscle.resize(q.size());
    r.energy = body.gradient(ws, q.data(), signals.data(), threads, r.elastic.data(), r.muscle.data());
    r.total = plus(r.elastic, 1.0, r.muscle);
    return r;
}

inline Vector product(const Body& body, BodyWorkspace& ws, const Vector& p, int threads = 1) {
    Vector out(p.size(), 0.0);
    body.product(ws, p.data(), threads, out.data());
    return out;
}

}  // namespace fixtures
