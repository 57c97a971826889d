// SPDX-License-Identifier: MIT
#include "body/body.hpp"

#include <algorithm>
#include <numeric>

namespace dqa {

Body::Body(const ActiveSet& set, const Elasticity& elasticity, const std::vector<MuscleEntry>& muscles,
           double contraction, InstructionSet instructions)
    : muscles_(muscles),
      n_coordinates_(static_cast<std::size_t>(set.n_nodes()) * 3),
      n_cells_(static_cast<std::size_t>(set.n_cells())) {
    const auto add = [&](ElasticKind kind) {
        terms_.push_back(std::make_unique<ElasticTerm>(kind, elasticity.quadrature, set, elasticity.mu,
                                                       elasticity.lambda, instructions));
    };
    if (elasticity.material == Material::neo_hookean) {
        add(ElasticKind::neo_hookean);
        add(ElasticKind::neo_hookean_volume);
    } else {
        add(ElasticKind::corotated);
        if (elasticity.material == Material::corotated_volume) add(ElasticKind::corotated_volume);
    }
    n_elastic_ = terms_.size();
    if (!muscles.empty()) terms_.push_back(std::make_unique<MuscleTerm>(set, muscles, contraction, instructions));
}

double Body::gradient(BodyWorkspace& ws, const double* q, const double* signals, Threads threads, double* elastic_out,
                      double* muscle_out) const {
    prepare(ws);
    parallel_chunks(threads, n_chunks(), 1, [&](int k, int) { gradient_chunk(ws, q, signals, k); });
    std::vector<NodeTerm<double>> forces;
    list_forces(ws, forces);
    parallel_chunks(threads, static_cast<int>(n_coordinates_ / 3), kNodeGrain, [&](int begin, int end) {
        for (double* out : {elastic_out, muscle_out}) std::fill(out + 3 * begin, out + 3 * end, 0.0);
        for (std::size_t t = 0; t < forces.size(); ++t)
            add_term(forces[t], begin, end, t < n_elastic_ ? elastic_out : muscle_out);
    });
    return energy(ws);
}

void Body::prepare(BodyWorkspace& ws) const {
    ws.terms.resize(terms_.size());
    for (std::size_t t = 0; t < terms_.size(); ++t) terms_[t]->prepare(ws.terms[t]);
}

double Body::energy(BodyWorkspace& ws) const {
    double sum = 0.0;
    ws.inverted = 0;
    for (const TermWorkspace& term : ws.terms) {
        sum += std::accumulate(term.energy.begin(), term.energy.end(), 0.0);
        ws.inverted = std::accumulate(term.inverted.begin(), term.inverted.end(), ws.inverted);
    }
    return sum;
}

int Body::n_chunks() const {
    int sum = 0;
    for (const auto& term : terms_) sum += term->n_chunks();
    return sum;
}

std::pair<std::size_t, int> Body::at_chunk(int k) const {
    std::size_t t = 0;
    for (; k >= terms_[t]->n_chunks(); ++t) k -= terms_[t]->n_chunks();
    return {t, k};
}

int Body::chunk_node(int k) const {
    const auto [term, chunk] = at_chunk(k);
    return terms_[term]->chunk_node(chunk);
}

void Body::to_single(BodyWorkspace& ws, Threads threads) const {
    for (std::size_t t = 0; t < terms_.size(); ++t) terms_[t]->prepare_single(ws.terms[t]);
    parallel_chunks(threads, n_chunks(), 1, [&](int k, int) {
        const auto [term, chunk] = at_chunk(k);
        terms_[term]->to_single(ws.terms[term], chunk);
    });
}

void Body::filter(BodyWorkspace& ws) const {
    for (std::size_t t = 0; t < terms_.size(); ++t) terms_[t]->filter(ws.terms[t]);
}

double Body::cancelling() const {
    double sum = 0.0;
    for (const auto& term : terms_) sum += term->cancelling();
    return sum;
}

std::vector<Vec3> Body::preconditioner_stiffness() const {
    std::vector<Vec3> stiffness(n_cells_, Vec3{});
    for (const auto& term : terms_) term->precondition(stiffness);
    return stiffness;
}

void Body::parameter_pullback(BodyWorkspace& ws, const double* q, const double* lambda, Threads threads,
                              const BodyBar& bar) const {
    for (std::size_t t = 0; t < terms_.size(); ++t) terms_[t]->pullback(ws.terms[t], q, lambda, threads, bar);
}

}  // namespace dqa
