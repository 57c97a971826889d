// SPDX-License-Identifier: MIT
// A Cholesky factor packed for a fast approximate solve with three right-hand sides: single precision, per supernode
// the matrix B = [L11^-1; L21 L11^-1] in chunks of 16 rows, so that both sweeps are streams of fused multiply-adds
// without a dependent division: forward (z1, x2) <- (L11^-1 b1, b2 - L21 L11^-1 b1), backward x1 <- B^T (z1, -x2).
#pragma once

#include <memory>
#include <vector>

#include "linalg/kernels.hpp"
#include "linalg/sparse.hpp"

namespace dqa {

class PackedFactor {
public:
    PackedFactor(const CholeskyFactor& factor, InstructionSet instructions);

    struct Workspace {
        std::vector<float> x, scratch;
    };
    // out [n][3] ~ A^-1 in [n][3]; the two may be the same. A symmetric positive definite operator up to rounding.
    void solve(const double* in, double* out, Workspace& ws) const;
    long entries() const { return entries_; }
    std::size_t bytes() const { return values_.size() * sizeof(float); }

private:
    const FactorKernels& kernels_;
    int n_;
    long entries_;
    int widest_ = 0;
    std::vector<int> permutation_, rows_;
    std::vector<PackedSupernode> supernodes_;
    std::vector<float> values_;
};

}  // namespace dqa
