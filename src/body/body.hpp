// SPDX-License-Identifier: MIT
// The soft body: elastic terms of its material with moduli per cell, and contractile muscles.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "body/elastic_term.hpp"
#include "body/muscle_term.hpp"

namespace dqa {

// corotated: the shear term alone, as in the paper. corotated_volume: with the volume term. neo_hookean: stable
// neo-Hookean with its volume term.
enum class Material : int { corotated = 0, corotated_volume = 1, neo_hookean = 2 };

// Lame's parameters of each active cell (Pa); lambda is not looked at by `corotated`.
struct Elasticity {
    Material material = Material::corotated;
    std::vector<double> mu, lambda;
    Quadrature quadrature = Quadrature::reduced;
};

// Scratch of one evaluation point; belongs to the caller.
struct BodyWorkspace {
    std::vector<TermWorkspace> terms;
    int inverted = 0;  // integration points with det F <= 0 at the last gradient
};

class Body {
public:
    Body(const ActiveSet& set, const Elasticity& elasticity, const std::vector<MuscleEntry>& muscles,
         double contraction, InstructionSet instructions);

    const std::vector<MuscleEntry>& muscles() const { return muscles_; }
    int n_muscles() const { return static_cast<int>(muscles_.size()); }

    // Energy; elastic_out and muscle_out [n_nodes][3] are overwritten with dE/dq of each part. Fills the linearisation.
    double gradient(BodyWorkspace& ws, const double* q, const double* signals, Threads threads, double* elastic_out,
                    double* muscle_out) const;
    // out += H p at the last gradient.
    template <class T>
    void product(BodyWorkspace& ws, const T* p, Threads threads, T* out) const {
        parallel_chunks(threads, n_chunks(), 1, [&](int k, int) { product_chunk(ws, p, k); });
        std::vector<NodeTerm<T>> forces;
        list_forces(ws, forces);
        add_terms(forces, static_cast<int>(n_coordinates_ / 3), threads, out);
    }
    // Both in two parts, see EnergyTerm; energy() sums up what all chunks of a gradient have left.
    int n_chunks() const;
    int chunk_node(int k) const;
    void prepare(BodyWorkspace& ws) const;
    void gradient_chunk(BodyWorkspace& ws, const double* q, const double* signals, int k) const {
        const auto [term, chunk] = at_chunk(k);
        terms_[term]->gradient_chunk(ws.terms[term], q, signals, chunk);
    }
    double energy(BodyWorkspace& ws) const;
    template <class T>
    void product_chunk(BodyWorkspace& ws, const T* p, int k) const {
        const auto [term, chunk] = at_chunk(k);
        terms_[term]->product_chunk(ws.terms[term], p, chunk);
    }
    // The forces of tissue, then of muscles, as terms of the sums on the nodes.
    template <class T>
    void list_forces(const BodyWorkspace& ws, std::vector<NodeTerm<T>>& out) const {
        for (std::size_t t = 0; t < terms_.size(); ++t) out.push_back(terms_[t]->template forces<T>(ws.terms[t]));
    }
    int n_elastic_terms() const { return static_cast<int>(n_elastic_); }
    int n_terms() const { return static_cast<int>(terms_.size()); }
    // The linearisation in single precision too, for products in it.
    void to_single(BodyWorkspace& ws, Threads threads) const;
    // Makes the linearisation positive semi-definite (fallback when curvature is negative).
    void filter(BodyWorkspace& ws) const;
    // Size of the parts that cancel in the energy (J); see EnergyTerm.
    double cancelling() const;
    // Stiffness of each active cell along x, y, z for a scalar Laplacian that stands for the Hessian (Pa).
    std::vector<Vec3> preconditioner_stiffness() const;
    // Adds the cotangents of lambda . dE/dq at q (the workspace holds the gradient there).
    void parameter_pullback(BodyWorkspace& ws, const double* q, const double* lambda, Threads threads,
                            const BodyBar& bar) const;

private:
    std::pair<std::size_t, int> at_chunk(int k) const;  // term and its chunk

    std::vector<std::unique_ptr<EnergyTerm>> terms_;
    std::size_t n_elastic_;  // of them, at the front
    std::vector<MuscleEntry> muscles_;
    std::size_t n_coordinates_, n_cells_;
};

}  // namespace dqa
