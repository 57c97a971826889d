// SPDX-License-Identifier: MIT
// One implicit Euler step and its adjoint.
//
// Step: q+ minimises  |q+ - y|_M^2 / (2 h^2) + E_body(q+, a) + D_water(q+; q, v),  y = q + h v;  v+ = (q+ - q) / h.
// Newton's method with conjugate gradients preconditioned by the projective-dynamics factor; the exact Hessian,
// filtered only where it shows negative curvature. Stops at |r| <= tolerance * (|f_elastic| + |f_muscle| + |f_inertia|
// + |f_water|), norms over nodes: independent of the origin and of rigid motion.
//
// Adjoint: H(q+) lambda = q+_bar + v+_bar / h, then the cotangents of everything the residual depends on.
#pragma once

#include <memory>
#include <vector>

#include "grid/error.hpp"
#include "linalg/pcg.hpp"
#include "linalg/sparse.hpp"
#include "motion/design.hpp"

namespace dqa {

struct StepReport {
    int newton_iterations = 0;
    int linear_iterations = 0;
    int inverted = 0;       // Gauss points with det F <= 0 at the solution
    int filtered = 0;       // Newton iterations that needed the filtered Hessian
    double residual = 0.0;  // relative
};

struct AdjointReport {
    int linear_iterations = 0;
    bool direct = false;  // the Krylov solve failed and a factorisation took over
    double residual = 0.0;
};

class Stepper {
public:
    explicit Stepper(std::shared_ptr<const Design> design);

    const Design& design() const { return *design_; }

    // q, v -> q_new [n_nodes][3]; signals [n_signals]. step: index for messages. Throws NOT_CONVERGED or DIVERGED.
    StepReport step(const double* q, const double* v, const double* signals, long step, double* q_new);
    // Hydrodynamic totals of the step just taken.
    WaterTotals totals(const double* q, const double* q_new) const;

    // Pullback of step at a solution q_new: q_new_bar (the sum q+_bar + v+_bar / h) gives q_bar, v_bar (added to),
    // signal_bar (added to) and bar (added to). The term -v+_bar/h of q_bar is the caller's.
    AdjointReport adjoint(const double* q, const double* v, const double* signals, const double* q_new, long step,
                          const double* q_new_bar, double* q_bar, double* v_bar, double* signal_bar, DesignBar& bar);

private:
    struct Evaluation {
        double energy = 0.0, residual = 0.0, scale = 0.0;
        bool finite = true;
    };
    // step and adjoint inside the crew of their threads.
    StepReport solve(const double* q, const double* v, const double* signals, long step, double* q_new);
    AdjointReport pull_back(const double* q, const double* v, const double* signals, const double* q_new, long step,
                            const double* q_new_bar, double* q_bar, double* v_bar, double* signal_bar, DesignBar& bar);
    void begin(const double* q, const double* v);
    Evaluation evaluate(const double* q_new, const double* signals);
    void apply_hessian(const double* p, double* out);
    SymmetricMatrix assemble();
    bool newton_direction(double forcing, StepReport& report, bool* truncated);
    [[noreturn]] void fail_step(Status status, long step, const char* why, double relative) const;
    int worst_cell() const;

    std::shared_ptr<const Design> design_;
    const SceneSettings& scene_;
    std::size_t size_;    // 3 n_nodes
    Threads threads_{1};  // of the call in progress
    BodyWorkspace body_;
    WaterWorkspace water_;
    PcgWorkspace krylov_;
    PackedFactor::Workspace factor_;
    std::vector<double> y_, q_old_, gradient_, elastic_, muscle_, direction_, trial_, lambda_;
    double noise_ = 0.0;  // rounding level of the residual norm
};

}  // namespace dqa
