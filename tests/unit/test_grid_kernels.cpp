// SPDX-License-Identifier: MIT
// The loops of the multigrid cycle and of the preconditioner: every instruction set against their definitions, in
// single and in double precision, and on ranges of the nodes.
#include "linalg/grid_kernels.hpp"
#include "linalg/multigrid.hpp"
#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;

// Nodes of a grid with holes, neighbours one apart coupled at random: rows of 1 to 27 blocks.
template <class Real>
struct Grid {
    std::vector<GridNode> nodes;
    GridTransfer transfer;
    std::vector<int> start{0}, column;
    std::vector<Real> block, inverse, turns, local;
    Random random{11};

    Grid() : nodes(holed()), transfer(nodes) {
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            for (std::size_t j = 0; j < nodes.size(); ++j) {
                int apart = 0;
                for (std::size_t a = 0; a < 3; ++a) apart = std::max(apart, std::abs(nodes[i][a] - nodes[j][a]));
                if (apart <= 1 && (i == j || i % 5 != 0)) column.push_back(static_cast<int>(j));
            }
            start.push_back(static_cast<int>(column.size()));
        }
        block = padded_blocks(column.size());
        inverse = padded_blocks(nodes.size()), turns = padded_blocks(nodes.size()), local = padded_blocks(nodes.size());
    }
    static std::vector<GridNode> holed() {
        std::vector<GridNode> out;
        for (int i = 0; i < 5; ++i)
            for (int j = 0; j < 4; ++j)
                for (int k = 0; k < 6; ++k)
                    if ((7 * i + 3 * j + k) % 6 != 0) out.push_back({i, j, k});
        return out;
    }
    std::vector<Real> numbers(std::size_t n) {
        std::vector<Real> out;
        for (const double x : random_vector(n, random)) out.push_back(static_cast<Real>(x));
        return out;
    }
    std::vector<Real> padded_vectors(std::size_t n) {
        std::vector<Real> out = numbers(4 * n);
        for (std::size_t k = 3; k < out.size(); k += 4) out[k] = 0;
        return out;
    }
    std::vector<Real> padded_blocks(std::size_t n) { return padded_vectors(3 * n); }
    LevelRows<Real> rows() const { return {start.data(), column.data(), block.data(), inverse.data()}; }
    int size() const { return static_cast<int>(nodes.size()); }
    int coarse_size() const { return static_cast<int>(transfer.coarse.size()); }
};

// y += scale M x of a block by columns, or of its transpose.
template <class Real>
void add_product(const Real* block, const double* x, double scale, bool transposed, double* y) {
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            y[row] += scale * static_cast<double>(block[transposed ? 4 * row + column : 4 * column + row]) * x[column];
}

// Values [n][4] in double precision, [n][3].
template <class Real>
Vector plain(const std::vector<Real>& padded) {
    Vector out;
    for (std::size_t k = 0; k < padded.size(); ++k)
        if (k % 4 != 3) out.push_back(static_cast<double>(padded[k]));
    return out;
}

// Q [fine][coarse] by its definition: products of hat functions.
Vector interpolation(const std::vector<GridNode>& fine, const std::vector<GridNode>& coarse) {
    Vector q;
    for (const GridNode& f : fine)
        for (const GridNode& c : coarse) {
            double weight = 1.0;
            for (std::size_t a = 0; a < 3; ++a) weight *= std::max(0.0, 1.0 - 0.5 * std::abs(f[a] - 2 * c[a]));
            q.push_back(weight);
        }
    return q;
}

Vector transferred(const Vector& q, std::size_t n_coarse, const Vector& x, bool down) {
    const std::size_t n_fine = q.size() / n_coarse;
    Vector out(3 * (down ? n_coarse : n_fine));
    for (std::size_t f = 0; f < n_fine; ++f)
        for (std::size_t c = 0; c < n_coarse; ++c)
            for (std::size_t a = 0; a < 3; ++a)
                out[3 * (down ? c : f) + a] += q[f * n_coarse + c] * x[3 * (down ? f : c) + a];
    return out;
}

constexpr InstructionSet kSets[] = {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512};

template <class Real>
void grid_loops() {
    const double rounding = sizeof(Real) == sizeof(float) ? 2e-6 : 1e-14;
    Grid<Real> g;
    const int n = g.size(), m = g.coarse_size();
    const std::size_t coarse_nodes = g.transfer.coarse.size(), nodes = g.nodes.size();
    const Vector q = interpolation(g.nodes, g.transfer.coarse);
    const auto near = [&](const std::vector<Real>& got, const Vector& wanted) {
        NEAR(relative_difference(plain(got), wanted), 0.0, rounding);
        for (std::size_t k = 3; k < got.size(); k += 4) CHECK(got[k] == Real(0));
    };
    const std::vector<Real> fine = g.padded_vectors(nodes), right = g.padded_vectors(nodes),
                            x = g.padded_vectors(nodes);
    std::vector<Real> coarse = g.padded_vectors(coarse_nodes);
    const Vector restricted = transferred(q, coarse_nodes, plain(fine), true);
    const Vector interpolated = transferred(q, coarse_nodes, plain(coarse), false);
    coarse.resize(coarse.size() + 4);  // where rows of Q have fewer than eight entries
    const Vector flat_x = plain(x);
    Vector left = plain(right), smoothed = flat_x;
    for (std::size_t i = 0; i < nodes; ++i) {
        for (int k = g.start[i]; k < g.start[i + 1]; ++k)
            add_product(g.block.data() + 12 * k, flat_x.data() + 3 * g.column[static_cast<std::size_t>(k)], -1.0, false,
                        left.data() + 3 * i);
        add_product(g.inverse.data() + 12 * i, left.data() + 3 * i, 1.0, false, smoothed.data() + 3 * i);
    }
    for (const InstructionSet set : kSets) {
        const GridKernels<Real>& kernels = grid_kernels(set).grid.in(Real());
        const TransferRows rows = g.transfer.rows();
        std::vector<int> listed;
        for (int c = m; c-- > 0;) listed.push_back(c);
        std::vector<Real> out(4 * coarse_nodes), backwards(out.size());
        kernels.restrict_to(rows, listed.data(), m, fine.data(), backwards.data());
        for (std::size_t c = 0; c < coarse_nodes; ++c)
            std::copy_n(backwards.begin() + static_cast<long>(4 * (coarse_nodes - 1 - c)), 4,
                        out.begin() + static_cast<long>(4 * c));
        near(out, restricted);
        // In two ranges, as the chunks of parallel loops are.
        std::vector<Real> first(out.size()), start(out.size());
        for (const auto& [begin, end] : {std::pair{0, m / 3}, std::pair{m / 3, m}})
            kernels.begin_smooth(g.rows(), rows, fine.data(), begin, end, first.data(), start.data());
        near(first, restricted);
        Vector damped(3 * coarse_nodes);
        for (std::size_t c = 0; c < coarse_nodes; ++c)
            add_product(g.inverse.data() + 12 * c, restricted.data() + 3 * c, 1.0, false, damped.data() + 3 * c);
        near(start, damped);
        std::vector<Real> residual(4 * nodes), last(4 * nodes), corrected = x;
        for (const auto& [begin, end] : {std::pair{0, n / 2}, std::pair{n / 2, n}}) {
            kernels.residual(g.rows(), right.data(), x.data(), begin, end, residual.data());
            kernels.end_smooth(g.rows(), right.data(), x.data(), begin, end, last.data());
            kernels.correct(rows, coarse.data(), begin, end, corrected.data());
        }
        near(residual, left);
        near(last, smoothed);
        near(corrected, plus(flat_x, 1.0, interpolated));
    }
}

template <class Real, class T>
void turned_vectors() {
    const double rounding = sizeof(Real) == sizeof(float) || sizeof(T) == sizeof(float) ? 3e-6 : 1e-14;
    Grid<Real> g;
    const std::size_t nodes = g.nodes.size(), coarse_nodes = g.transfer.coarse.size();
    const auto vectors = [&] {
        std::vector<T> out;
        for (const double v : random_vector(3 * nodes, g.random)) out.push_back(static_cast<T>(v));
        return out;
    };
    const auto wide = [](const std::vector<T>& v) { return Vector(v.begin(), v.end()); };
    const std::vector<T> in = vectors(), other = vectors(), beside = vectors();
    std::vector<Real> coarse = g.padded_vectors(coarse_nodes);
    const Vector up = transferred(interpolation(g.nodes, g.transfer.coarse), coarse_nodes, plain(coarse), false);
    coarse.resize(coarse.size() + 4);
    constexpr double kScale = 0.25, kSize = 4.0, kShare = 0.5;
    Vector turned(3 * nodes), flat_in = wide(in);
    for (std::size_t k = 0; k < nodes; ++k)
        add_product(g.turns.data() + 12 * k, flat_in.data() + 3 * k, kScale, true, turned.data() + 3 * k);
    for (const bool local : {true, false}) {
        Vector wanted = local ? Vector(3 * nodes) : wide(beside);
        for (std::size_t k = 0; k < nodes; ++k) {
            double sum[3];
            for (std::size_t a = 0; a < 3; ++a) sum[a] = kShare * up[3 * k + a];
            if (local) add_product(g.local.data() + 12 * k, turned.data() + 3 * k, 1.0, false, sum);
            add_product(g.turns.data() + 12 * k, sum, kSize, false, wanted.data() + 3 * k);
        }
        for (const InstructionSet set : kSets) {
            const TurnKernels<Real, T>& kernels = grid_kernels(set).turns.in(Real()).vectors.in(T());
            std::vector<Real> back(4 * nodes, Real(7));
            std::vector<T> out = beside;
            double with_in = 0.0, with_other = 0.0;
            const int n = g.size();
            for (const auto& [begin, end] : {std::pair{0, n / 2}, std::pair{n / 2, n}})
                kernels.back(g.turns.data(), static_cast<T>(kScale), in.data(), begin, end, back.data());
            NEAR(relative_difference(plain(back), turned), 0.0, rounding);
            for (std::size_t k = 3; k < back.size(); k += 4) CHECK(back[k] == Real(0));
            for (const auto& [begin, end] : {std::pair{0, n / 2}, std::pair{n / 2, n}}) {
                double sums[2] = {7.0, 7.0};
                kernels.out(g.turns.data(), local ? g.local.data() : nullptr, g.transfer.rows(), coarse.data(),
                            static_cast<Real>(kShare), static_cast<T>(kSize), back.data(), in.data(), other.data(),
                            begin, end, out.data(), sums);
                with_in += sums[0], with_other += sums[1];
            }
            NEAR(relative_difference(wide(out), wanted), 0.0, rounding);
            NEAR(with_in, dot_of(flat_in, wanted), 10 * rounding * norm_of(flat_in) * norm_of(wanted));
            NEAR(with_other, dot_of(wide(other), wanted), 10 * rounding * norm_of(wide(other)) * norm_of(wanted));
        }
    }
}

void test_grid_loops() {
    grid_loops<float>();
    grid_loops<double>();
}
void test_turned_vectors() {
    turned_vectors<float, float>();
    turned_vectors<float, double>();
    turned_vectors<double, float>();
    turned_vectors<double, double>();
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {TEST(test_grid_loops), TEST(test_turned_vectors)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
