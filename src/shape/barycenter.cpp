// SPDX-License-Identifier: MIT
#include "shape/barycenter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "grid/error.hpp"
#include "grid/log.hpp"
#include "grid/parallel.hpp"
#include "shape/anderson.hpp"
#include "shape/tangent.hpp"

namespace dqa {
namespace {

constexpr double kFloor = 1e-290;  // of K w in the linear form
const double kLogFloor = std::log(kFloor);
constexpr int kWider = 4;                 // wider kernels to start from, each 1 / sqrt 2 of the one before
constexpr double kStartTolerance = 0.03;  // marginal error at which a wider kernel has done its work
constexpr double kSettled = 0.05;         // marginal error below which the coarse correction is kept
constexpr int kStartIterations = 400;     // and its most iterations
// Share of p that cells with a floored d may carry in all: below the rounding of p's sum. The floor makes p larger, so
// that the true share is smaller still.
constexpr double kNegligible = 1e-17;

struct Parts {
    std::vector<std::size_t> active, idle;  // alpha_i > 0, = 0
    std::vector<double> weights, ones;      // of the active ones; as many ones as idle ones
};

Parts parts_of(const std::vector<double>& weights) {
    Parts parts;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        if (weights[i] > 0)
            parts.active.push_back(i), parts.weights.push_back(weights[i]);
        else
            parts.idle.push_back(i), parts.ones.push_back(1.0);
    }
    return parts;
}

std::vector<double> gathered(const std::vector<double>& z, const std::vector<std::size_t>& which, std::size_t n) {
    std::vector<double> out(which.size() * n);
    for (std::size_t k = 0; k < which.size(); ++k)
        std::copy_n(z.begin() + static_cast<long>(which[k] * n), n, out.begin() + static_cast<long>(k * n));
    return out;
}

struct Counter {
    int iterations = 0, linear = 0;
    int all() const { return iterations + linear; }
};

// Iterates for one width of the kernel; bases for which its linear form underflows go over to the logarithmic one.
class Solver {
public:
    // counter: iterations so far, over all widths.
    Solver(const GaussianKernel& kernel, const Densities& bases, const std::vector<double>& weights,
           const BarycenterSettings& settings, Counter& counter)
        : settings_(settings),
          weights_(weights),
          parts_(parts_of(weights)),
          m_(bases.size()),
          n_(static_cast<std::size_t>(kernel.size())),
          transport_(kernel, bases, std::vector<char>(m_, settings.force_log), settings.threads),
          kernels_(barycenter_kernels(InstructionSet::automatic)),
          counter_(counter),
          kv_(m_ * n_),
          w_(m_ * n_),
          log_d_(m_ * n_),
          f_(m_ * n_),
          log_p_(n_),
          p_(n_) {}

    // From x to a marginal error within the tolerance. False if `limit` iterations of this width are spent.
    bool run(std::vector<double>& x, double tolerance, int limit) {
        const double infinity = std::numeric_limits<double>::infinity();
        std::vector<double> best_x;
        double best = infinity, before = infinity;
        Anderson anderson(m_ * n_, settings_.window);
        const int last = std::min(settings_.max_iterations, limit < settings_.max_iterations - counter_.all()
                                                                ? counter_.all() + limit
                                                                : settings_.max_iterations);
        // Steps of the iteration still to do before the next of Newton's; a few of them plain. Twice as many each time.
        int relief = settings_.window == 0 ? std::numeric_limits<int>::max() : 0, plain = relief, next_relief = 8;
        bool newton = false;
        while (counter_.all() < last) {
            const Outcome outcome = evaluate(x);
            // Where a step of Newton's went too far, the form of the kernel is not to blame.
            const bool stray = newton && outcome != Outcome::fine;
            tick(counter_.iterations);
            if (outcome == Outcome::underflow && !stray) {
                use_logarithms(x);
                best = before = infinity, anderson.restart();
                continue;
            }
            if (outcome != Outcome::fine) {
                if (best_x.empty()) fail(Status::NOT_CONVERGED, "barycentre: the iteration became non-finite at once");
                x = best_x, best = infinity, anderson.restart(), newton = false;
                relief = next_relief, plain = stray ? 3 : 5, next_relief *= 2;
                continue;
            }
            if (error_ <= tolerance) return true;
            if (newton && error_ > 0.9 * before) {  // no progress: back to where it was, and another way on
                newton = false;
                if (error_ > before) {
                    x = best_x, best = infinity;
                    anderson.restart(), relief = next_relief, plain = 3, next_relief *= 2;
                    continue;
                }
                anderson.restart(), relief = next_relief, plain = 3, next_relief *= 2;
            }
            if (relief > 0 && settings_.window > 0 && error_ > 10.0 * best && error_ > before && plain == 0) {
                // Acceleration went astray; a few plain steps from the best iterate, which always contract.
                x = best_x, best = infinity, anderson.restart(), plain = 3;
                continue;
            }
            if (error_ < best) {
                best = error_;
                if (settings_.window > 0) best_x = x;
            }
            before = error_;
            if (relief == 0) {
                newton_step(x, tolerance), newton = true;
            } else if (plain > 0) {
                for (std::size_t k = 0; k < x.size(); ++k) x[k] += f_[k];
                if (settings_.window > 0) --plain, --relief;
            } else {
                anderson.step(x, f_, relative_p());
                --relief;
            }
        }
        return false;
    }

    double error() const { return error_; }

    void write(const std::vector<double>& x, Barycenter& out) const {
        out.m = static_cast<int>(m_), out.n = static_cast<int>(n_);
        out.weights = weights_;
        out.p = p_, out.log_d = log_d_, out.log_v = x, out.log_kv = kv_;
        out.logarithmic = transport_.logarithmic();
        out.iterations = counter_.iterations, out.linear_iterations = counter_.linear, out.marginal_error = error_;
        for (std::size_t k = 0; k < kv_.size(); ++k)
            if (!transport_.logarithmic(k / n_)) out.log_kv[k] = kv_[k] > 0 ? std::log(kv_[k]) : 0.0;
    }
    std::size_t n_logarithmic() const {
        const auto& forms = transport_.logarithmic();
        return static_cast<std::size_t>(std::count(forms.begin(), forms.end(), 1));
    }

private:
    enum class Outcome { fine, underflow, not_finite };

    void tick(int& kind) {
        ++kind;
        if (settings_.monitor) settings_.monitor(counter_.all(), error_);
    }

    // v = p / d, where d is floored, is no larger; beyond that it would overflow.
    void limit(std::vector<double>& x) const {
        for (std::size_t i = 0; i < m_; ++i) {
            if (transport_.logarithmic(i)) continue;
            double* of_base = x.data() + i * n_;
            parallel_chunks(transport_.threads(), static_cast<int>(n_), 1 << 14, [&](int begin, int end) {
                for (int c = begin; c < end; ++c) of_base[c] = of_base[c] < -kLogFloor ? of_base[c] : -kLogFloor;
            });
        }
    }

    bool beyond_limit(const std::vector<double>& x) const {
        for (std::size_t k = 0; k < x.size(); ++k)
            if (x[k] > -kLogFloor && !transport_.logarithmic(k / n_)) return true;
        return false;
    }

    // Takes the base that underflowed worst over to the logarithmic form, or all where nothing else was left of p. The
    // others may have followed it: they are looked at anew, from the x that was not limited.
    void use_logarithms(std::vector<double>& x) {
        const std::size_t worst =
            static_cast<std::size_t>(std::max_element(floored_.begin(), floored_.end()) - floored_.begin());
        for (std::size_t i = 0; i < m_; ++i)
            if (i == worst || !(floored_[worst] > 0)) transport_.make_logarithmic(i);
        if (!unlimited_.empty()) x = unlimited_;
        log_message(LogLevel::debug, "barycentre: the linear kernel underflows; logarithmic for %zu of %zu bases",
                    n_logarithmic(), m_);
    }

    std::vector<double> relative_p() const {
        std::vector<double> q(n_);
        for (std::size_t c = 0; c < n_; ++c) q[c] = std::exp(log_p_[c] - log_peak_);
        return q;
    }

    // One iteration from x: w, d, p, f = T(x) - x and the marginal error.
    Outcome evaluate(std::vector<double>& x) {
        unlimited_.clear();
        if (beyond_limit(x)) unlimited_ = x;
        limit(x);
        transport_.sweep(x.data(), kv_.data(), w_.data(), log_d_.data(), kFloor);
        constexpr int grain = 1024;
        const int chunks = (static_cast<int>(n_) + grain - 1) / grain;
        std::vector<double> peak(static_cast<std::size_t>(chunks)), part(static_cast<std::size_t>(chunks) * m_);
        std::vector<double> at_floor(part.size(), 0.0);  // what p has in cells where d_i is floored
        parallel_chunks(transport_.threads(), static_cast<int>(n_), grain, [&](int begin, int end) {
            const std::size_t first = static_cast<std::size_t>(begin), count = static_cast<std::size_t>(end - begin);
            double* log_p = log_p_.data() + first;
            std::fill(log_p, log_p + count, 0.0);
            for (std::size_t i = 0; i < m_; ++i)
                if (weights_[i] > 0)
                    for (std::size_t c = 0; c < count; ++c) log_p[c] += weights_[i] * log_d_[i * n_ + first + c];
            kernels_.exp(log_p, p_.data() + first, end - begin);
            double largest = -std::numeric_limits<double>::infinity(), sum[grain];
            for (std::size_t c = 0; c < count; ++c) largest = log_p[c] > largest ? log_p[c] : largest;
            peak[first / grain] = largest;
            for (std::size_t i = 0; i < m_; ++i) {
                const std::size_t at = i * n_ + first;
                double lowest = 0.0;
                for (std::size_t c = 0; c < count; ++c) {
                    sum[c] = x[at + c] + log_d_[at + c];
                    f_[at + c] = log_p[c] - sum[c];
                    lowest = log_d_[at + c] < lowest ? log_d_[at + c] : lowest;
                }
                kernels_.exp(sum, sum, end - begin);
                double& floored = at_floor[first / grain * m_ + i];
                for (std::size_t c = 0; lowest <= kLogFloor && !transport_.logarithmic(i) && c < count; ++c)
                    if (log_d_[at + c] <= kLogFloor) floored += p_[first + c];
                double e = 0.0;
                for (std::size_t c = 0; c < count; ++c) e += std::fabs(sum[c] - p_[first + c]);
                part[first / grain * m_ + i] = e;
            }
        });
        log_peak_ = *std::max_element(peak.begin(), peak.end());
        error_ = 0.0;
        const bool finite_peak = std::isfinite(log_peak_);
        bool finite = finite_peak;
        for (std::size_t i = 0; i < m_; ++i) {
            double e = 0.0;
            for (std::size_t k = 0; k < static_cast<std::size_t>(chunks); ++k) e += part[k * m_ + i];
            floored_[i] = finite_peak && !std::isfinite(e) && !transport_.logarithmic(i) ? 1.0 : 0.0;
            finite = finite && std::isfinite(e);
            error_ = std::max(error_, e);
        }
        // The first p of supports far apart is below the smallest double everywhere; only its logarithm counts then.
        if (n_logarithmic() < m_ && (!finite || !(std::exp(log_peak_) > 0))) return Outcome::underflow;
        if (!finite) return Outcome::not_finite;
        double mass = 0.0;
        for (const double q : p_) mass += q;
        bool underflow = false;
        for (std::size_t i = 0; i < m_; ++i) {
            floored_[i] = 0.0;
            for (std::size_t k = 0; k < peak.size(); ++k) floored_[i] += at_floor[k * m_ + i];
            underflow = underflow || floored_[i] > kNegligible / static_cast<double>(m_) * mass;
        }
        return underflow ? Outcome::underflow : Outcome::fine;
    }

    // x += (I - P J)^-1 f. The residual that conjugate gradients leave is added too: a step of the iteration, which
    // settles the cells where p is next to nothing and conjugate gradients see nothing.
    void newton_step(std::vector<double>& x, double tolerance) {
        // J at v = p / d with the w of this d is self-adjoint under p.
        std::vector<double> y(x), kv(m_ * n_), w(m_ * n_), log_d(m_ * n_);
        for (std::size_t k = 0; k < y.size(); ++k) y[k] += f_[k];
        limit(y);
        transport_.sweep(y.data(), kv.data(), w.data(), log_d.data(), kFloor);
        tick(counter_.iterations);
        const Jacobian jacobian(transport_, y.data(), kv.data(), w_.data(), log_d_.data());
        // As accurate as the next error is going to be, and no better than what is asked for.
        const double accuracy = std::max(error_ < 1e-2 ? error_ : 0.1, 0.1 * tolerance / error_);
        const std::vector<double> q = relative_p();
        // Built anew while p still moves, then only told the new weights: that costs no iteration.
        if (!correction_ || error_built_ > kSettled)
            correction_.emplace(transport_.kernel().cells(), transport_.kernel().sigma(), q), error_built_ = error_;
        else
            correction_->reweight(q);
        std::vector<double> moved(n_, 0.0);  // what log p changes by beyond f
        const auto correct = [&](const std::vector<std::size_t>& which, const std::vector<double>& weights,
                                 bool joint) {
            const Tangent tangent(jacobian, transport_.threads(), which, weights, q, joint, *correction_);
            std::vector<double> b = gathered(f_, which, n_);
            for (std::size_t k = 0; !joint && k < b.size(); ++k) b[k] += moved[k % n_];
            tangent.project(b);
            std::vector<double> z = b, r(b.size());
            tangent.laplacian(z, r);
            tick(counter_.linear);
            tangent.project(r);
            const double target = accuracy * accuracy * tangent.product(b, b);
            for (std::size_t k = 0; k < r.size(); ++k) r[k] = b[k] - r[k];
            tangent.solve(z, r, target, [&](double) {
                tick(counter_.linear);
                if (counter_.all() >= settings_.max_iterations) not_converged();
            });
            if (joint && !parts_.idle.empty()) {
                std::vector<double> lz(z.size());
                tangent.laplacian(z, lz);
                moved = tangent.mean(lz);
            }
            for (std::size_t k = 0; k < z.size(); ++k) z[k] += r[k];
            tangent.centre(z);
            for (std::size_t k = 0; k < which.size(); ++k)
                for (std::size_t c = 0; c < n_; ++c) x[which[k] * n_ + c] += z[k * n_ + c];
        };
        correct(parts_.active, parts_.weights, true);
        if (!parts_.idle.empty()) correct(parts_.idle, parts_.ones, false);
    }

public:
    [[noreturn]] void not_converged() const {
        fail(Status::NOT_CONVERGED,
             "barycentre: marginal error %.3g after %d iterations, expected <= %.3g; raise max_iterations or sigma",
             error_, counter_.all(), settings_.tolerance);
    }

private:
    const BarycenterSettings& settings_;
    const std::vector<double>& weights_;
    Parts parts_;
    std::size_t m_, n_;
    Transport transport_;
    const BarycenterKernels& kernels_;
    Counter& counter_;
    std::vector<double> kv_, w_, log_d_, f_, log_p_, p_;
    std::vector<double> floored_ = std::vector<double>(m_, 0.0);  // [m], what p has in cells where d_i is floored
    std::vector<double> unlimited_;                               // x of the last evaluation, if it was limited
    std::optional<CoarseCorrection> correction_;
    double error_built_ = 0.0;
    double log_peak_ = 0.0, error_ = std::numeric_limits<double>::infinity();
};

}  // namespace

Barycenter solve_barycenter(const GaussianKernel& kernel, const std::vector<std::vector<double>>& bases,
                            const std::vector<double>& weights, const BarycenterSettings& settings) {
    Barycenter solution;
    with_crew(settings.threads.count, [&](Threads threads) {
        BarycenterSettings s(settings);
        s.threads = threads;
        Counter counter;
        std::vector<double> x(bases.size() * static_cast<std::size_t>(kernel.size()), 0.0);
        const double narrowing = std::sqrt(0.5);
        for (int level = s.window > 0 ? kWider : 0; level > 0; --level) {
            const GaussianKernel wide(kernel.cells(), kernel.sigma() * std::pow(narrowing, -level));
            const std::vector<double> start = x;
            Solver solver(wide, bases, weights, s, counter);
            if (!solver.run(x, std::max(kStartTolerance, s.tolerance), kStartIterations)) x = start;
            if (counter.all() >= s.max_iterations) solver.not_converged();
            for (double& value : x) value *= 2.0;  // sigma^2 x is kept
        }
        Solver solver(kernel, bases, weights, s, counter);
        if (!solver.run(x, s.tolerance, s.max_iterations)) solver.not_converged();
        solver.write(x, solution);
        log_message(
            LogLevel::debug,
            "barycentre: %d iterations to a marginal error of %.2g, the logarithmic kernel for %zu of %zu bases",
            counter.all(), solution.marginal_error, solver.n_logarithmic(), bases.size());
    });
    return solution;
}

// With g = dL/dp and <a, b> = sum p a b, the adjoint of the fixed point reduces to: find y_i (alpha_i > 0) and tau with
//   (I - J_i) y_i = tau for every i,   sum_i alpha_i y_i = g   (all up to constants),
// the optimality conditions of min sum_i alpha_i <y_i, (I - J_i) y_i> / 2 under the constraint; solved by conjugate
// gradients in the subspace of the constraint, where the operator is symmetric positive semi-definite. Then
// dL/dalpha_k = <tau, log d_k>. (Derivation: lambda_i = J_i^T (lambda_i - alpha_i t), t = g p + sum_i lambda_i, written
// for m_i = lambda_i / p; J_i is self-adjoint under p at the fixed point, so m_i = -alpha_i (I - J_i)^+ J_i tau.)
static std::vector<double> pull_back(const GaussianKernel& kernel, const std::vector<std::vector<double>>& bases,
                                     const Barycenter& s, const double* p_bar, const BarycenterSettings& settings) {
    const std::size_t m = static_cast<std::size_t>(s.m), n = static_cast<std::size_t>(s.n);
    const Parts parts = parts_of(s.weights);
    const Transport transport(kernel, bases, s.logarithmic, settings.threads);
    // As in newton_step: J at v = p / d is self-adjoint under p, whatever error the solution has kept.
    std::vector<double> x(m * n), w(m * n), kv(m * n), new_w(m * n), new_log_d(m * n);
    std::vector<double> log_p(n, 0.0);
    for (const std::size_t i : parts.active)
        for (std::size_t c = 0; c < n; ++c) log_p[c] += s.weights[i] * s.log_d[i * n + c];
    for (std::size_t i = 0; i < m; ++i)
        for (std::size_t c = 0; c < n; ++c) {
            const std::size_t k = i * n + c;
            x[k] = log_p[c] - s.log_d[k];
            if (!s.logarithmic[i]) x[k] = std::min(x[k], -kLogFloor);
            const double log_w =
                bases[i][c] > 0 ? std::log(bases[i][c]) - s.log_kv[k] : -std::numeric_limits<double>::infinity();
            w[k] = s.logarithmic[i] ? log_w : std::exp(log_w);
        }
    transport.sweep(x.data(), kv.data(), new_w.data(), new_log_d.data(), kFloor);
    const Jacobian jacobian(transport, x.data(), kv.data(), w.data(), s.log_d.data());
    std::vector<double> q(s.p);
    const double peak = *std::max_element(q.begin(), q.end());
    for (double& v : q) v /= peak;
    const CoarseCorrection correction(kernel.cells(), kernel.sigma(), q);
    const Tangent tangent(jacobian, settings.threads, parts.active, parts.weights, q, true, correction);
    const std::vector<double> gamma(p_bar, p_bar + n);
    std::vector<double> y(tangent.size()), ly(y.size()), r(y.size());
    for (std::size_t k = 0; k < parts.active.size(); ++k)
        std::copy(gamma.begin(), gamma.end(), y.begin() + static_cast<long>(k * n));
    tangent.centre(y);
    tangent.laplacian(y, ly);
    if (parts.active.size() > 1) {
        for (std::size_t k = 0; k < r.size(); ++k) r[k] = -ly[k];
        tangent.project(r);
        const double scale = tangent.product(ly, ly) + tangent.product(r, r);
        const double target = std::max(1e-28, 1e-4 * settings.tolerance * settings.tolerance) * scale;
        int iteration = 0;
        tangent.solve(y, r, target, [&](double norm) {
            if (++iteration >= settings.max_iterations)
                fail(Status::NOT_CONVERGED, "barycentre pullback: relative residual %.3g after %d iterations",
                     norm / std::sqrt(scale), settings.max_iterations);
            if (settings.monitor) settings.monitor(-iteration, norm / std::sqrt(scale));
        });
        tangent.laplacian(y, ly);
    }
    std::vector<double> tau = tangent.mean(ly);
    double mass = 0.0, constant = 0.0;
    for (std::size_t c = 0; c < n; ++c) mass += s.p[c], constant += s.p[c] * tau[c];
    std::vector<double> bar(m, 0.0);
    double average = 0.0;
    for (std::size_t k = 0; k < m; ++k) {
        for (std::size_t c = 0; c < n; ++c) bar[k] += s.p[c] * (tau[c] - constant / mass) * s.log_d[k * n + c];
        average += bar[k] / static_cast<double>(m);
    }
    for (double& b : bar) b -= average;
    return bar;
}

std::vector<double> barycenter_pullback(const GaussianKernel& kernel, const std::vector<std::vector<double>>& bases,
                                        const Barycenter& solution, const double* p_bar,
                                        const BarycenterSettings& settings) {
    std::vector<double> bar;
    with_crew(settings.threads.count, [&](Threads threads) {
        BarycenterSettings s(settings);
        s.threads = threads;
        bar = pull_back(kernel, bases, solution, p_bar, s);
    });
    return bar;
}

}  // namespace dqa
