// SPDX-License-Identifier: MIT
#include "body/muscle_term.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dqa {
namespace {

std::vector<int> cells_of(const std::vector<MuscleEntry>& muscles) {
    std::vector<int> out;
    for (const MuscleEntry& m : muscles) out.push_back(m.cell);
    return out;
}

}  // namespace

MuscleTerm::MuscleTerm(const ActiveSet& set, const std::vector<MuscleEntry>& muscles, double contraction,
                       InstructionSet instructions)
    : inv_dx_(1.0 / set.box.dx),
      gauss_volume_(set.box.dx * set.box.dx * set.box.dx / 8.0),
      contraction_(contraction),
      kernels_(body_kernels(instructions)),
      muscles_(muscles),
      entries_(set, cells_of(muscles), kBodyGrain) {
    std::vector<double> weight;
    for (const MuscleEntry& m : muscles_) weight.push_back(m.weight * gauss_volume_);
    weight_ = entries_.blocked(weight);
    direction_.assign(static_cast<std::size_t>(entries_.n_blocks()) * 24, 0.0);
    for (std::size_t e = 0; e < static_cast<std::size_t>(entries_.n_blocks()) * 8; ++e) {
        const MuscleEntry& m = muscles_[std::min(e, muscles_.size() - 1)];
        for (std::size_t k = 0; k < 3; ++k) direction_[(e / 8) * 24 + k * 8 + e % 8] = m.direction[k];
    }
}

double MuscleTerm::gradient(TermWorkspace& ws, const double* q, const double* signals, Threads threads,
                            double* out) const {
    const std::size_t blocks = static_cast<std::size_t>(entries_.n_blocks());
    ws.force.resize(entries_.sums().size()), ws.energy.resize(blocks);
    ws.cache.resize(blocks * kMuscleCache), ws.rest.resize(blocks * 8);
    for (std::size_t e = 0; e < blocks * 8; ++e) {
        const MuscleEntry& m = muscles_[std::min(e, muscles_.size() - 1)];
        ws.rest[e] = 1.0 - m.sign * contraction_ * signals[m.signal];
    }
    parallel_chunks(threads, entries_.n_blocks(), kBodyGrain, [&](int begin, int end) {
        kernels_.muscle_gradient(q, entries_.nodes(), direction_.data(), weight_.data(), ws.rest.data(), inv_dx_, begin,
                                 end, forces_of(entries_.sums(), begin / kBodyGrain, ws.force), ws.energy.data(),
                                 ws.cache.data());
    });
    entries_.sums().gather().add(ws.force.data(), 1.0, out, threads);
    return std::accumulate(ws.energy.begin(), ws.energy.end(), 0.0);
}

int MuscleTerm::n_chunks() const {
    return entries_.sums().n_chunks();
}

int MuscleTerm::chunk_node(int k) const {
    return entries_.nodes()[64 * k * kBodyGrain] / 3;
}

void MuscleTerm::product_chunk(TermWorkspace& ws, const double* p, int k) const {
    const int begin = k * kBodyGrain, end = std::min(begin + kBodyGrain, entries_.n_blocks());
    kernels_.muscle_product(p, entries_.nodes(), direction_.data(), weight_.data(), ws.rest.data(), inv_dx_, begin, end,
                            ws.cache.data(), forces_of(entries_.sums(), k, ws.force));
}

void MuscleTerm::add_product(const TermWorkspace& ws, int begin, int end, double* out) const {
    entries_.sums().gather().add(ws.force.data(), 1.0, begin, end, out);
}

// Drops compressive transverse stiffness, w - u.u < 0, and keeps w along the fibre.
void MuscleTerm::filter(TermWorkspace& ws) const {
    for (std::size_t at = 0; at < ws.cache.size(); at += 3 * 8)
        for (std::size_t l = 0; l < 8; ++l) {
            const std::size_t entry = at / kMuscleCache * 8 + l;
            double* u = &ws.cache[at + l];
            const double square = u[0] * u[0] + u[8] * u[8] + u[16] * u[16];
            if (ws.rest[entry] < 0.0 || square <= weight_[entry]) continue;
            const double scale = std::sqrt(weight_[entry] / square) * (1.0 - 1e-15);  // w - u.u not below 0 by rounding
            for (std::size_t k = 0; k < 3; ++k) u[8 * k] *= scale;
        }
}

// Along the fibre, for one of three directions of motion.
void MuscleTerm::precondition(std::vector<Vec3>& stiffness) const {
    for (const MuscleEntry& m : muscles_)
        for (std::size_t k = 0; k < 3; ++k)
            stiffness[static_cast<std::size_t>(m.cell)][k] += m.weight / 3.0 * m.direction[k] * m.direction[k];
}

void MuscleTerm::pullback(TermWorkspace& ws, const double* q, const double* lambda, Threads threads,
                          const BodyBar& bar) const {
    std::vector<double> weight_bar(static_cast<std::size_t>(entries_.n_blocks()) * 8), rest_bar(weight_bar.size());
    parallel_chunks(threads, entries_.n_blocks(), kBodyGrain, [&](int begin, int end) {
        kernels_.muscle_bar(q, lambda, entries_.nodes(), direction_.data(), weight_.data(), ws.rest.data(), inv_dx_,
                            begin, end, weight_bar.data(), rest_bar.data());
    });
    for (std::size_t e = 0; e < muscles_.size(); ++e) {
        bar.muscle_weight[e] += gauss_volume_ * weight_bar[e];
        bar.signals[muscles_[e].signal] -= muscles_[e].sign * contraction_ * rest_bar[e];
    }
}

}  // namespace dqa
