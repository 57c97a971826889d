// SPDX-License-Identifier: MIT
// Preconditioner of a design's Newton systems: a local part S and a correction on coarser grids,
//   P^-1 = S + share (R Q) M (R Q)^T,
// where Q interpolates from every second node, M is a multigrid cycle for Q^T H_0 Q with the exact Hessian H_0 at rest,
// and the rotations R of the cells around each node turn everything with the body. S is
//   multilevel:  R D_0^-1 R^T, D_0 the diagonal blocks of H_0: cheap, and as parallel as a product;
//   factor:      A^-1, the projective-dynamics factor (Bouaziz et al. 2014), one scalar matrix for all directions.
//   Alone
//                it knows neither that rotations cost no energy nor how easily slender bodies bend.
// Additive multilevel methods: e.g. Toselli & Widlund 2005, ch. 2. A function of the positions alone.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "grid/active_set.hpp"
#include "grid/parallel.hpp"
#include "linalg/multigrid.hpp"
#include "linalg/packed_factor.hpp"

namespace dqa {

class Preconditioner {
public:
    template <class Real>
    struct Scratch {
        std::vector<Real> turns;   // R by columns of four, [n_nodes][12]
        std::vector<Real> turned;  // R^T residual, [n_nodes][4]
        typename Multigrid<Real>::Workspace coarse;
    };
    struct Workspace {
        PackedFactor::Workspace factor;
        std::vector<double> mean;  // deformation gradients of the cells
        Scratch<float> single_precision;
        Scratch<double> double_precision;
    };

    // apply(p, out): out = H_0 p, zero on the constrained coordinates where p is. factor: null for `multilevel`.
    // cell_weight [n_cells] weighs the cells around a node (occupancy).
    Preconditioner(const ActiveSet& set, const std::vector<double>& cell_weight, const std::vector<int>& constrained,
                   const std::function<void(const double*, double*)>& apply, std::unique_ptr<PackedFactor> factor,
                   Precision precision, InstructionSet instructions);

    // Turns everything with the positions q [n_nodes][3], before solve.
    void turn(const double* q, Threads threads, Workspace& ws) const;
    // out [n_nodes][3] ~ H^-1 in, not the same array. A symmetric positive definite operator up to rounding, if
    // constrained coordinates are zero in `in` and ignored in `out`.
    void solve(const double* in, double* out, Threads threads, Workspace& ws) const;
    // Whether there is a solve in single precision: not by the factor.
    bool has_single() const { return precision_ == Precision::single_precision && !factor_; }
    // The same where the norm of `in` is known (any number of its size serves), with in.out and other.out: the inner
    // products of an iteration, taken on the way. descended: `in` and `norm` are the r and norm of the last descend.
    // For doubles, and for floats if has_single().
    template <class T>
    std::array<double, 2> solve(const T* in, double norm, bool descended, const T* other, T* out, Threads threads,
                                Workspace& ws) const;
    // x += step p, r -= step ap, all [n_nodes][3]; returns |r|^2. Turns r on the way.
    template <class T>
    double descend(T step, const T* p, const T* ap, T* x, T* r, double norm, Threads threads, Workspace& ws) const;

    // Of the Cholesky factors that it holds.
    long factor_entries() const;
    // Of what one solve reads: rotations, transfers, local blocks, the coarse grids and the factor.
    std::int64_t bytes() const;

private:
    template <class Real>
    struct Parts {
        std::unique_ptr<Multigrid<Real>> coarse;
        std::vector<Real> local;  // damped D_0^-1 by columns of four, [n_nodes][12]; empty with a factor
    };
    template <class Real>
    void build(Parts<Real>& parts, const std::vector<int>& constrained,
               const std::function<void(const double*, double*)>& apply, InstructionSet instructions);
    template <class Real>
    void turn_with(const double* q, Threads threads, Workspace& ws, Scratch<Real>& scratch) const;
    template <class Real, class T>
    std::array<double, 2> solve_with(const Parts<Real>& parts, const T* in, double norm, bool descended, const T* other,
                                     T* out, Threads threads, Workspace& ws, Scratch<Real>& scratch) const;
    template <class Real, class T>
    double descend_with(T step, const T* p, const T* ap, T* x, T* r, double norm, Threads threads,
                        Scratch<Real>& scratch) const;
    int n_nodes() const { return static_cast<int>(nodes_.size()); }

    const GridTables& kernels_;
    Precision precision_;
    std::unique_ptr<PackedFactor> factor_;
    std::vector<GridNode> nodes_;
    GridTransfer transfer_;
    Parts<float> single_;
    Parts<double> double_;
    double inv_dx_, slab_;
    std::vector<std::array<int, 8>> cell_nodes_;
    std::vector<int> node_start_, node_cells_;  // compressed rows: cells around each node
    std::vector<double> cell_weight_;
};

}  // namespace dqa
