// SPDX-License-Identifier: MIT
// The separable Gaussian kernel against the sum over all pairs of cells, its logarithmic form, and its mean.
#include <limits>
#include <utility>

#include "derivative_checks.hpp"
#include "shape/gaussian_kernel.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Random;

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr std::array<int, 3> cells{5, 7, 6};  // three lengths, so that mixed-up axes show
constexpr double sigma = 0.9;

double log_kernel(const Box& box, int a, int b, double width) {
    const auto i = box.cell_ijk(a), j = box.cell_ijk(b);
    double r2 = 0;
    for (std::size_t k = 0; k < 3; ++k) r2 += (i[k] - j[k]) * (i[k] - j[k]);
    return -r2 / (2 * width * width);
}

std::vector<double> brute_force(const Box& box, const std::vector<double>& in) {
    std::vector<double> out(in.size(), 0.0);
    for (int a = 0; a < box.n_cells(); ++a)
        for (int b = 0; b < box.n_cells(); ++b)
            out[static_cast<std::size_t>(a)] +=
                std::exp(log_kernel(box, a, b, sigma)) * in[static_cast<std::size_t>(b)];
    return out;
}

std::vector<double> logs(const std::vector<double>& v) {
    std::vector<double> out;
    for (const double x : v) out.push_back(std::log(x));
    return out;
}

std::vector<double> applied(const GaussianKernel& kernel, const std::vector<double>& in) {
    std::vector<double> out(in.size()), scratch(in.size());
    kernel.apply(in.data(), out.data(), scratch.data());
    return out;
}

std::vector<double> applied_log(const GaussianKernel& kernel, const std::vector<double>& in) {
    std::vector<double> out(in.size());
    kernel.apply_log(in.data(), out.data(), nullptr);
    return out;
}

void test_brute_force() {
    const Box box{cells, 1.0};
    const GaussianKernel kernel(cells, sigma);
    CHECK(kernel.size() == box.n_cells());
    Random random(3);
    const auto in = random.vector(static_cast<std::size_t>(box.n_cells()), 0.0, 1.0);
    const auto expected = brute_force(box, in), out = applied(kernel, in);
    for (std::size_t c = 0; c < in.size(); ++c) NEAR(out[c] / expected[c], 1, 1e-14);
    // In place.
    std::vector<double> same = in, scratch(in.size());
    kernel.apply(same.data(), same.data(), scratch.data());
    CHECK(same == out);
    // One cell gives the kernel itself.
    std::vector<double> one(in.size(), 0.0);
    one[static_cast<std::size_t>(box.cell(2, 5, 1))] = 1;
    const auto k = applied(kernel, one);
    NEAR(k[static_cast<std::size_t>(box.cell(3, 3, 2))], std::exp(-6 / (2 * sigma * sigma)), 1e-16);
}

void test_symmetric() {
    const GaussianKernel kernel(cells, sigma);
    Random random(4);
    const auto n = static_cast<std::size_t>(kernel.size());
    const auto a = random.vector(n), b = random.vector(n);
    const double left = derivative::dot(a, applied(kernel, b)), right = derivative::dot(applied(kernel, a), b);
    CHECK(std::fabs(left) > 0.1);
    NEAR(left / right, 1, 1e-12);
}

void test_logarithmic_agrees() {
    const GaussianKernel kernel(cells, sigma);
    Random random(5);
    auto in = random.vector(static_cast<std::size_t>(kernel.size()), 0.0, 1.0);
    for (std::size_t c = 0; c < in.size(); c += 3) in[c] = 0;                            // log is -infinity
    for (std::size_t c = 1; c < in.size(); c += 3) in[c] *= std::pow(10.0, -double(c));  // over 200 decades
    const auto linear = applied(kernel, in), logarithmic = applied_log(kernel, logs(in));
    for (std::size_t c = 0; c < in.size(); ++c) NEAR(logarithmic[c], std::log(linear[c]), 1e-13);
}

void test_logarithmic_reaches_far() {
    const std::array<int, 3> line{100, 2, 1};
    const Box box{line, 1.0};
    const GaussianKernel kernel(line, 1.0);
    std::vector<double> in(200, 0.0);
    in[static_cast<std::size_t>(box.cell(0, 0, 0))] = 1;
    const auto linear = applied(kernel, in), logarithmic = applied_log(kernel, logs(in));
    NEAR(linear[static_cast<std::size_t>(box.cell(60, 0, 0))], 0, 0);  // exp(-1800) is not a double
    for (int i = 0; i < 100; ++i) {
        NEAR(logarithmic[static_cast<std::size_t>(box.cell(i, 0, 0))], -0.5 * i * i, 1e-12);
        NEAR(logarithmic[static_cast<std::size_t>(box.cell(i, 1, 0))], -0.5 * (i * i + 1), 1e-12);
    }
    // Nothing in: nothing out, and not a NaN.
    for (const double v : applied_log(kernel, std::vector<double>(200, -inf))) CHECK(v == -inf);
}

void test_mean() {
    const Box box{cells, 1.0};
    const GaussianKernel kernel(cells, sigma);
    Random random(6);
    auto in = random.vector(static_cast<std::size_t>(box.n_cells()), 0.0, 1.0);
    for (std::size_t c = 0; c < in.size(); c += 4) in[c] = 0;
    const auto value = random.vector(in.size());
    std::vector<double> product(in.size());
    for (std::size_t c = 0; c < in.size(); ++c) product[c] = in[c] * value[c];
    const auto upper = brute_force(box, product), lower = brute_force(box, in);
    std::vector<double> mean = value, log_out(in.size());
    kernel.apply_log(logs(in).data(), log_out.data(), mean.data());
    for (std::size_t c = 0; c < in.size(); ++c) {
        NEAR(mean[c], upper[c] / lower[c], 1e-13);
        NEAR(log_out[c], std::log(lower[c]), 1e-13);
    }
}

void test_mean_far_away() {
    // Between sources 40 and 60 cells away the nearer one counts alone; half way between two, both the same.
    const std::array<int, 3> line{101, 1, 1};
    const GaussianKernel kernel(line, 1.0);
    std::vector<double> log_in(101, -inf), value(101, 9.0), log_out(101);
    log_in[0] = log_in[100] = 0;
    value[0] = -3, value[100] = 5;
    kernel.apply_log(log_in.data(), log_out.data(), value.data());
    NEAR(value[40], -3, 1e-14);
    NEAR(value[60], 5, 1e-14);
    NEAR(value[50], 1, 1e-14);
    NEAR(log_out[50], std::log(2.0) - 1250, 1e-12);
}

struct LogSum {
    double log, mean;
};

// Of n terms exp(first) and the values second, scaled by the largest of them.
template <class F>
LogSum log_sum(int n, F&& term) {
    double largest = -inf, sum = 0, weighted = 0;
    for (int k = 0; k < n; ++k) largest = std::max(largest, term(k).first);
    for (int k = 0; k < n; ++k) {
        const auto [e, value] = term(k);
        if (e > -inf) sum += std::exp(e - largest), weighted += std::exp(e - largest) * value;
    }
    return {largest + std::log(sum), weighted / sum};
}

// Logarithms that lie hundreds apart from cell to cell, with holes, on more lines than one pass holds: against the sum
// over all pairs, each scaled by its largest term. By every instruction set, and one thread or three.
void test_rugged() {
    constexpr std::array<int, 3> rugged{23, 5, 13};
    const Box box{rugged, 1.0};
    Random random(8);
    const std::size_t n = static_cast<std::size_t>(box.n_cells());
    const auto value = random.vector(n), holes = random.vector(n, 0.0, 1.0);
    for (const double width : {0.5, 4.0}) {
        auto in = random.vector(n, -700.0, 700.0);
        for (std::size_t c = 0; c < n; ++c)
            if (holes[c] < 0.4 || c % 13 < 3) in[c] = -inf;
        const GaussianKernel kernel(rugged, width);
        std::vector<double> out(n), mean = value, again(n), mean_again = value;
        kernel.apply_log(in.data(), out.data(), mean.data());
        kernel.apply_log(in.data(), again.data(), mean_again.data(), 3);
        for (int a = 0; a < box.n_cells(); ++a) {
            const std::size_t c = static_cast<std::size_t>(a);
            const LogSum exact = log_sum(box.n_cells(), [&](int b) {
                const std::size_t d = static_cast<std::size_t>(b);
                return std::pair(in[d] + log_kernel(box, a, b, width), value[d]);
            });
            NEAR(out[c], exact.log, 1e-11);
            NEAR(mean[c], exact.mean, 1e-11);
            CHECK(again[c] == out[c] && mean_again[c] == mean[c]);
        }
    }
}

void test_instruction_sets() {
    constexpr int n = 29, lines = 11;  // as one box of [n][lines]: a pass that is not full
    Random random(9);
    auto in = random.vector(n * lines, -300.0, 300.0);
    const auto value = random.vector(n * lines);
    for (std::size_t c = 0; c < in.size(); c += 3) in[c] = -inf;
    for (std::size_t j = 0; j < n; ++j) in[j * lines + 4] = -inf;  // a line without anything
    std::vector<double> cost, scratch(4 * n * kLogLines);
    for (int k = 1 - n; k < n; ++k) cost.push_back(0.5 * k * k);
    for (const auto set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
        std::vector<double> out(in.size()), mean = value;
        barycenter_kernels(set).log_lines(cost.data() + n - 1, n, lines, in.data(), out.data(), mean.data(), 0, lines,
                                          scratch.data());
        for (std::size_t l = 0; l < lines; ++l)
            for (int i = 0; i < n; ++i) {
                const std::size_t at = static_cast<std::size_t>(i) * lines + l;
                if (l == 4) {
                    CHECK(out[at] == -inf && mean[at] == 0);
                    continue;
                }
                const LogSum exact = log_sum(n, [&](int j) {
                    const std::size_t from = static_cast<std::size_t>(j) * lines + l;
                    return std::pair(in[from] - 0.5 * (i - j) * (i - j), value[from]);
                });
                NEAR(out[at], exact.log, 1e-12);
                NEAR(mean[at], exact.mean, 1e-12);
            }
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_brute_force),
        TEST(test_symmetric),
        TEST(test_logarithmic_agrees),
        TEST(test_logarithmic_reaches_far),
        TEST(test_mean),
        TEST(test_mean_far_away),
        TEST(test_rugged),
        TEST(test_instruction_sets),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
