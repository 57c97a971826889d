// SPDX-License-Identifier: MIT
// Covered fractions by the divergence theorem, exact up to rounding. A part of the surface at x = h(y, z) with the
// solid behind it covers, in each column of cells along x, everything up to h: of the cell it lies in the part below h,
// and all cells before that one. A part that faces the other way takes the same away. So the surface is cut along the
// planes between cells, and each piece adds its integral of h over its shadow on the (y, z) plane to its own cell, and
// its shadow's area to the cells before it. Cell units.
#include "shape/voxelize.hpp"

#include <algorithm>
#include <cmath>

#include "grid/error.hpp"
#include "grid/parallel.hpp"
#include "shape/bounds.hpp"
#include "shape/convex_polygon.hpp"
#include "shape/outer_surface.hpp"
#include "shape/vector.hpp"

namespace dqa {
namespace {

// A cell's fraction closer than this to 0 or 1 is rounding of the sum over its pieces.
constexpr double kRounding = 1e-12;

std::size_t idx(int i) {
    return static_cast<std::size_t>(i);
}

// A mesh with its centre of mass at the origin and 64 units long: distances that matter are then of the same size for
// every mesh.
struct Solid {
    OuterSurface surface;
    Bounds bounds;
};

// Centre of mass of what a surface encloses.
Vec3 centre_of_mass(const OuterSurface& surface) {
    double volume = 0.0;
    Vec3 first{0, 0, 0};
    for (std::size_t p = 0; p < surface.size(); ++p) {
        const ConvexPolygon polygon = surface.polygon(p);
        for (int c = 1; c + 1 < polygon.n; ++c) {
            const Vec3 &a = polygon[0], &b = polygon[c], &d = polygon[c + 1];
            const double six_volumes = dot(a, cross(b, d));
            volume += six_volumes;
            first = plus(first, scaled(plus(plus(a, b), d), 0.25 * six_volumes));
        }
    }
    return volume > 0 ? scaled(first, 1.0 / volume) : Vec3{0, 0, 0};
}

Solid solid_of(const TriangleMesh& mesh) {
    constexpr double kLength = 64.0;
    Bounds bounds;
    for (const Vec3& v : mesh.vertices) bounds.include(v);
    const std::size_t axis = bounds.longest_axis();
    const double scale = kLength / (bounds.hi[axis] - bounds.lo[axis]);
    const Vec3 centre = mesh_centre_of_mass(mesh);
    if (!std::isfinite(scale))
        fail(Status::ERROR_MESH, "a mesh of extents %g x %g x %g cannot be scaled to the box",
             bounds.hi[0] - bounds.lo[0], bounds.hi[1] - bounds.lo[1], bounds.hi[2] - bounds.lo[2]);
    std::vector<Vec3> vertices;
    vertices.reserve(mesh.vertices.size());
    for (const Vec3& v : mesh.vertices) vertices.push_back(scaled(minus(v, centre), scale));
    Solid solid{outer_surface(vertices, mesh.triangles), {}};
    if (!solid.surface.simple) {
        // The centre of mass from the triangles counts an overlap twice; that of the solid does not.
        Vec3 shift = centre_of_mass(solid.surface);
        for (double& x : shift) x = std::fabs(x) > 1e-9 ? x : 0.0;  // rounding must not break a symmetry
        for (Vec3& v : vertices) v = minus(v, shift);
        for (Vec3& v : solid.surface.corner) v = minus(v, shift);
    }
    for (const Vec3& v : vertices) solid.bounds.include(v);
    for (const Vec3& v : solid.surface.corner) solid.bounds.include(v);  // which rounding may have moved outwards
    return solid;
}

// The sums of the row of cells j.
class Row {
public:
    Row(const Box& box, int j, std::vector<double>& fractions)
        : box_(box),
          nx_(box.cells[0]),
          nz_(box.cells[2]),
          j_(j),
          fractions_(fractions),
          before_(idx(nx_ * nz_), 0.0),
          touched_(before_.size(), 0) {}

    // The pieces of a polygon in the cells of this row: cut first along y, then z, then x.
    void add(const ConvexPolygon& polygon) {
        ConvexPolygon rest = polygon, piece, beyond;
        const auto [lo, hi] = polygon.extent(1);
        if (lo < j_) cut_at(polygon, 1, j_, piece, rest);
        if (rest.n < 3) return;
        if (hi > j_ + 1) {
            cut_at(rest, 1, j_ + 1, piece, beyond);
            rest = piece;
        }
        if (rest.n < 3) return;
        for_cells(rest, 2, [&](const ConvexPolygon& slice, int k) {
            for_cells(slice, 0, [&](const ConvexPolygon& in_cell, int i) { add_piece(in_cell, i, k); });
        });
    }

    void finish() {
        for (int k = 0; k < nz_; ++k) {
            double covered = 0.0;  // of the column's cross-section, by the surface further ahead
            for (int i = nx_ - 1; i >= 0; --i) {
                const std::size_t at = idx(i * nz_ + k);
                double& f = fractions_[idx(box_.cell(i, j_, k))];
                f += covered;
                covered += before_[at];
                // Where no surface passes the cell is empty or full.
                if (!touched_[at]) f = f > 0.5 ? 1.0 : 0.0;
                if (f < kRounding) f = 0.0;
                if (f > 1.0 - kRounding) f = 1.0;
            }
        }
    }

private:
    static void cut_at(const ConvexPolygon& in, std::size_t axis, double at, ConvexPolygon& below,
                       ConvexPolygon& above) {
        cut(
            in, [&](const Vec3& x) { return x[axis] - at; }, below, above);
    }

    template <class F>
    void for_cells(const ConvexPolygon& polygon, std::size_t axis, const F& f) const {
        const auto [lo, hi] = polygon.extent(axis);
        const int cells = box_.cells[axis], first = std::clamp(static_cast<int>(std::floor(lo)), 0, cells - 1);
        const int last = std::clamp(static_cast<int>(std::ceil(hi)) - 1, first, cells - 1);
        if (first == last) {
            f(polygon, first);
            return;
        }
        ConvexPolygon rest = polygon, piece, beyond;
        for (int c = first; c < last && rest.n >= 3; ++c) {
            cut_at(rest, axis, c + 1, piece, beyond);
            if (piece.n >= 3) f(piece, c);
            rest = beyond;
        }
        if (rest.n >= 3) f(rest, last);
    }

    void add_piece(const ConvexPolygon& p, int i, int k) {
        double shadow = 0.0, depth = 0.0;  // area, and integral of x - i over it
        for (int c = 1; c + 1 < p.n; ++c) {
            const Vec3 &a = p[0], &b = p[c], &d = p[c + 1];
            const double area = 0.5 * ((b[1] - a[1]) * (d[2] - a[2]) - (b[2] - a[2]) * (d[1] - a[1]));
            shadow += area, depth += area * ((a[0] - i) + (b[0] - i) + (d[0] - i)) / 3.0;
        }
        fractions_[idx(box_.cell(i, j_, k))] += depth;
        before_[idx(i * nz_ + k)] += shadow;
        touched_[idx(i * nz_ + k)] = 1;
    }

    const Box& box_;
    int nx_, nz_, j_;
    std::vector<double>& fractions_;
    std::vector<double> before_;  // [i][k] area that pieces in a cell add to all cells before it
    std::vector<char> touched_;   // [i][k] cells with pieces
};

class Voxelizer {
public:
    Voxelizer(Solid& solid, const Box& box, Margin margin) : surface_(solid.surface), box_(box) {
        place(solid, margin);
        bin_rows();
    }

    double length() const { return length_; }

    // Adds the row of cells j (all i, k) to `fractions`.
    void row(int j, std::vector<double>& fractions) const {
        Row row(box_, j, fractions);
        for (const std::size_t p : rows_[idx(j)]) row.add(surface_.polygon(p));
        row.finish();
    }

private:
    void place(Solid& solid, Margin margin) {
        const Bounds& b = solid.bounds;
        double scale = HUGE_VAL;
        for (std::size_t a = 0; a < 3; ++a) {
            const double reach = std::max(b.hi[a], -b.lo[a]);
            if (reach > 0.0) scale = std::min(scale, (0.5 * box_.cells[a] - margin.of(a)) / reach);
        }
        length_ = (b.hi[0] - b.lo[0]) * scale;
        for (Vec3& x : surface_.corner)
            // Round-off must not let a touching mesh spill into the margin.
            for (std::size_t a = 0; a < 3; ++a)
                x[a] = std::clamp(x[a] * scale + 0.5 * box_.cells[a], double(margin.of(a)),
                                  double(box_.cells[a] - margin.of(a)));
    }

    void bin_rows() {
        rows_.resize(idx(box_.cells[1]));
        for (std::size_t p = 0; p < surface_.size(); ++p) {
            double lo = HUGE_VAL, hi = -HUGE_VAL;
            for (std::size_t c = surface_.first[p]; c < surface_.first[p + 1]; ++c)
                lo = std::min(lo, surface_.corner[c][1]), hi = std::max(hi, surface_.corner[c][1]);
            const int first = std::clamp(static_cast<int>(std::floor(lo)), 0, box_.cells[1] - 1);
            const int last = std::clamp(static_cast<int>(std::ceil(hi)) - 1, first, box_.cells[1] - 1);
            for (int j = first; j <= last; ++j) rows_[idx(j)].push_back(p);
        }
    }

    OuterSurface& surface_;  // cells, from the lower corner of the box
    const Box& box_;
    double length_ = 0.0;
    std::vector<std::vector<std::size_t>> rows_;  // polygons that reach into the cells j
};

void check_arguments(const TriangleMesh& cleaned, const Box& box, Margin margin) {
    for (std::size_t a = 0; a < 3; ++a)
        if (box.cells[a] < 1 || box.cells[a] > 4096)
            fail(Status::ERROR_ARGUMENT, "the box has %d cells along %c; expected 1 to 4096", box.cells[a], "xyz"[a]);
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (margin.of(axis) < 0 || 2 * margin.of(axis) >= box.cells[axis])
            fail(Status::ERROR_ARGUMENT, "a margin of %d cells leaves no room in a box of %d x %d x %d cells",
                 margin.of(axis), box.cells[0], box.cells[1], box.cells[2]);
    if (cleaned.triangles.empty()) fail(Status::ERROR_MESH, "a mesh without triangles cannot be voxelised");
}

}  // namespace

std::vector<double> covered_fractions(const TriangleMesh& cleaned, const Box& box, Margin margin, int threads,
                                      double* length_in_cells) {
    check_arguments(cleaned, box, margin);
    Solid solid = solid_of(cleaned);
    const Voxelizer voxelizer(solid, box, margin);
    std::vector<double> fractions(static_cast<std::size_t>(box.n_cells()), 0.0);
    parallel_chunks(threads, box.cells[1], 1, [&](int begin, int end) {
        for (int j = begin; j < end; ++j) voxelizer.row(j, fractions);
    });
    if (length_in_cells) *length_in_cells = voxelizer.length();
    return fractions;
}

}  // namespace dqa
