// SPDX-License-Identifier: MIT
// One term of the body's energy: value, gradient, Hessian-vector product, what it adds to the preconditioner, and the
// derivatives with respect to its parameters. A body is a list of terms; a new material is a new term.
#pragma once

#include <algorithm>
#include <vector>

#include "body/kernels.hpp"
#include "grid/active_set.hpp"
#include "grid/parallel.hpp"
#include "grid/precision.hpp"

namespace dqa {

constexpr int kBodyGrain = 8;  // blocks a chunk: the unit of ordered sums

// What products need of an evaluation point, and where they leave their forces; in single precision a copy of it.
template <class T>
struct Linearisation {
    std::vector<T> force, cache, rest;
};

// Scratch of one term at one evaluation point; belongs to the caller.
struct TermWorkspace : InBothPrecisions<Linearisation> {
    std::vector<double> energy;  // of the blocks
    std::vector<int> inverted;   // Gauss points with det F <= 0 at the last gradient, of the chunks
};

// Cotangents of the body's parameters; every pointer may be added to.
struct BodyBar {
    double* mu;             // [n_cells] Lame's mu (shear modulus)
    double* lambda;         // [n_cells] Lame's lambda
    double* muscle_weight;  // [n_muscles]
    double* signals;        // [n_signals]
};

class EnergyTerm {
public:
    virtual ~EnergyTerm() = default;
    virtual const char* name() const = 0;
    // dE/dq in two parts that other terms' may run beside: element forces of chunk k of n_chunks(), with its energy and
    // linearisation; then forces() tells their sums on the nodes. prepare makes room for it.
    virtual void gradient_chunk(TermWorkspace& ws, const double* q, const double* signals, int k) const = 0;
    virtual void prepare(TermWorkspace& ws) const {
        const std::size_t blocks = static_cast<std::size_t>(elements_.n_blocks());
        ws.exact.force.resize(elements_.sums().size()), ws.exact.cache.resize(blocks * block_cache_);
        ws.energy.resize(blocks), ws.inverted.resize(static_cast<std::size_t>(n_chunks()));
    }
    // H p at the last gradient in the same way. In single precision once prepare_single has made room and to_single has
    // copied all chunks; p has one number more than 3 n_nodes then, whose value does not matter.
    virtual void product_chunk(TermWorkspace& ws, const double* p, int k) const = 0;
    virtual void product_chunk(TermWorkspace& ws, const float* p, int k) const = 0;
    template <class T>
    NodeTerm<T> forces(const TermWorkspace& ws) const {
        return elements_.sums().gather().term(ws.in(T()).force.data());
    }
    void prepare_single(TermWorkspace& ws) const {
        ws.single.force.resize(ws.exact.force.size()), ws.single.cache.resize(ws.exact.cache.size());
        ws.single.rest.assign(ws.exact.rest.begin(), ws.exact.rest.end());
    }
    void to_single(TermWorkspace& ws, int k) const {
        convert(ws.exact.cache, ws.single.cache, static_cast<std::size_t>(first_of(k)) * block_cache_,
                static_cast<std::size_t>(last_of(k)) * block_cache_);
    }
    int n_chunks() const { return elements_.sums().n_chunks(); }
    // One of the chunk's nodes, which says where along the body it lies.
    int chunk_node(int k) const { return elements_.nodes()[64 * first_of(k)] / 3; }
    // Makes the linearisation positive semi-definite (fallback when curvature is negative).
    virtual void filter(TermWorkspace& ws) const = 0;
    // Size of the parts that cancel in the energy (J): at rest its rounding is that of these, however small it is.
    virtual double cancelling() const { return 0.0; }
    // Adds the stiffness of each cell along x, y, z that a scalar Laplacian should carry: [n_cells] (Pa).
    virtual void precondition(std::vector<Vec3>& stiffness) const = 0;
    // Adds the cotangents of lambda . dE/dq at q, where the workspace holds the gradient.
    virtual void pullback(TermWorkspace& ws, const double* q, const double* lambda, Threads threads,
                          const BodyBar& bar) const = 0;

protected:
    // cells: active cell of each element; block_cache: numbers that a block of 8 elements caches.
    EnergyTerm(const ActiveSet& set, const std::vector<int>& cells, int block_cache)
        : elements_(set, cells, kBodyGrain), block_cache_(static_cast<std::size_t>(block_cache)) {}

    // Blocks of chunk k.
    int first_of(int k) const { return k * kBodyGrain; }
    int last_of(int k) const { return std::min(first_of(k) + kBodyGrain, elements_.n_blocks()); }

    BlockLayout elements_;

private:
    std::size_t block_cache_;
};

}  // namespace dqa
