// SPDX-License-Identifier: MIT
// Triangles meet where an edge of one meets the other, so every edge is held against the triangles near it, which a
// tree of bounding boxes finds. An edge and a triangle with a common corner need no test: where they meet elsewhere,
// the edge opposite of the corner in one of the two triangles meets the other. Separating axes decide: two convex sets
// are apart if they are along one of a few axes.
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

class Meetings {
public:
    Meetings(const std::vector<Vec3>& vertices, const std::vector<std::array<int, 3>>& triangles)
        : vertices_(vertices), triangles_(triangles) {
        normal_.reserve(triangles.size());
        for (const auto& t : triangles) normal_.push_back(cross(minus(at(t[1]), at(t[0])), minus(at(t[2]), at(t[0]))));
    }

    // Whether an edge meets a triangle that has none of its ends for a corner.
    bool pierces(int from, int to, int t) const {
        // Relative to one corner rounding is that of the triangle's size, not of its place.
        const Vec3& origin = at(triangles_[idx(t)][0]);
        const Vec3 start = minus(at(from), origin), end = minus(at(to), origin), along = minus(end, start);
        const Vec3& n = normal_[idx(t)];
        // Both ends on one side of the plane: that decides nearly all, so it comes first.
        const double one = dot(n, start), other = dot(n, end), least = std::min(std::fabs(one), std::fabs(other));
        if ((one > 0) == (other > 0) && least * least > kTouching * kTouching * dot(n, n)) return false;
        const Triangle p{Vec3{0, 0, 0}, minus(at(triangles_[idx(t)][1]), origin),
                         minus(at(triangles_[idx(t)][2]), origin)};
        const Triangle q{start, end, end};
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 side = minus(p[(k + 1) % 3], p[k]);
            if (gap_along(p, q, cross(n, side)) || gap_along(p, q, cross(along, side))) return false;
        }
        return !gap_along(p, q, cross(n, along)) && !gap_along(p, q, along);
    }

    // Whether triangles with a common edge meet elsewhere: only if one is folded onto the other.
    bool folded(const TriangleEdge& one, const TriangleEdge& other) const {
        const Vec3& origin = at(one.lo);
        const Vec3 edge = minus(at(one.hi), origin), p = minus(at(opposite(one)), origin),
                   q = minus(at(opposite(other)), origin);
        const double square = dot(edge, edge);
        if (!(square > 0)) return true;
        const Vec3 a = minus(p, scaled(edge, dot(p, edge) / square)), b = minus(q, scaled(edge, dot(q, edge) / square));
        const double a2 = dot(a, a), b2 = dot(b, b), touching2 = kTouching * kTouching;
        if (a2 <= touching2 || b2 <= touching2) return true;  // no area: it has no plane
        if (!(dot(a, b) > 0)) return false;
        const Vec3 turn = cross(a, b);
        return dot(turn, turn) <= touching2 * std::max(a2, b2);
    }

private:
    const Vec3& at(int i) const { return vertices_[idx(i)]; }
    int opposite(const TriangleEdge& e) const {
        const auto& t = triangles_[idx(e.triangle)];
        return t[0] != e.lo && t[0] != e.hi ? t[0] : t[1] != e.lo && t[1] != e.hi ? t[1] : t[2];
    }

    const std::vector<Vec3>& vertices_;
    const std::vector<std::array<int, 3>>& triangles_;
    std::vector<Vec3> normal_;  // of twice the area
};

// Binary tree over triangles, halved along the longest side of the boxes down to kLeaf triangles.
class BoundsTree {
public:
    BoundsTree(const std::vector<Vec3>& vertices, const std::vector<std::array<int, 3>>& triangles)
        : triangles_(triangles) {
        for (const auto& t : triangles) {
            Bounds b;
            for (const int i : t) b.include(vertices[idx(i)]);
            boxes_.push_back(b);
        }
        order_.resize(triangles.size());
        std::iota(order_.begin(), order_.end(), 0);
        root_ = build(0, static_cast<int>(order_.size()));
    }

    // f(t) for the triangles whose boxes come near and of which neither `from` nor `to` is a corner.
    template <class F>
    void for_near(const Bounds& box, int from, int to, const F& f) const {
        visit(root_, box, from, to, f);
    }

private:
    static constexpr int kLeaf = 4;
    struct Node {
        Bounds bounds;
        int begin, end;
        int left, right;            // -1 in a leaf
        std::array<int, 3> common;  // corners of all its triangles: a fan is passed over at once; -1: none
    };

    int build(int begin, int end) {
        Bounds b;
        for (int i = begin; i < end; ++i) b.include(boxes_[idx(order_[idx(i)])]);
        const int self = static_cast<int>(nodes_.size());
        nodes_.push_back({b, begin, end, -1, -1, triangles_[idx(order_[idx(begin)])]});
        if (end - begin <= kLeaf) {
            for (int i = begin + 1; i < end; ++i) keep_common(nodes_[idx(self)], triangles_[idx(order_[idx(i)])]);
            return self;
        }
        const std::size_t axis = b.longest_axis();
        const int middle = begin + (end - begin) / 2;
        std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int s, int t) {
            const Bounds &p = boxes_[idx(s)], &q = boxes_[idx(t)];
            const double x = p.lo[axis] + p.hi[axis], y = q.lo[axis] + q.hi[axis];
            return x != y ? x < y : s < t;
        });
        const int left = build(begin, middle), right = build(middle, end);
        Node& node = nodes_[idx(self)];
        node.left = left, node.right = right, node.common = nodes_[idx(left)].common;
        keep_common(node, nodes_[idx(right)].common);
        return self;
    }

    static void keep_common(Node& node, const std::array<int, 3>& others) {
        for (int& c : node.common)
            if (std::find(others.begin(), others.end(), c) == others.end()) c = -1;
    }

    static bool has(const std::array<int, 3>& corners, int from, int to) {
        for (const int c : corners)
            if (c == from || c == to) return true;
        return false;
    }

    template <class F>
    void visit(int number, const Bounds& box, int from, int to, const F& f) const {
        const Node& n = nodes_[idx(number)];
        if (!n.bounds.near(box, kTouching) || has(n.common, from, to)) return;
        if (n.left >= 0) {
            visit(n.left, box, from, to, f), visit(n.right, box, from, to, f);
            return;
        }
        for (int i = n.begin; i < n.end; ++i) {
            const int t = order_[idx(i)];
            if (!has(triangles_[idx(t)], from, to) && boxes_[idx(t)].near(box, kTouching)) f(t);
        }
    }

    const std::vector<std::array<int, 3>>& triangles_;
    std::vector<Bounds> boxes_;  // of the triangles
    std::vector<int> order_;     // of the triangles in the leaves
    std::vector<Node> nodes_;
    int root_ = 0;
};

}  // namespace

std::vector<TriangleEdge> triangle_edges(const std::vector<std::array<int, 3>>& triangles) {
    std::vector<TriangleEdge> edges;
    edges.reserve(3 * triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [lo, hi] = std::minmax(triangles[t][k], triangles[t][(k + 1) % 3]);
            edges.push_back({lo, hi, static_cast<int>(t)});
        }
    std::sort(edges.begin(), edges.end(), [](const TriangleEdge& a, const TriangleEdge& b) {
        if (a.lo != b.lo) return a.lo < b.lo;
        return a.hi != b.hi ? a.hi < b.hi : a.triangle < b.triangle;
    });
    return edges;
}

TriangleCrossings triangle_crossings(const std::vector<Vec3>& vertices,
                                     const std::vector<std::array<int, 3>>& triangles,
                                     const std::vector<TriangleEdge>& edges) {
    std::vector<std::pair<int, int>> found;
    const auto pair = [&](int s, int t) { found.emplace_back(s, t), found.emplace_back(t, s); };
    const Meetings meetings(vertices, triangles);
    const BoundsTree tree(vertices, triangles);
    for (std::size_t e = 0, end = 0; e < edges.size(); e = end) {
        const TriangleEdge& edge = edges[e];
        while (end < edges.size() && edges[end].lo == edge.lo && edges[end].hi == edge.hi) ++end;
        Bounds box;
        box.include(vertices[idx(edge.lo)]), box.include(vertices[idx(edge.hi)]);
        tree.for_near(box, edge.lo, edge.hi, [&](int t) {
            if (!meetings.pierces(edge.lo, edge.hi, t)) return;
            for (std::size_t k = e; k < end; ++k) pair(edges[k].triangle, t);
        });
        for (std::size_t i = e; i < end; ++i)
            for (std::size_t k = i + 1; k < end; ++k)
                if (meetings.folded(edges[i], edges[k])) pair(edges[i].triangle, edges[k].triangle);
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    TriangleCrossings out;
    out.first.assign(triangles.size() + 1, 0);
    for (const auto& [s, t] : found) ++out.first[idx(s) + 1], out.partner.push_back(t);
    std::partial_sum(out.first.begin(), out.first.end(), out.first.begin());
    return out;
}

}  // namespace dqa
