// SPDX-License-Identifier: MIT
// Controllers: parameters theta and the map from sensors and time to actuation, with pullback. Time is the integer
// index of the step, so that a long rollout does not lose digits of it.
#pragma once

#include <memory>
#include <vector>

namespace dqa {

class Controller {
public:
    virtual ~Controller() = default;
    virtual std::unique_ptr<Controller> clone() const = 0;
    virtual int n_signals() const = 0;
    // Length of the sensor vector it reads; 0: none, the loop is open.
    virtual int n_sensors() const { return 0; }
    // Whether there is a pullback.
    virtual bool differentiable() const { return true; }
    // Whether both are the same map with the same parameters.
    virtual bool equals(const Controller& other) const = 0;
    virtual std::vector<double> parameters() const = 0;
    // Throws ERROR_ARGUMENT for values out of range; the old parameters then stay.
    virtual void set_parameters(const std::vector<double>& theta) = 0;
    // The same without the range check: finite differences step across the bounds of the admissible set.
    virtual void assign_parameters(const std::vector<double>& theta) = 0;
    // actuation [n_signals] of the step with this index, sensors [n_sensors] read at its start.
    virtual void evaluate(long step, const double* sensors, double* actuation) const = 0;
    // theta_bar [n_parameters] += (d actuation / d theta)^T actuation_bar, sensors_bar [n_sensors] likewise.
    virtual void pullback(long step, const double* sensors, const double* actuation_bar, double* theta_bar,
                          double* sensors_bar) const = 0;
};

// a sin(omega t + phi) per signal, t = step * time_step; theta [n_signals][3] = (a, omega rad/s, phi rad).
class Sinusoid : public Controller {
public:
    Sinusoid(int n_signals, double time_step);
    std::unique_ptr<Controller> clone() const override { return std::make_unique<Sinusoid>(*this); }
    int n_signals() const override { return static_cast<int>(theta_.size() / 3); }
    double time_step() const { return time_step_; }
    bool equals(const Controller& other) const override;
    std::vector<double> parameters() const override { return theta_; }
    void set_parameters(const std::vector<double>& theta) override;
    void assign_parameters(const std::vector<double>& theta) override { theta_ = theta; }
    void evaluate(long step, const double* sensors, double* actuation) const override;
    void pullback(long step, const double* sensors, const double* actuation_bar, double* theta_bar,
                  double* sensors_bar) const override;

private:
    double time_step_;
    std::vector<double> theta_;
};

}  // namespace dqa
