// SPDX-License-Identifier: MIT
// Head, centre and tail sensors: where they sit, that they move smoothly with the density, and their derivatives.
#include "density_fixtures.hpp"
#include "derivative_checks.hpp"
#include "motion/sensors.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Random;
using derivative::Vector;

const Box box{{24, 6, 8}, 0.1};

ActiveSet active(const Box& of, const Vector& p_hat, double threshold) {
    std::vector<char> mask;
    for (const double p : p_hat) mask.push_back(p > threshold);
    return make_active_set(of, mask);
}

Vector sampled(const std::function<double(const Vec3&)>& value) {
    Vector out;
    for (int c = 0; c < box.n_cells(); ++c) out.push_back(value(box.cell_centre(c)));
    return out;
}

// A body from `tail` to `head` (m) whose density falls linearly from `top` to zero over four cells at its ends.
Vector bar_of(double tail, double head, double top = 1.0) {
    return sampled([&](const Vec3& x) {
        const double along = std::min({1.0, (head - x[0]) / 0.4 + 0.5, (x[0] - tail) / 0.4 + 0.5});
        return std::fabs(x[1]) < 0.2 && std::fabs(x[2]) < 0.3 ? top * std::max(0.0, along) : 0.0;
    });
}

// Without any symmetry or flat part, so that every term of a derivative counts.
Vector bumpy(std::uint64_t seed, double top = 1.0) {
    Random random(seed);
    Vector p = soft_ellipsoid(box.cells, {12.2, 3.1, 3.8}, {8.3, 2.2, 2.9});
    for (double& x : p) x *= top * random.uniform(0.85, 1.0);
    return p;
}

Vector deformed(const ActiveSet& set, std::uint64_t seed) {
    Random random(seed);
    Vector q = set.rest_positions();
    for (double& x : q) x += random.uniform(-0.03, 0.03);
    return q;
}

void test_places() {
    for (const double tail : {-0.9, -0.83, -0.75})
        for (const double head : {0.6, 0.637, 0.84}) {
            const Vector p = bar_of(tail, head);
            const ActiveSet set = active(box, p, 0.02);
            const Sensors s(set, p, 0.0, 0.0);
            // Linear between cells, linear density: the half crossings are exact.
            NEAR(s.point(Sensors::head).rest[0], head, 1e-12);
            NEAR(s.point(Sensors::tail).rest[0], tail, 1e-12);
            NEAR(s.point(Sensors::centre).rest[0], 0, 0);
            const Vector rest = set.rest_positions();
            for (const int which : {Sensors::head, Sensors::centre, Sensors::tail}) {
                const Vec3 x = s.read(which, rest.data());
                for (std::size_t k = 0; k < 3; ++k) NEAR(x[k], s.point(which).rest[k], 1e-14);
                NEAR(std::accumulate(s.point(which).weight.begin(), s.point(which).weight.end(), 0.0), 1, 1e-14);
            }
            const Vec3 d = s.direction(rest.data());
            NEAR(d[0], 1, 1e-12);
            NEAR(std::hypot(d[1], d[2]), 0, 1e-12);
        }
    // Trilinear: a field that is linear in the rest position is read exactly, anywhere.
    const Vector p = bumpy(1);
    const ActiveSet set = active(box, p, 0.02);
    const Sensors s(set, p, 0.07, -0.04);
    Vector field = set.rest_positions();
    for (std::size_t n = 0; n < field.size(); n += 3)
        field[n] = 2 * field[n] - field[n + 1] + 3 * field[n + 2] + 1, field[n + 1] = 7;
    for (const int which : {Sensors::head, Sensors::centre, Sensors::tail}) {
        const Vec3 x = s.point(which).rest, value = s.read(which, field.data());
        NEAR(x[1], 0.07, 0);
        NEAR(x[2], -0.04, 0);
        NEAR(value[0], 2 * x[0] - x[1] + 3 * x[2] + 1, 1e-13);
        NEAR(value[1], 7, 1e-13);
    }
}

void test_crossing_at_the_wall() {
    // Outside of the box there is nothing: a body up to its ends crosses half of its peak right there.
    const Vector p = sampled([](const Vec3&) { return 1.0; });
    const ActiveSet set = active(box, p, 0.02);
    const Sensors s(set, p, 0.0, 0.0);
    NEAR(s.point(Sensors::head).rest[0], 1.2, 1e-12);
    NEAR(s.point(Sensors::tail).rest[0], -1.2, 1e-12);
    NEAR(s.read(Sensors::head, set.rest_positions().data())[0], 1.2, 1e-12);
}

void test_moves_smoothly() {
    // A body that slides over three cells in small steps: the sensors follow, without a jump at any cell.
    double last_head = 0, last_tail = 0;
    for (int k = 0; k <= 300; ++k) {
        const double by = 0.001 * k;
        const Vector p = sampled([&](const Vec3& x) {
            const double r = std::hypot((x[0] - by) / 0.8, x[1] / 0.25, x[2] / 0.35);
            return 1 / (1 + std::exp(8 * (r - 1)));
        });
        const ActiveSet set = active(box, p, 0.02);
        const Sensors s(set, p, 0.0, 0.0);
        const Vector rest = set.rest_positions();
        const double head = s.read(Sensors::head, rest.data())[0], tail = s.read(Sensors::tail, rest.data())[0];
        if (k > 0) {
            NEAR(head - last_head, 0.001, 3e-4);
            NEAR(tail - last_tail, 0.001, 3e-4);
        }
        last_head = head, last_tail = tail;
    }
}

void check_places(const Vector& p, double y, double z) {
    const ActiveSet set = active(box, p, 0.02);
    derivative::Options options;
    options.step = options.taylor_step = 1e-3;
    derivative::check_pullback(
        "places",
        [&](const Vector& x) {
            const Sensors s(set, x, y, z);
            return Vector{s.point(Sensors::head).rest[0], s.point(Sensors::tail).rest[0]};
        },
        [&](const Vector& x, const Vector& bar) {
            Vector out(x.size(), 0.0);
            Sensors(set, x, y, z).place_pullback(bar[0], bar[1], out.data());
            return out;
        },
        p, options);
}

void test_place_derivative() {
    check_places(bumpy(2), 0.0, 0.0);
    check_places(bumpy(3), 0.03, -0.08);
    check_places(bumpy(4, 0.6), 0.03, -0.08);  // thin: the level follows the largest value on the line
    check_places(bumpy(5), 0.05, 0.05);        // through cell centres: one row of cells alone
}

void test_thin_body() {
    // Half of the peak is not reached on the line, or barely: two thirds of what is there.
    for (const double top : {0.7, 0.5, 0.2, 0.05}) {
        const Vector p = bar_of(-0.83, 0.637, top);
        const Sensors s(active(box, p, 0.02), p, 0.0, 0.0);
        NEAR(s.point(Sensors::head).rest[0], 0.637 - 0.4 / 6, 1e-12);
        NEAR(s.point(Sensors::tail).rest[0], -0.83 + 0.4 / 6, 1e-12);
    }
    // Where the rule changes nothing jumps.
    const Vector above = bar_of(-0.83, 0.637, 0.75 + 1e-9), below = bar_of(-0.83, 0.637, 0.75 - 1e-9);
    NEAR(Sensors(active(box, above, 0.02), above, 0, 0).point(Sensors::head).rest[0],
         Sensors(active(box, below, 0.02), below, 0, 0).point(Sensors::head).rest[0], 1e-8);
    const Vector p = bar_of(-0.8, 0.6);
    const ActiveSet set = active(box, p, 0.02);
    EXPECT_ERROR(ERROR_ARGUMENT, "misses the body", Sensors(set, p, 0.29, 0.0));
}

// direction() of a deformed body as a function of the nodes, and of the density through the places of the sensors.
void test_direction_derivative() {
    const Vector p = bumpy(6);
    const ActiveSet set = active(box, p, 0.02);
    const Vector q = deformed(set, 7);
    const auto back = [&](const Vector& density, const Vector& nodes, const Vector& bar, bool to_nodes) {
        const Sensors s(set, density, 0.02, -0.03);
        Vector q_bar(nodes.size(), 0.0), p_bar(density.size(), 0.0);
        double head = 0, tail = 0;
        s.direction_pullback(nodes.data(), {bar[0], bar[1], bar[2]}, q_bar.data(), head, tail);
        s.place_pullback(head, tail, p_bar.data());
        return to_nodes ? q_bar : p_bar;
    };
    const auto direction = [&](const Vector& density, const Vector& nodes) {
        const Vec3 d = Sensors(set, density, 0.02, -0.03).direction(nodes.data());
        NEAR(std::hypot(d[0], d[1], d[2]), 1, 1e-12);
        return Vector(d.begin(), d.end());
    };
    derivative::check_pullback(
        "direction by nodes", [&](const Vector& x) { return direction(p, x); },
        [&](const Vector& x, const Vector& bar) { return back(p, x, bar, true); }, q);
    derivative::Options options;
    options.step = options.taylor_step = 3e-3;
    derivative::check_pullback(
        "direction by density", [&](const Vector& x) { return direction(x, q); },
        [&](const Vector& x, const Vector& bar) { return back(x, q, bar, false); }, p, options);
}

void test_read_derivative() {
    const Vector p = bumpy(8);
    const ActiveSet set = active(box, p, 0.02);
    const Sensors s(set, p, 0.02, -0.03);
    derivative::Options options;
    options.affine = true;
    for (const int which : {Sensors::head, Sensors::centre, Sensors::tail})
        derivative::check_pullback(
            "read",
            [&](const Vector& x) {
                const Vec3 v = s.read(which, x.data());
                return Vector(v.begin(), v.end());
            },
            [&](const Vector& x, const Vector& bar) {
                Vector out(x.size(), 0.0);
                s.read_pullback(which, {bar[0], bar[1], bar[2]}, out.data());
                return out;
            },
            deformed(set, 9), options);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_places),    TEST(test_crossing_at_the_wall), TEST(test_moves_smoothly),  TEST(test_place_derivative),
        TEST(test_thin_body), TEST(test_direction_derivative), TEST(test_read_derivative),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
