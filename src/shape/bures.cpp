// SPDX-License-Identifier: MIT
#include "shape/bures.hpp"

#include <cmath>

#include "grid/error.hpp"

namespace dqa {
namespace {

using Eigen::Matrix3d;
using Eigen::SelfAdjointEigenSolver;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kMaxIterations = 10000;
constexpr double kRoundOff = 1e-14;

Matrix3d symmetric(const Matrix3d& a) {
    return 0.5 * (a + a.transpose());
}

// Coordinates of symmetric matrices in an orthonormal basis, so that <A, B> = a . b.
Vector6 coordinates(const Matrix3d& a) {
    const double r = std::sqrt(2.0);
    Vector6 v;
    v << a(0, 0), a(1, 1), a(2, 2), r * a(0, 1), r * a(0, 2), r * a(1, 2);
    return v;
}
Matrix3d from_coordinates(const Vector6& v) {
    const double r = std::sqrt(0.5);
    Matrix3d a;
    a << v[0], r * v[3], r * v[4], r * v[3], v[1], r * v[5], r * v[4], r * v[5], v[2];
    return a;
}

struct Roots {
    Matrix3d root, inverse;
};

Roots roots_of(const Matrix3d& a) {
    const SelfAdjointEigenSolver<Matrix3d> solver(a);
    const Eigen::Vector3d s = solver.eigenvalues().cwiseSqrt();
    const Matrix3d& v = solver.eigenvectors();
    return {symmetric(v * s.asDiagonal() * v.transpose()),
            symmetric(v * s.cwiseInverse().asDiagonal() * v.transpose())};
}

}  // namespace

Matrix3d square_root(const Matrix3d& matrix) {
    return roots_of(matrix).root;
}

// T dT + dT T = dA: the transposed map solves the same equation.
Matrix3d square_root_pullback(const Matrix3d& root, const Matrix3d& root_bar) {
    const SelfAdjointEigenSolver<Matrix3d> solver(root);
    const Matrix3d& v = solver.eigenvectors();
    Matrix3d x = v.transpose() * symmetric(root_bar) * v;
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) x(a, b) /= solver.eigenvalues()[a] + solver.eigenvalues()[b];
    return symmetric(v * x * v.transpose());
}

Matrix3d bures_barycenter(const std::vector<Matrix3d>& covariances, const std::vector<double>& weights) {
    Matrix3d s = Matrix3d::Zero();
    for (std::size_t i = 0; i < covariances.size(); ++i) {
        if (weights[i] == 1.0) return covariances[i];
        s += weights[i] * covariances[i];
    }
    double last = HUGE_VAL;
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
        const Roots r = roots_of(s);
        Matrix3d mean = Matrix3d::Zero();
        for (std::size_t i = 0; i < covariances.size(); ++i)
            if (weights[i] > 0) mean += weights[i] * square_root(symmetric(r.root * covariances[i] * r.root));
        const Matrix3d next = symmetric(r.inverse * mean * mean * r.inverse);
        const double change = (next - s).norm() / s.norm();
        s = next;
        // The change falls geometrically down to rounding, where it stays.
        if (change < kRoundOff || (change < 1e-11 && change >= last)) return s;
        last = change;
    }
    fail(Status::NOT_CONVERGED, "the Bures barycentre of actuators changes by a relative %g after %d iterations", last,
         kMaxIterations);
}

// With M_i = (S^(1/2) S_i S^(1/2))^(1/2) the barycentre solves sum_i w_i S^(-1/2) M_i S^(-1/2) = 1. Its differential,
// in D = S^(-1/2) dS S^(-1/2) and the eigenbasis of each M_i, is  sum_i w_i [m_a m_b / (m_a + m_b) D_ab] = sum_i dw_i
// M_i: a symmetric positive definite system in the six entries of D.
std::vector<double> bures_barycenter_pullback(const std::vector<Matrix3d>& covariances,
                                              const std::vector<double>& weights, const Matrix3d& barycenter,
                                              const Matrix3d& barycenter_bar) {
    const Matrix3d root = square_root(barycenter);
    std::vector<Matrix3d> maps;
    Matrix6 system = Matrix6::Zero();
    for (std::size_t i = 0; i < covariances.size(); ++i) {
        const Matrix3d m = square_root(symmetric(root * covariances[i] * root));
        maps.push_back(m);
        if (!(weights[i] > 0)) continue;
        const SelfAdjointEigenSolver<Matrix3d> solver(m);
        const Matrix3d& v = solver.eigenvectors();
        for (int c = 0; c < 6; ++c) {
            Matrix3d d = v.transpose() * from_coordinates(Vector6::Unit(c)) * v;
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) {
                    const double ma = solver.eigenvalues()[a], mb = solver.eigenvalues()[b];
                    d(a, b) *= ma * mb / (ma + mb);
                }
            system.col(c) += weights[i] * coordinates(symmetric(v * d * v.transpose()));
        }
    }
    const Vector6 y = system.ldlt().solve(coordinates(symmetric(root * symmetric(barycenter_bar) * root)));
    std::vector<double> out;
    for (const Matrix3d& m : maps) out.push_back(y.dot(coordinates(m)));
    return out;
}

}  // namespace dqa
