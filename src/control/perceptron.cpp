// SPDX-License-Identifier: MIT
#include "control/perceptron.hpp"

#include <cmath>

#include "grid/error.hpp"
#include "grid/random.hpp"

namespace dqa {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Of the layers, the input first.
std::vector<std::size_t> layer_sizes(const PerceptronSettings& settings) {
    std::vector<std::size_t> sizes;
    sizes.push_back(
        static_cast<std::size_t>(5 * settings.dims + (settings.temporal_encoding ? 2 * Perceptron::kFrequencies : 0)));
    for (const int n : settings.hidden) sizes.push_back(static_cast<std::size_t>(n));
    sizes.push_back(static_cast<std::size_t>(settings.n_signals));
    return sizes;
}

}  // namespace

std::size_t Perceptron::count(const PerceptronSettings& settings) {
    const std::vector<std::size_t> sizes = layer_sizes(settings);
    std::size_t n = 0;
    for (std::size_t layer = 0; layer + 1 < sizes.size(); ++layer) n += (sizes[layer] + 1) * sizes[layer + 1];
    return n;
}

Perceptron::Perceptron(const PerceptronSettings& settings) : settings_(settings), sizes_(layer_sizes(settings)) {
    theta_.reserve(count(settings));
    Random random{settings.seed};
    for (std::size_t layer = 0; layer + 1 < sizes_.size(); ++layer) {
        const std::size_t in = sizes_[layer], out = sizes_[layer + 1];
        const double limit = settings.scale * std::sqrt(6.0 / static_cast<double>(in + out));
        for (std::size_t k = 0; k < in * out; ++k) theta_.push_back(limit * random());
        theta_.insert(theta_.end(), out, 0.0);
    }
}

bool Perceptron::equals(const Controller& other) const {
    const auto* o = dynamic_cast<const Perceptron*>(&other);
    return o && o->settings_ == settings_ && o->theta_ == theta_;
}

void Perceptron::set_parameters(const std::vector<double>& theta) {
    for (std::size_t k = 0; k < theta.size(); ++k)
        if (!std::isfinite(theta[k]))
            fail(Status::ERROR_ARGUMENT, "theta[%zu] is %g, expected a finite number", k, theta[k]);
    theta_ = theta;
}

std::vector<double> Perceptron::activations(long step, const double* sensors) const {
    std::size_t total = 0;
    for (const std::size_t n : sizes_) total += n;
    std::vector<double> a(sensors, sensors + n_sensors());
    a.reserve(total);
    if (settings_.temporal_encoding) {
        const double tau = static_cast<double>(step % settings_.period_steps) / settings_.period_steps;
        for (int k = 0; k < kFrequencies; ++k) a.push_back(std::sin(std::ldexp(kPi * tau, k)));
        for (int k = 0; k < kFrequencies; ++k) a.push_back(std::cos(std::ldexp(kPi * tau, k)));
    }
    const double* w = theta_.data();
    std::size_t input = 0;
    for (std::size_t layer = 0; layer + 1 < sizes_.size(); ++layer) {
        const std::size_t in = sizes_[layer], out = sizes_[layer + 1];
        const double* bias = w + in * out;
        for (std::size_t i = 0; i < out; ++i) {
            double sum = bias[i];
            for (std::size_t j = 0; j < in; ++j) sum += w[in * i + j] * a[input + j];
            a.push_back(std::tanh(sum));
        }
        w = bias + out;
        input += in;
    }
    return a;
}

void Perceptron::evaluate(long step, const double* sensors, double* actuation) const {
    const std::vector<double> a = activations(step, sensors);
    // Weights and sensors near the largest numbers make infinities of both signs.
    for (auto at = a.end() - n_signals(); at != a.end(); ++at)
        if (!std::isfinite(*at))
            fail(Status::DIVERGED,
                 "the perceptron gives no number at step %ld: its parameters or its sensors are too large", step);
    std::copy(a.end() - n_signals(), a.end(), actuation);
}

void Perceptron::pullback(long step, const double* sensors, const double* actuation_bar, double* theta_bar,
                          double* sensors_bar) const {
    const std::vector<double> a = activations(step, sensors);
    std::vector<double> out_bar(actuation_bar, actuation_bar + n_signals()), in_bar;
    std::size_t output = a.size(), at = theta_.size();
    for (std::size_t layer = sizes_.size() - 1; layer-- > 0;) {
        const std::size_t in = sizes_[layer], out = sizes_[layer + 1];
        output -= out;
        at -= in * out + out;
        const double *w = theta_.data() + at, *input = a.data() + output - in;
        double *w_bar = theta_bar + at, *bias_bar = w_bar + in * out;
        in_bar.assign(in, 0.0);
        for (std::size_t i = 0; i < out; ++i) {
            const double y = a[output + i], sum_bar = out_bar[i] * (1.0 - y * y);
            bias_bar[i] += sum_bar;
            for (std::size_t j = 0; j < in; ++j) {
                w_bar[in * i + j] += sum_bar * input[j];
                in_bar[j] += sum_bar * w[in * i + j];
            }
        }
        out_bar.swap(in_bar);
    }
    for (std::size_t k = 0; k < static_cast<std::size_t>(n_sensors()); ++k) sensors_bar[k] += out_bar[k];
}

}  // namespace dqa
