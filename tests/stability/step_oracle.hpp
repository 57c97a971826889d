// SPDX-License-Identifier: MIT
// A second way to the answer of a time step, written without the library's stepper: the potential of the step from its
// parts (body, water, inertia), its Hessian by probing, and Newton's method with a direct solver whose matrix is
// shifted until it is positive definite and the step pays off (Levenberg-Marquardt; Nocedal & Wright 2006, ch. 4).
// Slow and sturdy, to the rounding of the arithmetic.
#pragma once

#include <utility>
#include <vector>

#include "linalg/sparse.hpp"
#include "motion/design.hpp"
#include "motion/state.hpp"

namespace stability {

using Vector = std::vector<double>;

// The equations of one step from `now` with `input`.
class StepProblem {
public:
    StepProblem(const dqa::Design& design, const dqa::State& now, const dqa::StepInput& input);

    struct Value {
        double energy = 0.0;
        double scale = 0.0;     // sum of the norms of the forces
        double residual = 0.0;  // of the gradient, relative to the scale
        double rounding = 0.0;  // residual that the rounding of positions makes
        Vector gradient;
        bool finite() const;
    };
    Value evaluate(const Vector& q);
    dqa::SymmetricMatrix hessian();  // at the last evaluation
    // Where the step's search starts by default: as if no force acted.
    const Vector& predicted() const { return predicted_; }
    const dqa::Design& design() const { return design_; }
    dqa::State state_of(const dqa::State& now, const Vector& q) const;

private:
    void product(const Vector& p, Vector& out);

    const dqa::Design& design_;
    Vector signals_, base_, inertial_, predicted_;
    double beta_;
    dqa::BodyWorkspace body_;
    dqa::WaterWorkspace water_;
    std::vector<std::vector<int>> colours_;  // nodes whose columns may be probed together
    dqa::SymmetricMatrix pattern_;           // of the Hessian, without values
};

struct Found {
    bool found = false;
    bool minimum = false;  // the Hessian is positive definite there
    double residual = 0.0;
    int iterations = 0;
    Vector q;
};

// A stationary point, downhill from a start; `found` where the forces balance to 1e-12 or to their rounding.
Found solve_step(StepProblem& problem, const Vector& start, int max_iterations);

}  // namespace stability
