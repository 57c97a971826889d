// SPDX-License-Identifier: MIT
// Elastic terms: one kernel family, with a modulus per cell that follows from Lame's parameters.
#pragma once

#include "body/energy_term.hpp"
#include "body/kernels.hpp"

namespace dqa {

class ElasticTerm : public EnergyTerm {
public:
    // mu, lambda: Lame's parameters of each active cell (Pa); lambda may be empty for kinds that do not use it.
    ElasticTerm(ElasticKind kind, Quadrature quadrature, const ActiveSet& set, const std::vector<double>& mu,
                const std::vector<double>& lambda, InstructionSet instructions);

    const char* name() const override;
    void gradient_chunk(TermWorkspace& ws, const double* q, const double* signals, int k) const override;
    void product_chunk(TermWorkspace& ws, const double* p, int k) const override { product_of(ws, p, k); }
    void product_chunk(TermWorkspace& ws, const float* p, int k) const override { product_of(ws, p, k); }
    void filter(TermWorkspace& ws) const override;
    double cancelling() const override;
    void precondition(std::vector<Vec3>& stiffness) const override;
    void pullback(TermWorkspace& ws, const double* q, const double* lambda, Threads threads,
                  const BodyBar& bar) const override;

private:
    template <class T>
    void product_of(TermWorkspace& ws, const T* p, int k) const;

    ElasticKind kind_;
    const ElasticKernels& kernels_;
    double inv_dx_, slab_, volume_;  // volume of a cell's integration point
    std::vector<double> mu_, lambda_;
    InBothPrecisions<Numbers> weight_;  // blocked
    std::vector<double> shift_;         // blocked
};

}  // namespace dqa
