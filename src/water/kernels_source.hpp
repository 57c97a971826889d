// SPDX-License-Identifier: MIT
// Source of the water's kernels, included once per instruction set with DQA_KERNEL_TABLE naming the table it defines.
#include "grid/simd_vector.hpp"
#include "water/kernels.hpp"

namespace dqa {
namespace {

void product(const double* p, const int* nodes, const double* cd, const double* ct, const double* n, double inv_h,
             int begin, int end, double* force) {
    for (int block = begin; block < end; ++block)
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            V x = V{}, y = V{}, z = V{};
            for (int k = 0; k < 4; ++k) {
                V cx, cy, cz;
                load_three(p, nodes + (4 * block + k) * kBlock + lane, cx, cy, cz);
                x += cx, y += cy, z += cz;
            }
            const double scale = 0.25 * inv_h;
            const double* normal = n + 3 * block * kBlock + lane;
            const V nx = load(normal), ny = load(normal + kBlock), nz = load(normal + 2 * kBlock);
            const V drag = scale * load(cd + block * kBlock + lane);
            const V along = scale * load(ct + block * kBlock + lane) * (nx * x + ny * y + nz * z);
            store_three(force + 4 * (block * kBlock + lane), drag * x + along * nx, drag * y + along * ny,
                        drag * z + along * nz);
        }
}

}  // namespace

const WaterKernels& DQA_KERNEL_TABLE() {
    static const WaterKernels table = {product};
    return table;
}

}  // namespace dqa
