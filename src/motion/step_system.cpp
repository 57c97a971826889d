// SPDX-License-Identifier: MIT
// The linear system of a step, H x = b with the Hessian H of what the step minimises: its product, in double and in
// single precision, its preconditioner, its matrix for direct solvers, and what rounding leaves of it.
#include <algorithm>
#include <cmath>
#include <limits>

#include "motion/stepper.hpp"

namespace dqa {

template <class T>
double Stepper::rounding_of(const T* x) const {
    const double* diagonal = design_->stiffness_diagonal().data();
    const double square = parallel_sum(threads_, design_->n_nodes(), kNodeGrain, [&](int begin, int end) {
        double sum = 0.0;
        for (std::size_t i = 3 * static_cast<std::size_t>(begin); i < 3 * static_cast<std::size_t>(end); ++i) {
            const double force = diagonal[i / 3] * static_cast<double>(x[i]);
            sum += force * force;
        }
        return sum;
    });
    return 0.25 * static_cast<double>(std::numeric_limits<T>::epsilon()) * std::sqrt(square);
}
template double Stepper::rounding_of(const double*) const;

template <class T>
void Stepper::mask(T* field) const {
    for (const int i : design_->constrained()) field[i] = T(0);
}
template void Stepper::mask(double*) const;

template <class T>
double Stepper::apply_hessian(const T* p, T* out) {
    if (design_->constrained().empty()) return full_product(p, out);
    std::vector<T>& masked = masked_.in(T());
    masked.resize(size_ + 1);
    std::copy(p, p + size_, masked.begin());
    mask(masked.data());
    double product = full_product(masked.data(), out);
    for (const int i : design_->constrained()) out[i] = p[i], product += static_cast<double>(p[i] * p[i]);
    return product;
}
template double Stepper::apply_hessian(const double*, double*);

void Stepper::precondition(const double* in, double* out) {
    design_->preconditioner().solve(in, out, threads_, preconditioner_);
    mask(out);
}

template <class T>
PcgProducts<T> Stepper::system() {
    // r, p and ap are zero on the constrained coordinates.
    return {[this](const T* p, T* out) { return apply_hessian(p, out); },
            [this](const T* r, double norm, bool descended, const T* ap, T* z) {
                const auto products =
                    design_->preconditioner().solve(r, norm, descended, ap, z, threads_, preconditioner_);
                mask(z);
                return products;
            },
            [this](const T* z, T beta, T* p, T* ap) { return direct(z, beta, p, ap); },
            [this](T step, const T* p, const T* ap, T* x, T* r, double norm) {
                return design_->preconditioner().descend(step, p, ap, x, r, norm, threads_, preconditioner_);
            }};
}

PcgResult Stepper::solve_hessian(const double* b, double* x, double tolerance, bool indefinite) {
    if (!design_->preconditioner().has_single())
        return pcg(size_, b, x, tolerance, scene_.max_linear, system<double>(), threads_, krylov_, indefinite);
    design_->body().to_single(body_, threads_);
    const auto rounding = [this](const float* p) { return rounding_of(p); };
    return mixed_pcg(size_, b, x, tolerance, scene_.max_linear, system<double>(), system<float>(), rounding, threads_,
                     krylov_, indefinite);
}

// Products come in two parallel loops: the forces of cells, fibres and faces, then their sums on the nodes.
template <class T>
double Stepper::sum_products(const T* z, const double* free, T beta, T* p, T* ap) {
    const Body& body = design_->body();
    const Water* water = design_->water();
    const bool of_water = water && water->has_product();
    on_elements([&](int k) { body.product_chunk(body_, z, k); },
                [&](int k) {
                    if (of_water) water->product_chunk(water_, z, beta_, k);
                });
    std::vector<NodeTerm<T>>& forces = forces_.in(T());
    forces.clear();
    body.list_forces(body_, forces);
    if (of_water) water->list_forces(water_, forces);
    const double inv_b2 = 1.0 / (beta_ * beta_);
    return parallel_sum(threads_, design_->n_nodes(), kNodeGrain, [&](int begin, int end) {
        return kernels_.direct.in(T())(forces.data(), static_cast<int>(forces.size()), design_->mass().data(), inv_b2,
                                       free, z, beta, begin, end, p, ap);
    });
}

template <class T>
double Stepper::full_product(const T* p, T* out) {
    return sum_products<T>(p, nullptr, T(0), nullptr, out);
}
template double Stepper::full_product(const double*, double*);

template <class T>
double Stepper::direct(const T* z, T beta, T* p, T* ap) {
    return sum_products(z, free_or_null(), beta, p, ap);
}

// The exact Hessian as a matrix, by probing: nodes of equal coordinates modulo 3 are not coupled, so 27 x 3 products
// yield all of it, from the same kernel that the iterative solver uses.
SymmetricMatrix Stepper::assemble() {
    const auto& nodes = design_->set().node_ijk;
    const Box& box = design_->space().box();
    std::vector<std::vector<std::pair<int, double>>> columns(size_);
    std::vector<double> probe(size_), out(size_);
    for (int colour = 0; colour < 27; ++colour) {
        const auto of_colour = [&](const std::array<int, 3>& ijk) {
            return (ijk[0] % 3) * 9 + (ijk[1] % 3) * 3 + ijk[2] % 3 == colour;
        };
        if (std::none_of(nodes.begin(), nodes.end(), of_colour)) continue;
        for (int axis = 0; axis < 3; ++axis) {
            std::fill(probe.begin(), probe.end(), 0.0);
            for (std::size_t n = 0; n < nodes.size(); ++n)
                if (of_colour(nodes[n])) probe[3 * n + static_cast<std::size_t>(axis)] = 1.0;
            apply_hessian(probe.data(), out.data());
            for (std::size_t n = 0; n < nodes.size(); ++n) {
                if (!of_colour(nodes[n])) continue;
                const int column = static_cast<int>(3 * n) + axis;
                for (int o = 0; o < 27; ++o) {
                    const int i = nodes[n][0] + o / 9 - 1, j = nodes[n][1] + o / 3 % 3 - 1, k = nodes[n][2] + o % 3 - 1;
                    if (i < 0 || j < 0 || k < 0 || i > box.cells[0] || j > box.cells[1] || k >= box.node_planes())
                        continue;
                    const int other = design_->set().node_to_active[static_cast<std::size_t>(box.node(i, j, k))];
                    if (other < 0) continue;
                    for (int a = 0; a < 3; ++a) {
                        const int row = 3 * other + a;
                        if (row >= column)
                            columns[static_cast<std::size_t>(column)].emplace_back(row,
                                                                                   out[static_cast<std::size_t>(row)]);
                    }
                }
            }
        }
    }
    return matrix_from_columns(columns);
}

// direction_ <- -H^-1 gradient_. Returns false if no descent direction came of it (negative curvature at once).
bool Stepper::newton_direction(double forcing, StepReport& report) {
    std::vector<double>& b = right_;
    on_coordinates([&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) b[i] = -gradient_[i];
    });
    if (scene_.method == Method::newton_direct) {
        // An indefinite Hessian is shifted, as little as will do: filtering all cells would cost Newton's convergence.
        SymmetricMatrix h = assemble();
        double shifted = 0.0;
        for (const double shift : {0.0, 1e-6, 1e-4, 1e-2}) {
            for (std::size_t j = 0; j < size_; ++j)
                h.value[static_cast<std::size_t>(h.start[j])] +=
                    (shift - shifted) * design_->stiffness_diagonal()[j / 3];
            shifted = shift;
            std::vector<double> x(b);
            if (!solve_positive(h, x)) continue;
            direction_ = x;
            ++report.linear_iterations;
            report.indefinite += shift > 0.0;
            return true;
        }
        ++report.indefinite;
        return false;
    }
    const PcgResult r = solve_hessian(b.data(), direction_.data(), forcing, false);
    report.linear_iterations += r.iterations;
    report.indefinite += r.negative_curvature;
    // An iterate before the negative curvature, or at the iteration limit, is still a descent direction.
    return r.iterations > 0 && std::isfinite(r.relative_residual);
}

}  // namespace dqa
