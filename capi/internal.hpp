// SPDX-License-Identifier: MIT
// What the files of the ABI share: handles, the exception barrier, and checks of arguments. No numerics here.
#pragma once

#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "diffaqua.h"
#include "grid/error.hpp"
#include "lease.hpp"
#include "tape/gradient_check.hpp"
#include "tape/reader.hpp"
#include "tape/tape.hpp"

struct dqa_cancel_token {
    std::shared_ptr<std::atomic<int>> flag;
};
struct dqa_shape_space : dqa::capi::Handle {
    std::shared_ptr<dqa::ShapeSpace> core;
    std::shared_ptr<std::atomic<int>> cancel;
};
struct dqa_simulator : dqa::capi::Handle {
    std::shared_ptr<const dqa::ShapeSpace> space;
    dqa::SceneSettings scene;
    std::unique_ptr<dqa::Simulation> simulation;               // null before the first design
    std::shared_ptr<const dqa::WaterCurrent> current;          // null: uniform, as the scene says
    std::shared_ptr<int> identity = std::make_shared<int>(0);  // tapes know their simulator by it
    std::int64_t newton_iterations = 0, linear_iterations = 0;
    std::shared_ptr<std::atomic<std::int64_t>> adjoint_iterations = std::make_shared<std::atomic<std::int64_t>>(0);
    double last_residual = 0.0, setup_seconds = 0.0;
};
struct dqa_controller : dqa::capi::Handle {
    std::unique_ptr<dqa::Controller> core;
};

namespace dqa::capi {

// A tape outlives its handle while adjoints of it live.
struct TapeState {
    explicit TapeState(std::int64_t memory_bytes) : tape(std::make_shared<Tape>(memory_bytes)) {}
    std::shared_ptr<Tape> tape;
    // For dqa_tape_get_state and _surface: states computed again are not lost between the calls.
    std::mutex reading;
    std::atomic<std::thread::id> reads;  // the thread that holds it
    TapeReader reader{*tape};
    std::shared_ptr<int> simulator;
    std::shared_ptr<std::atomic<std::int64_t>> simulator_adjoint_iterations;
    std::atomic<int> adjoints{0};
    std::atomic<std::int64_t> adjoint_iterations{0};
    std::atomic<double> worst_adjoint_residual{0.0};
};

}  // namespace dqa::capi

struct dqa_tape : dqa::capi::Handle {
    std::shared_ptr<dqa::capi::TapeState> state;
};
struct dqa_adjoint : dqa::capi::Handle {
    ~dqa_adjoint() {
        if (state) --state->adjoints;
    }
    std::shared_ptr<dqa::capi::TapeState> state;
    std::unique_ptr<dqa::Adjoint> core;
    std::shared_ptr<std::atomic<int>> cancel;
    std::int64_t counted = 0;  // iterations already added to the statistics
};

namespace dqa::capi {

// Runs f; turns exceptions into a status and the thread's last error. f is passed by address: a std::function would
// need memory outside of the barrier.
dqa_status guard_call(void (*call)(void*), void* f) noexcept;

template <class F>
dqa_status guard(F&& f) noexcept {
    return guard_call([](void* g) { (*static_cast<std::remove_reference_t<F>*>(g))(); }, &f);
}

[[noreturn]] void bad_null(const char* name);

template <class T>
void require(const T* pointer, const char* name) {
    if (!pointer) bad_null(name);
}

// Creators write NULL first, so that a failure leaves NULL.
template <class T>
void begin_create(T** out, const char* name) {
    if (!out) bad_null(name);
    *out = nullptr;
}

void require_count(std::int64_t got, std::int64_t expected, const char* name, const char* shape);
void require_finite(const double* values, std::int64_t n, const char* name);
void require_range(double value, bool good, const char* name, const char* expected);
void require_time_step(double value);

// Options as the caller compiled them, laid over defaults. NULL: defaults.
template <class T>
T read_options(const T* given, const T& defaults, const char* name) {
    T out = defaults;
    if (!given) return out;
    std::uint32_t size;
    std::memcpy(&size, given, sizeof size);
    if (size < 8 || size % 8 != 0)
        fail(Status::ERROR_ARGUMENT,
             "%s: struct_size is %u, expected a multiple of 8, at least 8; fill it with the _init function", name,
             size);
    const unsigned char* bytes = reinterpret_cast<const unsigned char*>(given);
    for (std::size_t k = sizeof(T); k < size; ++k)
        if (bytes[k] != 0)
            fail(Status::ERROR_ARGUMENT,
                 "%s: struct_size is %u and byte %zu is set: a field that this library (%zu bytes) does not know", name,
                 size, k, sizeof(T));
    std::memcpy(&out, given, size < sizeof(T) ? size : sizeof(T));
    out.struct_size = static_cast<std::uint32_t>(sizeof(T));
    return out;
}

template <class T>
void init_options(T* out, std::uint64_t size, const T& defaults, const char* name) {
    require(out, name);
    if (size < 8 || size % 8 != 0 || size > 65536)
        fail(Status::ERROR_ARGUMENT, "size is %llu, expected sizeof of the struct",
             static_cast<unsigned long long>(size));
    T value = defaults;
    value.struct_size = static_cast<std::uint32_t>(size);
    std::memset(static_cast<void*>(out), 0, size);
    std::memcpy(static_cast<void*>(out), &value, size < sizeof(T) ? size : sizeof(T));
}

template <class T>
void write_struct(T* out, std::uint64_t size, T value, const char* name) {
    require(out, name);
    if (size < 8 || size % 8 != 0)
        fail(Status::ERROR_ARGUMENT, "size is %llu, expected sizeof of the struct",
             static_cast<unsigned long long>(size));
    const std::size_t n = size < sizeof(T) ? size : sizeof(T);
    value.struct_size = static_cast<std::uint32_t>(n);
    std::memcpy(static_cast<void*>(out), &value, n);
}

// Copies to the caller's buffer if there is one, after its count was checked.
void copy_out(const double* from, std::size_t n, double* to, std::int64_t count, const char* name, const char* shape);

// Fields over points, [n][3] inside and [n][dims] at the boundary: in two dimensions z is 0.
std::vector<double> points_in(const double* from, std::int64_t n, int dims);
void points_out(const double* from, std::size_t n_points, int dims, double* to);

// Throws CANCELLED when the token is set.
void check_cancel(const std::shared_ptr<std::atomic<int>>& flag);
// A monitor of the barycentre that reports percent of the way to the tolerance (on the logarithm of the error).
std::function<void(int, double)> shape_monitor(dqa_progress progress, void* user_data, double tolerance,
                                               std::shared_ptr<std::atomic<int>> cancel);

std::vector<double> read_weights(const ShapeSpace& space, const double* weights, std::int64_t m);
std::vector<ObjectiveTerm> read_terms(const dqa_objective_term* terms, std::int64_t n_terms, int dims);
const Simulation& design_of(const dqa_simulator* simulator);
// The controller reads none of the design's sensors or all.
void require_sensors(const Controller& controller, const Design& design);

}  // namespace dqa::capi
