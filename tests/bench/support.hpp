// SPDX-License-Identifier: MIT
// Shared by the benchmarks: scenes, runs in a process of their own, statistics, errors.
//
// Every configuration runs in a child process, so that its peak memory is its own. Shape spaces are built once, in a
// child too, and handed on as files.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "command_line.hpp"
#include "diffaqua.h"

namespace bench {

// Throws what dqa_last_error says.
void check(dqa_status status, const char* what);

double milliseconds();  // since some time in the past
// Of a non-empty list.
struct Spread {
    double median = 0.0, least = 0.0, largest = 0.0;
};
Spread spread_of(Vector values);

// Runs `work` in a child process and brings back its numbers and its peak memory. A failure there is an exception here.
struct ChildResult {
    std::vector<Vector> values;
    double peak_mib = 0.0;
};
ChildResult in_child(const std::function<std::vector<Vector>()>& work);

// ---------------------------------------------------------------- scenes

struct Scene {
    std::string name;
    std::array<int, 3> grid{};
    std::string file;  // the built shape space
    int n_bases = 0;
    std::string grid_text() const;
};

// eel: the shipped eels, 40x8x8. shipped: clownfish and tuna, 60x16x26. orca_shark: Orca.stl and GreatWhiteShark.stl of
// `data`, 60x16x26. three: three generated rays with muscles in tail and wings, 60x54x14. Weights are equal. Another
// grid if grid[0] > 0; refine = 2 halves the cells and keeps everything else as it is in metres; sigma is the width of
// the kernel in cells. No value, and a message, where meshes are absent.
std::optional<Scene> open_scene(const std::string& name, const std::string& data, const std::array<int, 3>& grid = {},
                                int refine = 1, double sigma = 0.4);
// The scene in two dimensions: the plane through the middle of each base, with the same caudal muscles. No value for
// bases with other muscles, which a plane does not have.
std::optional<Scene> middle_plane(const Scene& scene, double sigma = 0.4);

// ---------------------------------------------------------------- runs

constexpr const char* kMethods[] = {"newton_pcg", "newton_direct", "projective", "reference"};
constexpr int kReferenceMethod = 3;
constexpr const char* kIntegrators[] = {"euler", "bdf2"};
constexpr const char* kQuadratures[] = {"full", "reduced"};  // the reference has full
constexpr const char* kPrecisions[] = {"single", "double"};  // of linear iterations
constexpr const char* kModels[] = {"full", "planar", "plane", "no_water"};

struct Setup {
    int method = 0, integrator = 0, material = 0, quadrature = 1, precision = 0, threads = 1;
    double threshold = 0.02, tolerance = 1e-6, adjoint_tolerance = 0.0;
    double time_step = 1.0 / 30.0;
    int steps = 5, repeat = 5;
    bool planar = false, water = true;
    double budget = 60.0;   // s, after which no further repetition starts
    double checkpoint = 0;  // bytes of the tape; 0: no limit
};

// What a rollout and its backward sweep gave; the objective is the distance travelled.
struct Outcome {
    double active_cells = 0.0, setup_ms = 0.0, newton = 0.0, linear = 0.0, adjoint = 0.0;  // iterations a step
    double residual = 0.0, loss = 0.0, tape_mib = 0.0, peak_mib = 0.0;
    Vector forward, backward,
        pullback;                // ms of a rollout, its sweep, the way from there to the weights: one a repetition
    Vector node, q, rest, mass;  // of the last state; index in the full box of each node; mass of occupancy 1
    Vector weights_bar, actuation_bar;  // gradient; weights_bar is empty of the reference
    Vector amplitude_bar;               // gradient by a factor on each signal
};

// Actuation of a signal at a time (s): the paper's sine of twelve steps at h = 1/30, led in over 0.1 s. A step takes it
// at its end, where implicit integrators take their forces.
double actuation(double time, int signal);

// In a child process.
Outcome run(const Scene& scene, const Setup& setup);
// What a plane gave, as nodes in the middle of `scene`, which do not move across it.
Outcome in_the_middle(Outcome plane, const Scene& scene);

// Displacements weighted by mass, |u - u_exact| / |u_exact|, over the nodes of `got`, which are among those of `exact`.
// fine = 2: `exact` has cells of half the size.
double state_error(const Outcome& got, const Outcome& exact, const Scene& scene, int fine = 1);
// The larger of the errors by weights, where the method has them, and by actuation: each |g - g_exact| over |g_exact|,
// or over a tenth of the norm of both together where that is larger, so that a part that nearly vanishes does not
// decide. Rollouts of other time steps are compared in the gradient by each signal's amplitude.
enum class Actuations { each, amplitudes };
double gradient_error(const Outcome& got, const Outcome& exact, Actuations actuations = Actuations::each);

}  // namespace bench
