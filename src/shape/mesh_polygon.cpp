// SPDX-License-Identifier: MIT
// Polygons of mesh files cut into triangles. Whatever the cut, the edges of the polygon stay, so that a closed surface
// stays closed; the cut decides only how a polygon that is not plane is bent.
#include <algorithm>
#include <cmath>

#include "shape/mesh_readers.hpp"

namespace dqa {
namespace {

constexpr std::size_t kMostEars = 256;  // corners: cutting ears takes the square of their number

struct Point {
    double x, y;
};

double turn(const Point& a, const Point& b, const Point& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Corners projected along the mean normal (Newell), so that they run counter-clockwise.
std::vector<Point> projected(const TriangleMesh& mesh, const std::vector<int>& corners) {
    const auto at = [&](std::size_t k) -> const Vec3& {
        return mesh.vertices[static_cast<std::size_t>(corners[k % corners.size()])];
    };
    Vec3 normal{};
    const Vec3 origin = at(0);
    for (std::size_t k = 0; k < corners.size(); ++k) {
        Vec3 a = at(k), b = at(k + 1);
        for (std::size_t i = 0; i < 3; ++i) a[i] -= origin[i], b[i] -= origin[i];
        for (std::size_t i = 0; i < 3; ++i)
            normal[i] += a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
    }
    std::size_t main = 0;
    for (std::size_t i = 1; i < 3; ++i)
        if (std::fabs(normal[i]) > std::fabs(normal[main])) main = i;
    const std::size_t u = (main + 1) % 3, v = (main + 2) % 3;
    std::vector<Point> out;
    for (std::size_t k = 0; k < corners.size(); ++k) {
        const double x = at(k)[u] - origin[u], y = at(k)[v] - origin[v];
        out.push_back(normal[main] > 0 ? Point{x, y} : Point{y, x});
    }
    return out;
}

bool is_ear(const std::vector<Point>& points, const std::vector<std::size_t>& left, std::size_t k) {
    const std::size_t n = left.size();
    const Point &a = points[left[(k + n - 1) % n]], &b = points[left[k]], &c = points[left[(k + 1) % n]];
    if (!(turn(a, b, c) > 0)) return false;
    for (std::size_t o = 2; o + 1 < n; ++o) {
        const Point& p = points[left[(k + o) % n]];
        if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
}

}  // namespace

void add_polygon(TriangleMesh& mesh, const std::vector<int>& corners) {
    const std::size_t n = corners.size();
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
        mesh.triangles.push_back({corners[a], corners[b], corners[c]});
    };
    std::vector<Point> points;
    bool folds = false;
    if (n > 3 && n <= kMostEars) {
        points = projected(mesh, corners);
        for (std::size_t k = 1; k + 1 < n && !folds; ++k) folds = turn(points[0], points[k], points[k + 1]) < 0;
    }
    if (!folds) {
        for (std::size_t k = 1; k + 1 < n; ++k) add(0, k, k + 1);
        return;
    }
    std::vector<std::size_t> left(n);
    for (std::size_t k = 0; k < n; ++k) left[k] = k;
    while (left.size() > 3) {
        std::size_t k = 0;
        while (k < left.size() && !is_ear(points, left, k)) ++k;
        if (k == left.size()) k = 1;  // it crosses itself: any cut is as good
        const std::size_t m = left.size();
        add(left[(k + m - 1) % m], left[k % m], left[(k + 1) % m]);
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
    }
    add(left[0], left[1], left[2]);
}

}  // namespace dqa
