// SPDX-License-Identifier: MIT
// Automatic muscles: where they are placed in shipped and simple shapes, and where none are.
#include "derivative_checks.hpp"
#include "shape/actuator_placement.hpp"
#include "shape/actuator_region.hpp"
#include "shape/mesh_file.hpp"
#include "shape/voxelize.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Vector;

void check_placement(const std::string& path, const Box& box, bool eel) {
    TriangleMesh mesh = clean_and_check(read_mesh_file(path), path, nullptr);
    orient_up(mesh, UP_AUTO);
    const auto f = covered_fractions(mesh, box, 2, 1, nullptr);
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
    const double half = std::sqrt(kTwoLn2 * a.variance[0]), back = a.mean[0] - half, front = a.mean[0] + half;
    CHECK(half > 0.02 * length);
    if (eel) {
        NEAR(back, tail + 0.4 * length, 1.01 * box.dx);
        NEAR(front, tail + 0.9 * length, 1.01 * box.dx);
    } else {
        CHECK(back >= tail + 0.08 * length - 1.01 * box.dx && back <= tail + 0.4 * length + 1.01 * box.dx);
        CHECK(front > back + 2 * box.dx - 1e-9 && front <= tail + 0.56 * length + box.dx);
        const auto section = [&](double x) {
            return area[static_cast<std::size_t>(std::floor(x / box.dx + 0.5 * box.cells[0] + 1e-6))];
        };
        for (double x = std::max(back, tail + 0.1 * length); x < tail + 0.38 * length; x += box.dx)
            CHECK(section(back) <= section(x) + 1e-12);
    }
    // Symmetric about y = 0, and around the body there: every covered cell of that stretch is a member.
    NEAR(a.mean[1], 0, 0);
    for (const double e : a.euler) NEAR(e, 0, 0);
    const ActuatorPoint point = interpolate_actuator({&a}, {1}, Interpolation::linear);
    const ActuatorRegion region(point, box.dx);
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
    for (const char* name : {"clownfish", "tuna", "eel_vertical", "eel_horizontal"})
        for (const Box& box : {Box{{40, 12, 20}, 0.05}, Box{{60, 16, 26}, 1.0 / 56}})
            check_placement(std::string(DQA_SHAPES_DIR "/") + name + ".stl", box, std::strstr(name, "eel") != nullptr);
}

void test_placement_without_body() {
    const Box box{{20, 8, 8}, 0.1};
    EXPECT_ERROR(ERROR_ARGUMENT, "no body found",
                 place_caudal(box, Vector(static_cast<std::size_t>(box.n_cells()), 0.0)));
}

// A body of revolution with a pair of flat fins as given: [x0, x1] x [y0, y1] x [z0, z1] in m, mirrored at y = 0.
Vector finned(const Box& box, const Vec3& body, double x0, double x1, double y0, double y1, double z0, double z1,
              bool both_sides = true) {
    Vector f(static_cast<std::size_t>(box.n_cells()), 0.0);
    for (int c = 0; c < box.n_cells(); ++c) {
        const Vec3 x = box.cell_centre(c);
        double r2 = 0;
        for (std::size_t k = 0; k < 3; ++k) r2 += x[k] * x[k] / (body[k] * body[k]);
        const double y = both_sides ? std::fabs(x[1]) : x[1];
        const bool fin = x[0] > x0 && x[0] < x1 && y > y0 && y < y1 && x[2] > z0 && x[2] < z1;
        f[static_cast<std::size_t>(c)] = r2 <= 1 || fin ? 1.0 : 0.0;
    }
    return f;
}

void test_fins() {
    const Box box{{40, 30, 16}, 0.05};
    const Vec3 body{0.9, 0.25, 0.3};
    const auto found = place_fins(box, finned(box, body, 0, 0.4, 0.1, 0.6, -0.1, 0.0));
    CHECK(found && found->kind == ActuatorKind::fins && found->half == ActuatorHalf::left && found->layers == 4);
    NEAR(found->mean[0], 0.2, 1e-12);
    NEAR(std::sqrt(kTwoLn2 * found->variance[0]), 0.2, 1e-12);
    // From beside the trunk to the tip.
    NEAR(found->mean[1] + std::sqrt(kTwoLn2 * found->variance[1]), 0.6, 1e-12);
    NEAR(found->mean[1] - std::sqrt(kTwoLn2 * found->variance[1]), 0.25, 0.11);
    NEAR(found->mean[2], -0.05, 1e-12);
    CHECK(found->variance[2] <= std::min(found->variance[0], found->variance[1]));
    for (const double e : found->euler) NEAR(e, 0, 0);
    // None: a plain body, stubs of a cell, one side only, a seam along the whole body, a sliver.
    CHECK(!place_fins(box, finned(box, body, 0, 0, 0, 0, 0, 0)));
    CHECK(!place_fins(box, finned(box, body, 0, 0.4, 0.1, 0.3, -0.1, 0.0)));
    CHECK(!place_fins(box, finned(box, body, 0, 0.4, 0.1, 0.6, -0.1, 0.0, false)));
    CHECK(!place_fins(box, finned(box, body, -0.9, 0.9, 0.1, 0.6, -0.1, 0.0)));
    CHECK(!place_fins(box, finned(box, body, 0, 0.05, 0.1, 0.6, -0.05, 0.0)));
    // A flat fish: its wings are what is wider than it is high.
    CHECK(place_fins(box, finned(box, {0.9, 0.2, 0.12}, -0.3, 0.5, 0.1, 0.7, -0.05, 0.05)).has_value());
    CHECK(!place_fins(box, Vector(static_cast<std::size_t>(box.n_cells()), 0.0)));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_placement),
        TEST(test_placement_without_body),
        TEST(test_fins),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
