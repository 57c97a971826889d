// SPDX-License-Identifier: MIT
#include "reference.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <unsupported/Eigen/AutoDiff>

#include "grid/error.hpp"
#include "motion/muscles.hpp"
#include "shape/occupancy.hpp"

namespace bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kHistory = 20;

double dot(const Field& a, const Field& b) {
    return a.cwiseProduct(b).sum();
}

// Two-loop recursion (Nocedal & Wright, alg. 7.4) around the inverse of the constant matrix.
class QuasiNewton {
public:
    template <class Initial>
    Field direction(const Field& gradient, Initial&& initial) const {
        Field q = gradient;
        std::vector<double> alpha(pairs_.size());
        for (std::size_t k = pairs_.size(); k-- > 0;) {
            alpha[k] = dot(pairs_[k].s, q) * pairs_[k].rho;
            q -= alpha[k] * pairs_[k].y;
        }
        Field r = initial(q);
        for (std::size_t k = 0; k < pairs_.size(); ++k)
            r += (alpha[k] - dot(pairs_[k].y, r) * pairs_[k].rho) * pairs_[k].s;
        return -r;
    }
    void remember(Field s, Field y) {
        const double sy = dot(s, y);
        if (!(sy > 0)) return;
        pairs_.push_back({std::move(s), std::move(y), 1.0 / sy});
        if (pairs_.size() > kHistory) pairs_.pop_front();
    }
    bool empty() const { return pairs_.empty(); }
    void clear() { pairs_.clear(); }

private:
    struct Pair {
        Field s, y;
        double rho;
    };
    std::deque<Pair> pairs_;
};

Vector3d vector(const dqa::Vec3& a) {
    return {a[0], a[1], a[2]};
}
dqa::Vec3 array(const Vector3d& a) {
    return {a[0], a[1], a[2]};
}
dqa::Vec3 mean_of(const Field& f, const std::array<int, 4>& nodes) {
    return array(0.25 * (f.col(nodes[0]) + f.col(nodes[1]) + f.col(nodes[2]) + f.col(nodes[3])));
}

// Scalars that carry their derivatives by (area vector, lagged velocity, new velocity, spine): 12 variables.
using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, 12, 1>>;
double chain(const dqa::LawValue& law, double) {
    return law.value;
}
Dual chain(const dqa::LawValue& law, const Dual& x) {
    return Dual(law.value, law.derivative * x.derivatives());
}
double value_of(double x) {
    return x;
}
double value_of(const Dual& x) {
    return x.value();
}

template <class T>
using Triple = std::array<T, 3>;
template <class T, class S>
T inner(const Triple<T>& a, const Triple<S>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <class T>
struct Coefficients {
    T cd, ct, k;
    Triple<T> n;
};

// Coefficients of a face from its area vector (outward), the lagged velocity relative to the water, and the spine.
template <class T>
Coefficients<T> lag(const Triple<T>& a, const Triple<T>& u, const Triple<T>& spine, double weight,
                    const dqa::WaterLaws& laws, const dqa::WaterSettings& water) {
    using std::sqrt;
    const T area = sqrt(inner(a, a) + 1e-30), uu = inner(u, u), su = inner(spine, u);
    const T speed = sqrt(uu + water.speed_smoothing * water.speed_smoothing), lateral2 = uu - su * su;
    const T x = inner(a, u) / (area * speed);
    const bool counts = !water.windward_only || value_of(x) > 0.0;
    const T w = (counts ? 0.5 * water.density * std::fabs(weight) : 0.0) * area;
    Coefficients<T> c;
    c.cd = w * chain(laws.drag(value_of(x)), x) * speed;
    c.ct = w * chain(laws.thrust_slope(value_of(x)), x) * lateral2 / speed;
    c.k = w * laws.thrust_rest() * lateral2;
    for (std::size_t i = 0; i < 3; ++i) c.n[i] = a[i] / area;
    return c;
}

}  // namespace

Reference::Reference(const dqa::ShapeSpace& space, const std::vector<double>& weights, const dqa::SceneSettings& scene)
    : scene_(scene),
      laws_(scene.hydrodynamics.drag, scene.hydrodynamics.thrust, scene.hydrodynamics.angle_smoothing),
      inv_dx_(1.0 / space.box().dx),
      gauss_volume_(std::pow(space.box().dx, 3) / 8.0) {
    const dqa::Box& box = space.box();
    if (box.dims != 3) dqa::fail(dqa::Status::ERROR_ARGUMENT, "the reference knows three dimensions only");
    const dqa::ShapePoint point = space.evaluate(weights, scene.shape_tolerance, 1, nullptr);
    set_ = dqa::make_active_set(box, std::vector<char>(static_cast<std::size_t>(box.n_cells()), 1));
    const dqa::Occupancy law(0.0, scene.occupancy_floor);
    for (const double p : point.p_hat) occupancy_.push_back(law.value(p));
    const std::vector<double> rest = set_.rest_positions();
    rest_ = Eigen::Map<const Field>(rest.data(), 3, set_.n_nodes());
    mass_ = Eigen::VectorXd::Zero(set_.n_nodes());
    spine_ = mass_;
    for (std::size_t c = 0; c < occupancy_.size(); ++c)
        for (const int n : set_.cell_nodes[c]) {
            mass_[n] += scene.density * gauss_volume_ * occupancy_[c];
            spine_[n] += std::max(0.0, 1.0 - std::fabs(rest_(1, n)) * inv_dx_) * occupancy_[c];
        }
    spine_ /= spine_.sum();
    const std::vector<double> stiffness(occupancy_.size(), scene.muscle_stiffness);
    const dqa::Muscles muscles(space, point, set_, occupancy_, stiffness);
    for (const dqa::MuscleEntry& m : muscles.entries()) fibres_.push_back({m, 1.0});
    sensors_ = dqa::Sensors(set_, point.p_hat, space.axis_y(), space.axis_z());
    for (int g = 0; g < 8; ++g)
        for (int k = 0; k < 8; ++k) {
            double shape[3], slope[3];
            for (int axis = 0; axis < 3; ++axis) {
                const bool high_node = (k >> (2 - axis)) & 1, high_point = (g >> (2 - axis)) & 1;
                const double t = 0.5 + (high_point ? 0.5 : -0.5) / std::sqrt(3.0);
                shape[axis] = high_node ? t : 1.0 - t;
                slope[axis] = high_node ? inv_dx_ : -inv_dx_;
            }
            shape_gradient_[static_cast<std::size_t>(g)].row(k) << slope[0] * shape[1] * shape[2],
                shape[0] * slope[1] * shape[2], shape[0] * shape[1] * slope[2];
        }
    if (scene.water) make_faces();
    make_factor();
}

void Reference::make_faces() {
    const dqa::Box& box = set_.box;
    const double eps = scene_.hydrodynamics.surface_smoothing;
    for (int axis = 0; axis < 3; ++axis) {
        const std::size_t ax = static_cast<std::size_t>(axis), b = (ax + 1) % 3, c = (ax + 2) % 3;
        std::array<int, 3> planes = box.cells;
        ++planes[ax];
        std::array<int, 3> at{};
        for (at[0] = 0; at[0] < planes[0]; ++at[0])
            for (at[1] = 0; at[1] < planes[1]; ++at[1])
                for (at[2] = 0; at[2] < planes[2]; ++at[2]) {
                    auto below = at;
                    --below[ax];
                    const auto occupancy = [&](const std::array<int, 3>& cell) {
                        return occupancy_[static_cast<std::size_t>(box.cell(cell[0], cell[1], cell[2]))];
                    };
                    const double low = at[ax] > 0 ? occupancy(below) : 0.0;
                    const double high = at[ax] < box.cells[ax] ? occupancy(at) : 0.0, jump = low - high;
                    Face f;
                    f.weight = std::copysign(jump * jump / (std::sqrt(jump * jump + eps * eps) + eps), jump);
                    std::array<std::array<int, 3>, 4> corners{at, at, at, at};
                    corners[1][b] += 1, corners[2][b] += 1, corners[2][c] += 1, corners[3][c] += 1;
                    for (std::size_t k = 0; k < 4; ++k)
                        f.nodes[k] = box.node(corners[k][0], corners[k][1], corners[k][2]);
                    faces_.push_back(f);
                }
    }
}

// M/h^2 + sum over Gauss points of 2 mu G^T G + sum over fibres of w (G m)^T (G m): one matrix for x, y and z.
void Reference::make_factor() {
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](std::size_t cell, const Eigen::Matrix<double, 8, 8>& local) {
        for (int a = 0; a < 8; ++a)
            for (int b = 0; b < 8; ++b)
                entries.emplace_back(set_.cell_nodes[cell][static_cast<std::size_t>(a)],
                                     set_.cell_nodes[cell][static_cast<std::size_t>(b)], local(a, b));
    };
    for (std::size_t c = 0; c < occupancy_.size(); ++c) {
        Eigen::Matrix<double, 8, 8> local = Eigen::Matrix<double, 8, 8>::Zero();
        for (const auto& g : shape_gradient_) local += g * g.transpose();
        add(c, 2.0 * scene_.unit_mu() * scene_.young_modulus * occupancy_[c] * gauss_volume_ * local);
    }
    for (const Fibre& f : fibres_) {
        Eigen::Matrix<double, 8, 8> local = Eigen::Matrix<double, 8, 8>::Zero();
        for (const auto& g : shape_gradient_) {
            const Eigen::Matrix<double, 8, 1> gm = g * vector(f.entry.direction);
            local += gm * gm.transpose();
        }
        add(static_cast<std::size_t>(f.entry.cell), f.entry.weight * gauss_volume_ * local);
    }
    for (int n = 0; n < set_.n_nodes(); ++n)
        entries.emplace_back(n, n, mass_[n] / (scene_.time_step * scene_.time_step));
    Eigen::SparseMatrix<double> matrix(set_.n_nodes(), set_.n_nodes());
    matrix.setFromTriplets(entries.begin(), entries.end());
    diagonal_ = matrix.diagonal();
    factor_.compute(matrix);
    if (factor_.info() != Eigen::Success)
        dqa::fail(dqa::Status::NOT_CONVERGED, "the projective-dynamics matrix was not factorised");
}

Field Reference::precondition(const Field& in) const {
    const Eigen::MatrixXd x = factor_.solve(Eigen::MatrixXd(in.transpose()));
    return x.transpose();
}

Reference::Corners Reference::gather(const Field& q, int cell) const {
    Corners c;
    for (int k = 0; k < 8; ++k)
        c.col(k) = q.col(set_.cell_nodes[static_cast<std::size_t>(cell)][static_cast<std::size_t>(k)]);
    return c;
}

Reference::Turn Reference::turn_of(const Matrix3d& f) {
    const Eigen::JacobiSVD<Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Turn t{svd.matrixU(), svd.matrixV(), svd.singularValues()};
    if (t.u.determinant() * t.v.determinant() < 0) t.u.col(2) *= -1.0, t.sigma[2] *= -1.0;
    return t;
}

void Reference::begin(const FieldState& now, const std::vector<double>& signals) {
    now_ = now;
    y_ = now.q + scene_.time_step * now.v;
    noise_ = 0.25 * std::numeric_limits<double>::epsilon() * (now.q * diagonal_.asDiagonal()).norm();
    for (Fibre& f : fibres_)
        f.rest = 1.0 - f.entry.sign * scene_.contraction * signals[static_cast<std::size_t>(f.entry.signal)];
    Vector3d axis = Vector3d::Zero();
    const dqa::MaterialPoint &head = sensors_.point(dqa::Sensors::head), &tail = sensors_.point(dqa::Sensors::tail);
    for (std::size_t k = 0; k < 8; ++k)
        axis += head.weight[k] * now.q.col(head.node[k]) - tail.weight[k] * now.q.col(tail.node[k]);
    spine_direction_ = axis / std::sqrt(axis.squaredNorm() + 1e-24);
    const Vector3d current = vector(scene_.hydrodynamics.current);
    for (Face& f : faces_) {
        const Vector3d d1 = now.q.col(f.nodes[2]) - now.q.col(f.nodes[0]);
        const Vector3d d2 = now.q.col(f.nodes[3]) - now.q.col(f.nodes[1]);
        const Vector3d a = (f.weight >= 0 ? 0.5 : -0.5) * d1.cross(d2);
        f.u = vector(mean_of(now.v, f.nodes)) - current;
        const auto c = lag(array(a), array(f.u), array(spine_direction_), f.weight, laws_, scene_.hydrodynamics);
        f.cd = c.cd, f.ct = c.ct, f.k = c.k, f.n = vector(c.n);
    }
}

double Reference::add_elastic(const Field& q, Field& force) const {
    double energy = 0.0;
    for (int c = 0; c < set_.n_cells(); ++c) {
        const auto& nodes = set_.cell_nodes[static_cast<std::size_t>(c)];
        const double w =
            2.0 * scene_.unit_mu() * scene_.young_modulus * occupancy_[static_cast<std::size_t>(c)] * gauss_volume_;
        const Corners x = gather(q, c);
        Corners local = Corners::Zero();
        for (const auto& g : shape_gradient_) {
            const Matrix3d f = x * g;
            const Turn t = turn_of(f);
            const Matrix3d strain = f - t.u * t.v.transpose();
            energy += 0.5 * w * strain.squaredNorm();
            local += w * strain * g.transpose();
        }
        for (int k = 0; k < 8; ++k) force.col(nodes[static_cast<std::size_t>(k)]) += local.col(k);
    }
    return energy;
}

double Reference::add_muscle(const Field& q, Field& force) const {
    double energy = 0.0;
    for (const Fibre& fibre : fibres_) {
        const auto& nodes = set_.cell_nodes[static_cast<std::size_t>(fibre.entry.cell)];
        const double w = fibre.entry.weight * gauss_volume_;
        const Corners x = gather(q, fibre.entry.cell);
        Corners local = Corners::Zero();
        for (const auto& g : shape_gradient_) {
            const Eigen::Matrix<double, 8, 1> gm = g * vector(fibre.entry.direction);
            const Vector3d t = x * gm;
            const double length = std::sqrt(t.squaredNorm() + 1e-24), stretch = length - fibre.rest;
            energy += 0.5 * w * stretch * stretch;
            local += (w * stretch / length) * t * gm.transpose();
        }
        for (int k = 0; k < 8; ++k) force.col(nodes[static_cast<std::size_t>(k)]) += local.col(k);
    }
    return energy;
}

double Reference::add_water(const Field& q, Field& force) const {
    const double h = scene_.time_step;
    double energy = 0.0;
    for (const Face& f : faces_) {
        const Vector3d fresh =
            (vector(mean_of(q, f.nodes)) - vector(mean_of(now_.q, f.nodes))) / h - vector(scene_.hydrodynamics.current);
        const Vector3d u = scene_.hydrodynamics.explicit_forces ? f.u : fresh;
        const double nu = f.n.dot(u);
        const Vector3d drag = f.cd * u + (f.ct * nu + f.k) * f.n;
        energy += scene_.hydrodynamics.explicit_forces
                      ? h * drag.dot(fresh)
                      : h * (0.5 * (f.cd * u.squaredNorm() + f.ct * nu * nu) + f.k * nu);
        for (const int n : f.nodes) force.col(n) += 0.25 * drag;
    }
    return energy;
}

Reference::Evaluation Reference::evaluate(const Field& q) const {
    Evaluation e;
    e.gradient = (q - y_) * (mass_ / (scene_.time_step * scene_.time_step)).asDiagonal();
    e.energy = 0.5 * dot(e.gradient, q - y_);
    e.scale = e.gradient.norm();
    Field part = Field::Zero(3, q.cols());
    const auto take = [&](double energy) {
        e.energy += energy, e.scale += part.norm(), e.gradient += part;
        part.setZero();
    };
    take(add_elastic(q, part));
    take(add_muscle(q, part));
    take(add_water(q, part));
    e.residual = e.gradient.norm();
    return e;
}

ReferenceReport Reference::step(const FieldState& now, const std::vector<double>& signals, FieldState& next) {
    begin(now, signals);
    ReferenceReport report;
    Field x = y_;
    Evaluation here = evaluate(x);
    QuasiNewton history;
    while (!(here.residual <= std::max(scene_.tolerance * here.scale, noise_))) {
        if (report.iterations++ >= scene_.max_linear || !std::isfinite(here.residual))
            dqa::fail(dqa::Status::NOT_CONVERGED, "reference: residual %.3g after %d iterations, expected <= %.3g",
                      here.residual / here.scale, report.iterations - 1, scene_.tolerance);
        const Field direction = history.direction(here.gradient, [&](const Field& in) { return precondition(in); });
        const double slope = dot(here.gradient, direction);
        const double rounding = 1e-13 * (std::fabs(here.energy) + std::fabs(slope)) + 1e-15 * here.scale * x.norm();
        double t = 1.0;
        Evaluation there;
        bool found = false;
        for (int k = 0; k < 30 && slope < 0 && !found; ++k, t *= 0.5) {
            there = evaluate(x + t * direction);
            found = there.energy <= here.energy + 1e-4 * t * slope ||
                    (there.energy <= here.energy + rounding && there.residual < here.residual);
            if (found) break;
        }
        if (found) {
            history.remember(t * direction, there.gradient - here.gradient);
            x += t * direction;
            here = std::move(there);
        } else if (here.residual <= 200.0 * noise_) {
            break;
        } else if (history.empty()) {
            dqa::fail(dqa::Status::NOT_CONVERGED, "reference: the line search is exhausted at a residual of %.3g",
                      here.residual / here.scale);
        } else {
            history.clear();
        }
    }
    report.residual = here.scale > 0 ? here.residual / std::max(here.scale, 200.0 * noise_ / scene_.tolerance) : 0.0;
    next.v = (x - now.q) / scene_.time_step;
    next.q = std::move(x);
    return report;
}

// dR = U (Omega) V^T with Omega_ij = (W_ij - W_ji) / (sigma_i + sigma_j), W = U^T dF V (e.g. Papadopoulo & Lourakis
// 2000).
Field Reference::product(const Field& q, const Field& p) {
    const double h = scene_.time_step;
    if (turns_.empty())
        for (int c = 0; c < set_.n_cells(); ++c)
            for (const auto& g : shape_gradient_) turns_.push_back(turn_of(gather(q, c) * g));
    Field out = p * (mass_ / (h * h)).asDiagonal();
    for (int c = 0; c < set_.n_cells(); ++c) {
        const double w =
            2.0 * scene_.unit_mu() * scene_.young_modulus * occupancy_[static_cast<std::size_t>(c)] * gauss_volume_;
        const Corners x = gather(p, c);
        Corners local = Corners::Zero();
        for (std::size_t k = 0; k < 8; ++k) {
            const Turn& t = turns_[8 * static_cast<std::size_t>(c) + k];
            const Matrix3d df = x * shape_gradient_[k], wuv = t.u.transpose() * df * t.v;
            Matrix3d omega = Matrix3d::Zero();
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j)
                    if (i != j) omega(i, j) = (wuv(i, j) - wuv(j, i)) / std::max(1e-6, t.sigma[i] + t.sigma[j]);
            local += w * (df - t.u * omega * t.v.transpose()) * shape_gradient_[k].transpose();
        }
        for (int k = 0; k < 8; ++k)
            out.col(set_.cell_nodes[static_cast<std::size_t>(c)][static_cast<std::size_t>(k)]) += local.col(k);
    }
    for (const Fibre& fibre : fibres_) {
        const double w = fibre.entry.weight * gauss_volume_;
        const Corners x = gather(q, fibre.entry.cell), dx = gather(p, fibre.entry.cell);
        Corners local = Corners::Zero();
        for (const auto& g : shape_gradient_) {
            const Eigen::Matrix<double, 8, 1> gm = g * vector(fibre.entry.direction);
            const Vector3d t = x * gm, d = dx * gm;
            const double length = std::sqrt(t.squaredNorm() + 1e-24);
            const Vector3d unit = t / length;
            local +=
                w * ((1.0 - fibre.rest / length) * d + (fibre.rest / length) * unit.dot(d) * unit) * gm.transpose();
        }
        for (int k = 0; k < 8; ++k)
            out.col(set_.cell_nodes[static_cast<std::size_t>(fibre.entry.cell)][static_cast<std::size_t>(k)]) +=
                local.col(k);
    }
    if (scene_.hydrodynamics.explicit_forces) return out;
    for (const Face& f : faces_) {
        const Vector3d u = vector(mean_of(p, f.nodes)) / h;
        const Vector3d drag = f.cd * u + f.ct * f.n.dot(u) * f.n;
        for (const int n : f.nodes) out.col(n) += 0.25 * drag;
    }
    return out;
}

// Adds -(dr_water/d(old state))^T lambda, by forward differentiation of every face.
void Reference::water_pullback(const Field& lambda, const Field& q, FieldState& bar) const {
    const Vector3d current = vector(scene_.hydrodynamics.current);
    Vector3d spine_bar = Vector3d::Zero();
    for (const Face& f : faces_) {
        const Vector3d d1 = now_.q.col(f.nodes[2]) - now_.q.col(f.nodes[0]);
        const Vector3d d2 = now_.q.col(f.nodes[3]) - now_.q.col(f.nodes[1]);
        const double sign = f.weight >= 0 ? 0.5 : -0.5;
        const Vector3d a = sign * d1.cross(d2);
        const Vector3d fresh =
            (vector(mean_of(q, f.nodes)) - vector(mean_of(now_.q, f.nodes))) / scene_.time_step - current;
        Triple<Dual> variables[4];
        const Vector3d values[4] = {a, f.u, fresh, spine_direction_};
        for (std::size_t v = 0; v < 4; ++v)
            for (std::size_t i = 0; i < 3; ++i)
                variables[v][i] = Dual(values[v][static_cast<Eigen::Index>(i)], 12, static_cast<int>(3 * v + i));
        const auto c = lag(variables[0], variables[1], variables[3], f.weight, laws_, scene_.hydrodynamics);
        const Triple<Dual>& u = scene_.hydrodynamics.explicit_forces ? variables[1] : variables[2];
        const dqa::Vec3 l = mean_of(lambda, f.nodes);
        const Dual nu = inner(c.n, u), nl = inner(c.n, l), ul = inner(u, l);
        const Dual work = c.cd * ul + (c.ct * nu + c.k) * nl;
        const Eigen::Matrix<double, 12, 1> d = -work.derivatives();
        const Vector3d a_bar = d.segment<3>(0), u_bar = d.segment<3>(3), fresh_bar = d.segment<3>(6);
        spine_bar += d.segment<3>(9);
        const Vector3d d1_bar = sign * d2.cross(a_bar), d2_bar = sign * a_bar.cross(d1);
        bar.q.col(f.nodes[2]) += d1_bar, bar.q.col(f.nodes[0]) -= d1_bar;
        bar.q.col(f.nodes[3]) += d2_bar, bar.q.col(f.nodes[1]) -= d2_bar;
        for (const int n : f.nodes) {
            bar.v.col(n) += 0.25 * u_bar;
            bar.q.col(n) -= 0.25 / scene_.time_step * fresh_bar;
        }
    }
    const dqa::MaterialPoint &head = sensors_.point(dqa::Sensors::head), &tail = sensors_.point(dqa::Sensors::tail);
    Vector3d axis = Vector3d::Zero();
    for (std::size_t k = 0; k < 8; ++k)
        axis += head.weight[k] * now_.q.col(head.node[k]) - tail.weight[k] * now_.q.col(tail.node[k]);
    const Vector3d axis_bar = (spine_bar - spine_direction_ * spine_direction_.dot(spine_bar)) / axis.norm();
    for (std::size_t k = 0; k < 8; ++k) {
        bar.q.col(head.node[k]) += head.weight[k] * axis_bar;
        bar.q.col(tail.node[k]) -= tail.weight[k] * axis_bar;
    }
}

// H lambda = q+_bar + v+_bar / h by L-BFGS on |.|_H^2 / 2 with exact steps, DiffPD's quasi-Newton variant. Its plain
// fixed point lambda <- lambda + A^-1 (b - H lambda) creeps here: muscles give A their stiffness in every direction and
// H in that of the fibre alone, which leaves a residual of 0.1 to 0.5 after 50 iterations of a body of 588 cells.
ReferenceReport Reference::adjoint(const FieldState& now, const std::vector<double>& signals, const FieldState& next,
                                   const FieldState& next_bar, FieldState& bar, std::vector<double>& signals_bar) {
    begin(now, signals);
    turns_.clear();
    const double h = scene_.time_step;
    const Field rhs = next_bar.q + next_bar.v / h;
    const double target = scene_.adjoint_tolerance_over(1) * rhs.norm();
    ReferenceReport report;
    Field lambda = Field::Zero(3, rhs.cols()), gradient = -rhs;
    QuasiNewton history;
    while (gradient.norm() > target) {
        if (report.iterations++ >= scene_.max_linear)
            dqa::fail(dqa::Status::NOT_CONVERGED, "reference: adjoint residual %.3g after %d iterations",
                      gradient.norm() / rhs.norm(), scene_.max_linear);
        const Field p = history.direction(gradient, [&](const Field& in) { return precondition(in); });
        const Field hp = product(next.q, p);
        const double curvature = dot(p, hp);
        if (!(curvature > 0))
            dqa::fail(dqa::Status::NOT_CONVERGED, "reference: the Hessian of the adjoint has negative curvature");
        const double t = -dot(gradient, p) / curvature;
        lambda += t * p, gradient += t * hp;
        history.remember(t * p, t * hp);
    }
    report.residual = target > 0 ? gradient.norm() / rhs.norm() : 0.0;
    bar.q = lambda * (mass_ / (h * h)).asDiagonal();
    bar.v = h * bar.q;
    bar.q -= next_bar.v / h;
    if (scene_.water) water_pullback(lambda, next.q, bar);
    // dE/dr of a fibre is -w (|F m| - r); r falls by sign * contraction for a unit of signal.
    for (const Fibre& fibre : fibres_) {
        const Corners x = gather(next.q, fibre.entry.cell), l = gather(lambda, fibre.entry.cell);
        double sum = 0.0;
        for (const auto& g : shape_gradient_) {
            const Eigen::Matrix<double, 8, 1> gm = g * vector(fibre.entry.direction);
            const Vector3d t = x * gm;
            sum += t.dot(l * gm) / std::sqrt(t.squaredNorm() + 1e-24);
        }
        signals_bar[static_cast<std::size_t>(fibre.entry.signal)] -=
            fibre.entry.weight * gauss_volume_ * fibre.entry.sign * scene_.contraction * sum;
    }
    return report;
}

}  // namespace bench
