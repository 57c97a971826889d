// SPDX-License-Identifier: MIT
// Every callback crossed with every function of the header: from within a call each either does what it says, or is
// refused with DQA_ERROR_STATE and a message that names the handle; nothing crashes, and the call around it gives the
// same bits as without, if it gives an answer at all. Also: frees from within, and a function that is missing here.
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "diffaqua.h"

// cmocka last: it defines fail() as a macro.
extern "C" {
#include <cmocka.h>
}

namespace {

using Vector = std::vector<double>;
constexpr int kCells[2] = {16, 8};

void need(dqa_status status, const char* what) {
    if (status != DQA_SUCCESS) fail_msg("%s: %s: %s", what, dqa_status_name(status), dqa_last_error());
}
#define OK(call) need(call, #call)

template <class T>
T options_of(dqa_status (*init)(T*, std::uint64_t)) {
    T o;
    OK(init(&o, sizeof o));
    return o;
}

// What runs inside a callback: once, at the first call of the site that is under test.
std::function<void()> inside;

void visit() {
    if (!inside) return;
    const auto once = std::move(inside);
    inside = nullptr;
    once();
}

Vector blob(double wide) {
    Vector cells;
    for (int i = 0; i < kCells[0]; ++i)
        for (int j = 0; j < kCells[1]; ++j) {
            const double x = i - 7.5, y = j - 3.5;
            cells.push_back(std::fmin(1.0, std::fmax(0.0, 2.0 * (1.0 - x * x / 36.0 - y * y / wide))));
        }
    return cells;
}

dqa_shape_space* open_space() {
    auto o = options_of(dqa_shape_space_options_init);
    o.dims = 2, o.cells_x = kCells[0], o.cells_y = kCells[1], o.sigma = 0.7, o.tolerance = 1e-6;
    dqa_shape_space* space = nullptr;
    OK(dqa_shape_space_create(&o, &space));
    for (const double wide : {4.0, 6.0}) {
        const Vector cells = blob(wide);
        OK(dqa_shape_space_add_density(space, "blob", cells.data(), static_cast<std::int64_t>(cells.size()), nullptr));
    }
    return space;
}

// Which callbacks visit; the others only do their work.
enum Site {
    kBuild,
    kSetWeights,
    kRollout,
    kEvaluate,
    kCurrent,
    kBackward,
    kControlPullback,
    kCurrentPullback,
    kCheckGradient,
    kReading,
    kSites
};
constexpr const char* kSiteNames[kSites] = {"build",    "set_weights",       "rollout",          "evaluate",
                                            "current",  "backward",          "control pullback", "current pullback",
                                            "checking", "reading (log line)"};
Site site = kSites;

// Where a tape is read it must not hold all of its states, so that they are computed again.
int steps() {
    return site == kReading ? 10 : 3;
}

std::int32_t progress(std::int64_t, std::int64_t, void* at) {
    if (site == *static_cast<const Site*>(at)) visit();
    return 0;
}
std::int32_t evaluate(std::int64_t, double time, const double* sensors, std::int64_t, const double* theta, std::int64_t,
                      double* actuation, std::int64_t, void*) {
    actuation[0] = theta[0] * std::sin(15.0 * time + 1.0) + 0.01 * std::tanh(sensors[0]);
    if (site == kEvaluate || site == kCheckGradient) visit();
    return 0;
}
std::int32_t evaluate_pullback(std::int64_t, double time, const double* sensors, std::int64_t, const double*,
                               std::int64_t, const double* actuation_bar, std::int64_t, double* theta_bar,
                               double* sensors_bar, void*) {
    theta_bar[0] += std::sin(15.0 * time + 1.0) * actuation_bar[0];
    const double t = std::tanh(sensors[0]);
    sensors_bar[0] += 0.01 * (1.0 - t * t) * actuation_bar[0];
    if (site == kControlPullback) visit();
    return 0;
}
std::int32_t blow(double time, double* current, void*) {
    current[0] = -0.1 * std::cos(5.0 * time);
    if (site == kCurrent) visit();
    return 0;
}
std::int32_t blow_back(double, const double*, void*) {
    if (site == kCurrentPullback) visit();
    return 0;
}
void on_log(std::int32_t, const char*, void*) {
    if (site == kReading) visit();
}

const Site sites[kSites] = {kBuild,    kSetWeights,      kRollout,         kEvaluate,      kCurrent,
                            kBackward, kControlPullback, kCurrentPullback, kCheckGradient, kReading};
void* at(Site s) {
    return const_cast<Site*>(&sites[s]);
}

// One of each handle, in the middle of an ordinary life.
struct World {
    dqa_shape_space *space = nullptr, *building = nullptr;
    dqa_simulator* simulator = nullptr;
    dqa_controller* controller = nullptr;
    dqa_tape *tape = nullptr, *finished = nullptr;
    dqa_adjoint* adjoint = nullptr;
    dqa_cma_es* search = nullptr;
    dqa_cancel_token* token = nullptr;
    std::int64_t n_q = 0;

    World() {
        space = open_space();
        OK(dqa_shape_space_build(space, nullptr, nullptr));
        building = open_space();
        OK(dqa_cancel_token_create(&token));
        auto o = options_of(dqa_simulator_options_init);
        o.cancel = token;
        if (site == kReading) o.max_newton = 2, o.young_modulus = 2e6;  // its steps are rescued, and say so
        OK(dqa_simulator_create(space, &o, &simulator));
        OK(dqa_simulator_set_current_callback(simulator, blow, blow_back, nullptr));
        const double weights[2] = {0.5, 0.5}, theta = 0.6, mean[2] = {0.0, 1.0};
        OK(dqa_simulator_set_weights(simulator, weights, 2, nullptr, nullptr));
        auto c = options_of(dqa_callback_controller_options_init);
        c.n_sensors = 10, c.evaluate = evaluate, c.pullback = evaluate_pullback;
        OK(dqa_controller_create_callback(&c, &theta, 1, &controller));
        dqa_simulator_info info;
        OK(dqa_simulator_get_info(simulator, &info, sizeof info));
        n_q = 2 * info.n_nodes;
        // A budget below the whole rollout: states are computed again when they are read.
        auto t = options_of(dqa_tape_options_init);
        t.memory_bytes = 8 * 6 * info.n_nodes * 4 + 2000;
        OK(dqa_tape_create(simulator, &t, &finished));
        OK(dqa_simulator_rollout(simulator, controller, steps(), finished, nullptr, nullptr));
        OK(dqa_simulator_set_state(simulator, nullptr, 0, nullptr, 0));
        OK(dqa_tape_create(simulator, &t, &tape));
        const auto term = options_of(dqa_objective_term_init);
        OK(dqa_adjoint_create(finished, &adjoint));
        OK(dqa_adjoint_seed_objective(adjoint, &term, 1));
        OK(dqa_cma_es_create(nullptr, mean, nullptr, 2, &search));
    }
    World(const World&) = delete;
    World& operator=(const World&) = delete;
    ~World() {
        dqa_adjoint_free(adjoint);
        dqa_tape_free(tape);
        dqa_tape_free(finished);
        dqa_controller_free(controller);
        dqa_simulator_free(simulator);
        dqa_shape_space_free(space);
        dqa_shape_space_free(building);
        dqa_cma_es_free(search);
        dqa_cancel_token_free(token);
    }
};

// The call whose callback is the site. Appends what it gave.
dqa_status outer(World& w, Vector& out) {
    const double weights[2] = {0.3, 0.7};
    Vector q(static_cast<std::size_t>(w.n_q));
    dqa_status status = DQA_SUCCESS;
    switch (site) {
        case kBuild:
            return dqa_shape_space_build(w.building, progress, at(site));
        case kSetWeights:
            return dqa_simulator_set_weights(w.simulator, weights, 2, progress, at(site));
        case kRollout:
        case kEvaluate:
        case kCurrent:
            status = dqa_simulator_rollout(w.simulator, w.controller, steps(), w.tape, progress, at(kRollout));
            if (status == DQA_SUCCESS && w.simulator &&
                dqa_simulator_get_state(w.simulator, q.data(), w.n_q, nullptr, 0) == DQA_SUCCESS)
                out = q;
            return status;
        case kBackward:
        case kControlPullback:
        case kCurrentPullback:
            status = dqa_adjoint_backward(w.adjoint, 0, progress, at(kBackward));
            out.assign(3, 0.0);
            if (status == DQA_SUCCESS && w.adjoint) {
                OK(dqa_adjoint_get(w.adjoint, DQA_WRT_WEIGHTS, out.data(), 2));
                OK(dqa_adjoint_get(w.adjoint, DQA_WRT_CONTROL, out.data() + 2, 1));
            }
            return status;
        case kCheckGradient: {
            const auto term = options_of(dqa_objective_term_init);
            auto o = options_of(dqa_gradient_check_options_init);
            o.with_respect_to = DQA_WRT_CONTROL, o.n_steps = 1;
            dqa_gradient_check_report report;
            status = dqa_check_gradient(w.simulator, w.controller, &term, 1, &o, &report, sizeof report);
            out.assign(1, report.adjoint);
            return status;
        }
        default: {
            for (int step = steps(); step > 0 && w.finished && status == DQA_SUCCESS; --step)
                status = dqa_tape_get_state(w.finished, step, q.data(), w.n_q, nullptr, 0);
            out = q;
            return status;
        }
    }
}

struct Function {
    std::string name;
    std::function<dqa_status(World&)> call;
};

std::vector<Function> functions() {
    static double many[8192];
    static std::int32_t whole[8192];
    static const auto term = options_of(dqa_objective_term_init);
    static std::int64_t n;
    static const double halves[2] = {0.5, 0.5}, theta[1] = {0.1};
    const std::int64_t cells = kCells[0] * kCells[1];
    std::vector<Function> f;
    const auto add = [&](const char* name, std::function<dqa_status(World&)> call) {
        f.push_back({name, std::move(call)});
    };
#define CALL(name, ...) add(#name, [=]([[maybe_unused]] World& w) -> dqa_status { return name(__VA_ARGS__); })
#define GIVES(name, expression)                               \
    add(#name, [=]([[maybe_unused]] World& w) -> dqa_status { \
        (void)(expression);                                   \
        return DQA_SUCCESS;                                   \
    })
#define FREES(name, handle)                  \
    add(#name, [=](World& w) -> dqa_status { \
        name(handle);                        \
        handle = nullptr;                    \
        return DQA_SUCCESS;                  \
    })
#define MAKES(name, type, release, ...)                       \
    add(#name, [=]([[maybe_unused]] World& w) -> dqa_status { \
        type* made = nullptr;                                 \
        const dqa_status status = name(__VA_ARGS__);          \
        release(made);                                        \
        return status;                                        \
    })
#define INITS(name, type)                      \
    add(#name, [=](World&) -> dqa_status {     \
        type options;                          \
        return name(&options, sizeof options); \
    })
    GIVES(dqa_version, dqa_version());
    GIVES(dqa_abi_version, dqa_abi_version());
    GIVES(dqa_features, dqa_features());
    GIVES(dqa_status_name, dqa_status_name(0));
    GIVES(dqa_status_text, dqa_status_text(0));
    GIVES(dqa_last_error, dqa_last_error());
    CALL(dqa_set_log_handler, site == kReading ? on_log : nullptr, DQA_LOG_DEBUG, nullptr);
    MAKES(dqa_cancel_token_create, dqa_cancel_token, dqa_cancel_token_free, &made);
    CALL(dqa_cancel_token_set, w.token);
    CALL(dqa_cancel_token_reset, w.token);
    FREES(dqa_cancel_token_free, w.token);
    INITS(dqa_shape_space_options_init, dqa_shape_space_options);
    MAKES(dqa_shape_space_create, dqa_shape_space, dqa_shape_space_free, nullptr, &made);
    FREES(dqa_shape_space_free, w.building);
    FREES(dqa_shape_space_free, w.space);
    CALL(dqa_shape_space_add_mesh, w.building, "m", many, 1, whole, 1, nullptr);
    CALL(dqa_shape_space_add_mesh_file, w.building, "none.stl", nullptr);
    add("dqa_shape_space_add_density", [=](World& w) {
        const Vector more = blob(5.0);
        return dqa_shape_space_add_density(w.building, "more", more.data(), cells, nullptr);
    });
    CALL(dqa_shape_space_add_polygon, w.building, "p", many, 3, nullptr);
    CALL(dqa_shape_space_add_image, w.building, "i", many, 1, 1, nullptr);
    INITS(dqa_actuator_options_init, dqa_actuator_options);
    add("dqa_shape_space_add_actuator", [](World& w) {
        auto o = options_of(dqa_actuator_options_init);
        o.variance[0] = o.variance[1] = o.variance[2] = 0.01;
        return dqa_shape_space_add_actuator(w.building, 0, &o);
    });
    add("dqa_shape_space_get_actuator", [](World& w) {
        auto o = options_of(dqa_actuator_options_init);
        return dqa_shape_space_get_actuator(w.building, 0, 0, 0, &o);
    });
    CALL(dqa_shape_space_build, w.building, nullptr, nullptr);
    add("dqa_shape_space_get_info", [](World& w) {
        dqa_shape_space_info info;
        return dqa_shape_space_get_info(w.building, &info, sizeof info);
    });
    add("dqa_shape_space_signal", [](World& w) {
        dqa_signal_info info;
        return dqa_shape_space_signal(w.building, 0, &info, sizeof info);
    });
    GIVES(dqa_shape_space_base_name, dqa_shape_space_base_name(w.building, 0));
    CALL(dqa_shape_space_get_base, w.building, 0, many, cells);
    CALL(dqa_shape_space_density, w.building, halves, 2, many, cells);
    CALL(dqa_shape_space_pullback, w.building, halves, 2, many, cells, many + cells);
    CALL(dqa_shape_space_save, w.building, "reentry.space");
    MAKES(dqa_shape_space_load, dqa_shape_space, dqa_shape_space_free, "none.space", &made);
    INITS(dqa_simulator_options_init, dqa_simulator_options);
    MAKES(dqa_simulator_create, dqa_simulator, dqa_simulator_free, w.building, nullptr, &made);
    FREES(dqa_simulator_free, w.simulator);
    CALL(dqa_simulator_set_weights, w.simulator, halves, 2, nullptr, nullptr);
    CALL(dqa_simulator_set_material, w.simulator, nullptr, nullptr, 0);
    CALL(dqa_simulator_set_fixed_nodes, w.simulator, nullptr, 0);
    CALL(dqa_simulator_node_box_index, w.simulator, whole, w.n_q / 2);
    CALL(dqa_simulator_set_current_table, w.simulator, nullptr, 0, nullptr, 0);
    CALL(dqa_simulator_set_current_callback, w.simulator, nullptr, nullptr, nullptr);
    add("dqa_simulator_get_info", [](World& w) {
        dqa_simulator_info info;
        return dqa_simulator_get_info(w.simulator, &info, sizeof info);
    });
    CALL(dqa_simulator_get_weights, w.simulator, many, 2);
    CALL(dqa_simulator_suggest_threshold, w.simulator, halves, 2, 0.1, many, nullptr);
    CALL(dqa_simulator_step, w.simulator, theta, 1, nullptr);
    CALL(dqa_simulator_rollout, w.simulator, w.controller, 1, w.tape, nullptr, nullptr);
    CALL(dqa_simulator_get_state, w.simulator, many, w.n_q, nullptr, 0);
    CALL(dqa_simulator_set_state, w.simulator, nullptr, 0, nullptr, 0);
    CALL(dqa_simulator_sensors, w.simulator, many, 10);
    CALL(dqa_simulator_forces, w.simulator, many, 8);
    CALL(dqa_simulator_surface, w.simulator, nullptr, 0, nullptr, 0, &n, nullptr);
    CALL(dqa_simulator_mesh, w.simulator, nullptr, 0, nullptr, 0, nullptr, 0);
    add("dqa_simulator_actuator", [](World& w) {
        dqa_actuator_info info;
        return dqa_simulator_actuator(w.simulator, 0, 0, &info, sizeof info);
    });
    CALL(dqa_simulator_muscles, w.simulator, nullptr, nullptr, nullptr, 0, nullptr, 0, nullptr, 0, &n);
    MAKES(dqa_controller_create_sinusoid, dqa_controller, dqa_controller_free, 1, 0.1, &made);
    INITS(dqa_mlp_options_init, dqa_mlp_options);
    MAKES(dqa_controller_create_mlp, dqa_controller, dqa_controller_free, nullptr, &made);
    INITS(dqa_callback_controller_options_init, dqa_callback_controller_options);
    add("dqa_controller_create_callback", [](World&) {
        auto c = options_of(dqa_callback_controller_options_init);
        c.evaluate = evaluate;
        dqa_controller* made = nullptr;
        const dqa_status status = dqa_controller_create_callback(&c, theta, 1, &made);
        dqa_controller_free(made);
        return status;
    });
    FREES(dqa_controller_free, w.controller);
    add("dqa_controller_get_info", [](World& w) {
        dqa_controller_info info;
        return dqa_controller_get_info(w.controller, &info, sizeof info);
    });
    CALL(dqa_controller_n_parameters, w.controller, &n);
    CALL(dqa_controller_get_parameters, w.controller, many, 1);
    CALL(dqa_controller_set_parameters, w.controller, theta, 1);
    CALL(dqa_controller_evaluate, w.controller, 0, many, 10, many + 16, 1);
    CALL(dqa_controller_save, w.controller, "reentry.controller");
    MAKES(dqa_controller_load, dqa_controller, dqa_controller_free, "none.controller", &made);
    INITS(dqa_tape_options_init, dqa_tape_options);
    MAKES(dqa_tape_create, dqa_tape, dqa_tape_free, w.simulator, nullptr, &made);
    FREES(dqa_tape_free, w.tape);
    FREES(dqa_tape_free, w.finished);
    CALL(dqa_tape_clear, w.tape);
    CALL(dqa_tape_clear, w.finished);
    CALL(dqa_tape_n_steps, w.tape, &n);
    CALL(dqa_tape_get_state, w.tape, 0, many, w.n_q, nullptr, 0);
    CALL(dqa_tape_get_state, w.finished, 1, many, w.n_q, nullptr, 0);
    CALL(dqa_tape_get_actuation, w.tape, 0, many, 1);
    CALL(dqa_tape_get_current, w.tape, 0, many, 2);
    CALL(dqa_tape_get_surface, w.finished, 1, many, 2);
    add("dqa_tape_stats", [](World& w) {
        dqa_tape_statistics s;
        return dqa_tape_stats(w.tape, &s, sizeof s);
    });
    INITS(dqa_objective_term_init, dqa_objective_term);
    CALL(dqa_tape_objective, w.tape, &term, 1, many, nullptr);
    MAKES(dqa_adjoint_create, dqa_adjoint, dqa_adjoint_free, w.tape, &made);
    add("dqa_adjoint_create", [](World& w) {  // and kept beyond the callback
        if (w.adjoint && site != kBackward && site != kControlPullback && site != kCurrentPullback) {
            dqa_adjoint_free(w.adjoint);
            w.adjoint = nullptr;
        } else {
            return DQA_ERROR_STATE;
        }
        return dqa_adjoint_create(w.tape, &w.adjoint);
    });
    FREES(dqa_adjoint_free, w.adjoint);
    CALL(dqa_adjoint_seed, w.adjoint, 0, DQA_SEED_POSITION, many, w.n_q);
    CALL(dqa_adjoint_seed_objective, w.adjoint, &term, 1);
    CALL(dqa_adjoint_backward, w.adjoint, 0, nullptr, nullptr);
    CALL(dqa_adjoint_get, w.adjoint, DQA_WRT_ACTUATION, many, steps());
    INITS(dqa_gradient_check_options_init, dqa_gradient_check_options);
    add("dqa_check_gradient", [](World& w) {
        auto o = options_of(dqa_gradient_check_options_init);
        o.with_respect_to = DQA_WRT_CONTROL, o.n_steps = 1;
        dqa_gradient_check_report report;
        return dqa_check_gradient(w.simulator, w.controller, &term, 1, &o, &report, sizeof report);
    });
    add("dqa_adam_step", [](World&) {
        double x = 0, g = 1, r = 0.1, m = 0, v = 0;
        return dqa_adam_step(&x, &g, &r, &m, &v, 1, 1);
    });
    add("dqa_project_simplex", [](World&) {
        double x[2] = {0.4, 0.9};
        return dqa_project_simplex(x, 2);
    });
    INITS(dqa_cma_es_options_init, dqa_cma_es_options);
    MAKES(dqa_cma_es_create, dqa_cma_es, dqa_cma_es_free, nullptr, halves, nullptr, 2, &made);
    FREES(dqa_cma_es_free, w.search);
    add("dqa_cma_es_ask", [](World& w) {
        dqa_cma_es_info info;
        OK(dqa_cma_es_get_info(w.search, &info, sizeof info));
        return dqa_cma_es_ask(w.search, many, info.population * 2);
    });
    CALL(dqa_cma_es_tell, w.search, many, 1);
    CALL(dqa_cma_es_best, w.search, many, 2, nullptr);
    CALL(dqa_cma_es_mean, w.search, many, 2);
    add("dqa_cma_es_get_info", [](World& w) {
        dqa_cma_es_info info;
        return dqa_cma_es_get_info(w.search, &info, sizeof info);
    });
    CALL(dqa_cma_es_save, w.search, "reentry.search");
    MAKES(dqa_cma_es_load, dqa_cma_es, dqa_cma_es_free, "none.search", &made);
    return f;
}

void every_function_is_here(void**) {
    std::ifstream file(DQA_HEADER);
    const std::string header((std::istreambuf_iterator<char>(file)), {});
    assert_true(header.size() > 10000);
    std::set<std::string> missing;
    // The name of a declared function is what stands before the first bracket after DQA_API.
    const std::string mark = "DQA_API ";
    for (auto at = header.find(mark); at != std::string::npos; at = header.find(mark, at + 1)) {
        const auto bracket = header.find('(', at);
        const auto name = header.find_last_of(" *", bracket) + 1;
        if (header.compare(name, 4, "dqa_") == 0) missing.insert(header.substr(name, bracket - name));
    }
    assert_true(missing.size() > 70);
    for (const Function& f : functions()) missing.erase(f.name);
    for (const std::string& name : missing) print_error("%s is not crossed with the callbacks\n", name.c_str());
    assert_true(missing.empty());
}

void cross(Site s) {
    site = s;
    OK(dqa_set_log_handler(s == kReading ? on_log : nullptr, DQA_LOG_DEBUG, nullptr));
    Vector expected;
    {
        World w;
        inside = nullptr;
        OK(outer(w, expected));
    }
    int done = 0, refused = 0;
    std::map<std::string, dqa_status> answers;
    for (const Function& f : functions()) {
        World w;
        dqa_status answer = DQA_ERROR_INTERNAL;
        std::string message;
        inside = [&] {
            answer = f.call(w);
            if (answer != DQA_SUCCESS) message = dqa_last_error();
        };
        Vector got;
        const dqa_status status = outer(w, got);
        assert_true(!inside);  // it was called
        done += answer == DQA_SUCCESS, refused += answer == DQA_ERROR_STATE;
        if (answer == DQA_ERROR_INTERNAL || answer == DQA_ERROR_MEMORY || (answer != DQA_SUCCESS && message.empty()))
            fail_msg("%s in %s: %s, '%s'", f.name.c_str(), kSiteNames[s], dqa_status_name(answer), message.c_str());
        if (status != DQA_SUCCESS && status != DQA_CANCELLED)
            fail_msg("%s in %s leaves %s: %s", f.name.c_str(), kSiteNames[s], dqa_status_name(status),
                     dqa_last_error());
        const bool handles_are_there = !got.empty() && w.simulator && w.adjoint && w.finished;
        if (status == DQA_SUCCESS && handles_are_there && got != expected)
            fail_msg("%s in %s changes the result of the call around it", f.name.c_str(), kSiteNames[s]);
        answers[f.name] = answer;
    }
    print_message("%s: %d calls done, %d refused\n", kSiteNames[s], done, refused);
    OK(dqa_set_log_handler(nullptr, 0, nullptr));
    site = kSites;
    // Calls that would change what is under way.
    const auto is_refused = [&](const char* name) {
        if (answers.at(name) != DQA_ERROR_STATE)
            fail_msg("%s in %s: %s", name, kSiteNames[s], dqa_status_name(answers.at(name)));
    };
    if (s == kBuild)
        for (const char* name :
             {"dqa_shape_space_build", "dqa_shape_space_add_density", "dqa_shape_space_add_actuator"})
            is_refused(name);
    if (s == kSetWeights || s == kRollout || s == kEvaluate || s == kCurrent || s == kCheckGradient)
        for (const char* name : {"dqa_simulator_set_weights", "dqa_simulator_step", "dqa_simulator_set_state"})
            is_refused(name);
    if (s == kRollout || s == kEvaluate || s == kCheckGradient) is_refused("dqa_controller_set_parameters");
    if (s == kBackward || s == kControlPullback || s == kCurrentPullback)
        for (const char* name : {"dqa_adjoint_backward", "dqa_adjoint_seed", "dqa_adjoint_get", "dqa_tape_clear"})
            is_refused(name);
}

template <Site s>
void crossed(void**) {
    cross(s);
}

// An adjoint that would be made while its tape is being recorded, and the tape that would be emptied.
void recording_tapes_are_left_alone(void**) {
    World w;
    site = kRollout;
    dqa_status created = DQA_SUCCESS, cleared = DQA_SUCCESS, read = DQA_ERROR_STATE;
    inside = [&] {
        dqa_adjoint* made = nullptr;
        created = dqa_adjoint_create(w.tape, &made);
        assert_non_null(std::strstr(dqa_last_error(), "tape"));
        cleared = dqa_tape_clear(w.tape);
        std::int64_t n = 0;
        read = dqa_tape_n_steps(w.tape, &n);
        assert_int_equal(n, 1);
    };
    Vector q;
    OK(outer(w, q));
    assert_int_equal(created, DQA_ERROR_STATE);
    assert_int_equal(cleared, DQA_ERROR_STATE);
    assert_int_equal(read, DQA_SUCCESS);
    std::int64_t n = 0;
    OK(dqa_tape_n_steps(w.tape, &n));
    assert_int_equal(n, steps());
    site = kSites;
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(every_function_is_here),    cmocka_unit_test(recording_tapes_are_left_alone),
        cmocka_unit_test(crossed<kBuild>),           cmocka_unit_test(crossed<kSetWeights>),
        cmocka_unit_test(crossed<kRollout>),         cmocka_unit_test(crossed<kEvaluate>),
        cmocka_unit_test(crossed<kCurrent>),         cmocka_unit_test(crossed<kBackward>),
        cmocka_unit_test(crossed<kControlPullback>), cmocka_unit_test(crossed<kCurrentPullback>),
        cmocka_unit_test(crossed<kCheckGradient>),   cmocka_unit_test(crossed<kReading>),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
