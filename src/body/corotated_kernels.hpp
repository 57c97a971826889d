// SPDX-License-Identifier: MIT
// Kernels of corotated elasticity: the shear term at the Gauss points and the volume term at the centre.
#pragma once

#include "body/cell_kernels.hpp"

namespace dqa {
namespace {

constexpr int kCorotatedPoint = 15;  // cached values of a point: R (columns), K

// K = (tr(S) I - S)^-1 of S = sym(R^T F), by cofactors: 00, 11, 22, 01, 02, 12. The matrix is singular only where R is
// not unique (two singular values cancel): bounded there.
struct Twist {
    V k[6];
};

inline Twist twist_of(const V3 c[3], const V3 r[3]) {
    const V s00 = dot(r[0], c[0]), s11 = dot(r[1], c[1]), s22 = dot(r[2], c[2]);
    const V s01 = 0.5 * (dot(r[0], c[1]) + dot(r[1], c[0]));
    const V s02 = 0.5 * (dot(r[0], c[2]) + dot(r[2], c[0]));
    const V s12 = 0.5 * (dot(r[1], c[2]) + dot(r[2], c[1]));
    const V a00 = s11 + s22, a11 = s00 + s22, a22 = s00 + s11;
    const V k00 = a11 * a22 - s12 * s12, k11 = a00 * a22 - s02 * s02, k22 = a00 * a11 - s01 * s01;
    const V k01 = s12 * s02 + s01 * a22, k02 = s01 * s12 + s02 * a11, k12 = s01 * s02 + s12 * a00;
    V da = a00 * k00 - s01 * k01 - s02 * k02;
    const V least = V{} + 1e-9;
    da = select(da > least, da, least);
    const V id = 1.0 / da;
    return {{k00 * id, k11 * id, k22 * id, k01 * id, k02 * id, k12 * id}};
}

inline void store_twist(double* out, const V3 r[3], const Twist& twist) {
    for (int k = 0; k < 3; ++k) {
        store(out + (3 * k) * kBlock, r[k].x);
        store(out + (3 * k + 1) * kBlock, r[k].y);
        store(out + (3 * k + 2) * kBlock, r[k].z);
    }
    for (int k = 0; k < 6; ++k) store(out + (9 + k) * kBlock, twist.k[k]);
}

// dR = R [omega]x with omega = K ax(R^T dF - dF^T R), from the cached R and K.
template <class T>
inline void rotation_change(const T* in, const Vector3<T>& f0, const Vector3<T>& f1, const Vector3<T>& f2,
                            Vector3<T> d[3]) {
    using W = Lanes<T>;
    Vector3<T> r[3];
    load_columns(in, r);
    const W k00 = load(in + 9 * kBlock), k11 = load(in + 10 * kBlock), k22 = load(in + 11 * kBlock);
    const W k01 = load(in + 12 * kBlock), k02 = load(in + 13 * kBlock), k12 = load(in + 14 * kBlock);
    const W u0 = dot(r[2], f1) - dot(r[1], f2), u1 = dot(r[0], f2) - dot(r[2], f0), u2 = dot(r[1], f0) - dot(r[0], f1);
    const W o0 = k00 * u0 + k01 * u1 + k02 * u2, o1 = k01 * u0 + k11 * u1 + k12 * u2,
            o2 = k02 * u0 + k12 * u1 + k22 * u2;
    d[0] = o2 * r[1] - o1 * r[2], d[1] = o0 * r[2] - o2 * r[0], d[2] = o1 * r[0] - o0 * r[1];
}

void corotated_gradient(const double* q, const int* nodes, const double* weight, const double*, double inv_dx,
                        double slab, int begin, int end, const ChunkForces<double>& force, double* energy,
                        double* cache, int* inverted) {
    int n_inverted = 0;
    for (int block = begin; block < end; ++block) {
        double block_energy = 0.0;
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const V w = load(weight + block * kBlock + lane);
            const Gradient f = gradient_of(q, nodes + block * 8 * kBlock + lane, inv_dx, slab);
            Gradient p;
            clear(p);
            V e = V{};
            for (int gx = 0; gx < 2; ++gx)
                for (int gy = 0; gy < 2; ++gy)
                    for (int gz = 0; gz < 2; ++gz) {
                        const V3 c[3] = {f.x[gy][gz], f.y[gx][gz], f.z[gx][gy]};
                        V3 r[3];
                        V det;
                        rotation(c, r, &det);
                        n_inverted += inverted_lanes(det, w);
                        const V3 d0 = c[0] - r[0], d1 = c[1] - r[1], d2 = c[2] - r[2];
                        e += dot(d0, d0) + dot(d1, d1) + dot(d2, d2);
                        p.x[gy][gz] = p.x[gy][gz] + w * d0;
                        p.y[gx][gz] = p.y[gx][gz] + w * d1;
                        p.z[gx][gy] = p.z[gx][gy] + w * d2;
                        if (!cache) continue;
                        const Twist k = twist_of(c, r);
                        double* out =
                            cache + (static_cast<long>(block) * 8 + (4 * gx + 2 * gy + gz)) * kCorotatedPoint * kBlock +
                            lane;
                        store_twist(out, r, k);
                    }
            scatter(p, inv_dx, block, lane, force);
            block_energy += sum_lanes(0.5 * w * e);
        }
        energy[block] = block_energy;
    }
    *inverted += n_inverted;
}

template <class T>
void corotated_product(const T* p, const int* nodes, const T* weight, double inv_dx, int begin, int end, const T* cache,
                       const ChunkForces<T>& force) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += Register<T>::lanes) {
            const Lanes<T> w = load(weight + block * kBlock + lane);
            const GradientOf<T> f = gradient_of(p, nodes + block * 8 * kBlock + lane, inv_dx);
            GradientOf<T> s;
            clear(s);
            for (int gx = 0; gx < 2; ++gx)
                for (int gy = 0; gy < 2; ++gy)
                    for (int gz = 0; gz < 2; ++gz) {
                        const Vector3<T>&f0 = f.x[gy][gz], &f1 = f.y[gx][gz], &f2 = f.z[gx][gy];
                        const T* in =
                            cache + (static_cast<long>(block) * 8 + (4 * gx + 2 * gy + gz)) * kCorotatedPoint * kBlock +
                            lane;
                        Vector3<T> d[3];
                        rotation_change(in, f0, f1, f2, d);
                        const Vector3<T> d0 = f0 - d[0], d1 = f1 - d[1], d2 = f2 - d[2];
                        s.x[gy][gz] = s.x[gy][gz] + d0;
                        s.y[gx][gz] = s.y[gx][gz] + d1;
                        s.z[gx][gy] = s.z[gx][gy] + d2;
                    }
            for (int a = 0; a < 2; ++a)
                for (int b = 0; b < 2; ++b) {
                    s.x[a][b] = w * s.x[a][b];
                    s.y[a][b] = w * s.y[a][b];
                    s.z[a][b] = w * s.z[a][b];
                }
            scatter(s, inv_dx, block, lane, force);
        }
    }
}

void corotated_bar(const double* q, const double* lambda, const int* nodes, const double*, const double*, double inv_dx,
                   double slab, int begin, int end, const double* cache, double* weight_bar, double*) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const int* index = nodes + block * 8 * kBlock + lane;
            const Gradient f = gradient_of(q, index, inv_dx, slab), g = gradient_of(lambda, index, inv_dx);
            V sum = V{};
            for (int gx = 0; gx < 2; ++gx)
                for (int gy = 0; gy < 2; ++gy)
                    for (int gz = 0; gz < 2; ++gz) {
                        const double* in =
                            cache + (static_cast<long>(block) * 8 + (4 * gx + 2 * gy + gz)) * kCorotatedPoint * kBlock +
                            lane;
                        V3 r[3];
                        load_columns(in, r);
                        sum += dot(f.x[gy][gz] - r[0], g.x[gy][gz]) + dot(f.y[gx][gz] - r[1], g.y[gx][gz]) +
                               dot(f.z[gx][gy] - r[2], g.z[gx][gy]);
                    }
            store(weight_bar + block * kBlock + lane, sum);
        }
    }
}

// ---------------------------------------------------------------- volume term

constexpr int kVolumePoint = 16;  // R, K, tr(R^T F) - 3

// Deformation gradient at the cell's centre: the mean over the Gauss points.
template <class T>
inline void at_centre(const GradientOf<T>& f, Vector3<T> c[3]) {
    c[0] = 0.25 * (f.x[0][0] + f.x[0][1] + (f.x[1][0] + f.x[1][1]));
    c[1] = 0.25 * (f.y[0][0] + f.y[0][1] + (f.y[1][0] + f.y[1][1]));
    c[2] = 0.25 * (f.z[0][0] + f.z[0][1] + (f.z[1][0] + f.z[1][1]));
}

// Its transpose: the stress at the centre as one at the Gauss points.
template <class T>
inline GradientOf<T> from_centre(const Vector3<T> p[3]) {
    GradientOf<T> g;
    for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b) g.x[a][b] = 0.25 * p[0], g.y[a][b] = 0.25 * p[1], g.z[a][b] = 0.25 * p[2];
    return g;
}

void volume_gradient(const double* q, const int* nodes, const double* weight, const double*, double inv_dx, double slab,
                     int begin, int end, const ChunkForces<double>& force, double* energy, double* cache, int*) {
    for (int block = begin; block < end; ++block) {
        double block_energy = 0.0;
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const V w = load(weight + block * kBlock + lane);
            V3 c[3], r[3];
            at_centre(gradient_of(q, nodes + block * 8 * kBlock + lane, inv_dx, slab), c);
            V det;
            rotation(c, r, &det);
            const V trace = dot(r[0], c[0]) + dot(r[1], c[1]) + dot(r[2], c[2]) - 3.0;
            const V3 p[3] = {(w * trace) * r[0], (w * trace) * r[1], (w * trace) * r[2]};
            scatter(from_centre(p), inv_dx, block, lane, force);
            block_energy += sum_lanes(0.5 * w * trace * trace);
            if (!cache) continue;
            double* out = cache + static_cast<long>(block) * kVolumePoint * kBlock + lane;
            store_twist(out, r, twist_of(c, r));
            store(out + 15 * kBlock, trace);
        }
        energy[block] = block_energy;
    }
}

// d tr(R^T F) = R : dF, because R^T F is symmetric.
template <class T>
void volume_product(const T* p, const int* nodes, const T* weight, double inv_dx, int begin, int end, const T* cache,
                    const ChunkForces<T>& force) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += Register<T>::lanes) {
            const Lanes<T> w = load(weight + block * kBlock + lane);
            Vector3<T> f[3], d[3];
            at_centre(gradient_of(p, nodes + block * 8 * kBlock + lane, inv_dx), f);
            const T* in = cache + static_cast<long>(block) * kVolumePoint * kBlock + lane;
            rotation_change(in, f[0], f[1], f[2], d);
            Vector3<T> r[3];
            load_columns(in, r);
            const Lanes<T> change = w * (dot(r[0], f[0]) + dot(r[1], f[1]) + dot(r[2], f[2]));
            const Lanes<T> trace = w * load(in + 15 * kBlock);
            const Vector3<T> s[3] = {change * r[0] + trace * d[0], change * r[1] + trace * d[1],
                                     change * r[2] + trace * d[2]};
            scatter(from_centre(s), inv_dx, block, lane, force);
        }
    }
}

void volume_bar(const double*, const double* lambda, const int* nodes, const double*, const double*, double inv_dx,
                double, int begin, int end, const double* cache, double* weight_bar, double*) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            V3 g[3];
            at_centre(gradient_of(lambda, nodes + block * 8 * kBlock + lane, inv_dx), g);
            const double* in = cache + static_cast<long>(block) * kVolumePoint * kBlock + lane;
            V3 r[3];
            load_columns(in, r);
            const V sum = dot(r[0], g[0]) + dot(r[1], g[1]) + dot(r[2], g[2]);
            store(weight_bar + block * kBlock + lane, load(in + 15 * kBlock) * sum);
        }
    }
}

// ---------------------------------------------------------------- positive semi-definite linearisations

// The twist stiffness of |F - R|^2 along an eigenvector of K with eigenvalue k is weight (1 - 2 k): bounded by scaling
// K so that its Frobenius norm, an upper bound of k, stays <= 1/2.
inline void filter_twists(double* cache, long points) {
    for (long at = 0; at < points; ++at)
        for (int l = 0; l < kBlock; ++l) {
            double* k = cache + (at * kCorotatedPoint + 9) * kBlock + l;
            const double norm2 =
                k[0] * k[0] + k[8] * k[8] + k[16] * k[16] + 2.0 * (k[24] * k[24] + k[32] * k[32] + k[40] * k[40]);
            if (norm2 <= 0.25) continue;
            const double scale = 0.5 / __builtin_sqrt(norm2);
            for (int c = 0; c < 6; ++c) k[8 * c] *= scale;
        }
}

void corotated_filter(double* cache, int blocks) {
    filter_twists(cache, static_cast<long>(blocks) * 8);
}

// Compressed cells lose the term with dR, whose sign is that of the trace. (Where K itself is not positive, R jumps.)
void volume_filter(double* cache, int blocks) {
    for (long block = 0; block < blocks; ++block)
        for (int l = 0; l < kBlock; ++l) {
            double* point = cache + block * kVolumePoint * kBlock + l;
            const double k00 = point[9 * kBlock], k11 = point[10 * kBlock], k22 = point[11 * kBlock];
            if (point[15 * kBlock] < 0 || k00 < 0 || k11 < 0 || k22 < 0) point[15 * kBlock] = 0.0;
        }
}

}  // namespace
}  // namespace dqa
