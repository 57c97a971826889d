// SPDX-License-Identifier: MIT
#include "body/muscle_term.hpp"

#include <algorithm>
#include <cmath>

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
    : EnergyTerm(set, cells_of(muscles), kMuscleCache),
      inv_dx_(1.0 / set.box.dx),
      gauss_volume_(set.box.dx * set.box.dx * set.box.dx / 8.0),
      contraction_(contraction),
      kernels_(body_kernels(instructions)),
      muscles_(muscles) {
    std::vector<double> weight;
    for (const MuscleEntry& m : muscles_) weight.push_back(m.weight * gauss_volume_);
    fibres_.exact.weight = elements_.blocked(weight);
    fibres_.exact.direction.assign(static_cast<std::size_t>(elements_.n_blocks()) * 24, 0.0);
    for (std::size_t e = 0; e < static_cast<std::size_t>(elements_.n_blocks()) * 8; ++e) {
        const MuscleEntry& m = muscles_[std::min(e, muscles_.size() - 1)];
        for (std::size_t k = 0; k < 3; ++k) fibres_.exact.direction[(e / 8) * 24 + k * 8 + e % 8] = m.direction[k];
    }
    fibres_.single.weight.assign(fibres_.exact.weight.begin(), fibres_.exact.weight.end());
    fibres_.single.direction.assign(fibres_.exact.direction.begin(), fibres_.exact.direction.end());
}

void MuscleTerm::prepare(TermWorkspace& ws) const {
    EnergyTerm::prepare(ws);
    ws.exact.rest.resize(static_cast<std::size_t>(elements_.n_blocks()) * 8);
}

void MuscleTerm::gradient_chunk(TermWorkspace& ws, const double* q, const double* signals, int k) const {
    for (std::size_t e = static_cast<std::size_t>(first_of(k)) * 8; e < static_cast<std::size_t>(last_of(k)) * 8; ++e) {
        const MuscleEntry& m = muscles_[std::min(e, muscles_.size() - 1)];
        ws.exact.rest[e] = 1.0 - m.sign * contraction_ * signals[m.signal];
    }
    kernels_.muscle_gradient(q, elements_.nodes(), fibres_.exact.direction.data(), fibres_.exact.weight.data(),
                             ws.exact.rest.data(), inv_dx_, first_of(k), last_of(k),
                             elements_.sums().cleared(k, ws.exact.force), ws.energy.data(), ws.exact.cache.data());
}

template <class T>
void MuscleTerm::product_of(TermWorkspace& ws, const T* p, int k) const {
    const Fibres<T>& fibres = fibres_.in(T());
    Linearisation<T>& at = ws.in(T());
    kernels_.muscle_product.in(T())(p, elements_.nodes(), fibres.direction.data(), fibres.weight.data(), at.rest.data(),
                                    inv_dx_, first_of(k), last_of(k), at.cache.data(),
                                    elements_.sums().cleared(k, at.force));
}
template void MuscleTerm::product_of(TermWorkspace&, const double*, int) const;
template void MuscleTerm::product_of(TermWorkspace&, const float*, int) const;

// Drops compressive transverse stiffness, w - u.u < 0, and keeps w along the fibre.
void MuscleTerm::filter(TermWorkspace& ws) const {
    for (std::size_t at = 0; at < ws.exact.cache.size(); at += 3 * 8)
        for (std::size_t l = 0; l < 8; ++l) {
            const std::size_t entry = at / kMuscleCache * 8 + l;
            double* u = &ws.exact.cache[at + l];
            const double square = u[0] * u[0] + u[8] * u[8] + u[16] * u[16];
            if (ws.exact.rest[entry] < 0.0 || square <= fibres_.exact.weight[entry]) continue;
            const double scale =
                std::sqrt(fibres_.exact.weight[entry] / square) * (1.0 - 1e-15);  // w - u.u not below 0 by rounding
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
    std::vector<double> weight_bar(static_cast<std::size_t>(elements_.n_blocks()) * 8), rest_bar(weight_bar.size());
    parallel_chunks(threads, elements_.n_blocks(), kBodyGrain, [&](int begin, int end) {
        kernels_.muscle_bar(q, lambda, elements_.nodes(), fibres_.exact.direction.data(), fibres_.exact.weight.data(),
                            ws.exact.rest.data(), inv_dx_, begin, end, weight_bar.data(), rest_bar.data());
    });
    for (std::size_t e = 0; e < muscles_.size(); ++e) {
        bar.muscle_weight[e] += gauss_volume_ * weight_bar[e];
        bar.signals[muscles_[e].signal] -= muscles_[e].sign * contraction_ * rest_bar[e];
    }
}

}  // namespace dqa
