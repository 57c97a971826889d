// SPDX-License-Identifier: MIT
// Command lines, CSV files and the end of the benchmarks' main programs.
#pragma once

#include <array>
#include <cstdio>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace bench {

using Vector = std::vector<double>;

struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

std::vector<std::string> split(const std::string& text);  // at commas
Vector numbers(const std::string& text, const char* option);
std::array<int, 3> grid_of(const std::string& text);

// Index of a name among those there are to choose from.
template <std::size_t n>
int place(const char* const (&names)[n], const std::string& name) {
    for (std::size_t k = 0; k < n; ++k)
        if (name == names[k]) return static_cast<int>(k);
    throw UsageError("there is no '" + name + "' to choose");
}

// What the options of a program do, by their names.
class Options {
public:
    void flag(const std::string& name, std::function<void()> set);
    void flag(const std::string& name, bool& to);
    void value(const std::string& name, std::function<void(const std::string&)> take);
    void text(const std::string& name, std::string& to);
    void list(const std::string& name, std::vector<std::string>& to);
    void list(const std::string& name, Vector& to);
    void positive(const std::string& name, double& to);  // a number > 0
    void whole(const std::string& name, int& to);        // a whole number in [1, 1000]
    void parse(int argc, char** argv) const;             // throws UsageError

private:
    struct Option {
        bool has_value = false;
        std::function<void(const std::string&)> take;
    };
    std::map<std::string, Option> options_;
};

// Settings that the programs which run scenes share, with their options.
struct SceneRuns {
    std::string csv, data;  // data: DQA_TEST_DATA if not given
    std::vector<std::string> scenes;
    Vector threads{1.0};
    std::array<int, 3> grid{};
    int repeat = 3;
    double budget = 20.0;
    bool quick = false, reference = false;

    void add_to(Options& options);
};

// work() and what its exceptions end the program with: 2 after a wrong command line, 1 after everything else.
int run_program(const char* name, const std::function<void()>& work);

// CSV file, or nothing where the path is empty; every row is flushed, and a failed write throws.
class Csv {
public:
    Csv(const std::string& path, const char* header);
    ~Csv();
    Csv(const Csv&) = delete;
    Csv& operator=(const Csv&) = delete;
    void row(const char* pattern, ...) __attribute__((format(printf, 2, 3)));

private:
    std::FILE* file_ = nullptr;
};

}  // namespace bench
