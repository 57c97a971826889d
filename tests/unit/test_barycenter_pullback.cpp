// SPDX-License-Identifier: MIT
// dL/dalpha of the barycentre by implicit differentiation, against a reverse sweep through every step of the plain
// iteration (the oracle) and against differences.
#include "density_fixtures.hpp"
#include "derivative_checks.hpp"
#include "shape/barycenter.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Random;
using derivative::Vector;
using Bases = std::vector<Vector>;

const Cells cells{8, 8, 10};

const Bases& bodies() {
    static const Bases bases{normalised(soft_ellipsoid(cells, {3.6, 4.0, 5.0}, {2.2, 1.5, 2.9})),
                             normalised(soft_ellipsoid(cells, {4.5, 4.3, 4.4}, {1.5, 2.3, 1.8})),
                             normalised(soft_ellipsoid(cells, {4.2, 3.6, 6.0}, {2.6, 1.7, 1.4}))};
    return bases;
}

Bases two_bodies() {
    return {bodies()[0], bodies()[1]};
}

BarycenterSettings tight(bool force_log = false) {
    BarycenterSettings s;
    s.tolerance = 1e-13, s.force_log = force_log, s.max_iterations = 20000;
    return s;
}

Vector mean_free(Vector v) {
    const double mean = sum(v) / static_cast<double>(v.size());
    for (double& x : v) x -= mean;
    return v;
}

Vector implicit(const GaussianKernel& kernel, const Bases& bases, const Vector& alpha, const Vector& p_bar,
                const BarycenterSettings& s) {
    return barycenter_pullback(kernel, bases, solve_barycenter(kernel, bases, alpha, s), p_bar.data(), s);
}

// The oracle. Forward: x_i^0 = 0; log d_i^t = log K (p_i / K exp(x_i^t)); log p^t = sum alpha_i log d_i^t;
// x_i^{t+1} = log p^t - log d_i^t. L = <p_bar, exp(log p^T)>. Backward: the same lines, transposed, from the last.
Vector unrolled(const GaussianKernel& kernel, const Bases& bases, const Vector& alpha, const Vector& p_bar, int steps) {
    const std::size_t m = bases.size(), n = p_bar.size();
    struct Record {
        Vector v, kv, log_d;
    };
    std::vector<std::vector<Record>> tape;
    Vector scratch(n), log_p(n);
    Bases x(m, Vector(n, 0.0));
    for (int t = 0; t <= steps; ++t) {
        std::vector<Record> records(m, Record{Vector(n), Vector(n), Vector(n)});
        log_p.assign(n, 0.0);
        for (std::size_t i = 0; i < m; ++i) {
            Record& r = records[i];
            Vector d(n);
            for (std::size_t c = 0; c < n; ++c) r.v[c] = std::exp(x[i][c]);
            kernel.apply(r.v.data(), r.kv.data(), scratch.data());
            for (std::size_t c = 0; c < n; ++c) d[c] = bases[i][c] / r.kv[c];
            kernel.apply(d.data(), d.data(), scratch.data());
            for (std::size_t c = 0; c < n; ++c) r.log_d[c] = std::log(d[c]), log_p[c] += alpha[i] * r.log_d[c];
        }
        for (std::size_t i = 0; i < m; ++i)
            for (std::size_t c = 0; c < n; ++c) x[i][c] = log_p[c] - records[i].log_d[c];
        tape.push_back(std::move(records));
    }
    Vector alpha_bar(m, 0.0), log_p_bar(n);
    Bases log_d_bar(m, Vector(n, 0.0));
    for (std::size_t c = 0; c < n; ++c) log_p_bar[c] = p_bar[c] * std::exp(log_p[c]);
    for (std::size_t t = tape.size(); t-- > 0;) {
        // Here log_p_bar and log_d_bar hold what x^{t+1} (or the loss) asks of step t.
        Vector next_log_p_bar(n, 0.0);
        for (std::size_t i = 0; i < m; ++i) {
            const Record& r = tape[t][i];
            Vector a(n);
            for (std::size_t c = 0; c < n; ++c) {
                alpha_bar[i] += log_p_bar[c] * r.log_d[c];
                a[c] = (log_d_bar[i][c] + alpha[i] * log_p_bar[c]) * std::exp(-r.log_d[c]);
            }
            kernel.apply(a.data(), a.data(), scratch.data());
            for (std::size_t c = 0; c < n; ++c) a[c] *= -bases[i][c] / (r.kv[c] * r.kv[c]);
            kernel.apply(a.data(), a.data(), scratch.data());
            for (std::size_t c = 0; c < n; ++c) {
                const double x_bar = a[c] * r.v[c];
                next_log_p_bar[c] += x_bar, log_d_bar[i][c] = -x_bar;
            }
        }
        log_p_bar = next_log_p_bar;
    }
    return mean_free(alpha_bar);
}

void check_same(const Vector& g, const Vector& expected, double tolerance) {
    const double size = derivative::norm(expected);
    CHECK(size > 1e-3);
    for (std::size_t i = 0; i < g.size(); ++i) NEAR(g[i] / size, expected[i] / size, tolerance);
}

void test_against_unrolled() {
    const GaussianKernel kernel(cells, 1.0);
    Random random(11);
    const Vector p_bar = random.vector(static_cast<std::size_t>(kernel.size()));
    for (const Vector& alpha :
         {Vector{0.5, 0.3, 0.2}, Vector{0.05, 0.9, 0.05}, Vector{0.4, 0.0, 0.6}, Vector{0, 1, 0}}) {
        const Vector oracle = unrolled(kernel, bodies(), alpha, p_bar, 1500);
        check_same(unrolled(kernel, bodies(), alpha, p_bar, 1000), oracle, 1e-9);  // the oracle has converged
        check_same(implicit(kernel, bodies(), alpha, p_bar, tight()), oracle, 1e-8);
        check_same(implicit(kernel, bodies(), alpha, p_bar, tight(true)), oracle, 1e-8);
    }
    const Vector oracle = unrolled(kernel, two_bodies(), {0.35, 0.65}, p_bar, 1500);
    check_same(implicit(kernel, two_bodies(), {0.35, 0.65}, p_bar, tight()), oracle, 1e-8);
}

void check_differences(const Bases& bases, const Vector& alpha, double sigma, bool force_log,
                       const std::vector<Vector>& directions, bool one_sided) {
    const GaussianKernel kernel(cells, sigma);
    derivative::Options options;
    options.noise = 1e-12;  // of p, for marginals within 1e-13
    options.step = 0.04, options.taylor_step = 0.02;
    options.directions = directions, options.one_sided = one_sided;
    const BarycenterSettings s = tight(force_log);
    derivative::check_pullback(
        "barycentre", [&](const Vector& a) { return solve_barycenter(kernel, bases, a, s).p; },
        [&](const Vector& a, const Vector& bar) { return implicit(kernel, bases, a, bar, s); }, alpha, options);
}

void test_differences_inside() {
    for (const bool force_log : {false, true})  // the logarithmic form takes longer, so two bases are enough for it
        check_differences(two_bodies(), {0.35, 0.65}, 1.0, force_log, {{1, -1}}, false);
    check_differences(bodies(), {0.5, 0.3, 0.2}, 1.0, false, {{1, -1, 0}, {0.3, 0.5, -0.8}}, false);
    check_differences(bodies(), {0.5, 0.3, 0.2}, 0.6, false, {{1, -1, 0}, {0.3, 0.5, -0.8}}, false);
}

void test_differences_at_the_boundary() {
    // Into the simplex from a vertex, and from an edge.
    for (const bool force_log : {false, true}) check_differences(two_bodies(), {1, 0}, 1.0, force_log, {{-1, 1}}, true);
    check_differences(bodies(), {0, 1, 0}, 1.0, false, {{0.7, -1, 0.3}, {0, -1, 1}}, true);
    check_differences(bodies(), {0.4, 0, 0.6}, 1.0, false, {{-0.5, 1, -0.5}, {0.2, 0.8, -1}}, true);
    check_differences(bodies(), {0, 1, 0}, 0.6, false, {{0.7, -1, 0.3}}, true);
}

void test_properties() {
    const GaussianKernel kernel(cells, 0.8);
    Random random(12);
    const Vector p_bar = random.vector(static_cast<std::size_t>(kernel.size()));
    const Vector g = implicit(kernel, bodies(), {0.5, 0.3, 0.2}, p_bar, tight());
    NEAR(sum(g), 0, 1e-14 * derivative::norm(g));
    // The mass of p is one for every alpha: a constant in p_bar changes nothing.
    Vector raised = p_bar;
    for (double& b : raised) b += 5;
    check_same(implicit(kernel, bodies(), {0.5, 0.3, 0.2}, raised, tight()), g, 1e-9);
    // Linear in p_bar, over any scale.
    Vector scaled = p_bar;
    for (double& b : scaled) b *= -1e-12;
    Vector expected = implicit(kernel, bodies(), {0.5, 0.3, 0.2}, scaled, tight());
    for (double& b : expected) b *= -1e12;
    check_same(expected, g, 1e-9);
    // Bases in another order.
    const Vector h = implicit(kernel, {bodies()[2], bodies()[0], bodies()[1]}, {0.2, 0.5, 0.3}, p_bar, tight());
    check_same({h[1], h[2], h[0]}, g, 1e-9);
    // The same base twice: only the sum of its weights matters.
    const Vector twice = implicit(kernel, {bodies()[0], bodies()[1], bodies()[0]}, {0.2, 0.7, 0.1}, p_bar, tight());
    NEAR(twice[0], twice[2], 1e-9 * derivative::norm(twice));
    CHECK(derivative::norm(twice) > 1e-3);
    NEAR(implicit(kernel, {bodies()[0]}, {1.0}, p_bar, tight())[0], 0, 0);
    for (const double b : implicit(kernel, bodies(), {0.5, 0.3, 0.2}, Vector(p_bar.size(), 0.0), tight()))
        NEAR(b, 0, 0);
}

void test_threads_and_limits() {
    const GaussianKernel kernel(cells, 0.8);
    Random random(13);
    const Vector p_bar = random.vector(static_cast<std::size_t>(kernel.size()));
    BarycenterSettings s = tight();
    const Barycenter b = solve_barycenter(kernel, bodies(), {0.5, 0.3, 0.2}, s);
    const Vector one = barycenter_pullback(kernel, bodies(), b, p_bar.data(), s);
    for (const int threads : {2, 3, 8}) {
        s.threads = threads;
        CHECK(barycenter_pullback(kernel, bodies(), b, p_bar.data(), s) == one);
    }
    s.max_iterations = 3;
    EXPECT_ERROR(NOT_CONVERGED, "pullback: relative residual",
                 barycenter_pullback(kernel, bodies(), b, p_bar.data(), s));
    s = tight();
    s.monitor = [](int, double) { throw Error(Status::CANCELLED, "enough"); };
    EXPECT_ERROR(CANCELLED, "enough", barycenter_pullback(kernel, bodies(), b, p_bar.data(), s));
    // The gradient at the default tolerance is good for any optimiser.
    s = BarycenterSettings{};
    check_same(implicit(kernel, bodies(), {0.5, 0.3, 0.2}, p_bar, s), one, 1e-6);
}

// A loosely converged barycentre gives a gradient that is as loose, whatever the last iterate left in cells that carry
// next to nothing.
void test_error_follows_tolerance() {
    Random random(14);
    for (const double sigma : {0.4, 0.7, 1.0, 1.5}) {
        const GaussianKernel kernel(cells, sigma);
        const Vector p_bar = random.vector(static_cast<std::size_t>(kernel.size()));
        const Vector exact = implicit(kernel, bodies(), {0.5, 0.3, 0.2}, p_bar, tight());
        BarycenterSettings s;
        for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8}) {
            s.tolerance = tolerance;
            check_same(implicit(kernel, bodies(), {0.5, 0.3, 0.2}, p_bar, s), exact, 30 * tolerance);
        }
    }
}

// Supports at opposite ends, where only the logarithmic form exists: moving weight moves the body.
void test_far_apart() {
    const Cells line{90, 3, 3};
    const GaussianKernel kernel(line, 1.0);
    const Vector body = normalised(soft_ellipsoid(line, {45, 1.5, 1.5}, {4, 1, 1}));
    const Bases bases{shifted(line, body, -35), shifted(line, body, 35)};
    Vector place;  // L = mean x, dL/dalpha = (-35, 35)
    for (int c = 0; c < kernel.size(); ++c) place.push_back(c / 9);
    BarycenterSettings s;
    s.tolerance = 1e-11;
    for (const double weight : {0.5, 0.3}) {
        const Barycenter b = solve_barycenter(kernel, bases, {weight, 1 - weight}, s);
        CHECK(b.logarithmic == std::vector<char>(2, 1));
        const Vector g = barycenter_pullback(kernel, bases, b, place.data(), s);
        NEAR(g[0], -35, 1e-5);
        NEAR(g[1], 35, 1e-5);
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_against_unrolled), TEST(test_differences_inside), TEST(test_differences_at_the_boundary),
        TEST(test_properties),       TEST(test_threads_and_limits), TEST(test_error_follows_tolerance),
        TEST(test_far_apart),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
