// SPDX-License-Identifier: MIT
// The Wasserstein barycentre against shapes whose barycentre is known, the linear against the logarithmic form, plain
// against accelerated iterations, and its refusals.
//
// Translates. With x = x' + a, |x - y|^2 = |x' - y|^2 + 2 a (x' - y) + |a|^2: the added terms depend on x alone or on y
// alone and go into the scalings w and v; if sum alpha_i a_i = 0 the latter cancel in prod v_i^alpha_i = 1. So the
// barycentre of translates of one shape is that shape's own (blurred) one, moved by the mean translation, exactly.
//
// Gaussians N(mu_i, s_i^2) have a Gaussian barycentre with mean sum alpha_i mu_i. Plan i, w_i(x) K(x, y) v_i(y), has
// the precision [[A, -1/sigma^2], [-1/sigma^2, B_i]], marginal variances s_i^2 and S^2, hence 2 S^2 B_i = 1 + sqrt(1 +
// 4 s_i^2 S^2 / sigma^4); prod v_i^alpha_i = 1 means sum alpha_i B_i = 1/sigma^2. So
//   S^2 = sigma^2/2 + sum_i alpha_i sqrt(sigma^4/4 + s_i^2 S^2),
// the fixed point of Mallasto et al. 2020 ("Entropy-regularized 2-Wasserstein distance between Gaussian measures") for
// the cost |x - y|^2 with entropic weight 2 sigma^2; one base gives S^2 = s^2 + sigma^2. Sums over cells replace these
// integrals up to exp(-2 pi^2 V), V >= sigma^2 min(S / s_i, s_i / S) the conditional variances of the plans.
#include "density_fixtures.hpp"
#include "derivative_checks.hpp"
#include "shape/barycenter.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using Bases = std::vector<std::vector<double>>;

BarycenterSettings settings_of(double tolerance, int window = 15) {
    BarycenterSettings s;
    s.tolerance = tolerance, s.window = window, s.max_iterations = 200000;
    return s;
}

Bases three_bodies(const Cells& cells) {
    const double x = cells[0], y = cells[1], z = cells[2];
    return {normalised(soft_ellipsoid(cells, {0.5 * x, 0.5 * y, 0.5 * z}, {0.35 * x, 0.2 * y, 0.25 * z})),
            normalised(soft_ellipsoid(cells, {0.4 * x, 0.5 * y, 0.6 * z}, {0.2 * x, 0.3 * y, 0.2 * z})),
            normalised(soft_ellipsoid(cells, {0.6 * x, 0.45 * y, 0.4 * z}, {0.25 * x, 0.25 * y, 0.3 * z}))};
}

void check_whole(const Barycenter& b, double tolerance) {
    for (const auto* field : {&b.p, &b.log_v, &b.log_d, &b.log_kv})
        for (const double x : *field) CHECK(std::isfinite(x));
    for (const double x : b.p) CHECK(x >= 0);
    CHECK(b.marginal_error <= tolerance);
    NEAR(sum(b.p), 1, b.marginal_error + 1e-13);
}

// The largest sum |v_i d_i - p| of the solution, with d_i from v_i by the kernel here.
double marginal_error(const GaussianKernel& kernel, const Bases& bases, const Barycenter& b) {
    const std::size_t n = b.p.size();
    double worst = 0;
    for (std::size_t i = 0; i < bases.size(); ++i) {
        std::vector<double> v(n), w(n), scratch(n);
        for (std::size_t c = 0; c < n; ++c) v[c] = std::exp(b.log_v[i * n + c]);
        kernel.apply(v.data(), w.data(), scratch.data());
        for (std::size_t c = 0; c < n; ++c) w[c] = bases[i][c] / w[c];
        kernel.apply(w.data(), w.data(), scratch.data());
        for (std::size_t c = 0; c < n; ++c) w[c] *= v[c];
        worst = std::max(worst, distance_1(w, b.p));
    }
    return worst;
}

void test_translates() {
    const Cells cells{116, 4, 5};
    const GaussianKernel kernel(cells, 1.0);
    const auto body = normalised(soft_ellipsoid(cells, {58, 1.9, 2.7}, {4, 1.4, 1.8}));
    const Barycenter alone = solve_barycenter(kernel, {body}, {1.0}, settings_of(1e-12));
    CHECK(distance_1(alone.p, body) > 0.05);  // blurred by the entropy
    // Logarithms reach d^2 / (2 sigma^2) at distance d, so that their rounding lets marginals agree to 1e-12, not less.
    const double tolerance = 1e-10;
    const auto check_shift = [&](int a, int b, double weight, int expected) {
        const Bases bases{shifted(cells, body, a), shifted(cells, body, b)};
        const Barycenter both = solve_barycenter(kernel, bases, {weight, 1 - weight}, settings_of(tolerance));
        check_whole(both, tolerance);
        NEAR(distance_1(both.p, shifted(cells, alone.p, expected)), 0, 1e-8);
        return both.logarithmic == std::vector<char>{1, 1};
    };
    for (const int apart : {2, 10, 20, 30, 40}) CHECK(!check_shift(-apart / 2, apart / 2, 0.5, 0));
    CHECK(!check_shift(-2, 6, 0.25, 4));
    CHECK(!check_shift(-2, 6, 0.75, 0));
    CHECK(!check_shift(-16, 16, 0.25, 8));
    // Farther apart the linear kernel underflows and the other one takes over by itself, wherever that begins.
    for (int apart = 44; apart <= 92; apart += 16) check_shift(-apart / 2, apart / 2, 0.5, 0);
    CHECK(check_shift(-48, 48, 0.5, 0));  // opposite ends of the box
    CHECK(check_shift(-48, 48, 0.25, 24));
}

void test_gaussians() {
    const Cells cells{140, 1, 1};
    const auto gaussian = [&](double mean, double deviation) {
        std::vector<double> p;
        for (int i = 0; i < cells[0]; ++i) p.push_back(std::exp(-0.5 * std::pow((i - mean) / deviation, 2)));
        return normalised(p);
    };
    const std::vector<double> mean{62.3, 71.0, 78.4}, deviation{2.0, 5.0, 3.5};
    const Bases bases{gaussian(mean[0], deviation[0]), gaussian(mean[1], deviation[1]),
                      gaussian(mean[2], deviation[2])};
    for (const double sigma : {1.5, 2.0})
        for (const std::vector<double>& alpha :
             {std::vector<double>{0.2, 0.5, 0.3}, {1.0, 0.0, 0.0}, {0.0, 0.4, 0.6}}) {
            double m = 0, s2 = 1, last = 0;
            for (std::size_t i = 0; i < 3; ++i) m += alpha[i] * mean[i];
            while (std::fabs(s2 - last) > 1e-14 * s2) {
                last = s2, s2 = sigma * sigma / 2;
                for (std::size_t i = 0; i < 3; ++i)
                    s2 += alpha[i] * std::sqrt(std::pow(sigma, 4) / 4 + deviation[i] * deviation[i] * last);
            }
            if (alpha[0] == 1) NEAR(s2, 4 + sigma * sigma, 1e-12);
            const Barycenter b = solve_barycenter(GaussianKernel(cells, sigma), bases, alpha, settings_of(1e-12));
            check_whole(b, 1e-12);
            NEAR(distance_1(b.p, gaussian(m, std::sqrt(s2))), 0, 1e-8);
        }
}

void test_marginals_are_met() {
    const Cells cells{12, 10, 11};
    const GaussianKernel kernel(cells, 0.8);
    const Bases bases = three_bodies(cells);
    for (const double tolerance : {1e-4, 1e-9, 1e-12}) {
        const Barycenter b = solve_barycenter(kernel, bases, {0.3, 0.5, 0.2}, settings_of(tolerance));
        check_whole(b, tolerance);
        CHECK(b.m == 3 && b.n == kernel.size() && b.logarithmic == std::vector<char>(3, 0) && b.iterations > 3);
        NEAR(marginal_error(kernel, bases, b), b.marginal_error, 1e-13);
        CHECK(b.marginal_error > 1e-3 * tolerance || tolerance < 1e-9);  // no more work than was asked for
    }
}

void test_acceleration_changes_nothing_but_the_count() {
    const Cells cells{12, 10, 11};
    const Bases bases = three_bodies(cells);
    for (const double sigma : {0.6, 1.0}) {
        const GaussianKernel kernel(cells, sigma);
        const Barycenter fast = solve_barycenter(kernel, bases, {0.3, 0.5, 0.2}, settings_of(1e-11));
        const Barycenter plain = solve_barycenter(kernel, bases, {0.3, 0.5, 0.2}, settings_of(1e-11, 0));
        check_whole(plain, 1e-11);
        NEAR(distance_1(fast.p, plain.p), 0, 1e-8);
        CHECK(3 * fast.iterations < plain.iterations);
    }
}

void test_logarithmic_form_agrees() {
    const Cells cells{12, 10, 11};
    const GaussianKernel kernel(cells, 0.8);
    const Bases bases = three_bodies(cells);
    for (const std::vector<double>& alpha : {std::vector<double>{0.3, 0.5, 0.2}, {0.0, 1.0, 0.0}, {0.5, 0.0, 0.5}}) {
        BarycenterSettings s = settings_of(1e-11);
        const Barycenter linear = solve_barycenter(kernel, bases, alpha, s);
        s.force_log = true;
        const Barycenter logarithmic = solve_barycenter(kernel, bases, alpha, s);
        CHECK(linear.logarithmic == std::vector<char>(3, 0) && logarithmic.logarithmic == std::vector<char>(3, 1));
        check_whole(logarithmic, 1e-11);
        NEAR(distance_1(linear.p, logarithmic.p), 0, 1e-8);
    }
}

void test_vertices() {
    const Cells cells{12, 10, 11};
    const GaussianKernel kernel(cells, 0.5);
    const Bases bases = three_bodies(cells);
    for (std::size_t i = 0; i < 3; ++i) {
        std::vector<double> alpha(3, 0.0);
        alpha[i] = 1;
        const Barycenter b = solve_barycenter(kernel, bases, alpha, settings_of(1e-11));
        check_whole(b, 1e-11);
        NEAR(distance_1(b.p, solve_barycenter(kernel, {bases[i]}, {1.0}, settings_of(1e-11)).p), 0, 1e-9);
        // One base: v = 1, and p is the base blurred once after division by the kernel's mass.
        const std::size_t n = b.p.size();
        std::vector<double> w(n, 1.0), scratch(n);
        kernel.apply(w.data(), w.data(), scratch.data());
        for (std::size_t c = 0; c < n; ++c) w[c] = bases[i][c] / w[c];
        kernel.apply(w.data(), w.data(), scratch.data());
        NEAR(distance_1(b.p, w), 0, 1e-9);
    }
    // Equal bases: any weights give the same.
    const Barycenter b = solve_barycenter(kernel, {bases[0], bases[0]}, {0.3, 0.7}, settings_of(1e-12));
    NEAR(distance_1(b.p, solve_barycenter(kernel, {bases[0]}, {1.0}, settings_of(1e-12)).p), 0, 1e-10);
}

void test_supports_apart() {
    const Cells cells{110, 4, 4};
    const Bases bases{normalised(soft_ellipsoid(cells, {8, 2, 2}, {5, 1, 1.5})),
                      normalised(soft_ellipsoid(cells, {100, 1.5, 2.4}, {3, 1.3, 1}))};
    for (const double sigma : {0.7, 1.0, 2.0})
        for (const double weight : {0.5, 0.1, 0.0}) {
            const Barycenter b =
                solve_barycenter(GaussianKernel(cells, sigma), bases, {weight, 1 - weight}, settings_of(1e-9));
            check_whole(b, 1e-9);
            double middle = 0;
            for (std::size_t c = 0; c < b.p.size(); ++c) middle += b.p[c] * (static_cast<double>(c / 16) + 0.5);
            NEAR(middle, weight * 8 + (1 - weight) * 100, 0.05);
        }
}

void test_threads_give_the_same_bits() {
    const Cells cells{12, 10, 11};
    const GaussianKernel kernel(cells, 0.6);
    const Bases bases = three_bodies(cells);
    for (const bool force_log : {false, true}) {
        BarycenterSettings s = settings_of(1e-9);
        s.force_log = force_log;
        const Barycenter one = solve_barycenter(kernel, bases, {0.3, 0.5, 0.2}, s);
        for (const int threads : {2, 3, 8}) {
            s.threads = threads;
            const Barycenter many = solve_barycenter(kernel, bases, {0.3, 0.5, 0.2}, s);
            CHECK(many.p == one.p && many.log_v == one.log_v && many.log_d == one.log_d && many.log_kv == one.log_kv);
        }
    }
}

// One base far from where the others keep the body: it alone takes the logarithmic form, and the answer is the same.
void test_one_base_in_logarithms() {
    const Cells cells{30, 24, 4};
    const GaussianKernel kernel(cells, 0.3);
    const Bases bases{normalised(soft_ellipsoid(cells, {15, 12, 2}, {12, 2, 1.5})),
                      normalised(soft_ellipsoid(cells, {15, 12, 2}, {11, 3, 1.2})),
                      normalised(soft_ellipsoid(cells, {15, 12, 2}, {3, 11, 1.5}))};
    const std::vector<double> weights{0.45, 0.45, 0.1};
    BarycenterSettings s = settings_of(1e-12);
    const Barycenter mixed = solve_barycenter(kernel, bases, weights, s);
    CHECK(mixed.logarithmic == (std::vector<char>{0, 0, 1}));
    check_whole(mixed, 1e-12);
    s.force_log = true;
    const Barycenter all = solve_barycenter(kernel, bases, weights, s);
    NEAR(distance_1(mixed.p, all.p), 0, 1e-8);
    std::vector<double> p_bar;
    for (int c = 0; c < kernel.size(); ++c) p_bar.push_back(std::sin(0.01 * c));
    const std::vector<double> bar = barycenter_pullback(kernel, bases, mixed, p_bar.data(), settings_of(1e-12)),
                              expected = barycenter_pullback(kernel, bases, all, p_bar.data(), s);
    for (std::size_t i = 0; i < 3; ++i) NEAR(bar[i], expected[i], 1e-7);
}

void test_not_converged_and_cancelled() {
    const Cells cells{12, 10, 11};
    const GaussianKernel kernel(cells, 0.6);
    const Bases bases = three_bodies(cells);
    for (const bool force_log : {false, true}) {
        BarycenterSettings s = settings_of(1e-9);
        s.max_iterations = 5, s.force_log = force_log;
        EXPECT_ERROR(NOT_CONVERGED, "after 5 iterations", solve_barycenter(kernel, bases, {0.3, 0.5, 0.2}, s));
        s = settings_of(1e-30);  // below what doubles can reach
        s.max_iterations = 100, s.force_log = force_log;
        EXPECT_ERROR(NOT_CONVERGED, "expected <= 1e-30", solve_barycenter(kernel, bases, {0.3, 0.5, 0.2}, s));
        s = settings_of(1e-9);
        s.force_log = force_log;
        int calls = 0;
        s.monitor = [&](int iteration, double error) {
            ++calls;
            CHECK(iteration == calls && error > 1e-9);
            if (iteration == 7) throw Error(Status::CANCELLED, "enough");
        };
        EXPECT_ERROR(CANCELLED, "enough", solve_barycenter(kernel, bases, {0.3, 0.5, 0.2}, s));
        CHECK(calls == 7);
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_translates),
        TEST(test_gaussians),
        TEST(test_marginals_are_met),
        TEST(test_acceleration_changes_nothing_but_the_count),
        TEST(test_logarithmic_form_agrees),
        TEST(test_vertices),
        TEST(test_supports_apart),
        TEST(test_threads_give_the_same_bits),
        TEST(test_one_base_in_logarithms),
        TEST(test_not_converged_and_cancelled),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
