// SPDX-License-Identifier: MIT
// Status, last error, version, logs, cancel tokens; the exception barrier and the checks of the other files.
#include <array>
#include <cinttypes>
#include <cstdio>
#include <new>

#include "grid/log.hpp"
#include "grid/number_text.hpp"
#include "internal.hpp"
#include "linalg/sparse.hpp"

namespace {

thread_local std::string last_error_message;

#define DQA_X(name, value, text) static_assert(DQA_##name == (value), "header and list of statuses disagree");
DQA_STATUS_LIST(DQA_X)
#undef DQA_X

dqa_status remember(dqa::Status status, const char* message) noexcept {
    try {
        last_error_message = message;
    } catch (...) {
        last_error_message.clear();
    }
    return static_cast<dqa_status>(status);
}

#define DQA_STRING_(x) #x
#define DQA_STRING(x) DQA_STRING_(x)

}  // namespace

namespace dqa::capi {

dqa_status guard_call(void (*call)(void*), void* f) noexcept {
    try {
        call(f);
        return DQA_SUCCESS;
    } catch (const Error& e) {
        return remember(e.status(), e.what());
    } catch (const std::bad_alloc&) {
        return remember(Status::ERROR_MEMORY, "out of memory");
    } catch (const std::invalid_argument& e) {
        return remember(Status::ERROR_ARGUMENT, e.what());
    } catch (const std::exception& e) {
        return remember(Status::ERROR_INTERNAL, e.what());
    } catch (...) {
        return remember(Status::ERROR_INTERNAL, "unknown exception");
    }
}

void bad_null(const char* name) {
    fail(Status::ERROR_ARGUMENT, "%s is NULL, expected a valid pointer", name);
}

void require_count(std::int64_t got, std::int64_t expected, const char* name, const char* shape) {
    if (got != expected)
        fail(Status::ERROR_ARGUMENT, "%s is %" PRId64 ", expected %" PRId64 " elements: %s", name, got, expected,
             shape);
}

void require_finite(const double* values, std::int64_t n, const char* name) {
    for (std::int64_t k = 0; k < n; ++k)
        if (!std::isfinite(values[k]))
            fail(Status::ERROR_ARGUMENT, "%s[%" PRId64 "] is %g, expected a finite number", name, k, values[k]);
}

void require_range(double value, bool good, const char* name, const char* expected) {
    if (!good || !std::isfinite(value))
        fail(Status::ERROR_ARGUMENT, "%s is %s, expected %s", name, number_text(value).c_str(), expected);
}

// Beyond, squares and cubes of physical quantities leave the range of doubles (SI units).
void require_time_step(double value) {
    require_range(value, value >= 1e-12 && value <= 1e12, "time_step", "a time in [1e-12, 1e12] (s)");
}

void copy_out(const double* from, std::size_t n, double* to, std::int64_t count, const char* name, const char* shape) {
    if (!to) return;
    require_count(count, static_cast<std::int64_t>(n), name, shape);
    std::memcpy(to, from, n * sizeof *to);
}

std::vector<double> points_in(const double* from, std::int64_t n, int dims) {
    std::vector<double> out(static_cast<std::size_t>(n / dims * 3), 0.0);
    for (std::int64_t k = 0; k < n; ++k) out[static_cast<std::size_t>(k / dims * 3 + k % dims)] = from[k];
    return out;
}

void points_out(const double* from, std::size_t n_points, int dims, double* to) {
    const std::size_t d = static_cast<std::size_t>(dims);
    for (std::size_t p = 0; p < n_points && to; ++p)
        for (std::size_t a = 0; a < d; ++a) to[d * p + a] = from[3 * p + a];
}

void check_cancel(const std::shared_ptr<std::atomic<int>>& flag) {
    if (flag && flag->load()) fail(Status::CANCELLED, "the cancel token is set");
}

std::function<void(int, double)> shape_monitor(dqa_progress progress, void* user_data, double tolerance,
                                               std::shared_ptr<std::atomic<int>> cancel) {
    auto state = std::make_shared<std::pair<double, std::int64_t>>(0.0, 0);  // first error, percent so far
    return [=](int, double error) {
        check_cancel(cancel);
        if (!progress) return;
        if (!(state->first > 0)) state->first = std::max(error, 2.0 * tolerance);
        const double way = std::log(state->first / std::max(error, tolerance)) / std::log(state->first / tolerance);
        state->second = std::max(state->second, std::min<std::int64_t>(99, static_cast<std::int64_t>(100.0 * way)));
        if (progress(state->second, 100, user_data)) fail(Status::CANCELLED, "cancelled by the progress callback");
    };
}

}  // namespace dqa::capi

using namespace dqa::capi;

extern "C" {

const char* dqa_version(void) {
    return DQA_STRING(DQA_VERSION_MAJOR) "." DQA_STRING(DQA_VERSION_MINOR) "." DQA_STRING(DQA_VERSION_PATCH);
}

int32_t dqa_abi_version(void) {
    return DQA_ABI_VERSION;
}

const char* dqa_features(void) {
    // Without memory of its own: nothing here may fail.
    static const auto features = [] {
        const auto best = dqa::choose_instruction_set(dqa::InstructionSet::automatic);
        std::array<char, 128> f{};
        std::snprintf(f.data(), f.size(), "stl obj ply %s%s%s%s", dqa::direct_solver_name(),
#if defined(_OPENMP)
                      " openmp",
#else
                      "",
#endif
                      best >= dqa::InstructionSet::avx2 ? " avx2" : "",
                      best == dqa::InstructionSet::avx512 ? " avx512" : "");
        return f;
    }();
    return features.data();
}

const char* dqa_status_name(dqa_status status) {
    switch (status) {
#define DQA_X(name, value, text) \
    case value:                  \
        return "DQA_" #name;
        DQA_STATUS_LIST(DQA_X)
#undef DQA_X
        default:
            return "unknown status";
    }
}

const char* dqa_status_text(dqa_status status) {
    switch (status) {
#define DQA_X(name, value, text) \
    case value:                  \
        return text;
        DQA_STATUS_LIST(DQA_X)
#undef DQA_X
        default:
            return "unknown status";
    }
}

const char* dqa_last_error(void) {
    return last_error_message.c_str();
}

dqa_status dqa_set_log_handler(dqa_log_handler handler, int32_t level, void* user_data) {
    return guard([&] {
        if (handler && (level < DQA_LOG_ERROR || level > DQA_LOG_DEBUG))
            dqa::fail(dqa::Status::ERROR_ARGUMENT, "level is %d, expected DQA_LOG_ERROR (1) to DQA_LOG_DEBUG (4)",
                      level);
        dqa::set_log_handler(handler, level, user_data);
    });
}

dqa_status dqa_cancel_token_create(dqa_cancel_token** token) {
    return guard([&] {
        begin_create(token, "token");
        auto made = std::make_unique<dqa_cancel_token>();
        made->flag = std::make_shared<std::atomic<int>>(0);
        *token = made.release();
    });
}

dqa_status dqa_cancel_token_set(dqa_cancel_token* token) {
    if (!token) return guard([] { bad_null("token"); });
    token->flag->store(1);  // nothing else: this may run in a signal handler
    return DQA_SUCCESS;
}

dqa_status dqa_cancel_token_reset(dqa_cancel_token* token) {
    return guard([&] {
        require(token, "token");
        token->flag->store(0);
    });
}

void dqa_cancel_token_free(dqa_cancel_token* token) {
    delete token;
}

}  // extern "C"
