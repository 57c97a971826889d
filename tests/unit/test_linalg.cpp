// SPDX-License-Identifier: MIT
// Ordering, factor, packed solve, conjugate gradients and the direct solvers: through the public functions only, so
// that every build option is held to the same.
#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <filesystem>

#include "linalg/nested_dissection.hpp"
#include "linalg/packed_factor.hpp"
#include "linalg/pcg.hpp"
#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;
using Sparse = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

// 27-point coupling on the nodes of a set of cells: weight of each cell times the trilinear Laplacian, plus a diagonal.
SymmetricMatrix laplacian(const ActiveSet& set, const Vector& weight, double diagonal) {
    std::vector<Eigen::Triplet<double>> entries;
    for (int c = 0; c < set.n_cells(); ++c)
        for (int a = 0; a < 8; ++a)
            for (int b = 0; b < 8; ++b) {
                double value = 0.0;
                for (int axis = 0; axis < 3; ++axis) {
                    double v = 1.0;
                    for (int k = 0; k < 3; ++k) {
                        const bool same = (a >> k & 1) == (b >> k & 1);
                        v *= k == axis ? (same ? 1.0 : -1.0) : (same ? 1.0 / 3 : 1.0 / 6);
                    }
                    value += v;
                }
                const auto& nodes = set.cell_nodes[static_cast<std::size_t>(c)];
                const int row = nodes[static_cast<std::size_t>(a)], column = nodes[static_cast<std::size_t>(b)];
                if (row >= column) entries.emplace_back(row, column, weight[static_cast<std::size_t>(c)] * value);
            }
    for (int n = 0; n < set.n_nodes(); ++n) entries.emplace_back(n, n, diagonal);
    Sparse s(set.n_nodes(), set.n_nodes());
    s.setFromTriplets(entries.begin(), entries.end());
    SymmetricMatrix m;
    m.n = set.n_nodes();
    m.start.assign(s.outerIndexPtr(), s.outerIndexPtr() + m.n + 1);
    m.row.assign(s.innerIndexPtr(), s.innerIndexPtr() + s.nonZeros());
    m.value.assign(s.valuePtr(), s.valuePtr() + s.nonZeros());
    return m;
}

Sparse lower_of(const SymmetricMatrix& m) {
    return Eigen::Map<const Sparse>(m.n, m.n, static_cast<Eigen::Index>(m.value.size()), m.start.data(), m.row.data(),
                                    m.value.data());
}

// out = A in for `rhs` interleaved right-hand sides.
Vector multiply(const SymmetricMatrix& m, const Vector& in, std::size_t rhs) {
    Vector out(in.size(), 0.0);
    for (std::size_t j = 0; j < static_cast<std::size_t>(m.n); ++j)
        for (int k = m.start[j]; k < m.start[j + 1]; ++k) {
            const std::size_t i = static_cast<std::size_t>(m.row[static_cast<std::size_t>(k)]);
            for (std::size_t r = 0; r < rhs; ++r) {
                out[rhs * i + r] += m.value[static_cast<std::size_t>(k)] * in[rhs * j + r];
                if (i != j) out[rhs * j + r] += m.value[static_cast<std::size_t>(k)] * in[rhs * i + r];
            }
        }
    return out;
}

Vector ones(const ActiveSet& set) {
    return Vector(static_cast<std::size_t>(set.n_cells()), 1.0);
}

SymmetricMatrix dense(const std::vector<Vector>& rows) {
    SymmetricMatrix m;
    m.n = static_cast<int>(rows.size());
    m.start.push_back(0);
    for (std::size_t j = 0; j < rows.size(); ++j) {
        for (std::size_t i = j; i < rows.size(); ++i)
            m.row.push_back(static_cast<int>(i)), m.value.push_back(rows[i][j]);
        m.start.push_back(static_cast<int>(m.row.size()));
    }
    return m;
}

void check_permutation(const std::vector<int>& order, std::size_t n) {
    CHECK(order.size() == n);
    std::vector<char> seen(n, 0);
    for (const int k : order) {
        CHECK(k >= 0 && k < static_cast<int>(n) && !seen[static_cast<std::size_t>(k)]);
        seen[static_cast<std::size_t>(k)] = 1;
    }
}

void test_nested_dissection() {
    for (const std::array<int, 3> cells : {std::array<int, 3>{20, 8, 8}, {40, 8, 8}, {16, 16, 12}}) {
        const ActiveSet set = full_set(cells, 1.0);
        const std::vector<int> order = nested_dissection(set.node_ijk);
        check_permutation(order, static_cast<std::size_t>(set.n_nodes()));
        const Sparse lower = lower_of(laplacian(set, ones(set), 1.0));
        Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> p(set.n_nodes());
        for (int k = 0; k < set.n_nodes(); ++k) p.indices()(order[static_cast<std::size_t>(k)]) = k;
        Sparse permuted(set.n_nodes(), set.n_nodes());
        permuted.selfadjointView<Eigen::Lower>() = lower.selfadjointView<Eigen::Lower>().twistedBy(p);
        const Eigen::SimplicialLLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> ours(permuted);
        const Eigen::SimplicialLLT<Sparse, Eigen::Lower, Eigen::AMDOrdering<int>> amd(lower);
        const double fill = static_cast<double>(Sparse(ours.matrixL()).nonZeros());
        const double reference = static_cast<double>(Sparse(amd.matrixL()).nonZeros());
        print_message("%d x %d x %d: fill %.0f, minimum degree %.0f, ratio %.2f\n", cells[0], cells[1], cells[2], fill,
                      reference, fill / reference);
        CHECK(fill <= 1.3 * reference);
    }
    // Ragged and tiny sets.
    Random random{3};
    for (const int n : {0, 1, 2, 25, 200}) {
        std::vector<std::array<int, 3>> nodes;
        for (int k = 0; k < n; ++k)
            nodes.push_back({static_cast<int>(10 * random()), static_cast<int>(3 * random()), 7});
        check_permutation(nested_dissection(nodes), nodes.size());
    }
}

// The factor multiplies back to the matrix.
void test_factorise() {
    const ActiveSet set = full_set({7, 4, 5}, 1.0);
    Random random{2};
    Vector weight(static_cast<std::size_t>(set.n_cells()));
    for (double& w : weight) w = std::pow(10.0, between(random, -8, 0));
    const SymmetricMatrix m = laplacian(set, weight, 1e-3);
    const CholeskyFactor f = factorise(m, nested_dissection(set.node_ijk));
    CHECK(f.n == m.n);
    check_permutation(f.permutation, static_cast<std::size_t>(m.n));
    Eigen::MatrixXd l = Eigen::MatrixXd::Zero(m.n, m.n);
    int columns = 0;
    long entries = 0;
    for (const Supernode& s : f.supernodes) {
        CHECK(s.first == columns && s.values.size() == s.rows.size() * static_cast<std::size_t>(s.columns));
        for (int j = 0; j < s.columns; ++j) {
            CHECK(s.rows[static_cast<std::size_t>(j)] == s.first + j);
            for (std::size_t i = static_cast<std::size_t>(j); i < s.rows.size(); ++i, ++entries)
                l(s.rows[i], s.first + j) = s.values[static_cast<std::size_t>(j) * s.rows.size() + i];
        }
        columns += s.columns;
    }
    CHECK(columns == m.n);
    CHECK(entries == f.entries);
    const Sparse full = lower_of(m).selfadjointView<Eigen::Lower>();
    const Eigen::MatrixXd a(full), product = l * l.transpose();
    double worst = 0.0;
    for (int i = 0; i < m.n; ++i)
        for (int j = 0; j < m.n; ++j)
            worst = std::max(worst, std::fabs(product(i, j) - a(f.permutation[static_cast<std::size_t>(i)],
                                                                f.permutation[static_cast<std::size_t>(j)])));
    NEAR(worst, 0.0, 1e-14 * a.cwiseAbs().maxCoeff());
    EXPECT_ERROR(ERROR_INTERNAL, "not positive definite", factorise(dense({{1, 2}, {2, 1}}), {0, 1}));
    EXPECT_ERROR(ERROR_INTERNAL, "not positive definite",
                 factorise(laplacian(set, weight, -1e-3), nested_dissection(set.node_ijk)));
}

void test_packed_solve() {
    const ActiveSet set = full_set({20, 8, 8}, 1.0);
    const SymmetricMatrix m = laplacian(set, ones(set), 0.1);
    const CholeskyFactor factor = factorise(m, nested_dissection(set.node_ijk));
    Random random{5};
    const std::size_t n = 3 * static_cast<std::size_t>(m.n);
    const Vector x = random_vector(n, random), y = random_vector(n, random), b = multiply(m, x, 3);
    PackedFactor::Workspace ws;
    Vector reference;
    int tried = 0;
    for (const InstructionSet wanted : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
        if (choose_instruction_set(wanted) != wanted) continue;
        ++tried;
        const PackedFactor packed(factor, Precision::single_precision, wanted);
        CHECK(packed.entries() == factor.entries);
        Vector out(n), other(n);
        packed.solve(b.data(), out.data(), 1, ws);
        NEAR(relative_difference(out, x), 0.0, 1e-5);
        if (reference.empty()) reference = out;
        NEAR(relative_difference(out, reference), 0.0, 1e-5);
        // A symmetric positive operator up to rounding.
        packed.solve(y.data(), other.data(), 1, ws);
        const double xy = dot_of(out, y), yx = dot_of(other, b);
        NEAR(xy, yx, 1e-5 * norm_of(out) * norm_of(y));
        CHECK(dot_of(other, y) > 0);
        // One right-hand side alone, its unknowns in blocks of three.
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t blocks = n / 9;
            std::vector<float> one(4 * blocks, 7.0f);
            const PackedFactor::ReadBlocks<float> read = [&](const int* listed, int count, float* values) {
                for (int l = 0; l < count; ++l)
                    for (int a = 0; a < 3; ++a)
                        values[4 * l + a] = static_cast<float>(b[static_cast<std::size_t>(9 * listed[l] + 3 * a) + k]);
            };
            for (const int threads : {1, 3}) {
                packed.solve(read, one.data(), threads, ws);
                Vector got, expected;
                for (std::size_t i = 0; i < n / 3; ++i)
                    got.push_back(static_cast<double>(one[i / 3 * 4 + i % 3])), expected.push_back(x[3 * i + k]);
                NEAR(relative_difference(got, expected), 0.0, 1e-5);
            }
            for (std::size_t i = 0; i < blocks; ++i) CHECK(one[4 * i + 3] == 7.0f);
        }
        // In place, and whatever the units.
        for (const double scale : {1.0, 1e-60, 1e60}) {
            Vector in_place(b);
            for (double& v : in_place) v *= scale;
            packed.solve(in_place.data(), in_place.data(), 1, ws);
            for (double& v : in_place) v /= scale;
            NEAR(relative_difference(in_place, x), 0.0, 1e-5);
        }
        const Vector zero(n, 0.0);
        packed.solve(zero.data(), out.data(), 1, ws);
        CHECK(norm_of(out) == 0.0);
    }
    CHECK(tried >= 1);
}

// Stiffness that spans eight decades: the packed factor makes conjugate gradients converge at once.
void test_pcg_with_packed_factor() {
    const ActiveSet set = full_set({12, 6, 6}, 1.0);
    Random random{8};
    Vector weight(static_cast<std::size_t>(set.n_cells()));
    for (double& w : weight) w = std::pow(10.0, between(random, -8, 0));
    const SymmetricMatrix m = laplacian(set, weight, 1e-6);
    const PackedFactor packed(factorise(m, nested_dissection(set.node_ijk)), Precision::single_precision,
                              InstructionSet::automatic);
    PackedFactor::Workspace factor_ws;
    PcgWorkspace ws;
    const std::size_t n = 3 * static_cast<std::size_t>(m.n);
    const Vector b = random_vector(n, random);
    Vector x(n, 7.0);  // the start is zero whatever stands there
    const auto apply = [&](const double* p, double* out) {
        const Vector product = multiply(m, Vector(p, p + n), 3);
        std::copy(product.begin(), product.end(), out);
    };
    const auto precondition = [&](const double* r, double* z) { packed.solve(r, z, 1, factor_ws); };
    const PcgResult r = pcg(n, b.data(), x.data(), 1e-11, 100, apply, precondition, 1, ws);
    CHECK(r.converged && !r.negative_curvature);
    CHECK(r.iterations > 1 && r.iterations <= 12);
    NEAR(relative_difference(multiply(m, x, 3), b), 0.0, 2e-11);
    const PcgResult few = pcg(n, b.data(), x.data(), 1e-13, 1, apply, precondition, 1, ws);
    CHECK(!few.converged && few.iterations == 1 && few.relative_residual > 1e-13);
    NEAR(relative_difference(multiply(m, x, 3), b), few.relative_residual, 1e-6);
}

void test_pcg_special_cases() {
    PcgWorkspace ws;
    const auto diagonal = [](const Vector& d) {
        return [d](const double* p, double* out) {
            for (std::size_t i = 0; i < d.size(); ++i) out[i] = d[i] * p[i];
        };
    };
    const auto identity = diagonal({1, 1, 1, 1});
    Vector b = {1, 2, 3, 4}, x(4);
    PcgResult r = pcg(4, b.data(), x.data(), 1e-12, 10, diagonal({1, 2, 3, 4}), identity, 1, ws);
    CHECK(r.converged && r.iterations == 4);
    for (const double v : x) NEAR(v, 1.0, 1e-12);
    r = pcg(4, b.data(), x.data(), 1e-12, 10, diagonal({1, 2, -30, 4}), identity, 1, ws);
    CHECK(r.negative_curvature && !r.converged && r.iterations == 0);
    CHECK(norm_of(x) == 0.0);
    // Negative curvature in the second direction: the first iterate is kept, and is one of descent.
    r = pcg(4, b.data(), x.data(), 1e-12, 10, diagonal({-0.5, 2, 3, 4}), identity, 1, ws);
    CHECK(r.negative_curvature && !r.converged && r.iterations >= 1);
    CHECK(dot_of(x, b) > 0);
    const Vector zero(4, 0.0);
    r = pcg(4, zero.data(), x.data(), 1e-12, 10, diagonal({1, 2, 3, 4}), identity, 1, ws);
    CHECK(r.converged && r.iterations == 0 && norm_of(x) == 0.0);
    b[2] = std::nan("");
    r = pcg(4, b.data(), x.data(), 1e-12, 10, diagonal({1, 2, 3, 4}), identity, 1, ws);
    CHECK(!r.converged);
    r = pcg(4, b.data(), x.data(), 1e-12, 10, diagonal({1, 2, std::nan(""), 4}), identity, 1, ws);
    CHECK(!r.converged);
}

// Conjugate gradients that iterate in single precision, on diagonal systems. Their products are exact, or as wrong as
// `error` says; they are counted.
struct MixedTrial {
    Vector diagonal;
    float error = 0.0f;
    double rounding = 0.0;  // as it is told to the solver
    bool updates = false;   // the system updates the vectors itself
    int singles = 0, doubles = 0;
    PcgWorkspace ws;

    PcgResult solve(const Vector& b, Vector& x, double tolerance, int limit = 200, bool indefinite = false) {
        const std::size_t n = diagonal.size();
        singles = doubles = 0;
        x.assign(n, 7.0);
        return mixed_pcg(
            n, b.data(), x.data(), tolerance, limit, products<double>(doubles, 0.0), products<float>(singles, error),
            [&](const float*) { return rounding; }, 1, ws, indefinite);
    }

private:
    template <class T>
    PcgProducts<T> products(int& count, T wrong) {
        const auto apply = [this, &count, wrong](const T* p, T* out) {
            ++count;
            for (std::size_t i = 0; i < diagonal.size(); ++i)
                out[i] = static_cast<T>(diagonal[i]) * p[i] * (1 + (i % 2 ? wrong : -wrong));
            return ordered_dot(p, out, diagonal.size());
        };
        const auto precondition = [this](const T* r, double norm, bool descended, const T* ap,
                                         T* z) -> std::array<double, 2> {
            CHECK(!descended || norm == norm_of_descend);
            std::copy(r, r + diagonal.size(), z);
            return {ordered_dot(r, z, diagonal.size()), ordered_dot(ap, z, diagonal.size())};
        };
        if (!updates) return {apply, precondition};
        const auto direct = [this, apply](const T* z, T beta, T* p, T* ap) {
            std::vector<T> product(diagonal.size());
            apply(z, product.data());
            for (std::size_t i = 0; i < diagonal.size(); ++i) {
                p[i] = beta == T(0) ? z[i] : z[i] + beta * p[i];
                ap[i] = beta == T(0) ? product[i] : product[i] + beta * ap[i];
            }
            return ordered_dot(p, ap, diagonal.size());
        };
        const auto descend = [this](T step, const T* p, const T* ap, T* x, T* r, double norm) {
            norm_of_descend = norm;
            for (std::size_t i = 0; i < diagonal.size(); ++i) x[i] += step * p[i], r[i] -= step * ap[i];
            return ordered_dot(r, r, diagonal.size());
        };
        return {apply, precondition, direct, descend};
    }
    double norm_of_descend = 0.0;
};

void mixed_pcg_gains_digits(bool updates) {
    MixedTrial trial;
    trial.updates = updates;
    Random random{9};
    for (int i = 0; i < 60; ++i) trial.diagonal.push_back(std::pow(10.0, between(random, -2, 0)));
    const Vector b = random_vector(60, random, 1e-30);  // its squares are below the least float
    const auto residual = [&](const Vector& x) {
        Vector r = b;
        for (std::size_t i = 0; i < r.size(); ++i) r[i] -= trial.diagonal[i] * x[i];
        return norm_of(r) / norm_of(b);
    };
    Vector x;
    // Far beyond the digits of floats, in products that are nearly all in single precision.
    trial.rounding = 1.0;
    PcgResult r = trial.solve(b, x, 1e-12);
    CHECK(r.converged && residual(x) <= 1e-12);
    NEAR(residual(x), r.relative_residual, 1e-15);
    CHECK(trial.singles == r.iterations && trial.doubles >= 6 && trial.doubles <= 8);
    // Rounding far below the tolerance needs no check; close to it, it does.
    trial.rounding = 1e-4;
    r = trial.solve(b, x, 2e-2);
    CHECK(r.converged && residual(x) <= 2e-2 && trial.doubles == 0);
    trial.rounding = 1e-2;
    r = trial.solve(b, x, 2e-2);
    CHECK(r.converged && residual(x) <= 2e-2 && trial.doubles == 1);
    // Products that are wrong in the second digit still serve, a digit at a time; wrong by half, they do not, and
    // double precision takes over.
    trial.error = 0.02f;
    r = trial.solve(b, x, 1e-8);
    CHECK(r.converged && residual(x) <= 1e-8 && trial.singles == r.iterations);
    trial.error = 0.5f;
    r = trial.solve(b, x, 1e-8);
    CHECK(r.converged && residual(x) <= 1e-8 && trial.singles < r.iterations && trial.doubles > 10);
    // The limit is one for both.
    r = trial.solve(b, x, 1e-8, 20);
    CHECK(!r.converged && r.iterations == 20);
    NEAR(residual(x), r.relative_residual, 1e-6);
}

// What is no minimum, not finite or nothing at all ends as in double precision.
void mixed_pcg_special_cases(bool updates) {
    MixedTrial trial;
    trial.updates = updates;
    trial.rounding = 1.0;
    Vector b = {1, 2, 3, 4}, x;
    trial.diagonal = {1, 2, -30, 4};
    PcgResult r = trial.solve(b, x, 1e-12);
    CHECK(r.negative_curvature && !r.converged && r.iterations == 0 && norm_of(x) == 0.0);
    trial.diagonal = {-0.5, 2, 3, 4};
    r = trial.solve(b, x, 1e-12);
    CHECK(r.negative_curvature && !r.converged && r.iterations >= 1 && dot_of(x, b) > 0);
    r = trial.solve(b, x, 1e-12, 20, true);
    CHECK(r.negative_curvature && r.converged);
    for (std::size_t i = 0; i < 4; ++i) NEAR(x[i], b[i] / trial.diagonal[i], 1e-10);
    r = trial.solve({0, 0, 0, 0}, x, 1e-12);
    CHECK(r.converged && r.iterations == 0 && norm_of(x) == 0.0);
    trial.diagonal = {1, 2, 3, std::nan("")};
    CHECK(!trial.solve(b, x, 1e-12).converged);
    trial.diagonal = {1, 2, 3, 4};
    b[1] = std::nan("");
    CHECK(!trial.solve(b, x, 1e-12).converged);
}

// The direct solvers work on the calling thread: who has asked for one thread gets no more.
void test_no_hidden_threads() {
    const std::filesystem::path tasks = "/proc/self/task";
    if (!std::filesystem::exists(tasks)) skip();
    const auto threads = [&] {
        return std::distance(std::filesystem::directory_iterator(tasks), std::filesystem::directory_iterator());
    };
    const ActiveSet set = full_set({24, 12, 12}, 1.0);
    const SymmetricMatrix m = laplacian(set, ones(set), 0.01);
    Vector x(static_cast<std::size_t>(m.n), 1.0);
    const auto before = threads();
    CHECK(solve_positive(m, x));
    CHECK(threads() == before);
    (void)factorise(m, nested_dissection(set.node_ijk));
    CHECK(threads() == before);
}

void test_direct_solvers() {
    Random random{6};
    CHECK(std::strlen(direct_solver_name()) > 0);
    for (const int size : {1, 3, 8}) {
        const ActiveSet set = full_set({2 * size, size, size}, 1.0);
        const SymmetricMatrix good = laplacian(set, ones(set), 0.01);
        // Shifted into the middle of the spectrum.
        const SymmetricMatrix bad = laplacian(set, ones(set), -0.513);
        const Vector x = random_vector(static_cast<std::size_t>(good.n), random);
        Vector y = multiply(good, x, 1);
        CHECK(solve_positive(good, y));
        NEAR(relative_difference(y, x), 0.0, 1e-11);
        const Vector b = multiply(bad, x, 1);
        y = b;
        CHECK(!solve_positive(bad, y));
        y = b;
        CHECK(solve_indefinite(bad, y));
        NEAR(relative_difference(multiply(bad, y, 1), b), 0.0, 1e-11);
        y = multiply(good, x, 1);
        CHECK(solve_indefinite(good, y));
        NEAR(relative_difference(y, x), 0.0, 1e-11);
    }
    Vector y = {1.0, 3.0};
    CHECK(!solve_positive(dense({{1, 2}, {2, 1}}), y));
    y = {1.0, 3.0};
    CHECK(solve_indefinite(dense({{0, 2}, {2, 0}}), y));  // no pivot on the diagonal
    NEAR(y[0], 1.5, 1e-15);
    NEAR(y[1], 0.5, 1e-15);
    y = {1.0, 3.0};
    CHECK(!solve_positive(dense({{1, 1}, {1, 1}}), y));
    y = {1.0, 3.0};
    CHECK(!solve_indefinite(dense({{1, 1}, {1, 1}}), y));
}

void test_mixed_pcg() {
    for (const bool updates : {false, true}) mixed_pcg_gains_digits(updates);
}
void test_mixed_pcg_special_cases() {
    for (const bool updates : {false, true}) mixed_pcg_special_cases(updates);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_no_hidden_threads),  // before others start some
        TEST(test_nested_dissection),       TEST(test_factorise),         TEST(test_packed_solve),
        TEST(test_pcg_with_packed_factor),  TEST(test_pcg_special_cases), TEST(test_mixed_pcg),
        TEST(test_mixed_pcg_special_cases), TEST(test_direct_solvers),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
