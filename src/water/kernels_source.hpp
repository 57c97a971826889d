// SPDX-License-Identifier: MIT
// Source of the water's kernels, included once per instruction set with DQA_KERNEL_TABLE naming the table it defines.
#include "grid/simd_vector.hpp"
#include "water/kernels.hpp"

namespace dqa {
namespace {

// To the four corners of the faces from `lane` on.
template <class T>
inline void add_to_corners(const ChunkForces<T>& force, int block, int lane, Lanes<T> x, Lanes<T> y, Lanes<T> z) {
    for (int k = 0; k < 4; ++k) add_three(force.sum, force.slots + (4 * block + k) * kBlock + lane, x, y, z);
}

double gradient(const double* q_new, const double* q_base, const int* nodes, const double* cd, const double* ct,
                const double* k, const double* n, const double* u, const double* current, double h, int begin, int end,
                const ChunkForces<double>& force) {
    double energy = 0.0;
    for (int block = begin; block < end; ++block)
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            V x = V{}, y = V{}, z = V{};
            for (int corner = 0; corner < 4; ++corner) {
                const int* index = nodes + (4 * block + corner) * kBlock + lane;
                V ax, ay, az, bx, by, bz;
                load_three(q_new, index, ax, ay, az);
                load_three(q_base, index, bx, by, bz);
                x += ax - bx, y += ay - by, z += az - bz;
            }
            const double scale = 0.25 / h;
            x = scale * x - current[0], y = scale * y - current[1], z = scale * z - current[2];
            const double* normal = n + 3 * block * kBlock + lane;
            const V nx = load(normal), ny = load(normal + kBlock), nz = load(normal + 2 * kBlock);
            const V drag = load(cd + block * kBlock + lane), thrust = load(ct + block * kBlock + lane);
            const V rest = load(k + block * kBlock + lane);
            const double* lagged = u ? u + 3 * block * kBlock + lane : nullptr;
            const V vx = u ? load(lagged) : x, vy = u ? load(lagged + kBlock) : y,
                    vz = u ? load(lagged + 2 * kBlock) : z;
            const V along = nx * vx + ny * vy + nz * vz, push = thrust * along + rest;
            const V fx = drag * vx + push * nx, fy = drag * vy + push * ny, fz = drag * vz + push * nz;
            const V work = u ? fx * x + fy * y + fz * z
                             : 0.5 * (drag * (x * x + y * y + z * z) + thrust * along * along) + rest * along;
            energy += h * sum_lanes(work);
            add_to_corners<double>(force, block, lane, 0.25 * fx, 0.25 * fy, 0.25 * fz);
        }
    return energy;
}

template <class T>
void product(const T* p, const int* nodes, const T* cd, const T* ct, const T* n, double inv_h, int begin, int end,
             const ChunkForces<T>& force) {
    using W = Lanes<T>;
    for (int block = begin; block < end; ++block)
        for (int lane = 0; lane < kBlock; lane += Register<T>::lanes) {
            W x = W{}, y = W{}, z = W{};
            for (int k = 0; k < 4; ++k) {
                W cx, cy, cz;
                load_three(p, nodes + (4 * block + k) * kBlock + lane, cx, cy, cz);
                x += cx, y += cy, z += cz;
            }
            const T scale = static_cast<T>(0.0625 * inv_h);  // a mean of four, and a quarter of the force
            const T* normal = n + 3 * block * kBlock + lane;
            const W nx = load(normal), ny = load(normal + kBlock), nz = load(normal + 2 * kBlock);
            const W drag = scale * load(cd + block * kBlock + lane);
            const W along = scale * load(ct + block * kBlock + lane) * (nx * x + ny * y + nz * z);
            add_to_corners<T>(force, block, lane, drag * x + along * nx, drag * y + along * ny, drag * z + along * nz);
        }
}

}  // namespace

const WaterKernels& DQA_KERNEL_TABLE() {
    static const WaterKernels table = {gradient, {product<double>, product<float>}};
    return table;
}

}  // namespace dqa
