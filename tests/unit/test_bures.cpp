// SPDX-License-Identifier: MIT
// The Bures-Wasserstein barycentre: closed forms, its equation to rounding, and its derivative.
#include <Eigen/Geometry>

#include "derivative_checks.hpp"
#include "shape/bures.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Random;
using derivative::Vector;
using Eigen::Matrix3d;

Matrix3d random_covariance(Random& random, double ratio) {
    Matrix3d g;
    for (int k = 0; k < 9; ++k) g(k / 3, k % 3) = random.uniform(-1, 1);
    Matrix3d q;  // Gram-Schmidt
    q.col(0) = g.col(0).normalized();
    q.col(1) = (g.col(1) - q.col(0).dot(g.col(1)) * q.col(0)).normalized();
    q.col(2) = q.col(0).cross(q.col(1));
    return q * Eigen::Vector3d(1, ratio, ratio * ratio).asDiagonal() * q.transpose();
}

double equation_error(const std::vector<Matrix3d>& c, const Vector& w, const Matrix3d& s) {
    const Matrix3d root = square_root(s);
    Matrix3d sum = Matrix3d::Zero();
    for (std::size_t i = 0; i < c.size(); ++i) {
        const Matrix3d inner = root * c[i] * root;
        sum += w[i] * square_root(0.5 * (inner + inner.transpose()));
    }
    return (sum - s).norm() / s.norm();
}

void test_closed_forms() {
    Random random(1);
    const Matrix3d a = random_covariance(random, 0.3), b = random_covariance(random, 0.6);
    CHECK((square_root(a) * square_root(a) - a).norm() < 1e-15);
    CHECK(bures_barycenter({a, b}, {1, 0}) == a && bures_barycenter({a, b}, {0, 1}) == b);
    CHECK((bures_barycenter({a, a, a}, {0.2, 0.3, 0.5}) - a).norm() < 1e-14);
    // Two Gaussians: the geodesic ((1-t) 1 + t T) A ((1-t) 1 + t T), T the optimal map from A to B.
    const Matrix3d root = square_root(a), inverse = root.inverse(), inner = root * b * root;
    const Matrix3d map = inverse * square_root(0.5 * (inner + inner.transpose())) * inverse;
    for (const double t : {0.1, 0.5, 0.8}) {
        const Matrix3d step = (1 - t) * Matrix3d::Identity() + t * map;
        CHECK((bures_barycenter({a, b}, {1 - t, t}) - step * a * step).norm() < 1e-13);
    }
    // Commuting ones: standard deviations are averaged.
    const Matrix3d c = Eigen::Vector3d(1, 4, 9).asDiagonal(), d = Eigen::Vector3d(16, 1, 0.25).asDiagonal();
    const Matrix3d mean = Eigen::Vector3d(2.5 * 2.5, 1.5 * 1.5, 1.75 * 1.75).asDiagonal();
    CHECK((bures_barycenter({c, d}, {0.5, 0.5}) - mean).norm() < 1e-13);
}

void test_equation() {
    Random random(2);
    for (const double ratio : {1.0, 0.5, 0.1, 0.02}) {  // up to a needle
        std::vector<Matrix3d> c;
        for (int i = 0; i < 5; ++i) c.push_back(random.uniform(0.5, 2) * random_covariance(random, ratio));
        for (const Vector& w : {Vector{0.2, 0.2, 0.2, 0.2, 0.2}, Vector{0.7, 0, 0.05, 0.25, 0}}) {
            const Matrix3d s = bures_barycenter(c, w);
            CHECK(equation_error(c, w, s) < 1e-11);
            CHECK(s == s.transpose() && s.determinant() > 0);
        }
    }
}

Vector entries(const Matrix3d& m) {
    return {m(0, 0), m(1, 1), m(2, 2), m(0, 1) + m(1, 0), m(0, 2) + m(2, 0), m(1, 2) + m(2, 1)};
}
Matrix3d bar_of(const Vector& b) {
    Matrix3d m;
    m << b[0], b[3], b[4], b[3], b[1], b[5], b[4], b[5], b[2];
    return m;
}

void test_derivatives() {
    Random random(3);
    for (const double ratio : {0.5, 0.2}) {
        std::vector<Matrix3d> c;
        for (int i = 0; i < 4; ++i) c.push_back(random_covariance(random, ratio));
        derivative::Options options;
        options.noise = 1e-13;
        options.directions = {{1, -0.5, -0.2, -0.3}, {-0.3, 0.4, 0.6, -0.7}};  // within the simplex
        derivative::check_pullback(
            "barycentre", [&](const Vector& w) { return entries(bures_barycenter(c, w)); },
            [&](const Vector& w, const Vector& bar) {
                Vector g = bures_barycenter_pullback(c, w, bures_barycenter(c, w), bar_of(bar));
                const double mean = sum(g) / 4;
                for (double& x : g) x -= mean;
                return g;
            },
            {0.3, 0.2, 0.1, 0.4}, options);
        derivative::check_pullback(
            "square root", [&](const Vector& v) { return entries(square_root(bar_of(v))); },
            [&](const Vector& v, const Vector& bar) {
                return entries(square_root_pullback(square_root(bar_of(v)), bar_of(bar)));
            },
            {c[0](0, 0), c[0](1, 1), c[0](2, 2), c[0](0, 1), c[0](0, 2), c[0](1, 2)},
            {.step = 1e-3, .taylor_step = 1e-3});
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_closed_forms),
        TEST(test_equation),
        TEST(test_derivatives),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
