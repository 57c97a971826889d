// SPDX-License-Identifier: MIT
#include "control/controller.hpp"

#include <cmath>

#include "grid/error.hpp"
#include "grid/number_text.hpp"

namespace dqa {
namespace {

constexpr double kMostTurns = 1e6;  // rad: beyond, a phase after many steps has no digits left, and then is no number

}  // namespace

Sinusoid::Sinusoid(int n_signals, double time_step) : time_step_(time_step) {
    // The paper's start: amplitude 1, a period of twelve steps, no phase.
    for (int k = 0; k < n_signals; ++k) {
        theta_.push_back(1.0);
        theta_.push_back(3.14159265358979323846 / (6.0 * time_step));
        theta_.push_back(0.0);
    }
}

void Sinusoid::set_parameters(const std::vector<double>& theta) {
    for (std::size_t k = 0; k < theta.size(); ++k) {
        if (!std::isfinite(theta[k]))
            fail(Status::ERROR_ARGUMENT, "theta[%zu] is %g, expected a finite number", k, theta[k]);
        if (k % 3 == 0 && (theta[k] < 0.0 || theta[k] > 1.0))
            fail(Status::ERROR_ARGUMENT, "theta[%zu] is %s, expected an amplitude in [0, 1]", k,
                 number_text(theta[k]).c_str());
        if (k % 3 == 1 && !(std::fabs(theta[k]) * time_step_ <= kMostTurns))
            fail(Status::ERROR_ARGUMENT, "theta[%zu] is %s, expected a frequency of at most %g rad a time step", k,
                 number_text(theta[k]).c_str(), kMostTurns);
        if (k % 3 == 2 && !(std::fabs(theta[k]) <= kMostTurns))
            fail(Status::ERROR_ARGUMENT, "theta[%zu] is %s, expected a phase within %g rad", k,
                 number_text(theta[k]).c_str(), kMostTurns);
    }
    theta_ = theta;
}

bool Sinusoid::equals(const Controller& other) const {
    const auto* o = dynamic_cast<const Sinusoid*>(&other);
    return o && o->time_step_ == time_step_ && o->theta_ == theta_;
}

void Sinusoid::evaluate(long step, const double*, double* actuation) const {
    const double t = static_cast<double>(step) * time_step_;
    for (std::size_t k = 0; k < theta_.size() / 3; ++k)
        actuation[k] = theta_[3 * k] * std::sin(theta_[3 * k + 1] * t + theta_[3 * k + 2]);
}

void Sinusoid::pullback(long step, const double*, const double* actuation_bar, double* theta_bar, double*) const {
    const double t = static_cast<double>(step) * time_step_;
    for (std::size_t k = 0; k < theta_.size() / 3; ++k) {
        const double phase = theta_[3 * k + 1] * t + theta_[3 * k + 2];
        const double slope = theta_[3 * k] * std::cos(phase) * actuation_bar[k];
        theta_bar[3 * k] += std::sin(phase) * actuation_bar[k];
        theta_bar[3 * k + 1] += t * slope;
        theta_bar[3 * k + 2] += slope;
    }
}

}  // namespace dqa
