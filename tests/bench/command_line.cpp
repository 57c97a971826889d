// SPDX-License-Identifier: MIT
#include "command_line.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdlib>
#include <utility>

namespace bench {

std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> out;
    std::size_t from = 0;
    for (std::size_t to = 0; to != std::string::npos; from = to + 1)
        to = text.find(',', from), out.push_back(text.substr(from, to - from));
    return out;
}

Vector numbers(const std::string& text, const char* option) {
    Vector out;
    for (const std::string& part : split(text)) {
        char* end = nullptr;
        out.push_back(std::strtod(part.c_str(), &end));
        if (part.empty() || *end != '\0' || !std::isfinite(out.back()))
            throw UsageError(std::string(option) + " takes numbers with commas between them, not '" + text + "'");
    }
    return out;
}

std::array<int, 3> grid_of(const std::string& text) {
    std::array<int, 3> g{};
    if (std::sscanf(text.c_str(), "%dx%dx%d", &g[0], &g[1], &g[2]) != 3)
        throw UsageError("a grid is NXxNYxNZ, not '" + text + "'");
    return g;
}

void Options::flag(const std::string& name, std::function<void()> set) {
    options_[name] = {false, [set = std::move(set)](const std::string&) { set(); }};
}

void Options::flag(const std::string& name, bool& to) {
    flag(name, [&to] { to = true; });
}

void Options::value(const std::string& name, std::function<void(const std::string&)> take) {
    options_[name] = {true, std::move(take)};
}

void Options::text(const std::string& name, std::string& to) {
    value(name, [&to](const std::string& given) { to = given; });
}

void Options::list(const std::string& name, std::vector<std::string>& to) {
    value(name, [&to](const std::string& given) { to = split(given); });
}

void Options::list(const std::string& name, Vector& to) {
    value(name, [name, &to](const std::string& given) { to = numbers(given, name.c_str()); });
}

void Options::positive(const std::string& name, double& to) {
    value(name, [name, &to](const std::string& given) {
        const Vector v = numbers(given, name.c_str());
        if (v.size() != 1 || !(v[0] > 0)) throw UsageError(name + " takes a number > 0");
        to = v[0];
    });
}

void Options::whole(const std::string& name, int& to) {
    value(name, [name, &to](const std::string& given) {
        const Vector v = numbers(given, name.c_str());
        if (v.size() != 1 || v[0] < 1 || v[0] > 1000 || v[0] != std::floor(v[0]))
            throw UsageError(name + " takes a whole number in [1, 1000]");
        to = static_cast<int>(v[0]);
    });
}

void Options::parse(int argc, char** argv) const {
    for (int k = 1; k < argc; ++k) {
        const std::string name = argv[k];
        const auto found = options_.find(name);
        if (found == options_.end()) throw UsageError("unknown option " + name);
        if (found->second.has_value && ++k >= argc) throw UsageError(name + " needs a value");
        found->second.take(found->second.has_value ? argv[k] : "");
    }
}

void SceneRuns::add_to(Options& options) {
    if (const char* folder = std::getenv("DQA_TEST_DATA")) data = folder;
    options.text("--csv", csv);
    options.text("--data", data);
    options.list("--scenes", scenes);
    options.list("--threads", threads);
    options.value("--grid", [this](const std::string& given) { grid = grid_of(given); });
    options.whole("--repeat", repeat);
    options.positive("--budget", budget);
    options.flag("--reference", reference);
}

int run_program(const char* name, const std::function<void()>& work) {
    try {
        work();
        return 0;
    } catch (const UsageError& e) {
        std::fprintf(stderr, "%s: %s; the first lines of %s.cpp list the options\n", name, e.what(), name);
        return 2;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s: %s\n", name, e.what());
        return 1;
    }
}

Csv::Csv(const std::string& path, const char* header) {
    if (path.empty()) return;
    file_ = std::fopen(path.c_str(), "w");
    if (!file_) throw UsageError("cannot write " + path);
    row("%s\n", header);
}

Csv::~Csv() {
    if (file_) std::fclose(file_);
}

void Csv::row(const char* pattern, ...) {
    if (!file_) return;
    va_list args;
    va_start(args, pattern);
    const int written = std::vfprintf(file_, pattern, args);
    va_end(args);
    if (written < 0 || std::fflush(file_) != 0) throw std::runtime_error("the CSV file could not be written");
}

}  // namespace bench
