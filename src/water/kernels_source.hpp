// SPDX-License-Identifier: MIT
// Source of the water's kernels, included once per instruction set with DQA_KERNEL_TABLE naming the table it defines.
#include "grid/simd_vector.hpp"
#include "water/kernels.hpp"

namespace dqa {
namespace {

template <class T>
void product(const T* p, const int* nodes, const T* cd, const T* ct, const T* n, double inv_h, int begin, int end,
             T* force) {
    using W = Lanes<T>;
    for (int block = begin; block < end; ++block)
        for (int lane = 0; lane < kBlock; lane += Register<T>::lanes) {
            W x = W{}, y = W{}, z = W{};
            for (int k = 0; k < 4; ++k) {
                W cx, cy, cz;
                load_three(p, nodes + (4 * block + k) * kBlock + lane, cx, cy, cz);
                x += cx, y += cy, z += cz;
            }
            const T scale = static_cast<T>(0.25 * inv_h);
            const T* normal = n + 3 * block * kBlock + lane;
            const W nx = load(normal), ny = load(normal + kBlock), nz = load(normal + 2 * kBlock);
            const W drag = scale * load(cd + block * kBlock + lane);
            const W along = scale * load(ct + block * kBlock + lane) * (nx * x + ny * y + nz * z);
            store_three(force + 4 * (block * kBlock + lane), drag * x + along * nx, drag * y + along * ny,
                        drag * z + along * nz);
        }
}

}  // namespace

const WaterKernels& DQA_KERNEL_TABLE() {
    static const WaterKernels table = {{product<double>, product<float>}};
    return table;
}

}  // namespace dqa
