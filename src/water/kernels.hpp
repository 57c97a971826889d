// SPDX-License-Identifier: MIT
// Kernels of the water's forces over blocks of 8 faces, one table per instruction set.
#pragma once

#include "grid/precision.hpp"
#include "grid/simd.hpp"

namespace dqa {

// force [face][4] of faces in blocks [begin, end): (cd m + ct n (n.m)) inv_h, m the mean of p over the corners. nodes
// [block][4][8] holds 3 * node; cd, ct [block][8]; n [block][3][8]. In single precision p has one number more than
// 3 n_nodes, whose value does not matter.
template <class T>
using WaterProduct = void (*)(const T* p, const int* nodes, const T* cd, const T* ct, const T* n, double inv_h,
                              int begin, int end, T* force);

struct WaterKernels {
    InBothPrecisions<WaterProduct> product;
};

const WaterKernels& water_kernels(InstructionSet set);
const WaterKernels& water_kernels_baseline();
const WaterKernels& water_kernels_avx2();
const WaterKernels& water_kernels_avx512();

}  // namespace dqa
