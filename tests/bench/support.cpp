// SPDX-License-Identifier: MIT
#include "support.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <numeric>

#include "reference.hpp"

namespace bench {
namespace {

// A handle of the library, freed with its scope.
template <class T, void (*release)(T*)>
struct Handle {
    T* p = nullptr;
    Handle() = default;
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    ~Handle() { release(p); }
};
using Space = Handle<dqa_shape_space, dqa_shape_space_free>;
using Simulator = Handle<dqa_simulator, dqa_simulator_free>;
using TapeHandle = Handle<dqa_tape, dqa_tape_free>;
using AdjointHandle = Handle<dqa_adjoint, dqa_adjoint_free>;

// A folder for the files of shape spaces, gone when the program ends.
class Scratch {
public:
    Scratch() : owner_(getpid()) {
        std::string pattern = (std::filesystem::temp_directory_path() / "dqa-bench-XXXXXX").string();
        if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
        path_ = pattern;
    }
    ~Scratch() {
        std::error_code ignored;
        if (getpid() == owner_) std::filesystem::remove_all(path_, ignored);
    }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
    std::string file(int number) const { return (path_ / ("space" + std::to_string(number))).string(); }

private:
    pid_t owner_;
    std::filesystem::path path_;
};

std::string next_space() {
    static const Scratch scratch;
    static int number = 0;
    return scratch.file(number++);
}

void write_all(int to, const void* data, std::size_t bytes) {
    const char* at = static_cast<const char*>(data);
    while (bytes > 0) {
        const ssize_t n = write(to, at, bytes);
        if (n <= 0) _exit(3);
        at += n, bytes -= static_cast<std::size_t>(n);
    }
}

// A ray: a sphere made flat and wide, with wings swept back and a tail. Poles of the grid of n x n points on the x
// axis.
void ray_mesh(double span, double sweep, double tail, Vector& vertices, std::vector<std::int32_t>& triangles) {
    constexpr int n = 48;
    const auto add = [&](double x, double y, double z) {
        const double wing = std::fabs(y);
        vertices.push_back(0.5 * x - sweep * wing * wing - tail * std::pow(0.5 * (1.0 - x), 12));
        vertices.push_back(0.5 * span * y);
        vertices.push_back(0.09 * z * (1.0 - 0.6 * wing));
    };
    add(1.0, 0.0, 0.0);
    for (int i = 1; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double u = std::numbers::pi * i / n, w = 2.0 * std::numbers::pi * j / n;
            add(std::cos(u), std::sin(u) * std::cos(w), std::sin(u) * std::sin(w));
        }
    add(-1.0, 0.0, 0.0);
    const auto at = [&](int i, int j) { return i == 0 ? 0 : i == n ? 1 + (n - 1) * n : 1 + (i - 1) * n + j % n; };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            if (i > 0) triangles.insert(triangles.end(), {at(i, j), at(i + 1, j), at(i, j + 1)});
            if (i < n - 1) triangles.insert(triangles.end(), {at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
        }
}

void add_muscle(dqa_shape_space* space, std::int32_t base, std::int32_t kind, const double (&mean)[3],
                const double (&half)[3]) {
    dqa_actuator_options muscle;
    check(dqa_actuator_options_init(&muscle, sizeof muscle), "muscle");
    muscle.kind = muscle.category = kind;
    for (std::size_t a = 0; a < 3; ++a) {
        muscle.mean[a] = mean[a];
        muscle.variance[a] = half[a] * half[a] / (2.0 * std::numbers::ln2);
    }
    check(dqa_shape_space_add_actuator(space, base, &muscle), "muscle");
}

// Rays 1 m long, with muscles in their tails and in four layers of their wings.
void add_rays(dqa_shape_space* space) {
    static constexpr double kRays[3][3] = {{1.2, 0.25, 0.2}, {1.1, 0.1, 0.4}, {1.15, 0.2, 0.3}};
    for (const auto& ray : kRays) {
        Vector vertices;
        std::vector<std::int32_t> triangles;
        ray_mesh(ray[0], ray[1], ray[2], vertices, triangles);
        std::int32_t base = 0;
        check(dqa_shape_space_add_mesh(space, "ray", vertices.data(), static_cast<std::int64_t>(vertices.size() / 3),
                                       triangles.data(), static_cast<std::int64_t>(triangles.size() / 3), &base),
              "ray");
        add_muscle(space, base, DQA_ACTUATOR_CAUDAL, {-0.2, 0.0, 0.0}, {0.2, 0.06, 0.06});
        add_muscle(space, base, DQA_ACTUATOR_FINS, {0.05, 0.25, 0.0}, {0.16, 0.16, 0.05});
    }
}

Vector by_amplitude(const Vector& actuation_bar, std::size_t signals, double time_step) {
    Vector out(signals, 0.0);
    for (std::size_t k = 0; k < actuation_bar.size(); ++k)
        out[k % signals] += actuation_bar[k] *
                            actuation(static_cast<double>(k / signals + 1) * time_step, static_cast<int>(k % signals));
    return out;
}

Outcome run_library(const Scene& scene, const Setup& s) {
    Outcome out;
    Space space;
    check(dqa_shape_space_load(scene.file.c_str(), &space.p), "space");
    dqa_shape_space_info shape;
    check(dqa_shape_space_get_info(space.p, &shape, sizeof shape), "space");
    dqa_simulator_options o;
    check(dqa_simulator_options_init(&o, sizeof o), "options");
    o.method = s.method, o.integrator = s.integrator, o.material = s.material, o.threads = s.threads;
    o.threshold = s.threshold, o.tolerance = s.tolerance, o.adjoint_tolerance = s.adjoint_tolerance;
    o.time_step = s.time_step, o.linear_precision = s.precision, o.quadrature = s.quadrature;
    o.planar = s.planar ? 1 : 0, o.water = s.water ? DQA_WATER_IMPLICIT : DQA_WATER_NONE;
    Simulator simulator;
    check(dqa_simulator_create(space.p, &o, &simulator.p), "simulator");
    const Vector weights(static_cast<std::size_t>(scene.n_bases), 1.0 / scene.n_bases);
    check(dqa_simulator_set_weights(simulator.p, weights.data(), scene.n_bases, nullptr, nullptr), "weights");
    dqa_simulator_info info;
    check(dqa_simulator_get_info(simulator.p, &info, sizeof info), "info");
    const std::size_t nodes = static_cast<std::size_t>(info.n_nodes), ends = std::size_t{1} << info.dims;
    const std::int64_t size = info.dims * info.n_nodes;
    out.rest.resize(static_cast<std::size_t>(size)), out.q.resize(out.rest.size()), out.mass.assign(nodes, 0.0);
    check(dqa_simulator_get_state(simulator.p, out.rest.data(), size, nullptr, 0), "state");
    std::vector<std::int32_t> node(nodes), corners(ends * static_cast<std::size_t>(info.n_active_cells));
    Vector occupancy(static_cast<std::size_t>(info.n_active_cells));
    check(dqa_simulator_node_box_index(simulator.p, node.data(), info.n_nodes), "nodes");
    check(dqa_simulator_mesh(simulator.p, corners.data(), static_cast<std::int64_t>(corners.size()), nullptr, 0,
                             occupancy.data(), info.n_active_cells),
          "mesh");
    out.node.assign(node.begin(), node.end());
    for (std::size_t k = 0; k < corners.size(); ++k)
        out.mass[static_cast<std::size_t>(corners[k])] += occupancy[k / ends];
    dqa_tape_options tape_options;
    check(dqa_tape_options_init(&tape_options, sizeof tape_options), "tape options");
    tape_options.memory_bytes = static_cast<std::int64_t>(s.checkpoint);
    dqa_objective_term travel;
    check(dqa_objective_term_init(&travel, sizeof travel), "term");
    const double start = milliseconds();
    for (int k = 0; k < s.repeat && (k == 0 || milliseconds() - start < 1e3 * s.budget); ++k) {
        TapeHandle tape;
        AdjointHandle adjoint;
        check(dqa_simulator_set_state(simulator.p, nullptr, 0, nullptr, 0), "state");
        check(dqa_tape_create(simulator.p, &tape_options, &tape.p), "tape");
        double at = milliseconds();
        for (int step = 0; step < s.steps; ++step) {
            Vector signals;
            for (int n = 0; n < shape.n_signals; ++n) signals.push_back(actuation((step + 1) * s.time_step, n));
            check(dqa_simulator_step(simulator.p, signals.data(), shape.n_signals, tape.p), "step");
        }
        out.forward.push_back(milliseconds() - at);
        check(dqa_simulator_get_state(simulator.p, out.q.data(), size, nullptr, 0), "state");
        check(dqa_tape_objective(tape.p, &travel, 1, &out.loss, nullptr), "loss");
        check(dqa_adjoint_create(tape.p, &adjoint.p), "adjoint");
        check(dqa_adjoint_seed_objective(adjoint.p, &travel, 1), "seed");
        at = milliseconds();
        check(dqa_adjoint_backward(adjoint.p, 0, nullptr, nullptr), "backward");
        out.backward.push_back(milliseconds() - at);
        at = milliseconds();
        out.weights_bar.resize(weights.size());
        check(dqa_adjoint_get(adjoint.p, DQA_WRT_WEIGHTS, out.weights_bar.data(), scene.n_bases), "gradient");
        out.pullback.push_back(milliseconds() - at);
        out.actuation_bar.resize(static_cast<std::size_t>(s.steps * shape.n_signals));
        check(dqa_adjoint_get(adjoint.p, DQA_WRT_ACTUATION, out.actuation_bar.data(), s.steps * shape.n_signals),
              "gradient");
        dqa_tape_statistics stats;
        check(dqa_tape_stats(tape.p, &stats, sizeof stats), "statistics");
        const double steps = static_cast<double>(s.steps);
        out.newton = static_cast<double>(stats.newton_iterations) / steps;
        out.linear = static_cast<double>(stats.linear_iterations) / steps;
        out.adjoint = static_cast<double>(stats.adjoint_iterations) / steps;
        out.residual = stats.worst_residual;
        out.tape_mib = static_cast<double>(stats.bytes) / 1048576.0;
    }
    out.active_cells = static_cast<double>(info.n_active_cells);
    out.setup_ms = 1e3 * info.setup_seconds;
    out.amplitude_bar = by_amplitude(out.actuation_bar, static_cast<std::size_t>(shape.n_signals), s.time_step);
    return out;
}

Outcome run_reference(const Scene& scene, const Setup& s) {
    Outcome out;
    dqa::SceneSettings settings;
    settings.time_step = s.time_step, settings.tolerance = s.tolerance;
    settings.adjoint_tolerance = s.adjoint_tolerance;
    settings.max_linear = 5000;
    const auto space = dqa::ShapeSpace::load(scene.file);
    const std::size_t signals = static_cast<std::size_t>(space->n_signals());
    double at = milliseconds();
    Reference reference(*space, Vector(static_cast<std::size_t>(scene.n_bases), 1.0 / scene.n_bases), settings);
    out.setup_ms = milliseconds() - at;
    const Field zero = Field::Zero(3, reference.rest().cols());
    const double start = milliseconds();
    for (int k = 0; k < s.repeat && (k == 0 || milliseconds() - start < 1e3 * s.budget); ++k) {
        std::vector<FieldState> states{{reference.rest(), zero}};
        std::vector<Vector> inputs;
        out.newton = out.adjoint = out.residual = 0.0;
        at = milliseconds();
        for (int step = 0; step < s.steps; ++step) {
            inputs.emplace_back();
            for (std::size_t n = 0; n < signals; ++n)
                inputs.back().push_back(actuation((step + 1) * s.time_step, static_cast<int>(n)));
            FieldState next;
            const ReferenceReport report = reference.step(states.back(), inputs.back(), next);
            out.newton += static_cast<double>(report.iterations) / s.steps;
            out.residual = std::max(out.residual, report.residual);
            states.push_back(std::move(next));
        }
        out.forward.push_back(milliseconds() - at);
        at = milliseconds();
        FieldState bar{zero, zero}, before;  // of the travelled distance; its dependence on step 0 reaches no actuation
        bar.q.row(0) = -reference.spine().transpose();
        out.actuation_bar.assign(static_cast<std::size_t>(s.steps) * signals, 0.0);
        for (int step = s.steps - 1; step >= 0; --step) {
            const std::size_t i = static_cast<std::size_t>(step);
            Vector signals_bar(signals, 0.0);
            const ReferenceReport report =
                reference.adjoint(states[i], inputs[i], states[i + 1], bar, before, signals_bar);
            out.adjoint += static_cast<double>(report.iterations) / s.steps;
            std::copy(signals_bar.begin(), signals_bar.end(),
                      out.actuation_bar.begin() + static_cast<std::ptrdiff_t>(i * signals));
            std::swap(bar, before);
        }
        out.backward.push_back(milliseconds() - at);
        const Field& q = states.back().q;
        out.q.assign(q.data(), q.data() + q.size());
        out.loss = -(q.row(0) - reference.rest().row(0)).dot(reference.spine());
    }
    out.linear = out.newton;
    out.pullback.push_back(0.0);
    out.amplitude_bar = by_amplitude(out.actuation_bar, signals, s.time_step);
    out.rest.assign(reference.rest().data(), reference.rest().data() + reference.rest().size());
    out.mass.assign(reference.mass().begin(), reference.mass().end());
    out.node.resize(out.mass.size());
    std::iota(out.node.begin(), out.node.end(), 0.0);
    out.active_cells = space->box().n_cells();
    return out;
}

double norm(const Vector& a) {
    return std::sqrt(std::inner_product(a.begin(), a.end(), a.begin(), 0.0));
}
double distance(const Vector& a, const Vector& b) {
    if (a.size() != b.size()) throw std::runtime_error("gradients of different lengths were compared");
    double s = 0.0;
    for (std::size_t k = 0; k < a.size(); ++k) s += (a[k] - b[k]) * (a[k] - b[k]);
    return std::sqrt(s);
}

constexpr Vector Outcome::*kVectors[] = {&Outcome::forward,     &Outcome::backward,      &Outcome::node,
                                         &Outcome::q,           &Outcome::rest,          &Outcome::mass,
                                         &Outcome::weights_bar, &Outcome::actuation_bar, &Outcome::amplitude_bar,
                                         &Outcome::pullback};
constexpr double Outcome::*kNumbers[] = {&Outcome::active_cells, &Outcome::setup_ms, &Outcome::newton,
                                         &Outcome::linear,       &Outcome::adjoint,  &Outcome::residual,
                                         &Outcome::loss,         &Outcome::tape_mib};

}  // namespace

void check(dqa_status status, const char* what) {
    if (status != DQA_SUCCESS)
        throw std::runtime_error(std::string(what) + ": " + dqa_status_name(status) + ": " + dqa_last_error());
}

double milliseconds() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Spread spread_of(Vector values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return {0.5 * (values[n / 2] + values[(n - 1) / 2]), values.front(), values.back()};
}

ChildResult in_child(const std::function<std::vector<Vector>()>& work) {
    int ends[2];
    if (pipe(ends) != 0) throw std::runtime_error("no pipe for a child process");
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("no child process");
    if (child == 0) {
        close(ends[0]);
        int code = 0;
        try {
            for (const Vector& v : work()) {
                const std::size_t n = v.size();
                write_all(ends[1], &n, sizeof n);
                write_all(ends[1], v.data(), n * sizeof(double));
            }
        } catch (const std::exception& e) {
            std::fprintf(stderr, "%s\n", e.what());
            code = 1;
        }
        std::fflush(nullptr);
        _exit(code);
    }
    close(ends[1]);
    std::vector<char> bytes;
    char buffer[65536];
    for (ssize_t n = 0; (n = read(ends[0], buffer, sizeof buffer)) > 0;) bytes.insert(bytes.end(), buffer, buffer + n);
    close(ends[0]);
    int status = 0;
    struct rusage usage {};
    if (wait4(child, &status, 0, &usage) != child) throw std::runtime_error("the child process was lost");
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) throw std::runtime_error("this configuration failed");
    ChildResult out;
    for (std::size_t at = 0; at < bytes.size();) {
        std::size_t n = 0;
        std::copy_n(bytes.data() + at, sizeof n, reinterpret_cast<char*>(&n));
        at += sizeof n;
        Vector v(n);
        std::copy_n(bytes.data() + at, n * sizeof(double), reinterpret_cast<char*>(v.data()));
        at += n * sizeof(double);
        out.values.push_back(std::move(v));
    }
    out.peak_mib = static_cast<double>(usage.ru_maxrss) / 1024.0;
    return out;
}

std::string Scene::grid_text() const {
    return std::to_string(grid[0]) + "x" + std::to_string(grid[1]) + "x" + std::to_string(grid[2]);
}

std::optional<Scene> open_scene(const std::string& name, const std::string& data, const std::array<int, 3>& grid,
                                int refine, double sigma) {
    Scene scene{name, {60, 16, 26}, next_space(), 2};
    std::vector<std::string> meshes;
    const std::string shipped = DQA_SHAPES_DIR;
    if (name == "eel") {
        scene.grid = {40, 8, 8};
        meshes = {shipped + "/eel_horizontal.stl", shipped + "/eel_vertical.stl"};
    } else if (name == "shipped") {
        meshes = {shipped + "/clownfish.stl", shipped + "/tuna.stl"};
    } else if (name == "orca_shark") {
        meshes = {data + "/Orca.stl", data + "/GreatWhiteShark.stl"};
    } else if (name == "three") {
        scene.grid = {60, 54, 14}, scene.n_bases = 3;
    } else {
        throw UsageError("there is no scene '" + name + "'; there are eel, shipped, orca_shark and three");
    }
    if (grid[0] > 0) scene.grid = grid;
    for (int& n : scene.grid) n *= refine;
    for (const std::string& mesh : meshes)
        if (access(mesh.c_str(), R_OK) != 0) {
            std::printf("%s is left out: no %s (--data DIR or DQA_TEST_DATA names the folder)\n", name.c_str(),
                        mesh.c_str());
            return std::nullopt;
        }
    in_child([&]() -> std::vector<Vector> {
        dqa_shape_space_options o;
        check(dqa_shape_space_options_init(&o, sizeof o), "options");
        o.cells_x = scene.grid[0], o.cells_y = scene.grid[1], o.cells_z = scene.grid[2];
        o.margin *= refine, o.sigma = sigma * refine;
        if (name == "three") o.cell_size = 1.0 / (scene.grid[0] - 2 * o.margin);  // its muscles have places in metres
        Space space;
        check(dqa_shape_space_create(&o, &space.p), "space");
        for (const std::string& mesh : meshes)
            check(dqa_shape_space_add_mesh_file(space.p, mesh.c_str(), nullptr), mesh.c_str());
        if (meshes.empty()) add_rays(space.p);
        check(dqa_shape_space_build(space.p, nullptr, nullptr), "build");
        check(dqa_shape_space_save(space.p, scene.file.c_str()), "save");
        return {};
    });
    return scene;
}

std::optional<Scene> middle_plane(const Scene& scene, double sigma) {
    const Scene plane{scene.name, {scene.grid[0], scene.grid[1], 1}, next_space(), scene.n_bases};
    const auto [nx, ny, nz] = scene.grid;
    const ChildResult built = in_child([&]() -> std::vector<Vector> {
        Space solid, flat;
        check(dqa_shape_space_load(scene.file.c_str(), &solid.p), "space");
        dqa_shape_space_info info;
        check(dqa_shape_space_get_info(solid.p, &info, sizeof info), "space");
        if (info.n_signals != 1) return {};
        dqa_shape_space_options o;
        check(dqa_shape_space_options_init(&o, sizeof o), "options");
        o.dims = 2, o.cells_x = nx, o.cells_y = ny, o.sigma = sigma, o.cell_size = info.cell_size;
        check(dqa_shape_space_create(&o, &flat.p), "plane");
        for (std::int32_t base = 0; base < info.n_bases; ++base) {
            Vector cells(static_cast<std::size_t>(info.n_cells)), middle(static_cast<std::size_t>(nx * ny));
            check(dqa_shape_space_get_base(solid.p, base, cells.data(), info.n_cells), "base");
            for (std::size_t k = 0; k < middle.size(); ++k) {
                const double* column = &cells[k * static_cast<std::size_t>(nz)];
                middle[k] = 0.5 * (column[(nz - 1) / 2] + column[nz / 2]);
            }
            check(dqa_shape_space_add_density(flat.p, dqa_shape_space_base_name(solid.p, base), middle.data(), nx * ny,
                                              nullptr),
                  "plane of a base");
            dqa_actuator_options muscle;
            check(dqa_actuator_options_init(&muscle, sizeof muscle), "muscle");
            check(dqa_shape_space_get_actuator(solid.p, base, 0, DQA_SIDE_BOTH, &muscle), "muscle");
            check(dqa_shape_space_add_actuator(flat.p, base, &muscle), "muscle");
        }
        check(dqa_shape_space_build(flat.p, nullptr, nullptr), "build");
        check(dqa_shape_space_save(flat.p, plane.file.c_str()), "save");
        return {{1.0}};
    });
    return built.values.empty() ? std::nullopt : std::optional(plane);
}

double actuation(double time, int signal) {
    const double t = std::min(1.0, time / 0.1);
    return t * t * (3.0 - 2.0 * t) * std::sin(5.0 * std::numbers::pi * time + 0.5 + 0.7 * signal);
}

Outcome run(const Scene& scene, const Setup& setup) {
    const ChildResult child = in_child([&] {
        const Outcome o = setup.method == kReferenceMethod ? run_reference(scene, setup) : run_library(scene, setup);
        std::vector<Vector> values(1);
        for (const auto member : kNumbers) values[0].push_back(o.*member);
        for (const auto member : kVectors) values.push_back(o.*member);
        return values;
    });
    Outcome out;
    for (std::size_t k = 0; k < std::size(kNumbers); ++k) out.*kNumbers[k] = child.values.at(0).at(k);
    for (std::size_t k = 0; k < std::size(kVectors); ++k) out.*kVectors[k] = child.values.at(k + 1);
    out.peak_mib = child.peak_mib;
    return out;
}

Outcome in_the_middle(Outcome plane, const Scene& scene) {
    const int layers = scene.grid[2] + 1;
    for (double& node : plane.node) node = node * layers + scene.grid[2] / 2;
    for (Vector* positions : {&plane.q, &plane.rest}) {
        Vector lifted;
        for (std::size_t k = 0; k < plane.node.size(); ++k)
            lifted.insert(lifted.end(), {(*positions)[2 * k], (*positions)[2 * k + 1], 0.0});
        *positions = std::move(lifted);
    }
    return plane;
}

double state_error(const Outcome& got, const Outcome& exact, const Scene& scene, int fine) {
    const int ny = scene.grid[1] + 1, nz = scene.grid[2] + 1;
    const int fy = fine * scene.grid[1] + 1, fz = fine * scene.grid[2] + 1;
    std::vector<int> place(static_cast<std::size_t>((fine * scene.grid[0] + 1) * fy * fz), -1);
    for (std::size_t n = 0; n < exact.node.size(); ++n)
        place[static_cast<std::size_t>(exact.node[n])] = static_cast<int>(n);
    double error = 0.0, size = 0.0;
    for (std::size_t n = 0; n < got.node.size(); ++n) {
        const int at = static_cast<int>(got.node[n]), i = at / (ny * nz), j = at / nz % ny, k = at % nz;
        const int there = place[static_cast<std::size_t>((fine * i * fy + fine * j) * fz + fine * k)];
        if (there < 0) continue;  // next to nothing of the body is there
        for (std::size_t a = 0; a < 3; ++a) {
            const std::size_t e = 3 * static_cast<std::size_t>(there) + a;
            const double u = got.q[3 * n + a] - got.rest[3 * n + a], u_exact = exact.q[e] - exact.rest[e];
            error += got.mass[n] * (u - u_exact) * (u - u_exact);
            size += got.mass[n] * u_exact * u_exact;
        }
    }
    return size > 0 ? std::sqrt(error / size) : 0.0;
}

double gradient_error(const Outcome& got, const Outcome& exact, Actuations actuations) {
    const auto by_actuation = [&](const Outcome& o) {
        return actuations == Actuations::each ? o.actuation_bar : o.amplitude_bar;
    };
    const Vector a = by_actuation(exact);
    const double weights = norm(exact.weights_bar), least = 0.1 * std::hypot(weights, norm(a));
    double error = distance(by_actuation(got), a) / std::max(norm(a), least);
    if (!got.weights_bar.empty())
        error = std::max(error, distance(got.weights_bar, exact.weights_bar) / std::max(weights, least));
    return error;
}

}  // namespace bench
