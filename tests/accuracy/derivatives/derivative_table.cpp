// SPDX-License-Identifier: MIT
// Every derivative of the library, stage by stage and for the whole chain, against finite differences: prints a table
// and fails if a row does.
//   derivative_table                 measures and prints all rows
//   derivative_table --only TEXT     of the stages with this in their names alone
//   derivative_table --markdown      all, as the page tests/accuracy/derivatives.md
//   derivative_table --compare FILE  whether that page has the rows of this program; measures nothing
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>

#include "table.hpp"

namespace {

using table::Row;
using table::Table;

constexpr const char* kHeading = R"(# Every derivative, measured

Written by `build/default/tests/derivative_table --markdown`; the test of the same name measures it again. Figures
differ a little between machines, rows do not.

Stages: *f* at *x*, a direction *d* (random, with a part along the gradient), random covectors *w*.

- **Taylor slope**: of |⟨w, f(x + e d) − f(x)⟩ − e ⟨pullback(w), d⟩| over *e*, at the smallest steps whose remainder
  stands above the rounding of *f*. It must be 2 ± 0.1. `linear`: *f* is linear in the parameter, and its remainder was
  found to be rounding.
- **Differences**: |⟨pullback(w), d⟩ − D| / |D|, *D* the five-point difference of ⟨w, f⟩ along *d*; at most 1e-6.
- **Dot product**: |⟨pullback(w'), d⟩ − ⟨w', J d⟩| / (|pullback(w')| |d|), the larger one of two further covectors *w'*;
  *J d* is the five-point difference of all of *f* or, where the note says so, the stage's own product with its
  Jacobian; at most 1e-6.
- Steps of differences: where two neighbours of a ladder agree best. The derivative under test has no say in it.

The whole chain: `check_gradient` over ten steps of a swimmer in motion in a current that changes over time, force
residual 1e-13. *f* are the five objectives (travel, position keeping, efficiency, effort, path), *w* random weights of
theirs: slope and differences for one sum, dot product the larger relative error of that and of a second sum along a
second direction. "closed loop": the controller is a perceptron that reads the sensors. Weights at a vertex of the
simplex, and at one of its edges, are differenced into it, on one side. The neo-Hookean material moves more gently, since
its almost empty cells would turn inside out: in 3-D cells above a density of 0.3 alone and Poisson's ratio 0.3 instead
of 0.02 and 0.45, in 2-D half the time step and a contraction of 0.08 instead of 0.2.

Not in the table, with the reason: λ of the paper's corotated energy, which has no λ; forces by new positions of
`explicit` water, which do not depend on them; places where a law has no derivative (ties of a hard maximum, a face of
`windward` water at Φ = 0, a cell at the point of turning inside out).


)";

void print(const std::vector<Row>& rows) {
    std::puts("| stage | parameter | Taylor slope | differences | dot product | note |");
    std::puts("|---|---|---|---|---|---|");
    for (const Row& r : rows) {
        char slope[32] = "linear";
        if (!r.linear || r.slope != 0.0) std::snprintf(slope, sizeof(slope), "%.3f", r.slope);
        std::printf("| %s | %s | %s | %.0e | %.0e | %s |\n", r.stage.c_str(), r.parameter.c_str(), slope, r.differences,
                    r.dot_product, r.note.c_str());
    }
}

std::string name(const Row& r) {
    return "| " + r.stage + " | " + r.parameter + " |";
}

int compare(const std::vector<Row>& rows, const char* path) {
    std::ifstream file(path);
    if (!file) return std::fprintf(stderr, "%s: cannot be read\n", path), 1;
    std::vector<std::string> lines;
    int headings = 2;  // lines of a table that are not rows of it
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("|") && headings-- <= 0) lines.push_back(line);
    for (std::size_t k = 0; k < std::max(lines.size(), rows.size()); ++k) {
        const std::string expected = k < rows.size() ? name(rows[k]) : "no further row";
        if (k < lines.size() && lines[k].starts_with(expected)) continue;
        std::fprintf(stderr, "%s, row %zu: expected '%s', got '%s'; write it again with --markdown\n", path, k + 1,
                     expected.c_str(), k < lines.size() ? lines[k].c_str() : "the end");
        return 1;
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    const bool markdown = argc == 2 && std::strcmp(argv[1], "--markdown") == 0;
    const bool comparing = argc == 3 && std::strcmp(argv[1], "--compare") == 0;
    const bool part = argc == 3 && std::strcmp(argv[1], "--only") == 0;
    if (argc > 1 && !markdown && !comparing && !part)
        return std::fprintf(stderr, "usage: derivative_table [--only TEXT | --markdown | --compare FILE]\n"), 2;
    try {
        Table t(comparing, part ? argv[2] : "");
        for (const auto rows : {table::shape_rows, table::muscle_rows, table::body_rows, table::water_rows,
                                table::step_rows, table::sensor_rows, table::controller_rows, table::objective_rows,
                                table::chain_rows, table::reduced_body_rows})
            rows(t);
        if (comparing) return compare(t.rows(), argv[2]);
        if (markdown) std::fputs(kHeading, stdout);
        print(t.rows());
        int failures = 0;
        for (const Row& r : t.rows())
            if (!r.passed()) std::fprintf(stderr, "failed: %s, %s\n", r.stage.c_str(), r.parameter.c_str()), ++failures;
        return failures > 0;
    } catch (const std::exception& e) {
        return std::fprintf(stderr, "%s\n", e.what()), 1;
    }
}
