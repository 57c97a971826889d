// SPDX-License-Identifier: MIT
// Kernels of the muscle energy.
#pragma once

#include "body/cell_kernels.hpp"

namespace dqa {
namespace {

template <class T>
inline Vector3<T> along(const GradientOf<T>& f, int gx, int gy, int gz, const Lanes<T> m[3]) {
    return m[0] * f.x[gy][gz] + m[1] * f.y[gx][gz] + m[2] * f.z[gx][gy];
}

template <class T>
inline void add_outer(GradientOf<T>& p, int gx, int gy, int gz, const Lanes<T> m[3], const Vector3<T>& t) {
    p.x[gy][gz] = p.x[gy][gz] + m[0] * t;
    p.y[gx][gz] = p.y[gx][gz] + m[1] * t;
    p.z[gx][gy] = p.z[gx][gy] + m[2] * t;
}

// With l = |F m|, t = F m / l and the rest ratio r, the Hessian of a point is w ((1 - r/l) I + r/l t t^T). The cache
// holds u = sqrt(w |r| / l) t alone, from which it is (w -+ u.u) I +- u u^T with the sign of r: less to read than it
// saves to compute.

// |F m|, kept away from zero: a fibre crushed to a point has no direction.
inline V length_of(const V3& t) {
    return square_root(dot(t, t) + 1e-24);
}

void muscle_gradient(const double* q, const int* nodes, const double* direction, const double* weight,
                     const double* rest, double inv_dx, int begin, int end, const ChunkForces<double>& force,
                     double* energy, double* cache) {
    for (int block = begin; block < end; ++block) {
        double block_energy = 0.0;
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const V w = load(weight + block * kBlock + lane), ratio = load(rest + block * kBlock + lane);
            const double* dir = direction + block * 3 * kBlock + lane;
            const V m[3] = {load(dir), load(dir + kBlock), load(dir + 2 * kBlock)};
            const Gradient f = gradient_of(q, nodes + block * 8 * kBlock + lane, inv_dx);
            Gradient p;
            clear(p);
            V e = V{};
            for (int g = 0; g < 8; ++g) {
                const int gx = g >> 2, gy = g >> 1 & 1, gz = g & 1;
                const V3 t = along(f, gx, gy, gz, m);
                const V length = length_of(t);
                const V stretch = length - ratio;
                e += stretch * stretch;
                const V c1 = w * stretch / length;  // = w (1 - r / l)
                add_outer(p, gx, gy, gz, m, c1 * t);
                if (!cache) continue;
                double* out = cache + (static_cast<long>(block) * 8 + g) * 3 * kBlock + lane;
                const V inv = 1.0 / length, along_fibre = w * ratio * inv;
                const V scale = inv * square_root(select(along_fibre < 0.0, -along_fibre, along_fibre));
                // One crushed to a point has no direction: any will do, but u keeps its size, from which w - u.u comes.
                const Mask crushed = dot(t, t) < 1e-22;
                store(out, scale * select(crushed, length, t.x));
                store(out + kBlock, scale * select(crushed, V{}, t.y));
                store(out + 2 * kBlock, scale * select(crushed, V{}, t.z));
            }
            scatter(p, inv_dx, block, lane, force);
            block_energy += sum_lanes(0.5 * w * e);
        }
        energy[block] = block_energy;
    }
}

template <class T>
void muscle_product(const T* p, const int* nodes, const T* direction, const T* weight, const T* rest, double inv_dx,
                    int begin, int end, const T* cache, const ChunkForces<T>& force) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += Register<T>::lanes) {
            const T* dir = direction + block * 3 * kBlock + lane;
            const Lanes<T> m[3] = {load(dir), load(dir + kBlock), load(dir + 2 * kBlock)};
            const Lanes<T> w = load(weight + block * kBlock + lane), ratio = load(rest + block * kBlock + lane);
            const Lanes<T> one = Lanes<T>{} + T(1);
            const Lanes<T> sign = select(ratio < T(0), -one, one);
            const GradientOf<T> f = gradient_of(p, nodes + block * 8 * kBlock + lane, inv_dx);
            GradientOf<T> s;
            clear(s);
            for (int g = 0; g < 8; ++g) {
                const int gx = g >> 2, gy = g >> 1 & 1, gz = g & 1;
                const T* in = cache + (static_cast<long>(block) * 8 + g) * 3 * kBlock + lane;
                const Vector3<T> u = {load(in), load(in + kBlock), load(in + 2 * kBlock)};
                const Vector3<T> d = along(f, gx, gy, gz, m);
                add_outer(s, gx, gy, gz, m, (w - sign * dot(u, u)) * d + (sign * dot(u, d)) * u);
            }
            scatter(s, inv_dx, block, lane, force);
        }
    }
}

void muscle_bar(const double* q, const double* lambda, const int* nodes, const double* direction, const double* weight,
                const double* rest, double inv_dx, int begin, int end, double* weight_bar, double* rest_bar) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const V w = load(weight + block * kBlock + lane), ratio = load(rest + block * kBlock + lane);
            const double* dir = direction + block * 3 * kBlock + lane;
            const V m[3] = {load(dir), load(dir + kBlock), load(dir + 2 * kBlock)};
            const int* index = nodes + block * 8 * kBlock + lane;
            const Gradient f = gradient_of(q, index, inv_dx), l = gradient_of(lambda, index, inv_dx);
            V wb = V{}, rb = V{};
            for (int g = 0; g < 8; ++g) {
                const int gx = g >> 2, gy = g >> 1 & 1, gz = g & 1;
                const V3 t = along(f, gx, gy, gz, m);
                const V length = length_of(t);
                const V projected = dot(t, along(l, gx, gy, gz, m)) / length;
                wb += (length - ratio) * projected;
                rb -= w * projected;
            }
            store(weight_bar + block * kBlock + lane, wb);
            store(rest_bar + block * kBlock + lane, rb);
        }
    }
}

}  // namespace
}  // namespace dqa
