// SPDX-License-Identifier: MIT
#include "motion/preconditioner.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <type_traits>

#include "linalg/pcg.hpp"

namespace dqa {
namespace {

constexpr int kGrain = 64;            // nodes or cells a chunk
constexpr double kLocalShare = 0.8;   // of the diagonal blocks beside the coarse grids
constexpr double kFactorShare = 0.5;  // of the coarse grids beside the factor, which knows many smooth modes as well

// Polar factor of f (row-major 3 x 3) by Newton's iteration; the identity where f is singular or inverted: a
// preconditioner may be wrong there, but not undefined.
void turn_of(const double* f, double* r) {
    const auto identity = [&] {
        for (int k = 0; k < 9; ++k) r[k] = k % 4 == 0 ? 1.0 : 0.0;
    };
    for (int k = 0; k < 9; ++k) r[k] = f[k];
    for (int iteration = 0; iteration < 6; ++iteration) {
        const double c[9] = {r[4] * r[8] - r[5] * r[7], r[5] * r[6] - r[3] * r[8], r[3] * r[7] - r[4] * r[6],
                             r[2] * r[7] - r[1] * r[8], r[0] * r[8] - r[2] * r[6], r[1] * r[6] - r[0] * r[7],
                             r[1] * r[5] - r[2] * r[4], r[2] * r[3] - r[0] * r[5], r[0] * r[4] - r[1] * r[3]};
        const double det = r[0] * c[0] + r[1] * c[1] + r[2] * c[2];
        if (!(det > 1e-3) || !std::isfinite(det)) return identity();
        double change = 0.0;
        for (int k = 0; k < 9; ++k) {
            const double next = 0.5 * (r[k] + c[k] / det);
            change += (next - r[k]) * (next - r[k]);
            r[k] = next;
        }
        if (change < 1e-10) return;
    }
    // Not converged: strongly sheared cells. What is left is too far from a rotation to be trusted.
    identity();
}

struct Products {
    double with_in = 0.0, with_other = 0.0;
    void operator+=(const Products& o) { with_in += o.with_in, with_other += o.with_other; }
};

bool of_colour(const GridNode& node, int period, int colour) {
    return (node[0] % period * period + node[1] % period) * period + node[2] % period == colour;
}

// The diagonal blocks of an operator on grid nodes that couple one apart, by probing: nodes of equal parity do not.
std::vector<std::array<double, 9>> diagonal_blocks(const std::vector<GridNode>& nodes, const std::vector<char>& free,
                                                   const std::function<void(const double*, double*)>& apply) {
    const std::size_t n = nodes.size();
    std::vector<std::array<double, 9>> blocks(n);
    std::vector<double> probe(3 * n), image(3 * n);
    for (int colour = 0; colour < 8; ++colour) {
        if (std::none_of(nodes.begin(), nodes.end(), [&](const GridNode& k) { return of_colour(k, 2, colour); }))
            continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t a = 0; a < 3; ++a)
                    probe[3 * i + a] = a == axis && free[3 * i + a] && of_colour(nodes[i], 2, colour) ? 1.0 : 0.0;
            apply(probe.data(), image.data());
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t a = 0; a < 3 && of_colour(nodes[i], 2, colour); ++a)
                    blocks[i][3 * a + axis] = image[3 * i + a];
        }
    }
    return blocks;
}

// Q^T H Q by probing: coarse nodes of equal coordinates modulo 3 are not coupled.
BlockMatrix coarse_matrix(const GridTransfer& q, std::size_t n_fine, const std::vector<char>& free,
                          const std::function<void(const double*, double*)>& apply) {
    const std::size_t n = q.coarse.size();
    std::map<GridNode, int> index;
    for (std::size_t c = 0; c < n; ++c) index.emplace(q.coarse[c], static_cast<int>(c));
    BlockMatrix matrix;
    for (const GridNode& node : q.coarse) {
        for (int o = 0; o < 27; ++o) {
            const auto at = index.find({node[0] + o / 9 - 1, node[1] + o / 3 % 3 - 1, node[2] + o % 3 - 1});
            if (at != index.end()) matrix.column.push_back(at->second);
        }
        matrix.start.push_back(static_cast<int>(matrix.column.size()));
    }
    matrix.block.resize(matrix.column.size());
    std::vector<double> probe(3 * n_fine), image(3 * n_fine), sums(3 * n);
    for (int colour = 0; colour < 27; ++colour) {
        std::vector<char> probed(n);
        for (std::size_t c = 0; c < n; ++c) probed[c] = of_colour(q.coarse[c], 3, colour);
        if (std::find(probed.begin(), probed.end(), 1) == probed.end()) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            std::fill(probe.begin(), probe.end(), 0.0);
            for (std::size_t c = 0; c < n; ++c)
                for (int s = q.coarse_start[c]; probed[c] && s < q.coarse_start[c + 1]; ++s) {
                    const std::size_t i = 3 * static_cast<std::size_t>(q.coarse_to[static_cast<std::size_t>(s)]) + axis;
                    if (free[i]) probe[i] = static_cast<double>(q.coarse_weight[static_cast<std::size_t>(s)]);
                }
            apply(probe.data(), image.data());
            std::fill(sums.begin(), sums.end(), 0.0);
            for (std::size_t c = 0; c < n; ++c)
                for (int s = q.coarse_start[c]; s < q.coarse_start[c + 1]; ++s)
                    for (std::size_t a = 0; a < 3; ++a)
                        sums[3 * c + a] +=
                            static_cast<double>(q.coarse_weight[static_cast<std::size_t>(s)]) *
                            image[3 * static_cast<std::size_t>(q.coarse_to[static_cast<std::size_t>(s)]) + a];
            // The one probed neighbour of each node gave its sums.
            for (std::size_t c = 0; c < n; ++c)
                for (int k = matrix.start[c]; k < matrix.start[c + 1]; ++k)
                    if (probed[static_cast<std::size_t>(matrix.column[static_cast<std::size_t>(k)])])
                        for (std::size_t a = 0; a < 3; ++a)
                            matrix.block[static_cast<std::size_t>(k)][3 * a + axis] = sums[3 * c + a];
        }
    }
    return matrix;
}

}  // namespace

Preconditioner::Preconditioner(const ActiveSet& set, const std::vector<double>& cell_weight,
                               const std::vector<int>& constrained,
                               const std::function<void(const double*, double*)>& apply,
                               std::unique_ptr<PackedFactor> factor, Precision precision, InstructionSet instructions)
    : kernels_(grid_kernels(instructions)),
      precision_(precision),
      factor_(std::move(factor)),
      nodes_(set.node_ijk),
      transfer_(nodes_),
      inv_dx_(1.0 / set.box.dx),
      slab_(set.box.dims == 2 ? 1.0 : 0.0),
      cell_nodes_(set.cell_nodes),
      node_start_(set.node_cell_start),
      node_cells_(set.node_cells),
      cell_weight_(cell_weight) {
    if (precision_ == Precision::single_precision)
        build(single_, constrained, apply, instructions);
    else
        build(double_, constrained, apply, instructions);
}

template <class Real>
void Preconditioner::build(Parts<Real>& parts, const std::vector<int>& constrained,
                           const std::function<void(const double*, double*)>& apply, InstructionSet instructions) {
    std::vector<char> free(3 * nodes_.size(), 1);
    for (const int i : constrained) free[static_cast<std::size_t>(i)] = 0;
    parts.coarse = std::make_unique<Multigrid<Real>>(
        transfer_.coarse, coarse_matrix(transfer_, nodes_.size(), free, apply), instructions);
    if (factor_) return;
    const auto blocks = diagonal_blocks(nodes_, free, apply);
    parts.local.resize(12 * nodes_.size());
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
        const auto inverse = invert_block(blocks[n]);
        by_columns(inverse.data(), kLocalShare, parts.local.data() + 12 * n);
    }
}

long Preconditioner::factor_entries() const {
    return (factor_ ? factor_->entries() : 0) + (single_.coarse ? single_.coarse->factor_entries() : 0) +
           (double_.coarse ? double_.coarse->factor_entries() : 0);
}

std::int64_t Preconditioner::bytes() const {
    const bool single = precision_ == Precision::single_precision;
    const std::size_t real = single ? sizeof(float) : sizeof(double), n = nodes_.size();
    const std::size_t factor = factor_ ? 2 * static_cast<std::size_t>(factor_->entries()) * real : 12 * n * real;
    return static_cast<std::int64_t>(2 * 12 * n * real + transfer_.bytes() + factor) +
           (single ? single_.coarse->bytes() : double_.coarse->bytes());
}

// Rotation of the mean deformation gradient of the cells around each node.
template <class Real>
void Preconditioner::turn_with(const double* q, Threads threads, Workspace& ws, Scratch<Real>& scratch) const {
    ws.mean.resize(9 * cell_nodes_.size());
    parallel_chunks(threads, static_cast<int>(cell_nodes_.size()), kGrain, [&](int begin, int end) {
        for (std::size_t c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
            double f[9] = {};
            for (int corner = 0; corner < 8; ++corner) {
                const double* x = q + 3 * cell_nodes_[c][static_cast<std::size_t>(corner)];
                for (int axis = 0; axis < 3; ++axis) {
                    const double s = (corner >> (2 - axis) & 1) != 0 ? 1.0 : -1.0;
                    for (int k = 0; k < 3; ++k) f[3 * k + axis] += s * x[k];
                }
            }
            for (std::size_t k = 0; k < 9; ++k) ws.mean[9 * c + k] = 0.25 * inv_dx_ * f[k];
            ws.mean[9 * c + 8] += slab_;
        }
    });
    scratch.turns.resize(12 * nodes_.size());
    parallel_chunks(threads, n_nodes(), kGrain, [&](int begin, int end) {
        for (std::size_t n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
            double f[9] = {}, r[9], weight = 0.0;
            for (int s = node_start_[n]; s < node_start_[n + 1]; ++s) {
                const std::size_t c = static_cast<std::size_t>(node_cells_[static_cast<std::size_t>(s)]);
                for (std::size_t k = 0; k < 9; ++k) f[k] += cell_weight_[c] * ws.mean[9 * c + k];
                weight += cell_weight_[c];
            }
            for (double& x : f) x /= weight;
            turn_of(f, r);
            by_columns(r, 1.0, scratch.turns.data() + 12 * n);
        }
    });
}

void Preconditioner::turn(const double* q, Threads threads, Workspace& ws) const {
    if (precision_ == Precision::single_precision)
        turn_with(q, threads, ws, ws.single_precision);
    else
        turn_with(q, threads, ws, ws.double_precision);
}

template <class Real, class T>
double Preconditioner::descend_with(T step, const T* p, const T* ap, T* x, T* r, double norm, Threads threads,
                                    Scratch<Real>& scratch) const {
    scratch.turned.resize(4 * nodes_.size());
    const auto& kernels = kernels_.turns.in(Real()).vectors.in(T());
    const T scale = static_cast<T>(1.0 / norm);
    return parallel_sum(threads, n_nodes(), kGrain, [&](int begin, int end) {
        for (int i = 3 * begin; i < 3 * end; ++i) x[i] += step * p[i], r[i] -= step * ap[i];
        kernels.back(scratch.turns.data(), scale, r, begin, end, scratch.turned.data());
        return ordered_dot(r + 3 * begin, r + 3 * begin, 3 * static_cast<std::size_t>(end - begin));
    });
}

template <class T>
double Preconditioner::descend(T step, const T* p, const T* ap, T* x, T* r, double norm, Threads threads,
                               Workspace& ws) const {
    return precision_ == Precision::single_precision
               ? descend_with(step, p, ap, x, r, norm, threads, ws.single_precision)
               : descend_with(step, p, ap, x, r, norm, threads, ws.double_precision);
}
template double Preconditioner::descend(double, const double*, const double*, double*, double*, double, Threads,
                                        Workspace&) const;
template double Preconditioner::descend(float, const float*, const float*, float*, float*, double, Threads,
                                        Workspace&) const;

template <class Real, class T>
std::array<double, 2> Preconditioner::solve_with(const Parts<Real>& parts, const T* in, double norm, bool descended,
                                                 const T* other, T* out, Threads threads, Workspace& ws,
                                                 Scratch<Real>& scratch) const {
    if (!(norm > 0) || !std::isfinite(norm)) {
        std::fill(out, out + 3 * nodes_.size(), T(0));
        return {};
    }
    // Scaled to unit size: single precision must not under- or overflow whatever the units of the right-hand side.
    const T size = static_cast<T>(norm), scale = static_cast<T>(1.0 / norm);
    if constexpr (std::is_same_v<T, double>)
        if (factor_) factor_->solve(in, out, threads, ws.factor);
    const auto& kernels = kernels_.turns.in(Real()).vectors.in(T());
    scratch.turned.resize(4 * nodes_.size());
    const Real* turns = scratch.turns.data();
    Real* turned = scratch.turned.data();
    if (!descended)
        parallel_chunks(threads, n_nodes(), kGrain,
                        [&](int begin, int end) { kernels.back(turns, scale, in, begin, end, turned); });
    const Real* coarse = parts.coarse->solve(transfer_, turned, threads, scratch.coarse);
    const Real share = factor_ ? static_cast<Real>(kFactorShare) : Real(1);
    const Real* local = factor_ ? nullptr : parts.local.data();
    const TransferRows transfer = transfer_.rows();
    const Products sums = parallel_total<Products>(threads, n_nodes(), kGrain, [&](int begin, int end) {
        double of_chunk[2];
        kernels.out(turns, local, transfer, coarse, share, size, turned, in, other, begin, end, out, of_chunk);
        return Products{of_chunk[0], of_chunk[1]};
    });
    return {sums.with_in, sums.with_other};
}

template <class T>
std::array<double, 2> Preconditioner::solve(const T* in, double norm, bool descended, const T* other, T* out,
                                            Threads threads, Workspace& ws) const {
    return precision_ == Precision::single_precision
               ? solve_with(single_, in, norm, descended, other, out, threads, ws, ws.single_precision)
               : solve_with(double_, in, norm, descended, other, out, threads, ws, ws.double_precision);
}
template std::array<double, 2> Preconditioner::solve(const double*, double, bool, const double*, double*, Threads,
                                                     Workspace&) const;
template std::array<double, 2> Preconditioner::solve(const float*, double, bool, const float*, float*, Threads,
                                                     Workspace&) const;

void Preconditioner::solve(const double* in, double* out, Threads threads, Workspace& ws) const {
    solve(in, ordered_norm(in, 3 * nodes_.size(), threads), false, in, out, threads, ws);
}

}  // namespace dqa
