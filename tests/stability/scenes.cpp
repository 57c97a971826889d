// SPDX-License-Identifier: MIT
#include "scenes.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "grid/random.hpp"

namespace stability {
namespace {

using dqa::Design;
using dqa::Integrator;
using dqa::Material;
using dqa::Method;
using dqa::ShapeSpace;
using dqa::Vec3;

constexpr double kCell = 0.05;  // m

using Inside = std::function<bool(const Vec3&)>;  // of a place in cells from the box's centre

Vector fractions(const std::array<int, 3>& cells, const Inside& inside) {
    const dqa::Box box{cells, 1.0};
    constexpr int n = 4;
    Vector f(static_cast<std::size_t>(box.n_cells()), 0.0);
    for (int c = 0; c < box.n_cells(); ++c) {
        const Vec3 centre = box.cell_centre(c);
        for (int s = 0; s < n * n * n; ++s) {
            Vec3 x = centre;
            const int at[3] = {s / (n * n), s / n % n, s % n};
            for (std::size_t a = 0; a < 3; ++a) x[a] += (at[a] + 0.5) / n - 0.5;
            f[static_cast<std::size_t>(c)] += inside(x) ? 1.0 / (n * n * n) : 0.0;
        }
    }
    return f;
}

Inside ellipsoid(const Vec3& radius, const Vec3& centre = {}) {
    return [=](const Vec3& x) {
        double r2 = 0.0;
        for (std::size_t a = 0; a < 3; ++a) r2 += (x[a] - centre[a]) * (x[a] - centre[a]) / (radius[a] * radius[a]);
        return r2 < 1.0;
    };
}

Inside brick(const Vec3& low, const Vec3& high) {
    return [=](const Vec3& x) {
        for (std::size_t a = 0; a < 3; ++a)
            if (x[a] < low[a] || x[a] > high[a]) return false;
        return true;
    };
}

Inside either(const Inside& a, const Inside& b) {
    return [=](const Vec3& x) { return a(x) || b(x); };
}

// A caudal muscle over the rear half of what lies between `tail` and `head` along x, `across` wide (cells).
dqa::Actuator rear_muscle(double tail, double head, double across) {
    dqa::Actuator a;
    const double half = 0.25 * (head - tail);
    a.mean = {(tail + half) * kCell, 0.0, 0.0};
    const Vec3 size{half * kCell, across * kCell, across * kCell};
    for (std::size_t k = 0; k < 3; ++k) a.variance[k] = size[k] * size[k] / dqa::kTwoLn2;
    return a;
}

struct Base {
    Inside inside;
    double tail, head, across;
};

std::shared_ptr<const ShapeSpace> space_of(const std::array<int, 3>& cells, const std::vector<Base>& bases,
                                           double sigma = 0.5) {
    dqa::ShapeSettings s;
    s.dims = cells[2] == 1 ? 2 : 3;
    s.cells = cells;
    s.cell_size = kCell;
    s.sigma = sigma;
    auto space = std::make_shared<ShapeSpace>(s);
    for (const Base& b : bases) {
        const int base = space->add_fractions("base", fractions(cells, b.inside).data());
        space->add_actuator(base, rear_muscle(b.tail, b.head, b.across));
    }
    space->build(nullptr);
    return space;
}

// ---------------------------------------------------------------- initial states

using Start = std::function<void(const Design&, Vector&, Vector&)>;

// Every coordinate moved by up to so many cells.
Start shaken(double cells, std::uint64_t seed) {
    return [=](const Design& design, Vector& q, Vector&) {
        dqa::Random random{seed};
        for (double& x : q) x += cells * design.space().box().dx * random();
    };
}

// Along an axis times a factor: 0 flattens, -1 mirrors.
Start scaled(std::size_t axis, double factor) {
    return [=](const Design&, Vector& q, Vector&) {
        for (std::size_t i = axis; i < q.size(); i += 3) q[i] *= factor;
    };
}

Start point() {
    return [](const Design&, Vector& q, Vector&) { std::fill(q.begin(), q.end(), 0.0); };
}

// A random cell in eight turned inside out.
Start inverted_cells(std::uint64_t seed) {
    return [=](const Design& design, Vector& q, Vector&) {
        dqa::Random random{seed};
        const Vector rest(q);
        for (const auto& nodes : design.set().cell_nodes) {
            if (random() < 0.75) continue;
            for (std::size_t a = 0; a < 3; ++a) {
                double middle = 0.0;
                for (const int n : nodes) middle += rest[3 * static_cast<std::size_t>(n) + a] / 8.0;
                for (const int n : nodes) {
                    const std::size_t i = 3 * static_cast<std::size_t>(n) + a;
                    q[i] = 2.0 * middle - rest[i];
                }
            }
        }
    };
}

Start moving(const Vec3& speed) {
    return [=](const Design&, Vector&, Vector& v) {
        for (std::size_t i = 0; i < v.size(); ++i) v[i] = speed[i % 3];
    };
}

// ---------------------------------------------------------------- axes

struct Variant {
    const char* name;
    std::function<void(Trial&)> apply;
};

const Variant kDefault{"", [](Trial&) {}};
const Variant kDirect{"", [](Trial& t) { t.scene.method = Method::newton_direct; }};
const Variant kProjective{"", [](Trial& t) { t.scene.method = Method::projective; }};
const Variant kVolume{"volume", [](Trial& t) { t.scene.material = Material::corotated_volume; }};
const Variant kNeo{"neo-Hookean", [](Trial& t) { t.scene.material = Material::neo_hookean; }};
const Variant kBdf2{"bdf2", [](Trial& t) { t.scene.integrator = Integrator::bdf2; }};
const Variant kNeoBdf2{"neo-Hookean bdf2", [](Trial& t) {
                           t.scene.material = Material::neo_hookean;
                           t.scene.integrator = Integrator::bdf2;
                       }};
const Variant kPlane{"plane", [](Trial& t) { t.space = flat_space(); }};
const Variant kPlaneNeo{"plane neo-Hookean", [](Trial& t) {
                            t.space = flat_space();
                            t.scene.material = Material::neo_hookean;
                        }};
const Variant kPlaneDirect{"plane", [](Trial& t) {
                               t.space = flat_space();
                               t.scene.method = Method::newton_direct;
                           }};
const Variant kExplicit{"explicit water", [](Trial& t) { t.scene.hydrodynamics.explicit_forces = true; }};
const Variant kDouble{"double", [](Trial& t) { t.scene.precision = dqa::Precision::double_precision; }};
const Variant kFactor{"factor", [](Trial& t) { t.scene.preconditioner = dqa::PreconditionerKind::factor; }};
const Variant kFactorDouble{"factor double", [](Trial& t) {
                                t.scene.preconditioner = dqa::PreconditionerKind::factor;
                                t.scene.precision = dqa::Precision::double_precision;
                            }};
const Variant kReference{"", [](Trial& t) {
                             t.reference = true;
                             t.scene.quadrature = dqa::Quadrature::full;
                             t.scene.tolerance = t.scene.adjoint_tolerance = 1e-8;
                             t.scene.max_linear = 500;
                         }};
// As the examples of the paper run it.
const Variant kLoose{"tolerance 0.1", [](Trial& t) {
                         kReference.apply(t);
                         t.scene.tolerance = 1e-1, t.scene.adjoint_tolerance = 1e-3;
                     }};

using Set = std::function<void(Trial&, double)>;

class Map {
public:
    // Every pair of values under every variant.
    void plane(const char* x, const std::vector<double>& xs, const Set& set_x, const char* y,
               const std::vector<double>& ys, const Set& set_y, const std::vector<Variant>& variants) {
        for (const Variant& variant : variants)
            for (const double value_x : xs)
                for (const double value_y : ys) {
                    Trial t;
                    t.axis_x = x, t.axis_y = y, t.value_x = value_x, t.value_y = value_y;
                    t.variant = variant.name;
                    t.space = small_space();
                    variant.apply(t);
                    set_x(t, value_x);
                    set_y(t, value_y);
                    trials.push_back(std::move(t));
                }
    }
    void line(const char* x, const std::vector<double>& xs, const Set& set_x, const std::vector<Variant>& variants) {
        plane(
            x, xs, set_x, "none", {0.0}, [](Trial&, double) {}, variants);
    }

    std::vector<Trial> trials;
};

// The quick map: the ends of each axis, where methods fail, and what is harmless on the way to them. Muscles that tear
// at a soft body over a long step are most of the work, whoever solves it: these methods meet them, each material and
// integrator, solver and preconditioner among them, and the others at the ends of the axes beside that one.
bool is_corner(const Trial& t) {
    using Methods = std::vector<std::string_view>;
    struct Cell {
        std::string_view axis;
        double x, y;
        Methods methods;  // empty: all
    };
    static const Methods kTorn{"newton_pcg",
                               "newton_pcg/neo-Hookean",
                               "newton_pcg/neo-Hookean bdf2",
                               "newton_pcg/plane",
                               "newton_pcg/plane neo-Hookean",
                               "newton_direct/plane",
                               "newton_pcg/factor double",
                               "reference"};
    static const Methods kBeside{
        "newton_pcg/volume", "newton_pcg/bdf2",  "newton_pcg/neo-Hookean bdf2", "newton_direct", "pd",
        "newton_pcg/double", "newton_pcg/factor"};
    // Steps that once fell just below the tolerance, with positions a hundredfold of it off.
    static const Methods kLucky{"newton_pcg"};
    static const Methods kSolvers{"newton_direct", "pd", "newton_pcg/double", "newton_pcg/factor",
                                  "newton_pcg/factor double"};
    static const Methods kPoint{"newton_pcg", "newton_pcg/neo-Hookean"};  // no method begins; the oracle does
    static const Cell kCorners[] = {{"young_modulus", 1e4, 1.0 / 2, kTorn},
                                    {"young_modulus", 1e4, 1e-2, kBeside},
                                    {"young_modulus", 1e5, 1e-2, kLucky},
                                    {"young_modulus", 1e8, 1.0 / 2, kSolvers},
                                    {"young_modulus", 1e9, 1.0 / 2, {}},
                                    {"young_modulus", 5e6, 1e-3, {}},
                                    {"contraction", 0.8, 1e-2, {}},
                                    {"contraction", 0.8, 1.0 / 2, {}},
                                    {"flow", 0.1, 1.0 / 2, {}},
                                    {"flow", 10.0, 1.0 / 10, {}},
                                    {"occupancy_floor", 1e-10, 0.0, {}},
                                    {"occupancy_floor", 1e-2, 0.3, {}},
                                    {"time_step", 1.0 / 30, 0.0, {}},
                                    {"poisson_ratio", 0.499, 0.0, {}},
                                    {"muscle_stiffness", 1e8, 0.0, {}},
                                    {"first_weight", 0.0, 0.0, {}},
                                    {"first_weight", 1e-12, 0.0, {}},
                                    {"start_shaken", 3.0, 0.0, {}},
                                    {"start_inverted_cells", 3.0, 0.0, {}},
                                    {"start_scaled_lateral", -1.0, 0.0, {}},
                                    {"start_scaled_lateral", 0.0, 0.0, {}},
                                    {"start_point", 0.0, 0.0, kPoint},
                                    {"start_speed", 100.0, 0.0, {}},
                                    {"fin_one_cell_wide", 1.0, 0.0, {}},
                                    {"two_pieces", 1.0, 0.0, {}},
                                    {"one_cell", 1.0, 0.0, {}},
                                    {"opposite_ends", 12.0, 0.0, {}}};
    const std::string method = t.method();
    return std::any_of(std::begin(kCorners), std::end(kCorners), [&](const Cell& c) {
        return t.axis_x == c.axis && t.value_x == c.x && t.value_y == c.y &&
               (c.methods.empty() || std::find(c.methods.begin(), c.methods.end(), method) != c.methods.end());
    });
}

double body_length(const Trial& t) {
    return t.space->bases()[0].length_in_cells * t.space->box().dx;
}

}  // namespace

std::shared_ptr<const ShapeSpace> small_space() {
    static const auto space = space_of({14, 6, 6}, {{ellipsoid({6.0, 2.0, 2.4}), -6.0, 6.0, 2.2},
                                                    {ellipsoid({5.0, 2.4, 2.2}, {0.4, 0.0, 0.2}), -4.6, 5.4, 2.3}});
    return space;
}

std::shared_ptr<const ShapeSpace> flat_space() {
    static const auto space = space_of({24, 10, 1}, {{ellipsoid({10.0, 2.3, 1e6}), -10.0, 10.0, 2.3},
                                                     {ellipsoid({8.6, 2.9, 1e6}, {0.6, 0.0, 0.0}), -8.0, 9.2, 2.8}});
    return space;
}

std::shared_ptr<const ShapeSpace> cell_space() {
    const Inside cell = brick({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0});
    return space_of({8, 8, 8}, {{cell, -1.0, 1.0, 1.0}, {cell, -1.0, 1.0, 1.0}});
}

std::vector<BarycenterTrial> barycenters(bool quick) {
    std::vector<BarycenterTrial> out;
    const Vector sigmas = quick ? Vector{0.2, 0.4, 8.0} : Vector{0.2, 0.3, 0.4, 0.7, 1.0, 2.0, 4.0, 8.0};
    const Vector separations = quick ? Vector{0.0, 8.0, 24.0} : Vector{0.0, 4.0, 8.0, 16.0, 24.0};
    for (const bool reference : {false, true})
        for (const double sigma : sigmas)
            for (const double separation : separations) out.push_back({sigma, separation, reference});
    return out;
}

std::vector<Trial> mechanics(bool quick) {
    Map map;
    const auto young = [](Trial& t, double e) { t.scene.young_modulus = e; };
    const auto time_step = [](Trial& t, double h) { t.scene.time_step = h; };
    const std::vector<double> steps{1e-3, 1e-2, 1.0 / 30, 1.0 / 10, 1.0 / 3, 1.0 / 2};
    map.plane("young_modulus", {1e4, 1e5, 1e6, 5e6, 1e7, 1e8, 1e9}, young, "time_step", steps, time_step,
              {kDefault, kVolume, kNeo, kBdf2, kNeoBdf2, kPlane, kPlaneNeo, kPlaneDirect});
    map.plane("young_modulus", {1e4, 1e6, 1e8}, young, "time_step", {1e-2, 1.0 / 10, 1.0 / 2}, time_step,
              {kDirect, kProjective, kDouble, kFactor, kFactorDouble});
    map.plane("young_modulus", {1e4, 1e5, 1e6, 5e6, 1e7, 1e8, 1e9}, young, "time_step", steps, time_step, {kReference});
    map.plane("contraction", {0.05, 0.2, 0.4, 0.6, 0.8}, [](Trial& t, double c) { t.scene.contraction = c; },
              "time_step", steps, time_step, {kDefault, kVolume, kNeo, kBdf2, kReference});
    map.plane("flow", {0.0, 0.1, 1.0, 3.0, 10.0},  // body lengths a second, obliquely from ahead
              [](Trial& t, double speed) {
                  const double v = speed * body_length(t);
                  t.scene.hydrodynamics.current = {-0.8 * v, 0.5 * v, t.space->box().dims == 2 ? 0.0 : 0.3 * v};
              },
              "time_step", steps, time_step, {kDefault, kNeo, kBdf2, kExplicit, kReference});
    map.plane(
        "occupancy_floor", {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}, [](Trial& t, double g) { t.scene.occupancy_floor = g; },
        "threshold", {0.0, 0.005, 0.02, 0.1, 0.3}, [](Trial& t, double tau) { t.scene.threshold = tau; },
        {kDefault, kNeo});
    map.plane(
        "occupancy_floor", {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}, [](Trial& t, double g) { t.scene.occupancy_floor = g; },
        "threshold", {0.0}, [](Trial& t, double tau) { t.scene.threshold = tau; }, {kReference});
    map.line("time_step", steps, time_step, {kLoose});
    map.line("poisson_ratio", {0.0, 0.3, 0.45, 0.49, 0.499}, [](Trial& t, double nu) { t.scene.poisson_ratio = nu; },
             {kVolume, kNeo, kNeoBdf2});
    map.line("muscle_stiffness", {0.0, 1e4, 1e6, 1e8}, [](Trial& t, double w) { t.scene.muscle_stiffness = w; },
             {kDefault, kNeo});
    map.line("first_weight", {0.0, 1e-12, 1e-8, 1e-4, 1e-2, 1.0},
             [](Trial& t, double alpha) {
                 t.weights = {alpha, 1.0 - alpha};
             },
             {kDefault});
    const std::vector<Variant> materials{kDefault, kVolume, kNeo, kBdf2};
    map.line(
        "start_shaken", {0.1, 0.3, 1.0, 3.0}, [](Trial& t, double cells) { t.start = shaken(cells, 7); }, materials);
    map.line(
        "start_inverted_cells", {1.0, 2.0, 3.0},
        [](Trial& t, double seed) { t.start = inverted_cells(static_cast<std::uint64_t>(seed)); }, materials);
    map.line(
        "start_scaled_lateral", {-1.0, -0.1, 0.0, 0.1, 4.0}, [](Trial& t, double f) { t.start = scaled(1, f); },
        materials);
    map.line(
        "start_point", {0.0}, [](Trial& t, double) { t.start = point(); }, materials);
    map.line(
        "start_speed", {1.0, 10.0, 100.0},
        [](Trial& t, double speed) {
            t.start = moving({-speed * body_length(t), 0.0, 0.0});
        },
        materials);
    map.line(
        "fin_one_cell_wide", {1.0},
        [](Trial& t, double) {
            const Inside fish = either(ellipsoid({6.0, 2.0, 2.4}), brick({-7.0, -0.5, -3.0}, {-4.5, 0.5, 3.0}));
            const Inside wings = either(ellipsoid({5.0, 2.0, 2.2}), brick({-1.0, -4.0, -0.5}, {1.0, 4.0, 0.5}));
            t.space = space_of({18, 10, 8}, {{fish, -6.0, 6.0, 2.2}, {wings, -5.0, 5.0, 2.2}});
        },
        materials);
    map.line(
        "two_pieces", {1.0},
        [](Trial& t, double) {
            const Inside two =
                either(ellipsoid({3.0, 2.0, 2.0}, {-4.0, 0.0, 0.0}), ellipsoid({2.5, 2.0, 2.0}, {4.0, 0.0, 0.0}));
            t.space = space_of({18, 8, 8}, {{two, -7.0, 6.5, 2.0}, {two, -7.0, 6.5, 2.0}});
        },
        materials);
    map.line(
        "one_cell", {1.0}, [](Trial& t, double) { t.space = cell_space(); }, materials);
    map.line("opposite_ends", {4.0, 8.0, 12.0},  // cells between the centres of two bases
             [](Trial& t, double apart) {
                 const double x = 0.5 * apart;
                 t.space = space_of({24, 8, 8}, {{ellipsoid({4.0, 2.0, 2.0}, {-x, 0.0, 0.0}), -x - 4.0, -x + 4.0, 2.0},
                                                 {ellipsoid({4.0, 2.0, 2.0}, {x, 0.0, 0.0}), x - 4.0, x + 4.0, 2.0}});
                 t.weights = {0.5, 0.5};
             },
             {kDefault});
    if (quick) std::erase_if(map.trials, [](const Trial& t) { return !is_corner(t); });
    for (Trial& t : map.trials) t.independent = !quick;
    return map.trials;
}

}  // namespace stability
