// SPDX-License-Identifier: MIT
// Source of a step's loops over the nodes, included once per instruction set; see step_kernels.hpp.
#include "grid/four.hpp"
#include "motion/step_kernels.hpp"

namespace dqa {
namespace {

template <class T>
inline Four<T> force_on(const NodeTerm<T>& term, int n) {
    Four<T> sum = {};
    for (int s = term.start[n]; s < term.start[n + 1]; ++s) sum += four(term.values + term.place[s]);
    return sum;
}

template <class T>
inline Four<T> forces_on(const NodeTerm<T>* forces, int first, int last, int n) {
    Four<T> sum = {};
    for (int k = first; k < last; ++k) sum += force_on(forces[k], n);
    return sum;
}

template <class T>
inline void store_three(T* out, const Four<T>& v) {
    out[0] = v[0], out[1] = v[1], out[2] = v[2];
}

template <class T>
double direct(const NodeTerm<T>* forces, int n_forces, const double* mass, double inv_b2, const double* free,
              const T* z, T beta, int begin, int end, T* p, T* ap) {
    Four<double> product = {};
    for (int n = begin; n < end; ++n) {
        const Four<T> along = padded(z + 3 * n);
        Four<T> image = static_cast<T>(mass[n] * inv_b2) * along + forces_on(forces, 0, n_forces, n);
        if (free) image *= __builtin_convertvector(padded(free + 3 * n), Four<T>);
        Four<T> direction = along;
        if (beta != T(0)) image += beta * padded(ap + 3 * n), direction += beta * padded(p + 3 * n);
        store_three(ap + 3 * n, image);
        if (p) store_three(p + 3 * n, direction);
        product += __builtin_convertvector(direction, Four<double>) * __builtin_convertvector(image, Four<double>);
    }
    return total(product);
}

void balance(const NodeTerm<double>* forces, const ForceGroups& groups, const double* mass, double inv_b2,
             const double* q, const double* y, const double* free, int begin, int end, double* gradient,
             ForceSums& sums) {
    Four<double> energy = {}, inertia2 = {}, water2 = {}, elastic2 = {}, muscle2 = {}, total2 = {};
    for (int n = begin; n < end; ++n) {
        const Four<double> tissue = forces_on(forces, 0, groups.tissue, n),
                           muscles = forces_on(forces, groups.tissue, groups.muscles, n),
                           water = forces_on(forces, groups.muscles, groups.water, n),
                           way = padded(q + 3 * n) - padded(y + 3 * n), inertia = inv_b2 * mass[n] * way;
        Four<double> sum = inertia + water + tissue + muscles;
        if (free) sum *= padded(free + 3 * n);
        store_three(gradient + 3 * n, sum);
        energy += 0.5 * inertia * way, inertia2 += inertia * inertia, water2 += water * water;
        elastic2 += tissue * tissue, muscle2 += muscles * muscles, total2 += sum * sum;
    }
    sums.energy = total(energy), sums.inertia2 = total(inertia2), sums.water2 = total(water2);
    sums.elastic2 = total(elastic2), sums.muscle2 = total(muscle2), sums.total2 = total(total2);
}

}  // namespace

const StepKernels& DQA_KERNEL_TABLE() {
    static const StepKernels table = {{direct<double>, direct<float>}, balance};
    return table;
}

}  // namespace dqa
