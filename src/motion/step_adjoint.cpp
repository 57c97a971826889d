// SPDX-License-Identifier: MIT
// What a step tells besides its state, and the way back through it; see stepper.hpp.
#include <algorithm>
#include <cmath>

#include "body/fibre_turn.hpp"
#include "grid/error.hpp"
#include "grid/log.hpp"
#include "motion/stepper.hpp"

namespace dqa {

WaterTotals Stepper::totals(const State& next) const {
    const Water* water = design_->water();
    WaterTotals out;
    if (water)
        with_crew(crew_,
                  [&](Threads threads) { out = water->totals(water_, next.q.data(), base_.data(), beta_, threads); });
    return out;
}

void Stepper::totals_pullback(const State& now, const StepInput& input, const State& next,
                              const WaterTotals& totals_bar, State& next_bar, StepBar& out, DesignBar& bar) {
    for (auto* field : {&out.state.q, &out.state.v}) field->assign(size_, 0.0);
    out.state.q_before.clear(), out.state.v_before.clear();
    out.signals.assign(static_cast<std::size_t>(design_->n_signals()), 0.0);
    out.current = {};
    const Water* water = design_->water();
    if (!water) return;
    std::vector<double> base_bar(size_, 0.0), lag_q_bar(size_, 0.0), lag_v_bar(size_, 0.0);
    Vec3 spine_bar{};
    with_crew(crew_, [&](Threads threads) {
        threads_ = threads;
        begin(now, input);
        water->totals_pullback(water_, next.q.data(), base_.data(), lag_q_.data(), totals_bar, beta_, threads_,
                               next_bar.q.data(), base_bar.data(), lag_q_bar.data(), lag_v_bar.data(), spine_bar,
                               out.current, bar.water, bar.occupancy.data());
    });
    design_->sensors().direction_pullback(lag_q_.data(), spine_bar, lag_q_bar.data(), bar.head_x, bar.tail_x);
    begin_pullback(base_bar, std::vector<double>(size_, 0.0), lag_q_bar, lag_v_bar, out.state);
}

void Stepper::begin_pullback(const std::vector<double>& base_bar, const std::vector<double>& velocity_bar,
                             const std::vector<double>& lag_q_bar, const std::vector<double>& lag_v_bar,
                             State& bar) const {
    if (two_step_) {
        bar.q_before.resize(size_), bar.v_before.resize(size_);
        for (std::size_t i = 0; i < size_; ++i) {
            bar.q[i] += 4.0 / 3.0 * base_bar[i] + 2.0 * lag_q_bar[i];
            bar.v[i] += 4.0 / 3.0 * velocity_bar[i] + 2.0 * lag_v_bar[i];
            bar.q_before[i] = -base_bar[i] / 3.0 - lag_q_bar[i];
            bar.v_before[i] = -velocity_bar[i] / 3.0 - lag_v_bar[i];
        }
    } else {
        for (std::size_t i = 0; i < size_; ++i) {
            bar.q[i] += base_bar[i] + lag_q_bar[i];
            bar.v[i] += velocity_bar[i] + lag_v_bar[i];
        }
    }
}

AdjointReport Stepper::adjoint(const State& now, const StepInput& input, const State& next, long step,
                               const State& next_bar, StepBar& out, DesignBar& bar) {
    AdjointReport report;
    for (auto* field : {&out.state.q, &out.state.v}) field->assign(size_, 0.0);
    out.state.q_before.clear(), out.state.v_before.clear();
    out.signals.assign(static_cast<std::size_t>(design_->n_signals()), 0.0);
    out.current = {};
    // What the new state keeps of the old one.
    for (std::size_t i = 0; i < next_bar.q_before.size(); ++i) out.state.q[i] += next_bar.q_before[i];
    for (std::size_t i = 0; i < next_bar.v_before.size(); ++i) out.state.v[i] += next_bar.v_before[i];
    if (ordered_norm(next_bar.q.data(), size_) == 0.0 && ordered_norm(next_bar.v.data(), size_) == 0.0) return report;
    with_crew(crew_, [&](Threads threads) {
        threads_ = threads;
        report = pull_back(now, input, next, step, next_bar, out, bar);
    });
    return report;
}

// lambda_ <- H^-1 right_, and candidate_ <- right_ - H lambda_. A sweep's systems resemble each other, as one step's
// cotangents are the next one's right-hand side: it starts from the multiple of the solution kept that is nearest to
// this one in the energy norm (a Galerkin projection, e.g. Saad 2003, sec. 5.1), and what is left is solved for to the
// same residual. That saves a tenth of the iterations of a slender body and a quarter of a broad one's.
PcgResult Stepper::solve_adjoint(double tolerance) {
    std::vector<double>&left = candidate_, &change = direction_;
    left.resize(size_);
    const double work = dot(right_.data(), start_.data());  // 0 before the first solution
    const double curvature = work != 0.0 ? apply_hessian(start_.data(), trial_.data()) : 0.0;
    const double along = curvature > 0.0 ? work / curvature : 0.0;
    const bool usable = along != 0.0 && std::isfinite(along);
    on_coordinates([&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            lambda_[i] = usable ? along * start_[i] : 0.0;
            left[i] = usable ? right_[i] - along * trial_[i] : right_[i];
        }
    });
    const double share = ordered_norm(left.data(), size_, threads_) / ordered_norm(right_.data(), size_, threads_);
    PcgResult result;
    result.relative_residual = share;
    result.converged = share <= tolerance;
    if (!result.converged) {
        result = solve_hessian(left.data(), change.data(), tolerance / share, true);
        result.relative_residual *= share;
        on_coordinates([&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) lambda_[i] += change[i];
        });
        if (result.left_residual) {
            left.swap(krylov_.exact.r);
        } else {
            apply_hessian(lambda_.data(), trial_.data());
            on_coordinates([&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) left[i] = right_[i] - trial_[i];
            });
        }
    }
    return result;
}

AdjointReport Stepper::pull_back(const State& now, const StepInput& input, const State& next, long step,
                                 const State& next_bar, StepBar& out, DesignBar& bar) {
    AdjointReport report;
    begin(now, input);
    const double* q_new = next.q.data();
    design_->preconditioner().turn(q_new, threads_, preconditioner_);
    const double tolerance = scene_.adjoint_tolerance_over(sweep_, share_of_motion(evaluate(q_new, input.signals)));
    // v+ = (q+ - q~) / b except on constrained coordinates, where it is zero.
    std::vector<double> base_bar(size_), total(size_);
    on_coordinates([&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const double free = free_coordinate_.empty() ? 1.0 : free_coordinate_[i];
            base_bar[i] = -free * next_bar.v[i] / beta_;
            total[i] = next_bar.q[i] - base_bar[i];
            right_[i] = free * total[i];
        }
    });
    const double* q_new_bar = right_.data();
    const auto residual_of = [&](const std::vector<double>& x) {
        apply_hessian(x.data(), trial_.data());
        for (std::size_t i = 0; i < size_; ++i) trial_[i] -= q_new_bar[i];
        return ordered_norm(trial_.data(), size_) / ordered_norm(q_new_bar, size_);
    };
    bool solved = ordered_norm(q_new_bar, size_) == 0.0;
    if (solved) std::fill(lambda_.begin(), lambda_.end(), 0.0);
    if (!solved && scene_.method != Method::newton_direct) {
        const PcgResult r = solve_adjoint(tolerance);
        report.linear_iterations = r.iterations;
        report.residual = r.relative_residual;
        solved = r.converged;
        if (solved) balance_adjoint(q_new, tolerance);
    }
    if (!solved) {
        if (scene_.method != Method::newton_direct)
            log_message(LogLevel::warning,
                        "adjoint of step %ld: conjugate gradients stopped at a relative residual of %.2g after %d "
                        "iterations; a factorisation takes over",
                        step, report.residual, report.linear_iterations);
        // The direct solve serves `newton_direct`, and Hessians on which conjugate gradients fail: at a state where the
        // exact Hessian is indefinite the step's derivative still exists.
        const SymmetricMatrix h = assemble();
        lambda_.assign(q_new_bar, q_new_bar + size_);
        bool good = solve_positive(h, lambda_);
        if (!good) {
            lambda_.assign(q_new_bar, q_new_bar + size_);
            good = solve_indefinite(h, lambda_);
        }
        report.direct = true;
        report.residual = good ? residual_of(lambda_) : 1.0;
        const double bound = std::max(1e-9, tolerance);
        if (!(report.residual <= bound))
            fail(Status::NOT_CONVERGED,
                 "adjoint of step %ld: relative residual %.3g, expected <= %.3g: the Hessian is singular there", step,
                 report.residual, bound);
    }
    // A constrained coordinate keeps its old place, through which the others feel it too.
    if (!design_->constrained().empty()) {
        full_product(lambda_.data(), trial_.data());
        for (const int c : design_->constrained()) {
            const std::size_t i = static_cast<std::size_t>(c);
            out.state.q[i] += total[i] - trial_[i];
        }
    }
    // r = M (q+ - q~ - b v~) / b^2 + ...: every cotangent is -(dr/d.)^T lambda.
    const double inv_b2 = 1.0 / (beta_ * beta_);
    std::vector<double> velocity_bar(size_), lag_q_bar(size_, 0.0), lag_v_bar(size_, 0.0);
    on_coordinates([&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const double m = design_->mass()[i / 3];
            base_bar[i] += m * inv_b2 * lambda_[i];
            velocity_bar[i] = m / beta_ * lambda_[i];
            bar.mass[i / 3] -= lambda_[i] * (q_new[i] - y_[i]) * inv_b2;
            lambda_[i] = -lambda_[i];
        }
    });
    design_->body().parameter_pullback(
        body_, q_new, lambda_.data(), threads_,
        {bar.mu.data(), bar.lambda.data(), bar.muscle_weight.data(), out.signals.data()});
    if (!bar.muscle_direction.empty())
        add_direction_bar(design_->set(), design_->body().muscles(), scene_.contraction, q_new, lambda_.data(),
                          input.signals, bar.muscle_direction);
    if (const Water* water = design_->water()) {
        Vec3 spine_bar{};
        water->pullback(water_, q_new, base_.data(), lag_q_.data(), lambda_.data(), beta_, threads_, base_bar.data(),
                        lag_q_bar.data(), lag_v_bar.data(), spine_bar, out.current, bar.water, bar.occupancy.data());
        design_->sensors().direction_pullback(lag_q_.data(), spine_bar, lag_q_bar.data(), bar.head_x, bar.tail_x);
    }
    begin_pullback(base_bar, velocity_bar, lag_q_bar, lag_v_bar, out.state);
    return report;
}

}  // namespace dqa
