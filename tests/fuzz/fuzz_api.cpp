// SPDX-License-Identifier: MIT
// Fuzzing of sequences of calls: the bytes choose functions, handles (also missing ones), options and numbers of a
// small scene. Each call does what it says or is an error; what it gives with DQA_SUCCESS is finite.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "bytes.hpp"
#include "diffaqua.h"

namespace {

using Vector = std::vector<double>;

void require_finite(dqa_status status, const Vector& values, const char* what) {
    if (status != DQA_SUCCESS) return;
    for (const double v : values)
        if (!std::isfinite(v)) {
            std::fprintf(stderr, "%s: not finite, with success\n", what);
            std::abort();
        }
}

std::int64_t count(const Vector& v) {
    return static_cast<std::int64_t>(v.size());
}

// An init function's options with some fields replaced by what the bytes say; pointers [pointer, pointer + 8) stay.
template <class T>
T options(dqa_status (*init)(T*, std::uint64_t), fuzz::Bytes& in, std::size_t pointer = 0) {
    T o;
    if (init(&o, sizeof o) != DQA_SUCCESS) std::abort();
    for (int edits = in.below(4); edits > 0; --edits) {
        const std::size_t at = 4 * (static_cast<std::size_t>(in.byte()) % (sizeof o / 4));
        if (at == 0) continue;  // struct_size says how much memory there is: a lie of the caller's that nobody can see
        const bool wide = in.below(2) == 0 && at % 8 == 0;
        const std::size_t size = wide ? 8 : 4;
        if (at + size > pointer && at < pointer + 8 && pointer > 0) continue;
        if (wide && in.below(2) == 0) {
            const double value = in.number();
            std::memcpy(reinterpret_cast<char*>(&o) + at, &value, size);
        } else {
            const std::int64_t value = in.integer();
            std::memcpy(reinterpret_cast<char*>(&o) + at, &value, size);
        }
    }
    return o;
}

// Legal work that is only long is cut; what is refused stays.
template <class T>
void at_most(T& value, T least_refused, T most) {
    if (value > most && value < least_refused) value = most;
}

class Session {
public:
    explicit Session(fuzz::Bytes& in) : in_(in) {}
    ~Session() { free_all(); }
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    void run() {
        start();
        for (int calls = 0; calls < 60 && !in_.over(); ++calls) call(in_.below(34));
    }

private:
    void free_all() {
        dqa_adjoint_free(adjoint_), dqa_tape_free(tape_), dqa_controller_free(controller_);
        dqa_simulator_free(simulator_), dqa_shape_space_free(space_), dqa_cma_es_free(search_);
    }

    // A scene that works, so that most bytes are not spent on reaching one.
    void start() {
        new_space();
        add_density(), add_density();
        dqa_shape_space_build(space_, nullptr, nullptr);
        new_simulator();
        const double half[2] = {0.5, 0.5};
        dqa_simulator_set_weights(simulator_, half, 2, nullptr, nullptr);
        dqa_controller_create_sinusoid(1, 0.02, &controller_);
        dqa_tape_create(simulator_, nullptr, &tape_);
    }

    void new_space() {
        dqa_shape_space_free(space_);
        auto o = options(dqa_shape_space_options_init, in_, offsetof(dqa_shape_space_options, cancel));
        if (o.cells_x == 60) o.cells_x = 14;
        if (o.cells_y == 16) o.cells_y = 8;
        if (o.cells_z == 26) o.cells_z = 8;
        if (in_.below(2) == 0) o.dims = 2;
        if (o.sigma == 0.4) o.sigma = 0.8;
        for (std::int32_t* cells : {&o.cells_x, &o.cells_y, &o.cells_z}) at_most(*cells, 513, 20);
        at_most(o.max_iterations, INT32_MAX, 100);
        at_most(o.refinement, std::int64_t(5), std::int64_t(2));
        at_most(o.threads, INT32_MAX, 3);
        dqa_shape_space_create(&o, &space_);
    }

    void new_simulator() {
        dqa_simulator_free(simulator_);
        auto o = options(dqa_simulator_options_init, in_, offsetof(dqa_simulator_options, cancel));
        at_most(o.max_products, INT64_MAX, std::int64_t(500));
        at_most(o.threads, INT32_MAX, 3);
        at_most(o.max_newton, INT32_MAX, 20);
        at_most(o.max_linear, INT32_MAX, 500);
        dqa_simulator_create(space_, &o, &simulator_);
    }

    void sizes() {
        space_info_ = {}, info_ = {};
        dqa_shape_space_get_info(space_, &space_info_, sizeof space_info_);
        dqa_simulator_get_info(simulator_, &info_, sizeof info_);
    }

    // As many as are wanted, sometimes one more or less.
    Vector numbers(std::int64_t n, double usual) {
        const int odd = in_.byte();
        n = std::max<std::int64_t>(0, odd == 255 ? n + 1 : odd == 254 ? n - 1 : n);
        Vector v(static_cast<std::size_t>(n), usual);
        for (int k = in_.below(3); k > 0 && n > 0; --k) {
            const auto at = static_cast<std::size_t>(in_.byte()) * 7 % v.size();
            v[at] = in_.number();
        }
        return v;
    }

    void add_density() {
        sizes();
        const std::int64_t layers = space_info_.cells_z, rows = space_info_.cells_y;
        Vector cells = numbers(space_info_.n_cells, 0.0);
        for (std::size_t c = 0; c < cells.size() && cells.size() == static_cast<std::size_t>(space_info_.n_cells);
             ++c) {
            const auto at = static_cast<std::int64_t>(c);
            const double x = static_cast<double>(at / (rows * layers)) - 0.5 * space_info_.cells_x + 0.5,
                         y = static_cast<double>(at / layers % rows) - 3.5,
                         z = layers > 1 ? static_cast<double>(at % layers) - 3.5 : 0.0;
            if (cells[c] == 0.0 && x * x / 30 + y * y / 6 + z * z / 8 < 1) cells[c] = 1.0;
        }
        dqa_shape_space_add_density(space_, "body", cells.data(), count(cells), nullptr);
    }

    void add_outlines() {
        Vector corners;
        for (int k = in_.below(8); k > 0; --k) corners.push_back(in_.number()), corners.push_back(in_.number());
        dqa_shape_space_add_polygon(space_, "corners", corners.data(), count(corners) / 2, nullptr);
        const Vector pixels = numbers(12, 1.0);
        dqa_shape_space_add_image(space_, nullptr, pixels.data(), 3, in_.integer() % 16, nullptr);
        Vector vertices = numbers(12, 0.0);
        if (vertices.size() == 12) vertices[3] += 1.0, vertices[7] += 1.0, vertices[11] += 1.0;
        std::int32_t triangles[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
        if (in_.below(4) == 0) triangles[in_.below(12)] = static_cast<std::int32_t>(in_.integer());
        dqa_shape_space_add_mesh(space_, "mesh", vertices.data(), count(vertices) / 3, triangles, 4, nullptr);
    }

    void call(int which) {
        sizes();
        const std::int64_t state = info_.n_nodes * info_.dims;
        switch (which) {
            case 0:
                new_space();
                break;
            case 1:
                add_density();
                break;
            case 2:
                add_outlines();
                break;
            case 3: {
                const auto o = options(dqa_actuator_options_init, in_);
                dqa_shape_space_add_actuator(space_, static_cast<std::int32_t>(in_.integer()), &o);
                break;
            }
            case 4:
                dqa_shape_space_build(space_, nullptr, nullptr);
                break;
            case 5: {
                const Vector w = numbers(space_info_.n_bases, 1.0 / std::max(space_info_.n_bases, 1));
                Vector p(static_cast<std::size_t>(space_info_.n_cells), 0.0), bar = p;
                require_finite(dqa_shape_space_density(space_, w.data(), count(w), p.data(), count(p)), p, "density");
                Vector w_bar(w.size());
                if (!bar.empty()) bar[bar.size() / 2] = 1.0;
                require_finite(
                    dqa_shape_space_pullback(space_, w.data(), count(w), bar.data(), count(bar), w_bar.data()), w_bar,
                    "pullback");
                break;
            }
            case 6:
                new_simulator();
                break;
            case 7:
            case 8: {
                const Vector w = numbers(info_.n_bases, 1.0 / std::max(info_.n_bases, 1));
                dqa_simulator_set_weights(simulator_, w.data(), count(w), nullptr, nullptr);
                break;
            }
            case 9: {
                const Vector e = numbers(space_info_.n_cells, 1e6), m = numbers(count(e), 1e6);
                dqa_simulator_set_material(simulator_, e.data(), m.data(), std::min(count(e), count(m)));
                break;
            }
            case 10: {
                std::int32_t nodes[3];
                for (std::int32_t& node : nodes) node = static_cast<std::int32_t>(in_.integer());
                dqa_simulator_set_fixed_nodes(simulator_, nodes, in_.below(4));
                break;
            }
            case 11: {
                const Vector t{in_.number(), in_.number()}, v = numbers(2 * info_.dims, 0.1);
                dqa_simulator_set_current_table(simulator_, t.data(), 2, v.data(), count(v));
                break;
            }
            case 12:
            case 13:
            case 14: {
                const Vector a = numbers(info_.n_signals, 0.3);
                dqa_simulator_step(simulator_, a.data(), count(a), in_.below(3) == 0 ? nullptr : tape_);
                read_state();
                break;
            }
            case 15:
            case 16:
            case 17:
                dqa_simulator_rollout(simulator_, controller_, in_.below(4) == 0 ? in_.integer() % 4 : 2, tape_,
                                      nullptr, nullptr);
                read_state();
                break;
            case 18: {
                Vector q(static_cast<std::size_t>(state)), v = numbers(state, 0.0);
                dqa_simulator_get_state(simulator_, q.data(), state, nullptr, 0);
                if (!q.empty() && in_.below(2) == 0) q[q.size() / 3] += in_.number();
                dqa_simulator_set_state(simulator_, q.data(), count(q), v.data(), count(v));
                break;
            }
            case 19:
                dqa_controller_free(controller_);
                dqa_controller_create_sinusoid(static_cast<std::int32_t>(in_.below(4) == 0 ? in_.integer() : 1),
                                               in_.below(2) == 0 ? in_.number() : 0.02, &controller_);
                break;
            case 20: {
                dqa_controller_free(controller_);
                auto o = options(dqa_mlp_options_init, in_);
                for (std::int32_t& neurons : o.hidden) at_most(neurons, 65537, 8);
                dqa_controller_create_mlp(&o, &controller_);
                break;
            }
            case 21: {
                std::int64_t n = 0;
                dqa_controller_n_parameters(controller_, &n);
                const Vector theta = numbers(n, 0.5);
                dqa_controller_set_parameters(controller_, theta.data(), count(theta));
                break;
            }
            case 22: {
                Vector sensors = numbers(15, 0.1), out(static_cast<std::size_t>(info_.n_signals));
                require_finite(dqa_controller_evaluate(controller_, in_.integer(), sensors.data(), count(sensors),
                                                       out.data(), count(out)),
                               out, "actuation");
                break;
            }
            case 23: {
                dqa_tape_free(tape_);
                const auto o = options(dqa_tape_options_init, in_);
                dqa_tape_create(simulator_, &o, &tape_);
                break;
            }
            case 24:
                dqa_tape_clear(tape_);
                break;
            case 25:
            case 26:
            case 27:
                sweep(in_.below(4) == 0);
                break;
            case 28:
                check_gradient();
                break;
            case 29:
                search();
                break;
            case 30: {
                Vector x = numbers(3, 0.5), g = numbers(3, 1.0), r = numbers(3, 0.1), a(3), b(3);
                if (x.size() != 3 || g.size() != 3 || r.size() != 3) break;
                require_finite(dqa_adam_step(x.data(), g.data(), r.data(), a.data(), b.data(), 3,
                                             in_.below(4) == 0 ? in_.integer() : 0),
                               x, "Adam");
                require_finite(dqa_project_simplex(x.data(), 3), x, "projection");
                break;
            }
            case 31: {
                const Vector w = numbers(info_.n_bases, 1.0 / std::max(info_.n_bases, 1));
                Vector found(2);
                require_finite(
                    dqa_simulator_suggest_threshold(simulator_, w.data(), count(w), in_.number(), &found[0], &found[1]),
                    found, "threshold");
                break;
            }
            case 32: {
                Vector q(static_cast<std::size_t>(state));
                require_finite(dqa_tape_get_state(tape_, in_.integer(), q.data(), state, nullptr, 0), q, "tape");
                break;
            }
            default: {  // a parent goes before its children
                dqa_simulator_free(simulator_);
                simulator_ = nullptr;
                break;
            }
        }
    }

    void read_state() {
        const std::int64_t state = info_.n_nodes * info_.dims;
        Vector q(static_cast<std::size_t>(state)), v = q;
        const dqa_status status = dqa_simulator_get_state(simulator_, q.data(), state, v.data(), state);
        require_finite(status, q, "positions"), require_finite(status, v, "velocities");
        Vector s(static_cast<std::size_t>(info_.n_sensors)), f(4 * static_cast<std::size_t>(info_.dims));
        require_finite(dqa_simulator_sensors(simulator_, s.data(), count(s)), s, "sensors");
        require_finite(dqa_simulator_forces(simulator_, f.data(), count(f)), f, "forces");
    }

    dqa_objective_term term() {
        auto t = options(dqa_objective_term_init, in_, offsetof(dqa_objective_term, path));
        if (t.path == nullptr && t.n_path > 0 && in_.below(2) == 0) t.n_path = 0;
        return t;
    }

    void sweep(bool partly) {
        const dqa_objective_term terms[2] = {term(), term()};
        Vector loss(3);
        require_finite(dqa_tape_objective(tape_, terms, 1 + in_.below(2), &loss[0], &loss[1]), loss, "loss");
        dqa_adjoint_free(adjoint_);
        dqa_adjoint_create(tape_, &adjoint_);
        if (in_.below(3) == 0) {
            const Vector bar = numbers(info_.n_nodes * info_.dims, 1e-3);
            dqa_adjoint_seed(adjoint_, in_.integer(), static_cast<std::int32_t>(in_.below(6)), bar.data(), count(bar));
        }
        dqa_adjoint_seed_objective(adjoint_, terms, 1);
        dqa_adjoint_backward(adjoint_, partly ? in_.integer() : 0, nullptr, nullptr);
        for (std::int32_t wrt = -1; wrt < 14; ++wrt) {
            std::int64_t n = 1;
            std::int64_t steps = 0, parameters = 0;
            dqa_tape_n_steps(tape_, &steps), dqa_controller_n_parameters(controller_, &parameters);
            const std::int64_t sizes[] = {info_.n_bases,
                                          parameters,
                                          steps * info_.n_signals,
                                          info_.n_nodes * info_.dims,
                                          info_.n_nodes * info_.dims,
                                          info_.dims + 9,
                                          steps * info_.dims,
                                          info_.dims,
                                          space_info_.n_cells,
                                          space_info_.n_cells,
                                          4,
                                          2};
            if (wrt >= 0 && wrt < 12) n = sizes[wrt];
            Vector out(static_cast<std::size_t>(std::max<std::int64_t>(n, 0)));
            require_finite(dqa_adjoint_get(adjoint_, wrt, out.data(), count(out)), out, "gradient");
        }
    }

    void check_gradient() {
        auto o = options(dqa_gradient_check_options_init, in_);
        if (o.n_steps > 1) o.n_steps = 1;
        const dqa_objective_term t = term();
        dqa_gradient_check_report report;
        (void)dqa_check_gradient(simulator_, controller_, &t, 1, &o, &report, sizeof report);
    }

    void search() {
        auto o = options(dqa_cma_es_options_init, in_);
        at_most(o.population, INT64_MAX, std::int64_t(16));
        const Vector mean = numbers(3, 0.1), scales = numbers(3, 1.0);
        dqa_cma_es_free(search_);
        if (mean.size() != 3 || scales.size() != 3 || dqa_cma_es_create(&o, mean.data(), scales.data(), 3, &search_))
            return;
        for (int generation = in_.below(4); generation > 0; --generation) {
            dqa_cma_es_info info;
            if (dqa_cma_es_get_info(search_, &info, sizeof info) != DQA_SUCCESS) return;
            Vector x(static_cast<std::size_t>(3 * info.population));
            require_finite(dqa_cma_es_ask(search_, x.data(), count(x)), x, "candidates");
            const Vector values = numbers(info.population, 1.0);
            dqa_cma_es_tell(search_, values.data(), count(values));
            Vector best(4);
            require_finite(dqa_cma_es_mean(search_, best.data(), 3), best, "mean");
        }
    }

    fuzz::Bytes& in_;
    dqa_shape_space* space_ = nullptr;
    dqa_simulator* simulator_ = nullptr;
    dqa_controller* controller_ = nullptr;
    dqa_tape* tape_ = nullptr;
    dqa_adjoint* adjoint_ = nullptr;
    dqa_cma_es* search_ = nullptr;
    dqa_shape_space_info space_info_{};
    dqa_simulator_info info_{};
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes in(data, size);
    Session(in).run();
    return 0;
}
