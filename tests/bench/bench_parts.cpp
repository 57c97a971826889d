// SPDX-License-Identifier: MIT
// What the parts of a linear iteration cost, and how far that is from the least their memory traffic allows.
//
//   bench_parts [--csv FILE] [--threads LIST] [--quick] [--scenes LIST] [--grid NXxNYxNZ] [--data DIR] [--repeat N]
//
// A part is timed alone, at the state after --repeat steps of a sine, least of many calls. Its bytes are those that it
// must move: everything that is stored for it, read once, and its vectors, in and out once; what it moves besides
// (element forces on their way to the nodes) is its own affair. The bound is the time in which a triad a = b + s c over
// arrays of as many bytes in all moves them, on the same threads: the bandwidth of the cache that holds as much.
//   body        Hessian-vector product of tissue and muscles
//   water       the same of the water
//   multilevel  preconditioner by diagonal blocks and coarse grids
//   factor      preconditioner by the packed factor and coarse grids
//   vectors     what conjugate gradients do besides
//   forces      energy and forces of the body with their linearisation
// `iteration` is body, water, multilevel and vectors together, one after the other; steps update their vectors on the
// way of the other loops, so that their iterations take less. Solves iterate in single precision, and check themselves
// in double precision.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "motion/simulation.hpp"
#include "support.hpp"

namespace {

using namespace bench;
using dqa::Threads;

constexpr char kHeader[] =
    "scene,grid,active_cells,part,precision,threads,kib,bandwidth_gb_s,bound_us,time_us,times_bound,speed_up";

struct Settings : SceneRuns {
    double seconds = 0.4;  // of each part
};

// Least time of a call (us), over calls that take `seconds` in all.
double least_time(double seconds, const std::function<void()>& call) {
    double least = 1e300;
    const double end = milliseconds() + 1e3 * seconds;
    for (int k = 0; k < 10 || milliseconds() < end; ++k) {
        const double start = milliseconds();
        call();
        least = std::min(least, 1e3 * (milliseconds() - start));
    }
    return least;
}

// Bytes a microsecond of a triad whose arrays hold `bytes` together.
double triad(double bytes, double seconds, Threads threads) {
    const int n = std::max(1, static_cast<int>(bytes / (3 * sizeof(double))));
    Vector a(static_cast<std::size_t>(n), 0.0), b(a.size(), 1.0), c(a.size(), 2.0);
    const double time = least_time(seconds, [&] {
        dqa::parallel_chunks(threads, n, 2048, [&](int begin, int end) {
            for (int i = begin; i < end; ++i) {
                const std::size_t k = static_cast<std::size_t>(i);
                a[k] = b[k] + 0.5 * c[k];
            }
        });
    });
    return static_cast<double>(3 * sizeof(double)) * n / time;
}

class Bench {
public:
    explicit Bench(const Settings& s) : s_(s), csv_(s.csv, kHeader) {}

    void scene(const Scene& scene) {
        dqa::SceneSettings settings;
        const std::shared_ptr<const dqa::ShapeSpace> space = dqa::ShapeSpace::load(scene.file);
        const Vector weights(static_cast<std::size_t>(scene.n_bases), 1.0 / scene.n_bases);
        const auto design = std::make_shared<dqa::Design>(space, weights, settings, nullptr);
        settings.preconditioner = dqa::PreconditionerKind::factor;
        const auto with_factor = std::make_shared<dqa::Design>(*design, settings);
        dqa::Simulation simulation(design);
        Vector signals;
        for (int k = 0; k < s_.repeat; ++k) {
            signals.clear();
            for (int n = 0; n < design->n_signals(); ++n) signals.push_back(actuation((k + 1) * settings.time_step, n));
            simulation.step({signals.data(), {}});
        }
        one_.clear();
        for (const double threads : s_.threads)
            dqa::with_crew(static_cast<int>(threads), [&](Threads t) {
                parts<float>(scene, *design, *with_factor, simulation.state(), signals, t);
                parts<double>(scene, *design, *with_factor, simulation.state(), signals, t);
            });
    }

private:
    template <class T>
    void parts(const Scene& scene, const dqa::Design& design, const dqa::Design& with_factor, const dqa::State& state,
               const Vector& signals, Threads threads) {
        const std::size_t size = 3 * static_cast<std::size_t>(design.n_nodes());
        constexpr bool single = sizeof(T) == sizeof(float);
        const double field = static_cast<double>(size * sizeof(T)), h = design.scene().time_step;
        const double* q = state.q.data();
        Vector elastic(size), muscles(size), right(size), solution(size);
        std::vector<T> p(size + 1), out(size), other(size);
        for (std::size_t i = 0; i < size; ++i)
            right[i] = std::sin(1.0 + static_cast<double>(i)), p[i] = static_cast<T>(right[i]);
        sum_bound_ = sum_time_ = sum_bytes_ = 0.0;
        const auto part = [&](const char* name, double bytes, bool of_iteration, const std::function<void()>& call) {
            const double bandwidth = triad(bytes, s_.seconds, threads);
            report(scene, design, name, single, threads, bytes, bytes / bandwidth, least_time(s_.seconds, call),
                   of_iteration);
        };

        dqa::BodyWorkspace body;
        const auto forces = [&] {
            design.body().gradient(body, q, signals.data(), threads, elastic.data(), muscles.data());
        };
        forces();
        design.body().to_single(body, threads);
        double cache = 0.0;
        for (const dqa::TermWorkspace& term : body.terms)
            cache += static_cast<double>((term.in(T()).cache.size() + term.in(T()).rest.size()) * sizeof(T));
        part("body", cache + 3 * field, true, [&] { design.body().product(body, p.data(), threads, out.data()); });

        if (const dqa::Water* water = design.water()) {
            dqa::WaterWorkspace ws;
            water->lag(ws, q, state.v.data(), design.sensors().direction(q), {}, threads);
            const dqa::WaterResistance<T>& of = ws.in(T());
            const double faces = static_cast<double>((of.cd.size() + of.ct.size() + of.n.size()) * sizeof(T));
            part("water", faces + 3 * field, true, [&] { water->product(ws, p.data(), h, threads, out.data()); });
        }
        for (const bool factor : {false, true}) {
            if (factor && single) continue;  // the factor takes and gives vectors in double precision
            const dqa::Preconditioner& preconditioner = (factor ? with_factor : design).preconditioner();
            dqa::Preconditioner::Workspace ws;
            preconditioner.turn(q, threads, ws);
            part(factor ? "factor" : "multilevel", static_cast<double>(preconditioner.bytes()) + 3 * field, !factor,
                 [&] { preconditioner.solve(p.data(), 1.0, false, other.data(), out.data(), threads, ws); });
        }
        // Stand-ins that cost nothing; the residual alternates, so that all iterations are done.
        constexpr int kIterations = 20;
        dqa::PcgWorkspace ws;
        const auto iterate = [&] {
            if (single)
                dqa::mixed_pcg(
                    size, right.data(), solution.data(), 0.0, kIterations, idle<double>(), idle<float>(),
                    [](const float*) { return 0.0; }, threads, ws);
            else
                dqa::pcg(size, right.data(), solution.data(), 0.0, kIterations, idle<double>(), threads, ws);
        };
        const double vectors = least_time(s_.seconds, iterate) / kIterations, bytes = 9 * field;
        report(scene, design, "vectors", single, threads, bytes, bytes / triad(bytes, s_.seconds, threads), vectors,
               true);
        report(scene, design, "iteration", single, threads, sum_bytes_, sum_bound_, sum_time_, false);
        if (!single) part("forces", cache + 3 * field, false, forces);
    }

    template <class T>
    static dqa::PcgProducts<T> idle() {
        return {[](const T*, T*) { return 1.0; },
                [](const T*, double, bool, const T*, T*) {
                    return std::array<double, 2>{1.0, -1.0};
                }};
    }

    void report(const Scene& scene, const dqa::Design& design, const char* part, bool single, Threads threads,
                double bytes, double bound, double time, bool of_iteration) {
        const char* precision = kPrecisions[single ? 0 : 1];
        if (of_iteration) sum_bytes_ += bytes, sum_bound_ += bound, sum_time_ += time;
        const double one = one_.try_emplace(std::string(part) + precision, time).first->second;
        std::printf(
            "%-12s %6d cells, %d threads: %-10s %s %8.0f KiB at %5.1f GB/s: bound %7.1f us, takes %7.1f us: %4.1f "
            "times, "
            "speed-up %.2f\n",
            scene.name.c_str(), design.set().n_cells(), threads.count, part, precision, bytes / 1024,
            1e-3 * bytes / bound, bound, time, time / bound, one / time);
        std::fflush(stdout);
        csv_.row("%s,%s,%d,%s,%s,%d,%.1f,%.2f,%.4f,%.4f,%.4f,%.3f\n", scene.name.c_str(), scene.grid_text().c_str(),
                 design.set().n_cells(), part, precision, threads.count, bytes / 1024, 1e-3 * bytes / bound, bound,
                 time, time / bound, one / time);
    }

    const Settings& s_;
    Csv csv_;
    std::map<std::string, double> one_;  // time of each part with the first number of threads
    double sum_bytes_ = 0.0, sum_bound_ = 0.0, sum_time_ = 0.0;
};

}  // namespace

int main(int argc, char** argv) {
    return run_program("bench_parts", [&] {
        Settings s;
        s.repeat = 6;
        Options options;
        s.add_to(options);
        options.flag("--quick", [&] { s.quick = true, s.seconds = 0.05; });
        options.parse(argc, argv);
        if (s.scenes.empty()) s.scenes = {"eel"};
        Bench bench(s);
        for (const std::string& name : s.scenes)
            if (const auto scene = open_scene(name, s.data, s.grid)) bench.scene(*scene);
    });
}
