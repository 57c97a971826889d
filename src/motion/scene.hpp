// SPDX-License-Identifier: MIT
// Settings of a scene: material, water, time step, solver. SI units.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "body/body.hpp"
#include "grid/simd.hpp"
#include "linalg/packed_factor.hpp"
#include "water/water.hpp"

namespace dqa {

enum class Method : int { newton_pcg = 0, newton_direct = 1, projective = 2 };
enum class PreconditionerKind : int { multilevel = 0, factor = 1 };
enum class Integrator : int { implicit_euler = 0, bdf2 = 1 };

struct SceneSettings {
    int threads = 1;
    Method method = Method::newton_pcg;
    Material material = Material::corotated;
    Quadrature quadrature = Quadrature::reduced;
    Integrator integrator = Integrator::implicit_euler;
    bool water = true;
    bool planar = false;           // no motion along z
    std::vector<int> fixed_nodes;  // box nodes that keep their place; those not in the active set are ignored
    int max_newton = 50;
    int max_linear = 2000;
    std::int64_t max_products = 200000;  // with the Hessian, of a step
    InstructionSet instructions = InstructionSet::automatic;
    Precision precision = Precision::single_precision;  // of the iterations of linear solves
    PreconditionerKind preconditioner = PreconditionerKind::multilevel;
    double time_step = 1.0 / 30.0;  // s
    double young_modulus = 5e6;     // Pa
    double poisson_ratio = 0.45;
    double density = 1000.0;        // kg/m^3
    double muscle_stiffness = 2e6;  // Pa
    double contraction = 0.2;
    double threshold = 0.02;  // tau
    double occupancy_floor = 1e-10;
    double tolerance = 1e-6;
    double adjoint_tolerance = 0.0;  // 0: see adjoint_tolerance_over
    double shape_tolerance = 0.0;    // marginal error of the barycentre; 0: the space's own
    WaterSettings hydrodynamics;
    std::shared_ptr<std::atomic<int>> cancel;  // may be null; non-zero asks to stop

    // By cell of the box, in place of young_modulus and muscle_stiffness where not null (Pa, [n_box_cells]).
    std::shared_ptr<const std::vector<double>> young_of_cell, muscle_of_cell;

    // Tolerance of the linear solves of a backward sweep over n_steps: a third of that of the states, as in soft bodies
    // gradients by actuation lose a thousandfold of it. What adjoints leave unsolved adds up over the
    // steps: below the error that the states bring along up to some hundreds of them at their own tolerance, but to
    // 2e-3 of the gradient over ten thousand. As that of the states it is relative to what moves the body, whose share
    // of the forces is small in a stiff one. Not below what rounding allows: in the stiffest bodies, some 5e-8.
    double adjoint_tolerance_over(long n_steps, double share_of_motion = 1.0) const {
        if (adjoint_tolerance > 0.0) return adjoint_tolerance;
        const double length = std::min(1.0, 100.0 / static_cast<double>(n_steps));
        return std::max(1e-12, 0.3 * tolerance * length * std::max(0.1, share_of_motion));
    }

    // 1/b^2 of the integrator's step length b; see stepper.hpp.
    double inertia_factor() const {
        const double b = integrator == Integrator::bdf2 ? 2.0 / 3.0 * time_step : time_step;
        return 1.0 / (b * b);
    }
    double young(int box_cell) const {
        return young_of_cell ? (*young_of_cell)[static_cast<std::size_t>(box_cell)] : young_modulus;
    }
    double muscle(int box_cell) const {
        return muscle_of_cell ? (*muscle_of_cell)[static_cast<std::size_t>(box_cell)] : muscle_stiffness;
    }
    // Lame's parameters of Young's modulus 1, and their derivatives by Poisson's ratio.
    double unit_mu() const { return 1.0 / (2.0 * (1.0 + poisson_ratio)); }
    double unit_lambda() const { return poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio)); }
    double unit_mu_by_poisson() const { return -0.5 / ((1.0 + poisson_ratio) * (1.0 + poisson_ratio)); }
    double unit_lambda_by_poisson() const {
        const double d = (1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio);
        return (1.0 + 2.0 * poisson_ratio * poisson_ratio) / (d * d);
    }
};

}  // namespace dqa
