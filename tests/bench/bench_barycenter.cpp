// SPDX-License-Identifier: MIT
// Time and error of the barycentre and of its pullback over bases, width of the kernel, method and tolerance.
//
//   bench_barycenter [--csv FILE] [--threads N] [--grid NXxNYxNZ] [--sigma S] [--repeat N] [--budget SECONDS] [--quick]
//                    [--data DIR]
//
// Two bases: Orca.stl and GreatWhiteShark.stl of DIR, or the shipped clownfish and tuna. Twelve: these, all shipped
// shapes, and stretched ones. Times are medians of --repeat runs, of one where it takes more than a tenth of --budget
// (20 s); a method that took longer than the budget is not asked for tighter tolerances. vertex_iou: the worst base at
// its own vertex, half-peak set against covered fractions above 1/2. gradient_error: against a solve at 1e-12. Methods:
// newton, what the library does; logarithmic, the same with the logarithmic kernel; plain, the iteration without
// acceleration.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>

#include "grid/error.hpp"
#include "grid/random.hpp"
#include "shape/mesh_file.hpp"
#include "shape/shape_space.hpp"

namespace {

using namespace dqa;
using Vector = std::vector<double>;

struct Options {
    std::array<int, 3> grid{60, 16, 26};
    int threads = 1, repeat = 3;
    double sigma = 0;  // 0: several
    double budget = 20;
    bool quick = false;
    std::string csv, data;
};

[[noreturn]] void usage(const char* why) {
    std::fprintf(stderr,
                 "bench_barycenter: %s\nusage: bench_barycenter [--csv FILE] [--threads N] [--grid NXxNYxNZ] "
                 "[--sigma S] [--repeat N] [--budget SECONDS] [--quick] [--data DIR]\n",
                 why);
    std::exit(2);
}

Options parse(int argc, char** argv) {
    Options o;
    for (int k = 1; k < argc; ++k) {
        const std::string name = argv[k];
        if (name == "--quick") {
            o.quick = true, o.grid = {28, 10, 14}, o.repeat = 1;
            continue;
        }
        if (k + 1 >= argc) usage("unknown option, or its value is missing");
        const char* value = argv[++k];
        if (name == "--csv")
            o.csv = value;
        else if (name == "--data")
            o.data = value;
        else if (name == "--threads")
            o.threads = std::atoi(value);
        else if (name == "--repeat")
            o.repeat = std::atoi(value);
        else if (name == "--budget")
            o.budget = std::atof(value);
        else if (name == "--sigma")
            o.sigma = std::atof(value);
        else if (name == "--grid") {
            if (std::sscanf(value, "%dx%dx%d", &o.grid[0], &o.grid[1], &o.grid[2]) != 3) usage("--grid takes NXxNYxNZ");
        } else
            usage("unknown option");
    }
    if (o.threads < 1 || o.repeat < 1) usage("--threads and --repeat must be at least 1");
    if (!(o.budget > 0)) usage("--budget must be greater than 0");
    return o;
}

// The first `count` of twelve bases.
std::vector<BaseShape> bases_of(const Options& o, int count) {
    const std::string shipped = DQA_SHAPES_DIR "/";
    std::vector<std::string> files{shipped + "clownfish.stl", shipped + "tuna.stl", shipped + "eel_vertical.stl",
                                   shipped + "eel_horizontal.stl"};
    if (!o.data.empty()) files.insert(files.begin(), {o.data + "/Orca.stl", o.data + "/GreatWhiteShark.stl"});
    ShapeSettings settings;
    settings.cells = o.grid;
    ShapeSpace space(settings);
    const double across[][2] = {{1, 1}, {1.3, 1}, {1, 1.4}, {1.5, 1.2}};  // stretched in y and z
    for (int k = 0; k < count; ++k) {
        const std::size_t file = static_cast<std::size_t>(k) % files.size();
        const double* stretch = across[static_cast<std::size_t>(k) / files.size()];
        TriangleMesh mesh = read_mesh_file(files[file]);
        for (auto& v : mesh.vertices) v[1] *= stretch[0], v[2] *= stretch[1];
        space.add_mesh("base " + std::to_string(k), mesh);
    }
    space.build({});
    return space.bases();
}

template <class F>
double median_ms(const Options& o, F&& f) {
    Vector ms;
    for (int k = 0; k < o.repeat && (k == 0 || ms[0] < 100 * o.budget); ++k) {
        const auto start = std::chrono::steady_clock::now();
        f();
        ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    std::sort(ms.begin(), ms.end());
    return ms[ms.size() / 2];
}

double peak_mib() {
    rusage r;
    getrusage(RUSAGE_SELF, &r);
    return static_cast<double>(r.ru_maxrss) / 1024.0;
}

double vertex_iou(const GaussianKernel& kernel, const std::vector<BaseShape>& bases) {
    double worst = 1.0;
    for (const BaseShape& base : bases) {
        const Vector p = solve_barycenter(kernel, {base.density}, {1.0}, BarycenterSettings{}).p;
        const double peak = peak_of(p, Peak::smooth);
        double common = 0, either = 0;
        for (std::size_t c = 0; c < p.size(); ++c) {
            const bool a = p[c] > 0.5 * peak, b = base.fractions[c] > 0.5;
            common += a && b, either += a || b;
        }
        worst = std::min(worst, common / either);
    }
    return worst;
}

void measure(const Options& o, int count, double sigma, std::FILE* csv) {
    const std::vector<BaseShape> bases = bases_of(o, count);
    std::vector<Vector> densities;
    Vector weights;
    for (const BaseShape& b : bases) {
        densities.push_back(b.density);
        weights.push_back(count == 2 ? 0.5 : 1.0 + 0.5 * std::sin(3.0 * static_cast<double>(weights.size())));
    }
    double sum = 0;
    for (const double w : weights) sum += w;
    for (double& w : weights) w /= sum;
    const GaussianKernel kernel(o.grid, sigma);
    const double iou = vertex_iou(kernel, bases);
    Random random{7};
    Vector p_bar(static_cast<std::size_t>(kernel.size()));
    for (double& b : p_bar) b = random();
    BarycenterSettings s;
    s.max_iterations = 100000, s.tolerance = 1e-12;
    const Vector exact =
        barycenter_pullback(kernel, densities, solve_barycenter(kernel, densities, weights, s), p_bar.data(), s);
    struct Method {
        const char* name;
        int window;
        bool force_log;
        double tightest;
    };
    s.threads = o.threads;
    for (const Method& method :
         {Method{"newton", 15, false, 1e-11}, Method{"logarithmic", 15, true, count > 2 ? 1 : (o.quick ? 1e-9 : 1e-3)},
          Method{"plain", 0, false, count == 2 ? 1e-7 : 1e-4}})
        for (const double tolerance : {1e-3, 1e-5, 1e-7, 1e-9, 1e-11}) {
            if (tolerance < method.tightest) continue;
            s.tolerance = tolerance, s.window = method.window, s.force_log = method.force_log;
            Barycenter b;
            Vector bar;
            const double forward = median_ms(o, [&] { b = solve_barycenter(kernel, densities, weights, s); });
            const double pullback =
                median_ms(o, [&] { bar = barycenter_pullback(kernel, densities, b, p_bar.data(), s); });
            double error = 0, size = 0;
            for (std::size_t i = 0; i < bar.size(); ++i)
                error += std::pow(bar[i] - exact[i], 2), size += exact[i] * exact[i];
            const int iterations = b.iterations + b.linear_iterations;
            std::printf(
                "%2d bases  sigma %.2g  %-11s tolerance %.0e  %d threads: %5d iterations, forward %8.1f ms, "
                "pullback %8.1f ms, marginal error %.1e, vertex IoU %.3f, gradient error %.1e, peak %.0f MiB\n",
                count, sigma, method.name, tolerance, o.threads, iterations, forward, pullback, b.marginal_error, iou,
                std::sqrt(error / size), peak_mib());
            std::fflush(stdout);
            if (csv)
                std::fprintf(csv, "%d,%dx%dx%d,%g,%s,%g,%d,%d,%.3f,%.3f,%.3e,%.4f,%.3e,%.1f\n", count, o.grid[0],
                             o.grid[1], o.grid[2], sigma, method.name, tolerance, o.threads, iterations, forward,
                             pullback, b.marginal_error, iou, std::sqrt(error / size), peak_mib());
            if (forward > 1e3 * o.budget) break;
        }
}

}  // namespace

int main(int argc, char** argv) {
    const Options o = parse(argc, argv);
    std::FILE* csv = nullptr;
    if (!o.csv.empty()) {
        csv = std::fopen(o.csv.c_str(), "w");
        if (!csv) usage("cannot write the CSV file");
        std::fprintf(csv,
                     "bases,grid,sigma,method,tolerance,threads,iterations,forward_ms,pullback_ms,marginal_error,"
                     "vertex_iou,gradient_error,peak_mib\n");
    }
    try {
        for (const int count : {2, 12})
            for (const double sigma : o.sigma > 0 ? Vector{o.sigma} : Vector{0.3, 0.4, 0.5, 0.7, 1.0, 1.5})
                measure(o, count, sigma, csv);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "bench_barycenter: %s\n", e.what());
        return 1;
    }
    if (csv && std::fclose(csv) != 0) usage("cannot write the CSV file");
    return 0;
}
