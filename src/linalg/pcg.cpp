// SPDX-License-Identifier: MIT
#include "linalg/pcg.hpp"

#include <algorithm>
#include <cmath>

namespace dqa {
namespace {

constexpr int kGrain = 1024;      // entries of a chunk: the unit of ordered sums
constexpr double kUpdate = 1e-2;  // about what single precision may gain before it is checked
constexpr double kTrusted = 0.1;  // of a tolerance: rounding that need not be

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

double ordered_dot(const float* a, const float* b, std::size_t n) {
    double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    std::size_t i = 0;
    for (; i + 4 <= n; i += 4) {
        s0 += static_cast<double>(a[i]) * static_cast<double>(b[i]);
        s1 += static_cast<double>(a[i + 1]) * static_cast<double>(b[i + 1]);
        s2 += static_cast<double>(a[i + 2]) * static_cast<double>(b[i + 2]);
        s3 += static_cast<double>(a[i + 3]) * static_cast<double>(b[i + 3]);
    }
    for (; i < n; ++i) s0 += static_cast<double>(a[i]) * static_cast<double>(b[i]);
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

namespace {

// Conjugate gradients on the way: what one iteration leaves to the next besides the vectors.
struct Progress {
    double rz = 0.0, step = 0.0;
    double norm = 0.0;  // of r
    bool begun = false;
    bool negative_curvature = false;
};

// Iterates on x with its residual r until |r| <= target. Returns the number of iterations.
template <class T>
int iterate(std::size_t n, double target, int max_iterations, const PcgProducts<T>& system, Threads threads,
            PcgVectors<T>& v, T* x, bool indefinite, Progress& at) {
    const int size = static_cast<int>(n);
    T *r = v.r.data(), *z = v.z.data(), *p = v.p.data(), *ap = v.ap.data();
    const auto direct = [&](T beta) {
        if (system.direct) return system.direct(z, beta, p, ap);
        parallel_chunks(threads, size, kGrain, [&](int begin, int end) {
            if (beta == T(0))
                std::copy(z + begin, z + end, p + begin);
            else
                for (int i = begin; i < end; ++i) p[i] = z[i] + beta * p[i];
        });
        return system.apply(p, ap);
    };
    const auto descend = [&](T step) {
        if (system.descend) return system.descend(step, p, ap, x, r, at.norm);
        return parallel_sum(threads, size, kGrain, [&](int begin, int end) {
            for (int i = begin; i < end; ++i) x[i] += step * p[i], r[i] -= step * ap[i];
            return ordered_dot(r + begin, r + begin, static_cast<std::size_t>(end - begin));
        });
    };
    double norm_before = 0.0;
    for (int k = 0; k < max_iterations; ++k) {
        const bool descended = k > 0 && system.descend;
        const auto [rz, apz] = system.precondition(r, descended ? norm_before : at.norm, descended, ap, z);
        // Flexible beta: z . (r - r_before) with r - r_before = -step A p.
        const T beta = at.begun ? static_cast<T>(std::max(0.0, -at.step * apz / at.rz)) : T(0);
        at.rz = rz, at.begun = true;
        const double curvature = direct(beta);
        if (!(curvature > 0)) {
            at.negative_curvature = true;
            if (!indefinite || !(curvature < 0)) return k;
        }
        at.step = rz / curvature;
        norm_before = at.norm;
        at.norm = std::sqrt(descend(static_cast<T>(at.step)));
        if (at.norm <= target || !std::isfinite(at.norm)) return k + 1;
    }
    return max_iterations;
}

// Double precision from r on, as much as is left of max_iterations.
void finish(std::size_t n, double norm_b, double* x, double tolerance, int max_iterations, const PcgSystem& system,
            Threads threads, PcgVectors<double>& v, bool indefinite, Progress& at, PcgResult& result) {
    result.iterations +=
        iterate(n, tolerance * norm_b, max_iterations - result.iterations, system, threads, v, x, indefinite, at);
    result.negative_curvature = at.negative_curvature;
    result.relative_residual = at.norm / norm_b;
    result.converged = result.relative_residual <= tolerance;
}

}  // namespace

PcgResult pcg(std::size_t n, const double* b, double* x, double tolerance, int max_iterations, const PcgSystem& system,
              Threads threads, PcgWorkspace& ws, bool indefinite) {
    PcgResult result;
    PcgVectors<double>& v = ws.exact;
    std::fill(x, x + n, 0.0);
    v.r.assign(b, b + n), v.z.resize(n), v.p.resize(n), v.ap.assign(n, 0.0);
    Progress at;
    at.norm = ordered_norm(b, n, threads);
    if (at.norm == 0)  // not for NaN, which must not pass for a solved system
        result.converged = true;
    else
        finish(n, at.norm, x, tolerance, max_iterations, system, threads, v, indefinite, at, result);
    return result;
}

PcgResult mixed_pcg(std::size_t n, const double* b, double* x, double tolerance, int max_iterations,
                    const PcgSystem& system, const PcgProducts<float>& single,
                    const std::function<double(const float*)>& rounding, Threads threads, PcgWorkspace& ws,
                    bool indefinite) {
    const int size = static_cast<int>(n);
    const double norm_b = ordered_norm(b, n, threads);
    if (!(norm_b > 0) || !std::isfinite(norm_b))
        return pcg(n, b, x, tolerance, max_iterations, system, threads, ws, indefinite);
    PcgResult result;
    PcgVectors<double>& v = ws.exact;
    PcgVectors<float>& s = ws.single;
    v.r.resize(n), v.ap.resize(n);
    s.x.resize(n), s.r.resize(n), s.z.resize(n + 1), s.p.resize(n + 1), s.ap.assign(n, 0.0f);
    // Scaled to unit size: single precision must not under- or overflow whatever the units of the right-hand side.
    const double scale = 1.0 / norm_b;
    parallel_chunks(threads, size, kGrain, [&](int begin, int end) {
        for (int i = begin; i < end; ++i)
            x[i] = 0.0, v.r[i] = b[i], s.x[i] = 0.0f, s.r[i] = static_cast<float>(scale * b[i]);
    });
    Progress at;
    at.norm = 1.0;
    double exact = 1.0;  // the last residual that was computed in double precision
    while (result.iterations < max_iterations) {
        // In equal rounds: a last one for half a digit would cost as much as the others.
        const double left = tolerance / exact, rounds = std::max(1.0, std::round(std::log(left) / std::log(kUpdate)));
        const double goal = std::max(tolerance, std::pow(left, 1.0 / rounds) * exact);
        result.iterations +=
            iterate(n, goal, max_iterations - result.iterations, single, threads, s, s.x.data(), false, at);
        if (!std::isfinite(at.norm)) break;
        const bool trusted = at.norm <= tolerance && rounding(s.x.data()) <= kTrusted * tolerance;
        parallel_chunks(threads, size, kGrain, [&](int begin, int end) {
            for (int i = begin; i < end; ++i) x[i] += norm_b * static_cast<double>(s.x[i]), s.x[i] = 0.0f;
        });
        if (trusted) {
            result.relative_residual = at.norm;
            result.converged = true;
            return result;
        }
        system.apply(x, v.ap.data());
        const double rr = parallel_sum(threads, size, kGrain, [&](int begin, int end) {
            for (int i = begin; i < end; ++i) v.r[i] = b[i] - v.ap[i], s.r[i] = static_cast<float>(scale * v.r[i]);
            return ordered_dot(v.r.data() + begin, v.r.data() + begin, static_cast<std::size_t>(end - begin));
        });
        const double before = exact;
        exact = at.norm = scale * std::sqrt(rr);
        result.relative_residual = exact;
        if (exact <= tolerance) {
            result.converged = result.left_residual = true;
            return result;
        }
        if (at.negative_curvature || !(exact < 0.1 * before)) break;
    }
    v.z.resize(n), v.p.resize(n);
    Progress on;
    on.norm = norm_b * exact;
    finish(n, norm_b, x, tolerance, max_iterations, system, threads, v, indefinite, on, result);
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
                           [&](const double* r, double, bool, const double* ap, double* z) -> std::array<double, 2> {
                               precondition(r, z);
                               return {ordered_dot(r, z, n, threads), ordered_dot(ap, z, n, threads)};
                           }};
    return pcg(n, b, x, tolerance, max_iterations, system, threads, ws, indefinite);
}

}  // namespace dqa
