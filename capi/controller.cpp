// SPDX-License-Identifier: MIT
// The controller's handle, and the stateless helpers for optimisers.
#include <cinttypes>

#include "internal.hpp"
#include "optimize/optimizer.hpp"

using namespace dqa::capi;
using dqa::fail;
using dqa::Status;

extern "C" {

dqa_status dqa_controller_create_sinusoid(int32_t n_signals, double time_step, dqa_controller** controller) {
    return guard([&] {
        begin_create(controller, "controller");
        require_range(n_signals, n_signals >= 1 && n_signals <= 4096, "n_signals", "a number in [1, 4096]");
        require_range(time_step, time_step > 0, "time_step", "a time > 0 (s)");
        auto made = std::make_unique<dqa_controller>();
        made->core = std::make_unique<dqa::Sinusoid>(n_signals, time_step);
        *controller = made.release();
    });
}

void dqa_controller_free(dqa_controller* controller) {
    delete controller;
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
        require(controller, "controller"), require(theta, "theta");
        require_count(n, static_cast<int64_t>(controller->core->parameters().size()), "n", "theta [n_parameters]");
        controller->core->set_parameters(std::vector<double>(theta, theta + n));
    });
}

dqa_status dqa_controller_evaluate(const dqa_controller* controller, int64_t step, double* actuation, int64_t n) {
    return guard([&] {
        require(controller, "controller"), require(actuation, "actuation");
        require_count(n, controller->core->n_signals(), "n", "actuation [n_signals]");
        if (step < 0) fail(Status::ERROR_ARGUMENT, "step is %" PRId64 ", expected an index >= 0", step);
        controller->core->evaluate(static_cast<long>(step), actuation);
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
        dqa::adam_step(x, gradient, rates, first_moment, second_moment, n, iteration);
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
