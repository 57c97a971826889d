// SPDX-License-Identifier: MIT
// Triangles that meet no other keep one winding number in front over all of their area, and so does a patch of them
// that is joined along edges of two triangles: one ray decides for the patch. A crossed triangle is cut along the
// planes of its partners, and a ray decides for every piece; so the surface is exact, whatever its components do.
//
// Sheets of several components that lie on one another form a stack: the winding number on both sides of the whole
// stack decides, and the triangle of the lowest number speaks for it. Triangles that come that close are cut where
// their distance passes the limit, so that all pieces of a stack agree on who belongs to it.
#include "shape/outer_surface.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "shape/bounds.hpp"
#include "shape/triangle_crossings.hpp"
#include "shape/vector.hpp"
#include "shape/winding_number.hpp"

namespace dqa {
namespace {

// Faces that coincide but for the rounding of a file's numbers cross at tiny angles, and where they do, no distance
// tells which one is in front. Corners of meshes whose surfaces meet are rounded to a grid far coarser than kTogether,
// so that such faces either coincide or differ by more nearly everywhere.
constexpr double kGrid = 0x1p-23;
constexpr double kTogether = 1e-12;     // sheets no further apart lie on one another
constexpr double kNearParallel = 1e-5;  // sine between planes that may stay so close over a width that matters
constexpr double kOnPlane = 1e-13;      // rounding of a distance
constexpr double kNoArea = 1e-14;       // of a sliver that cutting leaves
static_assert(kOnPlane < kTogether && kTogether < kTouching);

std::size_t idx(int i) {
    return static_cast<std::size_t>(i);
}

// A point within a polygon that no symmetry of the mesh prefers; every attempt gives another.
Vec3 point_within(const ConvexPolygon& p, int attempt) {
    Vec3 sum{0, 0, 0};
    double total = 0.0;
    for (int i = 0; i < p.n; ++i) {
        const double turn = 0.6180339887498949 * (i + 1) + 0.7548776662466927 * attempt;
        const double weight = 0.5 + (turn - std::floor(turn));
        sum = plus(sum, scaled(p[i], weight)), total += weight;
    }
    return scaled(sum, 1.0 / total);
}

double area_of(const ConvexPolygon& p) {
    Vec3 sum{0, 0, 0};
    for (int i = 1; i + 1 < p.n; ++i) sum = plus(sum, cross(minus(p[i], p[0]), minus(p[i + 1], p[0])));
    return 0.5 * norm(sum);
}

bool has_area(const ConvexPolygon& p) {
    return p.n >= 3 && area_of(p) > kNoArea;
}

Bounds bounds_of(const ConvexPolygon& p) {
    Bounds b;
    for (int i = 0; i < p.n; ++i) b.include(p[i]);
    return b;
}

struct Plane {
    Vec3 normal, origin;
    double offset = 0.0;  // along the normal
    double height(const Vec3& x) const {
        const double h = dot(normal, minus(x, origin)) - offset;
        return std::fabs(h) < kOnPlane ? 0.0 : h;
    }
    // Whether a polygon has corners on both sides.
    bool parts(const ConvexPolygon& p) const {
        bool below = false, above = false;
        for (int i = 0; i < p.n; ++i) {
            const double h = height(p[i]);
            below = below || h < 0, above = above || h > 0;
        }
        return below && above;
    }
};

// A triangle that meets another one, and the part of it that lies within kTouching of the other's plane.
struct Partner {
    int triangle;
    Bounds reach;
};

class Weigher {
public:
    Weigher(const std::vector<Vec3>& vertices, const std::vector<std::array<int, 3>>& triangles,
            const std::vector<TriangleEdge>& edges, const TriangleCrossings& crossings)
        : vertices_(vertices), triangles_(triangles), edges_(edges), crossings_(crossings) {
        normal_.reserve(triangles.size());
        for (int t = 0; t < size(); ++t) {
            const Vec3 n = cross(minus(corner(t, 1), corner(t, 0)), minus(corner(t, 2), corner(t, 0)));
            const double length = norm(n);
            normal_.push_back(length > 0 ? scaled(n, 1.0 / length) : Vec3{0, 0, 0});
        }
    }

    OuterSurface surface() {
        const std::vector<int> weight = patch_weights();
        for (int t = 0; t < size(); ++t) {
            if (!crossings_.any(t))
                keep(whole(t), weight[idx(t)]);
            else if (dot(normal_[idx(t)], normal_[idx(t)]) > 0)
                split(t, whole(t), partners_of(t), 0);
        }
        return std::move(out_);
    }

private:
    int size() const { return static_cast<int>(triangles_.size()); }
    const Vec3& corner(int t, std::size_t k) const { return vertices_[idx(triangles_[idx(t)][k])]; }
    ConvexPolygon whole(int t) const {
        ConvexPolygon out;
        for (std::size_t k = 0; k < 3; ++k) out.add(corner(t, k));
        return out;
    }

    // Weight 1: the solid lies behind the polygon; -1: in front of it; 0: on both sides or on none.
    void keep(const ConvexPolygon& p, int weight) {
        if (weight != 1) out_.simple = false;
        if (weight == 0) return;
        for (int i = 0; i < p.n; ++i) out_.corner.push_back(p[weight > 0 ? i : p.n - 1 - i]);
        out_.first.push_back(out_.corner.size());
    }

    // The patch of each triangle, called by one of its triangles.
    std::vector<int> patches() const {
        std::vector<int> parent(triangles_.size());
        std::iota(parent.begin(), parent.end(), 0);
        const auto root = [&](int i) {
            while (parent[idx(i)] != i) i = parent[idx(i)] = parent[idx(parent[idx(i)])];
            return i;
        };
        for (std::size_t e = 0; e < edges_.size();) {
            std::size_t end = e;
            while (end < edges_.size() && edges_[end].lo == edges_[e].lo && edges_[end].hi == edges_[e].hi) ++end;
            const int s = edges_[e].triangle, t = edges_[end - 1].triangle;
            if (end - e == 2 && !crossings_.any(s) && !crossings_.any(t)) parent[idx(root(s))] = root(t);
            e = end;
        }
        for (int t = 0; t < size(); ++t) parent[idx(t)] = root(t);
        return parent;
    }

    // Weights of the triangles that meet no other.
    std::vector<int> patch_weights() {
        const std::vector<int> patch = patches();
        // The largest triangle speaks for its patch: there the ray starts farthest from all edges.
        std::vector<int> speaker(triangles_.size(), -1);
        std::vector<double> largest(triangles_.size(), -1.0);
        int n_patches = 0;
        for (int t = 0; t < size(); ++t) {
            const std::size_t p = idx(patch[idx(t)]);
            const double area = norm(cross(minus(corner(t, 1), corner(t, 0)), minus(corner(t, 2), corner(t, 0))));
            if (largest[p] < 0) ++n_patches;
            if (area > largest[p]) largest[p] = area, speaker[p] = t;
        }
        // In one piece and uncrossed: the volume is positive, so the solid lies behind.
        if (n_patches == 1) return std::vector<int>(triangles_.size(), 1);
        std::vector<int> weight(triangles_.size(), 0);
        for (std::size_t p = 0; p < weight.size(); ++p)
            if (speaker[p] >= 0 && !crossings_.any(speaker[p])) weight[p] = weigh(speaker[p], whole(speaker[p]), {});
        std::vector<int> out;
        out.reserve(weight.size());
        for (const int p : patch) out.push_back(weight[idx(p)]);
        return out;
    }

    std::vector<Partner> partners_of(int t) const {
        const Plane plane{normal_[idx(t)], corner(t, 0)};
        std::vector<Partner> partners;
        for (std::size_t k = crossings_.first[idx(t)]; k < crossings_.first[idx(t) + 1]; ++k) {
            const int other = crossings_.partner[k];
            if (dot(normal_[idx(other)], normal_[idx(other)]) == 0) continue;
            Partner p{other, {}};
            for (std::size_t i = 0; i < 3; ++i) {
                const Vec3 &a = corner(other, i), &b = corner(other, (i + 1) % 3);
                const double from = plane.height(a), to = plane.height(b);
                if (std::fabs(from) <= kTouching) p.reach.include(a);
                for (const double level : {-kTouching, kTouching})
                    if ((from < level) != (to < level))
                        p.reach.include(plus(a, scaled(minus(b, a), (level - from) / (to - from))));
            }
            partners.push_back(p);
        }
        return partners;
    }

    // The planes along which a partner divides triangle t: its own, and of one that may lie on t also where their
    // distance passes the limit and where the partner ends.
    std::vector<Plane> dividing_planes(int t, int partner) const {
        const Vec3 &n = normal_[idx(t)], &m = normal_[idx(partner)];
        std::vector<Plane> planes{{m, corner(partner, 0)}};
        if (norm(cross(n, m)) > kNearParallel) return planes;
        for (const double limit : {-kTogether, kTogether}) planes.push_back({m, corner(partner, 0), limit});
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 across = cross(n, minus(corner(partner, (k + 1) % 3), corner(partner, k)));
            const double length = norm(across);
            if (length > 0) planes.push_back({scaled(across, 1.0 / length), corner(partner, k)});
        }
        return planes;
    }

    // Cuts a piece of triangle t along those of its partners that reach it, and keeps what bounds the solid. The first
    // `settled` partners do not divide the piece.
    void split(int t, const ConvexPolygon& piece, const std::vector<Partner>& near_parent, std::size_t settled) {
        const Bounds bounds = bounds_of(piece);
        std::vector<Partner> partners;
        std::size_t begin = 0;
        for (std::size_t k = 0; k < near_parent.size(); ++k)
            if (near_parent[k].reach.near(bounds, kTouching)) {
                partners.push_back(near_parent[k]);
                begin += k < settled;
            }
        if (halve(t, piece, bounds, partners, begin)) return;
        for (std::size_t k = begin; k < partners.size(); ++k)
            for (const Plane& plane : dividing_planes(t, partners[k].triangle)) {
                if (!plane.parts(piece)) continue;
                ConvexPolygon below, above;
                cut(
                    piece, [&](const Vec3& x) { return plane.height(x); }, below, above);
                if (!has_area(below) || !has_area(above)) continue;
                split(t, below, partners, k), split(t, above, partners, k);
                return;
            }
        keep(piece, weigh(t, piece, partners));
    }

    // Of many partners most reach only one half of a piece: halving first saves cutting along all of them. A piece with
    // many corners is halved between them.
    bool halve(int t, const ConvexPolygon& piece, const Bounds& bounds, const std::vector<Partner>& partners,
               std::size_t settled) {
        constexpr std::size_t kFew = 8;
        ConvexPolygon one, other;
        if (piece.n > OuterSurface::kMostCorners) {
            const int middle = piece.n / 2;
            for (int i = 0; i <= middle; ++i) one.add(piece[i]);
            for (int i = middle; i < piece.n; ++i) other.add(piece[i]);
            other.add(piece[0]);
        } else {
            const std::size_t axis = bounds.longest_axis();
            const double middle = 0.5 * (bounds.lo[axis] + bounds.hi[axis]);
            std::size_t both = 0;
            for (const Partner& p : partners) both += p.reach.lo[axis] <= middle && p.reach.hi[axis] >= middle;
            if (partners.size() <= settled + kFew || 2 * both > partners.size()) return false;
            cut(
                piece, [&](const Vec3& x) { return x[axis] - middle; }, one, other);
            if (!has_area(one) || !has_area(other)) return false;
        }
        split(t, one, partners, settled), split(t, other, partners, settled);
        return true;
    }

    bool lies_on(const Vec3& x, int t) const {
        const Vec3& n = normal_[idx(t)];
        if (std::fabs(dot(n, minus(x, corner(t, 0)))) > kTogether) return false;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 &a = corner(t, k), &b = corner(t, (k + 1) % 3);
            if (dot(n, cross(minus(b, a), minus(x, a))) < 0) return false;
        }
        return true;
    }

    int weigh(int t, const ConvexPolygon& piece, const std::vector<Partner>& partners) {
        const Vec3& n = normal_[idx(t)];
        std::size_t axis = 0;  // of the ray: the one that meets the triangle least obliquely
        for (std::size_t a = 1; a < 3; ++a)
            if (std::fabs(n[a]) > std::fabs(n[axis])) axis = a;
        if (!winding_[axis]) winding_[axis] = std::make_unique<WindingNumber>(vertices_, triangles_, axis);
        constexpr int kAttempts = 16;
        for (int attempt = 0; attempt < kAttempts; ++attempt) {
            const Vec3 x = point_within(piece, attempt);
            std::vector<int> stack{t};
            for (const Partner& p : partners)
                if (norm(cross(n, normal_[idx(p.triangle)])) <= kNearParallel && lies_on(x, p.triangle))
                    stack.push_back(p.triangle);
            if (*std::min_element(stack.begin(), stack.end()) < t) return 0;
            int through = 0;  // by how much the number grows from the front of the stack to its back
            for (const int s : stack) through += dot(n, normal_[idx(s)]) > 0 ? 1 : -1;
            const WindingNumber::Count ahead = winding_[axis]->ahead(x, stack);
            if (ahead.uncertain && attempt + 1 < kAttempts) continue;
            // The ray starts in front of the stack and leaves it behind, or starts there and passes through it.
            const int front = n[axis] > 0 ? ahead.winding : ahead.winding - through;
            return (front + through > 0) - (front > 0);
        }
        return 0;
    }

    const std::vector<Vec3>& vertices_;
    const std::vector<std::array<int, 3>>& triangles_;
    const std::vector<TriangleEdge>& edges_;
    const TriangleCrossings& crossings_;
    std::vector<Vec3> normal_;                               // of unit length; 0 where a triangle has no area
    std::array<std::unique_ptr<WindingNumber>, 3> winding_;  // by the axis of the rays, made when needed
    OuterSurface out_;
};

}  // namespace

OuterSurface outer_surface(const std::vector<Vec3>& vertices, const std::vector<std::array<int, 3>>& triangles) {
    std::vector<Vec3> rounded = vertices;
    for (Vec3& v : rounded)
        for (double& x : v) x = std::round(x / kGrid) * kGrid;
    const std::vector<TriangleEdge> edges = triangle_edges(triangles);
    const TriangleCrossings crossings = triangle_crossings(rounded, triangles, edges);
    OuterSurface surface =
        Weigher(crossings.partner.empty() ? vertices : rounded, triangles, edges, crossings).surface();
    if (surface.simple) {
        surface.corner.clear(), surface.first.assign(1, 0);
        for (const auto& t : triangles) {
            for (const int i : t) surface.corner.push_back(vertices[idx(i)]);
            surface.first.push_back(surface.corner.size());
        }
    }
    return surface;
}

}  // namespace dqa
