// SPDX-License-Identifier: MIT
// Shared by the tests of shapes: checks that throw, their wrapper for cmocka, and simple closed meshes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "grid/error.hpp"
#include "shape/isosurface.hpp"
#include "shape/mesh.hpp"

// cmocka last: it defines fail() as a macro.
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include <cmocka.h>
}

namespace fixtures {

using namespace dqa;

constexpr double pi = 3.14159265358979323846;

// Neither an exception nor cmocka's longjmp may cross the other's frames: checks throw, and the wrapper fails the test
// once all destructors have run.
struct Skipped {};

inline void check(bool good, const char* what, int line) {
    if (!good) throw std::runtime_error("line " + std::to_string(line) + ": " + what);
}
#define CHECK(condition) check(condition, #condition, __LINE__)

inline void check_near(double value, double expected, double tolerance, int line) {
    if (!(std::fabs(value - expected) <= tolerance))
        throw std::runtime_error(format("line %d: %.17g; expected %.17g within %g", line, value, expected, tolerance));
}
#define NEAR(value, expected, tolerance) check_near(value, expected, tolerance, __LINE__)

#define TEST(name) \
    { #name, wrapped < name>, nullptr, nullptr, nullptr }

template <void body()>
void wrapped(void**) {
    static char message[2000];
    message[0] = '\0';
    bool skipped = false;
    try {
        body();
    } catch (const Skipped&) {
        skipped = true;
    } catch (const std::exception& e) {
        std::snprintf(message, sizeof(message), "%s", *e.what() ? e.what() : "exception");
    }
    if (skipped) skip();
    if (*message) fail_msg("%s", message);
}

inline void expect_error(Status status, const std::string& part, const std::function<void()>& call, int line) {
    try {
        call();
    } catch (const Error& e) {
        if (e.status() == status && std::strstr(e.what(), part.c_str())) return;
        throw std::runtime_error(format("line %d: status %d, '%s'; expected %d with '%s'", line, int(e.status()),
                                        e.what(), int(status), part.c_str()));
    }
    throw std::runtime_error(format("line %d: no error; expected %d with '%s'", line, int(status), part.c_str()));
}
#define EXPECT_ERROR(status, part, call) \
    expect_error(                        \
        Status::status, part, [&] { (void)(call); }, __LINE__)

// ---------------------------------------------------------------- shapes

// Box with lower corner `lo` and edges `size`.
inline TriangleMesh cuboid(const Vec3& lo, const Vec3& size) {
    TriangleMesh m;
    for (int c = 0; c < 8; ++c)
        m.vertices.push_back({lo[0] + (c >> 2) * size[0], lo[1] + (c >> 1 & 1) * size[1], lo[2] + (c & 1) * size[2]});
    m.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                   {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
    return m;
}

// Grid of rows x columns quadrilaterals over a surface; period in both parameters when `torus`, else poles.
inline TriangleMesh ellipsoid(const Vec3& radius, int columns = 96, int rows = 48) {
    TriangleMesh m;
    m.vertices.push_back({0, 0, radius[2]});
    for (int r = 1; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
            const double t = pi * r / rows, p = 2 * pi * c / columns;
            m.vertices.push_back({radius[0] * std::sin(t) * std::cos(p), radius[1] * std::sin(t) * std::sin(p),
                                  radius[2] * std::cos(t)});
        }
    m.vertices.push_back({0, 0, -radius[2]});
    const int last = static_cast<int>(m.vertices.size()) - 1;
    for (int c = 0; c < columns; ++c) {
        const int d = (c + 1) % columns;
        m.triangles.push_back({0, 1 + c, 1 + d});
        m.triangles.push_back({last, last - columns + d, last - columns + c});
        for (int r = 0; r + 2 < rows; ++r) {
            const int a = 1 + r * columns;
            m.triangles.push_back({a + c, a + columns + c, a + columns + d});
            m.triangles.push_back({a + c, a + columns + d, a + d});
        }
    }
    return m;
}

inline TriangleMesh torus(double major, double minor, int n = 64) {
    TriangleMesh m;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double u = 2 * pi * i / n, v = 2 * pi * j / n, r = major + minor * std::cos(v);
            m.vertices.push_back({r * std::cos(u), r * std::sin(u), minor * std::sin(v)});
        }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const int a = i * n + j, b = (i + 1) % n * n + j, c = (i + 1) % n * n + (j + 1) % n,
                      d = i * n + (j + 1) % n;
            m.triangles.push_back({a, b, c});
            m.triangles.push_back({a, c, d});
        }
    return m;
}

inline void append(TriangleMesh& to, const TriangleMesh& from) {
    const int base = static_cast<int>(to.vertices.size());
    to.vertices.insert(to.vertices.end(), from.vertices.begin(), from.vertices.end());
    for (auto t : from.triangles) to.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

inline double sum(const std::vector<double>& v) {
    return std::accumulate(v.begin(), v.end(), 0.0);
}

inline std::vector<double> mirrored(const Box& box, const std::vector<double>& f, int axis) {
    std::vector<double> out(f.size());
    for (int c = 0; c < box.n_cells(); ++c) {
        auto ijk = box.cell_ijk(c);
        const auto a = static_cast<std::size_t>(axis);
        ijk[a] = box.cells[a] - 1 - ijk[a];
        out[static_cast<std::size_t>(box.cell(ijk[0], ijk[1], ijk[2]))] = f[static_cast<std::size_t>(c)];
    }
    return out;
}

inline double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
    double d = 0.0;
    for (std::size_t c = 0; c < a.size(); ++c) d = std::max(d, std::fabs(a[c] - b[c]));
    return d;
}

inline MeshReport surface_report(const Box& box, const std::vector<double>& values, double level) {
    const Isosurface s = extract_isosurface(box, values.data(), level);
    MeshReport r;
    const TriangleMesh m = clean_and_check({s.vertices, s.triangles}, "isosurface", &r);
    CHECK(r.boundary_edges == 0 && r.flipped_edges == 0 && r.non_manifold_edges == 0);
    CHECK(r.degenerate_triangles == 0 && r.duplicate_vertices_merged == 0);
    CHECK(m.vertices.size() == s.vertices.size());  // no vertex without a triangle
    CHECK(r.volume > 0);                            // outward, before any flip
    return r;
}

}  // namespace fixtures
