// SPDX-License-Identifier: MIT
#include "linalg/packed_factor.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>

namespace dqa {

PackedFactor::PackedFactor(const CholeskyFactor& factor, InstructionSet instructions)
    : kernels_(factor_kernels(instructions)), n_(factor.n), entries_(factor.entries), permutation_(factor.permutation) {
    constexpr int lanes = kFactorLanes;
    const auto padded = [](int k) { return (k + lanes - 1) / lanes * lanes; };
    for (const Supernode& s : factor.supernodes) {
        PackedSupernode p;
        const int total = static_cast<int>(s.rows.size());
        p.first = s.first;
        p.columns = s.columns;
        p.rows_below = total - s.columns;
        p.row_offset = static_cast<int>(rows_.size());
        rows_.insert(rows_.end(), s.rows.begin() + s.columns, s.rows.end());
        widest_ = std::max(widest_, total);
        const Eigen::Map<const Eigen::MatrixXd> l(s.values.data(), total, s.columns);
        // B = [I; L21] L11^-1
        Eigen::MatrixXd b(total, s.columns);
        b.topRows(s.columns).setIdentity();
        b.bottomRows(p.rows_below) = l.bottomRows(p.rows_below);
        l.topRows(s.columns).triangularView<Eigen::Lower>().solveInPlace<Eigen::OnTheRight>(b);
        p.forward = static_cast<std::int64_t>(values_.size());
        values_.resize(values_.size() + static_cast<std::size_t>(padded(total)) * static_cast<std::size_t>(s.columns),
                       0.0f);
        for (int j = 0; j < s.columns; ++j)
            for (int i = 0; i < total; ++i)
                values_[static_cast<std::size_t>(p.forward) +
                        static_cast<std::size_t>((i / lanes) * lanes * s.columns + j * lanes + i % lanes)] =
                    static_cast<float>(b(i, j));
        p.backward = static_cast<std::int64_t>(values_.size());
        values_.resize(values_.size() + static_cast<std::size_t>(padded(s.columns)) * static_cast<std::size_t>(total),
                       0.0f);
        for (int j = 0; j < s.columns; ++j)
            for (int i = 0; i < total; ++i)
                values_[static_cast<std::size_t>(p.backward) +
                        static_cast<std::size_t>((j / lanes) * lanes * total + i * lanes + j % lanes)] =
                    static_cast<float>(b(i, j));
        supernodes_.push_back(p);
    }
}

void PackedFactor::solve(const double* in, double* out, Workspace& ws) const {
    const std::size_t n = static_cast<std::size_t>(n_);
    ws.x.resize(4 * n);
    ws.scratch.resize(4 * static_cast<std::size_t>(widest_) + 16);
    // Scaled to unit size: single precision must not under- or overflow whatever the units of the right-hand side.
    double top = 0.0;
    for (std::size_t k = 0; k < 3 * n; ++k) top = std::max(top, std::fabs(in[k]));
    if (!(top > 0) || !std::isfinite(top)) {
        std::fill(out, out + 3 * n, 0.0);
        return;
    }
    const double scale = 1.0 / top;
    for (std::size_t k = 0; k < n; ++k) {
        const double* source = in + 3 * static_cast<std::size_t>(permutation_[k]);
        for (std::size_t a = 0; a < 3; ++a) ws.x[4 * k + a] = static_cast<float>(scale * source[a]);
        ws.x[4 * k + 3] = 0.0f;
    }
    kernels_.solve(supernodes_.data(), static_cast<int>(supernodes_.size()), rows_.data(), values_.data(), ws.x.data(),
                   ws.scratch.data());
    for (std::size_t k = 0; k < n; ++k) {
        double* target = out + 3 * static_cast<std::size_t>(permutation_[k]);
        for (std::size_t a = 0; a < 3; ++a) target[a] = top * static_cast<double>(ws.x[4 * k + a]);
    }
}

}  // namespace dqa
