// SPDX-License-Identifier: MIT
// Pairs of triangles that meet: a tree of bounding boxes finds the candidates, separating axes decide. Two triangles
// are apart if they are along one of a few axes: the normals, the normals' products with the edges and the products of
// the edges.
#include "shape/triangle_crossings.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "shape/bounds.hpp"
#include "shape/vector.hpp"

namespace dqa {
namespace {

std::size_t idx(int i) {
    return static_cast<std::size_t>(i);
}

using Triangle = std::array<Vec3, 3>;

// Whether along `axis`, of any length, two triangles have a gap wider than kTouching between them. An axis that
// vanishes shows none.
bool gap_along(const Triangle& p, const Triangle& q, const Vec3& axis) {
    const auto [p_lo, p_hi] = std::minmax({dot(p[0], axis), dot(p[1], axis), dot(p[2], axis)});
    const auto [q_lo, q_hi] = std::minmax({dot(q[0], axis), dot(q[1], axis), dot(q[2], axis)});
    const double gap = std::max(q_lo - p_hi, p_lo - q_hi);
    return gap > 0 && gap * gap > kTouching * kTouching * dot(axis, axis);
}

// Two edges that start at the common corner of triangles: the cone of one of them.
using Cone = std::array<Vec3, 2>;

// Whether the plane through the corner across `axis` has one cone strictly on one side and the other not beyond it.
bool cones_apart(const Cone& p, const Cone& q, const Vec3& axis) {
    const auto [p_lo, p_hi] = std::minmax({dot(p[0], axis), dot(p[1], axis)});
    const auto [q_lo, q_hi] = std::minmax({dot(q[0], axis), dot(q[1], axis)});
    if (!(q_lo > 0 || p_hi < 0 || p_lo > 0 || q_hi < 0)) return false;
    const double length = norm(axis), strict = kTouching * length, rounding = 1e-2 * strict;
    return (p_hi <= rounding && q_lo > strict) || (p_hi < -strict && q_lo >= -rounding) ||
           (q_hi <= rounding && p_lo > strict) || (q_hi < -strict && p_lo >= -rounding);
}

class Pairs {
public:
    Pairs(const std::vector<Vec3>& vertices, const std::vector<std::array<int, 3>>& triangles)
        : vertices_(vertices), triangles_(triangles) {
        normal_.reserve(triangles.size());
        for (const auto& t : triangles) normal_.push_back(cross(minus(at(t[1]), at(t[0])), minus(at(t[2]), at(t[0]))));
    }

    bool meet(int s, int t) const {
        std::array<int, 3> a = triangles_[idx(s)], b = triangles_[idx(t)];
        // Common corners come first in both, in the same order.
        std::size_t common = 0;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = common; j < 3; ++j)
                if (a[i] == b[j]) {
                    std::swap(a[common], a[i]), std::swap(b[common], b[j]);
                    ++common;
                    break;
                }
        const Vec3 &n = normal_[idx(s)], &m = normal_[idx(t)];
        // Relative to one corner rounding is that of the triangles' size, not of their place.
        const Vec3& origin = at(a[0]);
        const Triangle p{Vec3{0, 0, 0}, minus(at(a[1]), origin), minus(at(a[2]), origin)};
        const Triangle q{minus(at(b[0]), origin), minus(at(b[1]), origin), minus(at(b[2]), origin)};
        switch (common) {
            case 0:
                return meet_apart(p, q, n, m);
            case 1:
                return meet_beyond_corner({p[1], p[2]}, {q[1], q[2]}, n, m);
            case 2:
                return folded(p[1], p[2], q[2]);
            default:
                return true;
        }
    }

private:
    const Vec3& at(int i) const { return vertices_[idx(i)]; }

    // The planes of the triangles decide nearly all candidates, so they come first.
    static bool meet_apart(const Triangle& p, const Triangle& q, const Vec3& n, const Vec3& m) {
        if (gap_along(p, q, n) || gap_along(p, q, m)) return false;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 e = minus(p[(i + 1) % 3], p[i]), f = minus(q[(i + 1) % 3], q[i]);
            if (gap_along(p, q, cross(n, e)) || gap_along(p, q, cross(m, f))) return false;
            for (std::size_t j = 0; j < 3; ++j)
                if (gap_along(p, q, cross(e, minus(q[(j + 1) % 3], q[j])))) return false;
        }
        return true;
    }

    static bool meet_beyond_corner(const Cone& p, const Cone& q, const Vec3& n, const Vec3& m) {
        if (cones_apart(p, q, n) || cones_apart(p, q, m)) return false;
        for (const Vec3& e : p)
            if (cones_apart(p, q, cross(n, e))) return false;
        for (const Vec3& f : q)
            if (cones_apart(p, q, cross(m, f))) return false;
        for (const Vec3& e : p)
            for (const Vec3& f : q)
                if (cones_apart(p, q, cross(e, f))) return false;
        return true;
    }

    // Triangles with a common edge meet elsewhere only if one is folded onto the other.
    static bool folded(const Vec3& edge, const Vec3& p, const Vec3& q) {
        const double square = dot(edge, edge);
        if (!(square > 0)) return true;
        const Vec3 a = minus(p, scaled(edge, dot(p, edge) / square)), b = minus(q, scaled(edge, dot(q, edge) / square));
        const double a2 = dot(a, a), b2 = dot(b, b), touching2 = kTouching * kTouching;
        if (a2 <= touching2 || b2 <= touching2) return true;  // no area: it has no plane
        if (!(dot(a, b) > 0)) return false;
        const Vec3 turn = cross(a, b);
        return dot(turn, turn) <= touching2 * std::max(a2, b2);
    }

    const std::vector<Vec3>& vertices_;
    const std::vector<std::array<int, 3>>& triangles_;
    std::vector<Vec3> normal_;  // of twice the area
};

// Binary tree over triangles, halved along the longest side of the boxes down to kLeaf triangles.
class BoundsTree {
public:
    BoundsTree(const std::vector<Vec3>& vertices, const std::vector<std::array<int, 3>>& triangles) {
        for (const auto& t : triangles) {
            Bounds b;
            for (const int i : t) b.include(vertices[idx(i)]);
            boxes_.push_back(b);
        }
        order_.resize(triangles.size());
        std::iota(order_.begin(), order_.end(), 0);
        root_ = build(0, static_cast<int>(order_.size()));
    }

    // f(s, t) once for each pair of triangles whose boxes come near.
    template <class F>
    void for_pairs(const F& f) const {
        within(root_, f);
    }

private:
    static constexpr int kLeaf = 4;
    struct Node {
        Bounds bounds;
        int begin, end;
        int left, right;  // -1 in a leaf
    };

    int build(int begin, int end) {
        Bounds b;
        for (int i = begin; i < end; ++i) b.include(boxes_[idx(order_[idx(i)])]);
        const int self = static_cast<int>(nodes_.size());
        nodes_.push_back({b, begin, end, -1, -1});
        if (end - begin <= kLeaf) return self;
        const std::size_t axis = b.longest_axis();
        const int middle = begin + (end - begin) / 2;
        std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int s, int t) {
            const Bounds &p = boxes_[idx(s)], &q = boxes_[idx(t)];
            const double x = p.lo[axis] + p.hi[axis], y = q.lo[axis] + q.hi[axis];
            return x != y ? x < y : s < t;
        });
        const int left = build(begin, middle), right = build(middle, end);
        nodes_[idx(self)].left = left, nodes_[idx(self)].right = right;
        return self;
    }

    template <class F>
    void within(int a, const F& f) const {
        const Node& n = nodes_[idx(a)];
        if (n.left < 0) {
            for (int i = n.begin; i < n.end; ++i)
                for (int j = i + 1; j < n.end; ++j) candidate(i, j, f);
            return;
        }
        within(n.left, f), within(n.right, f), between(n.left, n.right, f);
    }

    template <class F>
    void between(int a, int b, const F& f) const {
        const Node &p = nodes_[idx(a)], &q = nodes_[idx(b)];
        if (!p.bounds.near(q.bounds, kTouching)) return;
        if (p.left < 0 && q.left < 0) {
            for (int i = p.begin; i < p.end; ++i)
                for (int j = q.begin; j < q.end; ++j) candidate(i, j, f);
        } else if (q.left < 0 || (p.left >= 0 && p.end - p.begin >= q.end - q.begin)) {
            between(p.left, b, f), between(p.right, b, f);
        } else {
            between(a, q.left, f), between(a, q.right, f);
        }
    }

    template <class F>
    void candidate(int i, int j, const F& f) const {
        const int s = order_[idx(i)], t = order_[idx(j)];
        if (boxes_[idx(s)].near(boxes_[idx(t)], kTouching)) f(s, t);
    }

    std::vector<Bounds> boxes_;  // of the triangles
    std::vector<int> order_;     // of the triangles in the leaves
    std::vector<Node> nodes_;
    int root_ = 0;
};

}  // namespace

TriangleCrossings triangle_crossings(const std::vector<Vec3>& vertices,
                                     const std::vector<std::array<int, 3>>& triangles) {
    std::vector<std::pair<int, int>> found;
    const Pairs pairs(vertices, triangles);
    BoundsTree(vertices, triangles).for_pairs([&](int s, int t) {
        if (!pairs.meet(s, t)) return;
        found.emplace_back(s, t), found.emplace_back(t, s);
    });
    std::sort(found.begin(), found.end());
    TriangleCrossings out;
    out.first.assign(triangles.size() + 1, 0);
    for (const auto& [s, t] : found) ++out.first[idx(s) + 1], out.partner.push_back(t);
    std::partial_sum(out.first.begin(), out.first.end(), out.first.begin());
    return out;
}

}  // namespace dqa
