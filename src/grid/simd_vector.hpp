// SPDX-License-Identifier: MIT
// One SIMD register of doubles for kernel sources that are compiled once per instruction set. Everything here has
// internal linkage: an inline function shared between translation units of different flags could be merged by the
// linker into the wrong set. Data blocks hold kBlock lanes; a kernel walks them in pieces of kLanes.
#pragma once

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

[[maybe_unused]] inline V load(const double* p) {
    return *reinterpret_cast<const Vu*>(p);
}
[[maybe_unused]] inline void store(double* p, V v) {
    *reinterpret_cast<Vu*>(p) = v;
}
[[maybe_unused]] inline V broadcast(double x) {
    return V{} + x;
}
[[maybe_unused]] inline V gather(const double* p, const int* index) {
    V v;
    for (int l = 0; l < kLanes; ++l) v[l] = p[index[l]];
    return v;
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
