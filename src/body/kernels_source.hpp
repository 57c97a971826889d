// SPDX-License-Identifier: MIT
// Source of the body kernels, included once per instruction set (kernels_baseline.cpp, _avx2.cpp, _avx512.cpp) with
// DQA_KERNEL_TABLE naming the table it defines. See kernels.hpp for the layouts and formulas.
#include "body/kernels.hpp"
#include "grid/simd_vector.hpp"

namespace dqa {
namespace {

struct V3 {
    V x, y, z;
};
inline V3 operator+(const V3& a, const V3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline V3 operator-(const V3& a, const V3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline V3 operator*(V s, const V3& a) {
    return {s * a.x, s * a.y, s * a.z};
}
inline V3 operator*(double s, const V3& a) {
    return {s * a.x, s * a.y, s * a.z};
}
inline V dot(const V3& a, const V3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline V3 cross(const V3& a, const V3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Linear shape functions at the two Gauss points of an axis: (1 +- 1/sqrt 3) / 2.
constexpr double kNear = 0.78867513459481288225, kFar = 0.21132486540518711775;
inline double shape(int gauss, int node) {
    return gauss == node ? kNear : kFar;
}

// Columns of F at the Gauss points. dF/dX along an axis does not depend on that axis's own Gauss coordinate, so four
// values per axis serve all eight points (sum factorisation): x[gy][gz], y[gx][gz], z[gx][gy].
struct Gradient {
    V3 x[2][2], y[2][2], z[2][2];
};

inline void interpolate(const V3 edge[2][2], double scale, V3 out[2][2]) {
    V3 half[2][2];
    for (int a = 0; a < 2; ++a)
        for (int g = 0; g < 2; ++g)
            half[a][g] = (scale * shape(g, 0)) * edge[a][0] + (scale * shape(g, 1)) * edge[a][1];
    for (int h = 0; h < 2; ++h)
        for (int g = 0; g < 2; ++g) out[h][g] = shape(h, 0) * half[0][g] + shape(h, 1) * half[1][g];
}

inline Gradient gradient_of(const double* q, const int* nodes, double inv_dx, double slab = 0.0) {
    V3 c[8];
    for (int k = 0; k < 8; ++k) {
        const int* index = nodes + k * kBlock;
        c[k] = {gather(q, index), gather(q + 1, index), gather(q + 2, index)};
    }
    Gradient f;
    const V3 ex[2][2] = {{c[4] - c[0], c[5] - c[1]}, {c[6] - c[2], c[7] - c[3]}};
    const V3 ey[2][2] = {{c[2] - c[0], c[3] - c[1]}, {c[6] - c[4], c[7] - c[5]}};
    const V3 ez[2][2] = {{c[1] - c[0], c[3] - c[2]}, {c[5] - c[4], c[7] - c[6]}};
    interpolate(ex, inv_dx, f.x);
    interpolate(ey, inv_dx, f.y);
    interpolate(ez, inv_dx, f.z);
    for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b) f.z[a][b].z += slab;
    return f;
}

// Transpose of gradient_of: adds the stress sums of the Gauss points onto the corners.
inline void scatter(const Gradient& p, double inv_dx, double* force) {
    V3 ex[2][2], ey[2][2], ez[2][2];
    interpolate(p.x, inv_dx, ex);  // the matrix of `interpolate` is symmetric (near on the diagonal)
    interpolate(p.y, inv_dx, ey);
    interpolate(p.z, inv_dx, ez);
    for (int ix = 0; ix < 2; ++ix)
        for (int iy = 0; iy < 2; ++iy)
            for (int iz = 0; iz < 2; ++iz) {
                const double sx = ix ? 1.0 : -1.0, sy = iy ? 1.0 : -1.0, sz = iz ? 1.0 : -1.0;
                const V3 f = sx * ex[iy][iz] + sy * ey[ix][iz] + sz * ez[ix][iy];
                double* out = force + (4 * ix + 2 * iy + iz) * 3 * kBlock;
                store(out, f.x);
                store(out + kBlock, f.y);
                store(out + 2 * kBlock, f.z);
            }
}

inline void clear(Gradient& g) {
    const V zero = V{};
    for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b) g.x[a][b] = g.y[a][b] = g.z[a][b] = {zero, zero, zero};
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

void elastic_gradient(const double* q, const int* nodes, const double* weight, double inv_dx, double slab, int begin,
                      int end, double* force, double* energy, double* cache, int* inverted) {
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
                        if (min_lanes(det) <= 0.0)
                            for (int l = 0; l < kLanes; ++l) n_inverted += (det[l] <= 0.0 && w[l] > 0.0) ? 1 : 0;
                        const V3 d0 = c[0] - r[0], d1 = c[1] - r[1], d2 = c[2] - r[2];
                        e += dot(d0, d0) + dot(d1, d1) + dot(d2, d2);
                        p.x[gy][gz] = p.x[gy][gz] + w * d0;
                        p.y[gx][gz] = p.y[gx][gz] + w * d1;
                        p.z[gx][gy] = p.z[gx][gy] + w * d2;
                        if (!cache) continue;
                        // A = tr(S) I - S, S = sym(R^T F); K = A^-1 by cofactors. A is singular only where R is not
                        // unique (two singular values cancel): bounded there.
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
                        double* out =
                            cache + (static_cast<long>(block) * 8 + (4 * gx + 2 * gy + gz)) * 15 * kBlock + lane;
                        for (int k = 0; k < 3; ++k) {
                            store(out + (3 * k) * kBlock, r[k].x);
                            store(out + (3 * k + 1) * kBlock, r[k].y);
                            store(out + (3 * k + 2) * kBlock, r[k].z);
                        }
                        store(out + 9 * kBlock, k00 * id);
                        store(out + 10 * kBlock, k11 * id);
                        store(out + 11 * kBlock, k22 * id);
                        store(out + 12 * kBlock, k01 * id);
                        store(out + 13 * kBlock, k02 * id);
                        store(out + 14 * kBlock, k12 * id);
                    }
            scatter(p, inv_dx, force + static_cast<long>(block) * kCellForce + lane);
            block_energy += sum_lanes(0.5 * w * e);
        }
        energy[block] = block_energy;
    }
    *inverted += n_inverted;
}

void elastic_product(const double* p, const int* nodes, const double* weight, double inv_dx, int begin, int end,
                     const double* cache, double* force) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const V w = load(weight + block * kBlock + lane);
            const Gradient f = gradient_of(p, nodes + block * 8 * kBlock + lane, inv_dx);
            Gradient s;
            clear(s);
            for (int gx = 0; gx < 2; ++gx)
                for (int gy = 0; gy < 2; ++gy)
                    for (int gz = 0; gz < 2; ++gz) {
                        const V3 &f0 = f.x[gy][gz], &f1 = f.y[gx][gz], &f2 = f.z[gx][gy];
                        const double* in =
                            cache + (static_cast<long>(block) * 8 + (4 * gx + 2 * gy + gz)) * 15 * kBlock + lane;
                        const V3 r0 = {load(in), load(in + kBlock), load(in + 2 * kBlock)};
                        const V3 r1 = {load(in + 3 * kBlock), load(in + 4 * kBlock), load(in + 5 * kBlock)};
                        const V3 r2 = {load(in + 6 * kBlock), load(in + 7 * kBlock), load(in + 8 * kBlock)};
                        const V k00 = load(in + 9 * kBlock), k11 = load(in + 10 * kBlock), k22 = load(in + 11 * kBlock);
                        const V k01 = load(in + 12 * kBlock), k02 = load(in + 13 * kBlock),
                                k12 = load(in + 14 * kBlock);
                        // dR = R [omega]x with omega = K ax(R^T dF - dF^T R).
                        const V u0 = dot(r2, f1) - dot(r1, f2), u1 = dot(r0, f2) - dot(r2, f0),
                                u2 = dot(r1, f0) - dot(r0, f1);
                        const V o0 = k00 * u0 + k01 * u1 + k02 * u2, o1 = k01 * u0 + k11 * u1 + k12 * u2,
                                o2 = k02 * u0 + k12 * u1 + k22 * u2;
                        const V3 d0 = f0 - (o2 * r1 - o1 * r2), d1 = f1 - (o0 * r2 - o2 * r0),
                                 d2 = f2 - (o1 * r0 - o0 * r1);
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
            scatter(s, inv_dx, force + static_cast<long>(block) * kCellForce + lane);
        }
    }
}

void elastic_weight_bar(const double* q, const double* lambda, const int* nodes, double inv_dx, double slab, int begin,
                        int end, const double* cache, double* weight_bar) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const int* index = nodes + block * 8 * kBlock + lane;
            const Gradient f = gradient_of(q, index, inv_dx, slab), g = gradient_of(lambda, index, inv_dx);
            V sum = V{};
            for (int gx = 0; gx < 2; ++gx)
                for (int gy = 0; gy < 2; ++gy)
                    for (int gz = 0; gz < 2; ++gz) {
                        const double* in =
                            cache + (static_cast<long>(block) * 8 + (4 * gx + 2 * gy + gz)) * 15 * kBlock + lane;
                        const V3 r0 = {load(in), load(in + kBlock), load(in + 2 * kBlock)};
                        const V3 r1 = {load(in + 3 * kBlock), load(in + 4 * kBlock), load(in + 5 * kBlock)};
                        const V3 r2 = {load(in + 6 * kBlock), load(in + 7 * kBlock), load(in + 8 * kBlock)};
                        sum += dot(f.x[gy][gz] - r0, g.x[gy][gz]) + dot(f.y[gx][gz] - r1, g.y[gx][gz]) +
                               dot(f.z[gx][gy] - r2, g.z[gx][gy]);
                    }
            store(weight_bar + block * kBlock + lane, sum);
        }
    }
}

inline V3 along(const Gradient& f, int gx, int gy, int gz, const V m[3]) {
    return m[0] * f.x[gy][gz] + m[1] * f.y[gx][gz] + m[2] * f.z[gx][gy];
}

inline void add_outer(Gradient& p, int gx, int gy, int gz, const V m[3], const V3& t) {
    p.x[gy][gz] = p.x[gy][gz] + m[0] * t;
    p.y[gx][gz] = p.y[gx][gz] + m[1] * t;
    p.z[gx][gy] = p.z[gx][gy] + m[2] * t;
}

// |F m|, kept away from zero: a fibre crushed to a point has no direction.
inline V length_of(const V3& t) {
    return square_root(dot(t, t) + 1e-24);
}

void muscle_gradient(const double* q, const int* nodes, const double* direction, const double* weight,
                     const double* rest, double inv_dx, int begin, int end, double* force, double* energy,
                     double* cache) {
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
                double* out = cache + (static_cast<long>(block) * 8 + g) * 5 * kBlock + lane;
                const V inv = 1.0 / length;
                store(out, inv * t.x);
                store(out + kBlock, inv * t.y);
                store(out + 2 * kBlock, inv * t.z);
                store(out + 3 * kBlock, c1);
                store(out + 4 * kBlock, w * ratio * inv);
            }
            scatter(p, inv_dx, force + static_cast<long>(block) * kCellForce + lane);
            block_energy += sum_lanes(0.5 * w * e);
        }
        energy[block] = block_energy;
    }
}

void muscle_product(const double* p, const int* nodes, const double* direction, double inv_dx, int begin, int end,
                    const double* cache, double* force) {
    for (int block = begin; block < end; ++block) {
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const double* dir = direction + block * 3 * kBlock + lane;
            const V m[3] = {load(dir), load(dir + kBlock), load(dir + 2 * kBlock)};
            const Gradient f = gradient_of(p, nodes + block * 8 * kBlock + lane, inv_dx);
            Gradient s;
            clear(s);
            for (int g = 0; g < 8; ++g) {
                const int gx = g >> 2, gy = g >> 1 & 1, gz = g & 1;
                const double* in = cache + (static_cast<long>(block) * 8 + g) * 5 * kBlock + lane;
                const V3 t = {load(in), load(in + kBlock), load(in + 2 * kBlock)};
                const V c1 = load(in + 3 * kBlock), c2 = load(in + 4 * kBlock);
                const V3 d = along(f, gx, gy, gz, m);
                add_outer(s, gx, gy, gz, m, c1 * d + (c2 * dot(t, d)) * t);
            }
            scatter(s, inv_dx, force + static_cast<long>(block) * kCellForce + lane);
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

const BodyKernels& DQA_KERNEL_TABLE() {
    static const BodyKernels table = {elastic_gradient, elastic_product, elastic_weight_bar,
                                      muscle_gradient,  muscle_product,  muscle_bar};
    return table;
}

}  // namespace dqa
