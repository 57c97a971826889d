// SPDX-License-Identifier: MIT
// Bases of a plane space from polygons and images: exact areas, scaling and centring, orientation, and what is refused;
// and actuators in the plane.
#include "derivative_checks.hpp"
#include "shape/actuator_region.hpp"
#include "shape/planar_base.hpp"
#include "shape/shape_space.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Random;
using derivative::Vector;
using Polygon = std::vector<std::array<double, 2>>;

Box plane(int nx, int ny) {
    Box box{{nx, ny, 1}, 0.05};
    box.dims = 2;
    return box;
}

void check_centred(const Box& box, const Vector& f, double tolerance) {
    double x = 0, y = 0;
    for (int c = 0; c < box.n_cells(); ++c) {
        x += f[static_cast<std::size_t>(c)] * box.cell_centre(c)[0] / box.dx;
        y += f[static_cast<std::size_t>(c)] * box.cell_centre(c)[1] / box.dx;
    }
    NEAR(x / sum(f), 0, tolerance);
    NEAR(y / sum(f), 0, tolerance);
}

void test_rectangle() {
    const Box box = plane(12, 8);
    double length = 0;
    // 5 x 2, to fit 8 cells of the 12: 8 x 3.2 cells, whose last row is covered by 0.6.
    const Vector f = polygon_fractions({{10, 3}, {15, 3}, {15, 5}, {10, 5}}, box, {2, 1}, &length);
    NEAR(length, 8, 1e-13);
    NEAR(sum(f), 8 * 3.2, 1e-12);
    for (int i = 0; i < 12; ++i)
        for (int j = 0; j < 8; ++j) {
            const double expected = i < 2 || i > 9 ? 0 : j == 3 || j == 4 ? 1 : j == 2 || j == 5 ? 0.6 : 0;
            NEAR(f[static_cast<std::size_t>(box.cell(i, j, 0))], expected, 1e-13);
        }
    // The other sense of rotation, and far from the origin.
    CHECK(largest_difference(f, polygon_fractions({{10, 5}, {15, 5}, {15, 3}, {10, 3}}, box, {2, 1}, nullptr)) < 1e-13);
    CHECK(largest_difference(f, polygon_fractions({{1e6, 3e6}, {1e6 + 5, 3e6}, {1e6 + 5, 3e6 + 2}, {1e6, 3e6 + 2}}, box,
                                                  {2, 1}, nullptr)) < 1e-8);
}

// A star-shaped body, and its cells against a fine count of points.
void test_areas() {
    Random random(4);
    Polygon p;
    for (int k = 0; k < 40; ++k) {
        const double t = 2 * pi * k / 40, r = random.uniform(0.5, 1.0);
        p.push_back({2 * r * std::cos(t), r * std::sin(t)});
    }
    const Box box = plane(24, 14);
    double length = 0, area = 0;
    const Vector f = polygon_fractions(p, box, {2, 1}, &length);
    for (std::size_t i = 0; i < p.size(); ++i) {
        const auto &a = p[i], &b = p[(i + 1) % p.size()];
        area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
    }
    double lo = 0, hi = 0;
    for (const auto& c : p) lo = std::min(lo, c[0]), hi = std::max(hi, c[0]);
    const double scale = length / (hi - lo);
    NEAR(sum(f), area * scale * scale, 1e-11);
    for (const double v : f) CHECK(v >= 0 && v <= 1);
    for (int j = 0; j < 14; ++j) CHECK(f[static_cast<std::size_t>(box.cell(1, j, 0))] == 0);  // the margin stays empty
    // Refining the box by 5 gives the same areas: cell by cell where nothing is approximated.
    Box fine = plane(120, 70);
    const Vector g = polygon_fractions(p, fine, {10, 5}, nullptr);
    for (int c = 0; c < box.n_cells(); ++c) {
        const auto ijk = box.cell_ijk(c);
        double mean = 0;
        for (int a = 0; a < 25; ++a)
            mean += g[static_cast<std::size_t>(fine.cell(5 * ijk[0] + a / 5, 5 * ijk[1] + a % 5, 0))] / 25;
        NEAR(f[static_cast<std::size_t>(c)], mean, 1e-12);
    }
    check_centred(plane(240, 140), polygon_fractions(p, plane(240, 140), {2, 1}, nullptr), 2e-3);
    // A mirrored polygon gives mirrored cells.
    Polygon q = p;
    for (auto& c : q) c[1] = -c[1];
    CHECK(largest_difference(mirrored(box, f, 1), polygon_fractions(q, box, {2, 1}, nullptr)) < 1e-12);
}

void test_bad_polygons() {
    const Box box = plane(12, 8);
    const auto refused = [&](const Polygon& p, const char* part) {
        EXPECT_ERROR(ERROR_ARGUMENT, part, polygon_fractions(p, box, {2, 1}, nullptr));
    };
    refused({{0, 0}, {1, 0}}, "2 corners");
    refused({{0, 0}, {1, 0}, {std::nan(""), 1}}, "corner 2");
    refused({{0, 0}, {1, 0}, {1, 0}, {0, 1}}, "corners 1 and 2");
    refused({{0, 0}, {1, 0}, {1, 1}, {0, 0}}, "without repeating");
    refused({{0, 0}, {1, 1}, {1, 0}, {0, 1}}, "edges 0 and 2");
    refused({{0, 0}, {2, 0}, {2, 1}, {1, 0}, {0, 1}}, "edges 0 and 2");  // a corner on an edge
    refused({{0, 0}, {2, 0}, {1, 0}, {1, 1}}, "runs back");
    refused({{0, 0}, {1, 0}, {2, 0}}, "back on itself");
}

void test_images() {
    const Box box = plane(12, 8);
    // A fish of 4 x 2 pixels with empty ones around it; two pixels of it are half grey, at the picture's upper right.
    const Vector pixels = {0, 0, 0, 0,   0,   0,  //
                           0, 1, 1, 0.5, 0.5, 0,  //
                           0, 1, 1, 1,   1,   0};
    double length = 0;
    const Vector f = image_fractions(pixels.data(), 3, 6, box, {2, 1}, &length);
    const double scale = length / 4;
    NEAR(sum(f), 7 * scale * scale, 1e-12);
    check_centred(plane(12, 8), f, 0.2);
    double left = 0, right = 0, ahead = 0, behind = 0;
    for (int c = 0; c < box.n_cells(); ++c) {
        const Vec3 x = box.cell_centre(c);
        (x[1] > 0 ? left : right) += f[static_cast<std::size_t>(c)];
        (x[0] > 0 ? ahead : behind) += f[static_cast<std::size_t>(c)];
    }
    int tail = 12, head = 0;
    for (int i = 0; i < 12; ++i)
        for (int j = 0; j < 8; ++j)
            if (f[static_cast<std::size_t>(box.cell(i, j, 0))] > 1e-9)
                tail = std::min(tail, i), head = std::max(head, i);
    // The half-grey part is light: the centre of mass lies behind and below the middle, so the body reaches further
    // ahead and up.
    CHECK(head - 5.5 >= 5.5 - tail && head <= 9 && tail >= 2);
    // A fine image of a polygon's inside agrees with the polygon.
    const int rows = 300, columns = 700;
    Vector ellipse(static_cast<std::size_t>(rows * columns), 0.0);
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
            const double x = (c + 0.5 - 350) / 330, y = (150 - r - 0.5) / 140;
            if (x * x + y * y < 1 && x < 0.8) ellipse[static_cast<std::size_t>(r * columns + c)] = 1.0;
        }
    Polygon outline;
    const double end = std::acos(0.8);
    for (int k = 0; k <= 400; ++k) {
        const double t = end + (2 * pi - 2 * end) * k / 400;
        outline.push_back({330 * std::cos(t), 140 * std::sin(t)});
    }
    const Box fine = plane(40, 20);
    const Vector a = image_fractions(ellipse.data(), rows, columns, fine, {2, 1}, nullptr),
                 b = polygon_fractions(outline, fine, {2, 1}, nullptr);
    CHECK(largest_difference(a, b) < 0.03);
    NEAR(sum(a), sum(b), 0.005 * sum(b));
    EXPECT_ERROR(ERROR_ARGUMENT, "no pixel", image_fractions(Vector(6, 0.4).data(), 2, 3, box, {2, 1}, nullptr));
    EXPECT_ERROR(ERROR_ARGUMENT, "pixels[1][2] is 1.5",
                 image_fractions(Vector{0, 1, 1, 0, 1, 1.5}.data(), 2, 3, box, {2, 1}, nullptr));
    EXPECT_ERROR(ERROR_ARGUMENT, "no room", image_fractions(pixels.data(), 3, 6, box, {6, 1}, nullptr));
}

// A flat swimmer with a tail muscle and a pair of fins of one layer.
void test_plane_space() {
    ShapeSettings s;
    s.dims = 2, s.cells = {30, 16, 1}, s.cell_size = 0.04, s.sigma = 0.7;
    ShapeSpace space(s);
    const Polygon fish{{-10, 0}, {-9, -1.5}, {-4, -1}, {0, -2}, {2, -6}, {4, -6}, {4, -2.2}, {8, -1},
                       {9, 0},   {8, 1},     {4, 2.2}, {4, 6},  {2, 6},  {0, 2},  {-4, 1},   {-9, 1.5}};
    CHECK(space.add_polygon("fish", fish) == 0);
    const Vector pixels(8, 1.0);
    CHECK(space.add_image("bar", pixels.data(), 2, 4) == 1);
    Actuator a;
    a.kind = ActuatorKind::fins, a.category = 1, a.layers = 4;
    a.mean = {0, 0.15, 7}, a.variance = {0.01, 0.01, 1};
    EXPECT_ERROR(ERROR_ARGUMENT, "layers is 4, expected 1", space.add_actuator(0, a));
    a.layers = 1, a.euler[1] = 0.1;
    EXPECT_ERROR(ERROR_ARGUMENT, "expected (0, 0, angle)", space.add_actuator(0, a));
    a.euler = {0, 0, 0.2};
    space.add_actuator(0, a);
    space.build(nullptr);
    CHECK(space.n_signals() == 5);
    const ShapePoint p = space.evaluate({0.7, 0.3}, 0, 0, nullptr);
    for (const ActuatorPoint& q : p.actuators) {
        NEAR(q.mean[2], 0, 0);
        NEAR(ActuatorRegion(q, space.box().dx).membership(q.mean), 1, 1e-12);  // whole through the plane's thickness
    }
    s.automatic_fins = true;
    ShapeSpace automatic(s);
    automatic.add_polygon("fish", fish);
    automatic.build(nullptr);
    CHECK(automatic.n_signals() == 5 && automatic.bases()[0].actuators.size() == 3);
    const Actuator& fin = automatic.bases()[0].actuators[1];
    CHECK(fin.half == ActuatorHalf::left && fin.layers == 1 && fin.mean[1] > 0.05 && fin.mean[0] > 0);
    ShapeSettings solid;
    ShapeSpace three(solid);
    EXPECT_ERROR(ERROR_ARGUMENT, "expected 2", three.add_polygon("fish", fish));
    EXPECT_ERROR(ERROR_ARGUMENT, "expected 2", three.add_image("bar", pixels.data(), 2, 4));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_rectangle), TEST(test_areas), TEST(test_bad_polygons), TEST(test_images), TEST(test_plane_space),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
