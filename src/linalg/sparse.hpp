// SPDX-License-Identifier: MIT
// Symmetric sparse matrices and their direct solvers behind one small interface: CHOLMOD (supernodal) and UMFPACK where
// the build has them, Eigen otherwise. Double precision.
#pragma once

#include <memory>
#include <utility>
#include <vector>

namespace dqa {

// Lower triangle (diagonal included) in compressed columns, rows ascending.
struct SymmetricMatrix {
    int n = 0;
    std::vector<int> start, row;
    std::vector<double> value;
};

// From the entries (row, value) of each column, rows at or below the diagonal, each once, in any order.
SymmetricMatrix matrix_from_columns(std::vector<std::vector<std::pair<int, double>>>& columns);

// A Cholesky factor as supernodes in elimination order: columns [first, first + columns) and the rows of their common
// pattern (the own columns first), dense column-major of leading dimension rows.size().
struct Supernode {
    int first = 0, columns = 0;
    std::vector<int> rows;
    std::vector<double> values;
};
struct CholeskyFactor {
    int n = 0;
    std::vector<int> permutation;  // elimination position -> original index
    std::vector<Supernode> supernodes;
    long entries = 0;  // of L
};

// Factorises with the given fill-reducing order (original index at each position). Throws ERROR_INTERNAL if the matrix
// is not positive definite.
CholeskyFactor factorise(const SymmetricMatrix& matrix, const std::vector<int>& order);

// Solves matrix x = b (one right-hand side, in place), with iterative refinement: rounding leaves more than that of b
// in the stiff systems of bodies. Returns false if not positive definite.
bool solve_positive(const SymmetricMatrix& matrix, std::vector<double>& x);
// The same by pivoted LU, for indefinite matrices. Returns false if singular.
bool solve_indefinite(const SymmetricMatrix& matrix, std::vector<double>& x);

// What the build uses: "cholmod umfpack" or "eigen".
const char* direct_solver_name();

}  // namespace dqa
