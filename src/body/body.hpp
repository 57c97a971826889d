// SPDX-License-Identifier: MIT
// The soft body: corotated elasticity with a modulus per cell, and contractile muscles; energies, forces,
// Hessian-vector products and the derivatives with respect to moduli, muscle weights and rest ratios.
#pragma once

#include <vector>

#include "body/kernels.hpp"
#include "grid/active_set.hpp"
#include "grid/parallel.hpp"

namespace dqa {

// Scratch of one evaluation point; belongs to the caller.
struct BodyWorkspace {
    std::vector<double> elastic_force, elastic_energy, elastic_cache;
    std::vector<double> muscle_force, muscle_energy, muscle_cache, muscle_rest;
    int inverted = 0;  // Gauss points with det F <= 0 at the last gradient
};

// One fibre group in one cell. Energy density weight/2 (|F m| - r)^2, r = 1 - sign * contraction * signal value.
struct MuscleEntry {
    int cell = 0;         // active cell
    int signal = 0;       // index of the actuation signal
    double sign = 1.0;    // +1: contracts for a positive signal, -1: its antagonist
    Vec3 direction{};     // unit, at rest
    double weight = 0.0;  // Pa
};

class Body {
public:
    // mu: shear modulus of each active cell (Pa).
    Body(const ActiveSet& set, const std::vector<double>& mu, const std::vector<MuscleEntry>& muscles,
         double contraction, InstructionSet instructions);

    const std::vector<MuscleEntry>& muscles() const { return muscles_; }
    int n_muscles() const { return static_cast<int>(muscles_.size()); }

    // Energy; elastic_out and muscle_out [n_nodes][3] are overwritten with dE/dq of each part. Fills the linearisation.
    double gradient(BodyWorkspace& ws, const double* q, const double* signals, Threads threads, double* elastic_out,
                    double* muscle_out) const;
    // out += H p at the last gradient.
    void product(BodyWorkspace& ws, const double* p, Threads threads, double* out) const;
    // Makes the linearisation positive semi-definite (fallback when curvature is negative): limits the rotation term
    // so that each Gauss point's twist stiffness is >= 0, and drops compressive transverse muscle stiffness.
    void filter(BodyWorkspace& ws) const;

    // Cotangents of lambda . dE/dq at q (the workspace holds the gradient there): mu_bar [n_cells],
    // weight_bar [n_muscles], signal_bar [n_signals]; all are added to.
    void parameter_pullback(BodyWorkspace& ws, const double* q, const double* lambda, Threads threads, double* mu_bar,
                            double* weight_bar, double* signal_bar) const;

private:
    double inv_dx_, slab_, gauss_volume_, contraction_;
    const BodyKernels& kernels_;
    std::vector<MuscleEntry> muscles_;
    BlockLayout cells_, entries_;
    std::vector<double> elastic_weight_;    // 2 mu V/8, blocked
    std::vector<double> muscle_weight_;     // weight V/8, blocked
    std::vector<double> muscle_direction_;  // [block][3][8]
};

}  // namespace dqa
