// SPDX-License-Identifier: MIT
// A Cholesky factor packed for a fast solve with three right-hand sides, in single precision as a preconditioner or in
// double: per supernode the matrix B = [L11^-1; L21 L11^-1] in chunks of rows, so that both sweeps are streams of fused
// multiply-adds without a dependent division: forward (z1, x2) <- (L11^-1 b1, b2 - L21 L11^-1 b1), backward
// x1 <- B^T (z1, -x2).
//
// In parallel: disjoint subtrees of the elimination tree, each with a buffer of its own for what it passes up, summed
// in the order of the subtrees; then the supernodes above them, by chunks of rows. The division depends on the factor
// alone, so that the bits are the same for any number of threads.
#pragma once

#include <memory>
#include <vector>

#include "grid/parallel.hpp"
#include "linalg/kernels.hpp"
#include "linalg/sparse.hpp"

namespace dqa {

enum class Precision : int { single_precision = 0, double_precision = 1 };

class PackedFactor {
public:
    PackedFactor(const CholeskyFactor& factor, Precision precision, InstructionSet instructions);

    template <class Real>
    struct Scratch {
        std::vector<Real> x, outside, in;
    };
    struct Workspace {
        Scratch<float> single_precision;
        Scratch<double> double_precision;
    };
    // out [n][width] ~ A^-1 in [n][width], width 3 or 1; the two may be the same. A symmetric positive definite
    // operator up to rounding.
    void solve(const double* in, double* out, Threads threads, Workspace& ws, int width = 3) const;
    int size() const { return n_; }
    long entries() const { return entries_; }

private:
    struct Subtree {
        int begin = 0, end = 0;           // supernodes
        int first_row = 0, last_row = 0;  // of the elimination order
    };
    void divide(const CholeskyFactor& factor);
    template <class Real>
    void pack(const CholeskyFactor& factor, std::vector<Real>& values);
    template <int width, class Real>
    void sweep(const FactorKernels<Real>& kernels, const std::vector<Real>& values, const double* in, double* out,
               Threads threads, Scratch<Real>& ws) const;

    const LinalgKernels& kernels_;
    Precision precision_;
    int n_;
    long entries_;
    int widest_ = 0;
    int top_ = 0;  // first row above all subtrees
    std::vector<int> permutation_, rows_;
    std::vector<int> order_;  // supernodes of the factor in ours
    std::vector<Subtree> subtrees_;
    std::vector<PackedSupernode> supernodes_;  // those of the subtrees, then those above
    std::vector<float> single_;
    std::vector<double> double_;
};

}  // namespace dqa
