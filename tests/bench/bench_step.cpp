// SPDX-License-Identifier: MIT
// Time, iterations, memory and error of forward and backward steps.
//
//   bench_step [--csv FILE] [--threads LIST] [--quick] [--scenes LIST] [--grid NXxNYxNZ] [--data DIR] [--steps N]
//              [--repeat N] [--budget SECONDS] [--methods LIST] [--threshold LIST] [--tolerance LIST]
//              [--integrators LIST] [--precision LIST] [--quadrature full|reduced]
//              [--sweep tolerance|adjoint|threshold|quadrature|model] [--algebraic] [--discretisation] [--reference]
//              [--oracle auto|direct|pcg] [--scaling] [--indicator] [--sigma S]
//
// A run is a rollout of some steps under a sine and its backward sweep with the gradient by weights; times are per
// step, medians over --repeat, and the least of them, from which a machine that others use too takes less; each
// configuration in a process of its own.
// state_error and gradient_error are against newton_direct at 1e-12 on the full box (threshold 0): what solver and
// threshold make of one discrete problem. A tag in the scene column names another exact answer:
//   :same_cells  at 1e-12 on the row's own active cells, the solver's error alone (--algebraic, --sweep tolerance)
//   :h/8         eight steps for one, cells and threshold as in the row (--discretisation)
//   :dx/2        cells of half the size with the same blur in metres (--discretisation; both for newton_pcg on active
//                cells, one thread)
// --sweep adjoint prints, and writes in columns of its own, the gradient's error over the tolerance of the adjoints.
// --sweep quadrature: eight integration points a cell against one, on cells of the grid's size and of half of it; the
// error of the state is against eight points on cells of a quarter of the size (with the same blur in metres, to 1e-8),
// and that of one point on those says how far the two disagree there. In columns of its own.
// --sweep model: what a simpler scene leaves out. planar: nothing moves along z; plane: two dimensions, the plane
// through the middle of the bases with the same muscles (caudal ones only), its nodes against those in the middle of
// the full scene; no_water. Errors are against the full scene at 1e-9, that of the travel relative to its own there.
// --indicator sets the a-priori estimate of a threshold's error (motion/threshold.hpp) beside the measured ones of
// newton_pcg, against the full box at 1e-9, and prints the cells and the time that the threshold leaves.
// In boxes of more than 6000 cells, where factorising the Hessian takes minutes, the exact answer is newton_pcg's at
// 1e-12 (--oracle direct insists); on the eel its answer at 1e-10 is within 1e-10 of newton_direct's.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <tuple>

#include "motion/threshold.hpp"
#include "shape/shape_space.hpp"
#include "support.hpp"

namespace {

using namespace bench;

constexpr char kHeader[] =
    "scene,grid,active_cells,threshold,method,integrator,precision,tolerance,threads,setup_ms,forward_ms,backward_ms,"
    "newton_iterations,linear_iterations,adjoint_iterations,residual,state_error,gradient_error,peak_mib,"
    "forward_least_ms,backward_least_ms";

constexpr char kAdjointHeader[] =
    "scene,grid,active_cells,threshold,tolerance,adjoint_tolerance,adjoint_iterations,backward_ms,gradient_error";

constexpr char kQuadratureHeader[] =
    "scene,grid,active_cells,quadrature,cells_per_cell,steps,forward_ms,backward_ms,state_error";

constexpr char kModelHeader[] =
    "scene,grid,active_cells,model,steps,forward_ms,backward_ms,state_error,travel_error,gradient_error";

struct Settings : SceneRuns {
    std::string oracle = "auto";
    std::vector<std::string> methods{"newton_pcg", "projective", "newton_direct"}, integrators{"euler"},
        precisions{"single"};
    Vector thresholds{0.02, 0.0}, tolerances{1e-6};
    int steps = 5, quadrature = 1;
    double sigma = 0.4;
    bool adjoints = false, quadratures = false, models = false, indicator = false, algebraic = false,
         discretisation = false, scaling = false;
};

bool small(const Scene& scene) {
    return scene.grid[0] * scene.grid[1] * scene.grid[2] <= 6000;
}

Setup setup_of(const Settings& s, int method, int integrator, double threshold, double tolerance, int threads) {
    Setup out;
    out.method = method, out.integrator = integrator, out.threshold = threshold, out.threads = threads;
    out.tolerance = tolerance;
    out.steps = s.steps, out.repeat = s.repeat, out.budget = s.budget, out.quadrature = s.quadrature;
    return out;
}

class Bench {
public:
    explicit Bench(const Settings& s)
        : s_(s),
          csv_(s.csv, s.adjoints      ? kAdjointHeader
                      : s.quadratures ? kQuadratureHeader
                      : s.models      ? kModelHeader
                                      : kHeader) {}

    void scene(const Scene& scene) {
        exact_.clear();
        for (const std::string& integrator : s_.integrators)
            for (const double threshold : s_.thresholds)
                for (const std::string& method : s_.methods)
                    for (const double tolerance : s_.tolerances)
                        for (const std::string& precision : s_.precisions)
                            for (const double threads : s_.threads) {
                                if (method == kMethods[1] && precision != s_.precisions.front()) continue;
                                Setup setup = setup_of(s_, place(kMethods, method), place(kIntegrators, integrator),
                                                       threshold, tolerance, static_cast<int>(threads));
                                setup.precision = place(kPrecisions, precision);
                                library(scene, setup);
                            }
        if (!s_.reference && !(s_.quick && scene.name == "eel")) return;
        const Vector tolerances = s_.tolerances.size() > 1 ? s_.tolerances : Vector{1e-1, 1e-6};
        for (const double tolerance : tolerances) {
            if (tolerance < 1e-6) continue;  // minutes, and nobody waits for them
            Setup setup = setup_of(s_, kReferenceMethod, 0, 0.0, tolerance, 1);
            setup.repeat = s_.quick ? 1 : s_.repeat, setup.quadrature = 0;
            if (const auto got = measure(scene, setup))
                report(scene, "", setup, *got, *exact(scene, 0.0, 0, setup.quadrature));
        }
    }

    // Set-up, step and memory over the grid, for the same animals; errors are those of the solver.
    void scaling(const std::string& name) {
        static constexpr int kGrids[][3] = {{24, 8, 12},  {36, 10, 16}, {48, 13, 21},
                                            {60, 16, 26}, {84, 23, 37}, {120, 32, 52}};
        Vector cells, forward, backward, setup_ms, peak;
        for (const auto& g : kGrids) {
            if (s_.quick && g[0] > 48) break;
            const auto scene = open_scene(name, s_.data, {g[0], g[1], g[2]});
            if (!scene) return;
            exact_.clear();
            for (const double threads : s_.threads) {
                Setup setup = setup_of(s_, 0, 0, s_.thresholds.front(), 1e-6, static_cast<int>(threads));
                const auto got = measure(*scene, setup);
                const Outcome* truth = got ? exact(*scene, setup.threshold, 0, setup.quadrature, 1e-10) : nullptr;
                if (!truth) continue;
                report(*scene, ":same_cells", setup, *got, *truth);
                if (threads != s_.threads.front()) continue;
                cells.push_back(got->active_cells), setup_ms.push_back(got->setup_ms), peak.push_back(got->peak_mib);
                forward.push_back(spread_of(got->forward).median), backward.push_back(spread_of(got->backward).median);
            }
        }
        const auto exponent = [&](const Vector& y) {  // least squares in logarithms
            double sx = 0, sy = 0, sxx = 0, sxy = 0;
            const double n = static_cast<double>(cells.size());
            for (std::size_t k = 0; k < cells.size(); ++k) {
                const double x = std::log(cells[k]), z = std::log(y[k]);
                sx += x, sy += z, sxx += x * x, sxy += x * z;
            }
            return (n * sxy - sx * sy) / (n * sxx - sx * sx);
        };
        if (cells.size() > 1)
            std::printf(
                "time and memory grow with active cells to the power: set-up %.2f, forward %.2f, backward "
                "%.2f, peak %.2f\n",
                exponent(setup_ms), exponent(forward), exponent(backward), exponent(peak));
    }

    // The gradient's error over the tolerance of the adjoints, on the same cells: it falls until that of the states is
    // all that is left.
    void adjoints(const Scene& scene) {
        exact_.clear();
        for (const double threshold : s_.thresholds)
            for (const double tolerance : s_.tolerances)
                for (const double adjoint : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12}) {
                    Setup setup = usual(threshold, tolerance);
                    setup.adjoint_tolerance = adjoint;
                    const auto got = measure(scene, setup);
                    const Outcome* truth = got ? exact(scene, threshold, 0, setup.quadrature) : nullptr;
                    if (!truth) continue;
                    const double error = gradient_error(*got, *truth), ms = spread_of(got->backward).median / s_.steps;
                    std::printf(
                        "%-12s %6.0f cells tau %g: tolerance %.0e, of adjoints %.0e: %5.1f iterations a step, "
                        "backward %8.2f ms, gradient error %.1e\n",
                        scene.name.c_str(), got->active_cells, threshold, tolerance, adjoint, got->adjoint, ms, error);
                    std::fflush(stdout);
                    csv_.row("%s,%s,%.0f,%g,%g,%g,%.2f,%.4f,%.3e\n", scene.name.c_str(), scene.grid_text().c_str(),
                             got->active_cells, threshold, tolerance, adjoint, got->adjoint, ms, error);
                }
    }

    // What few points of integration cost and save, beside what smaller cells do.
    void quadratures(const Scene& scene) {
        constexpr int kFinest = 4;
        const auto finest = open_scene(scene.name, s_.data, scene.grid, kFinest, s_.sigma);
        Setup setup = usual(s_.thresholds.front(), 1e-8);
        setup.quadrature = 0, setup.repeat = 1;
        const auto truth = finest ? measure(*finest, setup) : std::nullopt;
        if (!truth) return;
        for (int refine = 1; refine <= kFinest; refine *= 2)
            for (int quadrature = refine < kFinest ? 0 : 1; quadrature < 2; ++quadrature) {
                const auto own = open_scene(scene.name, s_.data, scene.grid, refine, s_.sigma);
                setup = usual(s_.thresholds.front(), s_.tolerances.front());
                setup.quadrature = quadrature;
                if (refine == kFinest) setup.repeat = 1;
                const auto got = own ? measure(*own, setup) : std::nullopt;
                if (!got) continue;
                const double error = state_error(*got, *truth, *own, kFinest / refine);
                const double forward = spread_of(got->forward).median / s_.steps;
                const double backward = spread_of(got->backward).median / s_.steps;
                std::printf("%-12s %6.0f cells, %d for one, %-7s: forward %8.2f ms, backward %8.2f ms, error %.2e\n",
                            own->name.c_str(), got->active_cells, refine * refine * refine, kQuadratures[quadrature],
                            forward, backward, error);
                std::fflush(stdout);
                csv_.row("%s,%s,%.0f,%s,%d,%d,%.4f,%.4f,%.3e\n", own->name.c_str(), own->grid_text().c_str(),
                         got->active_cells, kQuadratures[quadrature], refine * refine * refine, s_.steps, forward,
                         backward, error);
            }
    }

    // What simpler scenes cost and what they get wrong.
    void models(const Scene& scene) {
        exact_.clear();
        const Outcome* truth = exact(scene, s_.thresholds.front(), 0, s_.quadrature, 1e-9);
        if (!truth) return;
        for (const std::string model : kModels) {
            Setup setup = usual(s_.thresholds.front(), s_.tolerances.front());
            setup.planar = model == "planar", setup.water = model != "no_water";
            const bool plane = model == "plane";
            const auto own = plane ? middle_plane(scene, s_.sigma) : std::optional(scene);
            if (!own) {
                std::printf("%-12s %-8s is left out: it has muscles that a plane does not have\n", scene.name.c_str(),
                            model.c_str());
                continue;
            }
            auto got = measure(*own, setup);
            if (!got) continue;
            if (plane) got = in_the_middle(std::move(*got), scene);
            const double state = state_error(*got, *truth, scene), gradient = gradient_error(*got, *truth);
            const double travel = std::fabs(got->loss - truth->loss) / std::fabs(truth->loss);
            const double forward = spread_of(got->forward).median / s_.steps;
            const double backward = spread_of(got->backward).median / s_.steps;
            std::printf(
                "%-12s %-8s %6.0f cells, %d steps: forward %8.2f ms, backward %8.2f ms, travel %8.2f mm, errors of "
                "state %.1e, travel %.1e, gradient %.1e\n",
                scene.name.c_str(), model.c_str(), got->active_cells, s_.steps, forward, backward, -1e3 * got->loss,
                state, travel, gradient);
            std::fflush(stdout);
            csv_.row("%s,%s,%.0f,%s,%d,%.4f,%.4f,%.3e,%.3e,%.3e\n", scene.name.c_str(), own->grid_text().c_str(),
                     got->active_cells, model.c_str(), s_.steps, forward, backward, state, travel, gradient);
        }
    }

    void indicator(const Scene& scene) {
        exact_.clear();
        const auto space = dqa::ShapeSpace::load(scene.file);
        const Vector weights(static_cast<std::size_t>(scene.n_bases), 1.0 / scene.n_bases);
        const dqa::ThresholdError estimate(space->box(), space->evaluate(weights, 0.0, 1, nullptr).p_hat,
                                           dqa::SceneSettings{});
        for (const double threshold : s_.thresholds) {
            Setup setup = usual(threshold, s_.tolerances.front());
            const auto got = measure(scene, setup);
            const Outcome* truth = got ? exact(scene, 0.0, 0, setup.quadrature, 1e-9) : nullptr;
            if (!truth) continue;
            const double start = milliseconds(), eta = estimate(threshold), took = milliseconds() - start;
            const double state = state_error(*got, *truth, scene), gradient = gradient_error(*got, *truth);
            std::printf(
                "%-12s sigma %g tau %-6g %6.0f cells: estimate %.2e (%.2f ms), state error %.2e (%.2f of it), gradient "
                "error %.2e (%.2f), forward %.2f ms, backward %.2f ms, iterations %.1f %.0f %.0f\n",
                scene.name.c_str(), s_.sigma, threshold, got->active_cells, eta, took, state, state / eta, gradient,
                gradient / eta, spread_of(got->forward).median / s_.steps, spread_of(got->backward).median / s_.steps,
                got->newton, got->linear, got->adjoint);
            std::fflush(stdout);
        }
    }

    int failures() const { return failures_; }

private:
    // newton_pcg and implicit Euler with the first number of threads.
    Setup usual(double threshold, double tolerance) const {
        return setup_of(s_, 0, 0, threshold, tolerance, static_cast<int>(s_.threads.front()));
    }

    std::optional<Outcome> measure(const Scene& scene, const Setup& setup) {
        try {
            return run(scene, setup);
        } catch (const std::runtime_error& e) {
            std::printf("%-12s %-13s tolerance %.0e threshold %g: %s\n", scene.name.c_str(), kMethods[setup.method],
                        setup.tolerance, setup.threshold, e.what());
            ++failures_;
            return std::nullopt;
        }
    }

    // The exact answer of a threshold, computed once; null where it failed.
    const Outcome* exact(const Scene& scene, double threshold, int integrator, int quadrature,
                         double tolerance = 1e-12) {
        const auto key = std::tuple(scene.file, threshold, integrator, quadrature);
        const auto found = exact_.find(key);
        if (found != exact_.end()) return found->second ? &*found->second : nullptr;
        const bool direct = s_.oracle == "direct" || (s_.oracle == "auto" && small(scene) && tolerance <= 1e-12);
        Setup setup = setup_of(s_, direct ? 1 : 0, integrator, threshold, tolerance, 1);
        setup.adjoint_tolerance = tolerance, setup.repeat = 1, setup.quadrature = quadrature;
        const double start = milliseconds();
        auto& entry = exact_[key] = measure(scene, setup);
        if (entry)
            std::printf("%-12s exact answer by %s at %.0e, threshold %g: %.0f cells, %.1f s\n", scene.name.c_str(),
                        kMethods[setup.method], tolerance, threshold, entry->active_cells,
                        1e-3 * (milliseconds() - start));
        std::fflush(stdout);
        return entry ? &*entry : nullptr;
    }

    void library(const Scene& scene, const Setup& setup) {
        const int form = setup.integrator;
        const double threshold = setup.threshold;
        if (setup.method == 1 && !small(scene) && s_.oracle != "direct") return;
        const auto got = measure(scene, setup);
        if (!got) return;
        if (const Outcome* truth = exact(scene, 0.0, form, setup.quadrature)) report(scene, "", setup, *got, *truth);
        if (s_.algebraic && threshold > 0)
            if (const Outcome* truth = exact(scene, threshold, form, setup.quadrature))
                report(scene, ":same_cells", setup, *got, *truth);
        if (!s_.discretisation || setup.method != 0 || setup.threads != 1 || threshold <= 0) return;
        Setup fine = setup;
        fine.time_step /= 8.0, fine.steps *= 8, fine.repeat = 1, fine.tolerance = fine.adjoint_tolerance = 1e-8;
        if (const auto truth = measure(scene, fine))
            report(scene, ":h/8", setup, *got, *truth, 1, Actuations::amplitudes);
        fine.time_step = setup.time_step, fine.steps = setup.steps;
        if (const auto half = open_scene(scene.name, s_.data, scene.grid, 2, s_.sigma))
            if (const auto truth = measure(*half, fine))
                report(scene, ":dx/2", setup, *got, *truth, 2, Actuations::amplitudes);
    }

    void report(const Scene& scene, const char* tag, const Setup& setup, const Outcome& o, const Outcome& exact,
                int fine = 1, Actuations actuations = Actuations::each) {
        const double steps = setup.steps;
        const Spread forward = spread_of(o.forward), backward = spread_of(o.backward);
        const double state = state_error(o, exact, scene, fine);
        const double gradient = gradient_error(o, exact, actuations);
        const bool iterative = setup.method == 0 || setup.method == 2;
        std::printf(
            "%-12s%-12s %-13s %-5s %.0e tau %-5g %d thr %6.0f cells: set-up %6.0f ms, forward %8.2f ms [%.2f, %.2f], "
            "backward %8.2f ms [%.2f, %.2f], pullback %.0f ms, iterations %.1f %.0f %.0f, residual %.1e, error %.1e "
            "%.1e, %.0f MiB\n",
            scene.name.c_str(), tag, kMethods[setup.method], kIntegrators[setup.integrator], setup.tolerance,
            setup.threshold, setup.threads, o.active_cells, o.setup_ms, forward.median / steps, forward.least / steps,
            forward.largest / steps, backward.median / steps, backward.least / steps, backward.largest / steps,
            spread_of(o.pullback).median, o.newton, o.linear, o.adjoint, o.residual, state, gradient, o.peak_mib);
        std::fflush(stdout);
        csv_.row("%s%s,%s,%.0f,%g,%s,%s,%s,%g,%d,%.3f,%.4f,%.4f,%.2f,%.2f,%.2f,%.3e,%.3e,%.3e,%.1f,%.4f,%.4f\n",
                 scene.name.c_str(), tag, scene.grid_text().c_str(), o.active_cells, setup.threshold,
                 kMethods[setup.method], kIntegrators[setup.integrator],
                 iterative ? kPrecisions[setup.precision] : "double", setup.tolerance, setup.threads, o.setup_ms,
                 forward.median / steps, backward.median / steps, o.newton, o.linear, o.adjoint, o.residual, state,
                 gradient, o.peak_mib, forward.least / steps, backward.least / steps);
    }

    const Settings& s_;
    Csv csv_;
    std::map<std::tuple<std::string, double, int, int>, std::optional<Outcome>> exact_;
    int failures_ = 0;
};

Settings parse(int argc, char** argv) {
    Settings s;
    s.repeat = 5;
    Options options;
    s.add_to(options);
    options.flag("--quick", [&] { s.quick = true, s.steps = 3, s.repeat = 3; });
    options.whole("--steps", s.steps);
    options.list("--methods", s.methods);
    options.list("--threshold", s.thresholds);
    options.list("--tolerance", s.tolerances);
    options.list("--integrators", s.integrators);
    options.list("--precision", s.precisions);
    options.value("--quadrature", [&](const std::string& what) { s.quadrature = place(kQuadratures, what); });
    options.value("--sweep", [&](const std::string& what) {
        if (what == "tolerance") {
            s.tolerances = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10}, s.algebraic = true;
        } else if (what == "adjoint") {
            s.adjoints = true, s.tolerances = {1e-6, 1e-10}, s.thresholds = {0.02};
        } else if (what == "quadrature") {
            s.quadratures = true, s.thresholds = {0.02};
        } else if (what == "model") {
            s.models = true, s.thresholds = {0.02};
        } else if (what == "threshold") {
            s.thresholds = {0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.0};
        } else {
            throw UsageError("--sweep takes tolerance, adjoint, threshold, quadrature or model");
        }
    });
    options.flag("--algebraic", s.algebraic);
    options.flag("--discretisation", s.discretisation);
    options.text("--oracle", s.oracle);
    options.flag("--indicator", s.indicator);
    options.positive("--sigma", s.sigma);
    options.flag("--scaling", s.scaling);
    options.parse(argc, argv);
    for (const std::string& method : s.methods)
        if (place(kMethods, method) == kReferenceMethod) throw UsageError("the reference comes with --reference");
    for (const std::string& integrator : s.integrators) place(kIntegrators, integrator);
    for (const std::string& precision : s.precisions) place(kPrecisions, precision);
    if (s.oracle != "auto" && s.oracle != "direct" && s.oracle != "pcg")
        throw UsageError("--oracle takes auto, direct or pcg");
    if (s.scenes.empty())
        s.scenes = s.quick || s.scaling ? std::vector<std::string>{s.scaling ? "shipped" : "eel"}
                                        : std::vector<std::string>{"eel", "shipped", "orca_shark", "three"};
    return s;
}

}  // namespace

int main(int argc, char** argv) {
    return bench::run_program("bench_step", [&] {
        const Settings s = parse(argc, argv);
        Bench bench(s);
        for (const std::string& name : s.scenes) {
            if (s.scaling) {
                bench.scaling(name);
            } else if (const auto scene = open_scene(name, s.data, s.grid, 1, s.sigma)) {
                if (s.adjoints)
                    bench.adjoints(*scene);
                else if (s.quadratures)
                    bench.quadratures(*scene);
                else if (s.models)
                    bench.models(*scene);
                else if (s.indicator)
                    bench.indicator(*scene);
                else
                    bench.scene(*scene);
            }
        }
        if (bench.failures() > 0) std::printf("%d configurations failed\n", bench.failures());
    });
}
