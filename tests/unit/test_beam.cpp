// SPDX-License-Identifier: MIT
// A cantilever of Q1 cells against beam theory. The corotated energy without its volume term has the uniaxial modulus
// 2 mu and no lateral contraction: tip deflection P L^3 / (3 E I) and first frequency 1.8751^2 sqrt(E I / (rho A L^4))
// with E = 2 mu (Euler-Bernoulli), shear included after Timoshenko for the order of convergence.
#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>

#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double kMu = 1e6, kDensity = 1000.0, kLength = 1.0, kSlenderness = 20.0;

struct Answer {
    double deflection = 0.0;  // m per N
    double frequency = 0.0;   // rad/s
};

// `layers` cells through the thickness, one across the width; the load is along y. Motion along z is held: without
// lateral contraction it takes no part, but its own bending would be the softer mode.
Answer solve(int layers, Material material, double lambda, Quadrature quadrature) {
    const double dx = kLength / kSlenderness / layers;
    const int nx = static_cast<int>(kSlenderness) * layers;
    const ActiveSet set = full_set({nx, layers, 1}, dx);
    const std::size_t n_cells = static_cast<std::size_t>(set.n_cells());
    const Body body(set, {material, Vector(n_cells, kMu), Vector(n_cells, lambda), quadrature}, {}, 0.2,
                    InstructionSet::automatic);
    const Vector rest = set.rest_positions();
    Vector force(rest.size()), muscle(rest.size());
    BodyWorkspace ws;
    NEAR(body.gradient(ws, rest.data(), nullptr, 1, force.data(), muscle.data()), 0.0, 1e-9);
    std::vector<int> free(rest.size(), -1);
    int n = 0;
    for (std::size_t i = 0; i < rest.size(); ++i)
        if (set.node_ijk[i / 3][0] > 0 && i % 3 != 2) free[i] = n++;
    std::vector<Eigen::Triplet<double>> entries;
    Vector unit(rest.size(), 0.0), column(rest.size());
    for (std::size_t j = 0; j < rest.size(); ++j) {
        if (free[j] < 0) continue;
        std::fill(column.begin(), column.end(), 0.0);
        unit[j] = 1.0;
        body.product(ws, unit.data(), 1, column.data());
        unit[j] = 0.0;
        for (std::size_t i = 0; i < rest.size(); ++i)
            if (free[i] >= 0 && column[i] != 0.0) entries.emplace_back(free[i], free[j], column[i]);
    }
    Sparse k(n, n);
    k.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Sparse> factor(k);
    CHECK(factor.info() == Eigen::Success && factor.vectorD().minCoeff() > 0);
    // Unit load spread over the end's nodes; deflection there likewise averaged (the work of the load).
    Eigen::VectorXd load = Eigen::VectorXd::Zero(n), mass = Eigen::VectorXd::Zero(n);
    for (const auto& nodes : set.cell_nodes)
        for (std::size_t c = 0; c < 8; ++c)
            for (int a = 0; a < 2; ++a) {
                const int i = free[static_cast<std::size_t>(3 * nodes[c] + a)];
                if (i < 0) continue;
                mass(i) += kDensity * dx * dx * dx / 8;
                if (a == 1 && set.node_ijk[static_cast<std::size_t>(nodes[c])][0] == nx) load(i) += 0.25 / layers;
            }
    NEAR(load.sum(), 1.0, 1e-12);
    Answer answer;
    Eigen::VectorXd x = factor.solve(load);
    answer.deflection = load.dot(x);
    for (int iteration = 0; iteration < 30; ++iteration) {  // inverse iteration
        const Eigen::VectorXd mx = mass.cwiseProduct(x);
        answer.frequency = std::sqrt(x.dot(k * x) / x.dot(mx));
        x = factor.solve(mx);
        x.normalize();
    }
    // Per unit of width, so that all refinements have the same answer.
    answer.deflection *= dx;
    return answer;
}

void test_cantilever() {
    const double modulus = 2 * kMu, t = kLength / kSlenderness;
    const double inertia = t * t * t / 12, area = t;  // of unit width
    const double bending = std::pow(kLength, 3) / (3 * modulus * inertia);
    const double shear = kLength / (5.0 / 6 * kMu * area);
    const double frequency =
        std::pow(1.87510406871196, 2) * std::sqrt(modulus * inertia / (kDensity * area * std::pow(kLength, 4)));
    const int layers[4] = {1, 2, 4, 8};
    Answer answers[4];
    double deflection_error[4], frequency_error[4];
    for (int k = 0; k < 4; ++k) {
        answers[k] = solve(layers[k], Material::corotated, 0.0, Quadrature::full);
        // Stiffness against stiffness: the error of one layer is as large as the answer.
        deflection_error[k] = (bending + shear) / answers[k].deflection - 1;
        frequency_error[k] = std::pow(answers[k].frequency / frequency, 2) - 1;
        print_message("%d layers: deflection %.5f of Euler-Bernoulli, frequency %.5f\n", layers[k],
                      answers[k].deflection / bending, answers[k].frequency / frequency);
    }
    for (int k = 1; k < 4; ++k) {
        NEAR(std::log2(deflection_error[k - 1] / deflection_error[k]), 2.0, 0.1);
        CHECK(frequency_error[k] < frequency_error[k - 1]);
    }
    // Shear takes 0.6 / slenderness^2 = 0.15 % of the static stiffness, and a little more of the frequency.
    NEAR(answers[3].deflection, bending, 0.01 * bending);
    NEAR(answers[3].frequency, frequency, 0.005 * frequency);
    const double limit = (4 * (1 / answers[3].deflection) - 1 / answers[2].deflection) / 3;
    NEAR(limit * (bending + shear), 1.0, 2e-4);
    const double squared = (4 * std::pow(answers[3].frequency, 2) - std::pow(answers[2].frequency, 2)) / 3;
    NEAR(std::sqrt(squared) / frequency, 1.0, 0.003);
    const double before = (4 * std::pow(answers[2].frequency, 2) - std::pow(answers[1].frequency, 2)) / 3;
    NEAR(std::log2((std::pow(answers[1].frequency, 2) - before) / (std::pow(answers[2].frequency, 2) - squared)), 2.0,
         0.1);
}

// One point and hourglass control: a single layer already bends, and swings, as the beam does, where eight points make
// it half again too stiff (test_cantilever). The limit is the same.
void test_single_layer() {
    const double modulus = 2 * kMu, t = kLength / kSlenderness, inertia = t * t * t / 12, area = t;
    const double deflection = std::pow(kLength, 3) / (3 * modulus * inertia) + kLength / (5.0 / 6 * kMu * area);
    const double frequency =
        std::pow(1.87510406871196, 2) * std::sqrt(modulus * inertia / (kDensity * area * std::pow(kLength, 4)));
    for (const int layers : {1, 2, 4, 8}) {
        const Answer answer = solve(layers, Material::corotated, 0.0, Quadrature::reduced);
        print_message("%d layers, one point: deflection %.5f of Timoshenko, frequency %.5f\n", layers,
                      answer.deflection / deflection, answer.frequency / frequency);
        NEAR(answer.deflection, deflection, 0.0015 * deflection);
        NEAR(answer.frequency, frequency, 0.004 * frequency);
    }
    const double locked = solve(1, Material::corotated, 0.0, Quadrature::full).deflection;
    NEAR(locked / deflection, 2.0 / 3, 0.01);
    const double fine = solve(8, Material::corotated, 0.0, Quadrature::reduced).deflection;
    NEAR(fine, solve(8, Material::corotated, 0.0, Quadrature::full).deflection, 0.01 * deflection);
}

// Nearly incompressible in plane strain, modulus E / (1 - nu^2): with the volume term at one point the beam bends as it
// should and converges as fast as before, where eight points would lock it.
void test_no_locking() {
    const double nu = 0.499, lambda = 2 * kMu * nu / (1 - 2 * nu);
    const double modulus = 2 * kMu * (1 + nu) / (1 - nu * nu), t = kLength / kSlenderness;
    const double bending = std::pow(kLength, 3) / (3 * modulus * t * t * t / 12);
    const std::pair<Material, Quadrature> laws[] = {{Material::corotated_volume, Quadrature::full},
                                                    {Material::neo_hookean, Quadrature::full},
                                                    {Material::corotated_volume, Quadrature::reduced},
                                                    {Material::neo_hookean, Quadrature::reduced}};
    for (const auto& [m, quadrature] : laws) {
        double error[3];
        for (int k = 0; k < 3; ++k) {
            const double deflection = solve(2 << k, m, lambda, quadrature).deflection;
            print_message("nu = %.3f, %d layers: deflection %.4f of Euler-Bernoulli\n", nu, 2 << k,
                          deflection / bending);
            error[k] = bending / deflection - 1;
        }
        CHECK(std::fabs(error[2]) < 0.03 && std::fabs(error[1]) < 0.1 && std::fabs(error[0]) < 0.4);
        CHECK(error[0] / error[1] > 3.0);
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {TEST(test_cantilever), TEST(test_single_layer), TEST(test_no_locking)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
