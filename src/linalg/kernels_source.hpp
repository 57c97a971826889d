// SPDX-License-Identifier: MIT
// Source of the triangular solve, included once per instruction set; see kernels.hpp and packed_factor.hpp.
#include "linalg/kernels.hpp"

namespace dqa {
namespace {

typedef float F16 __attribute__((vector_size(64), aligned(64), may_alias));
typedef float F16u __attribute__((vector_size(64), aligned(4), may_alias));

// out[rhs][16] = sum over `count` inputs j of chunk[j][16] * in[j][rhs]
inline void chunk_product(const float* chunk, const float* in, int count, F16& s0, F16& s1, F16& s2) {
    F16 a0 = {}, a1 = {}, a2 = {};
    for (int j = 0; j < count; ++j) {
        const F16 c = *reinterpret_cast<const F16u*>(chunk + 16 * static_cast<long>(j));
        a0 += c * in[4 * j];
        a1 += c * in[4 * j + 1];
        a2 += c * in[4 * j + 2];
    }
    s0 = a0, s1 = a1, s2 = a2;
}

void solve(const PackedSupernode* supernodes, int count, const int* rows, const float* values, float* x,
           float* scratch) {
    for (int s = 0; s < count; ++s) {
        const PackedSupernode& node = supernodes[s];
        const int total = node.columns + node.rows_below;
        float* own = x + 4 * static_cast<long>(node.first);
        for (int k = 0; k < 4 * node.columns; ++k) scratch[k] = own[k];
        const int* below = rows + node.row_offset;
        for (int r = 0; r < total; r += 16) {
            F16 y0, y1, y2;
            chunk_product(values + node.forward + static_cast<long>(r) * node.columns, scratch, node.columns, y0, y1,
                          y2);
            const int end = total - r < 16 ? total - r : 16;
            for (int l = 0; l < end; ++l) {
                const int row = r + l;
                if (row < node.columns) {
                    own[4 * row] = y0[l], own[4 * row + 1] = y1[l], own[4 * row + 2] = y2[l];
                } else {
                    float* target = x + 4 * static_cast<long>(below[row - node.columns]);
                    target[0] -= y0[l], target[1] -= y1[l], target[2] -= y2[l];
                }
            }
        }
    }
    for (int s = count - 1; s >= 0; --s) {
        const PackedSupernode& node = supernodes[s];
        const int total = node.columns + node.rows_below;
        float* own = x + 4 * static_cast<long>(node.first);
        for (int k = 0; k < 4 * node.columns; ++k) scratch[k] = own[k];
        const int* below = rows + node.row_offset;
        for (int r = 0; r < node.rows_below; ++r)
            for (int k = 0; k < 4; ++k) scratch[4 * (node.columns + r) + k] = -x[4 * static_cast<long>(below[r]) + k];
        for (int c = 0; c < node.columns; c += 16) {
            F16 y0, y1, y2;
            chunk_product(values + node.backward + static_cast<long>(c) * total, scratch, total, y0, y1, y2);
            const int end = node.columns - c < 16 ? node.columns - c : 16;
            for (int l = 0; l < end; ++l)
                own[4 * (c + l)] = y0[l], own[4 * (c + l) + 1] = y1[l], own[4 * (c + l) + 2] = y2[l];
        }
    }
}

}  // namespace

const FactorKernels& DQA_KERNEL_TABLE() {
    static const FactorKernels table = {solve};
    return table;
}

}  // namespace dqa
