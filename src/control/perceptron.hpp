// SPDX-License-Identifier: MIT
// Closed-loop controller of DiffAqua (2021), section "Closed-Loop Controller": a multilayer perceptron with tanh after
// every layer, the output included, so that signals stay in (-1, 1). Its input is the sensor vector (5 dims numbers:
// see motion/observation.hpp) followed by the temporal encoding phi of the step index,
//   phi = sin(2^k pi tau), k = 0 ... 9, then cos(2^k pi tau), k = 0 ... 9,   tau = (step mod period) / period.
#pragma once

#include <cstdint>

#include "control/controller.hpp"

namespace dqa {

struct PerceptronSettings {
    int n_signals = 1;
    int dims = 3;
    std::vector<int> hidden{64, 64};  // neurons of the hidden layers
    bool temporal_encoding = true;
    int period_steps = 25;   // T / h
    std::uint64_t seed = 1;  // of the initial weights
    double scale = 1.0;      // factor on the initial weights

    bool operator==(const PerceptronSettings&) const = default;
};

class Perceptron : public Controller {
public:
    static constexpr int kFrequencies = 10;

    // Weights drawn from Xavier's uniform distribution (Glorot & Bengio 2010): +-scale sqrt(6 / (inputs + outputs)) of
    // each layer; biases 0. A counter-based generator gives the same bits everywhere.
    explicit Perceptron(const PerceptronSettings& settings);
    // Number of parameters of a perceptron with these settings.
    static std::size_t count(const PerceptronSettings& settings);

    const PerceptronSettings& settings() const { return settings_; }
    std::unique_ptr<Controller> clone() const override { return std::make_unique<Perceptron>(*this); }
    int n_signals() const override { return settings_.n_signals; }
    int n_sensors() const override { return 5 * settings_.dims; }
    bool equals(const Controller& other) const override;
    // Per layer: weights [outputs][inputs], then biases [outputs].
    std::vector<double> parameters() const override { return theta_; }
    void set_parameters(const std::vector<double>& theta) override;
    void assign_parameters(const std::vector<double>& theta) override { theta_ = theta; }
    void evaluate(long step, const double* sensors, double* actuation) const override;
    void pullback(long step, const double* sensors, const double* actuation_bar, double* theta_bar,
                  double* sensors_bar) const override;

private:
    // Outputs of all layers behind one another, the input first.
    std::vector<double> activations(long step, const double* sensors) const;

    PerceptronSettings settings_;
    std::vector<std::size_t> sizes_;  // of the layers, the input first
    std::vector<double> theta_;
};

}  // namespace dqa
