// SPDX-License-Identifier: MIT
#include "control/callback.hpp"

#include <cmath>

#include "grid/error.hpp"
#include "grid/number_text.hpp"

namespace dqa {
namespace {

void require_success(std::int32_t returned, const char* which, long step) {
    if (returned != 0)
        fail(Status::CANCELLED, "the controller's %s callback returned %d at step %ld, expected 0", which, returned,
             step);
}

// into += from, once all of it is known to be finite.
void add_finite(const std::vector<double>& from, const char* name, long step, double* into) {
    for (std::size_t k = 0; k < from.size(); ++k)
        if (!std::isfinite(from[k]))
            fail(Status::ERROR_ARGUMENT,
                 "the controller's pullback callback gave %s[%zu] = %g at step %ld, expected a finite number", name, k,
                 from[k], step);
    for (std::size_t k = 0; k < from.size(); ++k) into[k] += from[k];
}

}  // namespace

bool CallbackController::equals(const Controller& other) const {
    const auto* o = dynamic_cast<const CallbackController*>(&other);
    return o && o->settings_ == settings_ && o->theta_ == theta_;
}

void CallbackController::set_parameters(const std::vector<double>& theta) {
    for (std::size_t k = 0; k < theta.size(); ++k)
        if (!std::isfinite(theta[k]))
            fail(Status::ERROR_ARGUMENT, "theta[%zu] is %g, expected a finite number", k, theta[k]);
    theta_ = theta;
}

void CallbackController::evaluate(long step, const double* sensors, double* actuation) const {
    // What the function does not write is found out as well.
    for (int k = 0; k < settings_.n_signals; ++k) actuation[k] = std::nan("");
    require_success(settings_.evaluate(step, static_cast<double>(step) * settings_.time_step,
                                       settings_.n_sensors > 0 ? sensors : nullptr, settings_.n_sensors, theta_.data(),
                                       static_cast<std::int64_t>(theta_.size()), actuation, settings_.n_signals,
                                       settings_.user_data),
                    "evaluate", step);
    for (int k = 0; k < settings_.n_signals; ++k)
        if (!(actuation[k] >= -1.0 && actuation[k] <= 1.0))
            fail(Status::ERROR_ARGUMENT,
                 "the controller's evaluate callback gave actuation[%d] = %s at step %ld, expected a number in [-1, 1]",
                 k, number_text(actuation[k]).c_str(), step);
}

void CallbackController::pullback(long step, const double* sensors, const double* actuation_bar, double* theta_bar,
                                  double* sensors_bar) const {
    if (!settings_.pullback)
        fail(Status::ERROR_STATE, "the controller has no pullback callback: its gradient does not exist");
    std::vector<double> by_theta(theta_.size(), 0.0), by_sensors(static_cast<std::size_t>(settings_.n_sensors), 0.0);
    require_success(settings_.pullback(step, static_cast<double>(step) * settings_.time_step,
                                       settings_.n_sensors > 0 ? sensors : nullptr, settings_.n_sensors, theta_.data(),
                                       static_cast<std::int64_t>(theta_.size()), actuation_bar, settings_.n_signals,
                                       by_theta.data(), by_sensors.data(), settings_.user_data),
                    "pullback", step);
    add_finite(by_theta, "theta_bar", step, theta_bar);
    add_finite(by_sensors, "sensors_bar", step, sensors_bar);
}

}  // namespace dqa
