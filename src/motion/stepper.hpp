// SPDX-License-Identifier: MIT
// One step of the time integrator and its adjoint.
//
// Step: q+ minimises  |q+ - y|_M^2 / (2 b^2) + E_body(q+, a) + D_water(q+; lagged state),  y = q~ + b v~,
// v+ = (q+ - q~) / b. Implicit Euler: q~ = q, v~ = v, b = h, lagged state (q, v). BDF2 (e.g. Hairer & Wanner, sec.
// V.1): q~ = (4 q - q_before) / 3, v~ alike, b = 2 h / 3, lagged state extrapolated: 2 q - q_before, 2 v - v_before.
// Newton's method with conjugate gradients (preconditioner.hpp) or with a direct solver; the exact Hessian, filtered
// only where it shows negative curvature. Or L-BFGS on the projective-dynamics factor (`projective`). Stops at
// |r| <= tolerance * (|f_elastic| + |f_muscle| + |f_inertia| + |f_water|), norms over nodes, but not above 1e4 times
// the share of the last two: independent of the origin and of rigid motion; and where the body as a whole is in balance
// too (rigid_balance.hpp), and the positions are known to be right to some tolerances (step_error.cpp). Constrained
// coordinates keep their place and drop out of all of it.
//
// Where that fails, another method takes over (rescue.cpp): another way to the same equations, so that the answer and
// its derivative mean the same; the report and a warning tell of it.
//
// The linear systems with the Hessian H of this are in step_system.cpp.
//
// Adjoint (step_adjoint.cpp): H(q+) lambda = q+_bar + v+_bar / b, then the cotangents of everything the residual
// depends on.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "grid/error.hpp"
#include "grid/node_gather.hpp"
#include "linalg/pcg.hpp"
#include "linalg/sparse.hpp"
#include "motion/design.hpp"
#include "motion/rigid_balance.hpp"
#include "motion/state.hpp"
#include "motion/step_kernels.hpp"

namespace dqa {

struct StepReport {
    int newton_iterations = 0;
    int linear_iterations = 0;
    int inverted = 0;       // Gauss points with det F <= 0 at the solution
    int filtered = 0;       // Newton iterations that needed the filtered Hessian
    int indefinite = 0;     // Newton iterations that met negative curvature
    bool rescued = false;   // the scene's method failed, and another one found the answer
    double residual = 0.0;  // relative
};

struct AdjointReport {
    int linear_iterations = 0;
    bool direct = false;  // the Krylov solve failed and a factorisation took over
    double residual = 0.0;
};

template <class T>
using NodeTerms = std::vector<NodeTerm<T>>;

class Stepper {
public:
    explicit Stepper(std::shared_ptr<const Design> design);

    const Design& design() const { return *design_; }

    // For the tolerance of the adjoints that follow; before, it is that of a single step.
    void expect_sweep(long n_steps) { sweep_ = n_steps; }

    // now -> next. step: index for messages. Throws NOT_CONVERGED or DIVERGED; next is then unspecified.
    StepReport step(const State& now, const StepInput& input, long step, State& next);
    // Hydrodynamic totals of the step just taken to `next`.
    WaterTotals totals(const State& next) const;

    // Pullback of step at its solution: next_bar gives out (overwritten) and bar (added to). next.before and
    // next_bar.before may be empty.
    AdjointReport adjoint(const State& now, const StepInput& input, const State& next, long step, const State& next_bar,
                          StepBar& out, DesignBar& bar);
    // The adjoints that follow start from the solution of the last one.
    void keep_solution() noexcept { start_.swap(lambda_); }
    // Pullback of the totals of a step to `next`: added to next_bar (q) and bar, the rest gives out (overwritten).
    void totals_pullback(const State& now, const StepInput& input, const State& next, const WaterTotals& totals_bar,
                         State& next_bar, StepBar& out, DesignBar& bar);

private:
    struct Evaluation {
        double energy = 0.0, residual = 0.0;
        double scale = 0.0, outer = 0.0;  // sums of the norms of all forces, and of inertia and water alone
        bool finite = true;
    };
    // step and adjoint inside the crew of their threads.
    StepReport solve(const State& now, const StepInput& input, long step, State& next);
    AdjointReport pull_back(const State& now, const StepInput& input, const State& next, long step,
                            const State& next_bar, StepBar& out, DesignBar& bar);
    void begin(const State& now, const StepInput& input);
    // Cotangents of what begin() made of the old state, back to it.
    void begin_pullback(const std::vector<double>& base_bar, const std::vector<double>& velocity_bar,
                        const std::vector<double>& lag_q_bar, const std::vector<double>& lag_v_bar, State& bar) const;
    Evaluation evaluate(const double* q_new, const double* signals);
    // f(begin, end) on chunks of the nodes' coordinates.
    template <class F>
    void on_coordinates(F&& f) const {
        parallel_chunks(threads_, design_->n_nodes(), kNodeGrain, [&](int begin, int end) {
            f(3 * static_cast<std::size_t>(begin), 3 * static_cast<std::size_t>(end));
        });
    }
    // free_coordinate_ as kernels take it.
    const double* free_or_null() const { return free_coordinate_.empty() ? nullptr : free_coordinate_.data(); }
    // body(chunk) or water(chunk) on all elements.
    template <class OnBody, class OnWater>
    void on_elements(OnBody&& body, OnWater&& water) const {
        const int of_body = design_->body().n_chunks();
        parallel_chunks(threads_, static_cast<int>(element_order_.size()), 1, [&](int place, int) {
            const int k = element_order_[static_cast<std::size_t>(place)];
            k < of_body ? body(k) : water(k - of_body);
        });
    }
    template <class T>
    double apply_hessian(const T* p, T* out);  // of the free coordinates, the identity on the others; p.out
    template <class T>
    double full_product(const T* p, T* out);  // of all coordinates; p.out
    // See StepKernels::direct.
    template <class T>
    double sum_products(const T* z, const double* free, T beta, T* p, T* ap);
    template <class T>
    double direct(const T* z, T beta, T* p, T* ap);  // PcgProducts::direct
    void precondition(const double* in, double* out);
    template <class T>
    PcgProducts<T> system();  // of both
    // H x = b, in mixed precision where the preconditioner is in single precision.
    PcgResult solve_hessian(const double* b, double* x, double tolerance, bool indefinite);
    // Numbers are known to one rounding; the stiffness turns it into a force that no iteration can remove.
    template <class T>
    double rounding_of(const T* x) const;
    template <class T>
    void mask(T* field) const;  // zero on the constrained coordinates
    double dot(const double* a, const double* b) const { return ordered_dot(a, b, size_, threads_); }
    SymmetricMatrix assemble();
    bool newton_direction(double forcing, StepReport& report);
    // Throws CANCELLED, or NOT_CONVERGED where the step has taken max_products.
    void check_limits(long step, const Evaluation& now, const StepReport& report) const;
    bool converged(const Evaluation& now) const;
    bool loose(const Evaluation& now) const;
    bool settled(std::vector<double>& x, Evaluation& now, const double* signals);
    bool balance(std::vector<double>& x, Evaluation& now, const double* signals);
    // Errors of positions, in the norm of the mass and over all nodes alike; see step_error.cpp.
    struct Allowed {
        double mass = 0.0, nodes = 0.0;
    };
    Allowed allowed_error(const std::vector<double>& q_old, const std::vector<double>& q_new) const;
    bool foreseen(const Allowed& allowed);
    bool small_correction(const Allowed& allowed) const;
    void locate(const std::vector<double>& q_old, std::vector<double>& x, Evaluation& now, const double* signals,
                long step, StepReport& report);
    // The way from a point along direction_: its motion of the body as a whole, and what is left of it.
    struct Path {
        std::unique_ptr<RigidBalance> whole;
        std::vector<double> motion, rest;
        bool turns = false;
    };
    Path path_along(const std::vector<double>& x);
    void move_along(const Path& path, const std::vector<double>& x, double t);
    PcgResult solve_adjoint(double tolerance);
    void balance_adjoint(const double* q, double tolerance);
    static double share_of_motion(const Evaluation& now);
    double target(const Evaluation& now, double tolerances = 1.0) const;
    double forcing(const Evaluation& now) const;
    double energy_noise(const std::vector<double>& x, const Evaluation& now) const;
    // The share of direction_ that was gone; 0 if none was found.
    double line_search(std::vector<double>& x, Evaluation& now, const double* signals);
    // From x down to the answer. They return what went wrong, null if nothing did.
    const char* descend_newton(std::vector<double>& x, Evaluation& now, const double* signals, long step,
                               StepReport& report);
    const char* descend_quasi_newton(std::vector<double>& x, Evaluation& now, const double* signals, long step,
                                     StepReport& report);
    bool descend_shifted(std::vector<double>& x, Evaluation& now, const double* signals, long step, int limit,
                         StepReport& report);
    double shifted_direction(double forcing, double shift, int limit, StepReport& report);
    void rescue(const State& before, std::vector<double>& x, Evaluation& now, const double* signals, long step,
                const char* why, StepReport& report);
    void check_unfolds(const State& before, long step) const;
    void check_explicit_water(const std::vector<double>& x, const Evaluation& now, const StepInput& input,
                              long step) const;
    [[noreturn]] void fail_step(Status status, long step, const std::string& why, const Evaluation& at) const;
    int worst_cell() const;

    std::shared_ptr<const Design> design_;
    const SceneSettings& scene_;
    RigidBalance::Free free_;
    std::vector<int> piece_;               // of each node
    int crew_;                             // number of threads of a call
    long sweep_ = 1;                       // steps of the backward sweep
    std::size_t size_;                     // 3 n_nodes
    double extent_;                        // of the body at rest (m)
    double energy_rounding_;               // of parts that cancel (J)
    std::vector<double> free_coordinate_;  // 1, or 0 where constrained; empty if all are free
    std::vector<int> element_order_;       // chunks of body and water, as loops over the elements take them
    Threads threads_{1};                   // of the call in progress
    BodyWorkspace body_;
    WaterWorkspace water_;
    PcgWorkspace krylov_;
    Preconditioner::Workspace preconditioner_;
    std::vector<double> y_, base_, gradient_, direction_, trial_, lambda_, start_;
    std::vector<double> lag_q_, lag_v_;  // lagged state; extrapolated in a two-step step
    std::vector<double> candidate_, right_;
    const StepKernels& kernels_;
    InBothPrecisions<NodeTerms> forces_;                 // of the elements: scratch of loops over the nodes
    InBothPrecisions<Numbers> masked_;                   // scratch of apply_hessian
    std::array<std::vector<double>, 2> preconditioned_;  // scratch of shifted_direction
    bool two_step_ = false;
    double beta_ = 0.0;                      // s
    double noise_ = 0.0;                     // rounding level of the residual norm
    static constexpr double kNoise = 200.0;  // residuals below this multiple of the rounding level may stagnate
};

}  // namespace dqa
