// SPDX-License-Identifier: MIT
// What stops at the boundary of the ABI: C++ exceptions from callbacks, and the N-th allocation failing, for every N
// (of long calls: for many N). A failed call gives DQA_ERROR_MEMORY and leaves its objects as they were.
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

extern "C" {
#include <cmocka.h>
}

#include "diffaqua.h"

// ---------------------------------------------------------------- allocation, counted, and failing when told to

namespace {
thread_local long countdown = -1;  // < 0: never
thread_local bool hit = false;
}  // namespace

static void* allocate(std::size_t size, std::size_t alignment) {
    if (countdown >= 0 && countdown-- == 0) {
        hit = true;
        throw std::bad_alloc();
    }
    void* p = alignment > alignof(std::max_align_t)
                  ? std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment)
                  : std::malloc(size ? size : 1);
    if (!p) throw std::bad_alloc();
    return p;
}

void* operator new(std::size_t size) {
    return allocate(size, 0);
}
void* operator new[](std::size_t size) {
    return allocate(size, 0);
}
void* operator new(std::size_t size, std::align_val_t a) {
    return allocate(size, static_cast<std::size_t>(a));
}
void* operator new[](std::size_t size, std::align_val_t a) {
    return allocate(size, static_cast<std::size_t>(a));
}
void operator delete(void* p) noexcept {
    std::free(p);
}
void operator delete[](void* p) noexcept {
    std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
    std::free(p);
}
void operator delete[](void* p, std::size_t) noexcept {
    std::free(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
    std::free(p);
}
void operator delete[](void* p, std::align_val_t) noexcept {
    std::free(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
    std::free(p);
}
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept {
    std::free(p);
}

namespace {

#define OK(call) assert_int_equal((call), DQA_SUCCESS)

// ---------------------------------------------------------------- a scene

constexpr int NX = 12, NY = 8, NZ = 8, N_CELLS = NX * NY * NZ;

std::vector<double> ellipsoid(double a, double b) {
    std::vector<double> cells(N_CELLS);
    for (int c = 0; c < N_CELLS; ++c) {
        const double x = c / (NY * NZ) + 0.5 - 0.5 * NX, y = c / NZ % NY + 0.5 - 0.5 * NY, z = c % NZ + 0.5 - 0.5 * NZ;
        cells[static_cast<std::size_t>(c)] = x * x / (a * a) + (y * y + z * z) / (b * b) < 1.0;
    }
    return cells;
}

dqa_shape_space_options space_options() {
    dqa_shape_space_options o;
    OK(dqa_shape_space_options_init(&o, sizeof o));
    o.cells_x = NX, o.cells_y = NY, o.cells_z = NZ;
    o.cell_size = 0.1;
    return o;
}

dqa_shape_space* make_space() {
    const dqa_shape_space_options o = space_options();
    dqa_shape_space* space = nullptr;
    OK(dqa_shape_space_create(&o, &space));
    OK(dqa_shape_space_add_density(space, "a", ellipsoid(4.5, 2.0).data(), N_CELLS, nullptr));
    OK(dqa_shape_space_add_density(space, "b", ellipsoid(3.5, 2.5).data(), N_CELLS, nullptr));
    OK(dqa_shape_space_build(space, nullptr, nullptr));
    return space;
}

const double kHalf[2] = {0.5, 0.5};

// ---------------------------------------------------------------- exceptions of callbacks

int thrown = 0;

int32_t throwing(int64_t, int64_t, void*) {
    if (thrown == 0) throw std::bad_alloc();
    if (thrown == 1) throw std::invalid_argument("the callback's own words");
    if (thrown == 2) throw std::runtime_error("the callback's other words");
    throw 42;
}

void test_exceptions_of_callbacks(void**) {
    dqa_shape_space* space = make_space();
    dqa_simulator* simulator = nullptr;
    OK(dqa_simulator_create(space, nullptr, &simulator));
    const dqa_status expected[] = {DQA_ERROR_MEMORY, DQA_ERROR_ARGUMENT, DQA_ERROR_INTERNAL, DQA_ERROR_INTERNAL};
    const char* texts[] = {"out of memory", "the callback's own words", "the callback's other words",
                           "unknown exception"};
    for (thrown = 0; thrown < 4; ++thrown) {
        assert_int_equal(dqa_simulator_set_weights(simulator, kHalf, 2, throwing, nullptr), expected[thrown]);
        assert_string_equal(dqa_last_error(), texts[thrown]);
    }
    OK(dqa_simulator_set_weights(simulator, kHalf, 2, nullptr, nullptr));
    dqa_simulator_free(simulator);
    dqa_shape_space_free(space);
}

// ---------------------------------------------------------------- failing allocations

// Runs `call` with the N-th allocation failing, for the first N, then for ever longer strides, until it succeeds.
// Returns how often it failed.
int sweep(const char* name, const std::function<dqa_status()>& call) {
    int failures = 0;
    for (long n = 0;; n += 1 + n / 16) {
        hit = false, countdown = n;
        const dqa_status status = call();
        countdown = -1;
        if (!hit) {
            if (status != DQA_SUCCESS) fail_msg("%s: %s: %s", name, dqa_status_name(status), dqa_last_error());
            break;
        }
        if (status != DQA_ERROR_MEMORY)
            fail_msg("%s: allocation %ld failed and the call gave %s: %s", name, n, dqa_status_name(status),
                     dqa_last_error());
        ++failures;
    }
    print_message("%s: survived %d failures\n", name, failures);
    return failures;
}

void test_every_call_survives(void**) {
    const dqa_shape_space_options so = space_options();
    const std::vector<double> a = ellipsoid(4.5, 2.0), b = ellipsoid(3.5, 2.5);
    dqa_shape_space* space = nullptr;
    dqa_simulator* simulator = nullptr;
    dqa_controller* controller = nullptr;
    dqa_tape* tape = nullptr;
    dqa_adjoint* adjoint = nullptr;
    dqa_cancel_token* token = nullptr;
    dqa_objective_term term;
    OK(dqa_objective_term_init(&term, sizeof term));
    const double times[2] = {0.0, 1.0}, rows[6] = {-0.1, 0, 0, -0.2, 0, 0};
    assert_true(sweep("features", [] { return dqa_features()[0] ? DQA_SUCCESS : DQA_ERROR_INTERNAL; }) == 0);
    assert_true(sweep("token", [&] { return dqa_cancel_token_create(&token); }) > 0);
    assert_true(sweep("space", [&] { return dqa_shape_space_create(&so, &space); }) > 0);
    assert_true(sweep("density", [&] {
                    return dqa_shape_space_add_density(space, "a name too long for a small string", a.data(), N_CELLS,
                                                       nullptr);
                }) > 0);
    OK(dqa_shape_space_add_density(space, "b", b.data(), N_CELLS, nullptr));
    dqa_shape_space_info info;
    OK(dqa_shape_space_get_info(space, &info, sizeof info));
    assert_int_equal(info.n_bases, 2);  // failed attempts left nothing behind
    assert_true(sweep("build", [&] { return dqa_shape_space_build(space, nullptr, nullptr); }) > 0);
    std::vector<double> density(N_CELLS), bar(N_CELLS, 1.0), weights_bar(2);
    assert_true(sweep("barycentre", [&] { return dqa_shape_space_density(space, kHalf, 2, density.data(), N_CELLS); }) >
                0);
    assert_true(sweep("its pullback", [&] {
                    return dqa_shape_space_pullback(space, kHalf, 2, bar.data(), N_CELLS, weights_bar.data());
                }) > 0);
    assert_true(sweep("save", [&] { return dqa_shape_space_save(space, "barrier.space"); }) > 0);
    dqa_shape_space* loaded = nullptr;
    assert_true(sweep("load", [&] { return dqa_shape_space_load("barrier.space", &loaded); }) > 0);
    dqa_shape_space_free(loaded);
    assert_true(sweep("simulator", [&] { return dqa_simulator_create(space, nullptr, &simulator); }) > 0);
    assert_true(sweep("design", [&] { return dqa_simulator_set_weights(simulator, kHalf, 2, nullptr, nullptr); }) > 0);
    double threshold = 0.0;
    assert_true(sweep("threshold", [&] {
                    return dqa_simulator_suggest_threshold(simulator, kHalf, 2, 0.05, &threshold, nullptr);
                }) > 0);
    assert_true(sweep("current", [&] { return dqa_simulator_set_current_table(simulator, times, 2, rows, 6); }) > 0);
    assert_true(sweep("controller", [&] { return dqa_controller_create_sinusoid(1, 1.0 / 30.0, &controller); }) > 0);
    assert_true(sweep("tape", [&] { return dqa_tape_create(simulator, nullptr, &tape); }) > 0);
    // Each success is one step more on the tape; a failure none.
    for (int step = 0; step < 2; ++step)
        assert_true(sweep("rollout",
                          [&] { return dqa_simulator_rollout(simulator, controller, 1, tape, nullptr, nullptr); }) > 0);
    int64_t steps = 0;
    OK(dqa_tape_n_steps(tape, &steps));
    assert_int_equal(steps, 2);
    double loss = 0.0;
    OK(dqa_tape_objective(tape, &term, 1, &loss, nullptr));
    assert_true(std::isfinite(loss) && loss != 0.0);
    assert_true(sweep("adjoint", [&] { return dqa_adjoint_create(tape, &adjoint); }) > 0);
    OK(dqa_adjoint_seed_objective(adjoint, &term, 1));
    assert_true(sweep("backward", [&] { return dqa_adjoint_backward(adjoint, 0, nullptr, nullptr); }) > 0);
    double after[2], undisturbed[2];
    assert_true(sweep("gradient", [&] { return dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, after, 2); }) > 0);
    dqa_adjoint_free(adjoint);
    // The same without failures: the same bits.
    dqa_tape_free(tape);
    tape = nullptr;
    OK(dqa_simulator_set_state(simulator, nullptr, 0, nullptr, 0));
    OK(dqa_tape_create(simulator, nullptr, &tape));
    OK(dqa_simulator_rollout(simulator, controller, 2, tape, nullptr, nullptr));
    OK(dqa_adjoint_create(tape, &adjoint));
    OK(dqa_adjoint_seed_objective(adjoint, &term, 1));
    OK(dqa_adjoint_backward(adjoint, 0, nullptr, nullptr));
    OK(dqa_adjoint_get(adjoint, DQA_WRT_WEIGHTS, undisturbed, 2));
    assert_memory_equal(after, undisturbed, sizeof after);
    dqa_adjoint_free(adjoint);
    dqa_tape_free(tape);
    dqa_controller_free(controller);
    dqa_simulator_free(simulator);
    dqa_shape_space_free(space);
    dqa_cancel_token_free(token);
}

// A message that cannot be kept leaves an empty one and the right status.
void test_message_without_memory(void**) {
    bool dropped = false, good = true, more = true;
    for (long n = 0; n < 64 && more; ++n)
        std::thread([&] {  // a thread that holds no message yet; assertions wait until it is gone
            countdown = n;
            const dqa_status status = dqa_project_simplex(nullptr, 3);
            countdown = -1;
            more = hit;
            good = good && (status == DQA_ERROR_ARGUMENT || (hit && status == DQA_ERROR_MEMORY));
            dropped = dropped || (status == DQA_ERROR_ARGUMENT && dqa_last_error()[0] == 0);
        })
            .join();
    assert_true(good);
    assert_false(more);
    assert_true(dropped);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_exceptions_of_callbacks),
        cmocka_unit_test(test_every_call_survives),
        cmocka_unit_test(test_message_without_memory),
    };
    return cmocka_run_group_tests_name("barrier", tests, nullptr, nullptr);
}
