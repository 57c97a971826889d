// SPDX-License-Identifier: MIT
// The simulator's handle.
#include <chrono>
#include <cinttypes>
#include <limits>
#include <optional>

#include "grid/log.hpp"
#include "grid/number_text.hpp"
#include "internal.hpp"
#include "motion/observation.hpp"
#include "motion/threshold.hpp"

using namespace dqa::capi;
using dqa::fail;
using dqa::Status;

namespace {

dqa_simulator_options default_options() {
    const dqa::SceneSettings s;
    dqa_simulator_options o{};
    o.struct_size = sizeof o;
    o.threads = s.threads;
    o.method = DQA_METHOD_NEWTON_PCG;
    o.water = DQA_WATER_IMPLICIT;
    o.quadrature = static_cast<int32_t>(s.quadrature);
    o.max_newton = s.max_newton, o.max_linear = s.max_linear, o.max_products = s.max_products;
    o.time_step = s.time_step;
    o.young_modulus = s.young_modulus, o.poisson_ratio = s.poisson_ratio, o.density = s.density;
    o.muscle_stiffness = s.muscle_stiffness, o.contraction = s.contraction;
    o.threshold = s.threshold, o.occupancy_floor = s.occupancy_floor;
    o.tolerance = s.tolerance, o.adjoint_tolerance = s.adjoint_tolerance;
    o.water_density = s.hydrodynamics.density;
    for (std::size_t k = 0; k < 4; ++k) {
        o.drag_coefficients[k] = s.hydrodynamics.drag[k];
        o.thrust_coefficients[k] = s.hydrodynamics.thrust[k];
    }
    o.speed_smoothing = s.hydrodynamics.speed_smoothing;
    o.angle_smoothing = s.hydrodynamics.angle_smoothing;
    o.surface_smoothing = s.hydrodynamics.surface_smoothing;
    return o;
}

dqa::SceneSettings settings_from(const dqa_simulator_options& o) {
    require_range(o.flags, o.flags == 0, "flags", "0");
    require_range(o.threads, o.threads >= 1 && o.threads <= 1024, "threads", "a number in [1, 1024]");
    require_range(o.method, o.method >= DQA_METHOD_NEWTON_PCG && o.method <= DQA_METHOD_PROJECTIVE, "method",
                  "one of DQA_METHOD_*");
    require_range(o.integrator, o.integrator == DQA_INTEGRATOR_IMPLICIT_EULER || o.integrator == DQA_INTEGRATOR_BDF2,
                  "integrator", "DQA_INTEGRATOR_IMPLICIT_EULER or DQA_INTEGRATOR_BDF2");
    require_range(o.material, o.material >= DQA_MATERIAL_COROTATED && o.material <= DQA_MATERIAL_NEO_HOOKEAN,
                  "material", "one of DQA_MATERIAL_*");
    require_range(o.quadrature, o.quadrature == DQA_QUADRATURE_FULL || o.quadrature == DQA_QUADRATURE_REDUCED,
                  "quadrature", "DQA_QUADRATURE_FULL or DQA_QUADRATURE_REDUCED");
    require_range(o.padding, o.padding == 0, "padding", "0");
    require_range(o.planar, o.planar == 0 || o.planar == 1, "planar", "0 or 1");
    require_range(o.preconditioner,
                  o.preconditioner == DQA_PRECONDITIONER_MULTILEVEL || o.preconditioner == DQA_PRECONDITIONER_FACTOR,
                  "preconditioner", "DQA_PRECONDITIONER_MULTILEVEL or DQA_PRECONDITIONER_FACTOR");
    require_range(o.water, o.water >= DQA_WATER_NONE && o.water <= DQA_WATER_EXPLICIT, "water", "one of DQA_WATER_*");
    require_range(o.water_faces, o.water_faces == DQA_FACES_BOTH || o.water_faces == DQA_FACES_WINDWARD, "water_faces",
                  "DQA_FACES_BOTH or DQA_FACES_WINDWARD");
    require_range(o.linear_precision,
                  o.linear_precision == DQA_PRECISION_SINGLE || o.linear_precision == DQA_PRECISION_DOUBLE,
                  "linear_precision", "DQA_PRECISION_SINGLE or DQA_PRECISION_DOUBLE");
    require_range(o.max_newton, o.max_newton >= 1, "max_newton", "at least 1");
    require_range(o.max_linear, o.max_linear >= 1, "max_linear", "at least 1");
    require_range(static_cast<double>(o.max_products), o.max_products >= 1, "max_products", "at least 1");
    require_range(o.instruction_set, o.instruction_set >= 0 && o.instruction_set <= 3, "instruction_set",
                  "a number in [0, 3]");
    const auto positive = [](double value, const char* name, const char* expected) {
        require_range(value, value >= 1e-12 && value <= 1e18, name, expected);
    };
    require_time_step(o.time_step);
    positive(o.young_modulus, "young_modulus", "a modulus in [1e-12, 1e18] (Pa)");
    require_range(o.poisson_ratio, o.poisson_ratio >= 0 && o.poisson_ratio < 0.5, "poisson_ratio",
                  "a number in [0, 0.5)");
    positive(o.density, "density", "a density in [1e-12, 1e18] (kg/m^3)");
    require_range(o.muscle_stiffness, o.muscle_stiffness >= 0 && o.muscle_stiffness <= 1e18, "muscle_stiffness",
                  "a modulus in [0, 1e18] (Pa)");
    require_range(o.contraction, o.contraction > 0 && o.contraction < 1, "contraction", "a number in (0, 1)");
    require_range(o.threshold, o.threshold >= 0 && o.threshold < 0.5, "threshold", "a number in [0, 0.5)");
    require_range(o.occupancy_floor, o.occupancy_floor >= 1e-12 && o.occupancy_floor <= 0.1, "occupancy_floor",
                  "a number in [1e-12, 0.1]");
    require_range(o.tolerance, o.tolerance > 0 && o.tolerance < 1, "tolerance", "a number in (0, 1)");
    require_range(o.adjoint_tolerance, o.adjoint_tolerance >= 0 && o.adjoint_tolerance < 1, "adjoint_tolerance",
                  "a number in (0, 1), or 0 for one that follows from `tolerance`");
    positive(o.water_density, "water_density", "a density in [1e-12, 1e18] (kg/m^3)");
    positive(o.speed_smoothing, "speed_smoothing", "a speed in [1e-12, 1e18] (m/s)");
    require_range(o.angle_smoothing, o.angle_smoothing > 0 && o.angle_smoothing <= 0.5, "angle_smoothing",
                  "an angle in (0, 0.5] rad");
    positive(o.surface_smoothing, "surface_smoothing", "a number in [1e-12, 1e18]");
    dqa::SceneSettings s;
    for (std::size_t k = 0; k < 3; ++k) {
        require_range(o.current[k], std::fabs(o.current[k]) <= 1e12, "current", "velocities within 1e12 (m/s)");
        s.hydrodynamics.current[k] = o.current[k];
    }
    for (std::size_t k = 0; k < 4; ++k) {
        s.hydrodynamics.drag[k] = o.drag_coefficients[k];
        s.hydrodynamics.thrust[k] = o.thrust_coefficients[k];
    }
    dqa::check_water_curves(s.hydrodynamics.drag, s.hydrodynamics.thrust, o.angle_smoothing);
    s.threads = o.threads;
    s.method = static_cast<dqa::Method>(o.method);
    s.integrator = static_cast<dqa::Integrator>(o.integrator);
    s.material = static_cast<dqa::Material>(o.material);
    s.quadrature = static_cast<dqa::Quadrature>(o.quadrature);
    s.planar = o.planar != 0;
    s.water = o.water != DQA_WATER_NONE;
    s.hydrodynamics.explicit_forces = o.water == DQA_WATER_EXPLICIT;
    s.hydrodynamics.windward_only = o.water_faces == DQA_FACES_WINDWARD;
    s.max_newton = o.max_newton, s.max_linear = o.max_linear, s.max_products = o.max_products;
    s.instructions = static_cast<dqa::InstructionSet>(o.instruction_set);
    s.preconditioner = static_cast<dqa::PreconditionerKind>(o.preconditioner);
    s.precision = static_cast<dqa::Precision>(o.linear_precision);
    s.time_step = o.time_step;
    s.young_modulus = o.young_modulus, s.poisson_ratio = o.poisson_ratio, s.density = o.density;
    s.muscle_stiffness = o.muscle_stiffness, s.contraction = o.contraction;
    s.threshold = o.threshold, s.occupancy_floor = o.occupancy_floor;
    s.tolerance = o.tolerance, s.adjoint_tolerance = o.adjoint_tolerance;
    s.hydrodynamics.density = o.water_density;
    s.hydrodynamics.speed_smoothing = o.speed_smoothing;
    s.hydrodynamics.angle_smoothing = o.angle_smoothing;
    s.hydrodynamics.surface_smoothing = o.surface_smoothing;
    if (o.cancel) s.cancel = o.cancel->flag;
    return s;
}

// The tape must belong to this simulator and end where the simulator stands.
void require_tape(const dqa_simulator* simulator, const dqa_tape* tape) {
    if (tape->state->simulator != simulator->identity)
        fail(Status::ERROR_ARGUMENT, "tape belongs to another simulator, expected one created with this simulator");
    if (tape->state->adjoints > 0)
        fail(Status::ERROR_STATE, "tape: an adjoint of it lives; free it before recording more");
    if (!tape->state->tape->continues(*simulator->simulation))
        fail(Status::ERROR_STATE,
             "tape does not end at the simulator's present state (design, state or clock changed); clear it first");
}

// A tape, or none, to which a call appends steps.
class Record {
public:
    Record(const dqa_simulator* simulator, dqa_tape* tape) {
        if (!tape) return;
        change_.emplace(tape, "tape");
        require_tape(simulator, tape);
        tape_ = tape->state->tape.get();
    }
    dqa::Tape* tape() const { return tape_; }

private:
    std::optional<Change<dqa_tape>> change_;
    dqa::Tape* tape_ = nullptr;
};

// A new design takes the place of the old one; nothing here can fail.
void put_design(dqa_simulator* simulator, std::unique_ptr<dqa::Simulation> simulation,
                std::chrono::steady_clock::time_point start) {
    if (simulator->current) simulation->set_current(simulator->current);
    simulator->simulation = std::move(simulation);
    simulator->newton_iterations = simulator->linear_iterations = 0;
    simulator->adjoint_iterations->store(0);
    simulator->last_residual = 0.0;
    simulator->setup_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// The scene changes, and with it the present design if there is one.
void put_scene(dqa_simulator* simulator, const dqa::SceneSettings& scene) {
    const auto start = std::chrono::steady_clock::now();
    if (simulator->simulation) {
        auto design = std::make_shared<const dqa::Design>(simulator->simulation->design(), scene);
        put_design(simulator, std::make_unique<dqa::Simulation>(std::move(design)), start);
    }
    simulator->scene = scene;
}

// Checked copy of one value per cell of the box; null for NULL.
std::shared_ptr<const std::vector<double>> cell_values(const double* values, int64_t n, const char* name,
                                                       double least) {
    if (!values) return nullptr;
    require_finite(values, n, name);
    for (int64_t k = 0; k < n; ++k)
        if (values[k] < least)
            fail(Status::ERROR_ARGUMENT, "%s[%" PRId64 "] is %s, expected a modulus %s 0 (Pa)", name, k,
                 dqa::number_text(values[k]).c_str(), least > 0.0 ? ">" : ">=");
    return std::make_shared<const std::vector<double>>(values, values + n);
}

void count(dqa_simulator* simulator, const dqa::StepReport& report) {
    simulator->newton_iterations += report.newton_iterations;
    simulator->linear_iterations += report.linear_iterations;
    simulator->last_residual = report.residual;
    dqa::log_message(dqa::LogLevel::debug,
                     "step %ld: %d Newton and %d linear iterations, relative residual %.2g, %d filtered, %d inverted",
                     simulator->simulation->steps(), report.newton_iterations, report.linear_iterations,
                     report.residual, report.filtered, report.inverted);
}

// For the steps from here on; null: uniform, as the options say.
void use_current(dqa_simulator* simulator, std::shared_ptr<const dqa::WaterCurrent> current) {
    if (!current) current = std::make_shared<dqa::WaterCurrent>(simulator->scene.hydrodynamics.current);
    simulator->current = current;
    if (simulator->simulation) simulator->simulation->set_current(current);
}

}  // namespace

namespace dqa::capi {

void require_sensors(const Controller& controller, const Design& design) {
    if (controller.n_sensors() > 0 && controller.n_sensors() != n_observed(design))
        fail(Status::ERROR_ARGUMENT, "controller reads %d sensors, expected %d (5 dims)", controller.n_sensors(),
             n_observed(design));
}

const Simulation& design_of(const dqa_simulator* simulator) {
    require(simulator, "simulator");
    if (!simulator->simulation)
        fail(Status::ERROR_STATE, "the simulator has no design yet; call dqa_simulator_set_weights first");
    return *simulator->simulation;
}

}  // namespace dqa::capi

extern "C" {

dqa_status dqa_simulator_options_init(dqa_simulator_options* options, uint64_t size) {
    return guard([&] { init_options(options, size, default_options(), "options"); });
}

dqa_status dqa_simulator_create(dqa_shape_space* space, const dqa_simulator_options* options,
                                dqa_simulator** simulator) {
    return guard([&] {
        begin_create(simulator, "simulator");
        require(space, "space");
        if (!space->core->built()) fail(Status::ERROR_STATE, "space is not built; call dqa_shape_space_build first");
        auto made = std::make_unique<dqa_simulator>();
        made->scene = settings_from(read_options(options, default_options(), "options"));
        made->space = space->core;
        const double up = made->scene.hydrodynamics.current[2];
        require_range(up, made->space->box().dims == 3 || up == 0.0, "current[2]", "0 in two dimensions");
        *simulator = made.release();
    });
}

void dqa_simulator_free(dqa_simulator* simulator) {
    free_handle(simulator);
}

dqa_status dqa_simulator_set_weights(dqa_simulator* simulator, const double* weights, int64_t m, dqa_progress progress,
                                     void* user_data) {
    return guard([&] {
        const Change change(simulator, "simulator");
        const auto w = read_weights(*simulator->space, weights, m);
        const auto start = std::chrono::steady_clock::now();
        auto design = std::make_shared<const dqa::Design>(
            simulator->space, w, simulator->scene,
            shape_monitor(progress, user_data, simulator->space->settings().tolerance, simulator->scene.cancel));
        auto simulation = std::make_unique<dqa::Simulation>(design);
        if (progress && progress(100, 100, user_data)) fail(Status::CANCELLED, "cancelled by the progress callback");
        put_design(simulator, std::move(simulation), start);
        dqa::log_message(dqa::LogLevel::info,
                         "design set: %d cells, %d nodes, %d faces, %lld factor entries; %.3g s, of which %.3g s for "
                         "the barycentre (%d iterations)",
                         design->set().n_cells(), design->n_nodes(), design->water() ? design->water()->n_faces() : 0,
                         static_cast<long long>(design->preconditioner().factor_entries()), simulator->setup_seconds,
                         design->barycenter_seconds(), design->point().barycenter.iterations);
    });
}

dqa_status dqa_simulator_set_current_table(dqa_simulator* simulator, const double* times, int64_t n_times,
                                           const double* velocities, int64_t n) {
    return guard([&] {
        const Change change(simulator, "simulator");
        if (n_times == 0) return use_current(simulator, nullptr);
        if (n_times < 0 || n_times > INT32_MAX)
            fail(Status::ERROR_ARGUMENT, "n_times is %" PRId64 ", expected a number in [0, 2^31)", n_times);
        require(times, "times"), require(velocities, "velocities");
        const int dims = simulator->space->box().dims;
        require_count(n, dims * n_times, "n", "velocities [n_times][dims]");
        const std::vector<double> values = points_in(velocities, n, dims);
        std::vector<dqa::Vec3> rows(static_cast<std::size_t>(n_times));
        for (std::size_t k = 0; k < values.size(); ++k) rows[k / 3][k % 3] = values[k];
        use_current(simulator, std::make_shared<dqa::WaterCurrent>(std::vector<double>(times, times + n_times), rows));
    });
}

dqa_status dqa_simulator_set_current_callback(dqa_simulator* simulator, dqa_current current,
                                              dqa_current_pullback pullback, void* user_data) {
    return guard([&] {
        const Change change(simulator, "simulator");
        if (!current) return use_current(simulator, nullptr);
        const int dims = simulator->space->box().dims;
        const auto value = [current, user_data, dims](double time) {
            dqa::Vec3 v{};
            if (current(time, v.data(), user_data))
                fail(Status::CANCELLED, "cancelled by the callback of the current at time %g s", time);
            if (dims == 2) v[2] = 0.0;  // whatever was written there
            return v;
        };
        dqa::WaterCurrent::Pullback back;
        if (pullback)
            back = [pullback, user_data](double time, const dqa::Vec3& bar) {
                if (pullback(time, bar.data(), user_data))
                    fail(Status::CANCELLED, "cancelled by the pullback of the current at time %g s", time);
            };
        use_current(simulator, std::make_shared<dqa::WaterCurrent>(value, back));
    });
}

dqa_status dqa_simulator_set_material(dqa_simulator* simulator, const double* young_modulus,
                                      const double* muscle_stiffness, int64_t n) {
    return guard([&] {
        const Change change(simulator, "simulator");
        const int64_t cells = simulator->space->box().n_cells();
        if (young_modulus || muscle_stiffness)
            require_count(n, cells, "n", "young_modulus and muscle_stiffness [n_cells]");
        dqa::SceneSettings scene = simulator->scene;
        scene.young_of_cell = cell_values(young_modulus, n, "young_modulus", std::numeric_limits<double>::min());
        scene.muscle_of_cell = cell_values(muscle_stiffness, n, "muscle_stiffness", 0.0);
        put_scene(simulator, scene);
    });
}

dqa_status dqa_simulator_set_fixed_nodes(dqa_simulator* simulator, const int32_t* nodes, int64_t n) {
    return guard([&] {
        const Change change(simulator, "simulator");
        if (n != 0) require(nodes, "nodes");
        const int all = simulator->space->box().n_nodes();
        if (n < 0 || n > all) fail(Status::ERROR_ARGUMENT, "n is %" PRId64 ", expected a number in [0, %d]", n, all);
        for (int64_t k = 0; k < n; ++k)
            if (nodes[k] < 0 || nodes[k] >= all)
                fail(Status::ERROR_ARGUMENT, "nodes[%" PRId64 "] is %d, expected an index in [0, %d)", k, nodes[k],
                     all);
        dqa::SceneSettings scene = simulator->scene;
        scene.fixed_nodes.assign(nodes, nodes + n);
        put_scene(simulator, scene);
    });
}

dqa_status dqa_simulator_node_box_index(const dqa_simulator* simulator, int32_t* nodes, int64_t n) {
    return guard([&] {
        const dqa::Design& d = design_of(simulator).design();
        require(nodes, "nodes");
        require_count(n, d.n_nodes(), "n", "nodes [n_nodes]");
        for (std::size_t k = 0; k < d.set().node_ijk.size(); ++k) {
            const auto& ijk = d.set().node_ijk[k];
            nodes[k] = d.set().box.node(ijk[0], ijk[1], ijk[2]);
        }
    });
}

dqa_status dqa_simulator_get_info(const dqa_simulator* simulator, dqa_simulator_info* info, uint64_t size) {
    return guard([&] {
        require(simulator, "simulator");
        dqa_simulator_info i{};
        const int dims = simulator->space->box().dims;
        i.dims = dims;
        i.n_bases = static_cast<int32_t>(simulator->space->bases().size());
        i.n_signals = simulator->space->n_signals();
        i.n_sensors = 5 * dims;
        i.cell_size = simulator->space->box().dx;
        if (simulator->simulation) {
            const dqa::Design& d = simulator->simulation->design();
            i.has_design = 1;
            i.n_nodes = d.n_nodes(), i.n_active_cells = d.set().n_cells(), i.n_body_cells = d.n_body_cells();
            i.n_faces = d.water() ? d.water()->n_faces() : 0;
            i.n_muscle_cells = d.n_muscle_cells();
            i.factor_entries = d.preconditioner().factor_entries();
            i.steps = simulator->simulation->steps();
            i.newton_iterations = simulator->newton_iterations;
            i.linear_iterations = simulator->linear_iterations;
            i.adjoint_iterations = simulator->adjoint_iterations->load();
            i.time = simulator->simulation->time();
            for (const double mass : d.mass()) i.total_mass += mass;
            i.volume = i.total_mass / d.scene().density;
            i.last_residual = simulator->last_residual;
            i.setup_seconds = simulator->setup_seconds;
            i.barycenter_seconds = d.barycenter_seconds();
        }
        write_struct(info, size, i, "info");
    });
}

dqa_status dqa_simulator_get_weights(const dqa_simulator* simulator, double* weights, int64_t m) {
    return guard([&] {
        const auto& w = design_of(simulator).design().point().barycenter.weights;
        require(weights, "weights");
        copy_out(w.data(), w.size(), weights, m, "m", "weights [n_bases]");
    });
}

dqa_status dqa_simulator_suggest_threshold(const dqa_simulator* simulator, const double* weights, int64_t m,
                                           double tolerance, double* threshold, double* estimate) {
    return guard([&] {
        require(simulator, "simulator");
        const Read reads(simulator, "simulator", Beside::changes);
        const auto w = read_weights(*simulator->space, weights, m);
        require_range(tolerance, tolerance > 0 && tolerance < 1, "tolerance", "a number in (0, 1)");
        require(threshold, "threshold");
        const dqa::ShapeSpace& space = *simulator->space;
        const dqa::SceneSettings& scene = simulator->scene;
        const auto suggest = [&](const dqa::ShapePoint& point) {
            return dqa::suggest_threshold(dqa::ThresholdError(space.box(), point.p_hat, scene), tolerance);
        };
        // The density of the present design is at hand.
        const dqa::ShapePoint* present = simulator->simulation ? &simulator->simulation->design().point() : nullptr;
        const auto found =
            present && present->barycenter.weights == w
                ? suggest(*present)
                : suggest(space.evaluate(w, scene.shape_tolerance, scene.threads,
                                         shape_monitor(nullptr, nullptr, space.settings().tolerance, scene.cancel)));
        *threshold = found.threshold;
        if (estimate) *estimate = found.error;
    });
}

dqa_status dqa_simulator_step(dqa_simulator* simulator, const double* actuation, int64_t n, dqa_tape* tape) {
    return guard([&] {
        const Change change(simulator, "simulator");
        const dqa::Design& design = design_of(simulator).design();
        require(actuation, "actuation");
        require_count(n, design.n_signals(), "n", "actuation [n_signals]");
        for (int64_t k = 0; k < n; ++k)
            if (!(actuation[k] >= -1.0 && actuation[k] <= 1.0))
                fail(Status::ERROR_ARGUMENT, "actuation[%" PRId64 "] is %s, expected a number in [-1, 1]", k,
                     dqa::number_text(actuation[k]).c_str());
        const Record record(simulator, tape);
        if (tape && tape->state->tape->controller())
            fail(Status::ERROR_STATE, "tape was driven by a controller so far; clear it before single steps");
        check_cancel(simulator->scene.cancel);
        count(simulator,
              dqa::advance(*simulator->simulation, std::vector<double>(actuation, actuation + n), record.tape()));
    });
}

dqa_status dqa_simulator_rollout(dqa_simulator* simulator, dqa_controller* controller, int64_t n_steps, dqa_tape* tape,
                                 dqa_progress progress, void* user_data) {
    return guard([&] {
        const Change change(simulator, "simulator");
        const dqa::Design& design = design_of(simulator).design();
        require(controller, "controller");
        const Read reads(controller, "controller");
        if (controller->core->n_signals() != design.n_signals())
            fail(Status::ERROR_ARGUMENT, "controller has %d signals, expected %d: one per actuator category",
                 controller->core->n_signals(), design.n_signals());
        require_sensors(*controller->core, design);
        if (n_steps < 0 || n_steps > INT32_MAX)
            fail(Status::ERROR_ARGUMENT, "n_steps is %" PRId64 ", expected a number in [0, 2^31)", n_steps);
        const Record record(simulator, tape);
        for (int64_t k = 0; k < n_steps; ++k) {
            check_cancel(simulator->scene.cancel);
            const auto actuation = dqa::actuation_of(*controller->core, *simulator->simulation);
            if (record.tape() && k == 0) record.tape()->set_controller(*controller->core);
            count(simulator, dqa::advance(*simulator->simulation, actuation, record.tape()));
            if (progress && progress(k + 1, n_steps, user_data))
                fail(Status::CANCELLED, "cancelled by the progress callback after %" PRId64 " steps", k + 1);
        }
    });
}

dqa_status dqa_simulator_get_state(const dqa_simulator* simulator, double* q, int64_t nq, double* v, int64_t nv) {
    return guard([&] {
        const dqa::Simulation& s = design_of(simulator);
        const int dims = s.design().set().box.dims;
        const int64_t n = static_cast<int64_t>(s.design().n_nodes()) * dims;
        if (q) require_count(nq, n, "nq", "q [n_nodes][dims]");
        if (v) require_count(nv, n, "nv", "v [n_nodes][dims]");
        points_out(s.q().data(), s.q().size() / 3, dims, q);
        points_out(s.v().data(), s.v().size() / 3, dims, v);
    });
}

dqa_status dqa_simulator_set_state(dqa_simulator* simulator, const double* q, int64_t nq, const double* v, int64_t nv) {
    return guard([&] {
        const Change change(simulator, "simulator");
        const dqa::Design& design = design_of(simulator).design();
        const int dims = design.set().box.dims;
        const int64_t n = static_cast<int64_t>(design.n_nodes()) * dims;
        if (q) require_count(nq, n, "nq", "q [n_nodes][dims]"), require_finite(q, nq, "q");
        if (v) require_count(nv, n, "nv", "v [n_nodes][dims]"), require_finite(v, nv, "v");
        const auto positions = q ? points_in(q, nq, dims) : std::vector<double>();
        const auto velocities = v ? points_in(v, nv, dims) : std::vector<double>();
        simulator->simulation->set_state(q ? positions.data() : nullptr, v ? velocities.data() : nullptr);
    });
}

dqa_status dqa_simulator_sensors(const dqa_simulator* simulator, double* sensors, int64_t n) {
    return guard([&] {
        const dqa::Simulation& s = design_of(simulator);
        require(sensors, "sensors");
        const auto seen = dqa::observe(s.design(), s.q().data(), s.v().data());
        copy_out(seen.data(), seen.size(), sensors, n, "n", "sensors [5][dims]");
    });
}

dqa_status dqa_simulator_forces(const dqa_simulator* simulator, double* forces, int64_t n) {
    return guard([&] {
        const dqa::Simulation& s = design_of(simulator);
        const dqa::WaterTotals& t = s.forces();
        require(forces, "forces");
        const int dims = s.design().set().box.dims;
        require_count(n, 4 * dims, "n", "forces [4][dims]");
        const dqa::Vec3* rows[4] = {&t.drag, &t.thrust, &t.mean_drag, &t.mean_thrust};
        for (int k = 0; k < 4; ++k) points_out(rows[k]->data(), 1, dims, forces + k * dims);
    });
}

dqa_status dqa_simulator_surface(const dqa_simulator* simulator, double* vertices, int64_t nv, int32_t* elements,
                                 int64_t ne, int64_t* n_vertices, int64_t* n_elements) {
    return guard([&] {
        const dqa::Simulation& s = design_of(simulator);
        const dqa::Isosurface& surface = s.design().surface();
        const int dims = s.design().set().box.dims;
        const int64_t rows_v = static_cast<int64_t>(surface.vertices.size()),
                      rows_e = static_cast<int64_t>(dims == 2 ? surface.segments.size() : surface.triangles.size());
        if (vertices) require_count(nv, dims * rows_v, "nv", "vertices [n_vertices][dims]");
        if (elements) require_count(ne, dims * rows_e, "ne", "elements [n_elements][dims]");
        if (vertices) {
            const auto x = s.design().carry_surface(s.q().data());
            for (std::size_t k = 0; k < x.size(); ++k)
                points_out(x[k].data(), 1, dims, vertices + dims * static_cast<int64_t>(k));
        }
        for (std::size_t t = 0; elements && t < static_cast<std::size_t>(rows_e); ++t)
            for (std::size_t k = 0; k < static_cast<std::size_t>(dims); ++k)
                elements[static_cast<std::size_t>(dims) * t + k] =
                    dims == 2 ? surface.segments[t][k] : surface.triangles[t][k];
        if (n_vertices) *n_vertices = rows_v;
        if (n_elements) *n_elements = rows_e;
    });
}

dqa_status dqa_simulator_mesh(const dqa_simulator* simulator, int32_t* cell_nodes, int64_t n_cell_nodes,
                              int32_t* cell_box_index, int64_t n_cells, double* occupancy, int64_t n_occupancy) {
    return guard([&] {
        const dqa::Design& d = design_of(simulator).design();
        const int64_t n = d.set().n_cells();
        // In two dimensions corners 4 ix + 2 iy + iz with iz = 0 and 1 are one node.
        const std::size_t corners = d.set().box.dims == 2 ? 4 : 8, stride = 8 / corners;
        if (cell_nodes)
            require_count(n_cell_nodes, static_cast<int64_t>(corners) * n, "n_cell_nodes",
                          "cell_nodes [n_active_cells][2^dims]");
        if (cell_box_index) require_count(n_cells, n, "n_cells", "cell_box_index [n_active_cells]");
        if (occupancy) require_count(n_occupancy, n, "n_occupancy", "occupancy [n_active_cells]");
        for (std::size_t c = 0; c < static_cast<std::size_t>(n); ++c) {
            for (std::size_t k = 0; k < corners && cell_nodes; ++k)
                cell_nodes[corners * c + k] = d.set().cell_nodes[c][stride * k];
            if (cell_box_index) cell_box_index[c] = d.set().cells[c];
            if (occupancy) occupancy[c] = d.occupancy()[c];
        }
    });
}

dqa_status dqa_simulator_actuator(const dqa_simulator* simulator, int32_t category, int32_t side,
                                  dqa_actuator_info* info, uint64_t size) {
    return guard([&] {
        const dqa::Design& d = design_of(simulator).design();
        const dqa::ShapeSpace& space = d.space();
        for (std::size_t s = 0; s < space.slots().size(); ++s) {
            const dqa::ActuatorCategory& c = space.categories()[static_cast<std::size_t>(space.slots()[s].category)];
            if (c.number != category || static_cast<int32_t>(space.slots()[s].half) != side) continue;
            const dqa::ActuatorPoint& a = d.point().actuators[s];
            dqa_actuator_info i{};
            i.category = category, i.kind = static_cast<int32_t>(c.kind), i.side = side;
            i.layers = c.layers, i.n_signals = c.n_signals, i.first_signal = c.first_signal;
            for (std::size_t k = 0; k < 3; ++k) {
                i.mean[k] = a.mean[k], i.half[k] = a.half[k];
                for (std::size_t j = 0; j < 3; ++j) {
                    i.covariance[3 * k + j] = a.covariance[3 * k + j];
                    i.normal[3 * k + j] = a.normal[k][j], i.edge[3 * k + j] = a.edge[k][j];
                }
            }
            i.share = a.share, i.strength = a.strength;
            write_struct(info, size, i, "info");
            return;
        }
        fail(Status::ERROR_STATE, "no base has an actuator of category %d and side %d", category, side);
    });
}

dqa_status dqa_simulator_muscles(const dqa_simulator* simulator, int32_t* cells, int32_t* signals, int32_t* signs,
                                 int64_t n, double* directions, int64_t nd, double* stiffness, int64_t ns,
                                 int64_t* n_muscles) {
    return guard([&] {
        const dqa::Design& d = design_of(simulator).design();
        const auto& muscles = d.body().muscles();
        const int dims = d.set().box.dims;
        const int64_t rows = static_cast<int64_t>(muscles.size());
        if (cells || signals || signs) require_count(n, rows, "n", "cells, signals, signs [n_muscles]");
        if (directions) require_count(nd, dims * rows, "nd", "directions [n_muscles][dims]");
        if (stiffness) require_count(ns, rows, "ns", "stiffness [n_muscles]");
        for (std::size_t e = 0; e < muscles.size(); ++e) {
            if (cells) cells[e] = muscles[e].cell;
            if (signals) signals[e] = muscles[e].signal;
            if (signs) signs[e] = muscles[e].sign > 0 ? 1 : -1;
            if (directions)
                points_out(muscles[e].direction.data(), 1, dims, directions + dims * static_cast<int64_t>(e));
            if (stiffness) stiffness[e] = muscles[e].weight;
        }
        if (n_muscles) *n_muscles = rows;
    });
}

}  // extern "C"
