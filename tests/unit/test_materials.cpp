// SPDX-License-Identifier: MIT
// The materials: rest, rigid motion, Hooke's law for small strains, derivatives, definite linearisation when asked for.
#include <Eigen/Core>

#include "body_fixtures.hpp"
#include "grid/symmetric_eigen.hpp"

namespace {

using namespace fixtures;

struct Law {
    Material material;
    Quadrature quadrature;
    const char* name;
};
constexpr Law kLaws[] = {{Material::corotated, Quadrature::full, "corotated"},
                         {Material::corotated_volume, Quadrature::full, "corotated with volume"},
                         {Material::neo_hookean, Quadrature::full, "neo-Hookean"},
                         {Material::corotated, Quadrature::reduced, "corotated, reduced"},
                         {Material::corotated_volume, Quadrature::reduced, "corotated with volume, reduced"},
                         {Material::neo_hookean, Quadrature::reduced, "neo-Hookean, reduced"}};

struct Block {
    Sample sample;
    Elasticity elasticity;
    explicit Block(const Law& law, int n_muscles = 0) : sample({4, 3, 3}, n_muscles) {
        elasticity = {law.material, sample.mu, {}, law.quadrature};
        Random random{9};
        for (const double m : sample.mu) elasticity.lambda.push_back(m * between(random, 0.5, 9.0));
    }
    Body body() const { return body(elasticity); }
    Body body(const Elasticity& e, InstructionSet set = InstructionSet::automatic) const {
        return Body(sample.set, e, sample.muscles, 0.2, set);
    }
};

void test_rest_and_rigid_motion() {
    Random random{1};
    for (const Law& m : kLaws) {
        const Block b(m);
        const Body body = b.body();
        BodyWorkspace ws;
        const Result stretched = evaluate(body, ws, mapped(b.sample.rest, {1.1, 0, 0, 0, 1, 0, 0, 0, 1}), {0, 0});
        CHECK(stretched.energy > 0);
        for (int k = 0; k < 5; ++k) {
            const Result r = evaluate(body, ws, mapped(b.sample.rest, random_rotation(random), {1, 2, 3}), {0, 0});
            CHECK(norm_of(r.total) <= 1e-11 * norm_of(stretched.total) && ws.inverted == 0);
        }
        const Result rest = evaluate(body, ws, b.sample.rest, {0, 0});
        CHECK(rest.energy >= 0);
        CHECK(evaluate(body, ws, b.sample.displaced(0.01), {0, 0}).energy > rest.energy);  // it is a minimum
    }
}

// Uniform small strains: the energy density is mu |e|^2 + lambda/2 tr(e)^2 for the two materials with a volume term.
void test_hooke() {
    Random random{2};
    for (const Law& m : kLaws) {
        if (m.material == Material::corotated) continue;
        Sample s({2, 2, 2}, 0);
        const double mu = 0.7e6, lambda = 2.9e6, volume = 8 * std::pow(s.set.box.dx, 3);
        const Elasticity e{m.material, Vector(8, mu), Vector(8, lambda), m.quadrature};
        const Body body(s.set, e, {}, 0.2, InstructionSet::automatic);
        BodyWorkspace ws;
        const double rest = evaluate(body, ws, s.rest, {0, 0}).energy;
        for (int k = 0; k < 6; ++k) {
            std::array<double, 9> g{};
            for (double& x : g) x = random();
            double trace = g[0] + g[4] + g[8], square = 0.0;
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t j = 0; j < 3; ++j) {
                    const double strain = 0.5 * (g[3 * i + j] + g[3 * j + i]);
                    square += strain * strain;
                }
            const double hooke = volume * (mu * square + 0.5 * lambda * trace * trace);
            // Second difference of the energy: exact up to e^2.
            const auto energy = [&](double step) {
                std::array<double, 9> f{1, 0, 0, 0, 1, 0, 0, 0, 1};
                for (std::size_t i = 0; i < 9; ++i) f[i] += step * g[i];
                return evaluate(body, ws, mapped(s.rest, f), {0, 0}).energy - rest;
            };
            const double step = 1e-3;
            const double d1 = (energy(step) + energy(-step)) / (2 * step * step),
                         d2 = (energy(2 * step) + energy(-2 * step)) / (8 * step * step);
            NEAR((4 * d1 - d2) / 3, hooke, 1e-6 * hooke);
        }
    }
}

void test_derivatives() {
    for (const Law& m : kLaws)
        for (const double part : {0.05, 0.25}) {
            const Block b(m, 7);
            const Body body = b.body();
            BodyWorkspace ws, scratch;
            Random random{3};
            const Vector q = b.sample.displaced(part);
            const Vector p = random_vector(q.size(), random, b.sample.set.box.dx), r = random_vector(q.size(), random);
            const Vector& signals = b.sample.signals;
            const Result at = evaluate(body, ws, q, signals);
            CHECK(ws.inverted == 0);
            CHECK_DERIVATIVE([&](double e) { return evaluate(body, scratch, plus(q, e, p), signals).energy; },
                             dot_of(at.total, p), 1e-2);
            const Vector hp = product(body, ws, p), hr = product(body, ws, r);
            CHECK_DERIVATIVE([&](double e) { return dot_of(r, evaluate(body, scratch, plus(q, e, p), signals).total); },
                             dot_of(r, hp), 1e-2);
            NEAR(dot_of(r, hp), dot_of(p, hr), 1e-13 * norm_of(p) * norm_of(hr));
        }
    report_worst("gradient and Hessian");
}

// Products in single precision are those in double precision to its rounding, whatever the instruction set, the number
// of threads and what stands behind the last coordinate.
void test_single_precision() {
    for (const Law& m : kLaws) {
        const Block b(m, 70);
        Random random{5};
        const Vector q = b.sample.displaced(0.25), p = random_vector(q.size(), random);
        std::vector<float> single(p.begin(), p.end());
        single.push_back(std::numeric_limits<float>::quiet_NaN());
        for (const InstructionSet set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
            const Body body = b.body(b.elasticity, set);
            BodyWorkspace ws;
            evaluate(body, ws, q, b.sample.signals);
            const auto single_product = [&](int threads) {
                body.to_single(ws, threads);
                std::vector<float> out(q.size(), 0.0f);
                body.product(ws, single.data(), threads, out.data());
                return out;
            };
            const std::vector<float> hp = single_product(1);
            const double error = relative_difference(Vector(hp.begin(), hp.end()), product(body, ws, p));
            CHECK(error > 1e-9 && error < 3e-7);
            for (const int threads : {2, 3}) CHECK(single_product(threads) == hp);
            // It follows the linearisation.
            body.filter(ws);
            const std::vector<float> filtered = single_product(1);
            NEAR(relative_difference(Vector(filtered.begin(), filtered.end()), product(body, ws, p)), 0.0, 3e-7);
        }
    }
}

void test_parameters() {
    for (const Law& m : kLaws) {
        const Block b(m, 5);
        const Body body = b.body();
        BodyWorkspace ws, scratch;
        Random random{4};
        const Vector q = b.sample.displaced(0.15), adjoint = random_vector(q.size(), random);
        evaluate(body, ws, q, b.sample.signals);
        const std::size_t n = b.sample.mu.size();
        Vector mu_bar(n, 0.0), lambda_bar(n, 0.0), weight_bar(5, 0.0), signal_bar(2, 0.0);
        body.parameter_pullback(ws, q.data(), adjoint.data(), 1,
                                {mu_bar.data(), lambda_bar.data(), weight_bar.data(), signal_bar.data()});
        const Vector dmu = random_vector(n, random, 1e5), dlambda = random_vector(n, random, 1e5);
        const auto value = [&](double e, double f) {
            const Elasticity changed{m.material, plus(b.elasticity.mu, e, dmu), plus(b.elasticity.lambda, f, dlambda),
                                     m.quadrature};
            return dot_of(adjoint, evaluate(b.body(changed), scratch, q, b.sample.signals).total);
        };
        // Forces are linear in both, but for the rest shift of the neo-Hookean, which is a constant times J's
        // cofactors.
        CHECK_LINEAR_DERIVATIVE([&](double e) { return value(e, 0); }, dot_of(mu_bar, dmu), 0.1);
        if (m.material == Material::corotated)
            CHECK(norm_of(lambda_bar) == 0.0);
        else
            CHECK_LINEAR_DERIVATIVE([&](double e) { return value(0, e); }, dot_of(lambda_bar, dlambda), 0.1);
    }
    report_worst("moduli");
}

// Violently deformed and turned inside out: after `filter` no direction has negative curvature.
void test_filter() {
    for (const Law& law : kLaws) {
        const Block b(law, 7);
        const Body body = b.body();
        BodyWorkspace ws;
        // The centre of a cell sees the mean of its corners: it takes more to turn it inside out.
        const double part = law.quadrature == Quadrature::full ? 0.7 : 1.4;
        evaluate(body, ws, b.sample.displaced(part), {1.0, -1.0});
        CHECK(ws.inverted > 0);
        const std::size_t n = b.sample.rest.size();
        const auto smallest = [&] {
            Eigen::MatrixXd h(n, n);
            Vector unit(n, 0.0);
            for (std::size_t j = 0; j < n; ++j) {
                unit[j] = 1.0;
                const Vector column = product(body, ws, unit);
                unit[j] = 0.0;
                for (std::size_t i = 0; i < n; ++i) h(static_cast<long>(i), static_cast<long>(j)) = column[i];
            }
            const dqa::SymmetricEigen e = dqa::symmetric_eigen(0.5 * (h + h.transpose()));
            return e.values(0) / e.values.cwiseAbs().maxCoeff();
        };
        const double before = smallest();
        body.filter(ws);
        const double after = smallest();
        print_message("%s: least eigenvalue %.1e of the largest, filtered %.1e\n", law.name, before, after);
        CHECK(before < -1e-4);
        CHECK(after > -1e-12);
    }
}

}  // namespace

// The size of the parts that cancel in the energy bounds its rounding: at rest only rounding is left.
void test_cancelling() {
    Random random{6};
    for (const Law& law : kLaws) {
        const Block b(law);
        const Body body = b.body();
        if (law.material != Material::neo_hookean) {
            CHECK(body.cancelling() == 0);
            continue;
        }
        const Law full{law.material, Quadrature::full, ""};
        CHECK(std::fabs(body.cancelling() / Block(full).body().cancelling() - 1) <= 1e-14);
        BodyWorkspace ws;
        const double rest = evaluate(body, ws, b.sample.rest, {0, 0}).energy;
        double scatter = 0;
        for (int k = 0; k < 20; ++k) {
            const Vector q = mapped(b.sample.rest, random_rotation(random), {1, 2, 3});
            scatter = std::fmax(scatter, std::fabs(evaluate(body, ws, q, {0, 0}).energy - rest));
        }
        const double bound = std::numeric_limits<double>::epsilon() * body.cancelling();
        CHECK(scatter > 0.001 * bound && scatter <= 4 * bound);
    }
}

int main() {
    const CMUnitTest tests[] = {
        TEST(test_rest_and_rigid_motion),
        TEST(test_hooke),
        TEST(test_derivatives),
        TEST(test_single_precision),
        TEST(test_parameters),
        TEST(test_filter),
        TEST(test_cancelling),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
