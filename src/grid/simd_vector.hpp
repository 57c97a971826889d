// SPDX-License-Identifier: MIT
// One SIMD register of doubles or floats for kernel sources that are compiled once per instruction set. Everything here
// has internal linkage: an inline function shared between translation units of different flags could be merged by the
// linker into the wrong set. Data blocks hold kBlock lanes; a kernel walks them in pieces of kLanes.
#pragma once

#include <cstdint>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace dqa {
namespace {

constexpr int kBlock = 8;  // lanes of a block in memory, for every instruction set

#if defined(__AVX512F__)
constexpr int kLanes = 8;
#elif defined(__AVX2__)
constexpr int kLanes = 4;
#else
constexpr int kLanes = 2;
#endif

typedef double V __attribute__((vector_size(kLanes * sizeof(double)), aligned(kLanes * sizeof(double)), may_alias));
typedef double Vu __attribute__((vector_size(kLanes * sizeof(double)), aligned(sizeof(double)), may_alias));
typedef long long Mask __attribute__((vector_size(kLanes * sizeof(long long))));

// The same in single precision: a block of floats is as wide as AVX's registers.
constexpr int kSingleLanes = kLanes < 4 ? 4 : kBlock;
typedef float Vs
    __attribute__((vector_size(kSingleLanes * sizeof(float)), aligned(kSingleLanes * sizeof(float)), may_alias));
typedef float Vsu __attribute__((vector_size(kSingleLanes * sizeof(float)), aligned(sizeof(float)), may_alias));
typedef int SingleMask __attribute__((vector_size(kSingleLanes * sizeof(int))));

// Four numbers of any alignment, a padded three-vector.
typedef double Four __attribute__((vector_size(4 * sizeof(double)), aligned(sizeof(double)), may_alias));
typedef float FourSingle __attribute__((vector_size(4 * sizeof(float)), aligned(sizeof(float)), may_alias));

// By the number that a kernel computes with.
template <class T>
struct Register;
template <>
struct Register<double> {
    typedef V type;
    typedef Four row;
    static constexpr int lanes = kLanes;
};
template <>
struct Register<float> {
    typedef Vs type;
    typedef FourSingle row;
    static constexpr int lanes = kSingleLanes;
};
template <class T>
using Lanes = typename Register<T>::type;

[[maybe_unused]] inline V load(const double* p) {
    return *reinterpret_cast<const Vu*>(p);
}
[[maybe_unused]] inline Vs load(const float* p) {
    return *reinterpret_cast<const Vsu*>(p);
}
[[maybe_unused]] inline void store(double* p, V v) {
    *reinterpret_cast<Vu*>(p) = v;
}
[[maybe_unused]] inline V broadcast(double x) {
    return V{} + x;
}
// Components of three-vectors [.][3] that start at p[index[lane]].
[[maybe_unused]] inline void load_three(const double* p, const int* index, V& x, V& y, V& z) {
#if defined(__AVX512F__)
    __m256d row[8];
    for (int l = 0; l < 8; ++l) row[l] = _mm256_maskz_loadu_pd(7, p + index[l]);
    const V r04 = (V)_mm512_maskz_insertf64x4(0xff, _mm512_castpd256_pd512(row[0]), row[4], 1);
    const V r15 = (V)_mm512_maskz_insertf64x4(0xff, _mm512_castpd256_pd512(row[1]), row[5], 1);
    const V r26 = (V)_mm512_maskz_insertf64x4(0xff, _mm512_castpd256_pd512(row[2]), row[6], 1);
    const V r37 = (V)_mm512_maskz_insertf64x4(0xff, _mm512_castpd256_pd512(row[3]), row[7], 1);
    const V xz01 = __builtin_shufflevector(r04, r15, 0, 8, 2, 10, 4, 12, 6, 14);
    const V xz23 = __builtin_shufflevector(r26, r37, 0, 8, 2, 10, 4, 12, 6, 14);
    const V y01 = __builtin_shufflevector(r04, r15, 1, 9, 3, 11, 5, 13, 7, 15);
    const V y23 = __builtin_shufflevector(r26, r37, 1, 9, 3, 11, 5, 13, 7, 15);
    x = __builtin_shufflevector(xz01, xz23, 0, 1, 8, 9, 4, 5, 12, 13);
    y = __builtin_shufflevector(y01, y23, 0, 1, 8, 9, 4, 5, 12, 13);
    z = __builtin_shufflevector(xz01, xz23, 2, 3, 10, 11, 6, 7, 14, 15);
#elif defined(__AVX2__)
    const __m256i three = _mm256_setr_epi64x(-1, -1, -1, 0);
    V row[4];
    for (int l = 0; l < 4; ++l) row[l] = (V)_mm256_maskload_pd(p + index[l], three);
    const V xz01 = __builtin_shufflevector(row[0], row[1], 0, 4, 2, 6);
    const V xz23 = __builtin_shufflevector(row[2], row[3], 0, 4, 2, 6);
    const V y01 = __builtin_shufflevector(row[0], row[1], 1, 5, 3, 7);
    const V y23 = __builtin_shufflevector(row[2], row[3], 1, 5, 3, 7);
    x = __builtin_shufflevector(xz01, xz23, 0, 1, 4, 5);
    y = __builtin_shufflevector(y01, y23, 0, 1, 4, 5);
    z = __builtin_shufflevector(xz01, xz23, 2, 3, 6, 7);
#else
    x = y = z = V{};
    for (int l = 0; l < kLanes; ++l) x[l] = p[index[l]], y[l] = p[index[l] + 1], z[l] = p[index[l] + 2];
#endif
}
// The same of floats. Each row is read as four of them: one float beyond the last vector has to be there.
[[maybe_unused]] inline void load_three(const float* p, const int* index, Vs& x, Vs& y, Vs& z) {
#if defined(__AVX2__)
    __m256 row[4];  // of the lanes l and l + 4
    for (int l = 0; l < 4; ++l)
        row[l] =
            _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(p + index[l])), _mm_loadu_ps(p + index[l + 4]), 1);
    const __m256 xy01 = _mm256_unpacklo_ps(row[0], row[1]), xy23 = _mm256_unpacklo_ps(row[2], row[3]);
    const __m256 z01 = _mm256_unpackhi_ps(row[0], row[1]), z23 = _mm256_unpackhi_ps(row[2], row[3]);
    x = (Vs)_mm256_shuffle_ps(xy01, xy23, 0x44);
    y = (Vs)_mm256_shuffle_ps(xy01, xy23, 0xee);
    z = (Vs)_mm256_shuffle_ps(z01, z23, 0x44);
#else
    x = y = z = Vs{};
    for (int l = 0; l < kSingleLanes; ++l) x[l] = p[index[l]], y[l] = p[index[l] + 1], z[l] = p[index[l] + 2];
#endif
}
// The transpose: (x, y, z, 0) of each lane.
[[maybe_unused]] inline void rows_of(V x, V y, V z, Four row[kLanes]) {
#if defined(__AVX512F__)
    const V zero = V{};
    const V xy_even = __builtin_shufflevector(x, y, 0, 8, 2, 10, 4, 12, 6, 14);
    const V xy_odd = __builtin_shufflevector(x, y, 1, 9, 3, 11, 5, 13, 7, 15);
    const V z_even = __builtin_shufflevector(z, zero, 0, 8, 2, 8, 4, 8, 6, 8);
    const V z_odd = __builtin_shufflevector(z, zero, 1, 8, 3, 8, 5, 8, 7, 8);
    const V r02 = __builtin_shufflevector(xy_even, z_even, 0, 1, 8, 9, 2, 3, 10, 11);
    const V r13 = __builtin_shufflevector(xy_odd, z_odd, 0, 1, 8, 9, 2, 3, 10, 11);
    const V r46 = __builtin_shufflevector(xy_even, z_even, 4, 5, 12, 13, 6, 7, 14, 15);
    const V r57 = __builtin_shufflevector(xy_odd, z_odd, 4, 5, 12, 13, 6, 7, 14, 15);
    const auto low = [](V v) -> Four { return __builtin_shufflevector(v, v, 0, 1, 2, 3); };
    const auto high = [](V v) -> Four { return __builtin_shufflevector(v, v, 4, 5, 6, 7); };
    row[0] = low(r02), row[1] = low(r13), row[2] = high(r02), row[3] = high(r13);
    row[4] = low(r46), row[5] = low(r57), row[6] = high(r46), row[7] = high(r57);
#elif defined(__AVX2__)
    const V zero = V{};
    const V xy_even = __builtin_shufflevector(x, y, 0, 4, 2, 6), xy_odd = __builtin_shufflevector(x, y, 1, 5, 3, 7);
    const V z_even = __builtin_shufflevector(z, zero, 0, 4, 2, 4), z_odd = __builtin_shufflevector(z, zero, 1, 4, 3, 4);
    row[0] = __builtin_shufflevector(xy_even, z_even, 0, 1, 4, 5);
    row[1] = __builtin_shufflevector(xy_odd, z_odd, 0, 1, 4, 5);
    row[2] = __builtin_shufflevector(xy_even, z_even, 2, 3, 6, 7);
    row[3] = __builtin_shufflevector(xy_odd, z_odd, 2, 3, 6, 7);
#else
    for (int l = 0; l < kLanes; ++l) row[l] = Four{x[l], y[l], z[l], 0.0};
#endif
}
[[maybe_unused]] inline void rows_of(Vs x, Vs y, Vs z, FourSingle row[kSingleLanes]) {
#if defined(__AVX2__)
    const __m256 zero = _mm256_setzero_ps();
    const __m256 xy01 = _mm256_unpacklo_ps((__m256)x, (__m256)y), xy23 = _mm256_unpackhi_ps((__m256)x, (__m256)y);
    const __m256 z01 = _mm256_unpacklo_ps((__m256)z, zero), z23 = _mm256_unpackhi_ps((__m256)z, zero);
    const __m256 both[4] = {_mm256_shuffle_ps(xy01, z01, 0x44), _mm256_shuffle_ps(xy01, z01, 0xee),
                            _mm256_shuffle_ps(xy23, z23, 0x44), _mm256_shuffle_ps(xy23, z23, 0xee)};
    for (int l = 0; l < 4; ++l) {
        row[l] = (FourSingle)_mm256_castps256_ps128(both[l]);
        row[l + 4] = (FourSingle)_mm256_extractf128_ps(both[l], 1);
    }
#else
    for (int l = 0; l < kSingleLanes; ++l) row[l] = FourSingle{x[l], y[l], z[l], 0.0f};
#endif
}
// To out [lane][4].
template <class T>
inline void store_three(T* out, Lanes<T> x, Lanes<T> y, Lanes<T> z) {
    using Row = typename Register<T>::row;
    Row row[Register<T>::lanes];
    rows_of(x, y, z, row);
    for (int l = 0; l < Register<T>::lanes; ++l) *reinterpret_cast<Row*>(out + 4 * l) = row[l];
}
// Added to the four numbers at p + index[lane].
template <class T>
inline void add_three(T* p, const std::uint16_t* index, Lanes<T> x, Lanes<T> y, Lanes<T> z) {
    using Row = typename Register<T>::row;
    Row row[Register<T>::lanes];
    rows_of(x, y, z, row);
    for (int l = 0; l < Register<T>::lanes; ++l) *reinterpret_cast<Row*>(p + index[l]) += row[l];
}
[[maybe_unused]] inline V square_root(V v) {
#if defined(__AVX512F__)
    return _mm512_maskz_sqrt_pd(0xff, v);  // the unmasked form warns in GCC 12
#elif defined(__AVX2__)
    return _mm256_sqrt_pd(v);
#elif defined(__x86_64__)
    return _mm_sqrt_pd(v);
#else
    for (int l = 0; l < kLanes; ++l) v[l] = __builtin_sqrt(v[l]);
    return v;
#endif
}
[[maybe_unused]] inline V select(Mask m, V a, V b) {
    return m ? a : b;
}
[[maybe_unused]] inline Vs select(SingleMask m, Vs a, Vs b) {
    return m ? a : b;
}
[[maybe_unused]] inline bool any(Mask m) {
#if defined(__AVX512F__)
    return _mm512_test_epi64_mask((__m512i)m, (__m512i)m) != 0;
#elif defined(__AVX2__)
    return _mm256_movemask_pd((__m256d)m) != 0;
#elif defined(__x86_64__)
    return _mm_movemask_pd((__m128d)m) != 0;
#else
    for (int l = 0; l < kLanes; ++l)
        if (m[l]) return true;
    return false;
#endif
}
[[maybe_unused]] inline double sum_lanes(V v) {
    double s = v[0];
    for (int l = 1; l < kLanes; ++l) s += v[l];
    return s;
}
[[maybe_unused]] inline double max_lanes(V v) {
    double s = v[0];
    for (int l = 1; l < kLanes; ++l) s = v[l] > s ? v[l] : s;
    return s;
}
[[maybe_unused]] inline double min_lanes(V v) {
    double s = v[0];
    for (int l = 1; l < kLanes; ++l) s = v[l] < s ? v[l] : s;
    return s;
}

}  // namespace
}  // namespace dqa
