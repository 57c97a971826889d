// SPDX-License-Identifier: MIT
#include "shape/barycenter.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <limits>

#include "grid/error.hpp"
#include "grid/log.hpp"
#include "grid/parallel.hpp"

namespace dqa {
namespace {

constexpr double kFloor = 1e-290;  // of K w in the linear form
const double kLogFloor = std::log(kFloor);
const double kLogNegligible = std::log(1e-30);  // of the peak of p: a floored cell may carry no more than this

// One half-iteration of base i: from x (log v) to log(K v) and log d. Linear: returns the cells where d was floored.
class Sweep {
public:
    Sweep(const GaussianKernel& kernel, const std::vector<std::vector<double>>& bases, bool logarithmic)
        : kernel_(kernel), bases_(bases), logarithmic_(logarithmic) {}

    void base(std::size_t i, const double* x, double* log_kv, double* log_d) const {
        const std::size_t n = static_cast<std::size_t>(kernel_.size());
        std::vector<double> a(n), b(n), scratch(n);
        if (logarithmic_) {
            kernel_.apply_log(x, log_kv, nullptr);
            for (std::size_t c = 0; c < n; ++c)
                a[c] = bases_[i][c] > 0 ? std::log(bases_[i][c]) - log_kv[c] : -std::numeric_limits<double>::infinity();
            kernel_.apply_log(a.data(), log_d, nullptr);
            return;
        }
        for (std::size_t c = 0; c < n; ++c) a[c] = std::exp(x[c]);
        kernel_.apply(a.data(), b.data(), scratch.data());
        for (std::size_t c = 0; c < n; ++c) {
            log_kv[c] = std::log(b[c]);
            a[c] = bases_[i][c] > 0 ? bases_[i][c] / b[c] : 0.0;
        }
        kernel_.apply(a.data(), b.data(), scratch.data());
        for (std::size_t c = 0; c < n; ++c) log_d[c] = std::log(std::max(b[c], kFloor));
    }

private:
    const GaussianKernel& kernel_;
    const std::vector<std::vector<double>>& bases_;
    bool logarithmic_;
};

// Anderson mixing (type II) of x <- T(x): minimises the weighted residual over the affine span of the last iterates.
class Anderson {
public:
    Anderson(std::size_t size, int window) : size_(size), window_(static_cast<std::size_t>(window)) {}

    void restart() { dx_.clear(), df_.clear(), gram_.resize(0, 0), have_last_ = false; }

    // x: iterate, f = T(x) - x; weight [size]; overwrites x with the next iterate.
    void step(std::vector<double>& x, const std::vector<double>& f, const std::vector<double>& weight) {
        if (have_last_) {
            std::vector<double> ex(size_), ef(size_);
            for (std::size_t c = 0; c < size_; ++c) ex[c] = x[c] - last_x_[c], ef[c] = f[c] - last_f_[c];
            if (dx_.size() == window_) {
                dx_.erase(dx_.begin()), df_.erase(df_.begin());
                const Eigen::Index keep = gram_.rows() - 1;
                gram_ = gram_.bottomRightCorner(keep, keep).eval();
            }
            dx_.push_back(std::move(ex));
            df_.push_back(std::move(ef));
            // Only the new row is formed, with the weight of now; older rows keep the weight of their time, which
            // differs little and only shapes the mixing.
            const Eigen::Index last = static_cast<Eigen::Index>(df_.size()) - 1;
            gram_.conservativeResize(last + 1, last + 1);
            for (Eigen::Index i = 0; i <= last; ++i)
                gram_(i, last) = gram_(last, i) = product(df_[static_cast<std::size_t>(i)], df_.back(), weight);
        }
        last_x_ = x, last_f_ = f, have_last_ = true;
        const Eigen::Index k = static_cast<Eigen::Index>(df_.size());
        Eigen::VectorXd gamma;
        if (k > 0) {
            Eigen::VectorXd right(k), scale(k);
            for (Eigen::Index i = 0; i < k; ++i) {
                right(i) = product(df_[static_cast<std::size_t>(i)], f, weight);
                scale(i) = gram_(i, i) > 0 ? 1.0 / std::sqrt(gram_(i, i)) : 0.0;
            }
            const Eigen::MatrixXd gram = scale.asDiagonal() * gram_ * scale.asDiagonal();
            const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
            const Eigen::VectorXd projected = eigen.eigenvectors().transpose() * scale.cwiseProduct(right);
            const double cut = 1e-14 * eigen.eigenvalues().cwiseAbs().maxCoeff();
            Eigen::VectorXd scaled(k);
            for (Eigen::Index i = 0; i < k; ++i)
                scaled(i) = eigen.eigenvalues()(i) > cut ? projected(i) / eigen.eigenvalues()(i) : 0.0;
            gamma = scale.cwiseProduct(eigen.eigenvectors() * scaled);
        }
        for (std::size_t c = 0; c < size_; ++c) x[c] += f[c];
        for (Eigen::Index j = 0; j < k; ++j) {
            const std::vector<double>&ex = dx_[static_cast<std::size_t>(j)], &ef = df_[static_cast<std::size_t>(j)];
            const double g = gamma(j);
            for (std::size_t c = 0; c < size_; ++c) x[c] -= g * (ex[c] + ef[c]);
        }
    }

private:
    double product(const std::vector<double>& a, const std::vector<double>& b,
                   const std::vector<double>& weight) const {
        double s = 0.0;
        for (std::size_t at = 0; at < size_; at += weight.size())
            for (std::size_t c = 0; c < weight.size(); ++c) s += weight[c] * a[at + c] * b[at + c];
        return s;
    }

    std::size_t size_, window_;
    bool have_last_ = false;
    std::vector<double> last_x_, last_f_;
    std::vector<std::vector<double>> dx_, df_;
    Eigen::MatrixXd gram_{0, 0};
};

// Solves with one form of the kernel. Returns false if the linear form underflowed where it matters.
bool solve_with(const GaussianKernel& kernel, const std::vector<std::vector<double>>& bases,
                const std::vector<double>& weights, const BarycenterSettings& settings, bool logarithmic,
                Barycenter& out) {
    const std::size_t m = bases.size(), n = static_cast<std::size_t>(kernel.size());
    const Sweep sweep(kernel, bases, logarithmic);
    out.m = static_cast<int>(m), out.n = static_cast<int>(n);
    out.weights = weights;
    out.logarithmic = logarithmic;
    out.log_v.assign(m * n, 0.0);
    out.log_kv.assign(m * n, 0.0);
    out.log_d.assign(m * n, 0.0);
    out.p.assign(n, 0.0);
    std::vector<double> log_p(n), f(m * n), x = out.log_v;
    std::vector<double> best_x;
    double best_error = std::numeric_limits<double>::infinity(), last_error = best_error;
    Anderson anderson(m * n, settings.window);
    int plain_until = 3;  // a few plain steps first: acceleration from v = 1 has nothing to go by
    for (int iteration = 1; iteration <= settings.max_iterations; ++iteration) {
        parallel_chunks(settings.threads, static_cast<int>(m), 1, [&](int begin, int end) {
            for (int i = begin; i < end; ++i) {
                const std::size_t at = static_cast<std::size_t>(i) * n;
                sweep.base(static_cast<std::size_t>(i), x.data() + at, out.log_kv.data() + at, out.log_d.data() + at);
            }
        });
        double log_peak = -std::numeric_limits<double>::infinity();
        for (std::size_t c = 0; c < n; ++c) {
            double s = 0.0;
            for (std::size_t i = 0; i < m; ++i)
                if (weights[i] > 0) s += weights[i] * out.log_d[i * n + c];
            log_p[c] = s;
            out.p[c] = std::exp(s);
            log_peak = std::max(log_peak, s);
        }
        // The first p of supports far apart is below the smallest double everywhere; only its logarithm counts then.
        bool finite = std::isfinite(log_peak) && (logarithmic || std::exp(log_peak) > 0);
        double error = 0.0;
        for (std::size_t i = 0; i < m && finite; ++i) {
            double e = 0.0;
            for (std::size_t c = 0; c < n; ++c) {
                const double log_d = out.log_d[i * n + c];
                e += std::fabs(std::exp(x[i * n + c] + log_d) - out.p[c]);
                f[i * n + c] = log_p[c] - log_d - x[i * n + c];
                if (!logarithmic && log_d <= kLogFloor && log_p[c] > log_peak + kLogNegligible) return false;
            }
            error = std::max(error, e);
            finite = finite && std::isfinite(e);
        }
        if (!finite) {
            if (!logarithmic) return false;
            if (best_x.empty()) fail(Status::NOT_CONVERGED, "barycentre: the iteration became non-finite at once");
            x = best_x, anderson.restart(), plain_until = iteration + 5;
            continue;
        }
        if (settings.monitor) settings.monitor(iteration, error);
        out.iterations = iteration;
        out.marginal_error = error;
        if (error <= settings.tolerance) {
            out.log_v = x;
            log_message(LogLevel::debug, "barycentre: %d iterations to a marginal error of %.2g%s", iteration, error,
                        logarithmic ? " (logarithmic kernel)" : "");
            return true;
        }
        if (error < best_error) best_error = error, best_x = x;
        if (settings.window == 0 || iteration <= plain_until) {
            for (std::size_t c = 0; c < m * n; ++c) x[c] += f[c];
        } else if (error > 10.0 * best_error && error > last_error && plain_until < iteration) {
            // Safeguard: acceleration went astray; a few plain steps from the best iterate, which always contract.
            x = best_x, anderson.restart(), plain_until = iteration + 3;
            best_error = std::numeric_limits<double>::infinity();
        } else {
            std::vector<double> weight(n);
            const double peak = std::exp(log_peak);
            for (std::size_t c = 0; c < n; ++c) weight[c] = peak > 0 ? out.p[c] / peak : std::exp(log_p[c] - log_peak);
            anderson.step(x, f, weight);
        }
        last_error = error;
    }
    fail(Status::NOT_CONVERGED,
         "barycentre: marginal error %.3g after %d iterations, expected <= %.3g; raise max_iterations or sigma",
         out.marginal_error, settings.max_iterations, settings.tolerance);
}

// y <- J_i y, J_i = diag(1/d) K diag(w / (K v)) K diag(v): a stochastic matrix, self-adjoint under the weight p.
class Transition {
public:
    Transition(const GaussianKernel& kernel, const std::vector<std::vector<double>>& bases, const Barycenter& s)
        : kernel_(kernel), n_(static_cast<std::size_t>(s.n)), logarithmic_(s.logarithmic) {
        const std::size_t m = static_cast<std::size_t>(s.m);
        v_.resize(m * n_), middle_.resize(m * n_), inv_d_.resize(m * n_);
        for (std::size_t i = 0; i < m; ++i) {
            for (std::size_t c = 0; c < n_; ++c) {
                const std::size_t k = i * n_ + c;
                const double log_w =
                    bases[i][c] > 0 ? std::log(bases[i][c]) - s.log_kv[k] : -std::numeric_limits<double>::infinity();
                if (logarithmic_) {
                    v_[k] = s.log_v[k], middle_[k] = log_w;
                } else {
                    v_[k] = std::exp(s.log_v[k]), middle_[k] = std::exp(log_w - s.log_kv[k]);
                    inv_d_[k] = std::exp(-s.log_d[k]);
                }
            }
        }
    }

    void apply(std::size_t i, const double* in, double* out) const {
        std::vector<double> a(n_), scratch(n_);
        if (logarithmic_) {
            // Two kernel means: over v, then over w; each keeps its own scale and cannot underflow.
            std::copy(in, in + n_, out);
            kernel_.apply_log(v_.data() + i * n_, a.data(), out);
            kernel_.apply_log(middle_.data() + i * n_, a.data(), out);
            return;
        }
        for (std::size_t c = 0; c < n_; ++c) a[c] = v_[i * n_ + c] * in[c];
        kernel_.apply(a.data(), a.data(), scratch.data());
        for (std::size_t c = 0; c < n_; ++c) a[c] *= middle_[i * n_ + c];
        kernel_.apply(a.data(), out, scratch.data());
        for (std::size_t c = 0; c < n_; ++c) out[c] *= inv_d_[i * n_ + c];
    }

private:
    const GaussianKernel& kernel_;
    std::size_t n_;
    bool logarithmic_;
    std::vector<double> v_, middle_, inv_d_;
};

}  // namespace

Barycenter solve_barycenter(const GaussianKernel& kernel, const std::vector<std::vector<double>>& bases,
                            const std::vector<double>& weights, const BarycenterSettings& settings) {
    Barycenter solution;
    with_crew(settings.threads.count, [&](Threads threads) {
        BarycenterSettings s(settings);
        s.threads = threads;
        if (!s.force_log && solve_with(kernel, bases, weights, s, false, solution)) return;
        if (!s.force_log)
            log_message(LogLevel::info, "barycentre: the linear kernel underflows here; logarithmic kernel used");
        solve_with(kernel, bases, weights, s, true, solution);
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
    const Transition transition(kernel, bases, s);
    std::vector<std::size_t> active;
    for (std::size_t i = 0; i < m; ++i)
        if (s.weights[i] > 0) active.push_back(i);
    const std::size_t a = active.size();
    double mass = 0.0;
    for (std::size_t c = 0; c < n; ++c) mass += s.p[c];
    const auto centre = [&](double* y) {  // removes the constant part under p
        double mean = 0.0;
        for (std::size_t c = 0; c < n; ++c) mean += s.p[c] * y[c];
        mean /= mass;
        for (std::size_t c = 0; c < n; ++c) y[c] -= mean;
    };
    // z_i -> (I - J_i) z_i for all active bases.
    const auto laplacian = [&](const std::vector<double>& in, std::vector<double>& out) {
        parallel_chunks(settings.threads, static_cast<int>(a), 1, [&](int begin, int end) {
            for (int k = begin; k < end; ++k) {
                const std::size_t at = static_cast<std::size_t>(k) * n;
                transition.apply(active[static_cast<std::size_t>(k)], in.data() + at, out.data() + at);
                for (std::size_t c = 0; c < n; ++c) out[at + c] = in[at + c] - out[at + c];
            }
        });
    };
    const auto mean_over_bases = [&](const std::vector<double>& y, std::vector<double>& mean) {
        mean.assign(n, 0.0);
        for (std::size_t k = 0; k < a; ++k)
            for (std::size_t c = 0; c < n; ++c) mean[c] += s.weights[active[k]] * y[k * n + c];
    };
    const auto product = [&](const std::vector<double>& y, const std::vector<double>& z) {
        double sum = 0.0;
        for (std::size_t k = 0; k < a; ++k) {
            double part = 0.0;
            for (std::size_t c = 0; c < n; ++c) part += s.p[c] * y[k * n + c] * z[k * n + c];
            sum += s.weights[active[k]] * part;
        }
        return sum;
    };
    std::vector<double> gamma(p_bar, p_bar + n);
    centre(gamma.data());
    std::vector<double> y(a * n), ly(a * n), r(a * n), d, mean;
    for (std::size_t k = 0; k < a; ++k) std::copy(gamma.begin(), gamma.end(), y.begin() + static_cast<long>(k * n));
    const auto project = [&](std::vector<double>& z) {  // onto sum_i alpha_i z_i = 0, each mean-free
        mean_over_bases(z, mean);
        for (std::size_t k = 0; k < a; ++k) {
            for (std::size_t c = 0; c < n; ++c) z[k * n + c] -= mean[c];
            centre(z.data() + k * n);
        }
    };
    laplacian(y, ly);
    std::vector<double> tau;
    if (a > 1) {
        for (std::size_t c = 0; c < a * n; ++c) r[c] = -ly[c];
        project(r);
        d = r;
        double rr = product(r, r);
        const double scale = product(ly, ly) + rr;
        const double target = std::max(1e-28, 1e-4 * settings.tolerance * settings.tolerance) * scale;
        int iteration = 0;
        std::vector<double> ld(a * n);
        double best = rr;
        int stalled = 0;
        while (rr > target) {
            if (++iteration > settings.max_iterations)
                fail(Status::NOT_CONVERGED, "barycentre pullback: relative residual %.3g after %d iterations",
                     std::sqrt(rr / scale), settings.max_iterations);
            laplacian(d, ld);
            project(ld);
            const double curvature = product(d, ld);
            if (!(curvature > 0)) break;
            const double step = rr / curvature;
            for (std::size_t c = 0; c < a * n; ++c) y[c] += step * d[c], r[c] -= step * ld[c];
            project(r);
            const double next = product(r, r);
            const double beta = next / rr;
            for (std::size_t c = 0; c < a * n; ++c) d[c] = r[c] + beta * d[c];
            rr = next;
            if (settings.monitor) settings.monitor(-iteration, std::sqrt(rr / scale));
            stalled = rr < 0.5 * best ? 0 : stalled + 1;
            best = std::min(best, rr);
            if (stalled > 200 && rr < 1e-16 * scale) break;  // rounding floor
        }
        laplacian(y, ly);
    }
    mean_over_bases(ly, tau);
    centre(tau.data());
    std::vector<double> bar(m, 0.0);
    double average = 0.0;
    for (std::size_t k = 0; k < m; ++k) {
        for (std::size_t c = 0; c < n; ++c) bar[k] += s.p[c] * tau[c] * s.log_d[k * n + c];
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
