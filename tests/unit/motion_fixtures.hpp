// SPDX-License-Identifier: MIT
// Shared by the tests of body, water, motion and tape: random vectors, derivative checks along a direction, and small
// shape spaces and designs.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "grid/active_set.hpp"
#include "grid/random.hpp"
#include "motion/design.hpp"
#include "motion/simulation.hpp"
#include "shape_fixtures.hpp"

namespace fixtures {

using Vector = std::vector<double>;

using dqa::Random;

inline double between(Random& random, double lo, double hi) {
    return lo + 0.5 * (hi - lo) * (random() + 1.0);
}

inline Vector random_vector(std::size_t n, Random& random, double scale = 1.0) {
    Vector v(n);
    for (double& x : v) x = scale * random();
    return v;
}

inline double dot_of(const Vector& a, const Vector& b) {
    double s = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) s += a[i] * b[i];
    return s;
}
inline double norm_of(const Vector& a) {
    return std::sqrt(dot_of(a, a));
}
inline Vector plus(const Vector& a, double e, const Vector& b) {
    Vector c(a);
    for (std::size_t i = 0; i < a.size(); ++i) c[i] += e * b[i];
    return c;
}
inline double relative_difference(const Vector& a, const Vector& b) {
    const double scale = norm_of(b), difference = norm_of(plus(a, -1.0, b));
    return difference == 0.0 ? 0.0 : difference / scale;
}
inline bool all_finite(const Vector& a) {
    return std::all_of(a.begin(), a.end(), [](double x) { return std::isfinite(x); });
}

// ---------------------------------------------------------------- derivatives

// f'(0) by the five-point stencil over a ladder of steps: the estimate whose neighbours agree best with it, chosen
// without a look at the derivative under test.
inline double five_point(const std::function<double(double)>& f, double first_step) {
    constexpr int levels = 7;
    double estimate[levels];
    for (int k = 0; k < levels; ++k) {
        const double e = first_step * std::pow(0.25, k);
        estimate[k] = (8.0 * (f(e) - f(-e)) - (f(2 * e) - f(-2 * e))) / (12.0 * e);
    }
    int best = 1;
    double agreement = 1e300;
    for (int k = 1; k + 1 < levels; ++k) {
        const double spread = std::fabs(estimate[k] - estimate[k - 1]) + std::fabs(estimate[k] - estimate[k + 1]);
        if (spread < agreement) agreement = spread, best = k;
    }
    return estimate[best];
}

// Slope of |f(e) - f(0) - e f'(0)| over e at the smallest steps whose remainder stands well above the rounding of f,
// which is read off second differences over steps too small for any curvature.
inline double taylor_slope(const std::function<double(double)>& f, double derivative, double first_step) {
    const double f0 = f(0.0);
    double rounding = 4e-16 * (std::fabs(f0) + std::fabs(derivative) * first_step);
    for (int k = 1; k <= 4; ++k) {
        const double e = 1e-8 * k * first_step;
        rounding = std::max(rounding, std::fabs(f(e) - 2.0 * f0 + f(-e)));
    }
    double slope = std::nan(""), before = 0.0;
    for (int k = 0; k < 14; ++k) {
        const double e = first_step * std::pow(0.5, k), r = std::fabs(f(e) - f0 - e * derivative);
        if (!(r > 100.0 * rounding)) break;
        if (k > 0) slope = std::log2(before / r);
        before = r;
    }
    return slope;
}

// The largest error that any check of this program saw; printed by report_worst.
inline double& worst_error() {
    static double worst = 0.0;
    return worst;
}
inline void report_worst(const char* what) {
    print_message("%s: worst finite-difference error %.1e\n", what, worst_error());
    worst_error() = 0.0;
}

enum class Order { linear, curved };  // of f: a linear one has no Taylor remainder

// Compares a derivative along a direction with f: not zero, five-point difference within 1e-6, slope 2 +- 0.1.
inline void check_derivative(const std::function<double(double)>& f, double derivative, double first_step, Order order,
                             int line) {
    if (!std::isfinite(derivative) || derivative == 0.0)
        throw std::runtime_error(format("line %d: derivative is %g", line, derivative));
    const double difference = five_point(f, first_step);
    const double error = std::fabs(derivative - difference) / std::fabs(difference);
    worst_error() = std::max(worst_error(), error);
    if (!(error <= 1e-6))
        throw std::runtime_error(format("line %d: derivative %.12g, differences give %.12g: error %.2g", line,
                                        derivative, difference, error));
    if (order == Order::linear) return;
    const double slope = taylor_slope(f, derivative, first_step);
    if (!(std::fabs(slope - 2.0) <= 0.1)) throw std::runtime_error(format("line %d: Taylor slope %.3f", line, slope));
}
#define CHECK_DERIVATIVE(f, derivative, step) check_derivative(f, derivative, step, Order::curved, __LINE__)
#define CHECK_LINEAR_DERIVATIVE(f, derivative, step) check_derivative(f, derivative, step, Order::linear, __LINE__)

// ---------------------------------------------------------------- geometry

// Rotation from a random quaternion, row-major.
inline std::array<double, 9> random_rotation(Random& random) {
    double q[4], n = 0.0;
    for (double& x : q) x = random(), n += x * x;
    for (double& x : q) x /= std::sqrt(n);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
            2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
            2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
}

// F x + t at every node.
inline Vector mapped(const Vector& rest, const std::array<double, 9>& f, const Vec3& t = {}) {
    Vector q(rest.size());
    for (std::size_t n = 0; n < rest.size(); n += 3)
        for (std::size_t a = 0; a < 3; ++a)
            q[n + a] = f[3 * a] * rest[n] + f[3 * a + 1] * rest[n + 1] + f[3 * a + 2] * rest[n + 2] + t[a];
    return q;
}

inline ActiveSet full_set(const std::array<int, 3>& cells, double dx) {
    const Box box{cells, dx};
    return make_active_set(box, std::vector<char>(static_cast<std::size_t>(box.n_cells()), 1));
}

// Covered fractions of an ellipsoid with these semi-axes (in cells) and its centre at a place in the box (in cells).
inline Vector ellipsoid_fractions(const std::array<int, 3>& cells, const Vec3& radius, const Vec3& centre = {}) {
    const Box box{cells, 1.0};
    constexpr int n = 4;
    Vector f(static_cast<std::size_t>(box.n_cells()), 0.0);
    for (int c = 0; c < box.n_cells(); ++c) {
        const Vec3 x = box.cell_centre(c);
        for (int s = 0; s < n * n * n; ++s) {
            const int at[3] = {s / (n * n), s / n % n, s % n};
            double r2 = 0.0;
            for (std::size_t a = 0; a < 3; ++a) {
                const double d = (x[a] + (at[a] + 0.5) / n - 0.5 - centre[a]) / radius[a];
                r2 += d * d;
            }
            f[static_cast<std::size_t>(c)] += r2 < 1.0 ? 1.0 / (n * n * n) : 0.0;
        }
    }
    return f;
}

// A caudal muscle over the rear half of an ellipsoid with these semi-axes and centre, in cells.
inline Actuator rear_muscle(const Vec3& radius, const Vec3& centre, double dx) {
    Actuator a;
    a.mean = {(centre[0] - 0.5 * radius[0]) * dx, centre[1] * dx, centre[2] * dx};
    const Vec3 half = {0.5 * radius[0] * dx, 0.97 * radius[1] * dx, 0.94 * radius[2] * dx};
    for (std::size_t k = 0; k < 3; ++k) a.variance[k] = half[k] * half[k] / kTwoLn2;
    return a;
}

// Two ellipsoids that differ in length, height and place, in a box of cells with these numbers; metres as a small fish.
inline std::shared_ptr<const ShapeSpace> ellipsoid_space(const std::array<int, 3>& cells = {20, 8, 8},
                                                         double dx = 0.05) {
    ShapeSettings s;
    s.cells = cells;
    s.cell_size = dx;
    s.sigma = 0.7;
    auto space = std::make_shared<ShapeSpace>(s);
    const double x = 0.5 * cells[0], y = 0.5 * cells[1], z = 0.5 * cells[2];
    const Vec3 slim{x - 2.0, y - 2.2, z - 2.0}, stout{x - 3.2, y - 1.8, z - 1.7}, centre{0.6, 0.0, 0.2};
    space->add_fractions("slim", ellipsoid_fractions(cells, slim).data());
    space->add_fractions("stout", ellipsoid_fractions(cells, stout, centre).data());
    space->add_actuator(0, rear_muscle(slim, {}, dx));
    space->add_actuator(1, rear_muscle(stout, centre, dx));
    space->build(nullptr);
    return space;
}

// The same idea in two dimensions: two ellipses.
inline std::shared_ptr<const ShapeSpace> plane_space(int nx = 24, int ny = 10, double dx = 0.04) {
    ShapeSettings s;
    s.dims = 2;
    s.cells = {nx, ny, 1};
    s.cell_size = dx;
    s.sigma = 0.7;
    auto space = std::make_shared<ShapeSpace>(s);
    space->add_fractions("slim", ellipsoid_fractions(s.cells, {0.5 * nx - 2.0, 0.5 * ny - 2.7, 1e6}).data());
    space->add_fractions("stout",
                         ellipsoid_fractions(s.cells, {0.5 * nx - 3.4, 0.5 * ny - 2.1, 1e6}, {0.6, 0.0, 0.0}).data());
    space->build(nullptr);
    return space;
}

inline std::shared_ptr<const Design> make_design(const SceneSettings& scene, const Vector& weights = {0.6, 0.4},
                                                 const std::shared_ptr<const ShapeSpace>& space = ellipsoid_space()) {
    return std::make_shared<Design>(space, weights, scene, nullptr);
}

inline SceneSettings tight_scene() {
    SceneSettings s;
    s.tolerance = 1e-10;
    s.adjoint_tolerance = 1e-12;
    s.shape_tolerance = 1e-12;
    return s;
}

// A smooth velocity field of about one size: translation, rotation and bending; not symmetric.
inline Vector swirl(const Vector& q, double size) {
    Vector v(q.size());
    for (std::size_t n = 0; n < q.size(); n += 3) {
        const double x = q[n], y = q[n + 1], z = q[n + 2];
        v[n] = size * (0.4 - 0.9 * y + 0.3 * z);
        v[n + 1] = size * (-0.2 + 0.9 * x - 0.5 * z + 0.8 * std::sin(5.0 * x));
        v[n + 2] = size * (0.1 + 0.5 * y - 0.3 * x + 0.2 * std::cos(4.0 * x));
    }
    return v;
}

}  // namespace fixtures
