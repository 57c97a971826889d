// SPDX-License-Identifier: MIT
// The balance of the body as a whole within a step; see rigid_balance.hpp.
#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>
#include <limits>

#include "motion/rigid_balance.hpp"
#include "motion/stepper.hpp"

namespace dqa {
namespace {

constexpr double kRounding = 0.1;         // of the forces' rounding that is left in their sum over the body, at most
constexpr double kBalance = 1.0;          // tolerances of the way moved that a step leaves free in rigid motion
constexpr double kTurn = 1e-3;            // rad: smaller turns are as good as straight
constexpr double kAdjointBalance = 1e-2;  // adjoint tolerances of lambda that its rigid motion may be off

// Sums weighted by mass: of the squared way moved, and of the squared places.
struct Extent {
    double way2 = 0.0, places2 = 0.0;
    void operator+=(const Extent& o) { way2 += o.way2, places2 += o.places2; }
};

}  // namespace

// The forces on the nodes and those on the body as a whole are both in balance. Where only the latter are not, the body
// is moved as a whole, which leaves its internal forces as they are.
bool Stepper::settled(std::vector<double>& x, Evaluation& now, const double* signals) {
    return converged(now) && balance(x, now, signals);
}

bool Stepper::balance(std::vector<double>& x, Evaluation& now, const double* signals) {
    if (free_ == RigidBalance::Free::none) return true;
    const std::vector<double>& mass = design_->mass();
    const double b2 = beta_ * beta_;
    for (int k = 0; k < 4 && converged(now); ++k) {
        const RigidBalance whole(free_, mass, piece_, x.data(), threads_);
        const Extent e = parallel_total<Extent>(threads_, design_->n_nodes(), kNodeGrain, [&](int begin, int end) {
            Extent own;
            for (std::size_t i = 3 * static_cast<std::size_t>(begin); i < 3 * static_cast<std::size_t>(end); ++i) {
                own.way2 += mass[i / 3] * (x[i] - base_[i]) * (x[i] - base_[i]);
                own.places2 += mass[i / 3] * x[i] * x[i];
            }
            return own;
        });
        // Rounding of forces adds up over the lever, most of it to nothing: signs are mixed.
        const double allowed = kBalance * scene_.tolerance * std::sqrt(e.way2) +
                               std::numeric_limits<double>::epsilon() * std::sqrt(e.places2) +
                               kRounding * b2 * noise_ * whole.lever(threads_);
        const std::vector<double> sums = whole.sums(gradient_.data(), threads_);
        const double free = b2 * ordered_norm(sums.data(), sums.size());
        if (free <= allowed) return true;
        // Newton's step within the rigid motions.
        const Eigen::Index n = static_cast<Eigen::Index>(whole.size());
        Eigen::MatrixXd h(n, n);
        for (Eigen::Index m = 0; m < n; ++m) {
            apply_hessian(whole.field(static_cast<std::size_t>(m)).data(), trial_.data());
            const std::vector<double> column = whole.sums(trial_.data(), threads_);
            h.col(m) = Eigen::Map<const Eigen::VectorXd>(column.data(), n);
        }
        const Eigen::LLT<Eigen::MatrixXd> factor(0.5 * (h + h.transpose()));
        const Eigen::Map<const Eigen::VectorXd> right(sums.data(), n);
        const Eigen::VectorXd c =
            factor.info() == Eigen::Success ? Eigen::VectorXd(-factor.solve(right)) : Eigen::VectorXd(-b2 * right);
        candidate_ = x;
        whole.move({c.data(), c.data() + n}, candidate_.data());
        const Evaluation next = evaluate(candidate_.data(), signals);
        const bool better = next.finite && whole.norm_of(gradient_.data(), threads_) * b2 <= 0.5 * free;
        if (!better) {
            now = evaluate(x.data(), signals);
            return now.residual <= kNoise * noise_;  // the rounding of the positions
        }
        x.swap(candidate_);
        now = next;
    }
    return false;
}

// candidate_ <- x moved along direction_ by t of it. Where the body turns as a whole it does so truly: along the
// straight way, the first-order turn, it would be stretched by half the square of the angle, and where tissue is stiff
// beside inertia and water that is turned down until the steps are too short to arrive.
Stepper::Path Stepper::path_along(const std::vector<double>& x) {
    Path path;
    path.whole = std::make_unique<RigidBalance>(free_, design_->mass(), piece_, x.data(), threads_);
    if (path.whole->size() == 0) return path;
    on_coordinates([&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) trial_[i] = design_->mass()[i / 3] * direction_[i];
    });
    path.motion = path.whole->sums(trial_.data(), threads_);
    path.turns = path.whole->turn_of(path.motion) > kTurn;
    if (!path.turns) return path;
    path.rest = direction_;
    path.whole->subtract(path.motion, path.rest.data());
    return path;
}

void Stepper::move_along(const Path& path, const std::vector<double>& x, double t) {
    const std::vector<double>& straight = path.turns ? path.rest : direction_;
    on_coordinates([&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) candidate_[i] = x[i] + t * straight[i];
    });
    if (!path.turns) return;
    std::vector<double> part(path.motion);
    for (double& c : part) c *= t;
    path.whole->move(part, candidate_.data());
}

// Likewise of the adjoint system, whose residual r is in candidate_. What r leaves of rigid motion is a push that every
// step forgets: it adds up with the square of the number of steps, and a residual of 1e-8 leaves the gradient of a
// rollout of ten thousand steps uncertain by two per cent. The way out is d = b^2 U U^T r, Newton's step where the mass
// alone resists, as long as the best along it.
void Stepper::balance_adjoint(const double* q, double tolerance) {
    if (free_ == RigidBalance::Free::none) return;
    const std::vector<double>& mass = design_->mass();
    const RigidBalance whole(free_, mass, piece_, q, threads_);
    const double size2 = parallel_sum(threads_, design_->n_nodes(), kNodeGrain, [&](int begin, int end) {
        double sum = 0.0;
        for (std::size_t i = 3 * static_cast<std::size_t>(begin); i < 3 * static_cast<std::size_t>(end); ++i)
            sum += mass[i / 3] * lambda_[i] * lambda_[i];
        return sum;
    });
    const std::vector<double> sums = whole.sums(candidate_.data(), threads_);
    const double way = beta_ * beta_ * ordered_norm(sums.data(), sums.size());
    if (way <= kAdjointBalance * tolerance * std::sqrt(size2)) return;
    std::vector<double> d(size_, 0.0);
    for (std::size_t m = 0; m < sums.size(); ++m) {
        const std::vector<double> u = whole.field(m);
        for (std::size_t i = 0; i < size_; ++i) d[i] += beta_ * beta_ * sums[m] * u[i];
    }
    double slope = 0.0, curvature = 0.0;
    for (std::size_t i = 0; i < size_; ++i) slope += d[i] * candidate_[i];
    apply_hessian(d.data(), trial_.data());
    for (std::size_t i = 0; i < size_; ++i) curvature += d[i] * trial_[i];
    if (!(curvature > 0.0)) return;
    for (std::size_t i = 0; i < size_; ++i) lambda_[i] += slope / curvature * d[i];
}

}  // namespace dqa
