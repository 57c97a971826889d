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
    void gradient_chunk(TermWorkspace& ws, const double* q, const double* signals, int k) const override;
    void prepare(TermWorkspace& ws) const override;
    void product_chunk(TermWorkspace& ws, const double* p, int k) const override { product_of(ws, p, k); }
    void product_chunk(TermWorkspace& ws, const float* p, int k) const override { product_of(ws, p, k); }
    void filter(TermWorkspace& ws) const override;
    void precondition(std::vector<Vec3>& stiffness) const override;
    void pullback(TermWorkspace& ws, const double* q, const double* lambda, Threads threads,
                  const BodyBar& bar) const override;

private:
    template <class T>
    void product_of(TermWorkspace& ws, const T* p, int k) const;

    double inv_dx_, gauss_volume_, contraction_;
    const BodyKernels& kernels_;
    std::vector<MuscleEntry> muscles_;
    template <class T>
    struct Fibres {
        std::vector<T> weight;     // weight V/8, blocked
        std::vector<T> direction;  // [block][3][8]
    };
    InBothPrecisions<Fibres> fibres_;
};

}  // namespace dqa
