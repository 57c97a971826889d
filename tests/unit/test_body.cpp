// SPDX-License-Identifier: MIT
// The body's energies: value, gradient, Hessian product, parameter derivatives, filter, and the layout of blocks.
// The rotation itself is tested in test_rotation.cpp.
#include <Eigen/Dense>

#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;

// A body with a modulus of its own in every cell, and fibres in several directions, some cells with two.
struct Sample {
    ActiveSet set;
    Vector rest, mu, signals{0.3, -0.8};
    std::vector<MuscleEntry> muscles;

    explicit Sample(const std::array<int, 3>& cells, int n_muscles = 13, std::uint64_t seed = 1)
        : set(full_set(cells, 0.1)), rest(set.rest_positions()) {
        Random random{seed};
        for (int c = 0; c < set.n_cells(); ++c) mu.push_back(random.between(0.2, 2.0) * 1e6);
        for (int e = 0; e < n_muscles; ++e) {
            MuscleEntry m;
            m.cell = (5 * e) % set.n_cells();
            m.signal = e % 2, m.sign = e % 3 ? 1.0 : -1.0;
            double n = 0.0;
            for (double& x : m.direction) x = random(), n += x * x;
            for (double& x : m.direction) x /= std::sqrt(n);
            m.weight = random.between(0.5, 2.0) * 1e6;
            muscles.push_back(m);
        }
    }
    Body body(InstructionSet instructions = InstructionSet::automatic) const {
        return Body(set, mu, muscles, 0.2, instructions);
    }
    // Rest state displaced at random by this part of a cell.
    Vector displaced(double part, std::uint64_t seed = 2) const {
        Random random{seed};
        return plus(rest, part * set.box.dx, random_vector(rest.size(), random));
    }
};

struct Result {
    double energy = 0.0;
    Vector elastic, muscle, total;
};

Result evaluate(const Body& body, BodyWorkspace& ws, const Vector& q, const Vector& signals, int threads = 1) {
    Result r;
    r.elastic.resize(q.size()), r.muscle.resize(q.size());
    r.energy = body.gradient(ws, q.data(), signals.data(), threads, r.elastic.data(), r.muscle.data());
    r.total = plus(r.elastic, 1.0, r.muscle);
    return r;
}

Vector product(const Body& body, BodyWorkspace& ws, const Vector& p, int threads = 1) {
    Vector out(p.size(), 0.0);
    body.product(ws, p.data(), threads, out.data());
    return out;
}

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
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (h + h.transpose())).eigenvalues()(0);
}

// ---------------------------------------------------------------- values

// Rotation and translation cost nothing, near the origin and a kilometre away, where positions are known to 1e-13 m.
void test_rigid_motion() {
    const Sample s({5, 4, 3}, 0);
    const Body body = s.body();
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
    CHECK(ws.inverted == 8 * s.set.n_cells());
}

// Uniform stretch: energy mu V |F - 1|^2 and muscle w/2 V (l - r)^2, by hand.
void test_uniform_stretch() {
    Sample s({3, 2, 2}, 0);
    s.muscles.push_back({4, 0, 1.0, {0.0, 1.0, 0.0}, 3e6});
    s.muscles.push_back({4, 0, -1.0, {0.0, 1.0, 0.0}, 2e6});
    const Body body = s.body();
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
    const Body body = s.body();
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
    const Body body = s.body();
    BodyWorkspace ws, scratch;
    Random random{4};
    const Vector q = plus(mapped(s.rest, {-0.5, 0.1, 0, 0, 1.3, 0.1, 0.05, 0, 1.0}), 0.002, random_vector(24, random));
    const Vector p = random_vector(24, random, 0.1), r = random_vector(24, random);
    const Result at = evaluate(body, ws, q, s.signals);
    CHECK(ws.inverted == 8);
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
    const Body body = s.body();
    BodyWorkspace ws, scratch;
    Random random{5};
    const Vector q = s.displaced(0.15), lambda = random_vector(q.size(), random);
    evaluate(body, ws, q, s.signals);
    Vector mu_bar(s.mu.size(), 0.0), weight_bar(s.muscles.size(), 0.0), signal_bar(2, 0.0);
    body.parameter_pullback(ws, q.data(), lambda.data(), 1, mu_bar.data(), weight_bar.data(), signal_bar.data());
    const Vector dmu = random_vector(s.mu.size(), random, 1e6), dweight = random_vector(s.muscles.size(), random, 1e6),
                 dsignal = {0.7, -0.4};
    const auto value = [&](const Vector& mu, double e, const Vector& dw, const Vector& signals) {
        std::vector<MuscleEntry> muscles(s.muscles);
        for (std::size_t k = 0; k < muscles.size(); ++k) muscles[k].weight += e * dw[k];
        const Body changed(s.set, mu, muscles, 0.2, InstructionSet::automatic);
        return dot_of(lambda, evaluate(changed, scratch, q, signals).total);
    };
    CHECK_LINEAR_DERIVATIVE([&](double e) { return value(plus(s.mu, e, dmu), 0.0, dweight, s.signals); },
                            dot_of(mu_bar, dmu), 0.1);
    CHECK_LINEAR_DERIVATIVE([&](double e) { return value(s.mu, e, dweight, s.signals); }, dot_of(weight_bar, dweight), 0.1);
    CHECK_LINEAR_DERIVATIVE([&](double e) { return value(s.mu, 0.0, dweight, plus(s.signals, e, dsignal)); },
                            dot_of(signal_bar, dsignal), 0.1);
    // Added to what is there.
    Vector twice(signal_bar);
    Vector mu2(mu_bar), weight2(weight_bar);
    body.parameter_pullback(ws, q.data(), lambda.data(), 1, mu2.data(), weight2.data(), twice.data());
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
    const Body body = s.body();
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
    const Body body = s.body();
    Random random{6};
    const Vector compressed = mapped(s.rest, {0.4, 0.1, 0, 0, 0.5, 0, 0, 0, 0.45}, {1, 2, 3});
    const Vector inverted = plus(mapped(s.rest, {-0.5, 0.1, 0, 0, 0.9, 0.1, 0.05, 0, 0.7}), 0.01, random_vector(36, random));
    const Vector collapsed(s.rest.size(), 0.25);
    for (const Vector& q : {compressed, inverted, collapsed, s.displaced(0.5)}) {
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

// ---------------------------------------------------------------- layout

// Any number of cells and muscles, full blocks or not: the sum of the cells one by one.
void test_padding() {
    for (const int n : {1, 2, 7, 8, 9, 13, 16}) {
        const Sample s({n, 1, 1}, n + 3);
        const Vector q = s.displaced(n % 2 ? 0.2 : 0.5);
        BodyWorkspace ws;
        const Body body = s.body();
        const Result all = evaluate(body, ws, q, s.signals);
        Random random{8};
        const Vector p = random_vector(q.size(), random), hp = product(body, ws, p);
        double energy = 0.0;
        int inverted = 0;
        Vector total(q.size(), 0.0), sum_hp(q.size(), 0.0);
        for (int c = 0; c < n; ++c) {
            Sample one({1, 1, 1}, 0);
            one.mu = {s.mu[static_cast<std::size_t>(c)]};
            for (MuscleEntry m : s.muscles)
                if (m.cell == c) m.cell = 0, one.muscles.push_back(m);
            const auto gather = [&](const Vector& from) {
                Vector local;
                for (const int node : s.set.cell_nodes[static_cast<std::size_t>(c)])
                    local.insert(local.end(), from.begin() + 3 * node, from.begin() + 3 * node + 3);
                return local;
            };
            const auto scatter = [&](const Vector& local, Vector& to) {
                for (std::size_t k = 0; k < 24; ++k)
                    to[3 * static_cast<std::size_t>(s.set.cell_nodes[static_cast<std::size_t>(c)][k / 3]) + k % 3] += local[k];
            };
            const Body single = one.body();
            const Result r = evaluate(single, ws, gather(q), s.signals);
            energy += r.energy, inverted += ws.inverted;
            scatter(r.total, total);
            scatter(product(single, ws, gather(p)), sum_hp);
        }
        NEAR(all.energy, energy, 1e-13 * energy);
        NEAR(relative_difference(all.total, total), 0.0, 1e-13);
        NEAR(relative_difference(hp, sum_hp), 0.0, 1e-12);
        BodyWorkspace again;
        evaluate(body, again, q, s.signals);
        CHECK(again.inverted == inverted);
    }
}

void test_instruction_sets_agree() {
    const Sample s({5, 4, 3});
    for (const double part : {0.1, 0.5}) {
        const Vector q = s.displaced(part);
        Random random{9};
        const Vector p = random_vector(q.size(), random);
        Vector reference[4];
        int tried = 0;
        for (const InstructionSet wanted : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
            if (choose_instruction_set(wanted) != wanted) continue;
            const Body body = s.body(wanted);
            BodyWorkspace ws;
            const Result r = evaluate(body, ws, q, s.signals);
            Vector mu_bar(s.mu.size(), 0.0), weight_bar(s.muscles.size(), 0.0), signal_bar(2, 0.0);
            body.parameter_pullback(ws, q.data(), p.data(), 1, mu_bar.data(), weight_bar.data(), signal_bar.data());
            const Vector values[4] = {r.total, product(body, ws, p), mu_bar, signal_bar};
            for (std::size_t k = 0; k < 4; ++k) {
                if (!tried) reference[k] = values[k];
                NEAR(relative_difference(values[k], reference[k]), 0.0, part < 0.2 ? 1e-13 : 1e-9);
            }
            ++tried;
        }
        CHECK(tried >= 1);
    }
}

void test_threads_give_the_same_bits() {
    const Sample s({12, 9, 7}, 301);
    const Body body = s.body();
    Random random{10};
    for (const double part : {0.1, 0.5}) {
        const Vector q = s.displaced(part), p = random_vector(q.size(), random);
        const auto run = [&](int threads) {
            BodyWorkspace ws;
            const Result r = evaluate(body, ws, q, s.signals, threads);
            Vector out(r.total), mu_bar(s.mu.size(), 0.0), weight_bar(s.muscles.size(), 0.0), signal_bar(2, 0.0);
            body.parameter_pullback(ws, q.data(), p.data(), threads, mu_bar.data(), weight_bar.data(), signal_bar.data());
            for (const Vector& v : {product(body, ws, p, threads), mu_bar, weight_bar, signal_bar})
                out.insert(out.end(), v.begin(), v.end());
            out.push_back(r.energy), out.push_back(ws.inverted);
            return out;
        };
        const Vector one = run(1);
        CHECK(all_finite(one));
        for (const int threads : {2, 3, 4}) CHECK(run(threads) == one);
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
        TEST(test_padding),
        TEST(test_instruction_sets_agree),
        TEST(test_threads_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
