// SPDX-License-Identifier: MIT
// The kernels of the barycentre for every instruction set: exp and log against long double, the half-iterations and
// their Jacobian against the dense kernel, and the coarse correction.
#include <limits>

#include "density_fixtures.hpp"
#include "derivative_checks.hpp"
#include "shape/coarse_correction.hpp"
#include "shape/transport.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Random;
using derivative::Vector;

const Cells cells{19, 9, 11};
const Densities& bodies() {
    static const Densities bases{normalised(soft_ellipsoid(cells, {8.6, 4.0, 5.0}, {5.2, 2.5, 2.9})),
                                 normalised(soft_ellipsoid(cells, {10.5, 4.3, 6.4}, {3.5, 3.3, 1.8}))};
    return bases;
}

double ulps(double got, long double exact) {
    const double rounded = static_cast<double>(exact);
    const double unit =
        std::nextafter(std::fabs(rounded), std::numeric_limits<double>::infinity()) - std::fabs(rounded);
    return static_cast<double>(std::fabs(static_cast<long double>(got) - exact) / static_cast<long double>(unit));
}

void test_exp_and_log() {
    Random random(21);
    Vector x = random.vector(20001, -700, 700), y = random.vector(20001, -1, 1);
    x.insert(x.end(), y.begin(), y.end());
    for (const double special : {0.0, -0.0, 1e-300, 709.7, -708.3, -744.0, 0.34657359027997264, -0.34657359027997264})
        x.push_back(special);
    Vector magnitude;
    for (const double v : x) magnitude.push_back(std::exp(v * 0.99));
    for (const double near : {1.0, 1 + 1e-15, 1 - 1e-15, 0.70710678118654746, 0.70710678118654757, 1.4142135623730951})
        magnitude.push_back(near);
    const double inf = std::numeric_limits<double>::infinity();
    Vector first;
    for (const auto set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
        const BarycenterKernels& kernels = barycenter_kernels(set);
        Vector out(x.size());
        kernels.exp(x.data(), out.data(), static_cast<int>(x.size()));
        for (std::size_t k = 0; k < x.size(); ++k)
            if (x[k] > -708) CHECK(ulps(out[k], std::exp(static_cast<long double>(x[k]))) <= 2);
        // Where an entry stands makes no difference.
        for (const int shift : {1, 3}) {
            Vector again(x.size());
            kernels.exp(x.data() + shift, again.data(), static_cast<int>(x.size()) - shift);
            for (std::size_t k = 0; k + 3 < x.size(); ++k) CHECK(again[k] == out[k + static_cast<std::size_t>(shift)]);
        }
        const Vector ends{-746, -1e10, -inf, 710, 1e10, inf, std::nan("")};
        Vector at_ends(ends.size());
        kernels.exp(ends.data(), at_ends.data(), static_cast<int>(ends.size()));
        for (std::size_t k = 0; k < 3; ++k) CHECK(at_ends[k] == 0 && at_ends[k + 3] == inf);
        CHECK(std::isnan(at_ends[6]));
        Vector logs(magnitude.size());
        kernels.log(magnitude.data(), logs.data(), static_cast<int>(magnitude.size()));
        for (std::size_t k = 0; k < magnitude.size(); ++k)
            if (magnitude[k] >= std::numeric_limits<double>::min()) {
                const long double exact = std::log(static_cast<long double>(magnitude[k]));
                CHECK(exact == 0 ? logs[k] == 0 : ulps(logs[k], exact) <= 2);
            }
    }
}

// w_i, d_i and I - J_i with the dense kernel.
void test_against_dense() {
    for (const double sigma : {0.4, 0.9, 3.0}) {
        const GaussianKernel kernel(cells, sigma);
        const std::size_t n = static_cast<std::size_t>(kernel.size()), m = bodies().size();
        Random random(22);
        const Vector x = random.vector(m * n), z = random.vector(m * n);
        const std::vector<char> linear(m, 0);
        const Transport transport(kernel, bodies(), linear, 1);
        Vector kv(m * n), w(m * n), log_d(m * n), out(m * n);
        transport.sweep(x.data(), kv.data(), w.data(), log_d.data(), 1e-290);
        Jacobian(transport, x.data(), kv.data(), w.data(), log_d.data()).laplacian({0, 1}, z.data(), out.data());
        for (std::size_t i = 0; i < m; ++i) {
            Vector v(n), k(n), scratch(n), d(n), a(n);
            for (std::size_t c = 0; c < n; ++c) v[c] = std::exp(x[i * n + c]), a[c] = v[c] * z[i * n + c];
            kernel.apply(v.data(), k.data(), scratch.data());
            kernel.apply(a.data(), a.data(), scratch.data());
            for (std::size_t c = 0; c < n; ++c) {
                if (bodies()[i][c] > 0) {
                    CHECK(transport.covers(i, c));
                    NEAR(kv[i * n + c] / k[c], 1, 1e-14);
                    NEAR(w[i * n + c] * k[c] / bodies()[i][c], 1, 1e-14);
                }
                d[c] = bodies()[i][c] / k[c], a[c] *= d[c] / k[c];
            }
            kernel.apply(d.data(), d.data(), scratch.data());
            kernel.apply(a.data(), a.data(), scratch.data());
            for (std::size_t c = 0; c < n; ++c) {
                NEAR(log_d[i * n + c], std::log(d[c]), 1e-13 * std::fmax(1, std::fabs(std::log(d[c]))));
                NEAR(out[i * n + c], z[i * n + c] - a[c] / d[c], 1e-12);
            }
        }
        // Any number of threads gives the same bits; each base alone gives what it gives among others.
        for (const int threads : {2, 5}) {
            const Transport many(kernel, bodies(), linear, threads);
            Vector kv2(m * n), w2(m * n), log_d2(m * n), out2(m * n);
            many.sweep(x.data(), kv2.data(), w2.data(), log_d2.data(), 1e-290);
            Jacobian(many, x.data(), kv2.data(), w2.data(), log_d2.data()).laplacian({0, 1}, z.data(), out2.data());
            CHECK(kv2 == kv && w2 == w && log_d2 == log_d && out2 == out);
        }
        // One base in logarithms beside others that are not.
        for (std::size_t i = 0; i < m; ++i) {
            Transport mixed(kernel, bodies(), linear, 2);
            mixed.make_logarithmic(i);
            Vector kv2(m * n), w2(m * n), log_d2(m * n), out2(m * n);
            mixed.sweep(x.data(), kv2.data(), w2.data(), log_d2.data(), 1e-290);
            Jacobian(mixed, x.data(), kv2.data(), w2.data(), log_d2.data()).laplacian({0, 1}, z.data(), out2.data());
            for (std::size_t k = 0; k < m * n; ++k) {
                NEAR(log_d2[k], log_d[k], 1e-13 * std::fmax(1, std::fabs(log_d[k])));
                NEAR(out2[k], out[k], 1e-12);
                if (k / n != i) CHECK(kv2[k] == kv[k] && w2[k] == w[k]);
                if (k / n == i && bodies()[i][k % n] > 0) NEAR(std::exp(kv2[k]) / kv[k], 1, 1e-13);
            }
        }
    }
}

// J_i 1 = 1, and <y, J_i z> = <J_i y, z> under v d, in both forms of the kernel.
void test_jacobian_is_stochastic_and_self_adjoint() {
    const GaussianKernel kernel(cells, 0.8);
    const std::size_t n = static_cast<std::size_t>(kernel.size());
    Random random(23);
    for (const bool logarithmic : {false, true}) {
        const Densities one{bodies()[0]};
        const Transport transport(kernel, one, {logarithmic}, 1);
        const Vector x = random.vector(n), y = random.vector(n), z = random.vector(n), constant(n, 2.5);
        Vector kv(n), w(n), log_d(n), ly(n), lz(n), lc(n);
        transport.sweep(x.data(), kv.data(), w.data(), log_d.data(), 1e-290);
        const Jacobian jacobian(transport, x.data(), kv.data(), w.data(), log_d.data());
        jacobian.laplacian({0}, y.data(), ly.data());
        jacobian.laplacian({0}, z.data(), lz.data());
        jacobian.laplacian({0}, constant.data(), lc.data());
        double left = 0, right = 0, square = 0;
        for (std::size_t c = 0; c < n; ++c) {
            const double q = std::exp(x[c] + log_d[c]);
            NEAR(lc[c], 0, 1e-12);
            left += q * y[c] * lz[c], right += q * ly[c] * z[c], square += q * y[c] * ly[c];
        }
        CHECK(square > 0 && std::fabs(left) > 1e-4);
        NEAR(left / right, 1, 1e-11);
        // w / (K v) may exceed the largest double where what it multiplies is as small.
        Vector low(x);
        for (double& v : low) v -= 500;
        transport.sweep(low.data(), kv.data(), w.data(), log_d.data(), 1e-290);
        Vector same(n);
        Jacobian(transport, low.data(), kv.data(), w.data(), log_d.data()).laplacian({0}, y.data(), same.data());
        for (std::size_t c = 0; c < n; ++c) NEAR(same[c], ly[c], 1e-11);
    }
}

// Symmetric and positive under p, leaves no smooth function alone, and undoes the diffusion of a linear one.
void test_coarse_correction() {
    const double sigma = 0.6;
    Vector p = soft_ellipsoid(cells, {9, 4.5, 5.5}, {8, 3.5, 4.5});
    const std::size_t n = p.size();
    const CoarseCorrection correction(cells, sigma, p);
    Random random(24);
    const Vector y = random.vector(n), z = random.vector(n);
    Vector my(n), mz(n);
    correction.apply(y.data(), my.data());
    correction.apply(z.data(), mz.data());
    double left = 0, right = 0, square = 0, plain = 0;
    for (std::size_t c = 0; c < n; ++c) {
        left += p[c] * y[c] * mz[c], right += p[c] * my[c] * z[c];
        square += p[c] * y[c] * my[c], plain += p[c] * y[c] * y[c];
    }
    NEAR(left / right, 1, 1e-9);
    CHECK(square > plain);
    // r = L x / p for x linear along the body: C A^-1 C^T p r gives x back, up to a constant.
    const auto at = [&](int i, int j, int k) { return static_cast<std::size_t>((i * cells[1] + j) * cells[2] + k); };
    Vector r(n, 0.0);
    for (int i = 0; i + 1 < cells[0]; ++i)
        for (int j = 0; j < cells[1]; ++j)
            for (int k = 0; k < cells[2]; ++k) {
                const std::size_t a = at(i, j, k), b = at(i + 1, j, k);
                if (p[a] < 1e-8 || p[b] < 1e-8) continue;
                const double flux = sigma * sigma * std::sqrt(p[a] * p[b]);
                r[a] -= flux / p[a], r[b] += flux / p[b];
            }
    correction.apply(r.data(), my.data());
    for (int i = 5; i < 13; ++i) {
        const std::size_t a = at(i, 4, 5), b = at(i + 1, 4, 5);
        NEAR((my[b] - r[b]) - (my[a] - r[a]), 1, 1e-3);
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_exp_and_log),
        TEST(test_against_dense),
        TEST(test_jacobian_is_stochastic_and_self_adjoint),
        TEST(test_coarse_correction),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
