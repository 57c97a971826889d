// SPDX-License-Identifier: MIT
#include "linalg/packed_factor.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <numeric>

namespace dqa {
namespace {

// Of the work: subtrees are split until none is larger. What lies above them is solved by one thread after the other,
// and in a small factor that is much.
constexpr double kSubtreeShare = 1.0 / 10.0, kSmallShare = 1.0 / 4.0;
constexpr int kSmall = 1024;                // unknowns
constexpr int kBatch = 64;                  // blocks that are read at once
constexpr long kParallelEntries = 1 << 14;  // supernodes above the subtrees with fewer are not worth a parallel loop

long work_of(const Supernode& s) {
    return static_cast<long>(s.rows.size()) * s.columns + 64;
}

}  // namespace

PackedFactor::PackedFactor(const CholeskyFactor& factor, Precision precision, InstructionSet instructions)
    : kernels_(linalg_kernels(instructions)), precision_(precision), n_(factor.n), entries_(factor.entries) {
    divide(factor);
    if (precision_ == Precision::single_precision)
        pack(factor, single_);
    else
        pack(factor, double_);
    list_blocks();
}

// Chooses the subtrees and puts their supernodes first, subtree by subtree.
void PackedFactor::divide(const CholeskyFactor& factor) {
    const int count = static_cast<int>(factor.supernodes.size());
    std::vector<int> owner(static_cast<std::size_t>(n_));
    for (int s = 0; s < count; ++s)
        for (int c = 0; c < factor.supernodes[static_cast<std::size_t>(s)].columns; ++c)
            owner[static_cast<std::size_t>(factor.supernodes[static_cast<std::size_t>(s)].first + c)] = s;
    std::vector<int> parent(static_cast<std::size_t>(count), -1);
    std::vector<long> work(static_cast<std::size_t>(count));
    std::vector<std::vector<int>> children(static_cast<std::size_t>(count) + 1);
    for (int s = 0; s < count; ++s) {  // children come before their parents
        const Supernode& node = factor.supernodes[static_cast<std::size_t>(s)];
        work[static_cast<std::size_t>(s)] += work_of(node);
        const bool root = static_cast<int>(node.rows.size()) == node.columns;
        const int p = root ? -1 : owner[static_cast<std::size_t>(node.rows[static_cast<std::size_t>(node.columns)])];
        parent[static_cast<std::size_t>(s)] = p;
        children[static_cast<std::size_t>(root ? count : p)].push_back(s);
        if (!root) work[static_cast<std::size_t>(p)] += work[static_cast<std::size_t>(s)];
    }
    long total = 0;
    for (const int root : children[static_cast<std::size_t>(count)]) total += work[static_cast<std::size_t>(root)];
    const double largest = (n_ <= kSmall ? kSmallShare : kSubtreeShare) * static_cast<double>(total);
    // Roots of the subtrees: descend while a tree is too large a share.
    std::vector<int> open = children[static_cast<std::size_t>(count)], roots, above;
    while (!open.empty()) {
        const int s = open.back();
        open.pop_back();
        const auto& below = children[static_cast<std::size_t>(s)];
        if (static_cast<double>(work[static_cast<std::size_t>(s)]) <= largest) {
            roots.push_back(s);
        } else {
            above.push_back(s);
            open.insert(open.end(), below.begin(), below.end());
        }
    }
    std::sort(roots.begin(), roots.end());
    std::sort(above.begin(), above.end());
    // Neighbouring small subtrees make one task.
    long gathered = 0;
    for (const int root : roots) {
        if (subtrees_.empty() || static_cast<double>(gathered + work[static_cast<std::size_t>(root)]) > largest) {
            const int at = static_cast<int>(order_.size());
            subtrees_.push_back({at, at});
            gathered = 0;
        }
        gathered += work[static_cast<std::size_t>(root)];
        std::vector<int> members{root};
        for (std::size_t k = 0; k < members.size(); ++k) {
            const auto& below = children[static_cast<std::size_t>(members[k])];
            members.insert(members.end(), below.begin(), below.end());
        }
        std::sort(members.begin(), members.end());
        order_.insert(order_.end(), members.begin(), members.end());
        subtrees_.back().end = static_cast<int>(order_.size());
    }
    order_.insert(order_.end(), above.begin(), above.end());
}

template <class Real>
void PackedFactor::pack(const CholeskyFactor& factor, std::vector<Real>& values) {
    constexpr int lanes = kFactorLanes<Real>;
    // New place of every row.
    std::vector<int> place(static_cast<std::size_t>(n_));
    int next = 0;
    for (const int s : order_) {
        const Supernode& node = factor.supernodes[static_cast<std::size_t>(s)];
        PackedSupernode p;
        p.first = next, p.columns = node.columns;
        p.rows_below = static_cast<int>(node.rows.size()) - node.columns;
        for (int c = 0; c < node.columns; ++c) {
            place[static_cast<std::size_t>(node.first + c)] = next++;
            permutation_.push_back(factor.permutation[static_cast<std::size_t>(node.first + c)]);
        }
        widest_ = std::max(widest_, static_cast<int>(node.rows.size()));
        supernodes_.push_back(p);
    }
    top_ = n_;
    const std::size_t below_top = subtrees_.empty() ? 0 : static_cast<std::size_t>(subtrees_.back().end);
    if (below_top < supernodes_.size()) top_ = supernodes_[below_top].first;
    for (const Subtree& t : subtrees_) {
        const PackedSupernode& last = supernodes_[static_cast<std::size_t>(t.end) - 1];
        parts_.push_back({supernodes_[static_cast<std::size_t>(t.begin)].first, last.first + last.columns, 0, 0});
    }
    for (int row = top_; row < n_; row += 3 * kBatch) parts_.push_back({row, std::min(n_, row + 3 * kBatch), 0, 0});
    for (std::size_t k = 0; k < order_.size(); ++k) {
        const Supernode& s = factor.supernodes[static_cast<std::size_t>(order_[k])];
        PackedSupernode& p = supernodes_[k];
        const int total = static_cast<int>(s.rows.size());
        p.row_offset = static_cast<int>(rows_.size());
        for (int r = s.columns; r < total; ++r)
            rows_.push_back(place[static_cast<std::size_t>(s.rows[static_cast<std::size_t>(r)])]);
        const Eigen::Map<const Eigen::MatrixXd> l(s.values.data(), total, s.columns);
        // B = [I; L21] L11^-1
        Eigen::MatrixXd b(total, s.columns);
        b.topRows(s.columns).setIdentity();
        b.bottomRows(p.rows_below) = l.bottomRows(p.rows_below);
        l.topRows(s.columns).triangularView<Eigen::Lower>().solveInPlace<Eigen::OnTheRight>(b);
        const int chunks = (total + lanes - 1) / lanes, column_chunks = (s.columns + lanes - 1) / lanes;
        p.forward = static_cast<std::int64_t>(values.size());
        p.backward = p.forward + packed_forward_offset(lanes, s.columns, chunks * lanes);
        values.resize(
            static_cast<std::size_t>(p.backward + packed_backward_offset(lanes, total, column_chunks * lanes)),
            Real(0));
        for (int j = 0; j < s.columns; ++j)
            for (int i = j; i < total; ++i) {
                const Real value = static_cast<Real>(b(i, j));
                const int r = i / lanes * lanes, c = j / lanes * lanes;
                values[static_cast<std::size_t>(p.forward + packed_forward_offset(lanes, s.columns, r) + j * lanes + i -
                                                r)] = value;
                values[static_cast<std::size_t>(p.backward + packed_backward_offset(lanes, total, c) + (i - c) * lanes +
                                                j - c)] = value;
            }
    }
}

void PackedFactor::list_blocks() {
    if (n_ % 3 != 0) return;
    std::vector<int> seen(static_cast<std::size_t>(n_ / 3), -1);
    for (Part& part : parts_) {
        part.first_block = static_cast<int>(block_.size());
        for (int k = part.first_row; k < part.last_row; ++k) {
            const int i = permutation_[static_cast<std::size_t>(k)];
            int& at = seen[static_cast<std::size_t>(i / 3)];
            if (at < part.first_block) {
                at = static_cast<int>(block_.size());
                block_.push_back(i / 3);
                block_rows_.push_back({-1, -1, -1});
            }
            block_rows_[static_cast<std::size_t>(at)][static_cast<std::size_t>(i % 3)] = k;
        }
        part.last_block = static_cast<int>(block_.size());
    }
}

template <int width, class Real, class Read, class Write>
void PackedFactor::sweep(const FactorKernels<Real>& kernels, const std::vector<Real>& values, Read&& read,
                         Write&& write, Threads threads, Scratch<Real>& ws) const {
    constexpr std::size_t stride = width == 1 ? 1 : 4;
    const std::size_t above = stride * static_cast<std::size_t>(n_ - top_);
    const std::size_t scratch = stride * static_cast<std::size_t>(widest_);
    const int n_subtrees = static_cast<int>(subtrees_.size()), n_parts = static_cast<int>(parts_.size());
    ws.outside.resize(above * subtrees_.size());
    ws.in.resize(scratch * (subtrees_.size() + 1));
    Real* x = ws.x.data();
    Real* x_above = x + stride * static_cast<std::size_t>(top_);
    // A supernode's rows or columns, in pieces over the threads if it is large.
    const auto by_pieces = [&](const PackedSupernode& p, int length, auto&& f) {
        const bool large = static_cast<long>(p.columns) * (p.columns + p.rows_below) >= kParallelEntries;
        const int grain = 4 * kFactorLanes<Real>;
        parallel_chunks(large ? threads : Threads(1), length, large ? grain : std::max(length, 1), f);
    };
    parallel_chunks(threads, n_parts, 1, [&](int t, int) {
        read(parts_[static_cast<std::size_t>(t)]);
        if (t >= n_subtrees) return;
        const Subtree& tree = subtrees_[static_cast<std::size_t>(t)];
        Real* outside = ws.outside.data() + static_cast<std::size_t>(t) * above;
        Real* input = ws.in.data() + static_cast<std::size_t>(t) * scratch;
        std::fill(outside, outside + above, Real(0));
        for (int s = tree.begin; s < tree.end; ++s) {
            const PackedSupernode& p = supernodes_[static_cast<std::size_t>(s)];
            kernels.own(p, x, input);
            kernels.forward(p, rows_.data(), values.data(), input, 0, p.columns + p.rows_below, x, outside, top_);
        }
    });
    for (std::size_t t = 0; t < subtrees_.size(); ++t)
        for (std::size_t k = 0; k < above; ++k) x_above[k] += ws.outside[t * above + k];
    Real* input = ws.in.data() + subtrees_.size() * scratch;
    const std::size_t first_above = subtrees_.empty() ? 0 : static_cast<std::size_t>(subtrees_.back().end);
    for (std::size_t s = first_above; s < supernodes_.size(); ++s) {
        const PackedSupernode& p = supernodes_[s];
        kernels.own(p, x, input);
        by_pieces(p, p.columns + p.rows_below, [&](int begin, int end) {
            kernels.forward(p, rows_.data(), values.data(), input, begin, end, x, x_above, top_);
        });
    }
    for (std::size_t s = supernodes_.size(); s-- > first_above;) {
        const PackedSupernode& p = supernodes_[s];
        kernels.own(p, x, input);
        kernels.below(p, rows_.data(), x, x_above, top_, input);
        by_pieces(p, p.columns, [&](int begin, int end) { kernels.backward(p, values.data(), input, begin, end, x); });
    }
    parallel_chunks(threads, n_parts, 1, [&](int t, int) {
        if (t < n_subtrees) {
            const Subtree& tree = subtrees_[static_cast<std::size_t>(t)];
            Real* own = ws.in.data() + static_cast<std::size_t>(t) * scratch;
            for (int s = tree.end; s-- > tree.begin;) {
                const PackedSupernode& p = supernodes_[static_cast<std::size_t>(s)];
                kernels.own(p, x, own);
                kernels.below(p, rows_.data(), x, x_above, top_, own);
                kernels.backward(p, values.data(), own, 0, p.columns, x);
            }
        }
        write(parts_[static_cast<std::size_t>(t)]);
    });
}

template <class Real>
void PackedFactor::solve_three(const FactorKernels<Real>& kernels, const std::vector<Real>& values, const double* in,
                               double* out, Threads threads, Scratch<Real>& ws) const {
    const std::size_t n = static_cast<std::size_t>(n_);
    ws.x.resize(4 * n);
    // Scaled to unit size: single precision must not under- or overflow whatever the units of the right-hand side.
    double largest = 0.0;
    for (std::size_t k = 0; k < 3 * n; ++k) largest = std::max(largest, std::fabs(in[k]));
    if (!(largest > 0) || !std::isfinite(largest)) {
        std::fill(out, out + 3 * n, 0.0);
        return;
    }
    const double scale = 1.0 / largest;
    Real* x = ws.x.data();
    const auto each_row = [&](const Part& part, auto&& f) {
        for (std::size_t k = static_cast<std::size_t>(part.first_row); k < static_cast<std::size_t>(part.last_row); ++k)
            f(x + 4 * k, 3 * static_cast<std::size_t>(permutation_[k]));
    };
    const auto read = [&](const Part& part) {
        each_row(part, [&](Real* row, std::size_t at) {
            for (std::size_t a = 0; a < 3; ++a) row[a] = static_cast<Real>(scale * in[at + a]);
            row[3] = 0;
        });
    };
    const auto write = [&](const Part& part) {
        each_row(part, [&](const Real* row, std::size_t at) {
            for (std::size_t a = 0; a < 3; ++a) out[at + a] = largest * static_cast<double>(row[a]);
        });
    };
    sweep<3>(kernels, values, read, write, threads, ws);
}

void PackedFactor::solve(const double* in, double* out, Threads threads, Workspace& ws) const {
    if (precision_ == Precision::single_precision)
        solve_three(kernels_.single_factor.three, single_, in, out, threads, ws.single_precision);
    else
        solve_three(kernels_.double_factor.three, double_, in, out, threads, ws.double_precision);
}

template <class Real>
void PackedFactor::solve_one(const FactorKernels<Real>& kernels, const std::vector<Real>& values,
                             const ReadBlocks<Real>& read_blocks, Real* out, Threads threads, Scratch<Real>& ws) const {
    ws.x.resize(static_cast<std::size_t>(n_));
    Real* x = ws.x.data();
    const auto read = [&](const Part& part) {
        Real batch[4 * kBatch];
        for (int first = part.first_block; first < part.last_block; first += kBatch) {
            const int count = std::min(kBatch, part.last_block - first);
            read_blocks(block_.data() + first, count, batch);
            for (int b = 0; b < count; ++b)
                for (std::size_t a = 0; a < 3; ++a) {
                    const int row = block_rows_[static_cast<std::size_t>(first + b)][a];
                    if (row >= 0) x[row] = batch[4 * static_cast<std::size_t>(b) + a];
                }
        }
    };
    const auto write = [&](const Part& part) {
        for (std::size_t b = static_cast<std::size_t>(part.first_block); b < static_cast<std::size_t>(part.last_block);
             ++b)
            for (std::size_t a = 0; a < 3; ++a)
                if (block_rows_[b][a] >= 0) out[4 * static_cast<std::size_t>(block_[b]) + a] = x[block_rows_[b][a]];
    };
    sweep<1>(kernels, values, read, write, threads, ws);
}

void PackedFactor::solve(const ReadBlocks<float>& read, float* out, Threads threads, Workspace& ws) const {
    solve_one(kernels_.single_factor.one, single_, read, out, threads, ws.single_precision);
}
void PackedFactor::solve(const ReadBlocks<double>& read, double* out, Threads threads, Workspace& ws) const {
    solve_one(kernels_.double_factor.one, double_, read, out, threads, ws.double_precision);
}

}  // namespace dqa
