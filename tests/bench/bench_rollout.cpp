// SPDX-License-Identifier: MIT
// Time, memory and error of whole rollouts: one second of swimming and its gradient.
//
//   bench_rollout [--csv FILE] [--threads LIST] [--quick] [--scenes LIST] [--grid NXxNYxNZ] [--data DIR]
//                 [--seconds S] [--rates LIST] [--repeat N] [--budget SECONDS] [--reference]
//
// --rates are steps per second, 1/h. Implicit Euler and BDF2 run at every rate; at 30, the default of the library (or
// the first given), the methods, the threads and the budgets of the tape (none, 64 and 8 MiB) take their turns.
// loss_error and gradient_error are against BDF2 with an eighth of the shortest time step, at a tolerance of 1e-8 on
// the same cells: what time step and solver make of one body. The loss is the distance travelled (m), its error
// relative to the larger of the loss and a tenth of the body's mean displacement; the gradient is by weights and by the
// amplitude of the sine. Times are of the whole rollout and of its whole gradient, medians over --repeat.
// checkpoint_mib 0: a tape without limit.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "support.hpp"

namespace {

using namespace bench;

constexpr char kHeader[] =
    "scene,grid,active_cells,method,integrator,steps,h,tolerance,threads,checkpoint_mib,forward_ms,backward_ms,loss,"
    "loss_error,gradient_error,peak_mib";

struct Settings : SceneRuns {
    Vector rates{15, 30, 60, 120};
    double seconds = 1.0;
};

double mean_displacement(const Outcome& o) {
    double sum = 0.0, mass = 0.0;
    for (std::size_t i = 0; i < o.q.size(); ++i) {
        const double u = o.q[i] - o.rest[i], m = o.mass[i / 3];
        sum += m * u * u, mass += m / 3.0;
    }
    return std::sqrt(sum / mass);
}

class Bench {
public:
    explicit Bench(const Settings& s) : s_(s), csv_(s.csv, kHeader) {}

    void scene(const Scene& scene) {
        Setup fine = setup(8.0 * *std::max_element(s_.rates.begin(), s_.rates.end()));
        fine.integrator = 1, fine.tolerance = fine.adjoint_tolerance = 1e-8, fine.repeat = 1;
        const double start = milliseconds();
        const auto exact = measure(scene, fine);
        if (!exact) return;
        std::printf("%-12s exact answer by bdf2, %d steps: loss %.6f m, %.1f s\n", scene.name.c_str(), fine.steps,
                    exact->loss, 1e-3 * (milliseconds() - start));
        for (int integrator = 0; integrator < 2; ++integrator)
            for (const double rate : s_.rates) {
                Setup one = setup(rate);
                one.integrator = integrator;
                row(scene, one, *exact);
            }
        const bool has_default = std::find(s_.rates.begin(), s_.rates.end(), 30.0) != s_.rates.end();
        const Setup usual = setup(has_default ? 30.0 : s_.rates.front());
        Setup other = usual;
        other.method = 2;
        row(scene, other, *exact);
        for (const double mib : {64.0, 8.0}) {
            other = usual, other.checkpoint = mib * 1048576.0;
            row(scene, other, *exact);
        }
        for (const double threads : s_.threads) {
            if (threads == s_.threads.front()) continue;
            other = usual, other.threads = static_cast<int>(threads);
            row(scene, other, *exact);
        }
        if (!s_.reference && !(s_.quick && scene.name == "eel")) return;
        other = usual, other.method = kReferenceMethod, other.repeat = 1;
        other.threshold = 0.0, other.tolerance = 1e-1, other.adjoint_tolerance = 1e-3;  // as the paper's examples
        row(scene, other, *exact);
        if (!s_.reference) return;
        other.tolerance = other.adjoint_tolerance = 1e-6;
        row(scene, other, *exact);
    }

private:
    Setup setup(double rate) const {
        Setup out;
        out.time_step = 1.0 / rate, out.steps = static_cast<int>(std::lround(s_.seconds * rate));
        out.threads = static_cast<int>(s_.threads.front());
        out.repeat = s_.repeat, out.budget = s_.budget;
        return out;
    }

    std::optional<Outcome> measure(const Scene& scene, const Setup& setup) {
        try {
            return run(scene, setup);
        } catch (const std::runtime_error& e) {
            std::printf("%-12s %-13s %-5s h %.4g: %s\n", scene.name.c_str(), kMethods[setup.method],
                        kIntegrators[setup.integrator], setup.time_step, e.what());
            return std::nullopt;
        }
    }

    void row(const Scene& scene, const Setup& setup, const Outcome& exact) {
        const auto got = measure(scene, setup);
        if (!got) return;
        Vector sweep(got->backward);
        for (std::size_t k = 0; k < sweep.size() && k < got->pullback.size(); ++k) sweep[k] += got->pullback[k];
        const Spread forward = spread_of(got->forward), backward = spread_of(sweep);
        const double loss_error =
            std::fabs(got->loss - exact.loss) / std::max(std::fabs(exact.loss), 0.1 * mean_displacement(exact));
        const double gradient = gradient_error(*got, exact, Actuations::amplitudes);
        const double checkpoint = setup.checkpoint / 1048576.0;
        std::printf(
            "%-12s %6.0f cells %-13s %-5s %4d steps of %.4f s, %d threads, checkpoints %2.0f MiB (tape %.1f): "
            "forward %8.1f ms [%.1f, %.1f], backward %8.1f ms [%.1f, %.1f], loss %.6f, error %.1e %.1e, "
            "%.0f MiB\n",
            scene.name.c_str(), got->active_cells, kMethods[setup.method], kIntegrators[setup.integrator], setup.steps,
            setup.time_step, setup.threads, checkpoint, got->tape_mib, forward.median, forward.least, forward.largest,
            backward.median, backward.least, backward.largest, got->loss, loss_error, gradient, got->peak_mib);
        std::fflush(stdout);
        csv_.row("%s,%s,%.0f,%s,%s,%d,%.6g,%g,%d,%g,%.3f,%.3f,%.9g,%.3e,%.3e,%.1f\n", scene.name.c_str(),
                 scene.grid_text().c_str(), got->active_cells, kMethods[setup.method], kIntegrators[setup.integrator],
                 setup.steps, setup.time_step, setup.tolerance, setup.threads, checkpoint, forward.median,
                 backward.median, got->loss, loss_error, gradient, got->peak_mib);
    }

    const Settings& s_;
    Csv csv_;
};

Settings parse(int argc, char** argv) {
    Settings s;
    Options options;
    s.add_to(options);
    options.flag("--quick", [&] { s.quick = true, s.seconds = 0.2, s.repeat = 1; });
    options.positive("--seconds", s.seconds);
    options.list("--rates", s.rates);
    options.parse(argc, argv);
    for (const double rate : s.rates)
        if (!(rate > 0) || s.seconds * rate < 1.0) throw UsageError("--rates and --seconds must make a step or more");
    if (s.scenes.empty())
        s.scenes = s.quick ? std::vector<std::string>{"eel"} : std::vector<std::string>{"eel", "shipped", "orca_shark"};
    return s;
}

}  // namespace

int main(int argc, char** argv) {
    return bench::run_program("bench_rollout", [&] {
        const Settings s = parse(argc, argv);
        Bench bench(s);
        for (const std::string& name : s.scenes)
            if (const auto scene = open_scene(name, s.data, s.grid)) bench.scene(*scene);
    });
}
