// SPDX-License-Identifier: MIT
// Kernels of the stable neo-Hookean material (Smith, de Goes & Kim 2018): at the Gauss points
// weight/2 (I - 3 - log((I + 1) / 4)), I = |F|^2; at the centre weight/2 (J - alpha)^2, J = det F.
#pragma once

#include "body/corotated_kernels.hpp"

namespace dqa {
namespace {

constexpr int kNeoPoint = 11;       // F, 1 - 1 / (I + 1), 2 / (I + 1)^2
constexpr int kJacobianPoint = 11;  // F, J - alpha, and the same as the weight of the geometric term

inline V natural_log(V v) {
    for (int l = 0; l < kLanes; ++l) v[l] = __builtin_log(v[l]);
    return v;
}

inline void store_columns(double* out, const V3 c[3]) {
    for (int k = 0; k < 3; ++k) {
        store(out + 3 * k * kBlock, c[k].x);
        store(out + (3 * k + 1) * kBlock, c[k].y);
        store(out + (3 * k + 2) * kBlock, c[k].z);
    }
}

void neo_gradient(const double* q, const int* nodes, const double* weight, const double*, double inv_dx, double slab,
                  int begin, int end, const ChunkForces<double>& force, double* energy, double* cache, int* inverted) {
    int n_inverted = 0;
    for (int block = begin; block < end; ++block) {
        double block_energy = 0.0;
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const V w = load(weight + block * kBlock + lane);
            const Gradient f = gradient_of(q, nodes + block * 8 * kBlock + lane, inv_dx, slab);
            Gradient p;
            clear(p);
            V e = V{};
            for (int g = 0; g < 8; ++g) {
                const int gx = g >> 2, gy = g >> 1 & 1, gz = g & 1;
                const V3 c[3] = {f.x[gy][gz], f.y[gx][gz], f.z[gx][gy]};
                const V det = dot(c[0], cross(c[1], c[2]));
                n_inverted += inverted_lanes(det, w);
                const V size = dot(c[0], c[0]) + dot(c[1], c[1]) + dot(c[2], c[2]);
                const V inv = 1.0 / (size + 1.0), a = 1.0 - inv;
                e += size - 3.0 - natural_log(0.25 * (size + 1.0));
                p.x[gy][gz] = p.x[gy][gz] + (w * a) * c[0];
                p.y[gx][gz] = p.y[gx][gz] + (w * a) * c[1];
                p.z[gx][gy] = p.z[gx][gy] + (w * a) * c[2];
                if (!cache) continue;
                double* out = cache + (static_cast<long>(block) * 8 + g) * kNeoPoint * kBlock + lane;
                store_columns(out, c);
                store(out + 9 * kBlock, a);
                store(out + 10 * kBlock, 2.0 * inv * inv);
            }
            scatter(p, inv_dx, block, lane, force);
            block_energy += sum_lanes(0.5 * w * e);
        }
        energy[block] = block_energy;
    }
    *inverted += n_inverted;
}

template <class T>
void neo_product(const T* p, const int* nodes, const T* weight, double inv_dx, int begin, int end, const T* cache,
                 const ChunkForces<T>& force) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += Register<T>::lanes) {
            const Lanes<T> w = load(weight + block * kBlock + lane);
            const GradientOf<T> f = gradient_of(p, nodes + block * 8 * kBlock + lane, inv_dx);
            GradientOf<T> s;
            clear(s);
            for (int g = 0; g < 8; ++g) {
                const int gx = g >> 2, gy = g >> 1 & 1, gz = g & 1;
                const Vector3<T> d[3] = {f.x[gy][gz], f.y[gx][gz], f.z[gx][gy]};
                const T* in = cache + (static_cast<long>(block) * 8 + g) * kNeoPoint * kBlock + lane;
                Vector3<T> c[3];
                load_columns(in, c);
                const Lanes<T> a = w * load(in + 9 * kBlock);
                const Lanes<T> b = w * load(in + 10 * kBlock) * (dot(c[0], d[0]) + dot(c[1], d[1]) + dot(c[2], d[2]));
                s.x[gy][gz] = s.x[gy][gz] + (a * d[0] + b * c[0]);
                s.y[gx][gz] = s.y[gx][gz] + (a * d[1] + b * c[1]);
                s.z[gx][gy] = s.z[gx][gy] + (a * d[2] + b * c[2]);
            }
            scatter(s, inv_dx, block, lane, force);
        }
    }
}

void neo_bar(const double*, const double* lambda, const int* nodes, const double*, const double*, double inv_dx, double,
             int begin, int end, const double* cache, double* weight_bar, double*) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const Gradient l = gradient_of(lambda, nodes + block * 8 * kBlock + lane, inv_dx);
            V sum = V{};
            for (int g = 0; g < 8; ++g) {
                const int gx = g >> 2, gy = g >> 1 & 1, gz = g & 1;
                const double* in = cache + (static_cast<long>(block) * 8 + g) * kNeoPoint * kBlock + lane;
                V3 c[3];
                load_columns(in, c);
                sum +=
                    load(in + 9 * kBlock) * (dot(c[0], l.x[gy][gz]) + dot(c[1], l.y[gx][gz]) + dot(c[2], l.z[gx][gy]));
            }
            store(weight_bar + block * kBlock + lane, sum);
        }
    }
}

// The linearisation is positive definite as it stands.
void neo_filter(double*, int) {}

// ---------------------------------------------------------------- volume term

void jacobian_gradient(const double* q, const int* nodes, const double* weight, const double* shift, double inv_dx,
                       double slab, int begin, int end, const ChunkForces<double>& force, double* energy, double* cache,
                       int*) {
    for (int block = begin; block < end; ++block) {
        double block_energy = 0.0;
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const V w = load(weight + block * kBlock + lane);
            V3 c[3];
            at_centre(gradient_of(q, nodes + block * 8 * kBlock + lane, inv_dx, slab), c);
            const V3 k[3] = {cross(c[1], c[2]), cross(c[2], c[0]), cross(c[0], c[1])};
            const V alpha = load(shift + block * kBlock + lane), excess = dot(c[0], k[0]) - alpha;
            const V3 p[3] = {(w * excess) * k[0], (w * excess) * k[1], (w * excess) * k[2]};
            scatter(from_centre(p), inv_dx, block, lane, force);
            block_energy += sum_lanes(0.5 * w * (excess * excess - (1.0 - alpha) * (1.0 - alpha)));  // 0 at rest
            if (!cache) continue;
            double* out = cache + static_cast<long>(block) * kJacobianPoint * kBlock + lane;
            store_columns(out, c);
            store(out + 9 * kBlock, excess);
            store(out + 10 * kBlock, excess);
        }
        energy[block] = block_energy;
    }
}

template <class T>
void jacobian_product(const T* p, const int* nodes, const T* weight, double inv_dx, int begin, int end, const T* cache,
                      const ChunkForces<T>& force) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += Register<T>::lanes) {
            const Lanes<T> w = load(weight + block * kBlock + lane);
            Vector3<T> d[3], c[3];
            at_centre(gradient_of(p, nodes + block * 8 * kBlock + lane, inv_dx), d);
            const T* in = cache + static_cast<long>(block) * kJacobianPoint * kBlock + lane;
            load_columns(in, c);
            const Vector3<T> k[3] = {cross(c[1], c[2]), cross(c[2], c[0]), cross(c[0], c[1])};
            const Lanes<T> change = w * (dot(k[0], d[0]) + dot(k[1], d[1]) + dot(k[2], d[2]));
            const Lanes<T> geometric = w * load(in + 10 * kBlock);
            const Vector3<T> s[3] = {change * k[0] + geometric * (cross(d[1], c[2]) + cross(c[1], d[2])),
                                     change * k[1] + geometric * (cross(d[2], c[0]) + cross(c[2], d[0])),
                                     change * k[2] + geometric * (cross(d[0], c[1]) + cross(c[0], d[1]))};
            scatter(from_centre(s), inv_dx, block, lane, force);
        }
    }
}

void jacobian_bar(const double*, const double* lambda, const int* nodes, const double* weight, const double*,
                  double inv_dx, double, int begin, int end, const double* cache, double* weight_bar,
                  double* shift_bar) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            V3 d[3], c[3];
            at_centre(gradient_of(lambda, nodes + block * 8 * kBlock + lane, inv_dx), d);
            const double* in = cache + static_cast<long>(block) * kJacobianPoint * kBlock + lane;
            load_columns(in, c);
            const V projected =
                dot(cross(c[1], c[2]), d[0]) + dot(cross(c[2], c[0]), d[1]) + dot(cross(c[0], c[1]), d[2]);
            store(weight_bar + block * kBlock + lane, load(in + 9 * kBlock) * projected);
            store(shift_bar + block * kBlock + lane, -load(weight + block * kBlock + lane) * projected);
        }
    }
}

// Without the geometric term what is left is weight cof F (x) cof F.
void jacobian_filter(double* cache, int blocks) {
    for (long block = 0; block < blocks; ++block)
        for (int l = 0; l < kBlock; ++l) cache[(block * kJacobianPoint + 10) * kBlock + l] = 0.0;
}

}  // namespace
}  // namespace dqa
