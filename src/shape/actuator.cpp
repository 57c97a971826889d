// SPDX-License-Identifier: MIT
#include "shape/actuator.hpp"

#include <cmath>

#include "shape/bures.hpp"

namespace dqa {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kFadeShare = 0.05;

// Rotation about one axis and its derivative by the angle.
void axis_rotation(int axis, double angle, Matrix3d& r, Matrix3d& d) {
    const double c = std::cos(angle), s = std::sin(angle);
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    r.setZero(), d.setZero();
    r(axis, axis) = 1.0;
    r(a, a) = r(b, b) = c, r(a, b) = -s, r(b, a) = s;
    d(a, a) = d(b, b) = -s, d(a, b) = -c, d(b, a) = c;
}

struct Frame {
    Matrix3d r, d[3];  // R and dR/d(euler)
};

Frame frame_of(const Vec3& euler) {
    Matrix3d r[3], d[3];
    for (int a = 0; a < 3; ++a) axis_rotation(a, euler[static_cast<std::size_t>(a)], r[a], d[a]);
    return {r[0] * r[1] * r[2], {d[0] * r[1] * r[2], r[0] * d[1] * r[2], r[0] * r[1] * d[2]}};
}

Vector3d vector(const Vec3& v) {
    return {v[0], v[1], v[2]};
}
Vec3 vec3(const Vector3d& v) {
    return {v[0], v[1], v[2]};
}

Matrix3d covariance_of(const Actuator& a) {
    const Matrix3d r = frame_of(a.euler).r;
    return r.transpose() * vector(a.variance).asDiagonal() * r;
}

std::vector<Matrix3d> covariances_of(const std::vector<const Actuator*>& of_base, const std::vector<double>& weights,
                                     std::vector<double>& present_weights) {
    std::vector<Matrix3d> out;
    for (std::size_t i = 0; i < of_base.size(); ++i)
        if (of_base[i]) out.push_back(covariance_of(*of_base[i])), present_weights.push_back(weights[i]);
    return out;
}

void store(const Matrix3d& m, std::array<double, 9>& out) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) out[static_cast<std::size_t>(3 * i + j)] = m(i, j);
}

Matrix3d load(const std::array<double, 9>& m) {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.data());
}

// Rectangular box along the rows of R.
void linear_box(const Matrix3d& r, ActuatorPoint& out) {
    for (std::size_t k = 0; k < 3; ++k) {
        out.half[k] = std::sqrt(kTwoLn2 * out.variance[k]);
        out.normal[k] = out.edge[k] = vec3(r.row(static_cast<int>(k)));
    }
    store(r.transpose() * vector(out.variance).asDiagonal() * r, out.covariance);
}

// Box mean + c T R^T [-1, 1]^3 with T = Sigma^(1/2): rows of its inverse R T^(-1) / c are normals over half widths.
void bures_box(const Matrix3d& r, const Matrix3d& root, ActuatorPoint& out) {
    const double c = std::sqrt(kTwoLn2);
    const Matrix3d faces = r * root.inverse() / c, edges = c * root * r.transpose();
    for (int k = 0; k < 3; ++k) {
        const std::size_t a = static_cast<std::size_t>(k);
        out.half[a] = 1.0 / faces.row(k).norm();
        out.normal[a] = vec3(faces.row(k) * out.half[a]);
        out.edge[a] = vec3(edges.col(k).normalized());
    }
}

// Cotangents of T and R from those of the box.
void bures_box_pullback(const Matrix3d& r, const Matrix3d& root, const ActuatorPoint& point, const ActuatorBar& bar,
                        Matrix3d& root_bar, Matrix3d& r_bar) {
    const double c = std::sqrt(kTwoLn2);
    const Matrix3d inverse = root.inverse(), edges = c * root * r.transpose();
    Matrix3d faces_bar, edges_bar;
    for (int k = 0; k < 3; ++k) {
        const std::size_t a = static_cast<std::size_t>(k);
        // With f = n / h: dh = -h^2 n . df, dn = h (1 - n n^T) df.
        const Vector3d n = vector(point.normal[a]), n_bar = vector(bar.normal[a]);
        const double h = point.half[a];
        faces_bar.row(k) = (h * (n_bar - n.dot(n_bar) * n) - bar.half[a] * h * h * n).transpose();
        const Vector3d e = vector(point.edge[a]), e_bar = vector(bar.edge[a]);
        edges_bar.col(k) = (e_bar - e.dot(e_bar) * e) / edges.col(k).norm();
    }
    const Matrix3d inverse_bar = r.transpose() * faces_bar / c;
    root_bar = c * edges_bar * r - inverse.transpose() * inverse_bar * inverse.transpose();
    r_bar = faces_bar * inverse.transpose() / c + c * edges_bar.transpose() * root;
}

}  // namespace

double smooth_step(double t) {
    if (t <= 0) return 0.0;
    if (t >= 1) return 1.0;
    return t * t * t * (10.0 + t * (-15.0 + 6.0 * t));
}

double smooth_step_derivative(double t) {
    if (t <= 0 || t >= 1) return 0.0;
    const double u = t * (1.0 - t);
    return 30.0 * u * u;
}

Actuator mirrored(const Actuator& actuator) {
    Actuator out = actuator;
    out.mean[1] = -out.mean[1], out.euler[0] = -out.euler[0], out.euler[2] = -out.euler[2];
    if (out.half == ActuatorHalf::left)
        out.half = ActuatorHalf::right;
    else if (out.half == ActuatorHalf::right)
        out.half = ActuatorHalf::left;
    return out;
}

ActuatorPoint interpolate_actuator(const std::vector<const Actuator*>& of_base, const std::vector<double>& weights,
                                   Interpolation interpolation) {
    ActuatorPoint out;
    out.weights.assign(weights.size(), 0.0);
    double count = 0.0;
    for (std::size_t i = 0; i < of_base.size(); ++i)
        if (of_base[i]) out.share += weights[i], count += 1.0;
    for (std::size_t i = 0; i < of_base.size(); ++i) {
        if (!of_base[i]) continue;
        // With no share at all the geometry is immaterial (strength 0) but must be finite.
        const double w = out.share > 0 ? weights[i] / out.share : 1.0 / count;
        out.weights[i] = w;
        for (std::size_t k = 0; k < 3; ++k) {
            out.mean[k] += w * of_base[i]->mean[k];
            out.variance[k] += w * of_base[i]->variance[k];
            out.euler[k] += w * of_base[i]->euler[k];
        }
    }
    out.strength = smooth_step(out.share / kFadeShare);
    const Matrix3d r = frame_of(out.euler).r;
    if (interpolation == Interpolation::linear) {
        linear_box(r, out);
        return out;
    }
    std::vector<double> present;
    const std::vector<Matrix3d> covariances = covariances_of(of_base, out.weights, present);
    const Matrix3d sigma = bures_barycenter(covariances, present);
    store(sigma, out.covariance);
    out.variance = vec3((r * sigma * r.transpose()).diagonal());
    bures_box(r, square_root(sigma), out);
    return out;
}

void interpolate_actuator_pullback(const std::vector<const Actuator*>& of_base, const ActuatorPoint& point,
                                   Interpolation interpolation, const ActuatorBar& bar,
                                   std::vector<double>& weights_bar) {
    if (!(point.share > 0)) return;  // strength and its slope are zero there
    const double strength_bar = bar.strength * smooth_step_derivative(point.share / kFadeShare) / kFadeShare;
    const Frame frame = frame_of(point.euler);
    Matrix3d r_bar;
    Vec3 variance_bar{}, euler_bar{};
    std::vector<double> by_covariance(of_base.size(), 0.0);
    if (interpolation == Interpolation::linear) {
        for (std::size_t k = 0; k < 3; ++k) {
            variance_bar[k] = 0.5 * bar.half[k] * point.half[k] / point.variance[k];
            r_bar.row(static_cast<int>(k)) = (vector(bar.normal[k]) + vector(bar.edge[k])).transpose();
        }
    } else {
        std::vector<double> present;
        const std::vector<Matrix3d> covariances = covariances_of(of_base, point.weights, present);
        const Matrix3d sigma = load(point.covariance), root = square_root(sigma);
        Matrix3d root_bar;
        bures_box_pullback(frame.r, root, point, bar, root_bar, r_bar);
        const std::vector<double> w_bar =
            bures_barycenter_pullback(covariances, present, sigma, square_root_pullback(root, root_bar));
        double mean = 0.0;
        for (std::size_t j = 0; j < present.size(); ++j) mean += present[j] * w_bar[j];
        for (std::size_t i = 0, j = 0; i < of_base.size(); ++i)
            if (of_base[i]) by_covariance[i] = w_bar[j++] - mean;
    }
    for (std::size_t e = 0; e < 3; ++e) euler_bar[e] = r_bar.cwiseProduct(frame.d[e]).sum();
    for (std::size_t i = 0; i < of_base.size(); ++i) {
        if (!of_base[i]) continue;
        double s = by_covariance[i];
        for (std::size_t k = 0; k < 3; ++k) {
            s += bar.mean[k] * (of_base[i]->mean[k] - point.mean[k]);
            s += variance_bar[k] * (of_base[i]->variance[k] - point.variance[k]);
            s += euler_bar[k] * (of_base[i]->euler[k] - point.euler[k]);
        }
        weights_bar[i] += s / point.share + strength_bar;
    }
}

}  // namespace dqa
