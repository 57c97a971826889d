// SPDX-License-Identifier: MIT
// Kernels of the water's forces over blocks of 8 faces, one table per instruction set.
#pragma once

#include "grid/simd.hpp"

namespace dqa {

struct WaterKernels {
    // force [face][4] of faces in blocks [begin, end): (cd m + ct n (n.m)) inv_h, m the mean of p over the corners.
    // nodes [block][4][8] holds 3 * node; cd, ct [block][8]; n [block][3][8].
    void (*product)(const double* p, const int* nodes, const double* cd, const double* ct, const double* n,
                    double inv_h, int begin, int end, double* force);
};

const WaterKernels& water_kernels(InstructionSet set);
const WaterKernels& water_kernels_baseline();
const WaterKernels& water_kernels_avx2();
const WaterKernels& water_kernels_avx512();

}  // namespace dqa
