// SPDX-License-Identifier: MIT
// The harness itself: it must pass a right pullback and reject every way of being wrong that it is there to find.
#include "derivative_checks.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Vector;

// f(x) = (x0 x1, sin x0 + x2^2, exp(x1) x2)
Vector map(const Vector& x) {
    return {x[0] * x[1], std::sin(x[0]) + x[2] * x[2], std::exp(x[1]) * x[2]};
}

Vector right(const Vector& x, const Vector& w) {
    return {w[0] * x[1] + w[1] * std::cos(x[0]), w[0] * x[0] + w[2] * std::exp(x[1]) * x[2],
            2 * w[1] * x[2] + w[2] * std::exp(x[1])};
}

const Vector point{0.3, -0.7, 1.1};

bool rejected(const derivative::Map& f, const derivative::Pullback& pullback, const std::string& reason,
              const derivative::Options& options = {}) {
    try {
        derivative::check_pullback("harness", f, pullback, point, options);
    } catch (const std::runtime_error& e) {
        if (std::strstr(e.what(), reason.c_str())) return true;
        throw;
    }
    return false;
}

void test_right_is_accepted() {
    derivative::check_pullback("right", map, right, point);
    derivative::Options forward;
    forward.one_sided = true;
    derivative::check_pullback("forward", map, right, point, forward);
    derivative::Options affine;
    affine.affine = true;
    derivative::check_pullback(
        "affine",
        [](const Vector& x) {
            return Vector{2 * x[0] - x[2] + 1, x[1]};
        },
        [](const Vector&, const Vector& w) {
            return Vector{2 * w[0], w[1], -w[0]};
        },
        point, affine);
}

void test_wrong_is_rejected() {
    CHECK(rejected(
        map,
        [](const Vector& x, const Vector& w) {
            Vector g = right(x, w);
            g[1] *= 1.001;  // a factor
            return g;
        },
        "slope of the Taylor remainder"));
    CHECK(rejected(
        map,
        [](const Vector& x, const Vector& w) {
            Vector g = right(x, w);
            for (double& v : g) v *= 1 + 3e-6;  // too little for the slope at the longest steps, not for differences
            return g;
        },
        "harness"));
    CHECK(rejected(
        map,
        [](const Vector& x, const Vector& w) {
            Vector g = right(x, w);
            g[2] -= 2 * w[1] * x[2];  // a forgotten term
            return g;
        },
        "harness"));
    CHECK(rejected(
        map, [](const Vector&, const Vector&) { return Vector(3, 0.0); }, "norm of the gradient"));
    CHECK(rejected(
        map, [](const Vector&, const Vector&) { return Vector(3, std::nan("")); }, "norm of the gradient"));
    // A constant map with a zero pullback tests nothing, and says so; so does a direction along which nothing changes.
    CHECK(rejected([](const Vector&) { return Vector{1.0}; },
                   [](const Vector&, const Vector&) { return Vector(3, 0.0); }, "norm of the gradient"));
    derivative::Options across;
    across.directions = {{0, 0, 1}};
    CHECK(rejected([](const Vector& x) { return Vector{x[0] * x[1]}; },
                   [](const Vector& x, const Vector& w) {
                       return Vector{w[0] * x[1], w[0] * x[0], 0};
                   },
                   "gradient along d", across));
    // An affine map cannot show the slope.
    CHECK(rejected([](const Vector& x) { return Vector{x[0]}; },
                   [](const Vector&, const Vector& w) {
                       return Vector{w[0], 0, 0};
                   },
                   "steps above the noise"));
}

void test_kink_is_rejected() {
    // |x0 - 0.3| at its kink: a one-sided derivative does not pass for a derivative.
    CHECK(rejected([](const Vector& x) { return Vector{std::fabs(x[0] - 0.3) + x[1] * x[1]}; },
                   [](const Vector& x, const Vector& w) {
                       return Vector{w[0], 2 * w[0] * x[1], 0};
                   },
                   "harness"));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {TEST(test_right_is_accepted), TEST(test_wrong_is_rejected),
                                TEST(test_kink_is_rejected)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
