// SPDX-License-Identifier: MIT
// Kernels of the body's energies over blocks of 8 cells (structure of arrays), one table per instruction set.
//
// A cell is a Q1 hexahedron with corners 4 ix + 2 iy + iz and 2 x 2 x 2 Gauss points in the same order. `nodes` holds
// 3 * (node index) as [block][8 corners][8 lanes]; forces are added up on the nodes of a chunk, and those of all chunks
// by ChunkedGather. Padding lanes repeat a real cell with weight 0.
//
// Elastic energies, weight = modulus * V / points, summed over 8 Gauss points or taken at the cell's centre (selective
// reduced integration, which keeps nearly incompressible cells from locking, e.g. Hughes 1987, sec. 4.5):
//   - corotated (e.g. Chao et al. 2010): weight/2 |F - R|^2, weight = 2 mu V/8, R the closest rotation;
//   - its volume term: weight/2 (tr(R^T F) - 3)^2 at the centre, weight = lambda V;
//   - stable neo-Hookean (Smith et al. 2018): weight/2 (I - 3 - log((I + 1)/4)), I = |F|^2, weight = mu V/8;
//   - its volume term: weight/2 (J - alpha)^2 at the centre, weight = lambda V, `shift` = alpha.
// `slab` is added to F_zz: 1 in two dimensions, where the nodes do not span z, else 0.
// Muscle energy (Min et al. 2019): weight/2 (|F m| - r)^2 per Gauss point. Cache: see muscle_kernels.hpp.
#pragma once

#include "grid/node_term.hpp"
#include "grid/precision.hpp"
#include "grid/simd.hpp"

namespace dqa {

constexpr int kMuscleCache = 8 * 3 * 8;

// Hessian-vector products from the cache, in double and in single precision. In single precision p has one number more
// than 3 n_nodes, whose value does not matter.
template <class T>
using ElasticProduct = void (*)(const T* p, const int* nodes, const T* weight, double inv_dx, int begin, int end,
                                const T* cache, const ChunkForces<T>& force);
template <class T>
using MuscleProduct = void (*)(const T* p, const int* nodes, const T* direction, const T* weight, const T* rest,
                               double inv_dx, int begin, int end, const T* cache, const ChunkForces<T>& force);
enum class ElasticKind : int { corotated = 0, corotated_volume = 1, neo_hookean = 2, neo_hookean_volume = 3 };

// Integration of the kinds that are not volume terms: at eight Gauss points as in the paper, or at the cell's centre
// with hourglass control (reduced_kernels.hpp). Volume terms are taken at the centre in both.
enum class Quadrature : int { full = 0, reduced = 1 };

struct ElasticKernels {
    int point_values;  // cached values of a cell; the cache is [block][point_values][8 lanes]
    int points;        // of integration in a cell
    // Energy (per block), forces dE/dq, and the linearisation (NULL: not wanted); inverted counts Gauss points with
    // det F <= 0. shift [block][8]: NULL where the energy has none.
    void (*gradient)(const double* q, const int* nodes, const double* weight, const double* shift, double inv_dx,
                     double slab, int begin, int end, const ChunkForces<double>& force, double* energy, double* cache,
                     int* inverted);
    InBothPrecisions<ElasticProduct> product;
    // d(lambda . dE/dq)/d(weight) and /d(shift) per cell, [block][8]; cache as of q.
    void (*bar)(const double* q, const double* lambda, const int* nodes, const double* weight, const double* shift,
                double inv_dx, double slab, int begin, int end, const double* cache, double* weight_bar,
                double* shift_bar);
    // Makes the cached linearisation positive semi-definite.
    void (*filter)(double* cache, int blocks);
};

struct BodyKernels {
    ElasticKernels elastic[2][4];  // by Quadrature and ElasticKind
    // The same for muscles; direction [block][3][8], rest ratio [block][8].
    void (*muscle_gradient)(const double* q, const int* nodes, const double* direction, const double* weight,
                            const double* rest, double inv_dx, int begin, int end, const ChunkForces<double>& force,
                            double* energy, double* cache);
    InBothPrecisions<MuscleProduct> muscle_product;
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
