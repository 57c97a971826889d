// SPDX-License-Identifier: MIT
// Kernels of the water's forces over blocks of 8 faces, one table per instruction set.
#pragma once

#include "grid/node_term.hpp"
#include "grid/precision.hpp"
#include "grid/simd.hpp"

namespace dqa {

// Of faces in blocks [begin, end): nodes [block][4][8] holds 3 * node; cd, ct, k [block][8]; n, u [block][3][8].

// Adds (cd m + ct n (n.m)) inv_h / 4 to each corner, m the mean of p over the corners. In single precision p has one
// number more than 3 n_nodes, whose value does not matter.
template <class T>
using WaterProduct = void (*)(const T* p, const int* nodes, const T* cd, const T* ct, const T* n, double inv_h,
                              int begin, int end, const ChunkForces<T>& force);

struct WaterKernels {
    // Adds f / 4 to each corner, f = cd v + (ct n.v + k) n. With u+ the mean of (q_new - q_base) / h over the corners
    // less `current`: v = u+, and the energy h (cd |v|^2 / 2 + ct (n.v)^2 / 2 + k n.v). If u is given: v = u, and the
    // energy h f.u+.
    double (*gradient)(const double* q_new, const double* q_base, const int* nodes, const double* cd, const double* ct,
                       const double* k, const double* n, const double* u, const double* current, double h, int begin,
                       int end, const ChunkForces<double>& force);
    InBothPrecisions<WaterProduct> product;
};

const WaterKernels& water_kernels(InstructionSet set);
const WaterKernels& water_kernels_baseline();
const WaterKernels& water_kernels_avx2();
const WaterKernels& water_kernels_avx512();

}  // namespace dqa
