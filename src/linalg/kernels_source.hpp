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

// What a row of a vector with `width` right-hand sides is: a number, or three and padding.
template <class Real, int width>
struct Row {
    typedef typename Lanes<Real>::Four Value;
    static constexpr long stride = 4;
    static Value of(const Real* flat, int l) {
        constexpr int lanes = Lanes<Real>::count;
        return Value{flat[l], flat[lanes + l], flat[2 * lanes + l], 0};
    }
};
template <class Real>
struct Row<Real, 1> {
    typedef Real Value __attribute__((may_alias));
    static constexpr long stride = 1;
    static Value of(const Real* flat, int l) { return flat[l]; }
};

// y_k = sum over `count` inputs j of chunk[j][lanes] * in[j][k].
template <class Real, int width>
inline void chunk_product(const Real* chunk, const Real* in, int count, typename Lanes<Real>::Vector y[width]) {
    typedef typename Lanes<Real>::Vector Vector;
    typedef typename Lanes<Real>::Loose Loose;
    constexpr int lanes = Lanes<Real>::count;
    constexpr int chains = width == 1 ? 4 : 2;  // one alone waits for the latency of its additions
    constexpr long stride = Row<Real, width>::stride;
    Vector sum[chains][width] = {};
    const auto add = [&](int chain, int j) {
        const Vector c = *reinterpret_cast<const Loose*>(chunk + static_cast<long>(lanes) * j);
        for (int k = 0; k < width; ++k) sum[chain][k] += c * in[stride * j + k];
    };
    int j = 0;
    for (; j + chains <= count; j += chains)
        for (int chain = 0; chain < chains; ++chain) add(chain, j + chain);
    for (; j < count; ++j) add(0, j);
    for (int k = 0; k < width; ++k) {
        y[k] = sum[0][k];
        for (int chain = 1; chain < chains; ++chain) y[k] += sum[chain][k];
    }
}

template <class Real, int width>
void forward(const PackedSupernode& node, const int* rows, const Real* values, const Real* in, int begin, int end,
             Real* x, Real* outside, int top) {
    using R = Row<Real, width>;
    using Value = typename R::Value;
    constexpr int lanes = Lanes<Real>::count;
    Real* own = x + R::stride * node.first;
    const int* below = rows + node.row_offset;
    for (int r = begin; r < end; r += lanes) {
        const int inputs = r + lanes < node.columns ? r + lanes : node.columns;
        typename Lanes<Real>::Vector y[width];
        chunk_product<Real, width>(values + node.forward + packed_forward_offset(lanes, node.columns, r), in, inputs,
                                   y);
        const int stop = end - r < lanes ? end - r : lanes;
        const Real* flat = reinterpret_cast<const Real*>(y);
        for (int l = 0; l < stop; ++l) {
            const int row = r + l;
            const Value value = R::of(flat, l);
            if (row < node.columns) {
                *reinterpret_cast<Value*>(own + R::stride * row) = value;
            } else {
                const int target = below[row - node.columns];
                *reinterpret_cast<Value*>((target < top ? x : outside - R::stride * top) + R::stride * target) -= value;
            }
        }
    }
}

template <class Real, int width>
void backward(const PackedSupernode& node, const Real* values, const Real* in, int begin, int end, Real* x) {
    using R = Row<Real, width>;
    constexpr int lanes = Lanes<Real>::count;
    Real* own = x + R::stride * node.first;
    const int total = node.columns + node.rows_below;
    for (int c = begin; c < end; c += lanes) {
        typename Lanes<Real>::Vector y[width];
        chunk_product<Real, width>(values + node.backward + packed_backward_offset(lanes, total, c), in + R::stride * c,
                                   total - c, y);
        const int stop = end - c < lanes ? end - c : lanes;
        const Real* flat = reinterpret_cast<const Real*>(y);
        for (int l = 0; l < stop; ++l)
            *reinterpret_cast<typename R::Value*>(own + R::stride * (c + l)) = R::of(flat, l);
    }
}

template <class Real, int width>
void own(const PackedSupernode& node, const Real* x, Real* in) {
    constexpr long stride = Row<Real, width>::stride;
    const Real* source = x + stride * node.first;
    for (long k = 0; k < stride * node.columns; ++k) in[k] = source[k];
}

template <class Real, int width>
void below(const PackedSupernode& node, const int* rows, const Real* x, const Real* outside, int top, Real* in) {
    using R = Row<Real, width>;
    using Value = typename R::Value;
    const int* list = rows + node.row_offset;
    for (int r = 0; r < node.rows_below; ++r) {
        const int row = list[r];
        const Real* source = row < top ? x + R::stride * row : outside + R::stride * (row - top);
        *reinterpret_cast<Value*>(in + R::stride * (node.columns + r)) = -*reinterpret_cast<const Value*>(source);
    }
}

template <class Real, int width>
constexpr FactorKernels<Real> factor_table() {
    return {forward<Real, width>, backward<Real, width>, own<Real, width>, below<Real, width>};
}

}  // namespace

const LinalgKernels& DQA_KERNEL_TABLE() {
    static const LinalgKernels table = {{factor_table<float, 1>(), factor_table<float, 3>()},
                                        {factor_table<double, 1>(), factor_table<double, 3>()}};
    return table;
}

}  // namespace dqa
