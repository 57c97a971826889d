// SPDX-License-Identifier: MIT
// Marching tetrahedra on cell centres (m): each cube of eight centres is cut into the six Kuhn tetrahedra around its
// main diagonal, which fit together across cubes. On a simplicial grid a sign per point always gives a manifold, with
// none of the ambiguous cases of marching cubes.
#include "shape/isosurface.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "grid/error.hpp"

namespace dqa {
namespace {

// Corners of a cube as bits 4 ix + 2 iy + iz. A Kuhn tetrahedron walks from corner 0 to corner 7 one axis at a time, so
// every edge joins a corner to one whose bits contain it; the difference (1 to 7) is the direction of the edge.
struct Tetrahedron {
    std::array<int, 4> corner;
    bool positive;  // the walk is right-handed
};
constexpr std::array<Tetrahedron, 6> kuhn{{{{0, 4, 6, 7}, true},
                                           {{0, 2, 3, 7}, true},
                                           {{0, 1, 5, 7}, true},
                                           {{0, 4, 5, 7}, false},
                                           {{0, 2, 6, 7}, false},
                                           {{0, 1, 3, 7}, false}}};

class Marcher {
public:
    Marcher(const Box& box, const double* values, double level) : box_(box), values_(values), level_(level) {}

    Isosurface run() {
        for (int i = -1; i < box_.cells[0]; ++i)
            for (int j = -1; j < box_.cells[1]; ++j)
                for (int k = -1; k < box_.cells[2]; ++k) cube(i, j, k);
        return std::move(out_);
    }

private:
    double value(int i, int j, int k) const {
        if (i < 0 || j < 0 || k < 0 || i >= box_.cells[0] || j >= box_.cells[1] || k >= box_.cells[2]) return 0.0;
        return values_[box_.cell(i, j, k)];
    }

    void cube(int i, int j, int k) {
        origin_ = {i, j, k};
        int inside = 0;
        for (int c = 0; c < 8; ++c) {
            corner_[static_cast<std::size_t>(c)] = value(i + (c >> 2), j + (c >> 1 & 1), k + (c & 1));
            if (corner_[static_cast<std::size_t>(c)] > level_) ++inside;
        }
        if (inside == 0 || inside == 8) return;
        for (const Tetrahedron& t : kuhn) tetrahedron(t);
    }

    void tetrahedron(const Tetrahedron& t) {
        std::array<int, 4> in{}, out{};  // corners inside (value above level) and outside, in the order of the walk
        int n_in = 0, n_out = 0;
        // Parity of the reordering (inside corners first): an odd one turns the tetrahedron's handedness.
        bool positive = t.positive;
        for (const int c : t.corner) {
            if (corner_[static_cast<std::size_t>(c)] > level_) {
                if (n_out % 2 == 1) positive = !positive;
                in[static_cast<std::size_t>(n_in++)] = c;
            } else {
                out[static_cast<std::size_t>(n_out++)] = c;
            }
        }
        // A right-handed tetrahedron (a, b, c, d) shows b, c, d counter-clockwise from the side away from a.
        if (n_in == 1) {
            triangle(vertex(in[0], out[0]), vertex(in[0], out[1]), vertex(in[0], out[2]), positive);
        } else if (n_in == 3) {
            triangle(vertex(in[0], out[0]), vertex(in[1], out[0]), vertex(in[2], out[0]), positive);
        } else if (n_in == 2) {
            const int p = vertex(in[0], out[0]), q = vertex(in[0], out[1]);
            const int r = vertex(in[1], out[1]), s = vertex(in[1], out[0]);
            triangle(p, q, r, positive);
            triangle(p, r, s, positive);
        }
    }

    void triangle(int a, int b, int c, bool positive) {
        if (positive)
            out_.triangles.push_back({a, b, c});
        else
            out_.triangles.push_back({a, c, b});
    }

    // Vertex on the edge between an inside and an outside corner, shared by all tetrahedra around that edge.
    int vertex(int inside, int outside) {
        const int low = inside & outside, direction = inside ^ outside;
        const std::int64_t i = origin_[0] + 1 + (low >> 2), j = origin_[1] + 1 + (low >> 1 & 1);
        const std::int64_t k = origin_[2] + 1 + (low & 1);
        const std::int64_t point = (i * (box_.cells[1] + 2) + j) * (box_.cells[2] + 2) + k;
        const auto [entry, is_new] = index_.try_emplace(point * 8 + direction, static_cast<int>(out_.vertices.size()));
        if (!is_new) return entry->second;
        const double a = corner_[static_cast<std::size_t>(inside)], b = corner_[static_cast<std::size_t>(outside)];
        // Kept off both ends: where the level is met exactly at a grid point, the vertices of all edges into that point
        // would coincide and the triangles between them would have no area.
        const double t = std::clamp((a - level_) / (a - b), 1e-3, 1.0 - 1e-3);
        Vec3 x;
        for (int axis = 0; axis < 3; ++axis) {
            const int bit = 2 - axis;
            const double from = inside >> bit & 1, to = outside >> bit & 1;
            const std::size_t s = static_cast<std::size_t>(axis);
            x[s] = (origin_[s] + from + t * (to - from) + 0.5 - 0.5 * box_.cells[s]) * box_.dx;
        }
        out_.vertices.push_back(x);
        return entry->second;
    }

    const Box& box_;
    const double* values_;
    double level_;
    std::array<int, 3> origin_{};
    std::array<double, 8> corner_{};
    std::unordered_map<std::int64_t, int> index_;
    Isosurface out_;
};

// Marching triangles: every square of four cell centres is cut along its rising diagonal.
class ContourMarcher {
public:
    ContourMarcher(const Box& box, const double* values, double level) : box_(box), values_(values), level_(level) {}

    Isosurface run() {
        for (int i = -1; i < box_.cells[0]; ++i)
            for (int j = -1; j < box_.cells[1]; ++j) {
                triangle({i, j}, {i + 1, j}, {i + 1, j + 1});
                triangle({i, j}, {i + 1, j + 1}, {i, j + 1});
            }
        return std::move(out_);
    }

private:
    using Point = std::array<int, 2>;

    double value(const Point& p) const {
        if (p[0] < 0 || p[1] < 0 || p[0] >= box_.cells[0] || p[1] >= box_.cells[1]) return 0.0;
        return values_[box_.cell(p[0], p[1], 0)];
    }

    // Corners counter-clockwise.
    void triangle(const Point& a, const Point& b, const Point& c) {
        const std::array<Point, 3> corner{a, b, c};
        std::array<bool, 3> in{};
        int count = 0;
        for (std::size_t k = 0; k < 3; ++k) count += in[k] = value(corner[k]) > level_;
        if (count == 0 || count == 3) return;
        // The corner that differs from the two others, and those in counter-clockwise order after it.
        std::size_t lone = 0;
        while (in[lone] != (count == 1)) ++lone;
        const Point &p = corner[lone], &q = corner[(lone + 1) % 3], &r = corner[(lone + 2) % 3];
        const int first = vertex(p, q), second = vertex(p, r);
        if (count == 1)
            out_.segments.push_back({first, second});
        else
            out_.segments.push_back({second, first});
    }

    int vertex(const Point& a, const Point& b) {
        const Point &low = a < b ? a : b, &high = a < b ? b : a;
        const std::int64_t point = static_cast<std::int64_t>(low[0] + 1) * (box_.cells[1] + 2) + low[1] + 1;
        const int direction = (high[0] - low[0]) * 2 + (high[1] - low[1]);
        const auto [entry, is_new] = index_.try_emplace(point * 4 + direction, static_cast<int>(out_.vertices.size()));
        if (!is_new) return entry->second;
        const double va = value(low), vb = value(high);
        const double t = std::clamp((va - level_) / (va - vb), 1e-3, 1.0 - 1e-3);  // off both ends, as above
        Vec3 x{};
        for (std::size_t k = 0; k < 2; ++k)
            x[k] = (low[k] + t * (high[k] - low[k]) + 0.5 - 0.5 * box_.cells[k]) * box_.dx;
        out_.vertices.push_back(x);
        return entry->second;
    }

    const Box& box_;
    const double* values_;
    double level_;
    std::unordered_map<std::int64_t, int> index_;
    Isosurface out_;
};

void check_field(const Box& box, const double* values, double level) {
    if (!(level > 0.0) || !std::isfinite(level))
        fail(Status::ERROR_ARGUMENT, "the level is %g; expected a positive number (values are 0 outside the box)",
             level);
    if (!(box.dx > 0.0)) fail(Status::ERROR_ARGUMENT, "the cell size is %g m; expected a positive number", box.dx);
    for (int c = 0; c < box.n_cells(); ++c)
        if (!std::isfinite(values[c]))
            fail(Status::ERROR_ARGUMENT, "the value of cell %d is %g; expected a finite number", c, values[c]);
}

}  // namespace

Isosurface extract_isosurface(const Box& box, const double* values, double level) {
    check_field(box, values, level);
    return Marcher(box, values, level).run();
}

Isosurface extract_contour(const Box& box, const double* values, double level) {
    check_field(box, values, level);
    return ContourMarcher(box, values, level).run();
}

}  // namespace dqa
