// SPDX-License-Identifier: MIT
// Loops of a step over the nodes, one table per instruction set: what inertia, tissue, muscles and water do to a node,
// summed up in one pass.
#pragma once

#include "grid/node_term.hpp"
#include "grid/precision.hpp"
#include "grid/simd.hpp"

namespace dqa {

// Conjugate gradients' new direction and its product, from forces = those of the elements at z, on nodes [begin, end):
//   ap = beta ap + free (inv_b2 mass z + forces),  p = z + beta p;  returns p.ap.
// mass [n]; vectors [n][3]. With beta = 0 the old ap and p are not read. free: 0 or 1 for each coordinate, null for
// all 1; p null: ap is the product with z, and z.ap is returned.
template <class T>
using DirectKernel = double (*)(const NodeTerm<T>* forces, int n_forces, const double* mass, double inv_b2,
                                const double* free, const T* z, T beta, int begin, int end, T* p, T* ap);

// Where the forces of each kind end in the list: tissue, then muscles, then water.
struct ForceGroups {
    int tissue, muscles, water;
};
// Energy of inertia, and squared norms.
struct ForceSums {
    double energy = 0.0, inertia2 = 0.0, water2 = 0.0, elastic2 = 0.0, muscle2 = 0.0, total2 = 0.0;
    void operator+=(const ForceSums& o) {
        energy += o.energy, inertia2 += o.inertia2, water2 += o.water2;
        elastic2 += o.elastic2, muscle2 += o.muscle2, total2 += o.total2;
    }
};

struct StepKernels {
    InBothPrecisions<DirectKernel> direct;
    // gradient = free (inv_b2 mass (q - y) + forces) on nodes [begin, end), and the sums over them.
    void (*balance)(const NodeTerm<double>* forces, const ForceGroups& groups, const double* mass, double inv_b2,
                    const double* q, const double* y, const double* free, int begin, int end, double* gradient,
                    ForceSums& sums);
};

const StepKernels& step_kernels(InstructionSet set);
const StepKernels& step_kernels_baseline();
const StepKernels& step_kernels_avx2();
const StepKernels& step_kernels_avx512();

}  // namespace dqa
