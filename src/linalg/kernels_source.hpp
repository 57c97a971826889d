// SPDX-License-Identifier: MIT
// Source of the triangular solve, included once per instruction set; see kernels.hpp and packed_factor.hpp.
#include "linalg/kernels.hpp"

namespace dqa {
namespace {

template <class Real>
struct Lanes {
    static constexpr int count = kFactorLanes<Real>;
    typedef Real Vector __attribute__((vector_size(64), aligned(64), may_alias));
    typedef Real Loose __attribute__((vector_size(64), aligned(sizeof(Real)), may_alias));
    typedef Real Four __attribute__((vector_size(4 * sizeof(Real)), aligned(sizeof(Real)), may_alias));
};

// s_k = sum over `count` inputs j of chunk[j][lanes] * in[j][k]: three right-hand sides.
template <class Real>
inline void chunk_product(const Real* chunk, const Real* in, int count, typename Lanes<Real>::Vector& s0,
                          typename Lanes<Real>::Vector& s1, typename Lanes<Real>::Vector& s2) {
    typedef typename Lanes<Real>::Vector Vector;
    typedef typename Lanes<Real>::Loose Loose;
    constexpr int lanes = Lanes<Real>::count;
    Vector a0 = {}, a1 = {}, a2 = {}, b0 = {}, b1 = {}, b2 = {};
    int j = 0;
    for (; j + 2 <= count; j += 2) {  // two chains: one alone waits for the latency of its additions
        const Vector c = *reinterpret_cast<const Loose*>(chunk + static_cast<long>(lanes) * j);
        const Vector d = *reinterpret_cast<const Loose*>(chunk + static_cast<long>(lanes) * (j + 1));
        a0 += c * in[4 * j], a1 += c * in[4 * j + 1], a2 += c * in[4 * j + 2];
        b0 += d * in[4 * j + 4], b1 += d * in[4 * j + 5], b2 += d * in[4 * j + 6];
    }
    if (j < count) {
        const Vector c = *reinterpret_cast<const Loose*>(chunk + static_cast<long>(lanes) * j);
        a0 += c * in[4 * j], a1 += c * in[4 * j + 1], a2 += c * in[4 * j + 2];
    }
    s0 = a0 + b0, s1 = a1 + b1, s2 = a2 + b2;
}

template <class Real>
void forward(const PackedSupernode& node, const int* rows, const Real* values, const Real* in, int begin, int end,
             Real* x, Real* outside, int top) {
    typedef typename Lanes<Real>::Vector Vector;
    typedef typename Lanes<Real>::Four Four;
    constexpr int lanes = Lanes<Real>::count;
    Real* own = x + 4 * static_cast<long>(node.first);
    const int* below = rows + node.row_offset;
    for (int r = begin; r < end; r += lanes) {
        const int inputs = r + lanes < node.columns ? r + lanes : node.columns;
        Vector y[3];
        chunk_product(values + node.forward + packed_forward_offset(lanes, node.columns, r), in, inputs, y[0], y[1],
                      y[2]);
        const int stop = end - r < lanes ? end - r : lanes;
        const Real* flat = reinterpret_cast<const Real*>(y);
        for (int l = 0; l < stop; ++l) {
            const int row = r + l;
            const Four value = {flat[l], flat[lanes + l], flat[2 * lanes + l], 0};
            if (row < node.columns) {
                *reinterpret_cast<Four*>(own + 4 * static_cast<long>(row)) = value;
            } else {
                const int target = below[row - node.columns];
                *reinterpret_cast<Four*>((target < top ? x : outside - 4 * static_cast<long>(top)) +
                                         4 * static_cast<long>(target)) -= value;
            }
        }
    }
}

template <class Real>
void backward(const PackedSupernode& node, const Real* values, const Real* in, int begin, int end, Real* x) {
    typedef typename Lanes<Real>::Vector Vector;
    typedef typename Lanes<Real>::Four Four;
    constexpr int lanes = Lanes<Real>::count;
    Real* own = x + 4 * static_cast<long>(node.first);
    const int total = node.columns + node.rows_below;
    for (int c = begin; c < end; c += lanes) {
        Vector y[3];
        chunk_product(values + node.backward + packed_backward_offset(lanes, total, c), in + 4 * static_cast<long>(c),
                      total - c, y[0], y[1], y[2]);
        const int stop = end - c < lanes ? end - c : lanes;
        const Real* flat = reinterpret_cast<const Real*>(y);
        for (int l = 0; l < stop; ++l)
            *reinterpret_cast<Four*>(own + 4 * static_cast<long>(c + l)) =
                Four{flat[l], flat[lanes + l], flat[2 * lanes + l], 0};
    }
}

template <class Real>
void own(const PackedSupernode& node, const Real* x, Real* in) {
    const Real* source = x + 4 * static_cast<long>(node.first);
    for (int k = 0; k < 4 * node.columns; ++k) in[k] = source[k];
}

template <class Real>
void below(const PackedSupernode& node, const int* rows, const Real* x, const Real* outside, int top, Real* in) {
    typedef typename Lanes<Real>::Four Four;
    const int* list = rows + node.row_offset;
    for (int r = 0; r < node.rows_below; ++r) {
        const int row = list[r];
        const Real* source = row < top ? x + 4 * static_cast<long>(row) : outside + 4 * static_cast<long>(row - top);
        *reinterpret_cast<Four*>(in + 4 * static_cast<long>(node.columns + r)) =
            -*reinterpret_cast<const Four*>(source);
    }
}

template <class Real>
constexpr FactorKernels<Real> factor_table() {
    return {forward<Real>, backward<Real>, own<Real>, below<Real>};
}

}  // namespace

const LinalgKernels& DQA_KERNEL_TABLE() {
    static const LinalgKernels table = {factor_table<float>(), factor_table<double>()};
    return table;
}

}  // namespace dqa
