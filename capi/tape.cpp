// SPDX-License-Identifier: MIT
// The handles of tape and adjoint, objectives, and the proof of the gradient.
#include <algorithm>
#include <cinttypes>

#include "grid/number_text.hpp"
#include "internal.hpp"

using namespace dqa::capi;
using dqa::fail;
using dqa::Status;

namespace {

dqa_tape_options default_options() {
    dqa_tape_options o{};
    o.struct_size = sizeof o;
    return o;
}

dqa_objective_term default_term() {
    dqa_objective_term t{};
    t.struct_size = sizeof t;
    const dqa::ObjectiveTerm core;
    t.kind = DQA_OBJECTIVE_TRAVEL;
    t.weight = core.weight;
    t.gamma = core.gamma, t.epsilon = core.epsilon;
    return t;
}

dqa_gradient_check_options default_check() {
    const dqa::GradientCheckSettings s;
    dqa_gradient_check_options o{};
    o.struct_size = sizeof o;
    o.with_respect_to = DQA_WRT_WEIGHTS;
    o.n_steps = s.n_steps;
    o.seed = s.seed;
    return o;
}

const dqa::Tape& recorded(const dqa_tape* tape) {
    require(tape, "tape");
    const dqa::Tape& t = *tape->state->tape;
    if (t.empty()) fail(Status::ERROR_STATE, "tape is empty: record at least one step first");
    return t;
}

// States of a tape are computed again on demand, by one call at a time.
class Reading {
public:
    explicit Reading(dqa_tape* tape) : read_(tape, "tape", Beside::changes), state_(*tape->state) {
        // A log handler may come here from within such a call.
        if (state_.reads.load() == std::this_thread::get_id()) refuse_lease("tape");
        state_.reading.lock();
        state_.reads.store(std::this_thread::get_id());
    }
    Reading(const Reading&) = delete;
    Reading& operator=(const Reading&) = delete;
    ~Reading() {
        state_.reads.store({});
        state_.reading.unlock();
    }

private:
    Read<dqa_tape> read_;
    TapeState& state_;
};

void require_step(int64_t step, int64_t last, const char* name) {
    if (step < 0 || step > last)
        fail(Status::ERROR_ARGUMENT, "%s is %" PRId64 ", expected an index in [0, %" PRId64 "]", name, step, last);
}

}  // namespace

namespace dqa::capi {

namespace {

[[noreturn]] void bad_term(std::int64_t k, const char* field, double value, const char* expected) {
    fail(Status::ERROR_ARGUMENT, "terms[%" PRId64 "].%s is %s, expected %s", k, field, number_text(value).c_str(),
         expected);
}

std::vector<ObjectiveTerm::Point> read_path(const dqa_objective_term& t, std::int64_t k, int dims) {
    if (!t.path)
        fail(Status::ERROR_ARGUMENT, "terms[%" PRId64 "].path is NULL, expected points [n_points][1 + dims]", k);
    const std::int64_t row = 1 + dims;
    if (t.n_path < row || t.n_path % row != 0 || t.n_path > (std::int64_t{1} << 40))
        fail(Status::ERROR_ARGUMENT,
             "terms[%" PRId64 "].n_path is %" PRId64 ", expected a multiple of %d: path [n_points][1 + dims]", k,
             t.n_path, static_cast<int>(row));
    std::vector<ObjectiveTerm::Point> out;
    for (const double* at = t.path; at < t.path + t.n_path; at += row) {
        ObjectiveTerm::Point p;
        p.time = at[0];
        for (int a = 0; a < dims; ++a) p.place[static_cast<std::size_t>(a)] = at[1 + a];
        for (int a = 0; a < row; ++a)
            if (!std::isfinite(at[a])) bad_term(k, "path", at[a], "finite numbers");
        if (!out.empty() && !(p.time > out.back().time)) bad_term(k, "path", p.time, "times that increase");
        out.push_back(p);
    }
    return out;
}

}  // namespace

std::vector<ObjectiveTerm> read_terms(const dqa_objective_term* terms, std::int64_t n_terms, int dims) {
    require(terms, "terms");
    if (n_terms < 1 || n_terms > 1000000)
        fail(Status::ERROR_ARGUMENT, "n_terms is %" PRId64 ", expected at least 1", n_terms);
    const std::uint32_t stride = terms->struct_size;
    std::vector<ObjectiveTerm> out;
    for (std::int64_t k = 0; k < n_terms; ++k) {
        const auto* at = reinterpret_cast<const dqa_objective_term*>(reinterpret_cast<const char*>(terms) + k * stride);
        const auto t = read_options(at, default_term(), "terms");
        if (at->struct_size != stride)
            fail(Status::ERROR_ARGUMENT, "terms[%" PRId64 "].struct_size is %u, expected %u as in terms[0]", k,
                 at->struct_size, stride);
        if (t.kind < DQA_OBJECTIVE_TRAVEL || t.kind > DQA_OBJECTIVE_PATH)
            bad_term(k, "kind", t.kind, "one of DQA_OBJECTIVE_*");
        if (!std::isfinite(t.weight)) bad_term(k, "weight", t.weight, "a finite number");
        for (const double x : t.target)
            if (!std::isfinite(x)) bad_term(k, "target", x, "finite coordinates (m)");
        if (!std::isfinite(t.gamma)) bad_term(k, "gamma", t.gamma, "a finite number");
        if (!(t.epsilon > 0 && std::isfinite(t.epsilon))) bad_term(k, "epsilon", t.epsilon, "a finite number > 0");
        ObjectiveTerm term;
        term.kind = static_cast<ObjectiveKind>(t.kind);
        term.weight = t.weight, term.gamma = t.gamma, term.epsilon = t.epsilon;
        std::copy(t.target, t.target + 3, term.target.begin());
        if (term.kind == ObjectiveKind::path) term.path = read_path(t, k, dims);
        out.push_back(std::move(term));
    }
    return out;
}

}  // namespace dqa::capi

extern "C" {

dqa_status dqa_tape_options_init(dqa_tape_options* options, uint64_t size) {
    return guard([&] { init_options(options, size, default_options(), "options"); });
}

dqa_status dqa_tape_create(dqa_simulator* simulator, const dqa_tape_options* options, dqa_tape** tape) {
    return guard([&] {
        begin_create(tape, "tape");
        require(simulator, "simulator");
        const auto o = read_options(options, default_options(), "options");
        require_range(o.flags, o.flags == 0, "flags", "0");
        if (o.memory_bytes < 0)
            fail(Status::ERROR_ARGUMENT, "memory_bytes is %" PRId64 ", expected a number >= 0", o.memory_bytes);
        auto made = std::make_unique<dqa_tape>();
        made->state = std::make_shared<TapeState>(o.memory_bytes);
        made->state->simulator = simulator->identity;
        made->state->simulator_adjoint_iterations = simulator->adjoint_iterations;
        *tape = made.release();
    });
}

void dqa_tape_free(dqa_tape* tape) {
    free_handle(tape);
}

dqa_status dqa_tape_clear(dqa_tape* tape) {
    return guard([&] {
        const Change change(tape, "tape");
        if (tape->state->adjoints > 0) fail(Status::ERROR_STATE, "tape: an adjoint of it lives; free it first");
        tape->state->tape->clear();
        tape->state->reader.reset();
    });
}

dqa_status dqa_tape_n_steps(const dqa_tape* tape, int64_t* n_steps) {
    return guard([&] {
        require(tape, "tape"), require(n_steps, "n_steps");
        *n_steps = tape->state->tape->n_steps();
    });
}

dqa_status dqa_tape_get_state(dqa_tape* tape, int64_t step, double* q, int64_t nq, double* v, int64_t nv) {
    return guard([&] {
        const dqa::Tape& t = recorded(tape);
        require_step(step, t.n_steps(), "step");
        const int dims = t.design().set().box.dims;
        const int64_t n = static_cast<int64_t>(t.design().n_nodes()) * dims;
        if (q) require_count(nq, n, "nq", "q [n_nodes][dims]");
        if (v) require_count(nv, n, "nv", "v [n_nodes][dims]");
        if (!q && !v) return;
        const Reading reading(tape);
        const dqa::State& state = tape->state->reader.state(static_cast<long>(step));
        points_out(state.q.data(), state.q.size() / 3, dims, q);
        points_out(state.v.data(), state.v.size() / 3, dims, v);
    });
}

dqa_status dqa_tape_get_actuation(dqa_tape* tape, int64_t step, double* actuation, int64_t n) {
    return guard([&] {
        const dqa::Tape& t = recorded(tape);
        require(actuation, "actuation");
        require_step(step, t.n_steps() - 1, "step");
        copy_out(t.actuation(step).data(), t.actuation(step).size(), actuation, n, "n", "actuation [n_signals]");
    });
}

dqa_status dqa_tape_get_current(dqa_tape* tape, int64_t step, double* current, int64_t n) {
    return guard([&] {
        const dqa::Tape& t = recorded(tape);
        require(current, "current");
        require_step(step, t.n_steps() - 1, "step");
        const int dims = t.design().set().box.dims;
        require_count(n, dims, "n", "current [dims]");
        points_out(t.current(step).data(), 1, dims, current);
    });
}

dqa_status dqa_tape_get_surface(dqa_tape* tape, int64_t step, double* vertices, int64_t nv) {
    return guard([&] {
        const dqa::Tape& t = recorded(tape);
        require(vertices, "vertices");
        require_step(step, t.n_steps(), "step");
        const int dims = t.design().set().box.dims;
        require_count(nv, dims * static_cast<int64_t>(t.design().surface().vertices.size()), "nv",
                      "vertices [n_vertices][dims]");
        const Reading reading(tape);
        const auto x = t.design().carry_surface(tape->state->reader.state(static_cast<long>(step)).q.data());
        for (std::size_t k = 0; k < x.size(); ++k)
            points_out(x[k].data(), 1, dims, vertices + dims * static_cast<int64_t>(k));
    });
}

dqa_status dqa_tape_stats(const dqa_tape* tape, dqa_tape_statistics* statistics, uint64_t size) {
    return guard([&] {
        require(tape, "tape");
        const TapeState& state = *tape->state;
        const auto& s = state.tape->statistics();
        dqa_tape_statistics out{};
        out.steps = state.tape->n_steps();
        out.bytes = s.bytes;
        out.newton_iterations = s.newton_iterations, out.linear_iterations = s.linear_iterations;
        out.adjoint_iterations = state.adjoint_iterations.load();
        out.worst_residual = s.worst_residual;
        out.checkpoints = state.tape->n_kept();
        out.recomputed_steps = state.tape->recomputed_steps();
        out.rescued_steps = s.rescued_steps, out.indefinite_steps = s.indefinite_steps;
        out.worst_adjoint_residual = state.worst_adjoint_residual.load();
        write_struct(statistics, size, out, "statistics");
    });
}

dqa_status dqa_objective_term_init(dqa_objective_term* term, uint64_t size) {
    return guard([&] { init_options(term, size, default_term(), "term"); });
}

dqa_status dqa_tape_objective(dqa_tape* tape, const dqa_objective_term* terms, int64_t n_terms, double* loss,
                              double* per_term) {
    return guard([&] {
        const dqa::Tape& t = recorded(tape);
        const auto list = read_terms(terms, n_terms, t.design().set().box.dims);
        require(loss, "loss");
        *loss = t.objective(list, per_term);
    });
}

dqa_status dqa_adjoint_create(dqa_tape* tape, dqa_adjoint** adjoint) {
    return guard([&] {
        begin_create(adjoint, "adjoint");
        recorded(tape);
        const Read reads(tape, "tape");
        auto made = std::make_unique<dqa_adjoint>();
        made->core = std::make_unique<dqa::Adjoint>(tape->state->tape);
        made->cancel = tape->state->tape->design().scene().cancel;
        made->state = tape->state;
        ++made->state->adjoints;
        *adjoint = made.release();
    });
}

void dqa_adjoint_free(dqa_adjoint* adjoint) {
    free_handle(adjoint);
}

dqa_status dqa_adjoint_seed(dqa_adjoint* adjoint, int64_t step, int32_t quantity, const double* bar, int64_t n) {
    return guard([&] {
        const Change change(adjoint, "adjoint");
        require(bar, "bar");
        dqa::Adjoint& a = *adjoint->core;
        require_step(step, a.tape().n_steps(), "step");
        require_range(quantity, quantity == DQA_SEED_POSITION || quantity == DQA_SEED_VELOCITY, "quantity",
                      "DQA_SEED_POSITION or DQA_SEED_VELOCITY");
        const int dims = a.tape().design().set().box.dims;
        require_count(n, static_cast<int64_t>(a.tape().design().n_nodes()) * dims, "n", "bar [n_nodes][dims]");
        require_finite(bar, n, "bar");
        const auto field = points_in(bar, n, dims);
        if (step > a.position())
            fail(Status::ERROR_STATE, "step is %" PRId64 ", expected at most %ld: the sweep has passed it", step,
                 a.position());
        if (quantity == DQA_SEED_POSITION)
            a.seed_position(static_cast<long>(step), field.data());
        else
            a.seed_velocity(static_cast<long>(step), field.data());
    });
}

dqa_status dqa_adjoint_seed_objective(dqa_adjoint* adjoint, const dqa_objective_term* terms, int64_t n_terms) {
    return guard([&] {
        const Change change(adjoint, "adjoint");
        adjoint->core->seed_objective(read_terms(terms, n_terms, adjoint->core->tape().design().set().box.dims));
    });
}

dqa_status dqa_adjoint_backward(dqa_adjoint* adjoint, int64_t to_step, dqa_progress progress, void* user_data) {
    return guard([&] {
        const Change change(adjoint, "adjoint");
        dqa::Adjoint& a = *adjoint->core;
        require_step(to_step, a.tape().n_steps(), "to_step");
        if (to_step > a.position())
            fail(Status::ERROR_STATE, "to_step is %" PRId64 ", expected at most %ld: the sweep has passed it", to_step,
                 a.position());
        const auto account = [&] {
            const std::int64_t fresh = a.iterations() - adjoint->counted;
            adjoint->counted = a.iterations();
            adjoint->state->adjoint_iterations += fresh;
            *adjoint->state->simulator_adjoint_iterations += fresh;
            if (a.worst_residual() > adjoint->state->worst_adjoint_residual.load())
                adjoint->state->worst_adjoint_residual.store(a.worst_residual());
        };
        check_cancel(adjoint->cancel);
        try {
            a.backward(static_cast<long>(to_step), [&](long done, long total) {
                check_cancel(done < total ? adjoint->cancel : nullptr);
                if (progress && progress(done, total, user_data))
                    fail(Status::CANCELLED, "cancelled by the progress callback");
            });
        } catch (...) {
            account();
            throw;
        }
        account();
    });
}

dqa_status dqa_adjoint_get(dqa_adjoint* adjoint, int32_t with_respect_to, double* out, int64_t n) {
    return guard([&] {
        const Change change(adjoint, "adjoint");
        require(out, "out");
        dqa::Adjoint& a = *adjoint->core;
        require_range(with_respect_to, with_respect_to >= DQA_WRT_WEIGHTS && with_respect_to <= DQA_WRT_LAME,
                      "with_respect_to", "one of DQA_WRT_*");
        if (with_respect_to != DQA_WRT_ACTUATION && with_respect_to != DQA_WRT_CURRENT &&
            (!a.begun() || a.position() > 0))
            fail(Status::ERROR_STATE,
                 "the sweep stands at step %ld, expected 0: call dqa_adjoint_backward(adjoint, 0, ...) first",
                 a.position());
        const auto give = [&](const std::vector<double>& values, const char* shape) {
            copy_out(values.data(), values.size(), out, n, "n", shape);
        };
        const int dims = a.tape().design().set().box.dims;
        const auto give_nodes = [&](const std::vector<double>& values) {
            require_count(n, static_cast<int64_t>(values.size() / 3) * dims, "n", "[n_nodes][dims]");
            points_out(values.data(), values.size() / 3, dims, out);
        };
        const auto give_rows = [&](const std::vector<dqa::Vec3>& rows, const char* shape) {
            require_count(n, static_cast<int64_t>(rows.size()) * dims, "n", shape);
            for (std::size_t k = 0; k < rows.size(); ++k)
                points_out(rows[k].data(), 1, dims, out + dims * static_cast<int64_t>(k));
        };
        switch (with_respect_to) {
            case DQA_WRT_WATER: {
                std::vector<double> values = a.water_bar();
                if (dims == 2) values.erase(values.begin() + 2);
                give(values, "[dims + 9]");
                break;
            }
            case DQA_WRT_CURRENT:
                give_rows(a.current_bar(), "[n_steps][dims]");
                break;
            case DQA_WRT_YOUNGS_MODULUS:
                give(a.material_bar().young, "[n_cells]");
                break;
            case DQA_WRT_MUSCLE_STIFFNESS:
                give(a.material_bar().muscle, "[n_cells]");
                break;
            case DQA_WRT_MATERIAL:
                give(dqa::material_vector(a.material_bar()), "[4]");
                break;
            case DQA_WRT_LAME:
                give({a.material_bar().lame_mu, a.material_bar().lame_lambda}, "[2]");
                break;
            case DQA_WRT_CURRENT_TABLE:
                give_rows(a.current_table_bar(), "[n_times][dims]");
                break;
            case DQA_WRT_WEIGHTS:
                require_count(n, static_cast<int64_t>(a.tape().design().space().bases().size()), "n", "[n_bases]");
                give(a.weights_bar(), "[n_bases]");
                break;
            case DQA_WRT_CONTROL:
                give(a.control_bar(), "[n_parameters]");
                break;
            case DQA_WRT_ACTUATION:
                give(a.actuation_bar(), "[n_steps][n_signals]");
                break;
            case DQA_WRT_INITIAL_POSITION:
                give_nodes(a.position_bar());
                break;
            default:
                give_nodes(a.velocity_bar());
                break;
        }
    });
}

dqa_status dqa_gradient_check_options_init(dqa_gradient_check_options* options, uint64_t size) {
    return guard([&] { init_options(options, size, default_check(), "options"); });
}

dqa_status dqa_check_gradient(const dqa_simulator* simulator, const dqa_controller* controller,
                              const dqa_objective_term* terms, int64_t n_terms,
                              const dqa_gradient_check_options* options, dqa_gradient_check_report* report,
                              uint64_t report_size) {
    return guard([&] {
        const dqa::Simulation& simulation = design_of(simulator);
        const Read reads_simulator(simulator, "simulator", Beside::changes);
        const Read reads_controller(controller, "controller");
        const auto list = read_terms(terms, n_terms, simulation.design().set().box.dims);
        const auto o = read_options(options, default_check(), "options");
        require(report, "report");
        if (report_size < 8)
            fail(Status::ERROR_ARGUMENT, "report_size is %" PRIu64 ", expected sizeof of the struct", report_size);
        require_range(o.flags, o.flags == 0, "flags", "0");
        require_range(o.with_respect_to, o.with_respect_to >= DQA_WRT_WEIGHTS && o.with_respect_to <= DQA_WRT_LAME,
                      "with_respect_to", "one of DQA_WRT_*");
        require_range(o.n_steps, o.n_steps >= 1 && o.n_steps <= 10000, "n_steps", "a number in [1, 10000]");
        require_range(o.step, o.step >= 0, "step", "a number >= 0");
        if (controller && controller->core->n_signals() != simulation.design().n_signals())
            fail(Status::ERROR_ARGUMENT, "controller has %d signals, expected %d", controller->core->n_signals(),
                 simulation.design().n_signals());
        if (controller) require_sensors(*controller->core, simulation.design());
        dqa::GradientCheckSettings s;
        s.quantity = static_cast<dqa::WithRespectTo>(o.with_respect_to);
        s.n_steps = o.n_steps, s.seed = o.seed, s.step = o.step;
        const auto r = dqa::check_gradient(simulation, controller ? controller->core.get() : nullptr, list, s);
        dqa_gradient_check_report out{};
        out.one_sided = r.one_sided ? 1 : 0;
        out.adjoint = r.adjoint, out.finite_difference = r.finite_difference, out.relative_error = r.relative_error;
        out.taylor_slope = r.taylor_slope, out.gradient_norm = r.gradient_norm, out.step = r.step;
        write_struct(report, report_size, out, "report");
    });
}

}  // extern "C"
