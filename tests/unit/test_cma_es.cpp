// SPDX-License-Identifier: MIT
// CMA-ES on the usual test functions against an independent implementation, its invariances, and its state on disk.
#include <unistd.h>

#include <fstream>
#include <functional>
#include <iterator>
#include <limits>

#include "motion_fixtures.hpp"
#include "optimize/cma_es.hpp"
#include "optimize/normal.hpp"

namespace {

using namespace fixtures;
using Function = std::function<double(const double*)>;

constexpr int kN = 10;

double sphere(const double* x, int n) {
    double s = 0.0;
    for (int i = 0; i < n; ++i) s += x[i] * x[i];
    return s;
}
// Condition 1e6.
double ellipsoid(const double* x) {
    double s = 0.0;
    for (int i = 0; i < kN; ++i) s += std::pow(10.0, 6.0 * i / (kN - 1)) * x[i] * x[i];
    return s;
}
double rosenbrock(const double* x) {
    double s = 0.0;
    for (int i = 0; i + 1 < kN; ++i)
        s += 100 * (x[i + 1] - x[i] * x[i]) * (x[i + 1] - x[i] * x[i]) + (1 - x[i]) * (1 - x[i]);
    return s;
}
double rastrigin(const double* x, int n) {
    double s = 10.0 * n;
    for (int i = 0; i < n; ++i) s += x[i] * x[i] - 10 * std::cos(2 * 3.14159265358979323846 * x[i]);
    return s;
}

// Rows of an orthogonal matrix [n][n].
Vector rotation(std::size_t n, std::uint64_t seed) {
    Random random{seed};
    Vector q = random_vector(n * n, random);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            double d = 0.0;
            for (std::size_t j = 0; j < n; ++j) d += q[i * n + j] * q[k * n + j];
            for (std::size_t j = 0; j < n; ++j) q[i * n + j] -= d * q[k * n + j];
        }
        double length = 0.0;
        for (std::size_t j = 0; j < n; ++j) length += q[i * n + j] * q[i * n + j];
        for (std::size_t j = 0; j < n; ++j) q[i * n + j] /= std::sqrt(length);
    }
    return q;
}
Vector times(const Vector& q, const double* x) {
    std::size_t n = 0;
    while (n * n < q.size()) ++n;
    Vector y(n, 0.0);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) y[i] += q[i * n + j] * x[j];
    return y;
}

// One generation; the lowest value of it.
double advance(CmaEs& es, const Function& f) {
    const auto lambda = static_cast<std::size_t>(es.population()), n = static_cast<std::size_t>(es.n());
    Vector x(lambda * n), values(lambda);
    es.ask(x.data());
    for (std::size_t k = 0; k < lambda; ++k) values[k] = f(x.data() + k * n);
    es.tell(values.data());
    return *std::min_element(values.begin(), values.end());
}

// Evaluations until a candidate is at most 1e-9; 0: not within `most`.
double evaluations(const Function& f, const Vector& start, double sigma, std::uint64_t seed, int population = 0,
                   double most = 40000) {
    CmaEsSettings s;
    s.n = static_cast<int>(start.size()), s.sigma = sigma, s.seed = seed, s.population = population;
    CmaEs es(s, start.data(), Vector(start.size(), 1.0).data());
    while (static_cast<double>(es.generation() * es.population()) < most) {
        advance(es, f);
        if (es.best_value() <= 1e-9) return static_cast<double>(es.generation() * es.population());
        if (es.sigma() < 1e-12) break;
    }
    return 0.0;
}

struct Record {
    int runs = 0, successes = 0;
    double median = 0;
};
Record record(const Function& f, const Vector& start, double sigma, int population = 0, int runs = 21) {
    Vector counts;
    for (int k = 1; k <= runs; ++k) {
        const double n = evaluations(f, start, sigma, static_cast<std::uint64_t>(k), population);
        if (n > 0) counts.push_back(n);
    }
    Record r;
    r.runs = runs, r.successes = static_cast<int>(counts.size());
    std::sort(counts.begin(), counts.end());
    if (!counts.empty()) r.median = counts[counts.size() / 2];
    return r;
}

// The median must be as that of pycma 4.5.0 (N. Hansen's own implementation; github.com/CMA-ES/pycma) from the same
// start over 21 or 100 seeds; its deciles are about 8 % away from the median.
void near_pycma(const char* name, const Record& r, int successes, double median) {
    print_message("%s: %d of %d, median of evaluations to 1e-9 %.0f (pycma %.0f)\n", name, r.successes, r.runs,
                  r.median, median);
    CHECK(r.successes >= successes);
    CHECK(r.median > 0.88 * median && r.median < 1.12 * median);
}

void test_evaluations_are_as_published() {
    near_pycma("sphere", record([](const double* x) { return sphere(x, kN); }, Vector(kN, 1.0), 0.5), 21, 1473);
    near_pycma("ellipsoid", record(ellipsoid, Vector(kN, 1.0), 0.5), 21, 4075);
    const Vector q = rotation(kN, 5);
    near_pycma("rotated ellipsoid",
               record([&](const double* x) { return ellipsoid(times(q, x).data()); }, Vector(kN, 1.0), 0.5), 21, 4027);
    // Some runs end in its second minimum: 2 of 21 there.
    near_pycma("Rosenbrock", record(rosenbrock, Vector(kN, 0.0), 0.5), 16, 5317);
}

// With the default population all runs end in some of its many minima; of 100 runs of pycma 61 find the lowest with a
// population of 100 and 87 with 200, counts with a standard error of 4 and more.
void test_rastrigin_wants_a_larger_population() {
    const Function f = [](const double* x) { return rastrigin(x, 5); };
    CHECK(record(f, Vector(5, 2.0), 2.0).successes <= 3);
    near_pycma("Rastrigin in 5-D, population 100", record(f, Vector(5, 2.0), 2.0, 100, 100), 40, 6408);
    near_pycma("Rastrigin in 5-D, population 200", record(f, Vector(5, 2.0), 2.0, 200, 100), 65, 9469);
}

// ---------------------------------------------------------------- invariance

// Of the samples' own making: the best value over generations does not care about rotations (the statistics, as the
// numbers drawn are along the axes), about shifts and increasing functions of f (to the bit where rounding allows).
void test_rotation_leaves_the_statistics() {
    const Vector q = rotation(kN, 11);
    const auto traces = [&](const Function& f) {
        Vector mean(61, 0.0);
        for (std::uint64_t seed = 1; seed <= 31; ++seed) {
            CmaEsSettings s;
            s.n = kN, s.seed = seed, s.sigma = 0.5;
            // The start must turn with the function; the one along the diagonal is turned in the function itself.
            CmaEs es(s, Vector(kN, 0.0).data(), Vector(kN, 1.0).data());
            for (int g = 0; g <= 360; ++g) {
                advance(es, f);
                if (g % 6 == 0) mean[static_cast<std::size_t>(g / 6)] += std::log10(es.best_value()) / 31;
            }
        }
        return mean;
    };
    const Vector centre(kN, 1.0);
    const auto shifted = [&](const double* x) { return plus(Vector(x, x + kN), -1.0, centre); };
    const Vector straight = traces([&](const double* x) { return ellipsoid(shifted(x).data()); });
    const Vector turned = traces([&](const double* x) {
        Vector y = times(q, x);  // the minimum of the turned function lies at Q^T centre
        return ellipsoid(shifted(y.data()).data());
    });
    double worst = 0;
    for (std::size_t k = 0; k < straight.size(); ++k) worst = std::max(worst, std::abs(straight[k] - turned[k]));
    print_message("rotated ellipsoid: mean of log10 f falls from %.2f to %.2f, at most %.2f from the one not rotated\n",
                  turned.front(), turned.back(), worst);
    CHECK(straight.back() < straight.front() - 8);
    CHECK(worst < 0.6);  // the standard error of the difference of two means is about 0.2 where the fall is steepest
}

void test_order_alone_counts() {
    const Function f = [](const double* x) { return sphere(x, kN); };
    const Function increasing = [](const double* x) { return std::cbrt(sphere(x, kN)) - 7.0; };
    CmaEsSettings s;
    s.n = kN;
    CmaEs a(s, Vector(kN, 2.0).data(), Vector(kN, 1.0).data()), b(s, Vector(kN, 2.0).data(), Vector(kN, 1.0).data());
    for (int g = 0; g < 60; ++g) advance(a, f), advance(b, increasing);
    CHECK(a.mean() == b.mean());
    CHECK(a.sigma() == b.sigma());
}

// Powers of two: nothing is rounded on the way.
void test_scales_are_units() {
    const Vector scales = {0.25, 8, 1, 2, 1024, 0.5, 4, 1, 1, 2};
    CmaEsSettings s;
    s.n = kN;
    CmaEs plain(s, Vector(kN, 1.0).data(), Vector(kN, 1.0).data()), scaled(s, scales.data(), scales.data());
    for (int g = 0; g < 40; ++g) {
        advance(plain, ellipsoid);
        advance(scaled, [&](const double* x) {
            Vector y(x, x + kN);
            for (std::size_t i = 0; i < y.size(); ++i) y[i] /= scales[i];
            return ellipsoid(y.data());
        });
    }
    for (std::size_t i = 0; i < scales.size(); ++i) NEAR(scaled.mean()[i], scales[i] * plain.mean()[i], 0.0);
    NEAR(scaled.best_value(), plain.best_value(), 0.0);
}

// The distribution learns the inverse of the Hessian.
void test_covariance_is_the_inverse_hessian() {
    CmaEsSettings s;
    s.n = kN;
    CmaEs es(s, Vector(kN, 1.0).data(), Vector(kN, 1.0).data());
    for (int g = 0; g < 600; ++g) advance(es, ellipsoid);
    CHECK(es.axis_ratio() > 500 && es.axis_ratio() < 2000);  // the square root of 1e6
}

// ---------------------------------------------------------------- limits

void test_values_that_could_not_be_had() {
    // Half of space cannot be evaluated; the minimum of the rest lies on its edge.
    const Function f = [](const double* x) {
        return x[0] < 0.5 ? std::numeric_limits<double>::infinity() : sphere(x, 3);
    };
    CmaEsSettings s;
    s.n = 3;
    CmaEs es(s, Vector(3, 2.0).data(), Vector(3, 1.0).data());
    for (int g = 0; g < 300; ++g) advance(es, f);
    NEAR(es.best_value(), 0.25, 1e-3);
    // Nothing at all can be: no best, no NaN.
    CmaEs none(s, Vector(3, 2.0).data(), Vector(3, 1.0).data());
    for (int g = 0; g < 50; ++g) advance(none, [](const double*) { return std::numeric_limits<double>::infinity(); });
    CHECK(none.best().empty() && all_finite(none.mean()) && std::isfinite(none.sigma()));
}

void test_unbounded_functions_are_reported() {
    CmaEsSettings s;
    s.n = 2;
    CmaEs es(s, Vector(2, 0.0).data(), Vector(2, 1.0).data());
    bool reported = false;
    for (int g = 0; g < 100000 && !reported; ++g) {
        try {
            advance(es, [](const double* x) { return std::max(x[0], -1e300); });
        } catch (const Error& e) {
            reported = e.status() == Status::DIVERGED;
        }
    }
    CHECK(reported);
}

void test_small_sizes() {
    for (const int n : {1, 2, 3})
        for (const int population : {2, 3, 4, 5}) {
            CmaEsSettings s;
            s.n = n, s.population = population;
            CmaEs es(s, Vector(3, 1.0).data(), Vector(3, 1.0).data());
            for (int g = 0; g < 2000; ++g) advance(es, [n](const double* x) { return sphere(x, n); });
            CHECK(std::isfinite(es.sigma()) && all_finite(es.mean()));
            // Two candidates are too few for a direction, but never lead up.
            CHECK(es.best_value() < (population > 3 ? 1e-9 : 1.0 * n));
        }
    CmaEsSettings s;
    s.n = 4;
    CmaEs es(s, Vector(4, 1.0).data(), Vector(4, 1.0).data());
    CHECK(es.population() == 8);  // 4 + floor(3 ln 4)
    EXPECT_ERROR(ERROR_STATE, "asked", es.tell(Vector(8, 0.0).data()));
}

// ---------------------------------------------------------------- numbers and files

void test_logarithm() {
    Random random{3};
    for (int k = 0; k < 20000; ++k) {
        const double x = std::exp(40 * random());
        const double exact = std::log(x);
        NEAR(portable_log(x), exact, 4e-16 * std::max(1.0, std::abs(exact)));
    }
    NEAR(portable_log(1.0), 0.0, 0.0);
    NEAR(portable_log(1.0 - 1e-9), std::log(1.0 - 1e-9), 1e-24);
}

void test_normal_numbers() {
    Random random{1};
    NormalNumbers normal(random);
    const int n = 400000;
    double moment[5] = {};
    int inside = 0;
    for (int k = 0; k < n; ++k) {
        const double z = normal();
        for (int p = 1; p <= 4; ++p) moment[p] += std::pow(z, p) / n;
        inside += std::abs(z) < 1.0;
    }
    // Within five standard errors.
    NEAR(moment[1], 0.0, 5 * std::sqrt(1.0 / n));
    NEAR(moment[2], 1.0, 5 * std::sqrt(2.0 / n));
    NEAR(moment[3], 0.0, 5 * std::sqrt(15.0 / n));
    NEAR(moment[4], 3.0, 5 * std::sqrt(96.0 / n));
    NEAR(static_cast<double>(inside) / n, 0.682689, 5 * std::sqrt(0.217 / n));
}

std::string content(const char* path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void test_a_saved_search_goes_on_with_the_same_bits() {
    const char* path = "search.dqa";
    CmaEsSettings s;
    s.n = kN, s.seed = 9;
    CmaEs whole(s, Vector(kN, 1.0).data(), Vector(kN, 1.0).data());
    CmaEs cut(s, Vector(kN, 1.0).data(), Vector(kN, 1.0).data());
    for (int g = 0; g < 35; ++g) advance(whole, rosenbrock), advance(cut, rosenbrock);
    // In the middle of a generation: the candidates come again.
    Vector asked(static_cast<std::size_t>(kN * cut.population())), again(asked);
    cut.ask(asked.data());
    cut.ask(again.data());
    CHECK(asked == again);
    cut.save(path);
    std::unique_ptr<CmaEs> resumed = CmaEs::load(path);
    EXPECT_ERROR(ERROR_STATE, "asked", resumed->tell(asked.data()));
    resumed->ask(again.data());
    CHECK(asked == again);
    for (int g = 0; g < 100; ++g) {
        const double a = advance(whole, rosenbrock), b = advance(*resumed, rosenbrock);
        CHECK(a == b);
    }
    CHECK(whole.mean() == resumed->mean() && whole.best() == resumed->best() && whole.sigma() == resumed->sigma());

    // Every flipped byte and every cut is found.
    const std::string good = content(path);
    for (std::size_t k = 0; k < good.size(); k += 97) {
        std::string bad = good;
        bad[k] = static_cast<char>(bad[k] ^ 0x10);
        std::ofstream("bad.dqa", std::ios::binary) << bad;
        EXPECT_ERROR(ERROR_FILE, "bad.dqa", (void)CmaEs::load("bad.dqa"));
        std::ofstream("bad.dqa", std::ios::binary) << good.substr(0, k);
        EXPECT_ERROR(ERROR_FILE, "bad.dqa", (void)CmaEs::load("bad.dqa"));
    }
    ::unlink(path);
    ::unlink("bad.dqa");
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_evaluations_are_as_published),
        TEST(test_rastrigin_wants_a_larger_population),
        TEST(test_rotation_leaves_the_statistics),
        TEST(test_order_alone_counts),
        TEST(test_scales_are_units),
        TEST(test_covariance_is_the_inverse_hessian),
        TEST(test_values_that_could_not_be_had),
        TEST(test_unbounded_functions_are_reported),
        TEST(test_small_sizes),
        TEST(test_logarithm),
        TEST(test_normal_numbers),
        TEST(test_a_saved_search_goes_on_with_the_same_bits),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
