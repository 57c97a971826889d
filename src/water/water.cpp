// SPDX-License-Identifier: MIT
#include "water/water.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "grid/parallel.hpp"

namespace dqa {
namespace {

double dot(const Vec3& a, const Vec3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3 axpy(double s, const Vec3& a, const Vec3& b) {
    return {s * a[0] + b[0], s * a[1] + b[1], s * a[2] + b[2]};
}
Vec3 at(const double* q, int node3) {
    return {q[node3], q[node3 + 1], q[node3 + 2]};
}
Vec3 minus(const Vec3& a, const Vec3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Vec3 mean_of(const double* q, const std::array<int, 4>& nodes) {
    Vec3 m{};
    for (const int n : nodes)
        for (std::size_t k = 0; k < 3; ++k) m[k] += 0.25 * q[n + static_cast<int>(k)];
    return m;
}

}  // namespace

Water::Water(const ActiveSet& set, const std::vector<double>& occupancy, const WaterSettings& settings,
             InstructionSet instructions)
    : settings_(settings),
      laws_(settings.drag, settings.thrust, settings.angle_smoothing),
      kernels_(water_kernels(instructions)) {
    const Box& box = set.box;
    const double eps = settings.surface_smoothing;
    const auto add = [&](int axis, int low, int high, const std::array<std::array<int, 3>, 4>& corners) {
        Face f;
        f.axis = axis, f.cell_low = low, f.cell_high = high;
        const double jump = (low >= 0 ? occupancy[static_cast<std::size_t>(low)] : 0.0) -
                            (high >= 0 ? occupancy[static_cast<std::size_t>(high)] : 0.0);
        const double root = std::sqrt(jump * jump + eps * eps);
        const double weight = jump * jump / (root + eps);  // = root - eps without cancellation
        f.weight = jump >= 0 ? weight : -weight;
        f.weight_derivative = jump / root;
        for (std::size_t k = 0; k < 4; ++k)
            f.nodes[k] =
                3 * set.node_to_active[static_cast<std::size_t>(box.node(corners[k][0], corners[k][1], corners[k][2]))];
        if (box.dims == 2) {
            f.span_1 = box.dx * (corners[2][2] - corners[0][2]);
            f.span_2 = box.dx * (corners[3][2] - corners[1][2]);
        }
        faces_.push_back(f);
    };
    // Every face of every active cell, once: the low faces of all, and the high faces towards inactive neighbours.
    for (int a = 0; a < set.n_cells(); ++a) {
        const auto ijk = box.cell_ijk(set.cells[static_cast<std::size_t>(a)]);
        for (int axis = 0; axis < 3; ++axis) {
            const std::size_t ax = static_cast<std::size_t>(axis);
            const std::size_t b = (ax + 1) % 3, c = (ax + 2) % 3;
            if (box.dims == 2 && axis == 2) continue;  // the slab's faces: the water does not flow past them
            for (int side = 0; side < 2; ++side) {
                auto other = ijk;
                other[ax] += side ? 1 : -1;
                const bool inside = other[ax] >= 0 && other[ax] < box.cells[ax];
                const int neighbour =
                    inside ? set.cell_to_active[static_cast<std::size_t>(box.cell(other[0], other[1], other[2]))] : -1;
                if (side && neighbour >= 0) continue;  // that cell's low face
                std::array<std::array<int, 3>, 4> corners{ijk, ijk, ijk, ijk};
                for (auto& corner : corners) corner[ax] += side;
                corners[1][b] += 1, corners[2][b] += 1, corners[2][c] += 1, corners[3][c] += 1;
                add(axis, side ? a : neighbour, side ? neighbour : a, corners);
            }
        }
    }
    // Faces across one axis have no two corners of a kind in one place: sums on the nodes then need not wait for each
    // other.
    for (std::size_t first = 0; first < faces_.size(); first += kChunk)
        std::sort(
            faces_.begin() + static_cast<std::ptrdiff_t>(first),
            faces_.begin() + static_cast<std::ptrdiff_t>(std::min(first + kChunk, faces_.size())),
            [](const Face& a, const Face& b) { return std::pair(a.axis, a.nodes[0]) < std::pair(b.axis, b.nodes[0]); });
    std::vector<int> node, corner;
    for (const Face& face : faces_)
        for (const int n : face.nodes) node.push_back(n / 3), corner.push_back(static_cast<int>(corner.size()));
    corners_ = NodeGather(set.n_nodes(), node, corner);
    const std::size_t blocks = (faces_.size() + 7) / 8;
    nodes_.resize(32 * blocks);
    for (std::size_t f = 0; f < 8 * blocks; ++f)
        for (std::size_t k = 0; k < 4; ++k)
            nodes_[f / 8 * 32 + 8 * k + f % 8] = faces_[std::min(f, faces_.size() - 1)].nodes[k];
    sums_ = ChunkedGather(set.n_nodes(), nodes_, 4, n_faces(), kChunk / 8);
}

void Water::lag(WaterWorkspace& ws, const double* q, const double* v, const Vec3& spine, const Vec3& current,
                Threads threads) const {
    const std::size_t nf = faces_.size();
    const std::size_t room = (nf + 7) / 8 * 8;
    const auto make_room = [&](auto& resistance) {
        resistance.cd.resize(room), resistance.ct.resize(room), resistance.n.resize(3 * room);
        resistance.force.resize(sums_.size());
    };
    make_room(ws.exact), make_room(ws.single);
    ws.k.resize(room), ws.u.resize(3 * room), ws.area.resize(nf);
    ws.energy.resize(static_cast<std::size_t>(n_chunks()));
    ws.spine = spine, ws.current = current;
    const double eps2 = settings_.speed_smoothing * settings_.speed_smoothing, half_rho = 0.5 * settings_.density;
    parallel_chunks(threads, n_faces(), kChunk, [&](int begin, int end) {
        for (std::size_t i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
            const Face& f = faces_[i];
            const auto [d1, d2] = diagonals(f, q);
            Vec3 a = cross(d1, d2);
            const double sign = f.weight >= 0 ? 0.5 : -0.5;
            for (double& x : a) x *= sign;
            const double area = std::sqrt(dot(a, a) + 1e-30);
            const Vec3 u = minus(mean_of(v, f.nodes), current);
            const double speed = std::sqrt(dot(u, u) + eps2);
            const double su = dot(spine, u), lateral2 = dot(u, u) - su * su;
            const double x = dot(a, u) / (area * speed);
            const double w = half_rho * std::fabs(f.weight) * area * counted(x);
            const WaterLaws::Angle angle = laws_.angle(x);
            ws.area[i] = area;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t at = i / 8 * 24 + 8 * k + i % 8;
                ws.exact.n[at] = a[k] / area, ws.u[at] = u[k];
            }
            ws.exact.cd[i] = w * laws_.drag(angle).value * speed;
            ws.exact.ct[i] = w * laws_.thrust_slope(angle).value * lateral2 / speed;
            ws.k[i] = w * laws_.thrust_rest() * lateral2;
        }
        const std::size_t first = static_cast<std::size_t>(begin), last = static_cast<std::size_t>(end + 7) / 8 * 8;
        convert(ws.exact.cd, ws.single.cd, first, last);
        convert(ws.exact.ct, ws.single.ct, first, last);
        convert(ws.exact.n, ws.single.n, 3 * first, 3 * last);
    });
}

Vec3 Water::new_velocity(const WaterWorkspace& ws, const Face& f, const double* q_new, const double* q_base,
                         double inv_h) {
    const Vec3 d = minus(mean_of(q_new, f.nodes), mean_of(q_base, f.nodes));
    return {d[0] * inv_h - ws.current[0], d[1] * inv_h - ws.current[1], d[2] * inv_h - ws.current[2]};
}

std::pair<Vec3, Vec3> Water::diagonals(const Face& f, const double* q) {
    Vec3 d1 = minus(at(q, f.nodes[2]), at(q, f.nodes[0])), d2 = minus(at(q, f.nodes[3]), at(q, f.nodes[1]));
    d1[2] += f.span_1, d2[2] += f.span_2;
    return {d1, d2};
}

Vec3 Water::force_velocity(const WaterWorkspace& ws, std::size_t i, const double* q_new, const double* q_base,
                           double inv_h) const {
    return settings_.explicit_forces ? ws.lagged(i) : new_velocity(ws, faces_[i], q_new, q_base, inv_h);
}

double Water::gradient(WaterWorkspace& ws, const double* q_new, const double* q_base, double h, Threads threads,
                       double* out) const {
    parallel_chunks(threads, n_chunks(), 1, [&](int k, int) { gradient_chunk(ws, q_new, q_base, h, k); });
    add_forces(ws, threads, out);
    return energy(ws);
}

void Water::gradient_chunk(WaterWorkspace& ws, const double* q_new, const double* q_base, double h, int k) const {
    WaterResistance<double>& at = ws.exact;
    ws.energy[static_cast<std::size_t>(k)] =
        kernels_.gradient(q_new, q_base, nodes_.data(), at.cd.data(), at.ct.data(), ws.k.data(), at.n.data(),
                          settings_.explicit_forces ? ws.u.data() : nullptr, ws.current.data(), h, first_of(k),
                          last_of(k), sums_.cleared(k, at.force));
}

double Water::energy(const WaterWorkspace& ws) const {
    return std::accumulate(ws.energy.begin(), ws.energy.end(), 0.0);
}

template <class T>
void Water::product(WaterWorkspace& ws, const T* p, double h, Threads threads, T* out) const {
    if (!has_product()) return;
    parallel_chunks(threads, n_chunks(), 1, [&](int k, int) { product_chunk(ws, p, h, k); });
    add_forces(ws, threads, out);
}
template void Water::product(WaterWorkspace&, const double*, double, Threads, double*) const;
template void Water::product(WaterWorkspace&, const float*, double, Threads, float*) const;

template <class T>
void Water::product_chunk(WaterWorkspace& ws, const T* p, double h, int k) const {
    WaterResistance<T>& at = ws.in(T());
    kernels_.product.in(T())(p, nodes_.data(), at.cd.data(), at.ct.data(), at.n.data(), 1.0 / h, first_of(k),
                             last_of(k), sums_.cleared(k, at.force));
}
template void Water::product_chunk(WaterWorkspace&, const double*, double, int) const;
template void Water::product_chunk(WaterWorkspace&, const float*, double, int) const;

template <class T>
void Water::add_forces(const WaterWorkspace& ws, Threads threads, T* out) const {
    std::vector<NodeTerm<T>> forces;
    list_forces(ws, forces);
    add_terms(forces, corners_.n_nodes(), threads, out);
}

void WaterParameterBar::operator+=(const WaterParameterBar& o) {
    density += o.density;
    for (std::size_t k = 0; k < 4; ++k) laws.drag[k] += o.laws.drag[k], laws.thrust[k] += o.laws.thrust[k];
}

void Water::SharedBar::operator+=(const SharedBar& o) {
    for (std::size_t k = 0; k < 3; ++k) spine[k] += o.spine[k], current[k] += o.current[k];
    parameters += o.parameters;
}

void Water::face_pullback(WaterWorkspace& ws, std::size_t i, const Vec3& un, const Vec3& l, const Vec3& m,
                          double wet_bar, const double* lag_q, SharedBar& shared) const {
    const double eps2 = settings_.speed_smoothing * settings_.speed_smoothing, half_rho = 0.5 * settings_.density;
    const Face& f = faces_[i];
    const Vec3 n = ws.normal(i), u = ws.lagged(i);
    const double area = ws.area[i], nm = dot(n, m), nun = dot(n, un);
    const double cd_bar = dot(l, un), ct_bar = nm * nun, k_bar = nm;
    Vec3 n_bar{};
    for (std::size_t k = 0; k < 3; ++k) n_bar[k] = ws.exact.ct[i] * (m[k] * nun + un[k] * nm) + ws.k[i] * m[k];
    Vec3 un_bar{};
    for (std::size_t k = 0; k < 3; ++k) un_bar[k] = ws.exact.cd[i] * l[k] + ws.exact.ct[i] * nm * n[k];
    // Lagged coefficients back to u, n, area, weight, spine.
    const double u2 = dot(u, u), speed = std::sqrt(u2 + eps2), su = dot(ws.spine, u), lateral2 = u2 - su * su;
    const double nu = dot(n, u), x = nu / speed;
    const WaterLaws::Angle angle = laws_.angle(x);
    const LawValue cd = laws_.drag(angle), ts = laws_.thrust_slope(angle);
    const double factor = counted(x), rest = laws_.thrust_rest();
    const double w = half_rho * std::fabs(f.weight) * area * factor;
    const double w_bar = cd_bar * cd.value * speed + ct_bar * ts.value * lateral2 / speed + k_bar * rest * lateral2;
    const double x_bar = w * (cd_bar * cd.derivative * speed + ct_bar * ts.derivative * lateral2 / speed);
    const double lateral_bar = w * (ct_bar * ts.value / speed + k_bar * rest);
    const double speed_bar =
        w * (cd_bar * cd.value - ct_bar * ts.value * lateral2 / (speed * speed)) - x_bar * x / speed;
    laws_.pullback(angle, w * cd_bar * speed, w * ct_bar * lateral2 / speed, w * k_bar * lateral2,
                   shared.parameters.laws);
    shared.parameters.density += w_bar * 0.5 * std::fabs(f.weight) * area * factor;
    const double area_bar = (w_bar * half_rho * factor + wet_bar) * std::fabs(f.weight);
    const double weight_bar = (w_bar * half_rho * factor + wet_bar) * area;
    Vec3 u_bar{};
    for (std::size_t k = 0; k < 3; ++k) {
        u_bar[k] = x_bar * n[k] / speed + speed_bar * u[k] / speed + lateral_bar * 2.0 * (u[k] - su * ws.spine[k]);
        n_bar[k] += x_bar * u[k] / speed;
        shared.spine[k] -= lateral_bar * 2.0 * su * u[k];
    }
    if (settings_.explicit_forces)  // un is u
        for (std::size_t k = 0; k < 3; ++k) u_bar[k] += un_bar[k], un_bar[k] = 0.0;
    // n = a / area, area = sqrt(|a|^2 + tiny): a_bar = (n_bar - n (n.n_bar)) / area + area_bar n.
    const double nn = dot(n, n_bar);
    Vec3 a_bar{};
    for (std::size_t k = 0; k < 3; ++k) a_bar[k] = (n_bar[k] - n[k] * nn) / area + area_bar * n[k];
    const double sign = f.weight >= 0 ? 0.5 : -0.5;
    const auto [d1, d2] = diagonals(f, lag_q);
    const Vec3 d1_bar = cross(d2, a_bar), d2_bar = cross(a_bar, d1);  // a = sign d1 x d2
    double* out = ws.face_bar.data() + 16 * i;
    for (std::size_t k = 0; k < 3; ++k) {
        out[k] = un_bar[k], out[4 + k] = u_bar[k], out[8 + k] = sign * d1_bar[k], out[12 + k] = sign * d2_bar[k];
        shared.current[k] -= un_bar[k] + u_bar[k];
    }
    ws.jump_bar[i] = weight_bar * f.weight_derivative;
}

// In two parallel loops: the cotangents of faces, then their sums on the nodes.
template <class F>
void Water::pull_back(WaterWorkspace& ws, const double* q_new, const double* q_base, const double* lag_q, F&& vectors,
                      double wet_bar, double h, Threads threads, double* q_new_bar, double* q_base_bar, double* q_bar,
                      double* v_bar, Vec3& spine_bar, Vec3& current_bar, WaterParameterBar& parameter_bar,
                      double* occupancy_bar) const {
    ws.face_bar.resize(16 * faces_.size()), ws.jump_bar.resize(faces_.size());
    const SharedBar shared = parallel_total<SharedBar>(threads, n_faces(), kChunk, [&](int begin, int end) {
        SharedBar own;
        for (std::size_t i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
            const auto [l, m] = vectors(faces_[i]);
            face_pullback(ws, i, force_velocity(ws, i, q_new, q_base, 1.0 / h), l, m, wet_bar, lag_q, own);
        }
        return own;
    });
    for (std::size_t k = 0; k < 3; ++k) spine_bar[k] += shared.spine[k], current_bar[k] += shared.current[k];
    parameter_bar += shared.parameters;
    const auto on_cells = [&] {
        for (std::size_t i = 0; i < faces_.size(); ++i) {
            if (faces_[i].cell_low >= 0) occupancy_bar[faces_[i].cell_low] += ws.jump_bar[i];
            if (faces_[i].cell_high >= 0) occupancy_bar[faces_[i].cell_high] -= ws.jump_bar[i];
        }
    };
    const auto on_node = [&](int n) {
        double un[3] = {}, u[3] = {}, place[3] = {};
        corners_.each(n, [&](int at) {
            const int corner = at % 4;
            const double* face = ws.face_bar.data() + 16 * static_cast<std::size_t>(at / 4);
            const double* diagonal = face + (corner % 2 ? 12 : 8);
            const double sign = corner < 2 ? -1.0 : 1.0;  // diagonals run from 0 to 2 and from 1 to 3
            for (int k = 0; k < 3; ++k) un[k] += face[k], u[k] += face[4 + k], place[k] += sign * diagonal[k];
        });
        for (int k = 0; k < 3; ++k) {
            q_bar[3 * n + k] += place[k];
            q_base_bar[3 * n + k] -= 0.25 / h * un[k];
            if (q_new_bar) q_new_bar[3 * n + k] += 0.25 / h * un[k];
            v_bar[3 * n + k] += 0.25 * u[k];
        }
    };
    const int chunks = (corners_.n_nodes() + kNodeGrain - 1) / kNodeGrain;
    parallel_chunks(threads, chunks + 1, 1, [&](int k, int) {
        if (k == 0) return on_cells();
        for (int n = (k - 1) * kNodeGrain; n < std::min(k * kNodeGrain, corners_.n_nodes()); ++n) on_node(n);
    });
}

void Water::pullback(WaterWorkspace& ws, const double* q_new, const double* q_base, const double* lag_q,
                     const double* lambda, double h, Threads threads, double* q_base_bar, double* q_bar, double* v_bar,
                     Vec3& spine_bar, Vec3& current_bar, WaterParameterBar& parameter_bar,
                     double* occupancy_bar) const {
    const auto vectors = [&](const Face& f) {
        const Vec3 l = mean_of(lambda, f.nodes);
        return std::pair{l, l};
    };
    pull_back(ws, q_new, q_base, lag_q, vectors, 0.0, h, threads, nullptr, q_base_bar, q_bar, v_bar, spine_bar,
              current_bar, parameter_bar, occupancy_bar);
}

double Water::dissipation(const WaterWorkspace& ws, const double* q_new, const double* q_base, double h) const {
    double power = 0.0;
    for (std::size_t i = 0; i < faces_.size(); ++i) {
        const Vec3 u = force_velocity(ws, i, q_new, q_base, 1.0 / h), n = ws.normal(i);
        const Vec3 fresh = new_velocity(ws, faces_[i], q_new, q_base, 1.0 / h);
        power += ws.exact.cd[i] * dot(u, fresh) + ws.exact.ct[i] * dot(n, u) * dot(n, fresh);
    }
    return power;
}

void WaterTotals::operator+=(const WaterTotals& o) {
    drag = axpy(1.0, o.drag, drag), thrust = axpy(1.0, o.thrust, thrust);
    wet_area += o.wet_area;
}

WaterTotals Water::totals(const WaterWorkspace& ws, const double* q_new, const double* q_base, double h,
                          Threads threads) const {
    WaterTotals t = parallel_total<WaterTotals>(threads, n_faces(), kChunk, [&](int begin, int end) {
        WaterTotals own;
        for (std::size_t i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
            const Vec3 u = force_velocity(ws, i, q_new, q_base, 1.0 / h);
            const Vec3 n = ws.normal(i);
            own.drag = axpy(-ws.exact.cd[i], u, own.drag);
            own.thrust = axpy(-(ws.exact.ct[i] * dot(n, u) + ws.k[i]), n, own.thrust);
            own.wet_area += std::fabs(faces_[i].weight) * ws.area[i];
        }
        return own;
    });
    for (std::size_t k = 0; k < 3 && t.wet_area > 0; ++k)
        t.mean_drag[k] = t.drag[k] / t.wet_area, t.mean_thrust[k] = t.thrust[k] / t.wet_area;
    return t;
}

void Water::totals_pullback(WaterWorkspace& ws, const double* q_new, const double* q_base, const double* lag_q,
                            const WaterTotals& totals_bar, double h, Threads threads, double* q_new_bar,
                            double* q_base_bar, double* q_bar, double* v_bar, Vec3& spine_bar, Vec3& current_bar,
                            WaterParameterBar& parameter_bar, double* occupancy_bar) const {
    const WaterTotals t = totals(ws, q_new, q_base, h, threads);
    if (!(t.wet_area > 0)) return;
    Vec3 drag_bar{}, thrust_bar{};  // of the sums without their sign
    for (std::size_t k = 0; k < 3; ++k) {
        drag_bar[k] = -totals_bar.drag[k] - totals_bar.mean_drag[k] / t.wet_area;
        thrust_bar[k] = -totals_bar.thrust[k] - totals_bar.mean_thrust[k] / t.wet_area;
    }
    const double wet_bar =
        -(dot(totals_bar.mean_drag, t.mean_drag) + dot(totals_bar.mean_thrust, t.mean_thrust)) / t.wet_area;
    const auto vectors = [&](const Face&) { return std::pair{drag_bar, thrust_bar}; };
    pull_back(ws, q_new, q_base, lag_q, vectors, wet_bar, h, threads, q_new_bar, q_base_bar, q_bar, v_bar, spine_bar,
              current_bar, parameter_bar, occupancy_bar);
}

}  // namespace dqa
