// SPDX-License-Identifier: MIT
// Muscle regions: interpolation over the bases, membership of a point, the fibre groups of fins, and their derivatives.
#include "derivative_checks.hpp"
#include "shape/actuator_region.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Random;
using derivative::Vector;

constexpr std::array<Interpolation, 2> both{Interpolation::linear, Interpolation::bures};

Actuator actuator(const Vec3& mean, const Vec3& half, const Vec3& euler) {
    Actuator a;
    a.mean = mean, a.euler = euler;
    for (std::size_t k = 0; k < 3; ++k) a.variance[k] = half[k] * half[k] / kTwoLn2;
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
template <class Point, class F>
void each_entry(Point& p, const F& f) {
    for (std::size_t k = 0; k < 3; ++k) f(p.mean[k]);
    for (std::size_t k = 0; k < 3; ++k) f(p.half[k]);
    for (std::size_t k = 0; k < 9; ++k) f(p.normal[k / 3][k % 3]);
    for (std::size_t k = 0; k < 9; ++k) f(p.edge[k / 3][k % 3]);
    f(p.strength);
}

template <class Point>
Vector row(const Point& p) {
    Vector out;
    each_entry(p, [&](double x) { out.push_back(x); });
    return out;
}

template <class Point>
Point point_of(const Vector& v) {
    Point p;
    std::size_t at = 0;
    each_entry(p, [&](double& x) { x = v[at++]; });
    return p;
}

double dot3(const Vec3& a, const Vec3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
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

// Row k of R = Rx(e0) Ry(e1) Rz(e2) as a product of plane rotations of a unit vector by the transpose.
Vec3 axis_of(const Vec3& euler, std::size_t k) {
    Vec3 xi{};
    xi[k] = 1;
    const auto rotate = [&](std::size_t a, std::size_t b, double angle) {
        const double c = std::cos(angle), s = std::sin(angle), u = xi[a], v = xi[b];
        xi[a] = c * u + s * v, xi[b] = -s * u + c * v;
    };
    rotate(1, 2, euler[0]), rotate(2, 0, euler[1]), rotate(0, 1, euler[2]);
    return xi;
}

void test_interpolation_at_vertices() {
    const std::vector<const Actuator*> bases{&first(), nullptr, &second()};
    for (const Interpolation way : both) {
        // A base alone gives the paper's box: along its own axes, around its half-peak ellipsoid.
        for (const std::size_t i : {std::size_t{0}, std::size_t{2}}) {
            Vector alpha(3, 0.0);
            alpha[i] = 1;
            const ActuatorPoint p = interpolate_actuator(bases, alpha, way);
            CHECK(p.mean == bases[i]->mean && p.share == 1 && p.strength == 1 && p.weights == alpha);
            for (std::size_t k = 0; k < 3; ++k) {
                NEAR(p.half[k], std::sqrt(kTwoLn2 * bases[i]->variance[k]), 1e-14);
                NEAR(p.variance[k], bases[i]->variance[k], 1e-15);
                for (std::size_t j = 0; j < 3; ++j) {
                    NEAR(p.normal[k][j], axis_of(bases[i]->euler, k)[j], 1e-13);
                    NEAR(p.edge[k][j], p.normal[k][j], 1e-13);
                }
            }
        }
        // None of it: nothing but finite numbers.
        const ActuatorPoint none = interpolate_actuator(bases, {0, 1, 0}, way);
        CHECK(none.share == 0 && none.strength == 0);
        for (const double v : row(none)) CHECK(std::isfinite(v));
    }
    // Weights are renormalised over the bases that have the category.
    const ActuatorPoint p = interpolate_actuator(bases, {0.2, 0.5, 0.3}, Interpolation::linear);
    NEAR(p.share, 0.5, 1e-16);
    CHECK(p.weights[1] == 0 && p.strength == 1);
    NEAR(p.weights[0], 0.4, 1e-15);
    NEAR(p.mean[0], 0.4 * 0.1 - 0.6 * 0.2, 1e-15);
    NEAR(p.euler[2], 0.4 * 0.4 + 0.6 * 0.6, 1e-15);
    // The strength fades below 5 % and grows without a step.
    double last = 0;
    for (int k = 1; k <= 60; ++k) {
        const double share = 0.001 * k;
        const double strength =
            interpolate_actuator(bases, {share / 2, 1 - share, share / 2}, Interpolation::linear).strength;
        CHECK(k < 50 ? strength > last && strength < 1 : strength == 1);
        CHECK(strength - last < 0.04);
        last = strength;
    }
    NEAR(interpolate_actuator(bases, {0.025, 0.975, 0}, Interpolation::linear).strength, 0.5, 1e-12);
}

// The parallelepiped of the Bures barycentre touches the half-peak ellipsoid with all its faces, like the paper's box.
void test_bures_box() {
    const ActuatorPoint p = interpolate_actuator({&first(), &second()}, {0.35, 0.65}, Interpolation::bures);
    double skew = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        double support = 0;  // of the ellipsoid along the normal: sqrt(2 ln 2 n . Sigma n)
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j)
                support += kTwoLn2 * p.normal[k][i] * p.covariance[3 * i + j] * p.normal[k][j];
        NEAR(p.half[k], std::sqrt(support), 1e-14);
        NEAR(dot3(p.normal[k], p.normal[k]), 1, 1e-14);
        NEAR(dot3(p.edge[k], p.edge[k]), 1, 1e-14);
        NEAR(dot3(p.normal[k], p.edge[(k + 1) % 3]), 0, 1e-13);
        NEAR(dot3(p.normal[k], p.edge[(k + 2) % 3]), 0, 1e-13);
        skew += std::fabs(dot3(p.normal[k], p.normal[(k + 1) % 3]));
    }
    CHECK(skew > 1e-3);  // not the trivial case
    // Without rotations the standard deviations are linear in the weights.
    Actuator a = first(), b = second();
    a.euler = b.euler = {};
    const ActuatorPoint q = interpolate_actuator({&a, &b}, {0.35, 0.65}, Interpolation::bures);
    for (std::size_t k = 0; k < 3; ++k)
        NEAR(q.half[k], std::sqrt(kTwoLn2) * (0.35 * std::sqrt(a.variance[k]) + 0.65 * std::sqrt(b.variance[k])),
             1e-14);
}

void test_interpolation_derivative() {
    // The last pair passes through equal eigenvalues, where sorted axes would jump.
    const Actuator round = actuator({0, 0, 0}, {0.2, 0.2, 0.2}, {0.3, 0.1, -0.2});
    const Actuator swapped = actuator({0, 0, 0}, {0.3, 0.2, 0.1}, {0, 0, 0}),
                   other = actuator({0, 0, 0}, {0.2, 0.3, 0.1}, {0, 0, 0.5});
    for (const Interpolation way : both)
        for (const auto& [a, b] : {std::pair{&first(), &second()}, std::pair{&round, &second()}, {&swapped, &other}}) {
            const std::vector<const Actuator*> bases{a, nullptr, b};
            const derivative::Map f = [&](const Vector& w) { return row(interpolate_actuator(bases, w, way)); };
            const derivative::Pullback back = [&](const Vector& w, const Vector& bar) {
                Vector out(3, 1.0);  // added to
                interpolate_actuator_pullback(bases, interpolate_actuator(bases, w, way), way,
                                              point_of<ActuatorBar>(bar), out);
                for (double& x : out) x -= 1;
                return out;
            };
            derivative::Options options;
            options.noise = 1e-14;
            derivative::check_pullback("a fair share", f, back, {0.2, 0.5, 0.3}, options);
            options.step = options.taylor_step = 1e-3;
            derivative::check_pullback("a vanishing share", f, back, {0.01, 0.97, 0.02}, options);
            // At an edge of the simplex, into it.
            options.one_sided = true;
            options.directions = {{0.7, -1, 0.3}};
            derivative::check_pullback("only one of two", f, back, {0.0, 0.97, 0.03}, options);
            // No share: no derivative either.
            for (const double x : back({0, 1, 0}, Vector(25, 1.0))) NEAR(x, 0, 0);
        }
}

void test_mirror() {
    Actuator left = second();
    left.kind = ActuatorKind::fins, left.half = ActuatorHalf::left;
    const Actuator right = mirrored(left);
    CHECK(right.half == ActuatorHalf::right && mirrored(right).half == ActuatorHalf::left);
    CHECK(mirrored(first()).half == ActuatorHalf::whole);
    const ActuatorPoint l = interpolate_actuator({&left}, {1}, Interpolation::linear),
                        r = interpolate_actuator({&right}, {1}, Interpolation::linear);
    const ActuatorRegion on_left(l, 0.03), on_right(r, 0.03);
    Random random(5);
    for (int k = 0; k < 300; ++k) {
        const Vec3 x{random.uniform(-0.4, 0), random.uniform(-0.1, 0.2), random.uniform(0, 0.2)};
        const Vec3 y{x[0], -x[1], x[2]};
        NEAR(on_left.membership(x), on_right.membership(y), 1e-13);
        for (int g = 0; g < 12; ++g)
            NEAR(on_left.group_share(x, left.half, 3, g / 4, g % 4),
                 on_right.group_share(y, right.half, 3, g / 4, g % 4), 1e-13);
    }
    const Vec3 d = fibre_direction(l, left.half), e = fibre_direction(r, right.half);
    NEAR(d[0], e[0], 1e-15);
    NEAR(d[1], -e[1], 1e-15);
    NEAR(d[2], e[2], 1e-15);
}

Vec3 from_local(const ActuatorPoint& p, const Vec3& xi) {
    Vec3 x = p.mean;
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t j = 0; j < 3; ++j) x[j] += p.normal[k][j] * xi[k];
    return x;
}

void test_membership() {
    const Vec3 half{0.3, 0.1, 0.15};
    const double ramp = 0.02;
    const ActuatorPoint p = interpolate_actuator({&first()}, {1}, Interpolation::linear);
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

// Layers from below, bands from back inside to ahead outside; together they are the whole fin.
void test_groups() {
    Actuator a = actuator({0.1, 0.3, 0}, {0.2, 0.2, 0.1}, {0, 0, 0});
    a.kind = ActuatorKind::fins, a.half = ActuatorHalf::left;
    const ActuatorPoint p = interpolate_actuator({&a}, {1}, Interpolation::linear);
    const ActuatorRegion region(p, 0.01);
    const auto group_at = [&](const Vec3& x, int layers) {
        double total = 0, largest = 0;
        int which = -1;
        for (int g = 0; g < 4 * layers; ++g) {
            const double share = region.group_share(x, a.half, layers, g / 4, g % 4);
            CHECK(share >= 0 && share <= 1);
            total += share;
            if (share > largest) largest = share, which = g;
        }
        NEAR(total, 1, 1e-14);
        return which;
    };
    CHECK(group_at({-0.05, 0.15, -0.09}, 4) == 0);    // back, inside, lowest
    CHECK(group_at({0.25, 0.45, -0.09}, 4) == 3);     // ahead, outside
    CHECK(group_at({0.25, 0.45, 0.09}, 4) == 15);     // highest
    CHECK(group_at({0.25, 0.12, 0.03}, 4) / 4 == 2);  // 3/4 of the way up
    CHECK(group_at({0.0, 0.35, 0}, 1) == 1 && group_at({0.2, 0.25, 0}, 1) == 2);
    const Vec3 d = fibre_direction(p, a.half);
    NEAR(d[0], -std::sqrt(0.5), 1e-15);  // back and outwards
    NEAR(d[1], std::sqrt(0.5), 1e-15);
    NEAR(d[2], 0, 1e-15);
    Random random(77);  // ramps wider than a layer
    const ActuatorRegion coarse(p, 0.15);
    for (int k = 0; k < 200; ++k) {
        const Vec3 x{random.uniform(-0.2, 0.4), random.uniform(0, 0.6), random.uniform(-0.15, 0.15)};
        double total = 0;
        for (int g = 0; g < 16; ++g) {
            const double share = coarse.group_share(x, a.half, 4, g / 4, g % 4);
            CHECK(share >= -1e-15);
            total += share;
        }
        NEAR(total, 1, 1e-14);
    }
}

void test_region_derivatives() {
    Random random(21);
    for (const Interpolation way : both) {
        const Vector x0 = row(interpolate_actuator({&first(), &second()}, {0.4, 0.6}, way));
        const ActuatorPoint p = point_of<ActuatorPoint>(x0);
        std::vector<Vec3> places;
        for (int k = 0; k < 200; ++k)
            places.push_back(
                from_local(p, {random.uniform(-0.35, 0.35), random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)}));
        const auto check_part =
            [&](const char* name, double ramp, const std::function<double(const ActuatorRegion&, const Vec3&)>& value,
                const std::function<void(const ActuatorRegion&, const Vec3&, double, ActuatorBar&)>& back) {
                derivative::Options options;
                options.step = options.taylor_step = 1e-3 * ramp;
                derivative::check_pullback(
                    name,
                    [&](const Vector& v) {
                        const ActuatorPoint q = point_of<ActuatorPoint>(v);
                        Vector out;
                        for (const Vec3& x : places) out.push_back(value(ActuatorRegion(q, ramp), x));
                        return out;
                    },
                    [&](const Vector& v, const Vector& bar) {
                        const ActuatorPoint q = point_of<ActuatorPoint>(v);
                        ActuatorBar sum;
                        for (std::size_t k = 0; k < places.size(); ++k)
                            back(ActuatorRegion(q, ramp), places[k], bar[k], sum);
                        return row(sum);
                    },
                    x0, options);
            };
        for (const double ramp : {0.1, 0.5}) {  // 0.5 is wider than the region: both sides of it count at once
            int within = 0;
            for (const Vec3& x : places) {
                const double value = ActuatorRegion(p, ramp).membership(x);
                within += value > 0.01 && value < 0.99;
            }
            CHECK(within > 20);
            check_part(
                "membership", ramp, [](const ActuatorRegion& r, const Vec3& x) { return r.membership(x); },
                [](const ActuatorRegion& r, const Vec3& x, double b, ActuatorBar& sum) {
                    r.membership_pullback(x, b, sum);
                });
            for (const ActuatorHalf half : {ActuatorHalf::left, ActuatorHalf::right})
                for (const int g : {0, 6, 11})
                    check_part(
                        "share of a group", ramp,
                        [&](const ActuatorRegion& r, const Vec3& x) { return r.group_share(x, half, 3, g / 4, g % 4); },
                        [&](const ActuatorRegion& r, const Vec3& x, double b, ActuatorBar& sum) {
                            r.group_share_pullback(x, half, 3, g / 4, g % 4, b, sum);
                        });
        }
        for (const ActuatorHalf half : {ActuatorHalf::left, ActuatorHalf::right})
            derivative::check_pullback(
                "direction of fibres",
                [&](const Vector& v) {
                    const Vec3 d = fibre_direction(point_of<ActuatorPoint>(v), half);
                    return Vector(d.begin(), d.end());
                },
                [&](const Vector& v, const Vector& bar) {
                    ActuatorBar sum;
                    fibre_direction_pullback(point_of<ActuatorPoint>(v), half, {bar[0], bar[1], bar[2]}, sum);
                    return row(sum);
                },
                x0);
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_smooth_step), TEST(test_interpolation_at_vertices),
        TEST(test_bures_box),   TEST(test_interpolation_derivative),
        TEST(test_mirror),      TEST(test_membership),
        TEST(test_groups),      TEST(test_region_derivatives),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
