// SPDX-License-Identifier: MIT
// Covered fractions against volumes that are known: thin parts in any position, components that nest, touch, overlap or
// pass through themselves, coinciding faces. Every cell counts, not just the sum.
#include <array>

#include "grid/random.hpp"
#include "shape/vector.hpp"
#include "shape/voxelize.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;

std::size_t idx(int i) {
    return static_cast<std::size_t>(i);
}

using Rotation = std::array<Vec3, 3>;

Vec3 turned(const Rotation& r, const Vec3& x) {
    return {dot(r[0], x), dot(r[1], x), dot(r[2], x)};
}

Rotation random_rotation(Random& random) {
    Vec3 a{random(), random(), random()}, b{random(), random(), random()};
    a = scaled(a, 1.0 / norm(a));
    b = minus(b, scaled(a, dot(a, b)));
    b = scaled(b, 1.0 / norm(b));
    return {a, b, cross(a, b)};
}

TriangleMesh turned(const Rotation& r, TriangleMesh mesh) {
    for (Vec3& v : mesh.vertices) v = turned(r, v);
    return mesh;
}

TriangleMesh moved(TriangleMesh mesh, const Vec3& by) {
    for (Vec3& v : mesh.vertices) v = plus(v, by);
    return mesh;
}

TriangleMesh inside_out(TriangleMesh mesh) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

TriangleMesh random_tetrahedron(Random& random, double size) {
    TriangleMesh m;
    for (int k = 0; k < 4; ++k) m.vertices.push_back({size * random(), size * random(), size * random()});
    m.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
    return mesh_volume(m) > 0 ? m : inside_out(m);
}

struct Covered {
    Box box;
    std::vector<double> fractions;
    double scale = 0.0;  // cells per unit of the mesh
    double volume() const { return sum(fractions); }
    double per_volume() const { return scale * scale * scale; }
};

Covered cover(const TriangleMesh& mesh, const std::array<int, 3>& cells, int margin = 1) {
    const TriangleMesh cleaned = clean_and_check(mesh, "test", nullptr);
    double lo = 1e300, hi = -1e300, length = 0.0;
    for (const Vec3& v : cleaned.vertices) lo = std::min(lo, v[0]), hi = std::max(hi, v[0]);
    Covered out{{cells, 1.0}, {}, 0.0};
    out.fractions = covered_fractions(cleaned, out.box, margin, 1, &length);
    out.scale = length / (hi - lo);
    for (const double f : out.fractions) CHECK(f >= 0.0 && f <= 1.0);
    return out;
}

// A mesh together with its image through the origin: whatever overlaps, the centre of mass is the origin.
TriangleMesh with_image(const TriangleMesh& mesh) {
    TriangleMesh both = mesh, image = mesh;
    for (Vec3& v : image.vertices) v = scaled(v, -1.0);
    append(both, inside_out(image));
    return both;
}

// Every cell of `c` against the mean of `inside` over points of the cell. The mesh has its centre of mass at the
// origin.
template <class Inside>
void check_by_sampling(const Covered& c, const Inside& inside, int points, double tolerance) {
    double total = 0.0;
    for (int cell = 0; cell < c.box.n_cells(); ++cell) {
        const Vec3 centre = c.box.cell_centre(cell);
        int covered = 0;
        for (int p = 0; p < points * points * points; ++p) {
            const Vec3 offset{(p / (points * points) + 0.5) / points - 0.5, (p / points % points + 0.5) / points - 0.5,
                              (p % points + 0.5) / points - 0.5};
            covered += inside(scaled(plus(centre, offset), 1.0 / c.scale));
        }
        const double expected = covered / std::pow(points, 3);
        NEAR(c.fractions[idx(cell)], expected, tolerance);
        total += expected;
    }
    NEAR(c.volume() / total, 1, 0.2 * tolerance);
}

// Winding number by the angle that all triangles cover (van Oosterom and Strackee 1983).
int winding(const TriangleMesh& mesh, const Vec3& x) {
    double angle = 0.0;
    for (const auto& t : mesh.triangles) {
        const Vec3 a = minus(mesh.vertices[idx(t[0])], x), b = minus(mesh.vertices[idx(t[1])], x),
                   c = minus(mesh.vertices[idx(t[2])], x);
        const double la = norm(a), lb = norm(b), lc = norm(c);
        angle += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return static_cast<int>(std::lround(angle / (4 * pi)));
}

// ---------------------------------------------------------------- thin parts

// A trunk and, not touching it, a fin: its section tells how thick the fin is.
void test_fins_on_the_middle_plane() {
    for (const double thickness : {0.05, 0.1, 0.12, 0.13, 0.25, 0.37, 0.38, 0.5, 0.62, 0.9, 1.0, 1.5, 2.0})
        for (const double offset : {0.0, 0.11, 0.5}) {
            TriangleMesh fish = cuboid({0, -3, -4}, {18, 6, 8});
            append(fish, cuboid({-12, offset - thickness / 2, -4}, {11, thickness, 8}));
            const Covered c = cover(fish, {40, 16, 24}, 2);
            double section = 0;
            for (int k = 0; k < c.box.cells[1] * c.box.cells[2]; ++k) section += c.fractions[idx(5 * 16 * 24 + k)];
            NEAR(section / (8 * thickness * c.scale * c.scale), 1, 1e-9);
            NEAR(c.volume() / (mesh_volume(fish) * c.per_volume()), 1, 1e-12);
        }
}

// Plates at random angles, in rows of cells that they cross in all ways. A cell's fraction is that of a slab.
void test_plates_at_any_angle() {
    Random random{11};
    for (const double thickness : {0.05, 0.07, 0.13, 0.3, 1.0, 2.0})
        for (int round = 0; round < 6; ++round) {
            const Rotation r = random_rotation(random);
            // In units of cells, as the box fits the scale by half a cell or so at most: the length is given back.
            const TriangleMesh plate = turned(r, cuboid({-7, -6, -thickness / 2}, {14, 12, thickness}));
            const Covered c = cover(plate, {24, 24, 24}, 2);
            NEAR(c.volume() / (14 * 12 * thickness * c.per_volume()), 1, 1e-12);
            const Vec3 normal{r[0][2], r[1][2], r[2][2]};
            const double t = thickness * c.scale;
            for (int cell = 0; cell < c.box.n_cells(); ++cell) {
                const Vec3 x = c.box.cell_centre(cell);
                if (norm(x) > 3) continue;
                // Volume of the cube below height h over the plane through its centre, by inclusion and exclusion over
                // its corners (Barrow and Smith 1979).
                const auto below = [&](double h) {
                    double value = 0;
                    for (int corner = 0; corner < 8; ++corner) {
                        double height = h - dot(normal, x), sign = 1;
                        for (std::size_t a = 0; a < 3; ++a) {
                            const double side = (corner >> a & 1) ? 0.5 : -0.5;
                            height -= normal[a] * side, sign *= side > 0 ? -1 : 1;
                        }
                        value += sign * std::pow(std::max(0.0, height), 3);
                    }
                    return value / (6 * normal[0] * normal[1] * normal[2]);
                };
                NEAR(c.fractions[idx(cell)], below(t / 2) - below(-t / 2), 1e-8);
            }
        }
}

void test_random_tetrahedra() {
    Random random{12};
    for (int round = 0; round < 100; ++round) {
        const TriangleMesh m = random_tetrahedron(random, 5);
        const Covered c = cover(m, {20, 14, 17});
        NEAR(c.volume() / (mesh_volume(m) * c.per_volume()), 1, 1e-9);
    }
}

void test_ellipsoids() {
    for (const Vec3& radius : {Vec3{3, 1, 1}, Vec3{3, 0.02, 1}, Vec3{1, 2, 0.03}}) {
        const TriangleMesh m = ellipsoid(radius, 48, 24);
        const Covered c = cover(m, {30, 26, 24});
        NEAR(c.volume() / (mesh_volume(m) * c.per_volume()), 1, 1e-11);
        for (int axis = 0; axis < 3; ++axis)
            NEAR(largest_difference(c.fractions, mirrored(c.box, c.fractions, axis)), 0, 1e-11);
    }
}

// The mirror image of a mesh without symmetry has the mirrored fractions.
void test_mirror_images() {
    Random random{13};
    for (int round = 0; round < 10; ++round) {
        TriangleMesh m = random_tetrahedron(random, 4);
        append(m, random_tetrahedron(random, 4));
        append(m, cuboid({-1, -1, -1}, {3, 1, 2}));
        const Covered c = cover(m, {18, 15, 16});
        for (std::size_t axis = 0; axis < 3; ++axis) {
            TriangleMesh image = m;
            for (Vec3& v : image.vertices) v[axis] = -v[axis];
            const Covered d = cover(inside_out(image), {18, 15, 16});
            NEAR(largest_difference(d.fractions, mirrored(c.box, c.fractions, static_cast<int>(axis))), 0, 1e-12);
        }
    }
}

// ---------------------------------------------------------------- components

// Cuboids with corners on a coarse lattice share faces, edges and corners in all ways. Their union is a union of small
// cuboids between lattice planes, whose overlaps with each cell are exact.
void check_lattice_cuboids(Random& random, int count, int lattice) {
    const auto position = [&] { return static_cast<int>(std::floor((random() + 1) * 0.5 * (lattice + 1))); };
    std::vector<std::array<std::array<int, 2>, 3>> cuboids;
    TriangleMesh mesh;
    while (static_cast<int>(cuboids.size()) < count) {
        std::array<std::array<int, 2>, 3> c;
        bool flat = false;
        for (auto& side : c) {
            side = {position(), position()};
            if (side[0] > side[1]) std::swap(side[0], side[1]);
            flat = flat || side[0] == side[1];
        }
        if (flat) continue;
        cuboids.push_back(c);
        append(mesh, cuboid({double(c[0][0]), double(c[1][0]), double(c[2][0])},
                            {double(c[0][1] - c[0][0]), double(c[1][1] - c[1][0]), double(c[2][1] - c[2][0])}));
    }
    std::vector<Vec3> covered;  // lower corners of unit cubes
    Vec3 centre{0, 0, 0};
    for (int p = 0; p < lattice * lattice * lattice; ++p) {
        const std::array<int, 3> x{p / (lattice * lattice), p / lattice % lattice, p % lattice};
        const auto holds = [&](const auto& c) {
            bool in = true;
            for (std::size_t a = 0; a < 3; ++a) in = in && c[a][0] <= x[a] && x[a] < c[a][1];
            return in;
        };
        if (!std::any_of(cuboids.begin(), cuboids.end(), holds)) continue;
        covered.push_back({double(x[0]), double(x[1]), double(x[2])});
        for (std::size_t a = 0; a < 3; ++a) centre[a] += x[a] + 0.5;
    }
    centre = scaled(centre, 1.0 / static_cast<double>(covered.size()));
    const Covered c = cover(mesh, {13, 12, 11});
    std::vector<double> expected(c.fractions.size(), 0.0);
    for (const Vec3& lower : covered) {
        std::array<std::array<double, 2>, 3> side;
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t end = 0; end < 2; ++end)
                side[a][end] = (lower[a] + double(end) - centre[a]) * c.scale + 0.5 * c.box.cells[a];
        for (int cell = 0; cell < c.box.n_cells(); ++cell) {
            const auto ijk = c.box.cell_ijk(cell);
            double overlap = 1.0;
            for (std::size_t a = 0; a < 3; ++a)
                overlap *= std::max(0.0, std::min(side[a][1], ijk[a] + 1.0) - std::max(side[a][0], double(ijk[a])));
            expected[idx(cell)] += overlap;
        }
    }
    NEAR(largest_difference(c.fractions, expected), 0, 1e-7);
}

void test_cuboids_that_touch_and_overlap() {
    Random random{21};
    for (int round = 0; round < 60; ++round) check_lattice_cuboids(random, 2 + round % 6, 3 + round % 3);
}

// The same turned: faces that coincide do so but for rounding.
void test_turned_cuboids() {
    Random random{25};
    for (int round = 0; round < 30; ++round) {
        const Rotation r = random_rotation(random);
        TriangleMesh blocks;  // three in a row with whole faces in common, and one that reaches through them all
        for (int k = 0; k < 3; ++k) append(blocks, cuboid({-3.0 + 2 * k, -1, -1}, {2, 2, 2}));
        append(blocks, cuboid({-3, -0.5, -1}, {6, 1, 2 + 0.5 * (round % 3)}));
        const Covered c = cover(turned(r, blocks), {16, 16, 16});
        NEAR(c.volume() / c.per_volume(), 24 + 6 * 0.5 * (round % 3), 1e-5);
    }
}

// Slanted slabs, tetrahedra and cuboids through one another.
void test_overlap_by_sampling() {
    Random random{22};
    for (int round = 0; round < 4; ++round) {
        const Rotation r = random_rotation(random), s = random_rotation(random);
        TriangleMesh m = moved(turned(r, cuboid({-3, -2, -0.2}, {6, 4, 0.4})), {0.5, 0.4, 0.3});
        append(m, turned(s, cuboid({-2, -1, -1}, {4, 2, 2})));
        append(m, random_tetrahedron(random, 3));
        m = with_image(m);
        const Covered c = cover(m, {12, 12, 12});
        check_by_sampling(
            c, [&](const Vec3& x) { return winding(m, x) > 0; }, 5, 0.17);
    }
}

// One component that passes through itself many times, with parts that are wound twice, or inside out.
void test_self_intersection_by_sampling() {
    Random random{23};
    for (int round = 0; round < 4; ++round) {
        TriangleMesh m = ellipsoid({2, 2, 2}, 6, 4);
        for (Vec3& v : m.vertices) v = plus(v, {1.6 * random(), 1.6 * random(), 1.6 * random()});
        if (mesh_volume(m) < 0) m = inside_out(m);
        m = with_image(m);
        const Covered c = cover(m, {11, 11, 11});
        check_by_sampling(
            c, [&](const Vec3& x) { return winding(m, x) > 0; }, 5, 0.17);
    }
}

// The same body several times, shifted by less than anything that matters: the body once. As many float files hold it.
void test_repeated_bodies() {
    Random random{24};
    for (const double shift : {0.0, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5})
        for (int round = 0; round < 3; ++round) {
            const Rotation r = random_rotation(random);
            const TriangleMesh body =
                round == 0 ? cuboid({-2, -1, -1}, {4, 2, 2}) : turned(r, ellipsoid({2, 1, 1}, 12, 8));
            const Covered once = cover(body, {20, 20, 20}, 2);
            TriangleMesh several = body;
            for (int copy = 0; copy < 2; ++copy) {
                TriangleMesh again = body;
                for (Vec3& v : again.vertices) v = plus(v, {shift * random(), shift * random(), shift * random()});
                append(several, again);
            }
            NEAR(largest_difference(cover(several, {20, 20, 20}, 2).fractions, once.fractions), 0, 1e-5 + 20 * shift);
        }
}

void test_nested_shells() {
    const TriangleMesh outer = ellipsoid({3, 2, 2}, 32, 16), inner = ellipsoid({2, 1, 1}, 32, 16),
                       innermost = ellipsoid({1, 0.5, 0.5}, 32, 16);
    const double v1 = mesh_volume(outer), v2 = mesh_volume(inner), v3 = mesh_volume(innermost);
    const auto volume = [&](const TriangleMesh& b, const TriangleMesh& c) {
        TriangleMesh m = outer;
        append(m, b), append(m, c);
        const Covered covered = cover(m, {26, 20, 20});
        return covered.volume() / covered.per_volume();
    };
    NEAR(volume(inner, innermost), v1, 1e-9);                               // bodies in a body
    NEAR(volume(inside_out(inner), innermost), v1 - v2 + v3, 1e-9);         // a body in a hollow
    NEAR(volume(inside_out(inner), inside_out(innermost)), v1 - v2, 1e-9);  // nothing less than empty
    NEAR(volume(inner, inside_out(innermost)), v1, 1e-9);                   // a hollow in a body that another fills
    NEAR(volume(moved(inner, {5.5, 0, 0}), inside_out(moved(innermost, {0, 9, 0}))), v1 + v2, 1e-9);  // beside it
}

void test_same_result_with_threads() {
    TriangleMesh m = ellipsoid({3, 0.5, 1});
    append(m, cuboid({-2.9, -0.05, -1.2}, {0.8, 0.1, 2.5}));
    m = clean_and_check(m, "fish", nullptr);
    const Box box{{60, 16, 26}, 1.0};
    CHECK(covered_fractions(m, box, 2, 3, nullptr) == covered_fractions(m, box, 2, 1, nullptr));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_fins_on_the_middle_plane),
        TEST(test_plates_at_any_angle),
        TEST(test_random_tetrahedra),
        TEST(test_ellipsoids),
        TEST(test_mirror_images),
        TEST(test_cuboids_that_touch_and_overlap),
        TEST(test_turned_cuboids),
        TEST(test_overlap_by_sampling),
        TEST(test_self_intersection_by_sampling),
        TEST(test_repeated_bodies),
        TEST(test_nested_shells),
        TEST(test_same_result_with_threads),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
