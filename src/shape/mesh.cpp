// SPDX-License-Identifier: MIT
// Mesh checks by counting directed edges; volume, centre of mass and moments by summing tetrahedra that join each
// triangle to a fixed point (divergence theorem). Lengths in the unit of the mesh.
#include "shape/mesh.hpp"

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <unordered_map>

#include "grid/error.hpp"
#include "grid/log.hpp"

namespace dqa {
namespace {

constexpr double kSeam = 1e-6;  // of the extent: vertices that close may be meant as one

std::size_t idx(int i) {
    return static_cast<std::size_t>(i);
}

Vec3 sub(const Vec3& a, const Vec3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

double det(const Vec3& a, const Vec3& b, const Vec3& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

struct Bounds {
    Vec3 lo{0, 0, 0}, hi{0, 0, 0};
    Vec3 middle() const { return {0.5 * lo[0] + 0.5 * hi[0], 0.5 * lo[1] + 0.5 * hi[1], 0.5 * lo[2] + 0.5 * hi[2]}; }
    double largest() const { return std::max({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]}); }
};

Bounds bounds_of(const TriangleMesh& mesh) {
    Bounds b;
    if (mesh.vertices.empty()) return b;
    b.lo = b.hi = mesh.vertices[0];
    for (const Vec3& v : mesh.vertices)
        for (std::size_t a = 0; a < 3; ++a) {
            b.lo[a] = std::min(b.lo[a], v[a]);
            b.hi[a] = std::max(b.hi[a], v[a]);
        }
    return b;
}

// Corners of a triangle relative to an origin, divided by a length: tetrahedra to the origin then neither overflow nor
// cancel when the mesh is huge or far away.
std::array<Vec3, 3> corners(const TriangleMesh& mesh, const std::array<int, 3>& t, const Vec3& origin, double unit) {
    std::array<Vec3, 3> c;
    for (std::size_t p = 0; p < 3; ++p) {
        c[p] = sub(mesh.vertices[idx(t[p])], origin);
        for (double& x : c[p]) x /= unit;
    }
    return c;
}

struct Edge {
    int lo, hi;
    int triangle;
    bool forward;  // the triangle runs from lo to hi
};

std::vector<Edge> directed_edges(const TriangleMesh& mesh) {
    std::vector<Edge> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t p = 0; p < 3; ++p) {
            const int a = mesh.triangles[t][p], b = mesh.triangles[t][(p + 1) % 3];
            edges.push_back({std::min(a, b), std::max(a, b), static_cast<int>(t), a < b});
        }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
        if (a.lo != b.lo) return a.lo < b.lo;
        if (a.hi != b.hi) return a.hi < b.hi;
        return a.triangle < b.triangle;
    });
    return edges;
}

class Forest {  // union-find with path halving
public:
    explicit Forest(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
    int root(int i) {
        while (parent_[idx(i)] != i) i = parent_[idx(i)] = parent_[idx(parent_[idx(i)])];
        return i;
    }
    void join(int a, int b) { parent_[idx(root(a))] = root(b); }

private:
    std::vector<int> parent_;
};

void check_input(const TriangleMesh& in, const char* name) {
    if (in.triangles.empty())
        fail(Status::ERROR_MESH, "mesh '%s': no triangles (%zu vertices); expected a closed triangle mesh", name,
             in.vertices.size());
    if (in.triangles.size() > INT_MAX / 4 || in.vertices.size() > INT_MAX / 4)
        fail(Status::ERROR_MESH, "mesh '%s': %zu vertices and %zu triangles; at most %d of each are supported", name,
             in.vertices.size(), in.triangles.size(), INT_MAX / 4);
    for (std::size_t i = 0; i < in.vertices.size(); ++i) {
        const Vec3& v = in.vertices[i];
        for (const double x : v)
            if (!std::isfinite(x) || std::fabs(x) > 1e100)
                fail(Status::ERROR_MESH,
                     "mesh '%s': vertex %zu is (%g, %g, %g); expected finite coordinates below 1e100", name, i, v[0],
                     v[1], v[2]);
    }
    const int n = static_cast<int>(in.vertices.size());
    for (std::size_t t = 0; t < in.triangles.size(); ++t)
        for (const int i : in.triangles[t])
            if (i < 0 || i >= n)
                fail(Status::ERROR_MESH, "mesh '%s': triangle %zu refers to vertex %d; expected an index in [0, %d)",
                     name, t, i, n);
}

// Merges vertices with equal coordinates, drops triangles with a repeated vertex, drops unused vertices; the first
// occurrence keeps its place.
TriangleMesh weld(const TriangleMesh& in, MeshReport& report) {
    const std::size_t n = in.vertices.size();
    std::vector<int> order(n), first(n), renumbered(n, -1);
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) {
        const Vec3 &va = in.vertices[idx(a)], &vb = in.vertices[idx(b)];
        return va != vb ? va < vb : a < b;  // comparing doubles treats -0.0 and 0.0 as equal, as it should
    });
    for (std::size_t i = 0; i < n; ++i) {
        const bool repeated = i > 0 && in.vertices[idx(order[i])] == in.vertices[idx(order[i - 1])];
        first[idx(order[i])] = repeated ? first[idx(order[i - 1])] : order[i];
        if (repeated) ++report.duplicate_vertices_merged;
    }
    TriangleMesh out;
    for (const auto& t : in.triangles) {
        std::array<int, 3> w{first[idx(t[0])], first[idx(t[1])], first[idx(t[2])]};
        if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0]) {
            ++report.degenerate_triangles;
            continue;
        }
        for (int& i : w) {
            int& to = renumbered[idx(i)];
            if (to < 0) {
                to = static_cast<int>(out.vertices.size());
                out.vertices.push_back(in.vertices[idx(i)]);
            }
            i = to;
        }
        out.triangles.push_back(w);
    }
    return out;
}

// Every vertex at the place of the first one within `reach` of it; returns how many that moved.
int snap(TriangleMesh& mesh, double reach) {
    using Key = std::array<std::int64_t, 3>;
    struct Hash {
        std::size_t operator()(const Key& k) const {
            std::uint64_t h = 0;
            for (const std::int64_t x : k)
                h = (h ^ static_cast<std::uint64_t>(x)) * 0x9E3779B97F4A7C15ull, h ^= h >> 29;
            return static_cast<std::size_t>(h);
        }
    };
    const Vec3 origin = bounds_of(mesh).lo;
    // First ones are further apart than the side of a cell, so that a cell holds only a few.
    std::unordered_map<Key, std::vector<int>, Hash> cells;
    int moved = 0;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        Vec3& v = mesh.vertices[i];
        Key key;
        for (std::size_t a = 0; a < 3; ++a) key[a] = static_cast<std::int64_t>((v[a] - origin[a]) / reach);
        int found = -1;
        for (int o = 0; o < 27 && found < 0; ++o) {
            const auto at = cells.find({key[0] + o / 9 - 1, key[1] + o / 3 % 3 - 1, key[2] + o % 3 - 1});
            if (at == cells.end()) continue;
            for (const int first : at->second) {
                const Vec3 d = sub(mesh.vertices[idx(first)], v);
                if (found < 0 && d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= reach * reach) found = first;
            }
        }
        if (found < 0) {
            cells[key].push_back(static_cast<int>(i));
        } else if (v != mesh.vertices[idx(found)]) {
            v = mesh.vertices[idx(found)];
            ++moved;
        }
    }
    return moved;
}

// Counts edges and components; `bad` receives the middle of the first unbalanced edge.
void count_topology(const TriangleMesh& mesh, MeshReport& report, std::vector<int>& component, Vec3& bad) {
    const std::vector<Edge> edges = directed_edges(mesh);
    Forest forest(mesh.triangles.size());
    bool have_bad = false;
    int sheets = 0;  // an edge of 2k triangles is k edges of touching surfaces
    for (std::size_t e = 0; e < edges.size();) {
        std::size_t end = e;
        int balance = 0;
        for (; end < edges.size() && edges[end].lo == edges[e].lo && edges[end].hi == edges[e].hi; ++end) {
            balance += edges[end].forward ? 1 : -1;
            forest.join(edges[e].triangle, edges[end].triangle);
        }
        const int used = static_cast<int>(end - e);
        sheets += (used + 1) / 2;
        if (used % 2 == 1) ++report.boundary_edges;
        if (used % 2 == 0 && balance != 0) ++report.flipped_edges;
        if (used > 2 && balance == 0) ++report.non_manifold_edges;
        if (balance != 0 && !have_bad) {
            const Vec3 &a = mesh.vertices[idx(edges[e].lo)], &b = mesh.vertices[idx(edges[e].hi)];
            bad = {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])};
            have_bad = true;
        }
        e = end;
    }
    component.resize(mesh.triangles.size());
    std::vector<std::pair<int, int>> seen;  // a vertex where two components touch belongs to both
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        component[t] = forest.root(static_cast<int>(t));
        if (component[t] == static_cast<int>(t)) ++report.components;
        for (const int i : mesh.triangles[t]) seen.emplace_back(component[t], i);
    }
    std::sort(seen.begin(), seen.end());
    const auto distinct = std::unique(seen.begin(), seen.end()) - seen.begin();
    report.euler_characteristic = static_cast<int>(distinct) - sheets + static_cast<int>(mesh.triangles.size());
    report.genus = std::max(0, report.components - report.euler_characteristic / 2);
}

// Integral of x_i x_j x_k over the solid, coordinates relative to `origin` in `unit`; index -1 stands for the factor 1.
double moment(const TriangleMesh& mesh, const Vec3& origin, double unit, int i, int j, int k) {
    double sum = 0.0;
    for (const auto& t : mesh.triangles) {
        const auto c = corners(mesh, t, origin, unit);
        double si = 0, sj = 0, sk = 0, sij = 0, sik = 0, sjk = 0, sijk = 0;
        for (const Vec3& v : c) {
            const double a = v[idx(i)], b = v[idx(j)], d = k < 0 ? 1.0 : v[idx(k)];
            si += a, sj += b, sk += d;
            sij += a * b, sik += a * d, sjk += b * d, sijk += a * b * d;
        }
        // Integrals of products of barycentric coordinates: q! * volume * 6 / (q + 3)! summed over permutations.
        const double six_volumes = det(c[0], c[1], c[2]);
        if (k < 0)
            sum += six_volumes / 120.0 * (si * sj + sij);
        else
            sum += six_volumes / 720.0 * (si * sj * sk + si * sjk + sj * sik + sk * sij + 2.0 * sijk);
    }
    return sum;
}

}  // namespace

double mesh_volume(const TriangleMesh& mesh) {
    const Bounds b = bounds_of(mesh);
    const double unit = b.largest();
    if (!(unit > 0.0)) return 0.0;
    double six_volumes = 0.0;
    for (const auto& t : mesh.triangles) {
        const auto c = corners(mesh, t, b.middle(), unit);
        six_volumes += det(c[0], c[1], c[2]);
    }
    return six_volumes / 6.0 * unit * unit * unit;
}

Vec3 mesh_centre_of_mass(const TriangleMesh& mesh) {
    const Bounds b = bounds_of(mesh);
    const double unit = b.largest();
    Vec3 centre = b.middle();
    if (!(unit > 0.0)) return centre;
    double volume = 0.0;
    Vec3 first{0, 0, 0};
    for (const auto& t : mesh.triangles) {
        const auto c = corners(mesh, t, b.middle(), unit);
        const double six_volumes = det(c[0], c[1], c[2]);
        volume += six_volumes;
        for (std::size_t a = 0; a < 3; ++a) first[a] += six_volumes * 0.25 * (c[0][a] + c[1][a] + c[2][a]);
    }
    if (volume == 0.0) return centre;
    for (std::size_t a = 0; a < 3; ++a) {
        const double shift = first[a] / volume;
        // A mesh that mirrors across its middle gets exactly that plane, so that round-off does not break the symmetry.
        if (std::fabs(shift) > 1e-10) centre[a] += shift * unit;
    }
    return centre;
}

TriangleMesh clean_and_check(const TriangleMesh& in, const std::string& name, MeshReport* report) {
    MeshReport local;
    MeshReport& r = report ? *report : local;
    r = MeshReport{};
    check_input(in, name.c_str());
    TriangleMesh mesh = weld(in, r);
    if (mesh.triangles.empty())
        fail(Status::ERROR_MESH, "mesh '%s': no triangles left: all %d have a repeated vertex", name.c_str(),
             r.degenerate_triangles);
    const Bounds b = bounds_of(mesh);
    r.length_x = b.hi[0] - b.lo[0], r.length_y = b.hi[1] - b.lo[1], r.length_z = b.hi[2] - b.lo[2];
    std::vector<int> component;
    Vec3 bad{0, 0, 0};
    count_topology(mesh, r, component, bad);
    if (r.boundary_edges > 0) {
        // Vertices of one place that differ in their last digits, as programs write them, leave seams.
        TriangleMesh snapped = mesh;
        const int moved = snap(snapped, kSeam * b.largest());
        MeshReport of_snapped;
        const TriangleMesh closed = weld(snapped, of_snapped);
        std::vector<int> its_component;
        Vec3 its_bad{0, 0, 0};
        if (moved > 0 && !closed.triangles.empty()) count_topology(closed, of_snapped, its_component, its_bad);
        if (moved > 0 && !closed.triangles.empty() && of_snapped.boundary_edges == 0) {
            log_message(LogLevel::warning,
                        "mesh '%s': it closes only when vertices within %g of each other count as one; %d were moved",
                        name.c_str(), kSeam * b.largest(), moved);
            of_snapped.degenerate_triangles += r.degenerate_triangles;
            of_snapped.duplicate_vertices_merged += r.duplicate_vertices_merged;
            of_snapped.length_x = r.length_x, of_snapped.length_y = r.length_y, of_snapped.length_z = r.length_z;
            mesh = closed, r = of_snapped, component = its_component, bad = its_bad;
        }
    }
    if (r.boundary_edges > 0)
        fail(Status::ERROR_MESH,
             "mesh '%s' is open: %d boundary edges, the first at (%g, %g, %g); expected a closed surface where every "
             "edge "
             "has two triangles. Fill its holes in a mesh editor",
             name.c_str(), r.boundary_edges, bad[0], bad[1], bad[2]);
    if (r.flipped_edges > 0)
        fail(Status::ERROR_MESH,
             "mesh '%s' is inconsistently oriented: the triangles of %d edges run the same way, the first at "
             "(%g, %g, %g); expected counter-clockwise triangles seen from outside. Recompute the normals "
             "('make normals consistent', 'recalculate outside') in a mesh editor",
             name.c_str(), r.flipped_edges, bad[0], bad[1], bad[2]);
    r.volume = mesh_volume(mesh);
    const double unit = b.largest(), relative = r.volume / (unit * unit * unit);
    if (!(std::fabs(relative) > 1e-12))
        fail(Status::ERROR_MESH, "mesh '%s' encloses no volume: %g for extents %g x %g x %g; expected a solid body",
             name.c_str(), r.volume, r.length_x, r.length_y, r.length_z);
    if (r.volume < 0.0) {
        for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
        log_message(LogLevel::info, "mesh '%s': all triangles were clockwise seen from outside; they have been flipped",
                    name.c_str());
    }
    if (r.non_manifold_edges > 0)
        log_message(LogLevel::warning, "mesh '%s': %d edges are shared by more than two triangles; parts touch there",
                    name.c_str(), r.non_manifold_edges);
    std::vector<double> volumes(component.size(), 0.0);
    for (std::size_t t = 0; t < component.size(); ++t) {
        const auto c = corners(mesh, mesh.triangles[t], b.middle(), unit);
        volumes[idx(component[t])] += det(c[0], c[1], c[2]);
    }
    const auto hollow = std::count_if(volumes.begin(), volumes.end(), [](double v) { return v < -1e-12; });
    if (hollow > 0)
        log_message(LogLevel::warning, "mesh '%s': %d of %d components are inside out; they count as cavities",
                    name.c_str(), static_cast<int>(hollow), r.components);
    return mesh;
}

double mirror_asymmetry(const TriangleMesh& mesh, int axis) {
    if (axis != 1 && axis != 2) fail(Status::ERROR_INTERNAL, "mirror_asymmetry: axis %d; expected 1 or 2", axis);
    const double unit = bounds_of(mesh).largest();
    if (!(unit > 0.0)) return 0.0;
    const Vec3 centre = mesh_centre_of_mass(mesh);
    const double volume = mesh_volume(mesh) / (unit * unit * unit);
    std::array<double, 3> width;  // standard deviations of the solid along the axes
    for (int a = 0; a < 3; ++a) width[idx(a)] = std::sqrt(std::fabs(moment(mesh, centre, unit, a, a, -1) / volume));
    if (!(width[0] > 0.0 && width[1] > 0.0 && width[2] > 0.0)) return 0.0;
    const int a = axis, b = 3 - axis;
    const std::array<std::array<int, 3>, 4> odd{{{0, a, -1}, {0, 0, a}, {a, a, a}, {b, b, a}}};
    double sum = 0.0;
    for (const auto& m : odd) {
        double value = moment(mesh, centre, unit, m[0], m[1], m[2]) / volume;
        for (const int i : m)
            if (i >= 0) value /= width[idx(i)];
        sum += value * value;
    }
    return std::sqrt(sum);
}

void orient_up(TriangleMesh& mesh, int up) {
    if (up != UP_AUTO && up != UP_Z && up != UP_Y)
        fail(Status::ERROR_ARGUMENT, "up is %d; expected 0 (automatic), 1 (z up) or 2 (y up)", up);
    bool turn = up == UP_Y;
    if (up == UP_AUTO) {
        // Swimmers mirror left to right and hardly ever back to belly. Boxes, bodies of revolution and other shapes
        // that mirror both ways have two small numbers and stay; so does a shape with no clear answer.
        const double y = mirror_asymmetry(mesh, 1), z = mirror_asymmetry(mesh, 2);
        turn = y > 2e-3 && z < 0.5 * y;
        log_message(LogLevel::debug, "automatic up: asymmetry %.3g across y, %.3g across z: %s", y, z,
                    turn ? "turned, y was up" : "kept");
    }
    if (!turn) return;
    for (Vec3& v : mesh.vertices) v = {v[0], -v[2], v[1]};
}

}  // namespace dqa
