// SPDX-License-Identifier: MIT
#include "linalg/pcg.hpp"

#include <algorithm>
#include <cmath>

namespace dqa {

double ordered_dot(const double* a, const double* b, std::size_t n) {
    // Four interleaved sums: a fixed order, and no chain of dependent additions.
    double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    std::size_t i = 0;
    for (; i + 4 <= n; i += 4)
        s0 += a[i] * b[i], s1 += a[i + 1] * b[i + 1], s2 += a[i + 2] * b[i + 2], s3 += a[i + 3] * b[i + 3];
    for (; i < n; ++i) s0 += a[i] * b[i];
    return (s0 + s1) + (s2 + s3);
}

PcgResult pcg(std::size_t n, const double* b, double* x, double tolerance, int max_iterations,
              const std::function<void(const double*, double*)>& apply,
              const std::function<void(const double*, double*)>& precondition, PcgWorkspace& ws) {
    PcgResult result;
    std::fill(x, x + n, 0.0);
    ws.r.assign(b, b + n), ws.r_old.resize(n), ws.z.resize(n), ws.p.resize(n), ws.ap.resize(n);
    const double norm_b = std::sqrt(ordered_dot(b, b, n));
    if (norm_b == 0) {  // not for NaN, which must not pass for a solved system
        result.converged = true;
        return result;
    }
    double rz = 0.0;
    result.relative_residual = 1.0;
    for (int k = 0; k < max_iterations; ++k) {
        precondition(ws.r.data(), ws.z.data());
        const double rz_new = ordered_dot(ws.r.data(), ws.z.data(), n);
        if (k == 0) {
            ws.p = ws.z;
        } else {
            const double beta = std::max(0.0, (rz_new - ordered_dot(ws.r_old.data(), ws.z.data(), n)) / rz);
            for (std::size_t i = 0; i < n; ++i) ws.p[i] = ws.z[i] + beta * ws.p[i];
        }
        rz = rz_new;
        apply(ws.p.data(), ws.ap.data());
        const double curvature = ordered_dot(ws.p.data(), ws.ap.data(), n);
        if (!(curvature > 0)) {
            result.negative_curvature = true;
            return result;
        }
        const double step = rz / curvature;
        ws.r_old = ws.r;
        for (std::size_t i = 0; i < n; ++i) x[i] += step * ws.p[i], ws.r[i] -= step * ws.ap[i];
        result.iterations = k + 1;
        result.relative_residual = std::sqrt(ordered_dot(ws.r.data(), ws.r.data(), n)) / norm_b;
        if (result.relative_residual <= tolerance) {
            result.converged = true;
            return result;
        }
        if (!std::isfinite(result.relative_residual)) return result;
    }
    return result;
}

}  // namespace dqa
