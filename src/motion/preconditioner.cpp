// SPDX-License-Identifier: MIT
#include "motion/preconditioner.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "linalg/nested_dissection.hpp"

namespace dqa {
namespace {

constexpr int kNodeGrain = 256;
constexpr int kCoarsening = 3;        // fine cells to a coarse one, each way
constexpr double kCoarseShare = 0.5;  // of the coarse correction: smooth modes that the factor knows well count twice

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
        if (change < 1e-12) return;
    }
}

}  // namespace

Preconditioner::Preconditioner(const ActiveSet& set, const std::vector<double>& cell_weight, PackedFactor factor)
    : factor_(std::move(factor)),
      inv_dx_(1.0 / set.box.dx),
      slab_(set.box.dims == 2 ? 1.0 : 0.0),
      cell_nodes_(set.cell_nodes),
      node_start_(static_cast<std::size_t>(set.n_nodes()) + 1, 0),
      cell_weight_(cell_weight) {
    for (const auto& nodes : cell_nodes_)
        for (const int n : nodes) ++node_start_[static_cast<std::size_t>(n) + 1];
    for (std::size_t n = 1; n < node_start_.size(); ++n) node_start_[n] += node_start_[n - 1];
    node_cells_.resize(static_cast<std::size_t>(node_start_.back()));
    std::vector<int> fill(node_start_.begin(), node_start_.end() - 1);
    for (std::size_t c = 0; c < cell_nodes_.size(); ++c)
        for (const int n : cell_nodes_[c])
            node_cells_[static_cast<std::size_t>(fill[static_cast<std::size_t>(n)]++)] = static_cast<int>(c);
}

void Preconditioner::add_coarse(const ActiveSet& set, const std::vector<int>& constrained,
                                const std::function<void(const double*, double*)>& apply, Precision precision,
                                InstructionSet instructions) {
    // Coarse nodes in the order in which fine nodes first ask for them.
    std::map<std::array<int, 3>, int> index;
    std::vector<std::array<int, 3>> coarse_nodes;
    std::vector<std::vector<std::pair<int, double>>> rows;
    to_fine_.start.push_back(0);
    for (int n = 0; n < n_nodes(); ++n) {
        const auto& ijk = set.node_ijk[static_cast<std::size_t>(n)];
        for (int corner = 0; corner < 8; ++corner) {
            std::array<int, 3> at{};
            double weight = 1.0;
            for (std::size_t a = 0; a < 3; ++a) {
                const int side = corner >> a & 1, low = ijk[a] / kCoarsening;
                const double fraction = static_cast<double>(ijk[a] % kCoarsening) / kCoarsening;
                at[a] = low + side;
                weight *= side ? fraction : 1.0 - fraction;
            }
            if (weight == 0.0) continue;
            const auto [place, fresh] = index.try_emplace(at, static_cast<int>(coarse_nodes.size()));
            if (fresh) coarse_nodes.push_back(at), rows.emplace_back();
            to_fine_.other.push_back(place->second);
            to_fine_.weight.push_back(weight);
            rows[static_cast<std::size_t>(place->second)].emplace_back(n, weight);
        }
        to_fine_.start.push_back(static_cast<int>(to_fine_.other.size()));
    }
    to_coarse_.start.push_back(0);
    for (const auto& row : rows) {
        for (const auto& [n, weight] : row) to_coarse_.other.push_back(n), to_coarse_.weight.push_back(weight);
        to_coarse_.start.push_back(static_cast<int>(to_coarse_.other.size()));
    }
    // Q^T H_0 Q by probing: coarse nodes of equal coordinates modulo 3 are not coupled.
    const std::size_t size = 3 * static_cast<std::size_t>(n_nodes());
    std::vector<std::vector<std::pair<int, double>>> columns(3 * coarse_nodes.size());
    std::vector<double> probe(size), image(size);
    for (int colour = 0; colour < 27; ++colour) {
        std::vector<int> probed;
        for (std::size_t c = 0; c < coarse_nodes.size(); ++c) {
            const auto& k = coarse_nodes[c];
            if ((k[0] % 3) * 9 + (k[1] % 3) * 3 + k[2] % 3 == colour) probed.push_back(static_cast<int>(c));
        }
        for (int axis = 0; axis < 3 && !probed.empty(); ++axis) {
            std::fill(probe.begin(), probe.end(), 0.0);
            for (const int c : probed)
                for (const auto& [n, weight] : rows[static_cast<std::size_t>(c)])
                    probe[static_cast<std::size_t>(3 * n + axis)] = weight;
            for (const int i : constrained) probe[static_cast<std::size_t>(i)] = 0.0;
            apply(probe.data(), image.data());
            for (const int c : probed) {
                const int column = 3 * c + axis;
                for (int o = 0; o < 27; ++o) {
                    auto at = coarse_nodes[static_cast<std::size_t>(c)];
                    at[0] += o / 9 - 1, at[1] += o / 3 % 3 - 1, at[2] += o % 3 - 1;
                    const auto place = index.find(at);
                    if (place == index.end() || 3 * place->second + 2 < column) continue;
                    std::array<double, 3> sum{};
                    for (const auto& [n, weight] : rows[static_cast<std::size_t>(place->second)])
                        for (std::size_t a = 0; a < 3; ++a)
                            sum[a] += weight * image[static_cast<std::size_t>(3 * n) + a];
                    for (int a = 0; a < 3; ++a)
                        if (3 * place->second + a >= column)
                            columns[static_cast<std::size_t>(column)].emplace_back(3 * place->second + a,
                                                                                   sum[static_cast<std::size_t>(a)]);
                }
            }
        }
    }
    SymmetricMatrix matrix;
    matrix.n = static_cast<int>(columns.size());
    matrix.start.push_back(0);
    for (auto& column : columns) {
        std::sort(column.begin(), column.end());
        // Never singular to rounding; a coarse node whose fine nodes are all constrained has nothing but this.
        column.front().second += column.front().second > 0 ? 1e-9 * column.front().second : 1.0;
        for (const auto& [row, value] : column) matrix.row.push_back(row), matrix.value.push_back(value);
        matrix.start.push_back(static_cast<int>(matrix.row.size()));
    }
    std::vector<int> order;
    for (const int c : nested_dissection(coarse_nodes))
        for (int axis = 0; axis < 3; ++axis) order.push_back(3 * c + axis);
    coarse_ = std::make_unique<PackedFactor>(factorise(matrix, order), precision, instructions);
}

// Rotation of the mean deformation gradient of the cells around each node.
void Preconditioner::node_turns(const double* q, Threads threads, std::vector<double>& turns) const {
    const int n_cells = static_cast<int>(cell_nodes_.size()), n_nodes = static_cast<int>(node_start_.size()) - 1;
    std::vector<double> mean(9 * static_cast<std::size_t>(n_cells));
    parallel_chunks(threads, n_cells, kNodeGrain, [&](int begin, int end) {
        for (std::size_t c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
            double* f = mean.data() + 9 * c;
            for (int corner = 0; corner < 8; ++corner) {
                const double* x = q + 3 * cell_nodes_[c][static_cast<std::size_t>(corner)];
                for (int axis = 0; axis < 3; ++axis) {
                    const double s = (corner >> (2 - axis) & 1) != 0 ? 1.0 : -1.0;
                    for (int k = 0; k < 3; ++k) f[3 * k + axis] += s * x[k];
                }
            }
            for (int k = 0; k < 9; ++k) f[k] *= 0.25 * inv_dx_;
            f[8] += slab_;
        }
    });
    turns.resize(9 * static_cast<std::size_t>(n_nodes));
    parallel_chunks(threads, n_nodes, kNodeGrain, [&](int begin, int end) {
        for (std::size_t n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
            double f[9] = {}, weight = 0.0;
            for (int s = node_start_[n]; s < node_start_[n + 1]; ++s) {
                const std::size_t c = static_cast<std::size_t>(node_cells_[static_cast<std::size_t>(s)]);
                for (std::size_t k = 0; k < 9; ++k) f[k] += cell_weight_[c] * mean[9 * c + k];
                weight += cell_weight_[c];
            }
            for (double& x : f) x /= weight;
            turn_of(f, turns.data() + 9 * n);
        }
    });
}

void Preconditioner::turn(const double* q, Threads threads, Workspace& ws) const {
    if (coarse_) node_turns(q, threads, ws.turns);
}

void Preconditioner::solve(const double* in, double* out, Threads threads, Workspace& ws) const {
    factor_.solve(in, out, threads, ws.factor);
    if (!coarse_) return;
    ws.turned.resize(3 * static_cast<std::size_t>(n_nodes()));
    ws.coarse.resize(3 * static_cast<std::size_t>(n_coarse()));
    const double* turns = ws.turns.data();
    double *turned = ws.turned.data(), *coarse = ws.coarse.data();
    parallel_chunks(threads, n_nodes(), kNodeGrain, [&](int begin, int end) {
        for (int n = begin; n < end; ++n) {
            const double *r = turns + 9 * n, *x = in + 3 * n;
            for (int a = 0; a < 3; ++a) turned[3 * n + a] = r[a] * x[0] + r[3 + a] * x[1] + r[6 + a] * x[2];
        }
    });
    parallel_chunks(threads, n_coarse(), kNodeGrain / 8, [&](int begin, int end) {
        for (int c = begin; c < end; ++c) {
            double x = 0.0, y = 0.0, z = 0.0;
            for (int s = to_coarse_.start[static_cast<std::size_t>(c)];
                 s < to_coarse_.start[static_cast<std::size_t>(c) + 1]; ++s) {
                const double w = to_coarse_.weight[static_cast<std::size_t>(s)];
                const double* t = turned + 3 * to_coarse_.other[static_cast<std::size_t>(s)];
                x += w * t[0], y += w * t[1], z += w * t[2];
            }
            coarse[3 * c] = x, coarse[3 * c + 1] = y, coarse[3 * c + 2] = z;
        }
    });
    coarse_->solve(coarse, coarse, threads, ws.coarse_factor, 1);
    parallel_chunks(threads, n_nodes(), kNodeGrain, [&](int begin, int end) {
        for (int n = begin; n < end; ++n) {
            double x = 0.0, y = 0.0, z = 0.0;
            for (int s = to_fine_.start[static_cast<std::size_t>(n)];
                 s < to_fine_.start[static_cast<std::size_t>(n) + 1]; ++s) {
                const double w = kCoarseShare * to_fine_.weight[static_cast<std::size_t>(s)];
                const double* t = coarse + 3 * to_fine_.other[static_cast<std::size_t>(s)];
                x += w * t[0], y += w * t[1], z += w * t[2];
            }
            const double* r = turns + 9 * n;
            for (int a = 0; a < 3; ++a) out[3 * n + a] += r[3 * a] * x + r[3 * a + 1] * y + r[3 * a + 2] * z;
        }
    });
}

}  // namespace dqa
