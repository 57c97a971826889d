// SPDX-License-Identifier: MIT
// Adam and the projection onto the simplex: a step by hand, convergence, optimality, invariance.
#include "motion_fixtures.hpp"
#include "optimize/optimizer.hpp"

namespace {

using namespace fixtures;

struct Adam {
    Vector rates, first, second;
    std::int64_t iteration = 0;
    explicit Adam(const Vector& r) : rates(r), first(r.size(), 0.0), second(r.size(), 0.0) {}
    void operator()(Vector& x, const Vector& gradient) {
        adam_step(x.data(), gradient.data(), rates.data(), first.data(), second.data(),
                  static_cast<std::int64_t>(x.size()), ++iteration);
    }
};

// Two steps, with numbers worked out from algorithm 1 of Kingma & Ba (2015).
void test_adam_by_hand() {
    Adam adam({0.1, 0.01});
    Vector x = {1.0, -2.0};
    adam(x, {2.0, -0.5});
    NEAR(adam.first[0], 0.2, 1e-16);
    NEAR(adam.second[0], 0.004, 1e-16);
    // The corrected moments are g and g^2: a step of rate * g / (|g| + 1e-8).
    NEAR(x[0], 1.0 - 0.1 * 2.0 / (2.0 + 1e-8), 1e-15);
    NEAR(x[1], -2.0 + 0.01 * 0.5 / (0.5 + 1e-8), 1e-15);
    const double before = x[0];
    adam(x, {-1.0, 0.0});
    // first = 0.9 * 0.2 - 0.1 = 0.08, second = 0.999 * 0.004 + 0.001 = 0.004996; corrections 0.19 and 0.001999.
    NEAR(adam.first[0], 0.08, 1e-16);
    NEAR(adam.second[0], 0.004996, 1e-16);
    NEAR(x[0], before - 0.1 * (0.08 / 0.19) / (std::sqrt(0.004996 / 0.001999) + 1e-8), 1e-14);
}

void test_adam_on_a_quadratic() {
    const Vector target = {0.3, -1.2, 4.0}, curvature = {1.0, 100.0, 0.01};
    Adam adam({0.02, 0.02, 0.02});
    Vector x = {0.0, 0.0, 0.0};
    for (int k = 0; k < 4000; ++k) {
        Vector g(3);
        for (std::size_t i = 0; i < 3; ++i) g[i] = curvature[i] * (x[i] - target[i]);
        for (double& r : adam.rates) r = 0.02 * std::pow(0.999, k);
        adam(x, g);
    }
    for (std::size_t i = 0; i < 3; ++i) NEAR(x[i], target[i], 1e-3);
}

// Scaling of the loss leaves the path as it is, up to the epsilon in the denominator; a zero gradient moves nothing.
void test_adam_ignores_gradient_scale() {
    Random random{4};
    Vector a = {0.5, -0.5, 2.0}, b(a);
    Adam one({0.1, 0.2, 0.3}), two(one);
    for (int k = 0; k < 50; ++k) {
        const Vector g = random_vector(3, random);
        Vector scaled(g);
        for (double& x : scaled) x *= 1e4;
        one(a, g), two(b, scaled);
    }
    CHECK(norm_of(plus(a, -1.0, {0.5, -0.5, 2.0})) > 0.05);
    NEAR(relative_difference(b, a), 0.0, 1e-6);
    Adam still({0.1, 0.1, 0.1});
    Vector c = {1, 2, 3};
    still(c, {0, 0, 0});
    CHECK(c == Vector({1, 2, 3}));
}

// p = projection of x: p >= 0, sum p = 1, and x - p is one number on the support and not above it elsewhere.
void test_simplex_projection() {
    Random random{9};
    int with_zeros = 0, inside = 0;
    for (int round = 0; round < 2000; ++round) {
        const std::size_t n = 1 + static_cast<std::size_t>(round) % 12;
        Vector x = random_vector(n, random, std::pow(10.0, between(random, -3, 3)));
        if (round % 3 == 0)
            for (double& v : x) v += 1e3;
        if (round % 7 == 0 && n > 1) x[1] = x[0];  // ties
        const double scale = std::fabs(*std::max_element(x.begin(), x.end())) + 1.0;
        Vector p(x);
        project_simplex(p.data(), static_cast<std::int64_t>(n));
        double sum = 0.0, shift = -1e300;
        for (std::size_t i = 0; i < n; ++i) {
            CHECK(p[i] >= 0.0);
            sum += p[i];
            if (p[i] > 0) shift = std::max(shift, x[i] - p[i]);
            with_zeros += p[i] == 0.0;
        }
        NEAR(sum, 1.0, 1e-15 * static_cast<double>(n));
        for (std::size_t i = 0; i < n; ++i) {
            if (p[i] > 0) NEAR(x[i] - p[i], shift, 1e-14 * scale);
            CHECK(x[i] - p[i] <= shift + 1e-14 * scale);
        }
        inside += std::all_of(p.begin(), p.end(), [](double v) { return v > 0; }) && n > 1;
        Vector again(p);
        project_simplex(again.data(), static_cast<std::int64_t>(n));
        NEAR(norm_of(plus(again, -1.0, p)), 0.0, 1e-15 * static_cast<double>(n));
    }
    CHECK(with_zeros > 100 && inside > 100);
    Vector one = {-7.0};
    project_simplex(one.data(), 1);
    NEAR(one[0], 1.0, 0.0);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_adam_by_hand),
        TEST(test_adam_on_a_quadratic),
        TEST(test_adam_ignores_gradient_scale),
        TEST(test_simplex_projection),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
