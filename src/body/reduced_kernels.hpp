// SPDX-License-Identifier: MIT
// Kernels of elasticity with one integration point, the cell's centre, and hourglass control: a stiffness against the
// four modes of a cell that its centre does not feel, yz, xz, xy and xyz (Flanagan & Belytschko 1981). On cubes these
// modes see no affine motion, so the energy
//     weight (psi(F_centre) + s/2 sum_a k_a |h_a|^2)
// is quadratic in their amplitudes h_a (vectors, over dx) and turns with the body by itself. s is the second derivative
// of psi along a symmetric strain at rest; k_a is half the mean of |grad|^2 of the mode: the half that a symmetric
// strain leaves. With it a layer of single cells bends with the stiffness of beam theory: u_x = xy has the strain
// e_xx = y of bending; e_xy = x/2, which bending does not have, is left out, while eight Gauss points keep it and make
// the layer half again too stiff. Warping (u_x = yz) keeps the stiffness it has at eight points.
#pragma once

#include "body/corotated_kernels.hpp"
#include "body/neo_hookean_kernels.hpp"

namespace dqa {
namespace {

// Half of 2^2 times the mean of |grad|^2 over [-1, 1]^3: 2/3 for products of two coordinates, 1/3 for that of three.
constexpr double kHourglass[4] = {4.0 / 3.0, 4.0 / 3.0, 4.0 / 3.0, 2.0 / 3.0};

// Affine part and hourglass amplitudes of a field of three-vectors at the corners (node 4 ix + 2 iy + iz), both over
// dx.
template <class T>
struct CellOf {
    Vector3<T> f[3], h[4];
};
using Cell = CellOf<double>;

template <class T>
inline CellOf<T> cell_of(const T* q, const int* nodes, double inv_dx, double slab = 0.0) {
    Vector3<T> c[8];
    for (int k = 0; k < 8; ++k) load_three(q, nodes + k * kBlock, c[k].x, c[k].y, c[k].z);
    // Sums and differences along z, then y, then x: index bits say along which axes the difference was taken.
    for (int bit = 1; bit < 8; bit *= 2)
        for (int k = 0; k < 8; ++k)
            if (!(k & bit)) {
                const Vector3<T> low = c[k], high = c[k | bit];
                c[k] = low + high, c[k | bit] = high - low;
            }
    const double affine = 0.25 * inv_dx, hourglass = 0.125 * inv_dx;
    CellOf<T> cell = {{affine * c[4], affine * c[2], affine * c[1]},
                      {hourglass * c[3], hourglass * c[5], hourglass * c[6], hourglass * c[7]}};
    cell.f[2].z += static_cast<T>(slab);
    return cell;
}

// Its transpose.
template <class T>
inline void spread(const CellOf<T>& cell, double inv_dx, int block, int lane, const ChunkForces<T>& out) {
    const std::uint16_t* slots = out.slots + static_cast<long>(block) * 8 * kBlock + lane;
    const Lanes<T> zero = Lanes<T>{};
    const double affine = 0.25 * inv_dx, hourglass = 0.125 * inv_dx;
    Vector3<T> c[8] = {{zero, zero, zero}, affine * cell.f[2],    affine * cell.f[1],    hourglass * cell.h[0],
                       affine * cell.f[0], hourglass * cell.h[1], hourglass * cell.h[2], hourglass * cell.h[3]};
    for (int bit = 1; bit < 8; bit *= 2)
        for (int k = 0; k < 8; ++k)
            if (!(k & bit)) {
                const Vector3<T> sum = c[k], difference = c[k | bit];
                c[k] = sum - difference, c[k | bit] = sum + difference;
            }
    for (int k = 0; k < 8; ++k) add_three(out.sum, slots + k * kBlock, c[k].x, c[k].y, c[k].z);
}

// Hourglass forces of a cell for the stiffness w.
template <class T>
inline void resist(Lanes<T> w, const CellOf<T>& cell, CellOf<T>& out) {
    for (int k = 0; k < 4; ++k) out.h[k] = (static_cast<T>(kHourglass[k]) * w) * cell.h[k];
}
inline V hourglass_dot(const Cell& a, const Cell& b) {
    V sum = kHourglass[0] * dot(a.h[0], b.h[0]);
    for (int k = 1; k < 4; ++k) sum += kHourglass[k] * dot(a.h[k], b.h[k]);
    return sum;
}

void reduced_corotated_gradient(const double* q, const int* nodes, const double* weight, const double*, double inv_dx,
                                double slab, int begin, int end, const ChunkForces<double>& force, double* energy,
                                double* cache, int* inverted) {
    int n_inverted = 0;
    for (int block = begin; block < end; ++block) {
        double block_energy = 0.0;
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const V w = load(weight + block * kBlock + lane);
            const Cell cell = cell_of(q, nodes + block * 8 * kBlock + lane, inv_dx, slab);
            V3 r[3];
            V det;
            rotation(cell.f, r, &det);
            n_inverted += inverted_lanes(det, w);
            const V3 d[3] = {cell.f[0] - r[0], cell.f[1] - r[1], cell.f[2] - r[2]};
            const V e = dot(d[0], d[0]) + dot(d[1], d[1]) + dot(d[2], d[2]) + hourglass_dot(cell, cell);
            Cell s;
            for (int k = 0; k < 3; ++k) s.f[k] = w * d[k];
            resist(w, cell, s);
            if (cache)
                store_twist(cache + static_cast<long>(block) * kCorotatedPoint * kBlock + lane, r, twist_of(cell.f, r));
            spread(s, inv_dx, block, lane, force);
            block_energy += sum_lanes(0.5 * w * e);
        }
        energy[block] = block_energy;
    }
    *inverted += n_inverted;
}

template <class T>
void reduced_corotated_product(const T* p, const int* nodes, const T* weight, double inv_dx, int begin, int end,
                               const T* cache, const ChunkForces<T>& force) {
    for (int block = begin; block < end; ++block)
        for (int lane = 0; lane < kBlock; lane += Register<T>::lanes) {
            const Lanes<T> w = load(weight + block * kBlock + lane);
            const CellOf<T> cell = cell_of(p, nodes + block * 8 * kBlock + lane, inv_dx);
            Vector3<T> d[3];
            rotation_change(cache + static_cast<long>(block) * kCorotatedPoint * kBlock + lane, cell.f[0], cell.f[1],
                            cell.f[2], d);
            CellOf<T> s;
            for (int k = 0; k < 3; ++k) s.f[k] = w * (cell.f[k] - d[k]);
            resist(w, cell, s);
            spread(s, inv_dx, block, lane, force);
        }
}

void reduced_corotated_bar(const double* q, const double* lambda, const int* nodes, const double*, const double*,
                           double inv_dx, double slab, int begin, int end, const double* cache, double* weight_bar,
                           double*) {
    for (int block = begin; block < end; ++block)
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const int* index = nodes + block * 8 * kBlock + lane;
            const Cell f = cell_of(q, index, inv_dx, slab), g = cell_of(lambda, index, inv_dx);
            const double* in = cache + static_cast<long>(block) * kCorotatedPoint * kBlock + lane;
            V3 r[3];
            load_columns(in, r);
            store(weight_bar + block * kBlock + lane, dot(f.f[0] - r[0], g.f[0]) + dot(f.f[1] - r[1], g.f[1]) +
                                                          dot(f.f[2] - r[2], g.f[2]) + hourglass_dot(f, g));
        }
}

void reduced_corotated_filter(double* cache, int blocks) {
    filter_twists(cache, blocks);
}

// psi = (I - 3 - log((I + 1) / 4)) / 2: with the modulus of neo_hookean (4/3 mu), 2 mu along a symmetric strain is
constexpr double kNeoHourglass = 1.5;

void reduced_neo_gradient(const double* q, const int* nodes, const double* weight, const double*, double inv_dx,
                          double slab, int begin, int end, const ChunkForces<double>& force, double* energy,
                          double* cache, int* inverted) {
    int n_inverted = 0;
    for (int block = begin; block < end; ++block) {
        double block_energy = 0.0;
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const V w = load(weight + block * kBlock + lane);
            const Cell cell = cell_of(q, nodes + block * 8 * kBlock + lane, inv_dx, slab);
            const V det = dot(cell.f[0], cross(cell.f[1], cell.f[2]));
            n_inverted += inverted_lanes(det, w);
            const V size = dot(cell.f[0], cell.f[0]) + dot(cell.f[1], cell.f[1]) + dot(cell.f[2], cell.f[2]);
            const V inv = 1.0 / (size + 1.0), a = 1.0 - inv;
            const V e = size - 3.0 - natural_log(0.25 * (size + 1.0)) + kNeoHourglass * hourglass_dot(cell, cell);
            Cell s;
            for (int k = 0; k < 3; ++k) s.f[k] = (w * a) * cell.f[k];
            resist(kNeoHourglass * w, cell, s);
            if (cache) {
                double* out = cache + static_cast<long>(block) * kNeoPoint * kBlock + lane;
                store_columns(out, cell.f);
                store(out + 9 * kBlock, a);
                store(out + 10 * kBlock, 2.0 * inv * inv);
            }
            spread(s, inv_dx, block, lane, force);
            block_energy += sum_lanes(0.5 * w * e);
        }
        energy[block] = block_energy;
    }
    *inverted += n_inverted;
}

template <class T>
void reduced_neo_product(const T* p, const int* nodes, const T* weight, double inv_dx, int begin, int end,
                         const T* cache, const ChunkForces<T>& force) {
    for (int block = begin; block < end; ++block)
        for (int lane = 0; lane < kBlock; lane += Register<T>::lanes) {
            const Lanes<T> w = load(weight + block * kBlock + lane);
            const CellOf<T> d = cell_of(p, nodes + block * 8 * kBlock + lane, inv_dx);
            const T* in = cache + static_cast<long>(block) * kNeoPoint * kBlock + lane;
            Vector3<T> f[3];
            load_columns(in, f);
            const Lanes<T> a = w * load(in + 9 * kBlock);
            const Lanes<T> b = w * load(in + 10 * kBlock) * (dot(f[0], d.f[0]) + dot(f[1], d.f[1]) + dot(f[2], d.f[2]));
            CellOf<T> s;
            for (int k = 0; k < 3; ++k) s.f[k] = a * d.f[k] + b * f[k];
            resist(static_cast<T>(kNeoHourglass) * w, d, s);
            spread(s, inv_dx, block, lane, force);
        }
}

void reduced_neo_bar(const double* q, const double* lambda, const int* nodes, const double*, const double*,
                     double inv_dx, double slab, int begin, int end, const double* cache, double* weight_bar, double*) {
    for (int block = begin; block < end; ++block)
        for (int lane = 0; lane < kBlock; lane += kLanes) {
            const int* index = nodes + block * 8 * kBlock + lane;
            const Cell f = cell_of(q, index, inv_dx, slab), g = cell_of(lambda, index, inv_dx);
            const V a = load(cache + (static_cast<long>(block) * kNeoPoint + 9) * kBlock + lane);
            store(weight_bar + block * kBlock + lane,
                  a * (dot(f.f[0], g.f[0]) + dot(f.f[1], g.f[1]) + dot(f.f[2], g.f[2])) +
                      kNeoHourglass * hourglass_dot(f, g));
        }
}

}  // namespace
}  // namespace dqa
