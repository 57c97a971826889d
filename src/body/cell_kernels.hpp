// SPDX-License-Identifier: MIT
// What the kernels of all energies share: the deformation gradient of a block of cells, its transpose, and the rotation
// nearest to it. Part of the sources that are compiled once per instruction set: see kernels_source.hpp.
#pragma once

#include "body/kernels.hpp"
#include "grid/simd_vector.hpp"

namespace dqa {
namespace {

template <class T>
struct Vector3 {
    Lanes<T> x, y, z;
};
using V3 = Vector3<double>;
template <class T>
inline Vector3<T> operator+(const Vector3<T>& a, const Vector3<T>& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
inline Vector3<T> operator-(const Vector3<T>& a, const Vector3<T>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
inline Vector3<T> operator*(Lanes<T> s, const Vector3<T>& a) {
    return {s * a.x, s * a.y, s * a.z};
}
template <class T>
inline Vector3<T> operator*(double s, const Vector3<T>& a) {
    const T factor = static_cast<T>(s);
    return {factor * a.x, factor * a.y, factor * a.z};
}
template <class T>
inline Lanes<T> dot(const Vector3<T>& a, const Vector3<T>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
inline Vector3<T> cross(const Vector3<T>& a, const Vector3<T>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// Three vectors of a cache, by columns.
template <class T>
inline void load_columns(const T* in, Vector3<T> c[3]) {
    for (int k = 0; k < 3; ++k)
        c[k] = {load(in + 3 * k * kBlock), load(in + (3 * k + 1) * kBlock), load(in + (3 * k + 2) * kBlock)};
}

// Linear shape functions at the two Gauss points of an axis: (1 +- 1/sqrt 3) / 2.
constexpr double kNear = 0.78867513459481288225, kFar = 0.21132486540518711775;
inline double shape(int gauss, int node) {
    return gauss == node ? kNear : kFar;
}

// Columns of F at the Gauss points. dF/dX along an axis does not depend on that axis's own Gauss coordinate, so four
// values per axis serve all eight points (sum factorisation): x[gy][gz], y[gx][gz], z[gx][gy].
template <class T>
struct GradientOf {
    Vector3<T> x[2][2], y[2][2], z[2][2];
};
using Gradient = GradientOf<double>;

template <class T>
inline void interpolate(const Vector3<T> edge[2][2], double scale, Vector3<T> out[2][2]) {
    Vector3<T> half[2][2];
    for (int a = 0; a < 2; ++a)
        for (int g = 0; g < 2; ++g)
            half[a][g] = (scale * shape(g, 0)) * edge[a][0] + (scale * shape(g, 1)) * edge[a][1];
    for (int h = 0; h < 2; ++h)
        for (int g = 0; g < 2; ++g) out[h][g] = shape(h, 0) * half[0][g] + shape(h, 1) * half[1][g];
}

template <class T>
inline GradientOf<T> gradient_of(const T* q, const int* nodes, double inv_dx, double slab = 0.0) {
    Vector3<T> c[8];
    for (int k = 0; k < 8; ++k) {
        const int* index = nodes + k * kBlock;
        load_three(q, index, c[k].x, c[k].y, c[k].z);
    }
    GradientOf<T> f;
    const Vector3<T> ex[2][2] = {{c[4] - c[0], c[5] - c[1]}, {c[6] - c[2], c[7] - c[3]}};
    const Vector3<T> ey[2][2] = {{c[2] - c[0], c[3] - c[1]}, {c[6] - c[4], c[7] - c[5]}};
    const Vector3<T> ez[2][2] = {{c[1] - c[0], c[3] - c[2]}, {c[5] - c[4], c[7] - c[6]}};
    interpolate(ex, inv_dx, f.x);
    interpolate(ey, inv_dx, f.y);
    interpolate(ez, inv_dx, f.z);
    for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b) f.z[a][b].z += static_cast<T>(slab);
    return f;
}

// Transpose of gradient_of: adds the stress sums of the Gauss points onto the corners of the cells from `lane` on.
template <class T>
inline void scatter(const GradientOf<T>& p, double inv_dx, int block, int lane, const ChunkForces<T>& out) {
    const std::uint16_t* slots = out.slots + static_cast<long>(block) * 8 * kBlock + lane;
    Vector3<T> ex[2][2], ey[2][2], ez[2][2];
    interpolate(p.x, inv_dx, ex);  // the matrix of `interpolate` is symmetric (near on the diagonal)
    interpolate(p.y, inv_dx, ey);
    interpolate(p.z, inv_dx, ez);
    for (int ix = 0; ix < 2; ++ix)
        for (int iy = 0; iy < 2; ++iy)
            for (int iz = 0; iz < 2; ++iz) {
                const double sx = ix ? 1.0 : -1.0, sy = iy ? 1.0 : -1.0, sz = iz ? 1.0 : -1.0;
                const Vector3<T> f = sx * ex[iy][iz] + sy * ey[ix][iz] + sz * ez[ix][iy];
                add_three(out.sum, slots + (4 * ix + 2 * iy + iz) * kBlock, f.x, f.y, f.z);
            }
}

template <class T>
inline void clear(GradientOf<T>& g) {
    const Lanes<T> zero = Lanes<T>{};
    for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b) g.x[a][b] = g.y[a][b] = g.z[a][b] = {zero, zero, zero};
}

// Lanes of real cells (weight > 0) that are turned inside out.
inline int inverted_lanes(V det, V weight) {
    int count = 0;
    if (min_lanes(det) <= 0.0)
        for (int l = 0; l < kLanes; ++l) count += (det[l] <= 0.0 && weight[l] > 0.0) ? 1 : 0;
    return count;
}

// Rotation nearest to F (columns f): Newton iteration for the polar factor X <- (g X + X^-T / g) / 2 with Frobenius
// scaling g (Higham 1986), run until every lane has converged to rounding; lanes with det F near or below zero take
// the scalar path, which yields det = +1.
inline void rotation(const V3 f[3], V3 r[3], V* det_out) {
    r[0] = f[0], r[1] = f[1], r[2] = f[2];
    const V det0 = dot(f[0], cross(f[1], f[2]));
    *det_out = det0;
    const V size0 = dot(f[0], f[0]) + dot(f[1], f[1]) + dot(f[2], f[2]);
    const Mask regular = det0 > 1e-6 * size0 * square_root(size0);
    const V zero = V{}, one = zero + 1.0;
    // Irregular lanes iterate on the identity so that they do not hold the others up.
    for (int k = 0; k < 3; ++k) {
        r[k].x = select(regular, r[k].x, k == 0 ? one : zero);
        r[k].y = select(regular, r[k].y, k == 1 ? one : zero);
        r[k].z = select(regular, r[k].z, k == 2 ? one : zero);
    }
    for (int iteration = 0; iteration < 40; ++iteration) {
        const V3 c0 = cross(r[1], r[2]), c1 = cross(r[2], r[0]), c2 = cross(r[0], r[1]);
        const V inv = one / dot(r[0], c0);
        const V norm_x = dot(r[0], r[0]) + dot(r[1], r[1]) + dot(r[2], r[2]);
        const V norm_i = (dot(c0, c0) + dot(c1, c1) + dot(c2, c2)) * inv * inv;
        const V g2 = square_root(norm_i / norm_x);  // g^2
        const V g = square_root(g2);
        const V a = 0.5 * g, b = 0.5 * inv / g;
        const V3 n0 = a * r[0] + b * c0, n1 = a * r[1] + b * c1, n2 = a * r[2] + b * c2;
        const V3 d0 = n0 - r[0], d1 = n1 - r[1], d2 = n2 - r[2];
        const V change = dot(d0, d0) + dot(d1, d1) + dot(d2, d2);
        r[0] = n0, r[1] = n1, r[2] = n2;
        if (max_lanes(change) < 1e-17) break;  // quadratic: the error is then below 1e-17 itself
    }
    bool all = true;
    for (int l = 0; l < kLanes; ++l) all = all && regular[l] != 0;
    if (!all) {
        for (int l = 0; l < kLanes; ++l) {
            if (regular[l]) continue;
            const double m[9] = {f[0].x[l], f[1].x[l], f[2].x[l], f[0].y[l], f[1].y[l],
                                 f[2].y[l], f[0].z[l], f[1].z[l], f[2].z[l]};
            double o[9];
            rotation_any(m, o);
            for (int k = 0; k < 3; ++k) r[k].x[l] = o[k], r[k].y[l] = o[3 + k], r[k].z[l] = o[6 + k];
        }
    }
}

}  // namespace
}  // namespace dqa
