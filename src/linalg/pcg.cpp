// SPDX-License-Identifier: MIT
#include "linalg/pcg.hpp"

#include <algorithm>
#include <cmath>

namespace dqa {
namespace {

constexpr int kGrain = 4096;  // entries of a chunk: the unit of ordered sums

}  // namespace

double ordered_dot(const double* a, const double* b, std::size_t n) {
    // Four interleaved sums: a fixed order, and no chain of dependent additions.
    double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    std::size_t i = 0;
    for (; i + 4 <= n; i += 4)
        s0 += a[i] * b[i], s1 += a[i + 1] * b[i + 1], s2 += a[i + 2] * b[i + 2], s3 += a[i + 3] * b[i + 3];
    for (; i < n; ++i) s0 += a[i] * b[i];
    return (s0 + s1) + (s2 + s3);
}

double ordered_norm(const double* a, std::size_t n) {
    return std::sqrt(ordered_dot(a, a, n));
}

double ordered_dot(const double* a, const double* b, std::size_t n, Threads threads) {
    return parallel_sum(threads, static_cast<int>(n), kGrain, [&](int begin, int end) {
        return ordered_dot(a + begin, b + begin, static_cast<std::size_t>(end - begin));
    });
}

double ordered_norm(const double* a, std::size_t n, Threads threads) {
    return std::sqrt(ordered_dot(a, a, n, threads));
}

PcgResult pcg(std::size_t n, const double* b, double* x, double tolerance, int max_iterations, const PcgSystem& system,
              Threads threads, PcgWorkspace& ws, bool indefinite) {
    PcgResult result;
    std::fill(x, x + n, 0.0);
    ws.r.assign(b, b + n), ws.z.resize(n), ws.p.resize(n), ws.ap.assign(n, 0.0);
    const double norm_b = ordered_norm(b, n, threads);
    if (norm_b == 0) {  // not for NaN, which must not pass for a solved system
        result.converged = true;
        return result;
    }
    const int size = static_cast<int>(n);
    double *r = ws.r.data(), *z = ws.z.data(), *p = ws.p.data(), *ap = ws.ap.data();
    double rz = 0.0, step = 0.0, norm_r = norm_b;
    result.relative_residual = 1.0;
    for (int k = 0; k < max_iterations; ++k) {
        const auto [rz_new, apz] = system.precondition(r, norm_r, ap, z);
        // Flexible beta: z . (r - r_before) with r - r_before = -step A p.
        const double beta = k == 0 ? 0.0 : std::max(0.0, -step * apz / rz);
        parallel_chunks(threads, size, kGrain, [&](int begin, int end) {
            if (k == 0)
                std::copy(z + begin, z + end, p + begin);
            else
                for (int i = begin; i < end; ++i) p[i] = z[i] + beta * p[i];
        });
        rz = rz_new;
        const double curvature = system.apply(p, ap);
        if (!(curvature > 0)) {
            result.negative_curvature = true;
            if (!indefinite || !(curvature < 0)) return result;
        }
        step = rz / curvature;
        const double rr = parallel_sum(threads, size, kGrain, [&](int begin, int end) {
            for (int i = begin; i < end; ++i) x[i] += step * p[i], r[i] -= step * ap[i];
            return ordered_dot(r + begin, r + begin, static_cast<std::size_t>(end - begin));
        });
        norm_r = std::sqrt(rr);
        result.iterations = k + 1;
        result.relative_residual = norm_r / norm_b;
        if (result.relative_residual <= tolerance) {
            result.converged = true;
            return result;
        }
        if (!std::isfinite(result.relative_residual)) return result;
    }
    return result;
}

PcgResult pcg(std::size_t n, const double* b, double* x, double tolerance, int max_iterations,
              const std::function<void(const double*, double*)>& apply,
              const std::function<void(const double*, double*)>& precondition, Threads threads, PcgWorkspace& ws,
              bool indefinite) {
    const PcgSystem system{[&](const double* p, double* out) {
                               apply(p, out);
                               return ordered_dot(p, out, n, threads);
                           },
                           [&](const double* r, double, const double* ap, double* z) -> std::array<double, 2> {
                               precondition(r, z);
                               return {ordered_dot(r, z, n, threads), ordered_dot(ap, z, n, threads)};
                           }};
    return pcg(n, b, x, tolerance, max_iterations, system, threads, ws, indefinite);
}

}  // namespace dqa
