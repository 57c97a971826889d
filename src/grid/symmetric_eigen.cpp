// SPDX-License-Identifier: MIT
#include "grid/symmetric_eigen.hpp"

#include <Eigen/Eigenvalues>

namespace dqa {

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
    return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

}  // namespace dqa
