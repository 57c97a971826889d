// SPDX-License-Identifier: MIT
// A step's loops over the nodes: every instruction set against their definitions, in single and in double precision, on
// nodes with no element and with many, and on ranges of the nodes.
#include <limits>

#include "grid/node_gather.hpp"
#include "motion/step_kernels.hpp"
#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;

constexpr InstructionSet kSets[] = {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512};
constexpr int kNodes = 23, kPlaces = 40;

template <class T>
std::vector<T> numbers(std::size_t n, Random& random) {
    std::vector<T> out;
    for (const double x : random_vector(n, random)) out.push_back(static_cast<T>(x));
    return out;
}

// Three kinds of forces that a node may have from none to seven elements of each.
template <class T>
struct Forces {
    std::vector<NodeGather> gathers;
    std::vector<std::vector<T>> values;
    std::vector<Vector> sums;  // [n][3]

    explicit Forces(Random& random) {
        for (int kind = 0; kind < 3; ++kind) {
            std::vector<int> node, place;
            std::vector<T> value = numbers<T>(4 * kPlaces, random);
            for (std::size_t k = 3; k < value.size(); k += 4) value[k] = T(0);
            Vector sum(3 * kNodes, 0.0);
            for (int n = 0; n < kNodes; ++n)
                for (int s = 0; s < (5 * n + 3 * kind) % 8; ++s) {
                    node.push_back(n), place.push_back(4 * ((7 * n + 11 * s + kind) % kPlaces));
                    for (int a = 0; a < 3; ++a)
                        sum[static_cast<std::size_t>(3 * n + a)] +=
                            static_cast<double>(value[static_cast<std::size_t>(place.back() + a)]);
                }
            gathers.emplace_back(kNodes, node, place), values.push_back(value), sums.push_back(sum);
        }
    }
    std::vector<NodeTerm<T>> terms() const {
        std::vector<NodeTerm<T>> out;
        for (std::size_t k = 0; k < 3; ++k) out.push_back(gathers[k].term(values[k].data()));
        return out;
    }
};

template <class T>
void direct_loop() {
    const double rounding = sizeof(T) == sizeof(float) ? 2e-6 : 1e-14, inv_b2 = 3.0;
    Random random{5};
    const Forces<T> forces(random);
    const std::vector<T> z = numbers<T>(3 * kNodes, random), p = numbers<T>(3 * kNodes, random),
                         ap = numbers<T>(3 * kNodes, random);
    Vector mass = random_vector(kNodes, random), free(3 * kNodes, 1.0);
    for (double& m : mass) m = 0.5 + std::fabs(m);
    for (std::size_t i = 0; i < free.size(); i += 5) free[i] = 0.0;
    const std::vector<NodeTerm<T>> terms = forces.terms();
    for (const T beta : {T(0), T(0.5)})
        for (const bool all_free : {true, false})
            for (const bool with_p : {true, false}) {
                if (!with_p && beta != T(0)) continue;
                Vector image(3 * kNodes), direction(3 * kNodes);
                double product = 0.0;
                for (std::size_t i = 0; i < image.size(); ++i) {
                    const double along = static_cast<double>(z[i]), b = static_cast<double>(beta);
                    image[i] = inv_b2 * mass[i / 3] * along;
                    for (const Vector& sum : forces.sums) image[i] += sum[i];
                    image[i] = (all_free ? 1.0 : free[i]) * image[i] + b * static_cast<double>(ap[i]);
                    direction[i] = along + b * static_cast<double>(p[i]);
                    product += image[i] * direction[i];
                }
                for (const InstructionSet set : kSets) {
                    std::vector<T> new_p = p, new_ap = ap;
                    // With beta = 0 what was there is not read.
                    if (beta == T(0)) new_p.assign(p.size(), std::numeric_limits<T>::quiet_NaN()), new_ap = new_p;
                    double got = 0.0;
                    for (const auto& [begin, end] : {std::pair{0, 9}, std::pair{9, kNodes}})
                        got += step_kernels(set).direct.in(T())(terms.data(), 3, mass.data(), inv_b2,
                                                                all_free ? nullptr : free.data(), z.data(), beta, begin,
                                                                end, with_p ? new_p.data() : nullptr, new_ap.data());
                    NEAR(relative_difference(Vector(new_ap.begin(), new_ap.end()), image), 0.0, rounding);
                    if (with_p) NEAR(relative_difference(Vector(new_p.begin(), new_p.end()), direction), 0.0, rounding);
                    NEAR(got / product, 1.0, 10 * rounding);
                }
            }
}

void test_direct() {
    direct_loop<double>();
    direct_loop<float>();
}

void test_balance() {
    constexpr double inv_b2 = 3.0;
    Random random{6};
    const Forces<double> forces(random);
    const Vector q = random_vector(3 * kNodes, random), y = random_vector(3 * kNodes, random);
    Vector mass = random_vector(kNodes, random), free(3 * kNodes, 1.0);
    for (double& m : mass) m = 0.5 + std::fabs(m);
    for (std::size_t i = 0; i < free.size(); i += 4) free[i] = 0.0;
    const std::vector<NodeTerm<double>> terms = forces.terms();
    // Tissue of two terms and no muscles, or one of each kind.
    for (const ForceGroups groups : {ForceGroups{2, 2, 3}, ForceGroups{1, 2, 3}})
        for (const bool all_free : {true, false}) {
            Vector gradient(3 * kNodes);
            ForceSums sums;
            for (std::size_t i = 0; i < gradient.size(); ++i) {
                const double way = q[i] - y[i], inertia = inv_b2 * mass[i / 3] * way;
                const double second = forces.sums[1][i], muscle = groups.tissue == 1 ? second : 0.0;
                const double tissue = forces.sums[0][i] + (second - muscle), water = forces.sums[2][i];
                gradient[i] = (all_free ? 1.0 : free[i]) * (inertia + tissue + muscle + water);
                sums += {0.5 * inertia * way, inertia * inertia, water * water,
                         tissue * tissue,     muscle * muscle,   gradient[i] * gradient[i]};
            }
            for (const InstructionSet set : kSets) {
                Vector got(3 * kNodes);
                ForceSums total;
                for (const auto& [begin, end] : {std::pair{0, 9}, std::pair{9, kNodes}}) {
                    ForceSums part;
                    step_kernels(set).balance(terms.data(), groups, mass.data(), inv_b2, q.data(), y.data(),
                                              all_free ? nullptr : free.data(), begin, end, got.data(), part);
                    total += part;
                }
                NEAR(relative_difference(got, gradient), 0.0, 1e-14);
                for (const auto field : {&ForceSums::energy, &ForceSums::inertia2, &ForceSums::water2,
                                         &ForceSums::elastic2, &ForceSums::muscle2, &ForceSums::total2})
                    NEAR(total.*field, sums.*field, 1e-13 * sums.*field);
            }
        }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {TEST(test_direct), TEST(test_balance)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
