// SPDX-License-Identifier: MIT
// The controller's handle, and the stateless helpers for optimisers.
#include <cinttypes>

#include "control/callback.hpp"
#include "control/controller_file.hpp"
#include "control/perceptron.hpp"
#include "internal.hpp"
#include "optimize/optimizer.hpp"

using namespace dqa::capi;
using dqa::fail;
using dqa::Status;

namespace {

constexpr int32_t kMostHidden = 5;

dqa_mlp_options default_mlp() {
    const dqa::PerceptronSettings s;
    dqa_mlp_options o{};
    o.struct_size = sizeof o;
    o.n_signals = s.n_signals, o.dims = s.dims;
    o.n_hidden = static_cast<int32_t>(s.hidden.size());
    for (std::size_t k = 0; k < s.hidden.size(); ++k) o.hidden[k] = s.hidden[k];
    o.temporal_encoding = s.temporal_encoding ? 1 : 0;
    o.period_steps = s.period_steps;
    o.seed = s.seed;
    o.scale = s.scale;
    return o;
}

dqa_callback_controller_options default_callback() {
    const dqa::CallbackSettings s;
    dqa_callback_controller_options o{};
    o.struct_size = sizeof o;
    o.n_signals = s.n_signals, o.n_sensors = s.n_sensors;
    o.time_step = s.time_step;
    return o;
}

dqa::PerceptronSettings settings_from(const dqa_mlp_options& o) {
    require_range(o.flags, o.flags == 0, "flags", "0");
    require_range(o.n_signals, o.n_signals >= 1 && o.n_signals <= 4096, "n_signals", "a number in [1, 4096]");
    require_range(o.dims, o.dims == 2 || o.dims == 3, "dims", "2 or 3");
    require_range(o.n_hidden, o.n_hidden >= 0 && o.n_hidden <= kMostHidden, "n_hidden", "a number in [0, 5]");
    require_range(o.temporal_encoding, o.temporal_encoding == 0 || o.temporal_encoding == 1, "temporal_encoding",
                  "0 or 1");
    require_range(o.period_steps, o.period_steps >= 1 && o.period_steps <= 1 << 30, "period_steps",
                  "a number in [1, 2^30]");
    require_range(o.scale, o.scale >= 0, "scale", "a number >= 0");
    dqa::PerceptronSettings s;
    s.n_signals = o.n_signals, s.dims = o.dims;
    s.hidden.assign(o.hidden, o.hidden + o.n_hidden);
    for (const int n : s.hidden) require_range(n, n >= 1 && n <= 65536, "hidden", "numbers in [1, 65536]");
    s.temporal_encoding = o.temporal_encoding == 1;
    s.period_steps = o.period_steps;
    s.seed = o.seed, s.scale = o.scale;
    return s;
}

void give(std::unique_ptr<dqa::Controller> core, dqa_controller** controller) {
    auto made = std::make_unique<dqa_controller>();
    made->core = std::move(core);
    *controller = made.release();
}

}  // namespace

extern "C" {

dqa_status dqa_controller_create_sinusoid(int32_t n_signals, double time_step, dqa_controller** controller) {
    return guard([&] {
        begin_create(controller, "controller");
        require_range(n_signals, n_signals >= 1 && n_signals <= 4096, "n_signals", "a number in [1, 4096]");
        require_time_step(time_step);
        give(std::make_unique<dqa::Sinusoid>(n_signals, time_step), controller);
    });
}

dqa_status dqa_mlp_options_init(dqa_mlp_options* options, uint64_t size) {
    return guard([&] { init_options(options, size, default_mlp(), "options"); });
}

dqa_status dqa_controller_create_mlp(const dqa_mlp_options* options, dqa_controller** controller) {
    return guard([&] {
        begin_create(controller, "controller");
        const auto settings = settings_from(read_options(options, default_mlp(), "options"));
        give(std::make_unique<dqa::Perceptron>(settings), controller);
    });
}

dqa_status dqa_callback_controller_options_init(dqa_callback_controller_options* options, uint64_t size) {
    return guard([&] { init_options(options, size, default_callback(), "options"); });
}

dqa_status dqa_controller_create_callback(const dqa_callback_controller_options* options, const double* theta,
                                          int64_t n_parameters, dqa_controller** controller) {
    return guard([&] {
        begin_create(controller, "controller");
        const auto o = read_options(options, default_callback(), "options");
        require_range(o.flags, o.flags == 0, "flags", "0");
        require_range(o.n_signals, o.n_signals >= 1 && o.n_signals <= 4096, "n_signals", "a number in [1, 4096]");
        require_range(o.n_sensors, o.n_sensors == 0 || o.n_sensors == 10 || o.n_sensors == 15, "n_sensors",
                      "0 (an open loop), 10 (2-D) or 15 (3-D)");
        require_time_step(o.time_step);
        if (!o.evaluate) bad_null("evaluate");
        if (n_parameters < 0 || n_parameters > (int64_t{1} << 40))
            fail(Status::ERROR_ARGUMENT, "n_parameters is %" PRId64 ", expected a number >= 0", n_parameters);
        if (n_parameters > 0) require(theta, "theta"), require_finite(theta, n_parameters, "theta");
        dqa::CallbackSettings s;
        s.n_signals = o.n_signals, s.n_sensors = o.n_sensors, s.time_step = o.time_step;
        s.evaluate = o.evaluate, s.pullback = o.pullback, s.user_data = o.user_data;
        give(std::make_unique<dqa::CallbackController>(s, std::vector<double>(theta, theta + n_parameters)),
             controller);
    });
}

dqa_status dqa_controller_save(const dqa_controller* controller, const char* path) {
    return guard([&] {
        require(controller, "controller"), require(path, "path");
        dqa::save_controller(*controller->core, path);
    });
}

dqa_status dqa_controller_load(const char* path, dqa_controller** controller) {
    return guard([&] {
        begin_create(controller, "controller");
        require(path, "path");
        give(dqa::load_controller(path), controller);
    });
}

dqa_status dqa_controller_get_info(const dqa_controller* controller, dqa_controller_info* info, uint64_t size) {
    return guard([&] {
        require(controller, "controller");
        const dqa::Controller& c = *controller->core;
        dqa_controller_info i{};
        i.kind = DQA_CONTROLLER_CALLBACK;
        if (dynamic_cast<const dqa::Sinusoid*>(&c)) i.kind = DQA_CONTROLLER_SINUSOID;
        if (dynamic_cast<const dqa::Perceptron*>(&c)) i.kind = DQA_CONTROLLER_MLP;
        i.n_signals = c.n_signals(), i.n_sensors = c.n_sensors();
        i.has_pullback = c.differentiable() ? 1 : 0;
        i.n_parameters = static_cast<int64_t>(c.parameters().size());
        write_struct(info, size, i, "info");
    });
}

void dqa_controller_free(dqa_controller* controller) {
    free_handle(controller);
}

dqa_status dqa_controller_n_parameters(const dqa_controller* controller, int64_t* n) {
    return guard([&] {
        require(controller, "controller"), require(n, "n");
        *n = static_cast<int64_t>(controller->core->parameters().size());
    });
}

dqa_status dqa_controller_get_parameters(const dqa_controller* controller, double* theta, int64_t n) {
    return guard([&] {
        require(controller, "controller"), require(theta, "theta");
        const auto p = controller->core->parameters();
        copy_out(p.data(), p.size(), theta, n, "n", "theta [n_parameters]");
    });
}

dqa_status dqa_controller_set_parameters(dqa_controller* controller, const double* theta, int64_t n) {
    return guard([&] {
        const Change change(controller, "controller");
        require(theta, "theta");
        require_count(n, static_cast<int64_t>(controller->core->parameters().size()), "n", "theta [n_parameters]");
        controller->core->set_parameters(std::vector<double>(theta, theta + n));
    });
}

dqa_status dqa_controller_evaluate(const dqa_controller* controller, int64_t step, const double* sensors,
                                   int64_t n_sensors, double* actuation, int64_t n) {
    return guard([&] {
        require(controller, "controller"), require(actuation, "actuation");
        const Read reads(controller, "controller");
        const dqa::Controller& c = *controller->core;
        require_count(n, c.n_signals(), "n", "actuation [n_signals]");
        if (step < 0) fail(Status::ERROR_ARGUMENT, "step is %" PRId64 ", expected an index >= 0", step);
        if (c.n_sensors() > 0) {
            require(sensors, "sensors");
            require_count(n_sensors, c.n_sensors(), "n_sensors", "sensors, as dqa_simulator_sensors gives them");
            require_finite(sensors, n_sensors, "sensors");
        }
        // A failing callback leaves the caller's buffer alone.
        std::vector<double> out(static_cast<std::size_t>(n));
        c.evaluate(static_cast<long>(step), sensors, out.data());
        std::memcpy(actuation, out.data(), out.size() * sizeof out[0]);
    });
}

dqa_status dqa_adam_step(double* x, const double* gradient, const double* rates, double* first_moment,
                         double* second_moment, int64_t n, int64_t iteration) {
    return guard([&] {
        require(x, "x"), require(gradient, "gradient"), require(rates, "rates");
        require(first_moment, "first_moment"), require(second_moment, "second_moment");
        if (n < 1) fail(Status::ERROR_ARGUMENT, "n is %" PRId64 ", expected at least 1", n);
        if (iteration < 1) fail(Status::ERROR_ARGUMENT, "iteration is %" PRId64 ", expected a count from 1", iteration);
        require_finite(x, n, "x"), require_finite(gradient, n, "gradient"), require_finite(rates, n, "rates");
        require_finite(first_moment, n, "first_moment"), require_finite(second_moment, n, "second_moment");
        for (int64_t k = 0; k < n; ++k) {
            if (rates[k] < 0)
                fail(Status::ERROR_ARGUMENT, "rates[%" PRId64 "] is %g, expected a number >= 0", k, rates[k]);
            if (second_moment[k] < 0)
                fail(Status::ERROR_ARGUMENT, "second_moment[%" PRId64 "] is %g, expected a number >= 0", k,
                     second_moment[k]);
        }
        // On copies, so that nothing has changed where a square or a step is no number.
        std::vector<double> next(x, x + n), first(first_moment, first_moment + n),
            second(second_moment, second_moment + n);
        dqa::adam_step(next.data(), gradient, rates, first.data(), second.data(), n, iteration);
        for (int64_t k = 0; k < n; ++k) {
            const auto i = static_cast<std::size_t>(k);
            if (!std::isfinite(next[i]) || !std::isfinite(first[i]) || !std::isfinite(second[i]))
                fail(Status::DIVERGED,
                     "x[%" PRId64
                     "] = %g with gradient %g, rate %g and moments %g, %g: the step, or a moment after "
                     "it, is no finite number",
                     k, x[k], gradient[k], rates[k], first_moment[k], second_moment[k]);
        }
        std::copy(next.begin(), next.end(), x);
        std::copy(first.begin(), first.end(), first_moment);
        std::copy(second.begin(), second.end(), second_moment);
    });
}

dqa_status dqa_project_simplex(double* x, int64_t n) {
    return guard([&] {
        require(x, "x");
        if (n < 1) fail(Status::ERROR_ARGUMENT, "n is %" PRId64 ", expected at least 1", n);
        require_finite(x, n, "x");
        dqa::project_simplex(x, n);
    });
}

}  // extern "C"
