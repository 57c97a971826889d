// SPDX-License-Identifier: MIT
// Kernel of the packed supernodal triangular solve, one table per instruction set. Single precision: it serves as a
// preconditioner, and is bound by the traffic of the factor's entries.
#pragma once

#include <cstdint>

#include "grid/simd.hpp"

namespace dqa {

constexpr int kFactorLanes = 16;  // rows of a packed chunk

// One supernode: columns [first, first + columns), rows_below rows listed elsewhere.
struct PackedSupernode {
    int first = 0, columns = 0, rows_below = 0;
    int row_offset = 0;         // into the row list
    std::int64_t forward = 0;   // offset of B  = [L11^-1; L21 L11^-1], chunks of 16 rows x columns
    std::int64_t backward = 0;  // offset of Bt = chunks of 16 columns x all rows
};

struct FactorKernels {
    // x [n][4] floats (three right-hand sides and padding) in elimination order, in place: x <- L^-T L^-1 x.
    void (*solve)(const PackedSupernode* supernodes, int count, const int* rows, const float* values, float* x,
                  float* scratch);
};

const FactorKernels& factor_kernels(InstructionSet set);
const FactorKernels& linalg_kernels_baseline();
const FactorKernels& linalg_kernels_avx2();
const FactorKernels& linalg_kernels_avx512();

}  // namespace dqa
