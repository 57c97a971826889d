// SPDX-License-Identifier: MIT
// Four numbers of any alignment that are added and scaled at once, as a padded three-vector is. The functions have
// internal linkage, as sources that are compiled once per instruction set use them (simd_vector.hpp says why).
#pragma once

namespace dqa {

template <class Real>
struct FourOf {
    typedef Real type __attribute__((vector_size(4 * sizeof(Real)), aligned(sizeof(Real)), may_alias));
};
template <class Real>
using Four = typename FourOf<Real>::type;
template <class Real>
static inline Four<Real>& four(Real* p) {
    return *reinterpret_cast<Four<Real>*>(p);
}
template <class Real>
static inline const Four<Real>& four(const Real* p) {
    return *reinterpret_cast<const Four<Real>*>(p);
}
// (p[0], p[1], p[2], 0)
template <class Real>
static inline Four<Real> padded(const Real* p) {
    return Four<Real>{p[0], p[1], p[2], Real(0)};
}
template <class Vector>
static inline double total(const Vector& v) {
    return static_cast<double>(v[0]) + static_cast<double>(v[1]) + static_cast<double>(v[2]) +
           static_cast<double>(v[3]);
}

}  // namespace dqa
