// SPDX-License-Identifier: MIT
// The rotation of the corotated energy, scalar and batched: det +1 and optimal for every F, equal to the polar factor
// from a singular value decomposition where that is unique, converged to rounding.
#include <Eigen/Dense>

#include "body/kernels.hpp"
#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;
using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

struct Polar {
    Matrix r;
    double trace = 0.0;  // max over rotations of tr(R^T F)
    double gap = 0.0;    // s2 +- s3: how well R is defined, relative to s1
};

Polar polar_of(const Matrix& f) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(Eigen::Matrix3d(f), Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::Vector3d s = svd.singularValues();
    const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1.0 : 1.0;
    Polar p;
    p.r = svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
    p.trace = s(0) + s(1) + sign * s(2);
    p.gap = (s(1) + sign * s(2)) / s(0);
    return p;
}

Matrix random_matrix(Random& random) {
    Matrix f;
    for (int k = 0; k < 9; ++k) f.data()[k] = random();
    return f;
}

// U diag(s) V^T with random rotations: every kind of F by its signed singular values.
Matrix with_singular_values(const Vec3& s, Random& random) {
    const auto u = random_rotation(random), v = random_rotation(random);
    const Matrix a = Eigen::Map<const Matrix>(u.data()), b = Eigen::Map<const Matrix>(v.data());
    return a * Eigen::Vector3d(s[0], s[1], s[2]).asDiagonal() * b.transpose();
}

void check_rotation(const Matrix& f, const Matrix& r, int line) {
    const auto require = [&](double value, double expected, double tolerance) {
        check_near(value, expected, tolerance, line);
    };
    require((r.transpose() * r - Matrix::Identity()).norm(), 0.0, 4e-15);
    require(r.determinant(), 1.0, 4e-15);
    const double size = f.norm();
    if (!(size > 0)) return;
    const Polar p = polar_of(f / size);
    require((r.transpose() * f).trace() / size, p.trace, 5e-15);
    // Where two signed singular values nearly cancel, R turns by rounding / gap.
    if (p.gap > 1e-8) require((r - p.r).norm(), 0.0, 1e-14 / std::min(1.0, p.gap));
}

std::vector<Matrix> samples() {
    Random random{1};
    std::vector<Matrix> out;
    for (int k = 0; k < 400; ++k) out.push_back(random_matrix(random));  // half of them inverted
    for (int k = 0; k < 100; ++k) out.push_back(Matrix(Matrix::Identity() + 0.1 * random_matrix(random)));
    const Vec3 kinds[] = {{1, 1, 1},      {1, 1, -1},     {2, 1, -0.5},    {1, 1e-3, 1e-3},
                          {1, 1, 1e-5},   {1, 0.5, 1e-7}, {1, 0.5, -1e-7}, {1, 0.5, 0},
                          {1, 0, 0},      {1, 1e-9, 0},   {30, 1, 0.05},   {1, 0.3, -0.299},
                          {1, 0.3, -0.3}, {100, 1, 1e-4}, {3, 3, 3},       {1e-3, 1e-3, 1e-3}};
    for (const Vec3& s : kinds)
        for (int k = 0; k < 20; ++k) out.push_back(with_singular_values(s, random));
    out.push_back(Matrix::Zero());
    out.push_back(Matrix(-Matrix::Identity()));
    out.push_back(Matrix::Identity());
    out.push_back(Matrix(Eigen::Vector3d(1, -1, -1).asDiagonal()));
    out.push_back(Matrix(Eigen::Vector3d(-1, 1, 1).asDiagonal()));
    out.push_back(Matrix::Ones());
    return out;
}

void test_scalar_rotation() {
    for (const Matrix& f : samples())
        for (const double scale : {1.0, 1e-100, 1e100}) {
            const Matrix g = scale * f;
            Matrix r;
            rotation_any(g.data(), r.data());
            check_rotation(f, r, __LINE__);
        }
}

// F is uniform in each lane's cell; the cache holds R of every Gauss point.
void test_batched_rotation() {
    const auto all = samples();
    int tried = 0;
    for (const InstructionSet wanted : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
        if (choose_instruction_set(wanted) != wanted) continue;
        ++tried;
        const BodyKernels& kernels = body_kernels(wanted);
        int nodes[64];
        std::uint16_t slots[64];
        for (int k = 0; k < 64; ++k) nodes[k] = 3 * k, slots[k] = static_cast<std::uint16_t>(4 * k);  // [corner][lane]
        const Vector weight(8, 1.0);
        for (const double scale : {1.0, 1e-20, 1e20})
            for (std::size_t first = 0; first < all.size(); first += 5) {
                const auto f = [&](std::size_t lane) { return all[(first + lane) % all.size()]; };
                Vector q(192), force(256), energy(1),
                    cache(static_cast<std::size_t>(kernels.elastic[0][0].point_values) * 8);
                for (std::size_t lane = 0; lane < 8; ++lane)
                    for (int corner = 0; corner < 8; ++corner) {
                        const Eigen::Vector3d x(corner >> 2 & 1, corner >> 1 & 1, corner & 1);
                        const Eigen::Vector3d y = scale * (f(lane) * x);
                        for (int a = 0; a < 3; ++a) q[static_cast<std::size_t>(24 * corner + a) + 3 * lane] = y(a);
                    }
                int inverted = 0;
                kernels.elastic[0][0].gradient(q.data(), nodes, weight.data(), nullptr, 1.0, 0.0, 0, 1,
                                               {slots, force.data()}, energy.data(), cache.data(), &inverted);
                double expected = 0.0;
                for (std::size_t lane = 0; lane < 8; ++lane) {
                    for (std::size_t gauss = 0; gauss < 8; ++gauss) {
                        Matrix r;  // stored by columns
                        for (std::size_t k = 0; k < 9; ++k)
                            r(static_cast<int>(k % 3), static_cast<int>(k / 3)) = cache[(gauss * 15 + k) * 8 + lane];
                        check_rotation(f(lane), r, __LINE__);
                        expected += 0.5 * (scale * f(lane) - r).squaredNorm();
                    }
                }
                NEAR(energy[0], expected, 1e-13 * expected + 1e-28);
            }
    }
    CHECK(tried >= 1);
}

// Energy and gradient belong to the same rotation: along a path that begins at rest, the energy is the
// gradient's integral (Gauss-Legendre in short pieces), to rounding.
void test_energy_is_the_integral_of_the_gradient() {
    const ActiveSet set = full_set({2, 2, 2}, 1.0);
    const Body body(set, {Material::corotated, Vector(8, 1.0), {}}, {}, 0.2, InstructionSet::automatic);
    BodyWorkspace ws;
    Random random{2};
    const Vector rest = set.rest_positions(), q1 = plus(rest, 0.25, random_vector(rest.size(), random));
    const Vector q0 = mapped(rest, random_rotation(random), {10, 20, 30});
    const Vector &start = rest, path = plus(q1, -1.0, start);
    Vector elastic(rest.size()), muscle(rest.size());
    const auto slope = [&](double t) {
        body.gradient(ws, plus(start, t, path).data(), nullptr, 1, elastic.data(), muscle.data());
        return dot_of(elastic, path);
    };
    constexpr double x[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    constexpr double w[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    double integral = 0.0;
    constexpr int pieces = 40;
    for (int k = 0; k < pieces; ++k)
        for (int j = 0; j < 4; ++j)
            for (const double sign : {-1.0, 1.0})
                integral += 0.5 / pieces * w[j] * slope((k + 0.5 + 0.5 * sign * x[j]) / pieces);
    const double energy = body.gradient(ws, q1.data(), nullptr, 1, elastic.data(), muscle.data());
    CHECK(ws.inverted == 0 && energy > 0.1);
    NEAR(integral, energy, 1e-14 * energy * 10);
    NEAR(body.gradient(ws, q0.data(), nullptr, 1, elastic.data(), muscle.data()), 0.0, 1e-26);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_scalar_rotation),
        TEST(test_batched_rotation),
        TEST(test_energy_is_the_integral_of_the_gradient),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
