// SPDX-License-Identifier: MIT
// Source of the loops over grids, included once per instruction set; see grid_kernels.hpp.
#if defined(__AVX512F__)
#include <immintrin.h>
#endif

#include "grid/four.hpp"
#include "linalg/grid_kernels.hpp"

namespace dqa {
namespace {

// y += M x
template <class Real>
inline void add_block(const Real* block, const Real* x, Four<Real>& y) {
    y += four(block) * x[0] + four(block + 4) * x[1] + four(block + 8) * x[2];
}

template <class Real>
inline Four<Real> restricted(const TransferRows& q, int c, const Real* fine) {
    Four<Real> sum = {};
    for (int s = q.coarse_start[c]; s < q.coarse_start[c + 1]; ++s)
        sum += static_cast<Real>(q.coarse_weight[s]) * four(fine + 4 * q.coarse_to[s]);
    return sum;
}

template <class Real>
inline Four<Real> interpolated(const TransferRows& q, int n, const Real* coarse) {
    const int* from = q.fine_from + 8 * n;
    const auto at = [&](int k) { return Four<Real>(four(coarse + 4 * from[k])); };
    return static_cast<Real>(q.fine_weight[n]) *
           (((at(0) + at(1)) + (at(2) + at(3))) + ((at(4) + at(5)) + (at(6) + at(7))));
}

// The sum of M x over the blocks of row i.
template <class Real>
inline Four<Real> row_product(const LevelRows<Real>& level, const Real* x, int i) {
    Four<Real> sum = {};
    for (int k = level.start[i]; k < level.start[i + 1]; ++k)
        add_block(level.block + 12 * k, x + 4 * level.column[k], sum);
    return sum;
}

#if defined(__AVX512F__)
// A register holds a whole block; two sums, as one alone waits for the latency of its additions. (Compilers warn of
// what the forms without masks leave undefined.)
inline Four<float> row_product(const LevelRows<float>& level, const float* x, int i) {
    constexpr __mmask16 all = 0xffff, block = 0x0fff;
    const __m512i columns = _mm512_set_epi32(3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1, 0, 0, 0, 0);
    __m512 sum[2] = {_mm512_setzero_ps(), _mm512_setzero_ps()};
    const auto add = [&](int chain, int k) {
        const __m512 v = _mm512_maskz_broadcast_f32x4(all, _mm_loadu_ps(x + 4 * level.column[k]));
        sum[chain] = _mm512_fmadd_ps(_mm512_maskz_loadu_ps(block, level.block + 12 * k),
                                     _mm512_maskz_permutevar_ps(all, v, columns), sum[chain]);
    };
    int k = level.start[i];
    const int end = level.start[i + 1];
    for (; k + 2 <= end; k += 2) add(0, k), add(1, k + 1);
    if (k < end) add(0, k);
    float flat[16];
    _mm512_storeu_ps(flat, _mm512_add_ps(sum[0], sum[1]));
    return four(flat) + four(flat + 4) + four(flat + 8);
}
#endif

template <class Real>
inline Four<Real> residual_at(const LevelRows<Real>& level, const Real* right, const Real* x, int i) {
    return four(right + 4 * i) - row_product(level, x, i);
}

template <class Real>
void restrict_to(const TransferRows& q, const int* nodes, int count, const Real* fine, Real* out) {
    for (int b = 0; b < count; ++b) four(out + 4 * b) = restricted(q, nodes[b], fine);
}

template <class Real>
void begin_smooth(const LevelRows<Real>& level, const TransferRows& q, const Real* fine, int begin, int end,
                  Real* right, Real* x) {
    for (int i = begin; i < end; ++i) {
        Four<Real> sum = {};
        four(right + 4 * i) = restricted(q, i, fine);
        add_block(level.inverse + 12 * i, right + 4 * i, sum);
        four(x + 4 * i) = sum;
    }
}

template <class Real>
void residual(const LevelRows<Real>& level, const Real* right, const Real* x, int begin, int end, Real* out) {
    for (int i = begin; i < end; ++i) four(out + 4 * i) = residual_at(level, right, x, i);
}

template <class Real>
void correct(const TransferRows& q, const Real* coarse, int begin, int end, Real* x) {
    for (int i = begin; i < end; ++i) four(x + 4 * i) += interpolated(q, i, coarse);
}

template <class Real>
void end_smooth(const LevelRows<Real>& level, const Real* right, const Real* x, int begin, int end, Real* out) {
    for (int i = begin; i < end; ++i) {
        Four<Real> sum = four(x + 4 * i);
        const Four<Real> left = residual_at(level, right, x, i);
        const Real flat[3] = {left[0], left[1], left[2]};
        add_block(level.inverse + 12 * i, flat, sum);
        four(out + 4 * i) = sum;
    }
}

template <class Real, class T>
void back(const Real* turns, T scale, const T* in, int begin, int end, Real* turned) {
    for (int n = begin; n < end; ++n) {
        const T* v = in + 3 * n;
        const Real x = static_cast<Real>(scale * v[0]), y = static_cast<Real>(scale * v[1]),
                   z = static_cast<Real>(scale * v[2]);
        const Real* r = turns + 12 * n;
        for (int a = 0; a < 3; ++a) turned[4 * n + a] = r[4 * a] * x + r[4 * a + 1] * y + r[4 * a + 2] * z;
        turned[4 * n + 3] = 0;
    }
}

template <class Real, class T>
void turn_out(const Real* turns, const Real* local, const TransferRows& q, const Real* coarse, Real share, T size,
              const Real* turned, const T* in, const T* other, int begin, int end, T* out, double* sums) {
    Four<T> with_in = {}, with_other = {};
    for (int n = begin; n < end; ++n) {
        Four<Real> sum = share * interpolated(q, n, coarse);
        if (local) add_block(local + 12 * n, turned + 4 * n, sum);
        Four<Real> turned_out = {};
        const Real flat[3] = {sum[0], sum[1], sum[2]};
        add_block(turns + 12 * n, flat, turned_out);
        T* v = out + 3 * n;
        Four<T> value = size * __builtin_convertvector(turned_out, Four<T>);
        if (!local) value += padded(v);
        for (int a = 0; a < 3; ++a) v[a] = value[a];
        with_in += padded(in + 3 * n) * value, with_other += padded(other + 3 * n) * value;
    }
    sums[0] = total(with_in), sums[1] = total(with_other);
}

template <class Real>
constexpr GridKernels<Real> grid_table() {
    return {restrict_to<Real>, begin_smooth<Real>, residual<Real>, correct<Real>, end_smooth<Real>};
}
template <class Real, class T>
constexpr TurnKernels<Real, T> turn_table() {
    return {back<Real, T>, turn_out<Real, T>};
}
template <class Real>
constexpr TurnTables<Real> turn_tables() {
    return {{turn_table<Real, double>(), turn_table<Real, float>()}};
}

}  // namespace

const GridTables& DQA_KERNEL_TABLE() {
    static const GridTables table = {{grid_table<double>(), grid_table<float>()},
                                     {turn_tables<double>(), turn_tables<float>()}};
    return table;
}

}  // namespace dqa
