// SPDX-License-Identifier: MIT
// Numbers of equations and of table 1 are those of the tutorial.
#include "optimize/cma_es.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <limits>
#include <numeric>

#include "grid/error.hpp"
#include "grid/sealed_file.hpp"
#include "grid/symmetric_eigen.hpp"
#include "optimize/normal.hpp"

namespace dqa {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using MatrixView = Eigen::Map<Matrix>;
using ConstMatrixView = Eigen::Map<const Matrix>;
using VectorView = Eigen::Map<Vector>;
using ConstVectorView = Eigen::Map<const Vector>;

constexpr char kMagic[8] = {'D', 'Q', 'A', 'C', 'M', 'A', 'E', 'S'};
constexpr std::uint32_t kVersion = 1;

std::size_t sized(std::int64_t n) {
    return static_cast<std::size_t>(n);
}

}  // namespace

int CmaEs::default_population(int n) {
    return 4 + static_cast<int>(std::floor(3.0 * std::log(static_cast<double>(n))));
}

// Table 1.
void CmaEs::set_constants() {
    const double n = settings_.n;
    const int lambda = settings_.population;
    mu_ = lambda / 2;
    weights_.resize(sized(lambda));
    double positive = 0, positive2 = 0, negative = 0, negative2 = 0;
    for (int i = 0; i < lambda; ++i) {
        const double w = std::log(0.5 * (lambda + 1)) - std::log(i + 1.0);  // eq. 49
        weights_[sized(i)] = w;
        (i < mu_ ? positive : negative) += std::abs(w);
        (i < mu_ ? positive2 : negative2) += w * w;
    }
    mu_eff_ = positive * positive / positive2;
    const double mu_eff_negative = negative2 > 0 ? negative * negative / negative2 : 0.0;
    c_c_ = (4 + mu_eff_ / n) / (n + 4 + 2 * mu_eff_ / n);                                                // eq. 56
    c_1_ = 2 / ((n + 1.3) * (n + 1.3) + mu_eff_);                                                        // eq. 57
    c_mu_ = std::min(1 - c_1_, 2 * (0.25 + mu_eff_ + 1 / mu_eff_ - 2) / ((n + 2) * (n + 2) + mu_eff_));  // eq. 58
    c_sigma_ = (mu_eff_ + 2) / (n + mu_eff_ + 5);                                                        // eq. 55
    d_sigma_ = 1 + 2 * std::max(0.0, std::sqrt((mu_eff_ - 1) / (n + 1)) - 1) + c_sigma_;
    norm_ = std::sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n));  // of a standard normal vector
    // Eqs. 50 to 53: the negative weights are as large as keeps C positive definite.
    const double alpha =
        c_mu_ > 0
            ? std::min({1 + c_1_ / c_mu_, 1 + 2 * mu_eff_negative / (mu_eff_ + 2), (1 - c_1_ - c_mu_) / (n * c_mu_)})
            : 0.0;
    for (int i = 0; i < lambda; ++i)
        weights_[sized(i)] *= i < mu_ ? 1 / positive : negative > 0 ? std::max(0.0, alpha) / negative : 0.0;
    // B.2: as seldom as keeps the cost of a generation at O(n^2) a candidate.
    decomposition_interval_ = std::max<std::int64_t>(1, static_cast<std::int64_t>(1 / (10 * n * (c_1_ + c_mu_))));
}

CmaEs::CmaEs(const CmaEsSettings& settings)
    : settings_(settings), best_value_(std::numeric_limits<double>::infinity()) {
    if (settings_.population == 0) settings_.population = default_population(settings_.n);
    const std::size_t n = sized(settings_.n);
    set_constants();
    scales_.resize(n), mean_scaled_.resize(n), mean_.resize(n), lengths_.assign(n, 1.0);
    covariance_.assign(n * n, 0.0);
    for (std::size_t i = 0; i < n; ++i) covariance_[i * n + i] = 1.0;
    axes_ = covariance_;
    path_sigma_.assign(n, 0.0), path_c_.assign(n, 0.0);
    steps_.resize(sized(settings_.population) * n);
}

CmaEs::CmaEs(const CmaEsSettings& settings, const double* mean, const double* scales) : CmaEs(settings) {
    scales_.assign(scales, scales + settings.n);
    mean_.assign(mean, mean + settings.n);
    for (std::size_t i = 0; i < mean_.size(); ++i) mean_scaled_[i] = mean_[i] / scales_[i];
    sigma_ = settings.sigma;
    random_.state = settings.seed;
}

void CmaEs::ask(double* candidates) {
    const std::size_t n = sized(settings_.n);
    random_next_ = random_;
    NormalNumbers normal(random_next_);
    std::vector<double> z(n);
    const ConstMatrixView axes(axes_.data(), settings_.n, settings_.n);
    bool finite = true;
    for (std::size_t k = 0; k < sized(settings_.population); ++k) {
        for (std::size_t i = 0; i < n; ++i) z[i] = lengths_[i] * normal();
        VectorView y(steps_.data() + k * n, settings_.n);
        y = axes * ConstVectorView(z.data(), settings_.n);
        for (std::size_t i = 0; i < n; ++i) {
            candidates[k * n + i] = scales_[i] * (mean_scaled_[i] + sigma_ * steps_[k * n + i]);
            finite = finite && std::isfinite(candidates[k * n + i]);
        }
    }
    if (!finite)
        fail(Status::DIVERGED,
             "generation %lld: the step size has grown to %g and the candidates are not finite; is the "
             "function bounded below?",
             static_cast<long long>(generation_ + 1), sigma_);
    asked_ = true;
}

void CmaEs::whiten(const double* y, double* out) const {
    const ConstMatrixView axes(axes_.data(), settings_.n, settings_.n);
    Vector z = axes.transpose() * ConstVectorView(y, settings_.n);
    for (int i = 0; i < settings_.n; ++i) z[i] /= lengths_[sized(i)];
    VectorView(out, settings_.n) = axes * z;
}

void CmaEs::tell(const double* values) {
    if (!asked_)
        fail(Status::ERROR_STATE, "generation %lld: no candidates were asked for",
             static_cast<long long>(generation_ + 1));
    const int count = settings_.n;
    const std::size_t n = sized(count), lambda = sized(settings_.population);
    std::vector<std::size_t> order(lambda);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
    if (values[order[0]] < best_value_) {
        best_value_ = values[order[0]];
        best_.resize(n);
        for (std::size_t i = 0; i < n; ++i)
            best_[i] = scales_[i] * (mean_scaled_[i] + sigma_ * steps_[order[0] * n + i]);
    }

    Vector step = Vector::Zero(count);  // eq. 41
    for (std::size_t k = 0; k < sized(mu_); ++k)
        step += weights_[k] * ConstVectorView(steps_.data() + order[k] * n, count);
    for (std::size_t i = 0; i < n; ++i) {
        mean_scaled_[i] += sigma_ * step[static_cast<int>(i)];  // eq. 42
        mean_[i] = scales_[i] * mean_scaled_[i];
    }

    // Step size, eqs. 43 and 44.
    VectorView path_sigma(path_sigma_.data(), count), path_c(path_c_.data(), count);
    Vector white(count);
    whiten(step.data(), white.data());
    path_sigma = (1 - c_sigma_) * path_sigma + std::sqrt(c_sigma_ * (2 - c_sigma_) * mu_eff_) * white;
    const double length = path_sigma.norm();
    const double settled = 1 - std::pow(1 - c_sigma_, 2.0 * static_cast<double>(generation_ + 1));
    // The path of C stalls while the step size grows fast.
    const double h = length / std::sqrt(settled) < (1.4 + 2.0 / (count + 1)) * norm_ ? 1.0 : 0.0;
    sigma_ *= std::exp(c_sigma_ / d_sigma_ * (length / norm_ - 1));

    // Covariance, eqs. 45 to 47.
    path_c = (1 - c_c_) * path_c + h * std::sqrt(c_c_ * (2 - c_c_) * mu_eff_) * step;
    MatrixView c(covariance_.data(), count, count);
    const double sum = std::accumulate(weights_.begin(), weights_.end(), 0.0);
    c *= 1 + c_1_ * (1 - h) * c_c_ * (2 - c_c_) - c_1_ - c_mu_ * sum;
    c += c_1_ * path_c * path_c.transpose();
    for (std::size_t k = 0; k < lambda; ++k) {
        const ConstVectorView y(steps_.data() + order[k] * n, count);
        double w = weights_[k];
        if (w < 0) {
            whiten(y.data(), white.data());
            w *= count / std::max(white.squaredNorm(), std::numeric_limits<double>::min());
        }
        c += c_mu_ * w * y * y.transpose();
    }

    ++generation_;
    random_ = random_next_;
    asked_ = false;
    if (generation_ - decomposed_ >= decomposition_interval_) decompose();
}

void CmaEs::decompose() {
    MatrixView c(covariance_.data(), settings_.n, settings_.n);
    c = (0.5 * (c + c.transpose())).eval();
    const SymmetricEigen eigen = symmetric_eigen(c);
    const Vector& values = eigen.values;
    const double most = values.maxCoeff();
    if (!eigen.good || !std::isfinite(most) || !(most > 0))
        fail(Status::DIVERGED, "generation %lld: the covariance is not a finite positive matrix any more",
             static_cast<long long>(generation_));
    MatrixView(axes_.data(), settings_.n, settings_.n) = eigen.vectors;
    // Rounding alone can bring one to zero; C itself follows as it is adapted.
    for (int i = 0; i < settings_.n; ++i) lengths_[sized(i)] = std::sqrt(std::max(values[i], 1e-28 * most));
    decomposed_ = generation_;
}

double CmaEs::axis_ratio() const {
    const auto [least, most] = std::minmax_element(lengths_.begin(), lengths_.end());
    return *most / *least;
}

double CmaEs::widest() const {
    double most = 0;
    const std::size_t n = sized(settings_.n);
    for (std::size_t i = 0; i < n; ++i) most = std::max(most, covariance_[i * n + i]);
    return sigma_ * std::sqrt(most);
}

// ------------------------------------------------------------------ file
void CmaEs::save(const std::string& path) const {
    SealedWriter w(kMagic, kVersion);
    w.integer(settings_.n), w.integer(settings_.population);
    w.put(settings_.seed), w.put(settings_.sigma);
    w.put(generation_), w.put(decomposed_), w.put(random_.state), w.put(sigma_), w.put(best_value_);
    w.integer(best_.empty() ? 0 : 1);
    for (const auto* v :
         {&scales_, &mean_scaled_, &mean_, &covariance_, &axes_, &lengths_, &path_sigma_, &path_c_, &best_})
        w.doubles(v->data(), v->size());
    w.save(path);
}

std::unique_ptr<CmaEs> CmaEs::load(const std::string& path) {
    SealedReader r(path, kMagic, kVersion, "a saved evolution strategy");
    CmaEsSettings s;
    s.n = r.integer("the number of unknowns", 1, most_unknowns);
    s.population = r.integer("the population", 2, 1 << 20);
    r.expect(std::int64_t{s.n} * s.population <= most_numbers, "the population", s.population);
    s.seed = r.get<std::uint64_t>();
    s.sigma = r.positive("sigma");
    const auto generation = r.get<std::int64_t>(), decomposed = r.get<std::int64_t>();
    r.expect(generation >= 0, "the generation", static_cast<double>(generation));
    r.expect(decomposed >= 0 && decomposed <= generation, "the generation of the axes",
             static_cast<double>(decomposed));
    const auto random = r.get<std::uint64_t>();
    const double sigma = r.get<double>();
    r.expect(std::isfinite(sigma) && sigma >= 0, "the step size", sigma);
    const double best_value = r.get<double>();
    r.expect(!std::isnan(best_value), "the best value", best_value);
    const bool has_best = r.integer("whether there is a best candidate", 0, 1) == 1;
    const std::size_t n = sized(s.n);
    r.need((2 * n * n + (has_best ? 7 : 6) * n) * sizeof(double));  // before memory is asked for
    std::unique_ptr<CmaEs> e(new CmaEs(s));
    e->generation_ = generation, e->decomposed_ = decomposed;
    e->random_.state = random, e->sigma_ = sigma, e->best_value_ = best_value;
    if (has_best) e->best_.resize(n);
    for (auto* v : {&e->scales_, &e->mean_scaled_, &e->mean_, &e->covariance_, &e->axes_, &e->lengths_, &e->path_sigma_,
                    &e->path_c_, &e->best_}) {
        r.doubles(v->data(), v->size());
        for (const double x : *v) r.expect(std::isfinite(x), "a number of the state", x);
    }
    for (const double x : e->scales_) r.expect(x > 0, "a scale", x);
    for (const double x : e->lengths_) r.expect(x > 0, "the length of an axis", x);
    r.expect(r.left() == 0, "the number of bytes behind the state", static_cast<double>(r.left()));
    return e;
}

}  // namespace dqa
