// SPDX-License-Identifier: MIT
// Settings of a scene: material, water, time step, solver. SI units.
#pragma once

#include <atomic>
#include <cmath>
#include <memory>
#include <vector>

#include "body/body.hpp"
#include "grid/simd.hpp"
#include "water/water.hpp"

namespace dqa {

enum class Method : int { newton_pcg = 0, newton_direct = 1, projective = 2 };
enum class Integrator : int { implicit_euler = 0, bdf2 = 1 };

struct SceneSettings {
    int threads = 1;
    Method method = Method::newton_pcg;
    Material material = Material::corotated;
    Integrator integrator = Integrator::implicit_euler;
    bool water = true;
    bool planar = false;           // no motion along z
    std::vector<int> fixed_nodes;  // box nodes that keep their place; those not in the active set are ignored
    int max_newton = 50;
    int max_linear = 2000;
    InstructionSet instructions = InstructionSet::automatic;
    double time_step = 1.0 / 30.0;  // s
    double young_modulus = 5e6;     // Pa
    double poisson_ratio = 0.45;
    double density = 1000.0;        // kg/m^3
    double muscle_stiffness = 2e6;  // Pa
    double contraction = 0.2;
    double threshold = 0.02;  // tau
    double occupancy_floor = 1e-10;
    double tolerance = 1e-6;
    double adjoint_tolerance = 1e-8;
    double shape_tolerance = 0.0;  // marginal error of the barycentre; 0: the space's own
    WaterSettings hydrodynamics;
    std::shared_ptr<std::atomic<int>> cancel;  // may be null; non-zero asks to stop

    double lame_mu() const { return young_modulus / (2.0 * (1.0 + poisson_ratio)); }
    double lame_lambda() const {
        return young_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
    }
};

}  // namespace dqa
