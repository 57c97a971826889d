// SPDX-License-Identifier: MIT
// A Cholesky factor packed for fast solves with one right-hand side or three, in single precision as a preconditioner
// or in double: per supernode the matrix B = [L11^-1; L21 L11^-1] in chunks of rows, so that both sweeps are streams of
// fused multiply-adds without a dependent division: forward (z1, x2) <- (L11^-1 b1, b2 - L21 L11^-1 b1), backward x1 <-
// B^T (z1, -x2).
//
// In parallel: disjoint subtrees of the elimination tree, each with a buffer of its own for what it passes up, summed
// in the order of the subtrees; then the supernodes above them, by chunks of rows. The division depends on the factor
// alone, so that the bits are the same for any number of threads.
#pragma once

#include <array>
#include <functional>
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
    // out [n][3] ~ A^-1 in [n][3], the same for three right-hand sides; the two may be the same array. A symmetric
    // positive definite operator up to rounding.
    void solve(const double* in, double* out, Threads threads, Workspace& ws) const;
    // One right-hand side, of unknowns in blocks of three: unknown 3 i + a is out [i][4] at a; the fourth numbers stay
    // as they are. read(blocks, count, values) gives those of the blocks listed to values [count][4]; it is called from
    // all threads, for some blocks more than once. For factors in this precision.
    template <class Real>
    using ReadBlocks = std::function<void(const int* blocks, int count, Real* values)>;
    void solve(const ReadBlocks<float>& read, float* out, Threads threads, Workspace& ws) const;
    void solve(const ReadBlocks<double>& read, double* out, Threads threads, Workspace& ws) const;
    int size() const { return n_; }
    long entries() const { return entries_; }

private:
    struct Subtree {
        int begin = 0, end = 0;  // supernodes
    };
    // What is read and written at once: a subtree, or a piece of what lies above all of them.
    struct Part {
        int first_row = 0, last_row = 0;  // of the elimination order
        int first_block = 0, last_block = 0;
    };
    void divide(const CholeskyFactor& factor);
    template <class Real>
    void pack(const CholeskyFactor& factor, std::vector<Real>& values);
    void list_blocks();
    template <int width, class Real, class Read, class Write>
    void sweep(const FactorKernels<Real>& kernels, const std::vector<Real>& values, Read&& read, Write&& write,
               Threads threads, Scratch<Real>& ws) const;
    template <class Real>
    void solve_three(const FactorKernels<Real>& kernels, const std::vector<Real>& values, const double* in, double* out,
                     Threads threads, Scratch<Real>& ws) const;
    template <class Real>
    void solve_one(const FactorKernels<Real>& kernels, const std::vector<Real>& values, const ReadBlocks<Real>& read,
                   Real* out, Threads threads, Scratch<Real>& ws) const;

    const LinalgKernels& kernels_;
    Precision precision_;
    int n_;
    long entries_;
    int widest_ = 0;
    int top_ = 0;  // first row above all subtrees
    std::vector<int> permutation_, rows_;
    std::vector<int> order_;  // supernodes of the factor in ours
    std::vector<Subtree> subtrees_;
    std::vector<Part> parts_;                     // the subtrees, then the pieces
    std::vector<int> block_;                      // part by part
    std::vector<std::array<int, 3>> block_rows_;  // rows of its three unknowns, -1 where they are of another part
    std::vector<PackedSupernode> supernodes_;     // those of the subtrees, then those above
    std::vector<float> single_;
    std::vector<double> double_;
};

}  // namespace dqa
