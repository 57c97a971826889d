// SPDX-License-Identifier: MIT
// Covered fractions by rays along x. The (y, z) positions of vertices are snapped to a fine integer lattice that also
// holds the rays (finer than 1e-4 cells), so that the test "does this ray meet this triangle" is exact: a ray through a
// shared edge or vertex meets the closed surface consistently, with no leaks. Cell units.
#include "shape/voxelize.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "grid/error.hpp"
#include "grid/parallel.hpp"

namespace dqa {
namespace {

using Int = std::int64_t;

std::size_t idx(Int i) {
    return static_cast<std::size_t>(i);
}

struct LatticeVertex {
    double x;  // cells, from the lower x side of the box
    Int y, z;  // lattice units, from the centre of the box
};

struct Crossing {
    int ray;  // number within a row of cells
    double x;
    int turn;  // +1: the ray enters the solid, -1: it leaves
};

int sign(Int v) {
    return (v > 0) - (v < 0);
}

// Side of p = (y, z) from the line a -> b: +1 left, -1 right, never 0. A point on the line is moved by an infinitesimal
// step in y and a still smaller one in z (simulation of simplicity). The step goes away from the centre plane on both
// sides, which makes the decision mirror-symmetric; it depends on the ray alone, so all triangles of a ray agree.
// `value` receives twice the signed area of (a, b, p): below 2^61, as coordinates are below 2^29.
int side(const LatticeVertex& a, const LatticeVertex& b, Int y, Int z, Int& value) {
    const Int dy = b.y - a.y, dz = b.z - a.z;
    value = dy * (z - a.z) - dz * (y - a.y);
    if (value != 0) return sign(value);
    const int step_y = y < 0 ? -1 : 1, step_z = z < 0 ? -1 : 1;
    return dz != 0 ? -sign(dz) * step_y : sign(dy) * step_z;
}

// Integer division rounding up, b > 0.
Int ceil_div(Int a, Int b) {
    return a >= 0 ? (a + b - 1) / b : -(-a / b);
}
Int floor_div(Int a, Int b) {
    return -ceil_div(-a, b);
}

class Voxelizer {
public:
    // `centre` (unit of the mesh) comes to stand at the centre of the box.
    Voxelizer(const TriangleMesh& mesh, const Vec3& centre, const Box& box, Margin margin, int subsamples)
        : mesh_(mesh), box_(box), n_(box.cells), subsamples_(subsamples) {
        place(centre, margin);
        bin_rows();
    }

    double length() const { return length_; }
    double scale() const { return scale_; }  // cells per unit of the mesh

    // Adds the row of cells j (all i, k) to `fractions`; true when components overlap there.
    bool row(int j, std::vector<double>& fractions) const {
        std::vector<Crossing> crossings;
        for (const int t : rows_[idx(j)]) cross(t, j, crossings);
        std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
            if (a.ray != b.ray) return a.ray < b.ray;
            if (a.x != b.x) return a.x < b.x;
            return a.turn > b.turn;
        });
        const double weight = 1.0 / (subsamples_ * subsamples_);
        int winding = 0;
        bool overlap = false;
        double from = 0.0;
        for (std::size_t c = 0; c < crossings.size(); ++c) {
            const Crossing& now = crossings[c];
            if (c == 0 || crossings[c - 1].ray != now.ray) winding = 0;
            const int next = winding + now.turn;
            if (winding <= 0 && next > 0) from = now.x;
            if (winding > 0 && next <= 0) {
                const int k = now.ray / (subsamples_ * subsamples_);
                add_segment(from, now.x, weight, j, k, fractions);
            }
            if (winding > 1 && now.x > crossings[c - 1].x) overlap = true;
            winding = next;
        }
        return overlap;
    }

private:
    // Rays stand at odd multiples of `half_` from the centre (odd or even, as the number of rays is even or odd).
    Int ray_position(int ray, std::size_t axis) const { return (2 * ray + 1 - n_[axis] * subsamples_) * half_; }

    void place(const Vec3& centre, Margin margin) {
        Vec3 lo = mesh_.vertices.at(0), hi = lo;
        for (const Vec3& v : mesh_.vertices)
            for (std::size_t a = 0; a < 3; ++a) lo[a] = std::min(lo[a], v[a]), hi[a] = std::max(hi[a], v[a]);
        double scale = HUGE_VAL;
        for (std::size_t a = 0; a < 3; ++a) {
            const double reach = std::max(hi[a] - centre[a], centre[a] - lo[a]);
            if (reach > 0.0) scale = std::min(scale, (0.5 * n_[a] - margin.of(a)) / reach);
        }
        if (!std::isfinite(scale) || !(scale > 0.0))
            fail(Status::ERROR_MESH, "a mesh of extents %g x %g x %g cannot be scaled to the box", hi[0] - lo[0],
                 hi[1] - lo[1], hi[2] - lo[2]);
        scale_ = scale;
        length_ = (hi[0] - lo[0]) * scale;
        // The finest lattice whose coordinates stay below 2^29 within the box.
        half_ = 1;
        while (half_ * 2 * std::max(n_[1], n_[2]) * subsamples_ <= (Int{1} << 29)) half_ *= 2;
        const double per_cell = 2.0 * subsamples_ * static_cast<double>(half_);
        // Round-off must not let a touching mesh spill into the margin.
        const auto lattice = [&](double cells, std::size_t a) {
            const Int limit = (Int{n_[a]} - 2 * margin.of(a)) * subsamples_ * half_;
            return std::clamp<Int>(std::llround(cells * per_cell), -limit, limit);
        };
        vertices_.reserve(mesh_.vertices.size());
        for (const Vec3& v : mesh_.vertices)
            vertices_.push_back({std::clamp((v[0] - centre[0]) * scale + 0.5 * n_[0], double(margin.along),
                                            double(n_[0] - margin.along)),
                                 lattice((v[1] - centre[1]) * scale, 1), lattice((v[2] - centre[2]) * scale, 2)});
    }

    // First and last ray (last exclusive) of an axis whose positions lie in [lo, hi].
    std::pair<int, int> rays_between(Int lo, Int hi, std::size_t axis) const {
        const Int rays = Int{n_[axis]} * subsamples_, step = 2 * half_, first = ray_position(0, axis);
        const Int begin = std::clamp<Int>(ceil_div(lo - first, step), 0, rays);
        const Int end = std::clamp<Int>(floor_div(hi - first, step) + 1, 0, rays);
        return {static_cast<int>(begin), static_cast<int>(end)};
    }

    void bin_rows() {
        rows_.resize(idx(n_[1]));
        for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
            const auto& v = mesh_.triangles[t];
            const auto [lo, hi] = std::minmax({at(v[0]).y, at(v[1]).y, at(v[2]).y});
            const auto [begin, end] = rays_between(lo, hi, 1);
            if (begin >= end) continue;
            for (int j = begin / subsamples_; j <= (end - 1) / subsamples_; ++j)
                rows_[idx(j)].push_back(static_cast<int>(t));
        }
    }

    const LatticeVertex& at(int i) const { return vertices_[idx(i)]; }

    void cross(int t, int j, std::vector<Crossing>& out) const {
        const auto& v = mesh_.triangles[idx(t)];
        const LatticeVertex &a = at(v[0]), &b = at(v[1]), &c = at(v[2]);
        const Int area = (b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y);
        if (area == 0) return;          // seen edge-on: no ray in general position meets it
        const int facing = sign(area);  // +1: its normal points along +x, so a ray leaves the solid here
        const auto [ylo, yhi] = std::minmax({a.y, b.y, c.y});
        const auto [zlo, zhi] = std::minmax({a.z, b.z, c.z});
        auto [ray_y, ray_y_end] = rays_between(ylo, yhi, 1);
        const auto [ray_z, ray_z_end] = rays_between(zlo, zhi, 2);
        ray_y = std::max(ray_y, j * subsamples_);
        ray_y_end = std::min(ray_y_end, (j + 1) * subsamples_);
        for (int s = ray_y; s < ray_y_end; ++s)
            for (int r = ray_z; r < ray_z_end; ++r) {
                const Int y = ray_position(s, 1), z = ray_position(r, 2);
                Int wa = 0, wb = 0, wc = 0;
                if (side(b, c, y, z, wa) != facing || side(c, a, y, z, wb) != facing || side(a, b, y, z, wc) != facing)
                    continue;
                const double total = static_cast<double>(area);
                const double x =
                    (static_cast<double>(wa) * a.x + static_cast<double>(wb) * b.x + static_cast<double>(wc) * c.x) /
                    total;
                out.push_back({r * subsamples_ + s - j * subsamples_, x, -facing});
            }
    }

    void add_segment(double from, double to, double weight, int j, int k, std::vector<double>& fractions) const {
        const int last = std::min(n_[0] - 1, static_cast<int>(std::floor(to)));
        for (int i = std::max(0, static_cast<int>(std::floor(from))); i <= last; ++i) {
            const double covered = std::min(to, i + 1.0) - std::max(from, double(i));
            if (covered > 0.0) fractions[idx(box_.cell(i, j, k))] += weight * covered;
        }
    }

    const TriangleMesh& mesh_;
    const Box& box_;
    std::array<int, 3> n_;
    int subsamples_;
    Int half_ = 1;  // half the distance between rays, lattice units
    double scale_ = 0.0, length_ = 0.0;
    std::vector<LatticeVertex> vertices_;
    std::vector<std::vector<int>> rows_;  // triangles that rays of the cells j may meet
};

// Centroid of fractions relative to the centre of the box (cells).
Vec3 centroid(const Box& box, const std::vector<double>& fractions) {
    Vec3 first{0, 0, 0};
    double sum = 0.0;
    for (int c = 0; c < box.n_cells(); ++c) {
        const auto ijk = box.cell_ijk(c);
        sum += fractions[idx(c)];
        for (std::size_t a = 0; a < 3; ++a) first[a] += fractions[idx(c)] * (ijk[a] + 0.5 - 0.5 * box.cells[a]);
    }
    for (double& x : first) x = sum > 0.0 ? x / sum : 0.0;
    return first;
}

}  // namespace

std::vector<double> covered_fractions(const TriangleMesh& cleaned, const Box& box, Margin margin, int subsamples,
                                      int threads, double* length_in_cells) {
    for (std::size_t a = 0; a < 3; ++a)
        if (box.cells[a] < 1 || box.cells[a] > 4096)
            fail(Status::ERROR_ARGUMENT, "the box has %d cells along %c; expected 1 to 4096", box.cells[a], "xyz"[a]);
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (margin.of(axis) < 0 || 2 * margin.of(axis) >= box.cells[axis])
            fail(Status::ERROR_ARGUMENT, "a margin of %d cells leaves no room in a box of %d x %d x %d cells",
                 margin.of(axis), box.cells[0], box.cells[1], box.cells[2]);
    if (subsamples < 1 || subsamples > 64)
        fail(Status::ERROR_ARGUMENT, "subsamples is %d; expected 1 to 64", subsamples);
    if (cleaned.triangles.empty()) fail(Status::ERROR_MESH, "a mesh without triangles cannot be voxelised");
    std::vector<double> fractions;
    Vec3 centre = mesh_centre_of_mass(cleaned);
    for (int pass = 0;; ++pass) {
        const Voxelizer voxelizer(cleaned, centre, box, margin, subsamples);
        fractions.assign(static_cast<std::size_t>(box.n_cells()), 0.0);
        std::vector<char> overlap(idx(box.cells[1]), 0);
        parallel_chunks(threads, box.cells[1], 1, [&](int begin, int end) {
            for (int j = begin; j < end; ++j) overlap[idx(j)] = voxelizer.row(j, fractions);
        });
        for (double& f : fractions) f = std::min(f, 1.0);  // round-off above 1
        if (length_in_cells) *length_in_cells = voxelizer.length();
        // The centre of mass from the triangles counts an overlap twice; the fractions do not. The shift changes the
        // scale a little and thereby the fractions, so it is made twice.
        if (pass == 2 || std::find(overlap.begin(), overlap.end(), 1) == overlap.end()) return fractions;
        const Vec3 shift = centroid(box, fractions);
        for (std::size_t a = 0; a < 3; ++a)
            if (std::fabs(shift[a]) > 1e-9) centre[a] += shift[a] / voxelizer.scale();
    }
}

}  // namespace dqa
