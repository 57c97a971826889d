// SPDX-License-Identifier: MIT
// From a mesh to covered fractions of cells, and from cells back to a surface: good shapes against their known volumes
// and symmetries, bad ones against the error they must give.
#include <limits>

#include "shape/voxelize.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;

// ---------------------------------------------------------------- mesh

void test_good_meshes() {
    MeshReport r;
    TriangleMesh m = clean_and_check(cuboid({1, 2, 3}, {2, 3, 4}), "cuboid", &r);
    CHECK(r.boundary_edges == 0 && r.flipped_edges == 0 && r.components == 1 && r.genus == 0);
    CHECK(r.euler_characteristic == 2 && m.triangles.size() == 12);
    NEAR(r.volume, 24, 1e-12);
    NEAR(r.length_z, 4, 0);
    const Vec3 centre = mesh_centre_of_mass(m);
    NEAR(centre[0], 2, 1e-12);
    NEAR(centre[1], 3.5, 1e-12);
    NEAR(centre[2], 5, 1e-12);

    clean_and_check(torus(2, 0.5), "torus", &r);
    CHECK(r.genus == 1 && r.euler_characteristic == 0);
    NEAR(r.volume, 2 * pi * pi * 2 * 0.25, 0.05);

    TriangleMesh two = cuboid({0, 0, 0}, {1, 1, 1});
    append(two, cuboid({3, 0, 0}, {1, 1, 1}));
    clean_and_check(two, "two", &r);
    CHECK(r.components == 2 && r.genus == 0 && r.euler_characteristic == 4);
}

void test_weld_and_degenerate() {
    const TriangleMesh cube = cuboid({0, 0, 0}, {1, 1, 1});
    TriangleMesh soup;  // every triangle with its own vertices, as in STL
    for (const auto& t : cube.triangles) {
        const int base = static_cast<int>(soup.vertices.size());
        for (const int i : t) soup.vertices.push_back(cube.vertices[static_cast<std::size_t>(i)]);
        soup.triangles.push_back({base, base + 1, base + 2});
    }
    soup.vertices[0][0] = -0.0;  // equal to 0
    soup.triangles.push_back({0, 0, 1});
    soup.vertices.push_back({9, 9, 9});  // used by no triangle
    MeshReport r;
    const TriangleMesh m = clean_and_check(soup, "soup", &r);
    CHECK(m.vertices.size() == 8 && m.triangles.size() == 12);
    CHECK(r.duplicate_vertices_merged == 28 && r.degenerate_triangles == 1);
    NEAR(r.volume, 1, 1e-14);
}

void test_inside_out_is_flipped() {
    TriangleMesh m = cuboid({0, 0, 0}, {1, 1, 1});
    for (auto& t : m.triangles) std::swap(t[0], t[1]);
    MeshReport r;
    const TriangleMesh out = clean_and_check(m, "inside out", &r);
    NEAR(r.volume, -1, 1e-14);
    NEAR(mesh_volume(out), 1, 1e-14);
}

void test_touching_cubes_are_non_manifold() {
    TriangleMesh m = cuboid({0, 0, 0}, {1, 1, 1});
    append(m, cuboid({1, 1, 0}, {1, 1, 1}));  // share one edge
    MeshReport r;
    clean_and_check(m, "touching", &r);
    CHECK(r.non_manifold_edges == 1 && r.boundary_edges == 0);
    NEAR(r.volume, 2, 1e-14);
}

void test_bad_meshes() {
    MeshReport r;
    TriangleMesh m = cuboid({0, 0, 0}, {1, 1, 1});
    m.triangles.pop_back();
    EXPECT_ERROR(ERROR_MESH, "'box' is open: 3 boundary edges", clean_and_check(m, "box", &r));
    CHECK(r.boundary_edges == 3);
    m = cuboid({0, 0, 0}, {1, 1, 1});
    std::swap(m.triangles[4][0], m.triangles[4][1]);
    EXPECT_ERROR(ERROR_MESH, "inconsistently oriented: the triangles of 3 edges", clean_and_check(m, "box", &r));
    CHECK(r.flipped_edges == 3);
    m = cuboid({0, 0, 0}, {1, 1, 1});
    m.vertices[5][1] = std::nan("");
    EXPECT_ERROR(ERROR_MESH, "vertex 5", clean_and_check(m, "box", nullptr));
    m.vertices[5][1] = std::numeric_limits<double>::infinity();
    EXPECT_ERROR(ERROR_MESH, "vertex 5", clean_and_check(m, "box", nullptr));
    m = cuboid({0, 0, 0}, {1, 1, 1});
    m.triangles[3][2] = 8;
    EXPECT_ERROR(ERROR_MESH, "triangle 3 refers to vertex 8", clean_and_check(m, "box", nullptr));
    m.triangles[3][2] = -1;
    EXPECT_ERROR(ERROR_MESH, "vertex -1", clean_and_check(m, "box", nullptr));
    m.triangles.clear();
    EXPECT_ERROR(ERROR_MESH, "no triangles", clean_and_check(m, "box", nullptr));
    EXPECT_ERROR(ERROR_MESH, "no triangles", clean_and_check({}, "nothing", nullptr));
    m.triangles = {{1, 1, 2}, {3, 3, 3}};
    EXPECT_ERROR(ERROR_MESH, "no triangles left", clean_and_check(m, "box", nullptr));
    EXPECT_ERROR(ERROR_MESH, "no volume", clean_and_check(cuboid({0, 0, 0}, {1, 1, 0}), "flat", nullptr));
    m.triangles = {{0, 1, 2}, {0, 2, 1}};
    EXPECT_ERROR(ERROR_MESH, "no volume", clean_and_check(m, "two-sided triangle", nullptr));
    m.vertices.assign(3, {1, 1, 1});
    EXPECT_ERROR(ERROR_MESH, "no triangles left", clean_and_check(m, "point", nullptr));
}

void test_sizes_far_from_one() {
    for (const double size : {1e-30, 1e-3, 1e6, 1e30}) {
        TriangleMesh m = cuboid({-size, size, 3 * size}, {2 * size, size, size});
        m = clean_and_check(m, "scaled", nullptr);
        NEAR(mesh_volume(m) / (size * size * size), 2, 1e-12);
        double length = 0;
        const Box box{{20, 10, 10}, 1.0};
        const auto f = covered_fractions(m, box, 2, 1, &length);
        NEAR(length, 12, 1e-9);
        NEAR(sum(f), 12 * 36, 1e-6);
    }
}

void test_up() {
    TriangleMesh fish = ellipsoid({3, 0.5, 1});
    append(fish, cuboid({-0.5, -0.05, 0.8}, {1, 0.1, 0.7}));  // a dorsal fin towards +z
    TriangleMesh m = fish;
    orient_up(m, UP_AUTO);
    CHECK(m.vertices == fish.vertices);
    TriangleMesh lying = fish;  // the same with y up: (x, y, z) -> (x, z, -y)
    for (Vec3& v : lying.vertices) v = {v[0], v[2], -v[1]};
    CHECK(mirror_asymmetry(lying, 1) > 0.01 && mirror_asymmetry(lying, 2) < 1e-6);
    m = lying;
    orient_up(m, UP_AUTO);
    CHECK(m.vertices == fish.vertices);
    m = lying;
    orient_up(m, UP_Y);
    CHECK(m.vertices == fish.vertices);
    NEAR(mesh_volume(m), mesh_volume(fish), 1e-12);  // still right-handed
    m = lying;
    orient_up(m, UP_Z);
    CHECK(m.vertices == lying.vertices);
    for (const TriangleMesh& tie : {cuboid({0, 0, 0}, {3, 2, 1}), ellipsoid({3, 1, 1}), torus(2, 0.5)}) {
        m = tie;
        orient_up(m, UP_AUTO);
        CHECK(m.vertices == tie.vertices);
    }
    EXPECT_ERROR(ERROR_ARGUMENT, "up is 3", (orient_up(m, 3), 0));
}

// ---------------------------------------------------------------- voxels

void test_sphere_against_analytic() {
    const Box box{{24, 24, 24}, 1.0};
    const TriangleMesh sphere = clean_and_check(ellipsoid({1, 1, 1}, 256, 128), "sphere", nullptr);
    double length = 0;
    const auto f = covered_fractions(sphere, box, 2, 1, &length);
    NEAR(length, 20, 1e-3);
    NEAR(sum(f), 4.0 / 3.0 * pi * 1000, 4);
    for (int c = 0; c < box.n_cells(); ++c) {
        const Vec3 x = box.cell_centre(c);
        const double r = std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
        const double value = f[static_cast<std::size_t>(c)];
        CHECK(value >= 0.0 && value <= 1.0);
        if (r < 10 - 0.9) NEAR(value, 1, 1e-12);
        if (r > 10 + 0.9) NEAR(value, 0, 0);
        // Along the axes the surface is nearly a plane across the cell: its fraction is known.
        if (std::fabs(x[1]) < 1 && std::fabs(x[2]) < 1 && r > 9 && r < 11)
            NEAR(value, std::clamp(10 - 1.0 / 30 - std::fabs(x[0]) + 0.5, 0.0, 1.0), 0.05);
    }
    // First moments vanish: the centre of mass stands at the centre of the box.
    for (std::size_t a = 0; a < 3; ++a) {
        double moment = 0;
        for (int c = 0; c < box.n_cells(); ++c) moment += f[static_cast<std::size_t>(c)] * box.cell_centre(c)[a];
        NEAR(moment / sum(f), 0, 1e-3);
    }
}

void test_aligned_faces_and_margin() {
    // Every face, edge and diagonal of this cuboid runs along planes between cells, or along their diagonals.
    const Box box{{16, 10, 12}, 1.0};
    for (int margin = 1; margin <= 3; ++margin) {
        double length = 0;
        const TriangleMesh m = clean_and_check(cuboid({0, 0, 0}, {2, 2, 2}), "cube", nullptr);
        const auto f = covered_fractions(m, box, margin, 1, &length);
        const int edge = 10 - 2 * margin;
        NEAR(length, edge, 1e-12);
        NEAR(sum(f), edge * edge * edge, 0);
        for (int c = 0; c < box.n_cells(); ++c) {
            const Vec3 x = box.cell_centre(c);
            const bool inside = std::max({std::fabs(x[0]), std::fabs(x[1]), std::fabs(x[2])}) < 0.5 * edge;
            NEAR(f[static_cast<std::size_t>(c)], inside ? 1 : 0, 0);
        }
    }
}

// An octahedron whose corners and edges lie in the middle planes of the box, for cells on both sides of these and for
// cells that they halve: any leak would show as a full row.
void test_corners_on_middle_planes() {
    TriangleMesh m;
    m.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    m.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    m = clean_and_check(m, "octahedron", nullptr);
    for (const int cells : {14, 15}) {
        const Box box{{cells, cells, cells}, 1.0};
        double length = 0;
        const auto f = covered_fractions(m, box, 2, 1, &length);
        const double r = 0.5 * length;
        NEAR(r, 0.5 * cells - 2, 1e-12);
        NEAR(sum(f), 4.0 / 3.0 * r * r * r, 1e-10);
        for (int axis = 0; axis < 3; ++axis) NEAR(largest_difference(f, mirrored(box, f, axis)), 0, 1e-12);
    }
}

void test_volume_and_symmetry() {
    TriangleMesh fish = ellipsoid({3, 0.5, 1});
    append(fish, cuboid({-2.9, -0.05, -1.2}, {0.8, 0.1, 2.5}));  // overlaps the body
    fish = clean_and_check(fish, "fish", nullptr);
    const TriangleMesh body = clean_and_check(ellipsoid({3, 0.5, 1}), "body", nullptr);
    const Box box{{60, 16, 26}, 1.0};
    double length = 0;
    auto f = covered_fractions(body, box, 2, 1, &length);
    const double scale = length / 6;
    NEAR(sum(f) / (mesh_volume(body) * scale * scale * scale), 1, 1e-11);
    f = covered_fractions(fish, box, 2, 1, &length);
    NEAR(largest_difference(f, mirrored(box, f, 1)), 0, 1e-6);
    CHECK(largest_difference(f, mirrored(box, f, 2)) > 0.01);
    // The union has its centre of mass at the centre of the box, though the triangles count the overlap twice.
    double moment = 0;
    for (int c = 0; c < box.n_cells(); ++c) moment += f[static_cast<std::size_t>(c)] * box.cell_centre(c)[0];
    NEAR(moment / sum(f), 0, 0.01);  // cells stand for their middles here
    for (int c = 0; c < box.n_cells(); ++c) {
        const auto ijk = box.cell_ijk(c);
        for (std::size_t a = 0; a < 3; ++a)
            if (ijk[a] < 2 || ijk[a] >= box.cells[a] - 2) NEAR(f[static_cast<std::size_t>(c)], 0, 0);
    }
    CHECK(covered_fractions(fish, box, 2, 3, nullptr) == covered_fractions(fish, box, 2, 1, nullptr));
}

void test_cavity_and_overlap() {
    const Box box{{14, 14, 14}, 1.0};
    TriangleMesh hollow = cuboid({-5, -5, -5}, {10, 10, 10});
    TriangleMesh hole = cuboid({-2, -2, -2}, {4, 4, 4});
    for (auto& t : hole.triangles) std::swap(t[0], t[1]);
    append(hollow, hole);
    NEAR(sum(covered_fractions(clean_and_check(hollow, "hollow", nullptr), box, 2, 1, nullptr)), 1000 - 64, 1e-9);
    TriangleMesh cross = cuboid({-5, -1, -1}, {10, 2, 2});
    append(cross, cuboid({-1, -5, -1}, {2, 10, 2}));
    NEAR(sum(covered_fractions(clean_and_check(cross, "cross", nullptr), box, 2, 1, nullptr)), 40 + 40 - 8, 1e-6);
}

// A translation of the mesh changes nothing, as its centre of mass is put at the centre of the box; an off-centre part
// that shifts it by less than a cell changes fractions by about that shift, and no mass is lost.
void test_translation() {
    const Box box{{30, 16, 16}, 1.0};
    const TriangleMesh m = clean_and_check(ellipsoid({3, 1, 1}), "body", nullptr);
    const auto reference = covered_fractions(m, box, 2, 1, nullptr);
    TriangleMesh moved = m;
    for (Vec3& v : moved.vertices) v = {v[0] + 0.37, v[1] - 12.1, v[2] + 5.003};
    NEAR(largest_difference(covered_fractions(moved, box, 2, 1, nullptr), reference), 0, 1e-4);
    for (const int cells : {15, 16}) {  // a body whose middle is on a face of cells, or in a cell: half a cell apart
        const Box other{{30, cells, cells}, 1.0};
        double length = 0;
        const auto f = covered_fractions(m, other, cells == 15 ? 2 : 3, 1, &length);
        NEAR(sum(f) / std::pow(length / 6, 3), mesh_volume(m), 0.01 * mesh_volume(m));
    }
}

void test_voxelize_arguments() {
    const TriangleMesh m = cuboid({0, 0, 0}, {1, 1, 1});
    const Box box{{16, 16, 16}, 1.0};
    EXPECT_ERROR(ERROR_ARGUMENT, "margin of 8", covered_fractions(m, box, 8, 1, nullptr));
    EXPECT_ERROR(ERROR_ARGUMENT, "margin of -1", covered_fractions(m, box, -1, 1, nullptr));
    EXPECT_ERROR(ERROR_MESH, "without triangles", covered_fractions({}, box, 2, 1, nullptr));
}

// ---------------------------------------------------------------- isosurface

template <class F>
std::vector<double> sampled(const Box& box, F&& value) {
    std::vector<double> v;
    for (int c = 0; c < box.n_cells(); ++c) v.push_back(value(box.cell_centre(c)));
    return v;
}

void test_isosurface() {
    const Box box{{20, 22, 24}, 0.1};
    const auto radius = [](const Vec3& x) { return std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]); };
    MeshReport r =
        surface_report(box, sampled(box, [&](const Vec3& x) { return std::max(0.0, 1.5 - radius(x)); }), 0.7);
    CHECK(r.components == 1 && r.genus == 0);
    NEAR(r.volume, 4.0 / 3.0 * pi * 0.8 * 0.8 * 0.8, 0.02 * 4.0 / 3.0 * pi * 0.8 * 0.8 * 0.8);
    NEAR(r.length_x, 1.6, 0.02);
    const auto ring = [](const Vec3& x) {
        const double d = std::hypot(std::hypot(x[0], x[1]) - 0.6, x[2]);
        return std::max(0.0, 1 - d);
    };
    r = surface_report(box, sampled(box, ring), 0.75);
    CHECK(r.components == 1 && r.genus == 1);
    NEAR(r.volume, 2 * pi * pi * 0.6 * 0.0625, 0.03 * 2 * pi * pi * 0.6 * 0.0625);
    // Up to the walls of the box the surface closes outside of it.
    r = surface_report(box, std::vector<double>(static_cast<std::size_t>(box.n_cells()), 1.0), 0.5);
    CHECK(r.components == 1 && r.genus == 0);
    NEAR(r.length_x, 2.0, 1e-12);
    CHECK(extract_isosurface(box, std::vector<double>(static_cast<std::size_t>(box.n_cells()), 0.2).data(), 0.5)
              .triangles.empty());
}

// Values that equal the level at grid points, single cells, cells that touch at corners, and arbitrary patterns.
void test_isosurface_special_values() {
    const Box box{{7, 6, 5}, 1.0};
    std::vector<double> v(static_cast<std::size_t>(box.n_cells()), 0.0);
    v[static_cast<std::size_t>(box.cell(3, 3, 2))] = 1;
    CHECK(surface_report(box, v, 0.5).components == 1);
    v[static_cast<std::size_t>(box.cell(4, 4, 3))] = 0.5;
    surface_report(box, v, 0.5);
    std::uint32_t state = 1;
    for (int round = 0; round < 50; ++round) {
        for (double& x : v) {
            state = state * 1664525u + 1013904223u;
            x = 0.25 * (state >> 30);  // 0, 1/4, 1/2, 3/4
        }
        surface_report(box, v, 0.5);
        surface_report(box, v, 0.3);
    }
    v[7] = std::nan("");
    EXPECT_ERROR(ERROR_ARGUMENT, "cell 7", extract_isosurface(box, v.data(), 0.5));
    EXPECT_ERROR(ERROR_ARGUMENT, "level", extract_isosurface(box, v.data(), 0.0));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_good_meshes),
        TEST(test_weld_and_degenerate),
        TEST(test_inside_out_is_flipped),
        TEST(test_touching_cubes_are_non_manifold),
        TEST(test_bad_meshes),
        TEST(test_sizes_far_from_one),
        TEST(test_up),
        TEST(test_sphere_against_analytic),
        TEST(test_aligned_faces_and_margin),
        TEST(test_corners_on_middle_planes),
        TEST(test_volume_and_symmetry),
        TEST(test_cavity_and_overlap),
        TEST(test_translation),
        TEST(test_voxelize_arguments),
        TEST(test_isosurface),
        TEST(test_isosurface_special_values),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
