// SPDX-License-Identifier: MIT
// Kernels of the water's forces over blocks of 8 faces, one table per instruction set.
#pragma once

#include <cstdint>

#include "grid/simd.hpp"

namespace dqa {

struct WaterKernels {
    // Forces of the faces in blocks [begin, end), (cd m + ct n (n.m)) inv_h, m the mean of p over the corners: added to
    // all four corners, sum + slots[corner], of their chunk (ChunkedGather).
    // nodes [block][4][8] holds 3 * node; slots alike; cd, ct [block][8], 0 in padding lanes; n [block][3][8].
    void (*product)(const double* p, const int* nodes, const double* cd, const double* ct, const double* n,
                    double inv_h, int begin, int end, const std::uint16_t* slots, double* sum);
};

const WaterKernels& water_kernels(InstructionSet set);
const WaterKernels& water_kernels_baseline();
const WaterKernels& water_kernels_avx2();
const WaterKernels& water_kernels_avx512();

}  // namespace dqa
