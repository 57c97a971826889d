// SPDX-License-Identifier: MIT
// The body's energies: value, gradient, Hessian product, parameter derivatives, filter. The rotation itself is tested
// in test_rotation.cpp, blocks, instruction sets and threads in test_body_layout.cpp.
#include <Eigen/Core>

#include "body_fixtures.hpp"
#include "grid/symmetric_eigen.hpp"

namespace {

using namespace fixtures;

Eigen::MatrixXd hessian(const Body& body, BodyWorkspace& ws, std::size_t n) {
    Eigen::MatrixXd h(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
    for (std::size_t j = 0; j < n; ++j) {
        Vector unit(n, 0.0);
        unit[j] = 1.0;
        const Vector column = product(body, ws, unit);
        for (std::size_t i = 0; i < n; ++i) h(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = column[i];
    }
    return h;
}

double least_eigenvalue(const Eigen::MatrixXd& h) {
    return dqa::symmetric_eigen(0.5 * (h + h.transpose())).values(0);
}

Quadrature quadrature = Quadrature::full;  // of the bodies that the tests make: all run with each
int points() {
    return quadrature == Quadrature::full ? 8 : 1;  // of integration in a cell
}

// ---------------------------------------------------------------- values

// Rotation and translation cost nothing, near the origin and a kilometre away, where positions are known to 1e-13 m.
void test_rigid_motion() {
    const Sample s({5, 4, 3}, 0);
    const Body body = s.body(InstructionSet::automatic, quadrature);
    BodyWorkspace ws;
    Random random{7};
    for (const double distance : {0.0, 1000.0})
        for (int round = 0; round < 20; ++round) {
            const Vec3 t = {distance * random(), distance * random(), distance * random()};
            const Result r = evaluate(body, ws, mapped(s.rest, random_rotation(random), t), s.signals);
            // One rounding of a position is a strain of eps |q| / dx; stresses and areas follow.
            const double strain = 4 * 2.2e-16 * (1.0 + distance) / s.set.box.dx;
            for (const double f : r.total) NEAR(f, 0.0, 2e6 * strain * 8 * 0.01);
            NEAR(r.energy, 0.0, 2e6 * strain * strain * 0.1 * 0.1 * 0.1 * s.set.n_cells());
            CHECK(ws.inverted == 0);
        }
    // A reflection is no rigid motion: it turns every Gauss point inside out, at the energy of 2 per unit of mu.
    Vector q(s.rest);
    for (std::size_t n = 0; n < q.size(); n += 3) q[n] = -q[n];
    const Result r = evaluate(body, ws, q, s.signals);
    double expected = 0.0;
    for (const double mu : s.mu) expected += 4.0 * mu * 1e-3;  // |F - R|^2 = 4 for F = diag(-1, 1, 1)
    NEAR(r.energy, expected, 1e-12 * expected);
    CHECK(ws.inverted == points() * s.set.n_cells());
}

// Uniform stretch: energy mu V |F - 1|^2 and muscle w/2 V (l - r)^2, by hand.
void test_uniform_stretch() {
    Sample s({3, 2, 2}, 0);
    s.muscles.push_back({4, 0, 1.0, {0.0, 1.0, 0.0}, 3e6});
    s.muscles.push_back({4, 0, -1.0, {0.0, 1.0, 0.0}, 2e6});
    const Body body = s.body(InstructionSet::automatic, quadrature);
    BodyWorkspace ws;
    const Result r = evaluate(body, ws, mapped(s.rest, {1.2, 0, 0, 0, 0.9, 0, 0, 0, 1.1}, {3, 4, 5}), s.signals);
    double expected = 0.0;
    for (const double mu : s.mu) expected += mu * 1e-3 * (0.04 + 0.01 + 0.01);
    const double rest = 0.2 * s.signals[0];  // one half contracts, its antagonist gives way
    expected += 0.5e-3 * (3e6 * std::pow(0.9 - 1 + rest, 2) + 2e6 * std::pow(0.9 - 1 - rest, 2));
    NEAR(r.energy, expected, 1e-12 * expected);
    double sum = 0.0;
    for (const double f : r.total) sum += f;
    NEAR(sum, 0.0, 1e-10 * norm_of(r.total));
}

// ---------------------------------------------------------------- derivatives

void test_gradient_and_hessian() {
    const Sample s({4, 3, 3});
    const Body body = s.body(InstructionSet::automatic, quadrature);
    BodyWorkspace ws, scratch;
    Random random{3};
    for (const double part : {0.02, 0.15, 0.3}) {
        const Vector q = s.displaced(part);
        const Vector p = random_vector(q.size(), random, s.set.box.dx), r = random_vector(q.size(), random);
        const Result at = evaluate(body, ws, q, s.signals);
        CHECK(ws.inverted == 0);
        CHECK_DERIVATIVE([&](double e) { return evaluate(body, scratch, plus(q, e, p), s.signals).energy; },
                         dot_of(at.total, p), 1e-2);
        const Vector hp = product(body, ws, p), hr = product(body, ws, r);
        CHECK_DERIVATIVE([&](double e) { return dot_of(r, evaluate(body, scratch, plus(q, e, p), s.signals).total); },
                         dot_of(r, hp), 1e-2);
        NEAR(dot_of(r, hp), dot_of(p, hr), 1e-13 * norm_of(p) * norm_of(hr));
    }
    report_worst("body gradient and Hessian");
}

// One cell turned inside out along x and stretched unevenly: singular values 1.3, 1, -0.5, far from one another.
void test_derivatives_of_an_inverted_cell() {
    const Sample s({1, 1, 1}, 2);
    const Body body = s.body(InstructionSet::automatic, quadrature);
    BodyWorkspace ws, scratch;
    Random random{4};
    const Vector q = plus(mapped(s.rest, {-0.5, 0.1, 0, 0, 1.3, 0.1, 0.05, 0, 1.0}), 0.002, random_vector(24, random));
    const Vector p = random_vector(24, random, 0.1), r = random_vector(24, random);
    const Result at = evaluate(body, ws, q, s.signals);
    CHECK(ws.inverted == points());
    CHECK_DERIVATIVE([&](double e) { return evaluate(body, scratch, plus(q, e, p), s.signals).energy; },
                     dot_of(at.total, p), 1e-2);
    const Vector hp = product(body, ws, p);
    CHECK_DERIVATIVE([&](double e) { return dot_of(r, evaluate(body, scratch, plus(q, e, p), s.signals).total); },
                     dot_of(r, hp), 1e-2);
    NEAR(dot_of(r, hp), dot_of(p, product(body, ws, r)), 1e-13 * norm_of(hp) * norm_of(r));
    report_worst("inverted cell");
}

void test_parameter_pullback() {
    const Sample s({4, 3, 3});
    const Body body = s.body(InstructionSet::automatic, quadrature);
    BodyWorkspace ws, scratch;
    Random random{5};
    const Vector q = s.displaced(0.15), lambda = random_vector(q.size(), random);
    evaluate(body, ws, q, s.signals);
    Vector mu_bar(s.mu.size(), 0.0), weight_bar(s.muscles.size(), 0.0), signal_bar(2, 0.0);
    body.parameter_pullback(ws, q.data(), lambda.data(), 1,
                            {mu_bar.data(), nullptr, weight_bar.data(), signal_bar.data()});
    const Vector dmu = random_vector(s.mu.size(), random, 1e6), dweight = random_vector(s.muscles.size(), random, 1e6),
                 dsignal = {0.7, -0.4};
    const auto value = [&](const Vector& mu, double e, const Vector& dw, const Vector& signals) {
        std::vector<MuscleEntry> muscles(s.muscles);
        for (std::size_t k = 0; k < muscles.size(); ++k) muscles[k].weight += e * dw[k];
        const Body changed(s.set, {Material::corotated, mu, {}, quadrature}, muscles, 0.2, InstructionSet::automatic);
        return dot_of(lambda, evaluate(changed, scratch, q, signals).total);
    };
    CHECK_LINEAR_DERIVATIVE([&](double e) { return value(plus(s.mu, e, dmu), 0.0, dweight, s.signals); },
                            dot_of(mu_bar, dmu), 0.1);
    CHECK_LINEAR_DERIVATIVE([&](double e) { return value(s.mu, e, dweight, s.signals); }, dot_of(weight_bar, dweight),
                            0.1);
    CHECK_LINEAR_DERIVATIVE([&](double e) { return value(s.mu, 0.0, dweight, plus(s.signals, e, dsignal)); },
                            dot_of(signal_bar, dsignal), 0.1);
    // Added to what is there.
    Vector twice(signal_bar);
    Vector mu2(mu_bar), weight2(weight_bar);
    body.parameter_pullback(ws, q.data(), lambda.data(), 1, {mu2.data(), nullptr, weight2.data(), twice.data()});
    NEAR(norm_of(plus(twice, -2.0, signal_bar)), 0.0, 1e-12 * norm_of(signal_bar));
    NEAR(norm_of(plus(mu2, -2.0, mu_bar)), 0.0, 1e-12 * norm_of(mu_bar));
    report_worst("parameter pullback");
}

// Stretched to l along the fibre, a muscle resists with w along it, and with w (1 - r / l) across it: nearly nothing.
void test_muscle_hessian() {
    Sample s({1, 1, 1}, 0);
    s.mu = {0.0};
    const double w = 2e6, volume = 1e-3;
    s.muscles.push_back({0, 0, 1.0, {1.0, 0.0, 0.0}, w});
    const Body body = s.body(InstructionSet::automatic, quadrature);
    for (const double l : {1.0, 1.1, 0.9, 0.8}) {
        BodyWorkspace ws;
        evaluate(body, ws, mapped(s.rest, {l, 0, 0, 0, 1, 0, 0, 0, 1}), {1.0});  // r = 0.8
        Vector along(24, 0.0), across(24, 0.0);
        for (std::size_t n = 0; n < 24; n += 3) along[n] = s.rest[n], across[n + 1] = s.rest[n];
        NEAR(dot_of(along, product(body, ws, along)), w * volume, 1e-9 * w * volume);
        NEAR(dot_of(across, product(body, ws, across)), w * (1 - 0.8 / l) * volume, 1e-9 * w * volume);
    }
}

void test_filter() {
    Sample s({2, 1, 1}, 3);
    for (MuscleEntry& m : s.muscles) m.weight *= 4.0;
    const Body body = s.body(InstructionSet::automatic, quadrature);
    Random random{6};
    const Vector compressed = mapped(s.rest, {0.4, 0.1, 0, 0, 0.5, 0, 0, 0, 0.45}, {1, 2, 3});
    const Vector inverted =
        plus(mapped(s.rest, {-0.5, 0.1, 0, 0, 0.9, 0.1, 0.05, 0, 0.7}), 0.01, random_vector(36, random));
    // Compressed by a tenth: eigenvalues of K just above 1/2, where a careless bound lets them pass.
    const Vector squeezed = mapped(s.rest, {0.9, 0, 0, 0, 0.9, 0, 0, 0, 0.9});
    const Vector collapsed(s.rest.size(), 0.25);
    for (const Vector& q : {compressed, squeezed, inverted, collapsed, s.displaced(0.5)}) {
        BodyWorkspace ws;
        evaluate(body, ws, q, s.signals);
        const Eigen::MatrixXd exact = hessian(body, ws, q.size());
        const double scale = 1e6 * s.set.box.dx;
        CHECK(least_eigenvalue(exact) < -0.01 * scale);
        body.filter(ws);
        const Eigen::MatrixXd filtered = hessian(body, ws, q.size());
        CHECK(least_eigenvalue(filtered) > -1e-12 * scale);
        CHECK(filtered.trace() > scale);
        NEAR((filtered - filtered.transpose()).norm(), 0.0, 1e-12 * filtered.norm());
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_rigid_motion),
        TEST(test_uniform_stretch),
        TEST(test_gradient_and_hessian),
        TEST(test_derivatives_of_an_inverted_cell),
        TEST(test_parameter_pullback),
        TEST(test_muscle_hessian),
        TEST(test_filter),
    };
    const int failed = cmocka_run_group_tests_name("eight points", tests, nullptr, nullptr);
    quadrature = Quadrature::reduced;
    return failed + cmocka_run_group_tests_name("one point and hourglass control", tests, nullptr, nullptr);
}
