// SPDX-License-Identifier: MIT
// Preconditioned conjugate gradients with detection of negative curvature (Steihaug 1983; flexible beta, as the
// preconditioner is in single precision). Dot products are summed in a fixed order, whatever the number of threads.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "grid/parallel.hpp"
#include "grid/precision.hpp"

namespace dqa {

template <class T>
struct PcgVectors {
    std::vector<T> x, r, z, p, ap;
};
using PcgWorkspace = InBothPrecisions<PcgVectors>;

struct PcgResult {
    int iterations = 0;
    double relative_residual = 0.0;  // |b - A x| / |b|
    bool converged = false;
    bool negative_curvature = false;  // x is then the iterate before it
    bool left_residual = false;       // b - A x, computed anew, is in the workspace's exact.r
};

double ordered_dot(const double* a, const double* b, std::size_t n);
double ordered_norm(const double* a, std::size_t n);
// Of floats, summed in double precision.
double ordered_dot(const float* a, const float* b, std::size_t n);
// The same on several threads, in an order of its own that their number does not change.
double ordered_dot(const double* a, const double* b, std::size_t n, Threads threads);
double ordered_norm(const double* a, std::size_t n, Threads threads);

// A system by its products, each with the inner products that an iteration takes of it: who passes over the vectors
// anyway can take them on the way.
template <class T>
struct PcgProducts {
    // out = A p; returns p.out. In single precision p has one number more than the system, whose value does not matter.
    std::function<double(const T* p, T* out)> apply;
    // z ~ A^-1 r; returns r.z and ap.z. norm: |r| or a number of its size. descended: r and norm are those that
    // `descend` had last. In single precision z has one number more than the system, whose value does not matter.
    std::function<std::array<double, 2>(const T* r, double norm, bool descended, const T* ap, T* z)> precondition;
    // The two updates of the vectors, if who has the products can do them on the way too:
    // p = z + beta p and ap = A p, also as A z + beta ap (Chronopoulos & Gear 1989); returns p.ap. With beta = 0 the
    // old values are not read.
    std::function<double(const T* z, T beta, T* p, T* ap)> direct = nullptr;
    // x += step p, r -= step ap; returns |r|^2.
    std::function<double(T step, const T* p, const T* ap, T* x, T* r, double norm)> descend = nullptr;
};
using PcgSystem = PcgProducts<double>;

// Solves A x = b from x = 0 to |r| <= tolerance |b|. Stops at negative curvature, unless `indefinite`: with few
// negative eigenvalues the iteration as a rule still converges, to a solution that is then no minimum.
PcgResult pcg(std::size_t n, const double* b, double* x, double tolerance, int max_iterations, const PcgSystem& system,
              Threads threads, PcgWorkspace& ws, bool indefinite = false);
// The same by products alone: apply(p, out): out = A p; precondition(r, z): z ~ A^-1 r.
PcgResult pcg(std::size_t n, const double* b, double* x, double tolerance, int max_iterations,
              const std::function<void(const double*, double*)>& apply,
              const std::function<void(const double*, double*)>& precondition, Threads threads, PcgWorkspace& ws,
              bool indefinite = false);
// The same with iterations in single precision, which pass half the memory. Whenever they have gained about two digits
// the residual is computed anew in double precision, and the directions go on from there (reliable updates: Sleijpen &
// van der Vorst 1996), also at the end, unless rounding(x), a bound of the rounding of A x in single precision, is far
// below the tolerance: the result is as exact as the other's. Where single precision does not get on, or finds
// curvature that is not positive, double precision takes over.
PcgResult mixed_pcg(std::size_t n, const double* b, double* x, double tolerance, int max_iterations,
                    const PcgSystem& system, const PcgProducts<float>& single,
                    const std::function<double(const float*)>& rounding, Threads threads, PcgWorkspace& ws,
                    bool indefinite = false);

}  // namespace dqa
