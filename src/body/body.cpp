// SPDX-License-Identifier: MIT
#include "body/body.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "grid/parallel.hpp"

namespace dqa {
namespace {

constexpr int kGrain = 8;  // blocks a chunk: the unit of ordered sums

std::vector<int> all_cells(const ActiveSet& set) {
    std::vector<int> out(static_cast<std::size_t>(set.n_cells()));
    std::iota(out.begin(), out.end(), 0);
    return out;
}

std::vector<int> cells_of(const std::vector<MuscleEntry>& muscles) {
    std::vector<int> out;
    for (const MuscleEntry& m : muscles) out.push_back(m.cell);
    return out;
}

void fit(std::vector<double>& v, std::size_t n) {
    if (v.size() != n) v.assign(n, 0.0);
}

}  // namespace

Body::Body(const ActiveSet& set, const std::vector<double>& mu, const std::vector<MuscleEntry>& muscles,
           double contraction, InstructionSet instructions)
    : inv_dx_(1.0 / set.box.dx),
      slab_(set.box.dims == 2 ? 1.0 : 0.0),
      gauss_volume_(set.box.dx * set.box.dx * set.box.dx / 8.0),
      contraction_(contraction),
      kernels_(body_kernels(instructions)),
      muscles_(muscles),
      cells_(set, all_cells(set)),
      entries_(set, cells_of(muscles)) {
    std::vector<double> weight(mu);
    for (double& w : weight) w *= 2.0 * gauss_volume_;
    elastic_weight_ = cells_.blocked(weight);
    std::vector<double> muscle;
    for (const MuscleEntry& m : muscles_) muscle.push_back(m.weight * gauss_volume_);
    muscle_weight_ = entries_.blocked(muscle);
    muscle_direction_.assign(static_cast<std::size_t>(entries_.n_blocks()) * 24, 0.0);
    for (int e = 0; e < entries_.n_blocks() * 8; ++e) {
        const MuscleEntry& m = muscles_[static_cast<std::size_t>(std::min(e, n_muscles() - 1))];
        for (int k = 0; k < 3; ++k)
            muscle_direction_[static_cast<std::size_t>((e / 8) * 24 + k * 8 + e % 8)] =
                m.direction[static_cast<std::size_t>(k)];
    }
}

double Body::gradient(BodyWorkspace& ws, const double* q, const double* signals, Threads threads, double* elastic_out,
                      double* muscle_out) const {
    const std::size_t blocks = static_cast<std::size_t>(cells_.n_blocks());
    const std::size_t groups = static_cast<std::size_t>(entries_.n_blocks());
    fit(ws.elastic_force, blocks * kCellForce), fit(ws.elastic_energy, blocks),
        fit(ws.elastic_cache, blocks * kElasticCache);
    fit(ws.muscle_force, groups * kCellForce), fit(ws.muscle_energy, groups),
        fit(ws.muscle_cache, groups * kMuscleCache);
    fit(ws.muscle_rest, groups * 8);
    for (int e = 0; e < entries_.n_blocks() * 8; ++e) {
        const MuscleEntry& m = muscles_[static_cast<std::size_t>(std::min(e, n_muscles() - 1))];
        ws.muscle_rest[static_cast<std::size_t>(e)] = 1.0 - m.sign * contraction_ * signals[m.signal];
    }
    std::vector<int> inverted(blocks / kGrain + 1, 0);
    parallel_chunks(threads, cells_.n_blocks(), kGrain, [&](int begin, int end) {
        kernels_.elastic_gradient(q, cells_.nodes(), elastic_weight_.data(), inv_dx_, slab_, begin, end,
                                  ws.elastic_force.data(), ws.elastic_energy.data(), ws.elastic_cache.data(),
                                  &inverted[static_cast<std::size_t>(begin / kGrain)]);
    });
    parallel_chunks(threads, entries_.n_blocks(), kGrain, [&](int begin, int end) {
        kernels_.muscle_gradient(q, entries_.nodes(), muscle_direction_.data(), muscle_weight_.data(),
                                 ws.muscle_rest.data(), inv_dx_, begin, end, ws.muscle_force.data(),
                                 ws.muscle_energy.data(), ws.muscle_cache.data());
    });
    ws.inverted = std::accumulate(inverted.begin(), inverted.end(), 0);
    const std::size_t n = static_cast<std::size_t>(cells_.n_nodes()) * 3;
    std::fill(elastic_out, elastic_out + n, 0.0);
    std::fill(muscle_out, muscle_out + n, 0.0);
    cells_.add_to_nodes(ws.elastic_force.data(), elastic_out, threads);
    if (n_muscles() > 0) entries_.add_to_nodes(ws.muscle_force.data(), muscle_out, threads);
    double energy = 0.0;
    for (const double e : ws.elastic_energy) energy += e;
    for (const double e : ws.muscle_energy) energy += e;
    return energy;
}

void Body::product(BodyWorkspace& ws, const double* p, Threads threads, double* out) const {
    parallel_chunks(threads, cells_.n_blocks(), kGrain, [&](int begin, int end) {
        kernels_.elastic_product(p, cells_.nodes(), elastic_weight_.data(), inv_dx_, begin, end,
                                 ws.elastic_cache.data(), ws.elastic_force.data());
    });
    cells_.add_to_nodes(ws.elastic_force.data(), out, threads);
    if (n_muscles() == 0) return;
    parallel_chunks(threads, entries_.n_blocks(), kGrain, [&](int begin, int end) {
        kernels_.muscle_product(p, entries_.nodes(), muscle_direction_.data(), inv_dx_, begin, end,
                                ws.muscle_cache.data(), ws.muscle_force.data());
    });
    entries_.add_to_nodes(ws.muscle_force.data(), out, threads);
}

void Body::filter(BodyWorkspace& ws) const {
    // The twist stiffness along an eigenvector of K with eigenvalue k is weight (1 - 2 k): bounded by scaling K so
    // that its Frobenius norm, an upper bound of k, stays <= 1/2.
    for (std::size_t at = 0; at < ws.elastic_cache.size(); at += 15 * 8)
        for (std::size_t l = 0; l < 8; ++l) {
            double* k = ws.elastic_cache.data() + at + 9 * 8 + l;
            const double norm2 =
                k[0] * k[0] + k[8] * k[8] + k[16] * k[16] + 2.0 * (k[24] * k[24] + k[32] * k[32] + k[40] * k[40]);
            if (norm2 <= 0.25) continue;
            const double scale = 0.5 / std::sqrt(norm2);
            for (int c = 0; c < 6; ++c) k[8 * c] *= scale;
        }
    for (std::size_t at = 0; at < ws.muscle_cache.size(); at += 5 * 8)
        for (std::size_t l = 0; l < 8; ++l) {
            double& c1 = ws.muscle_cache[at + 3 * 8 + l];
            double& c2 = ws.muscle_cache[at + 4 * 8 + l];
            if (c1 < 0) c2 += c1, c1 = 0.0;  // keeps the stiffness w along the fibre, drops the rest
        }
}

void Body::parameter_pullback(BodyWorkspace& ws, const double* q, const double* lambda, Threads threads, double* mu_bar,
                              double* weight_bar, double* signal_bar) const {
    std::vector<double> bar(static_cast<std::size_t>(cells_.n_blocks()) * 8);
    parallel_chunks(threads, cells_.n_blocks(), kGrain, [&](int begin, int end) {
        kernels_.elastic_weight_bar(q, lambda, cells_.nodes(), inv_dx_, slab_, begin, end, ws.elastic_cache.data(),
                                    bar.data());
    });
    for (int c = 0; c < cells_.n_elements(); ++c) mu_bar[c] += 2.0 * gauss_volume_ * bar[static_cast<std::size_t>(c)];
    if (n_muscles() == 0) return;
    std::vector<double> wb(static_cast<std::size_t>(entries_.n_blocks()) * 8), rb(wb.size());
    kernels_.muscle_bar(q, lambda, entries_.nodes(), muscle_direction_.data(), muscle_weight_.data(),
                        ws.muscle_rest.data(), inv_dx_, 0, entries_.n_blocks(), wb.data(), rb.data());
    for (std::size_t e = 0; e < muscles_.size(); ++e) {
        weight_bar[e] += gauss_volume_ * wb[e];
        signal_bar[muscles_[e].signal] -= muscles_[e].sign * contraction_ * rb[e];
    }
}

}  // namespace dqa
