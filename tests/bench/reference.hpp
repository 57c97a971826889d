// SPDX-License-Identifier: MIT
// The yardstick of the benchmarks: textbook projective dynamics with Eigen alone, as the public code of DiffAqua (2021)
// runs it. Every cell of the box is simulated; the rotation of each Gauss point is that of a JacobiSVD; forward it is
// L-BFGS on Eigen::SimplicialLDLT of the scalar projective-dynamics matrix (Bouaziz et al. 2014, Liu et al. 2017);
// backward the quasi-Newton iteration of DiffPD (Du et al. 2021, sec. 4) on the same factor.
//
// The discrete problem is the library's: corotated elasticity, muscles, water with lagged coefficients, implicit Euler,
// threshold 0. Only what defines that problem is the library's own code (density, occupancy, fibres, places of the
// sensors, coefficient laws); kernels, factor, solvers and adjoint are not. Plain on purpose, not slow on purpose.
#pragma once

#include <array>
#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <vector>

#include "body/muscle_term.hpp"
#include "motion/scene.hpp"
#include "motion/sensors.hpp"
#include "shape/shape_space.hpp"
#include "water/laws.hpp"

namespace bench {

using Field = Eigen::Matrix3Xd;  // nodes of the full box, in the order of Box::node

struct FieldState {
    Field q, v;  // m, m/s
};

struct ReferenceReport {
    int iterations = 0;
    double residual = 0.0;  // relative, as the library measures it
};

class Reference {
public:
    // Of the scene: time step, Young's modulus, Poisson's ratio, densities, muscles, water, tolerances, max_linear.
    Reference(const dqa::ShapeSpace& space, const std::vector<double>& weights, const dqa::SceneSettings& scene);

    const Field& rest() const { return rest_; }
    const Eigen::VectorXd& mass() const { return mass_; }    // [n_nodes] kg
    const Eigen::VectorXd& spine() const { return spine_; }  // [n_nodes], sums to 1: weights of the travelled distance

    // Throw NOT_CONVERGED after max_linear iterations, where the line search is exhausted, or at negative curvature.
    ReferenceReport step(const FieldState& now, const std::vector<double>& signals, FieldState& next);
    // From next_bar to the cotangents of the old state (bar, overwritten) and of the actuation (added to signals_bar).
    ReferenceReport adjoint(const FieldState& now, const std::vector<double>& signals, const FieldState& next,
                            const FieldState& next_bar, FieldState& bar, std::vector<double>& signals_bar);

private:
    using Corners = Eigen::Matrix<double, 3, 8>;
    struct Face {
        std::array<int, 4> nodes{};  // counter-clockwise about the +axis
        double weight = 0.0;         // signed: > 0 if the low side is fuller
        // Lagged coefficients (N s/m, N s/m, N), unit normal and relative velocity of the step under way.
        double cd = 0.0, ct = 0.0, k = 0.0;
        Eigen::Vector3d n = Eigen::Vector3d::Zero(), u = Eigen::Vector3d::Zero();
    };
    struct Fibre {
        dqa::MuscleEntry entry;
        double rest = 1.0;  // commanded ratio
    };
    struct Turn {  // of a Gauss point: F = U diag(sigma) V^T, R = U V^T
        Eigen::Matrix3d u, v;
        Eigen::Vector3d sigma;
    };
    struct Evaluation {
        Field gradient;
        double energy = 0.0, residual = 0.0, scale = 0.0;
    };

    void make_faces();
    void make_factor();
    Corners gather(const Field& q, int cell) const;
    static Turn turn_of(const Eigen::Matrix3d& f);
    void begin(const FieldState& now, const std::vector<double>& signals);
    double add_elastic(const Field& q, Field& force) const;
    double add_muscle(const Field& q, Field& force) const;
    double add_water(const Field& q, Field& force) const;
    Evaluation evaluate(const Field& q) const;
    Field product(const Field& q, const Field& p);  // exact Hessian at q
    Field precondition(const Field& in) const;
    void water_pullback(const Field& lambda, const Field& q, FieldState& bar) const;

    dqa::SceneSettings scene_;
    dqa::ActiveSet set_;
    dqa::Sensors sensors_;
    dqa::WaterLaws laws_;
    double inv_dx_, gauss_volume_;
    Field rest_, y_;
    Eigen::VectorXd mass_, spine_, diagonal_;
    std::vector<double> occupancy_;
    std::array<Eigen::Matrix<double, 8, 3>, 8> shape_gradient_;  // at the Gauss points (1/m)
    std::vector<Face> faces_;
    std::vector<Fibre> fibres_;
    std::vector<Turn> turns_;  // [8 n_cells], of the last linearisation
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
    FieldState now_;
    Eigen::Vector3d spine_direction_;
    double noise_ = 0.0;  // rounding of the positions as a force
};

}  // namespace bench
