// SPDX-License-Identifier: MIT
// The caller's own controller: two functions, the second of which, the pullback, may be missing. The functions must
// depend on their arguments alone: the backward sweep calls the pullback for steps in reverse order.
#pragma once

#include <cstdint>

#include "control/controller.hpp"

namespace dqa {

// Both return 0, or anything else to stop. The pullback finds theta_bar and sensors_bar zeroed and writes the products
// of actuation_bar with the derivatives of actuation by theta and by sensors.
using EvaluateCallback = std::int32_t (*)(std::int64_t step, double time, const double* sensors, std::int64_t n_sensors,
                                          const double* theta, std::int64_t n_parameters, double* actuation,
                                          std::int64_t n_signals, void* user_data);
using PullbackCallback = std::int32_t (*)(std::int64_t step, double time, const double* sensors, std::int64_t n_sensors,
                                          const double* theta, std::int64_t n_parameters, const double* actuation_bar,
                                          std::int64_t n_signals, double* theta_bar, double* sensors_bar,
                                          void* user_data);

struct CallbackSettings {
    int n_signals = 1;
    int n_sensors = 0;  // 0: the loop is open
    double time_step = 1.0 / 30.0;
    EvaluateCallback evaluate = nullptr;
    PullbackCallback pullback = nullptr;  // may be null
    void* user_data = nullptr;

    bool operator==(const CallbackSettings&) const = default;
};

class CallbackController : public Controller {
public:
    CallbackController(const CallbackSettings& settings, std::vector<double> theta)
        : settings_(settings), theta_(std::move(theta)) {}
    const CallbackSettings& settings() const { return settings_; }
    std::unique_ptr<Controller> clone() const override { return std::make_unique<CallbackController>(*this); }
    int n_signals() const override { return settings_.n_signals; }
    int n_sensors() const override { return settings_.n_sensors; }
    bool differentiable() const override { return settings_.pullback != nullptr; }
    bool equals(const Controller& other) const override;
    std::vector<double> parameters() const override { return theta_; }
    void set_parameters(const std::vector<double>& theta) override;
    void assign_parameters(const std::vector<double>& theta) override { theta_ = theta; }
    // Both throw CANCELLED when the function returns other than 0, and ERROR_ARGUMENT for what is not a finite number
    // (an actuation: one in [-1, 1]).
    void evaluate(long step, const double* sensors, double* actuation) const override;
    void pullback(long step, const double* sensors, const double* actuation_bar, double* theta_bar,
                  double* sensors_bar) const override;

private:
    CallbackSettings settings_;
    std::vector<double> theta_;
};

}  // namespace dqa
