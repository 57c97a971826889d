// SPDX-License-Identifier: MIT
// Muscle regions: interpolation over the bases, membership of a point, automatic placement, and their derivatives.
#include "derivative_checks.hpp"
#include "shape/actuator.hpp"
#include "shape/mesh_file.hpp"
#include "shape/voxelize.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Random;
using derivative::Vector;

constexpr double two_ln_2 = 1.3862943611198906;

Actuator actuator(const Vec3& mean, const Vec3& half, const Vec3& euler) {
    Actuator a;
    a.mean = mean, a.euler = euler;
    for (std::size_t k = 0; k < 3; ++k) a.variance[k] = half[k] * half[k] / two_ln_2;
    return a;
}

const Actuator& first() {
    static const Actuator a = actuator({0.1, 0.0, -0.05}, {0.3, 0.1, 0.15}, {0.2, -0.3, 0.4});
    return a;
}
const Actuator& second() {
    static const Actuator a = actuator({-0.2, 0.05, 0.1}, {0.2, 0.15, 0.1}, {-0.1, 0.25, 0.6});
    return a;
}

// The fields that have derivatives, in one row, and back.
Vector row(const ActuatorPoint& p) {
    Vector out;
    for (const Vec3* v : {&p.mean, &p.variance, &p.euler}) out.insert(out.end(), v->begin(), v->end());
    out.push_back(p.strength);
    return out;
}

ActuatorPoint point_of(const Vector& v) {
    ActuatorPoint p;
    std::copy_n(v.begin(), 3, p.mean.begin());
    std::copy_n(v.begin() + 3, 3, p.variance.begin());
    std::copy_n(v.begin() + 6, 3, p.euler.begin());
    if (v.size() > 9) p.strength = v[9];
    return p;
}

void test_smooth_step() {
    NEAR(smooth_step(-1), 0, 0);
    NEAR(smooth_step(0.5), 0.5, 1e-16);
    NEAR(smooth_step(2), 1, 0);
    for (const double t : {0.01, 0.2, 0.5, 0.77, 0.99}) {
        const double h = 1e-4;
        NEAR(smooth_step_derivative(t), (smooth_step(t + h) - smooth_step(t - h)) / (2 * h), 3e-7);
        NEAR(smooth_step(t) + smooth_step(1 - t), 1, 1e-15);
    }
    for (const double t : {1e-9, 1 - 1e-9}) NEAR(smooth_step_derivative(t), 0, 1e-15);
}

void test_interpolation_at_vertices() {
    const std::vector<const Actuator*> bases{&first(), nullptr, &second()};
    for (const std::size_t i : {std::size_t{0}, std::size_t{2}}) {
        Vector alpha(3, 0.0);
        alpha[i] = 1;
        const ActuatorPoint p = interpolate_actuator(bases, alpha);
        CHECK(p.mean == bases[i]->mean && p.variance == bases[i]->variance && p.euler == bases[i]->euler);
        CHECK(p.share == 1 && p.strength == 1 && p.weights == alpha);
    }
    // Weights are renormalised over the bases that have the category.
    const ActuatorPoint p = interpolate_actuator(bases, {0.2, 0.5, 0.3});
    NEAR(p.share, 0.5, 1e-16);
    CHECK(p.weights[1] == 0 && p.strength == 1);
    NEAR(p.weights[0], 0.4, 1e-15);
    NEAR(p.mean[0], 0.4 * 0.1 - 0.6 * 0.2, 1e-15);
    NEAR(p.euler[2], 0.4 * 0.4 + 0.6 * 0.6, 1e-15);
    // None of it: nothing but finite numbers.
    const ActuatorPoint none = interpolate_actuator(bases, {0, 1, 0});
    CHECK(none.share == 0 && none.strength == 0);
    for (const double v : row(none)) CHECK(std::isfinite(v));
    // The strength fades below 5 % and grows without a step.
    double last = 0;
    for (int k = 1; k <= 60; ++k) {
        const double share = 0.001 * k,
                     strength = interpolate_actuator(bases, {share / 2, 1 - share, share / 2}).strength;
        CHECK(k < 50 ? strength > last && strength < 1 : strength == 1);
        CHECK(strength - last < 0.04);
        last = strength;
    }
    NEAR(interpolate_actuator(bases, {0.025, 0.975, 0}).strength, 0.5, 1e-12);
}

void test_interpolation_derivative() {
    const std::vector<const Actuator*> bases{&first(), nullptr, &second()};
    const derivative::Map f = [&](const Vector& a) { return row(interpolate_actuator(bases, a)); };
    const derivative::Pullback back = [&](const Vector& a, const Vector& bar) {
        Vector out(3, 1.0);  // added to
        interpolate_actuator_pullback(bases, interpolate_actuator(bases, a), point_of(bar), out);
        for (double& x : out) x -= 1;
        return out;
    };
    derivative::check_pullback("a fair share", f, back, {0.2, 0.5, 0.3});
    derivative::Options options;
    options.step = options.taylor_step = 1e-3;
    derivative::check_pullback("a vanishing share", f, back, {0.01, 0.97, 0.02}, options);
    // At an edge of the simplex, into it.
    options.one_sided = true;
    options.directions = {{0.7, -1, 0.3}};
    derivative::check_pullback("only one of two", f, back, {0.0, 0.97, 0.03}, options);
    // No share: no derivative either.
    for (const double x : back({0, 1, 0}, Vector(10, 1.0))) NEAR(x, 0, 0);
}

// x = mean + R^T xi with R = Rx(e0) Ry(e1) Rz(e2), as a product of plane rotations.
Vec3 from_local(const ActuatorPoint& p, Vec3 xi) {
    const auto rotate = [&](std::size_t a, std::size_t b, double angle) {  // by the transpose
        const double c = std::cos(angle), s = std::sin(angle), u = xi[a], v = xi[b];
        xi[a] = c * u + s * v, xi[b] = -s * u + c * v;
    };
    rotate(1, 2, p.euler[0]), rotate(2, 0, p.euler[1]), rotate(0, 1, p.euler[2]);
    for (std::size_t k = 0; k < 3; ++k) xi[k] += p.mean[k];
    return xi;
}

void test_membership() {
    const Vec3 half{0.3, 0.1, 0.15};
    const double ramp = 0.02;
    const ActuatorPoint p = point_of(row(interpolate_actuator({&first()}, {1})));
    const ActuatorRegion region(p, ramp);
    NEAR(region.membership(p.mean), 1, 0);
    for (std::size_t k = 0; k < 3; ++k)
        for (const double side : {-1.0, 1.0}) {
            const auto at = [&](double distance) {
                Vec3 xi{};
                xi[k] = side * (half[k] + distance);
                return region.membership(from_local(p, xi));
            };
            NEAR(at(0), 0.5, 1e-12);
            NEAR(at(-0.51 * ramp), 1, 0);  // the ramp is one `ramp` wide
            NEAR(at(0.51 * ramp), 0, 0);
            CHECK(at(-0.49 * ramp) < 1 && at(0.49 * ramp) > 0);
            double last = 1;
            for (int i = -10; i <= 10; ++i) {
                const double value = at(0.05 * i * ramp);
                CHECK(value <= last + 1e-15 && last - value < 0.1);
                last = value;
            }
        }
    // The region is the box around the ellipsoid, its corners included.
    NEAR(region.membership(from_local(p, {0.28, -0.08, 0.13})), 1, 0);
    NEAR(region.membership(from_local(p, {0.3, -0.1, 0.15})), 0.125, 1e-12);
    NEAR(region.membership(from_local(p, {0.28, -0.12, 0.13})), 0, 0);
}

void test_membership_derivative() {
    Random random(21);
    const Vector x0 = row(interpolate_actuator({&first(), &second()}, {0.4, 0.6}));
    const ActuatorPoint p = point_of(x0);
    std::vector<Vec3> places;
    for (int k = 0; k < 200; ++k)
        places.push_back(
            from_local(p, {random.uniform(-0.35, 0.35), random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)}));
    const auto check_ramp = [&](double ramp) {
        int within = 0;
        for (const Vec3& x : places) {
            const double value = ActuatorRegion(p, ramp).membership(x);
            within += value > 0.01 && value < 0.99;
        }
        CHECK(within > 20);
        derivative::Options options;
        options.step = options.taylor_step = 1e-3 * ramp;
        derivative::check_pullback(
            "membership",
            [&](const Vector& v) {
                Vector out;
                for (const Vec3& x : places) out.push_back(ActuatorRegion(point_of(v), ramp).membership(x));
                return out;
            },
            [&](const Vector& v, const Vector& bar) {
                ActuatorPoint sum;
                for (std::size_t k = 0; k < places.size(); ++k)
                    ActuatorRegion(point_of(v), ramp).membership_pullback(places[k], bar[k], sum);
                Vector out = row(sum);
                out.resize(v.size());
                return out;
            },
            Vector(x0.begin(), x0.begin() + 9), options);
    };
    check_ramp(0.1);
    check_ramp(0.5);  // wider than the region: both sides of it count at once
}

void check_placement(const std::string& path, const Box& box) {
    TriangleMesh mesh = clean_and_check(read_mesh_file(path), path, nullptr);
    orient_up(mesh, UP_AUTO);
    const auto f = covered_fractions(mesh, box, 2, 4, 1, nullptr);
    const Actuator a = place_caudal(box, f);
    // Sections from tail to head, and the narrowest between 8 % and 40 % of the length: the peduncle.
    const int slab = box.cells[1] * box.cells[2];
    Vector area(static_cast<std::size_t>(box.cells[0]), 0.0);
    for (int c = 0; c < box.n_cells(); ++c) area[static_cast<std::size_t>(c / slab)] += f[static_cast<std::size_t>(c)];
    const double largest = *std::max_element(area.begin(), area.end());
    Vector body;  // x of the sections that are more than a trace
    for (int i = 0; i < box.cells[0]; ++i)
        if (area[static_cast<std::size_t>(i)] >= 0.02 * largest)
            body.push_back((i + 0.5 - 0.5 * box.cells[0]) * box.dx);
    const double tail = body.front() - 0.5 * box.dx, length = body.back() - body.front() + box.dx;
    const double half = std::sqrt(two_ln_2 * a.variance[0]), back = a.mean[0] - half, front = a.mean[0] + half;
    CHECK(half > 0.02 * length);
    CHECK(back >= tail + 0.08 * length - 1.01 * box.dx && back <= tail + 0.4 * length + 1.01 * box.dx);
    CHECK(front > back + 2 * box.dx - 1e-9 && front <= tail + 0.56 * length + box.dx);
    const auto section = [&](double x) {
        return area[static_cast<std::size_t>(std::floor(x / box.dx + 0.5 * box.cells[0] + 1e-6))];
    };
    for (double x = std::max(back, tail + 0.1 * length); x < tail + 0.38 * length; x += box.dx)
        CHECK(section(back) <= section(x) + 1e-12);
    // Symmetric about y = 0, and around the body there: every covered cell of that stretch is a member.
    NEAR(a.mean[1], 0, 0);
    for (const double e : a.euler) NEAR(e, 0, 0);
    const ActuatorRegion region(interpolate_actuator({&a}, {1}), box.dx);
    double covered = 0, muscle = 0;
    for (int c = 0; c < box.n_cells(); ++c) {
        const Vec3 x = box.cell_centre(c);
        NEAR(region.membership(x), region.membership({x[0], -x[1], x[2]}), 1e-13);
        if (x[0] < back + box.dx || x[0] > front - box.dx) continue;
        covered += f[static_cast<std::size_t>(c)], muscle += f[static_cast<std::size_t>(c)] * region.membership(x);
    }
    CHECK(covered > 0 && muscle > 0.8 * covered);
}

void test_placement() {
#ifdef DQA_HAVE_ASSIMP
    for (const char* name : {"clownfish", "tuna", "eel_vertical", "eel_horizontal"})
        for (const Box& box : {Box{{40, 12, 20}, 0.05}, Box{{60, 16, 26}, 1.0 / 56}})
            check_placement(std::string(DQA_SHAPES_DIR "/") + name + ".stl", box);
#else
    throw Skipped{};
#endif
}

void test_placement_without_body() {
    const Box box{{20, 8, 8}, 0.1};
    EXPECT_ERROR(ERROR_ARGUMENT, "no body found",
                 place_caudal(box, Vector(static_cast<std::size_t>(box.n_cells()), 0.0)));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_smooth_step),
        TEST(test_interpolation_at_vertices),
        TEST(test_interpolation_derivative),
        TEST(test_membership),
        TEST(test_membership_derivative),
        TEST(test_placement),
        TEST(test_placement_without_body),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
