// SPDX-License-Identifier: MIT
// Where the library gives the right answer, where it says that it has none, and whether it is ever wrong in silence;
// beside it a textbook method (`reference`).
//
//   stability_map [--csv FILE [--resume]] [--threads N] [--quick] [--only AXIS] [--method NAME]
//                 [--failures] [--slowest]
//
// Every cell of the map is a rollout of four steps, muscles at full stroke and switching sides, held against an
// independent solve of the same equations to 1e-12 and the gradient by its adjoint: see trial.hpp; those of the axes
// sigma and separation are barycentres (barycenter_trial.hpp), and rollout_steps is a long rollout (long_rollout.hpp).
// inverted_cells counts Gauss points inside out at the end of a step. A reason that ends in `(solvable)` stands for a
// failure where the oracle did find an equilibrium.
// --threads: cells that are worked on at the same time, each on one thread. --resume keeps the rows that FILE has and
// works on the others; `rescued` counts those alone. Fails if an answer of the library is wrong in silence, or if fewer
// than nine in ten of the cells that the oracle solves are accurate.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <map>
#include <mutex>
#include <numeric>
#include <thread>

#include "../long_rollout.hpp"
#include "../scenes.hpp"
#include "grid/file.hpp"

namespace {

using namespace stability;

constexpr char kHeader[] =
    "axis_x,value_x,axis_y,value_y,method,outcome,steps_done,residual,state_error,gradient_error,inverted_cells,"
    "max_speed,reason\n";

constexpr char kSolvable[] = " (solvable)";

struct Row {
    std::string axis_x, axis_y, method;
    double value_x = 0.0, value_y = 0.0;
    double work = 0.0;  // guessed, to begin with the longest
    std::function<Result()> run;
    Result result;
    double seconds = 0.0;  // of processor
    bool done = false;     // the result is there, of this run or read from the file of an earlier one

    bool of_library() const { return method.rfind("reference", 0) != 0; }
    std::string reason() const {
        return result.outcome == Outcome::reported && result.solvable ? result.reason + kSolvable : result.reason;
    }
};

std::vector<Row> rows_of(bool quick) {
    std::vector<Row> rows;
    for (const Trial& t : mechanics(quick)) {
        Row row{t.axis_x, t.axis_y, t.method(), t.value_x, t.value_y, 0.0, [t] { return run(t); }, {}};
        const double cells = t.scene.threshold == 0.0 || t.reference ? 4.0 : 1.0;
        const double torn = std::sqrt(std::max(1.0, 1e6 / t.scene.young_modulus));  // by its muscles
        row.work = cells * torn * t.steps * (t.reference ? 10.0 : 1.0) * std::max(0.03, t.scene.time_step);
        rows.push_back(std::move(row));
    }
    for (const BarycenterTrial& t : barycenters(quick))
        rows.push_back({"sigma",
                        "separation",
                        t.reference ? "reference" : "newton",
                        t.sigma,
                        t.separation,
                        0.0,
                        [t] { return run(t); },
                        {}});
    for (const bool bdf2 : {false, true}) {
        LongRollout t;
        if (bdf2) t.integrator = dqa::Integrator::bdf2;
        if (quick) t.steps /= 10;
        rows.push_back({"rollout_steps",
                        "none",
                        bdf2 ? "newton_pcg/bdf2" : "newton_pcg",
                        1.0 * t.steps,
                        0.0,
                        1e3,
                        [t] { return run(t); },
                        {}});
    }
    return rows;
}

struct Count {
    int cells = 0, accurate = 0, reported = 0, silent = 0, nan = 0, solvable = 0, solved = 0, rescued = 0;
    void add(const Result& r) {
        ++cells;
        accurate += r.outcome == Outcome::accurate, reported += r.outcome == Outcome::reported;
        silent += r.outcome == Outcome::silent, nan += r.outcome == Outcome::nan;
        solvable += r.solvable, solved += r.solvable && r.outcome == Outcome::accurate;
        rescued += r.rescued > 0;
    }
    double share() const { return solvable ? 100.0 * solved / solvable : 100.0; }
    void print(const char* name) const {
        std::printf("%-56s %5d %9d %9d %7d %5d %14.1f %% %8d\n", name, cells, accurate, reported, silent, nan, share(),
                    rescued);
    }
};

int usage(const char* why) {
    std::fprintf(
        stderr,
        "stability_map: %s\nusage: stability_map [--csv FILE [--resume]] [--threads N] [--quick] [--only AXIS] "
        "[--method NAME] [--failures] [--slowest]\n",
        why);
    return 2;
}

std::string key_of(const Row& row) {
    return dqa::format("%s,%g,%s,%g,%s,", row.axis_x.c_str(), row.value_x, row.axis_y.c_str(), row.value_y,
                       row.method.c_str());
}

std::string line_of(const Row& row) {
    const Result& r = row.result;
    return key_of(row) +
           dqa::format("%s,%d,%.3e,%.3e,%.3e,%d,%.4g,", name_of(r.outcome), r.steps_done, r.residual, r.state_error,
                       r.gradient_error, r.inverted, r.max_speed) +
           row.reason() + "\n";
}

// What line_of has after the key; a line that was cut short is none.
bool read_result(const std::string& text, Result& r) {
    char outcome[16] = "";
    int at = 0;
    if (std::sscanf(text.c_str(), "%15[a-z],%d,%lf,%lf,%lf,%d,%lf,%n", outcome, &r.steps_done, &r.residual,
                    &r.state_error, &r.gradient_error, &r.inverted, &r.max_speed, &at) != 7 ||
        at == 0)
        return false;
    for (const Outcome o : {Outcome::accurate, Outcome::reported, Outcome::silent, Outcome::nan})
        if (!std::strcmp(outcome, name_of(o))) r.outcome = o;
    r.reason = text.substr(static_cast<std::size_t>(at));
    const bool marked = r.reason.ends_with(kSolvable);
    if (marked) r.reason.resize(r.reason.size() - std::strlen(kSolvable));
    r.solvable = marked || r.outcome != Outcome::reported;
    return true;
}

void resume(std::vector<Row>& rows, const char* path) {
    std::ifstream file(path);
    std::map<std::string, Row*> by_key;
    for (Row& row : rows) by_key[key_of(row)] = &row;
    int kept = 0;
    for (std::string line; std::getline(file, line) && !file.eof();) {
        std::size_t end = 0;  // of the key: behind its fifth comma
        for (int k = 0; k < 5 && end != std::string::npos; ++k) end = line.find(',', end + (k > 0));
        if (end == std::string::npos) continue;
        const auto found = by_key.find(line.substr(0, end + 1));
        if (found == by_key.end()) continue;
        found->second->done = read_result(line.substr(end + 1), found->second->result);
        kept += found->second->done;
    }
    std::printf("%d of %zu rows are in %s\n", kept, rows.size(), path);
}

void print_failure(const Row& row) {
    std::printf("%s %g, %s %g, %s: %s after %d steps: %s [state %.1e, %.0f s]\n", row.axis_x.c_str(), row.value_x,
                row.axis_y.c_str(), row.value_y, row.method.c_str(), name_of(row.result.outcome), row.result.steps_done,
                row.reason().c_str(), row.result.state_error, row.seconds);
    std::fflush(stdout);
}

// Whether the rows that are there could be written, in order.
bool save(const std::vector<Row>& rows, const char* path) {
    std::string text = kHeader;
    for (const Row& row : rows)
        if (row.done) text += line_of(row);
    try {
        dqa::write_atomically(path, text);
        return true;
    } catch (const dqa::Error& e) {
        std::fprintf(stderr, "stability_map: %s\n", e.what());
        return false;
    }
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Of the calling thread, which other work on the machine disturbs less than the wall clock.
double processor_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Longest first, so that none is left over at the end; the file gets every row as it is done.
void run_all(std::vector<Row>& rows, int threads, const char* csv_path, bool failures) {
    std::vector<std::size_t> order(rows.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return rows[a].work > rows[b].work; });
    std::atomic<std::size_t> next{0};
    std::mutex mutex;
    const auto work = [&] {
        for (std::size_t k = next++; k < rows.size(); k = next++) {
            Row& row = rows[order[k]];
            if (row.done) continue;
            const double begin = processor_seconds();
            const Result result = row.run();
            const double seconds = processor_seconds() - begin;
            const std::lock_guard lock(mutex);
            row.result = result, row.seconds = seconds, row.done = true;
            if (failures && result.outcome != Outcome::accurate) print_failure(row);
            if (csv_path) save(rows, csv_path);
        }
    };
    std::vector<std::thread> helpers;
    for (int k = 1; k < threads; ++k) helpers.emplace_back(work);
    work();
    for (std::thread& helper : helpers) helper.join();
}

}  // namespace

int main(int argc, char** argv) {
    bool quick = false, failures = false, slowest = false, resumed = false;
    int threads = 1;
    const char *csv_path = nullptr, *only = nullptr, *method = nullptr;
    for (int k = 1; k < argc; ++k) {
        const char* value = k + 1 < argc ? argv[k + 1] : nullptr;
        if (!std::strcmp(argv[k], "--quick")) {
            quick = true;
        } else if (!std::strcmp(argv[k], "--failures")) {
            failures = true;
        } else if (!std::strcmp(argv[k], "--resume")) {
            resumed = true;
        } else if (!std::strcmp(argv[k], "--slowest")) {
            slowest = true;
        } else if (value && !std::strcmp(argv[k], "--csv")) {
            csv_path = value, ++k;
        } else if (value && !std::strcmp(argv[k], "--only")) {
            only = value, ++k;
        } else if (value && !std::strcmp(argv[k], "--method")) {
            method = value, ++k;
        } else if (value && !std::strcmp(argv[k], "--threads")) {
            threads = std::atoi(value), ++k;
            if (threads < 1 || threads > 256) return usage("--threads takes a whole number in [1, 256]");
        } else {
            return usage("unknown option, or one without its value");
        }
    }
    std::vector<Row> rows = rows_of(quick);
    std::erase_if(rows, [&](const Row& r) { return (only && r.axis_x != only) || (method && r.method != method); });
    if (rows.empty()) return usage("no cell has this axis and method");
    if (resumed && !csv_path) return usage("--resume needs --csv");
    if (resumed) resume(rows, csv_path);
    if (csv_path && !save(rows, csv_path)) return 2;
    const auto begin = std::chrono::steady_clock::now();
    run_all(rows, threads, csv_path, failures);
    if (csv_path && !save(rows, csv_path)) return 2;  // now none may be missing
    std::map<std::string, Count> counts;
    Count ours, textbook;
    for (const Row& row : rows) {
        counts[row.axis_x + ", " + row.axis_y + ": " + row.method].add(row.result);
        (row.of_library() ? ours : textbook).add(row.result);
    }
    std::printf("%-56s %5s %9s %9s %7s %5s %16s %8s\n", "axes: method", "cells", "accurate", "reported", "silent",
                "nan", "of the solvable", "rescued");
    for (const auto& [name, count] : counts) count.print(name.c_str());
    if (textbook.cells) textbook.print("all of the reference");
    ours.print("all of the library");
    if (slowest) {
        std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.seconds > b.seconds; });
        for (std::size_t k = 0; k < std::min<std::size_t>(rows.size(), 20); ++k)
            std::printf("%7.1f s  %s %g, %s %g, %s\n", rows[k].seconds, rows[k].axis_x.c_str(), rows[k].value_x,
                        rows[k].axis_y.c_str(), rows[k].value_y, rows[k].method.c_str());
    }
    std::printf("%.1f s on %d threads; processor seconds of all cells %.1f\n", seconds_since(begin), threads,
                std::accumulate(rows.begin(), rows.end(), 0.0, [](double s, const Row& r) { return s + r.seconds; }));
    if (ours.silent + ours.nan > 0) std::printf("FAILED: the library is wrong in silence\n");
    if (ours.share() < 90.0)
        std::printf("FAILED: the library solves only %.1f %% of what can be solved\n", ours.share());
    return ours.silent + ours.nan > 0 || ours.share() < 90.0;
}
