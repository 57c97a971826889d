// SPDX-License-Identifier: MIT
// Where the library gives the right answer, where it says that it has none, and whether it is ever wrong in silence.
//
//   stability_map [--csv FILE] [--threads N] [--quick] [--only AXIS] [--failures]
//
// Every cell of the map is a rollout of four steps, muscles at full stroke and switching sides, held against an
// independent solve of the same equations to 1e-12 and the gradient by its adjoint: see trial.hpp. inverted_cells
// counts Gauss points inside out at the end of a step. A reason that ends in `(solvable)` stands for a failure where
// the oracle did find an equilibrium.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>

#include "../scenes.hpp"

namespace {

using namespace stability;

struct Count {
    int cells = 0, accurate = 0, reported = 0, silent = 0, nan = 0, solvable = 0, solved = 0, rescued = 0;
    void add(const Result& r) {
        ++cells;
        accurate += r.outcome == Outcome::accurate, reported += r.outcome == Outcome::reported;
        silent += r.outcome == Outcome::silent, nan += r.outcome == Outcome::nan;
        solvable += r.solvable, solved += r.solvable && r.outcome == Outcome::accurate;
        rescued += r.rescued > 0;
    }
    void print(const char* name) const {
        std::printf("%-48s %5d %9d %9d %7d %5d %14.1f %% %8d\n", name, cells, accurate, reported, silent, nan,
                    solvable ? 100.0 * solved / solvable : 100.0, rescued);
    }
};

int usage(const char* why) {
    std::fprintf(stderr,
                 "stability_map: %s\nusage: stability_map [--csv FILE] [--threads N] [--quick] [--only AXIS] "
                 "[--failures]\n",
                 why);
    return 2;
}

}  // namespace

int main(int argc, char** argv) {
    bool quick = false, failures = false;
    int threads = 1;
    const char *csv_path = nullptr, *only = nullptr;
    for (int k = 1; k < argc; ++k) {
        const char* value = k + 1 < argc ? argv[k + 1] : nullptr;
        if (!std::strcmp(argv[k], "--quick")) {
            quick = true;
        } else if (!std::strcmp(argv[k], "--failures")) {
            failures = true;
        } else if (value && !std::strcmp(argv[k], "--csv")) {
            csv_path = value, ++k;
        } else if (value && !std::strcmp(argv[k], "--only")) {
            only = value, ++k;
        } else if (value && !std::strcmp(argv[k], "--threads")) {
            threads = std::atoi(value), ++k;
            if (threads < 1) return usage("--threads must be at least 1");
        } else {
            return usage("unknown option, or one without its value");
        }
    }
    std::FILE* csv = csv_path ? std::fopen(csv_path, "w") : nullptr;
    if (csv_path && !csv) return usage("cannot write the CSV file");
    if (csv)
        std::fprintf(csv,
                     "axis_x,value_x,axis_y,value_y,method,outcome,steps_done,residual,state_error,gradient_error,"
                     "inverted_cells,max_speed,reason\n");
    std::map<std::string, Count> counts;
    Count all;
    const auto begin = std::chrono::steady_clock::now();
    for (Trial& trial : mechanics(quick)) {
        if (only && trial.axis_x != only) continue;
        trial.scene.threads = threads;
        const Result r = run(trial);
        std::string reason = r.reason;
        if (r.outcome == Outcome::reported && r.solvable) reason += " (solvable)";
        counts[trial.axis_x + ", " + trial.axis_y + ": " + trial.method()].add(r);
        all.add(r);
        if (csv)
            std::fprintf(csv, "%s,%g,%s,%g,%s,%s,%d,%.3e,%.3e,%.3e,%d,%.4g,%s\n", trial.axis_x.c_str(), trial.value_x,
                         trial.axis_y.c_str(), trial.value_y, trial.method().c_str(), name_of(r.outcome), r.steps_done,
                         r.residual, r.state_error, r.gradient_error, r.inverted, r.max_speed, reason.c_str());
        if (csv) std::fflush(csv);
        if (failures && r.outcome != Outcome::accurate)
            std::printf("%s %g, %s %g, %s: %s after %d steps: %s [state %.1e]\n", trial.axis_x.c_str(), trial.value_x,
                        trial.axis_y.c_str(), trial.value_y, trial.method().c_str(), name_of(r.outcome), r.steps_done,
                        reason.c_str(), r.state_error);
        std::fflush(stdout);
    }
    std::printf("%-48s %5s %9s %9s %7s %5s %16s %8s\n", "axes: method", "cells", "accurate", "reported", "silent",
                "nan", "of the solvable", "rescued");
    for (const auto& [name, count] : counts) count.print(name.c_str());
    all.print("all");
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::printf("%.1f s\n", seconds);
    if (csv && std::fclose(csv) != 0) return usage("cannot write the CSV file");
    return all.silent + all.nan > 0;
}
