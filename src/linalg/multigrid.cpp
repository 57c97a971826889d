// SPDX-License-Identifier: MIT
#include "linalg/multigrid.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <map>

#include "linalg/nested_dissection.hpp"

namespace dqa {
namespace {

constexpr std::size_t kCoarsest = 320;  // nodes that a direct solve takes
constexpr double kDamping = 1.2;        // over the largest eigenvalue of D^-1 H: smooths well, and is below 2
constexpr int kGrain = 64;              // nodes a chunk

// Q^T M Q for the trilinear Q of a transfer.
BlockMatrix galerkin(const BlockMatrix& fine, const GridTransfer& q) {
    BlockMatrix out;
    const std::size_t n = q.coarse.size();
    std::vector<int> slot(n, -1);
    for (std::size_t c = 0; c < n; ++c) {
        const std::size_t first = out.column.size();
        for (int s = q.coarse_start[c]; s < q.coarse_start[c + 1]; ++s) {
            const std::size_t i = static_cast<std::size_t>(q.coarse_to[static_cast<std::size_t>(s)]);
            const double w = static_cast<double>(q.coarse_weight[static_cast<std::size_t>(s)]);
            for (int k = fine.start[i]; k < fine.start[i + 1]; ++k) {
                const std::size_t j = static_cast<std::size_t>(fine.column[static_cast<std::size_t>(k)]);
                const auto& block = fine.block[static_cast<std::size_t>(k)];
                const double factor = w * static_cast<double>(q.fine_weight[j]);
                for (const int other : q.fine_from[j]) {
                    if (other == static_cast<int>(n)) break;
                    int& at = slot[static_cast<std::size_t>(other)];
                    if (at < 0) {
                        at = static_cast<int>(out.column.size());
                        out.column.push_back(other);
                        out.block.push_back({});
                    }
                    auto& sum = out.block[static_cast<std::size_t>(at)];
                    for (std::size_t e = 0; e < 9; ++e) sum[e] += factor * block[e];
                }
            }
        }
        for (std::size_t k = first; k < out.column.size(); ++k) slot[static_cast<std::size_t>(out.column[k])] = -1;
        out.start.push_back(static_cast<int>(out.column.size()));
    }
    return out;
}

std::vector<std::array<double, 9>> diagonal_inverses(const BlockMatrix& m) {
    std::vector<std::array<double, 9>> inverse(static_cast<std::size_t>(m.size()));
    for (std::size_t i = 0; i < inverse.size(); ++i)
        for (int k = m.start[i]; k < m.start[i + 1]; ++k)
            if (m.column[static_cast<std::size_t>(k)] == static_cast<int>(i))
                inverse[i] = invert_block(m.block[static_cast<std::size_t>(k)]);
    return inverse;
}

// Largest eigenvalue of D^-1 M by power iteration, from below.
double largest_eigenvalue(const BlockMatrix& m, const std::vector<std::array<double, 9>>& inverse) {
    const std::size_t n = inverse.size();
    std::vector<Eigen::Vector3d> x(n), y(n);
    for (std::size_t i = 0; i < n; ++i)  // rough: the largest eigenvalues belong to modes that alternate
        x[i] = Eigen::Vector3d(i % 2 ? -1.0 : 1.0, i / 2 % 2 ? -1.0 : 1.0, i / 3 % 2 ? -1.0 : 1.0);
    double value = 0.0;
    for (int iteration = 0; iteration < 12; ++iteration) {
        double norm = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            Eigen::Vector3d sum = Eigen::Vector3d::Zero();
            for (int k = m.start[i]; k < m.start[i + 1]; ++k)
                sum += Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
                           m.block[static_cast<std::size_t>(k)].data()) *
                       x[static_cast<std::size_t>(m.column[static_cast<std::size_t>(k)])];
            y[i] = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(inverse[i].data()) * sum;
            norm = std::max(norm, y[i].cwiseAbs().maxCoeff());
        }
        if (!(norm > 0)) return 1.0;
        value = norm;
        for (std::size_t i = 0; i < n; ++i) x[i] = y[i] / norm;
    }
    return value;
}

}  // namespace

std::array<double, 9> invert_block(const std::array<double, 9>& block) {
    Eigen::Matrix3d m = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(block.data());
    bool absent[3];
    for (int a = 0; a < 3; ++a) {
        absent[a] = !(m(a, a) > 0);
        if (absent[a]) m.row(a).setZero(), m.col(a).setZero(), m(a, a) = 1.0;
    }
    Eigen::LLT<Eigen::Matrix3d> llt(m);
    if (llt.info() != Eigen::Success) {
        m = Eigen::Matrix3d(m.diagonal().asDiagonal());
        llt.compute(m);
    }
    Eigen::Matrix3d inverse = llt.solve(Eigen::Matrix3d::Identity());
    for (int a = 0; a < 3; ++a)
        if (absent[a]) inverse(a, a) = 0.0;
    std::array<double, 9> out;
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(out.data()) = inverse;
    return out;
}

GridTransfer::GridTransfer(const std::vector<GridNode>& fine) {
    std::map<GridNode, int> index;
    std::vector<std::vector<std::pair<int, float>>> rows;
    for (std::size_t n = 0; n < fine.size(); ++n) {
        float weight = 1.0f;
        for (const int at : fine[n])
            if (at % 2) weight *= 0.5f;
        std::array<int, 8> from;
        from.fill(-1);
        std::size_t count = 0;
        for (int corner = 0; corner < 8; ++corner) {
            GridNode at{};
            bool counts = true;
            for (std::size_t a = 0; a < 3; ++a) {
                const int side = corner >> a & 1;
                at[a] = fine[n][a] / 2 + side;
                counts &= !side || fine[n][a] % 2;
            }
            if (!counts) continue;
            const auto [place, fresh] = index.try_emplace(at, static_cast<int>(coarse.size()));
            if (fresh) coarse.push_back(at), rows.emplace_back();
            from[count++] = place->second;
            rows[static_cast<std::size_t>(place->second)].emplace_back(static_cast<int>(n), weight);
        }
        fine_from.push_back(from), fine_weight.push_back(weight);
    }
    for (auto& from : fine_from)
        for (int& c : from)
            if (c < 0) c = static_cast<int>(coarse.size());
    for (const auto& row : rows) {
        for (const auto& [n, weight] : row) coarse_to.push_back(n), coarse_weight.push_back(weight);
        coarse_start.push_back(static_cast<int>(coarse_to.size()));
    }
}

template <class Real>
Multigrid<Real>::Multigrid(std::vector<GridNode> nodes, BlockMatrix matrix, InstructionSet instructions)
    : kernels_(grid_kernels(instructions).grid.in(Real())) {
    while (nodes.size() > kCoarsest) {
        Level level;
        level.start = matrix.start, level.column = matrix.column;
        level.block.resize(12 * matrix.block.size());
        for (std::size_t k = 0; k < matrix.block.size(); ++k)
            by_columns(matrix.block[k].data(), 1.0, level.block.data() + 12 * k);
        const auto inverse = diagonal_inverses(matrix);
        const double damping = kDamping / largest_eigenvalue(matrix, inverse);
        level.inverse.resize(12 * inverse.size());
        for (std::size_t i = 0; i < inverse.size(); ++i)
            by_columns(inverse[i].data(), damping, level.inverse.data() + 12 * i);
        level.transfer = std::make_unique<GridTransfer>(nodes);
        if (level.transfer->coarse.size() >= nodes.size()) break;  // scattered nodes that no coarser grid gathers
        matrix = galerkin(matrix, *level.transfer);
        nodes = level.transfer->coarse;
        levels_.push_back(std::move(level));
    }
    std::vector<std::vector<std::pair<int, double>>> columns(3 * nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i)
        for (std::size_t a = 0; a < 3; ++a) {
            const std::size_t here = 3 * i + a;  // of a symmetric matrix the rows are the columns
            for (int k = matrix.start[i]; k < matrix.start[i + 1]; ++k)
                for (std::size_t b = 0; b < 3; ++b) {
                    const std::size_t row =
                        3 * static_cast<std::size_t>(matrix.column[static_cast<std::size_t>(k)]) + b;
                    double value = matrix.block[static_cast<std::size_t>(k)][3 * a + b];
                    // Never singular to rounding; a coordinate that is constrained everywhere has nothing but this.
                    if (row == here) value += value > 0 ? 1e-9 * value : 1.0;
                    if (row >= here) columns[here].emplace_back(static_cast<int>(row), value);
                }
        }
    const SymmetricMatrix lower = matrix_from_columns(columns);
    std::vector<int> order;
    for (const int c : nested_dissection(nodes))
        for (int axis = 0; axis < 3; ++axis) order.push_back(3 * c + axis);
    coarsest_ = std::make_unique<PackedFactor>(
        factorise(lower, order), sizeof(Real) == 4 ? Precision::single_precision : Precision::double_precision,
        instructions);
}

template <class Real>
void Multigrid<Real>::prepare(Workspace& ws) const {
    const std::size_t count = levels_.size() + 1;
    ws.right.resize(count), ws.solution.resize(count), ws.residual.resize(count);
    for (std::size_t l = 0; l < count; ++l) {
        const std::size_t n =
            4 * static_cast<std::size_t>(l < levels_.size() ? levels_[l].size() : coarsest_->size() / 3);
        ws.right[l].resize(n), ws.solution[l].resize(n + 4), ws.residual[l].resize(n + 4);
        for (auto* values : {&ws.solution[l], &ws.residual[l]}) std::fill(values->end() - 4, values->end(), Real(0));
    }
}

template <class Real>
std::int64_t Multigrid<Real>::bytes() const {
    std::size_t sum = 2 * static_cast<std::size_t>(coarsest_->entries()) * sizeof(Real);
    for (const Level& l : levels_)
        sum += (l.block.size() + l.inverse.size()) * sizeof(Real) + l.column.size() * sizeof(int) + l.transfer->bytes();
    return static_cast<std::int64_t>(sum);
}

template <class Real>
const Real* Multigrid<Real>::solve(const GridTransfer& transfer, const Real* fine, Threads threads,
                                   Workspace& ws) const {
    prepare(ws);
    return cycle(0, transfer, fine, threads, ws);
}

// Loops are few, as every end of one waits for all threads: what is done node by node joins the loop that has its
// input.
template <class Real>
const Real* Multigrid<Real>::cycle(std::size_t l, const GridTransfer& transfer, const Real* fine, Threads threads,
                                   Workspace& ws) const {
    Real *right = ws.right[l].data(), *x = ws.solution[l].data();
    const int n = static_cast<int>(ws.right[l].size() / 4);
    const TransferRows down = transfer.rows();
    if (l == levels_.size()) {
        const PackedFactor::ReadBlocks<Real> read = [&](const int* blocks, int count, Real* values) {
            kernels_.restrict_to(down, blocks, count, fine, values);
        };
        coarsest_->solve(read, x, threads, ws.factor);
        return x;
    }
    const LevelRows<Real> level = levels_[l].rows();
    Real* residual = ws.residual[l].data();
    parallel_chunks(threads, n, kGrain,
                    [&](int begin, int end) { kernels_.begin_smooth(level, down, fine, begin, end, right, x); });
    parallel_chunks(threads, n, kGrain,
                    [&](int begin, int end) { kernels_.residual(level, right, x, begin, end, residual); });
    const Real* coarse = cycle(l + 1, *levels_[l].transfer, residual, threads, ws);
    const TransferRows up = levels_[l].transfer->rows();
    parallel_chunks(threads, n, kGrain, [&](int begin, int end) { kernels_.correct(up, coarse, begin, end, x); });
    Real* smoothed = residual;
    parallel_chunks(threads, n, kGrain,
                    [&](int begin, int end) { kernels_.end_smooth(level, right, x, begin, end, smoothed); });
    return smoothed;
}

template class Multigrid<float>;
template class Multigrid<double>;

}  // namespace dqa
