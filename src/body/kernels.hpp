// SPDX-License-Identifier: MIT
// Kernels of the body's energies over blocks of 8 cells (structure of arrays), one table per instruction set.
//
// A cell is a Q1 hexahedron with corners 4 ix + 2 iy + iz and 2 x 2 x 2 Gauss points in the same order. `nodes` holds
// 3 * (node index) as [block][8 corners][8 lanes]; forces come out as [block][8 corners][3][8 lanes] and are summed
// onto nodes by NodeGather. Padding lanes repeat a real cell with weight 0.
//
// Corotated energy (e.g. Chao et al. 2010): weight/2 |F - R|^2 per Gauss point, weight = 2 mu V/8, R the rotation
// closest to F with det R = +1. `slab` is added to F_zz: 1 in two dimensions, where the nodes do not span z, else 0.
// Linearisation cache per Gauss point: R (9), K = (tr(S) I - S)^-1 (6), S = R^T F. Muscle energy (Min et al. 2019):
// weight/2 (|F m| - r)^2 per Gauss point. Cache: F m / |F m| (3), c1, c2.
#pragma once

#include "grid/simd.hpp"

namespace dqa {

constexpr int kElasticCache = 8 * 15 * 8;  // doubles per block
constexpr int kMuscleCache = 8 * 5 * 8;
constexpr int kCellForce = 24 * 8;

struct BodyKernels {
    // Energy (per block), forces dE/dq, and the linearisation (NULL: not wanted); inverted counts Gauss points with
    // det F <= 0.
    void (*elastic_gradient)(const double* q, const int* nodes, const double* weight, double inv_dx, double slab,
                             int begin, int end, double* force, double* energy, double* cache, int* inverted);
    // Hessian-vector product from the cache.
    void (*elastic_product)(const double* p, const int* nodes, const double* weight, double inv_dx, int begin, int end,
                            const double* cache, double* force);
    // d(lambda . dE/dq)/d(weight) per cell, [block][8]; cache as of q.
    void (*elastic_weight_bar)(const double* q, const double* lambda, const int* nodes, double inv_dx, double slab,
                               int begin, int end, const double* cache, double* weight_bar);
    // Same three for muscles; direction [block][3][8], rest ratio [block][8].
    void (*muscle_gradient)(const double* q, const int* nodes, const double* direction, const double* weight,
                            const double* rest, double inv_dx, int begin, int end, double* force, double* energy,
                            double* cache);
    void (*muscle_product)(const double* p, const int* nodes, const double* direction, double inv_dx, int begin,
                           int end, const double* cache, double* force);
    // d(lambda . dE/dq)/d(weight) and /d(rest) per entry, [block][8].
    void (*muscle_bar)(const double* q, const double* lambda, const int* nodes, const double* direction,
                       const double* weight, const double* rest, double inv_dx, int begin, int end, double* weight_bar,
                       double* rest_bar);
};

const BodyKernels& body_kernels(InstructionSet set);
const BodyKernels& body_kernels_baseline();
const BodyKernels& body_kernels_avx2();
const BodyKernels& body_kernels_avx512();

// Rotation with det = +1 that maximises tr(R^T F), for any F (inverted, singular); row-major 3 x 3. Scalar, robust:
// the quaternion of the largest eigenvalue of Horn's 4 x 4 matrix (Horn 1987) by cyclic Jacobi sweeps.
void rotation_any(const double f[9], double r[9]);

}  // namespace dqa
