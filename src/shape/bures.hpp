// SPDX-License-Identifier: MIT
// Barycentre of covariances in the Bures-Wasserstein metric: the covariance of the optimal-transport barycentre of
// Gaussians (Agueh & Carlier 2011), by the fixed point of Alvarez-Esteban et al. 2016
//     S <- S^(-1/2) (sum_i w_i (S^(1/2) S_i S^(1/2))^(1/2))^2 S^(-1/2),
// its derivative by the implicit function theorem, and the symmetric square root with its own.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace dqa {

// weights >= 0 with sum 1; covariances symmetric positive definite.
Eigen::Matrix3d bures_barycenter(const std::vector<Eigen::Matrix3d>& covariances, const std::vector<double>& weights);
// dL/dw_i from dL/dS (symmetric) at the barycentre S, up to a constant along (1, ..., 1).
std::vector<double> bures_barycenter_pullback(const std::vector<Eigen::Matrix3d>& covariances,
                                              const std::vector<double>& weights, const Eigen::Matrix3d& barycenter,
                                              const Eigen::Matrix3d& barycenter_bar);

// Positive square root of a symmetric positive definite matrix.
Eigen::Matrix3d square_root(const Eigen::Matrix3d& matrix);
// dL/dA (symmetric) from dL/dT of T = A^(1/2).
Eigen::Matrix3d square_root_pullback(const Eigen::Matrix3d& root, const Eigen::Matrix3d& root_bar);

}  // namespace dqa
