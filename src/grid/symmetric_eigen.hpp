// SPDX-License-Identifier: MIT
// Eigenvalues and eigenvectors of symmetric matrices. One function and not Eigen's template wherever it is needed: that
// takes a compiler longer than all the rest of a file.
#pragma once

#include <Eigen/Core>

namespace dqa {

struct SymmetricEigen {
    Eigen::VectorXd values;   // ascending
    Eigen::MatrixXd vectors;  // orthonormal columns
    bool good;                // false: the iteration has not ended (entries that are no finite numbers)
};

// Of the symmetric matrix whose lower triangle is that of `a`.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);

}  // namespace dqa
