// SPDX-License-Identifier: MIT
// Contractile muscles: fibres in cells, with a rest ratio that the actuation commands.
#pragma once

#include "body/energy_term.hpp"
#include "body/kernels.hpp"

namespace dqa {

// One fibre group in one cell. Energy density weight/2 (|F m| - r)^2, r = 1 - sign * contraction * signal value.
struct MuscleEntry {
    int cell = 0;         // active cell
    int signal = 0;       // index of the actuation signal
    double sign = 1.0;    // +1: contracts for a positive signal, -1: its antagonist
    Vec3 direction{};     // unit, at rest
    double weight = 0.0;  // Pa
};

class MuscleTerm : public EnergyTerm {
public:
    MuscleTerm(const ActiveSet& set, const std::vector<MuscleEntry>& muscles, double contraction,
               InstructionSet instructions);

    const char* name() const override { return "muscle"; }
    double gradient(TermWorkspace& ws, const double* q, const double* signals, Threads threads,
                    double* out) const override;
    int n_chunks() const override;
    int chunk_node(int k) const override;
    void product_chunk(TermWorkspace& ws, const double* p, int k) const override;
    void add_product(const TermWorkspace& ws, int begin, int end, double* out) const override;
    void filter(TermWorkspace& ws) const override;
    void precondition(std::vector<Vec3>& stiffness) const override;
    void pullback(TermWorkspace& ws, const double* q, const double* lambda, Threads threads,
                  const BodyBar& bar) const override;

private:
    double inv_dx_, gauss_volume_, contraction_;
    const BodyKernels& kernels_;
    std::vector<MuscleEntry> muscles_;
    BlockLayout entries_;
    std::vector<double> weight_;     // weight V/8, blocked
    std::vector<double> direction_;  // [block][3][8]
};

}  // namespace dqa
