// SPDX-License-Identifier: MIT
#include "body/elastic_term.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dqa {
namespace {

std::vector<int> all_cells(const ActiveSet& set) {
    std::vector<int> out(static_cast<std::size_t>(set.n_cells()));
    std::iota(out.begin(), out.end(), 0);
    return out;
}

// The moduli of the stable neo-Hookean energy whose small deformations are Hooke's with Lame's (mu, lambda)
// (Smith et al. 2018, sec. 3.4): 4/3 mu and lambda + 5/6 mu; alpha = 1 + 3 mu_n / (4 lambda_n) keeps the rest state.
struct NeoModuli {
    double mu, lambda;
    double alpha() const { return 1.0 + 0.75 * mu / lambda; }
};
NeoModuli neo_moduli(double mu, double lambda) {
    return {4.0 / 3.0 * mu, lambda + 5.0 / 6.0 * mu};
}

const ElasticKernels& kernels_of(ElasticKind kind, Quadrature quadrature, InstructionSet instructions) {
    return body_kernels(instructions).elastic[static_cast<std::size_t>(quadrature)][static_cast<std::size_t>(kind)];
}

}  // namespace

ElasticTerm::ElasticTerm(ElasticKind kind, Quadrature quadrature, const ActiveSet& set, const std::vector<double>& mu,
                         const std::vector<double>& lambda, InstructionSet instructions)
    : EnergyTerm(set, all_cells(set), 8 * kernels_of(kind, quadrature, instructions).point_values),
      kind_(kind),
      kernels_(kernels_of(kind, quadrature, instructions)),
      inv_dx_(1.0 / set.box.dx),
      slab_(set.box.dims == 2 ? 1.0 : 0.0),
      volume_(set.box.dx * set.box.dx * set.box.dx / kernels_.points),
      mu_(mu),
      lambda_(lambda) {
    std::vector<double> weight(mu.size()), shift;
    for (std::size_t c = 0; c < mu.size(); ++c) switch (kind_) {
            case ElasticKind::corotated:
                weight[c] = 2.0 * mu[c] * volume_;
                break;
            case ElasticKind::corotated_volume:
                weight[c] = lambda[c] * volume_;
                break;
            case ElasticKind::neo_hookean:
                weight[c] = neo_moduli(mu[c], lambda[c]).mu * volume_;
                break;
            case ElasticKind::neo_hookean_volume:
                weight[c] = neo_moduli(mu[c], lambda[c]).lambda * volume_;
                shift.push_back(neo_moduli(mu[c], lambda[c]).alpha());
                break;
        }
    weight_.exact = elements_.blocked(weight);
    weight_.single.assign(weight_.exact.begin(), weight_.exact.end());
    if (!shift.empty()) shift_ = elements_.blocked(shift);
}

const char* ElasticTerm::name() const {
    constexpr const char* names[] = {"corotated", "corotated volume", "neo-Hookean", "neo-Hookean volume"};
    return names[static_cast<std::size_t>(kind_)];
}

void ElasticTerm::gradient_chunk(TermWorkspace& ws, const double* q, const double*, int k) const {
    int& inverted = ws.inverted[static_cast<std::size_t>(k)];
    inverted = 0;
    kernels_.gradient(q, elements_.nodes(), weight_.exact.data(), shift_.data(), inv_dx_, slab_, first_of(k),
                      last_of(k), elements_.sums().cleared(k, ws.exact.force), ws.energy.data(), ws.exact.cache.data(),
                      &inverted);
}

template <class T>
void ElasticTerm::product_of(TermWorkspace& ws, const T* p, int k) const {
    Linearisation<T>& at = ws.in(T());
    kernels_.product.in(T())(p, elements_.nodes(), weight_.in(T()).data(), inv_dx_, first_of(k), last_of(k),
                             at.cache.data(), elements_.sums().cleared(k, at.force));
}
template void ElasticTerm::product_of(TermWorkspace&, const double*, int) const;
template void ElasticTerm::product_of(TermWorkspace&, const float*, int) const;

void ElasticTerm::filter(TermWorkspace& ws) const {
    kernels_.filter(ws.exact.cache.data(), elements_.n_blocks());
}

// |F|^2 and 3, and the squares of J - alpha and 1 - alpha.
double ElasticTerm::cancelling() const {
    double sum = 0.0;
    if (kind_ == ElasticKind::neo_hookean)
        for (const double w : weight_.exact) sum += 1.5 * kernels_.points * w;
    if (kind_ == ElasticKind::neo_hookean_volume)
        for (std::size_t c = 0; c < weight_.exact.size(); ++c) sum += std::fabs(weight_.exact[c] * (1.0 - shift_[c]));
    return sum;
}

// grad-div terms resist one direction of each gradient in three: a third of the modulus.
void ElasticTerm::precondition(std::vector<Vec3>& stiffness) const {
    for (std::size_t c = 0; c < mu_.size(); ++c) {
        double s = 0.0;
        switch (kind_) {
            case ElasticKind::corotated:
            case ElasticKind::neo_hookean:
                s = 2.0 * mu_[c];
                break;
            case ElasticKind::corotated_volume:
                s = lambda_[c] / 3.0;
                break;
            case ElasticKind::neo_hookean_volume:
                s = neo_moduli(mu_[c], lambda_[c]).lambda / 3.0;
                break;
        }
        for (double& axis : stiffness[c]) axis += s;
    }
}

void ElasticTerm::pullback(TermWorkspace& ws, const double* q, const double* lambda, Threads threads,
                           const BodyBar& bar) const {
    std::vector<double> weight_bar(static_cast<std::size_t>(elements_.n_blocks()) * 8), shift_bar(weight_bar.size());
    parallel_chunks(threads, elements_.n_blocks(), kBodyGrain, [&](int begin, int end) {
        kernels_.bar(q, lambda, elements_.nodes(), weight_.exact.data(), shift_.data(), inv_dx_, slab_, begin, end,
                     ws.exact.cache.data(), weight_bar.data(), shift_bar.data());
    });
    for (std::size_t c = 0; c < mu_.size(); ++c) {
        const double w = weight_bar[c] * volume_;
        switch (kind_) {
            case ElasticKind::corotated:
                bar.mu[c] += 2.0 * w;
                break;
            case ElasticKind::corotated_volume:
                bar.lambda[c] += w;
                break;
            case ElasticKind::neo_hookean:
                bar.mu[c] += 4.0 / 3.0 * w;
                break;
            case ElasticKind::neo_hookean_volume: {
                // alpha = 1 + mu / lambda_n
                const NeoModuli n = neo_moduli(mu_[c], lambda_[c]);
                const double lambda_n_bar = w - shift_bar[c] * mu_[c] / (n.lambda * n.lambda);
                bar.lambda[c] += lambda_n_bar;
                bar.mu[c] += 5.0 / 6.0 * lambda_n_bar + shift_bar[c] / n.lambda;
                break;
            }
        }
    }
}

}  // namespace dqa
