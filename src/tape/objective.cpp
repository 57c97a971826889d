// SPDX-License-Identifier: MIT
#include "tape/objective.hpp"

#include <algorithm>
#include <cmath>

#include "motion/observation.hpp"

namespace dqa {
namespace {

// sqrt(x^2 + eps^2) - eps without cancellation, and its derivative.
double smooth_abs(double x, double eps) {
    return x * x / (std::sqrt(x * x + eps * eps) + eps);
}
double smooth_sign(double x, double eps) {
    return x / std::sqrt(x * x + eps * eps);
}

double dot(const Vec3& a, const Vec3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double spine_sum(const Design& design) {
    double sum = 0.0;
    for (const double w : design.spine()) sum += w;
    return sum;
}

Vec3 spine_mean(const Design& design, const double* field) {
    Vec3 sum{};
    for (std::size_t n = 0; n < design.spine().size(); ++n)
        for (std::size_t k = 0; k < 3; ++k) sum[k] += design.spine()[n] * field[3 * n + k];
    const double weight = spine_sum(design);
    for (double& x : sum) x /= weight;
    return sum;
}

void spine_mean_pullback(const Design& design, const double* field, const Vec3& mean, const Vec3& bar,
                         double* field_bar, double* spine_bar) {
    const double weight = spine_sum(design);
    for (std::size_t n = 0; n < design.spine().size(); ++n)
        for (std::size_t k = 0; k < 3; ++k) {
            field_bar[3 * n + k] += design.spine()[n] / weight * bar[k];
            spine_bar[n] += (field[3 * n + k] - mean[k]) / weight * bar[k];
        }
}

Vec3 place_on(const std::vector<ObjectiveTerm::Point>& path, double time) {
    const auto after =
        std::upper_bound(path.begin(), path.end(), time, [](double t, const auto& p) { return t < p.time; });
    if (after == path.begin()) return path.front().place;
    if (after == path.end()) return path.back().place;
    const auto before = after - 1;
    const double s = (time - before->time) / (after->time - before->time);
    Vec3 out{};
    for (std::size_t k = 0; k < 3; ++k) out[k] = (1.0 - s) * before->place[k] + s * after->place[k];
    return out;
}

// Offset of the centre from where it should be; the coordinates that do not exist are zero.
Vec3 offset_of(const Vec3& centre, const Vec3& target, const Design& design) {
    Vec3 d{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(design.set().box.dims); ++k) d[k] = centre[k] - target[k];
    return d;
}

void place_pullback(const Design& design, int which, const State& at, const Vec3& bar, State& state_bar,
                    double& x_bar) {
    design.sensors().read_pullback(which, bar, state_bar.q.data());
    x_bar += reading_by_place(design.sensors().point(which), at.q.data(), bar);
}

}  // namespace

Observed observed_of(const Simulation& simulation) {
    const Sensors& sensors = simulation.design().sensors();
    const double* q = simulation.q().data();
    Observed o;
    o.head = sensors.read(Sensors::head, q), o.centre = sensors.read(Sensors::centre, q);
    o.tail = sensors.read(Sensors::tail, q);
    o.velocity = spine_mean(simulation.design(), simulation.v().data());
    o.mean_drag = simulation.forces().mean_drag, o.mean_thrust = simulation.forces().mean_thrust;
    return o;
}

double state_value(const ObjectiveTerm& term, const Design& design, const Observed& state, double time) {
    const double eps = term.epsilon;
    switch (term.kind) {
        case ObjectiveKind::position_keeping: {
            double sum = -term.gamma * (state.head[0] - state.tail[0]);
            for (const double x : offset_of(state.centre, term.target, design)) sum += smooth_abs(x, eps);
            return sum;
        }
        case ObjectiveKind::efficiency: {
            const double thrust = smooth_abs(dot(state.mean_thrust, state.velocity), eps),
                         drag = smooth_abs(dot(state.mean_drag, state.velocity), eps);
            return -thrust / (1.0 + thrust + drag);
        }
        case ObjectiveKind::path: {
            const Vec3 d = offset_of(state.centre, place_on(term.path, time), design);
            return smooth_abs(std::sqrt(dot(d, d)), eps);
        }
        case ObjectiveKind::travel:
        case ObjectiveKind::effort:
            break;
    }
    return 0.0;
}

void state_pullback(const ObjectiveTerm& term, const Design& design, const Observed& state, double time, double scale,
                    const State& at, State& state_bar, WaterTotals& totals_bar, DesignBar& bar) {
    const double eps = term.epsilon;
    double nowhere = 0.0;  // the centre sensor does not move with the design
    switch (term.kind) {
        case ObjectiveKind::position_keeping: {
            Vec3 centre_bar = offset_of(state.centre, term.target, design);
            for (double& x : centre_bar) x = scale * smooth_sign(x, eps);
            place_pullback(design, Sensors::centre, at, centre_bar, state_bar, nowhere);
            place_pullback(design, Sensors::head, at, {-scale * term.gamma, 0.0, 0.0}, state_bar, bar.head_x);
            place_pullback(design, Sensors::tail, at, {scale * term.gamma, 0.0, 0.0}, state_bar, bar.tail_x);
            break;
        }
        case ObjectiveKind::efficiency: {
            const double p_thrust = dot(state.mean_thrust, state.velocity),
                         p_drag = dot(state.mean_drag, state.velocity);
            const double thrust = smooth_abs(p_thrust, eps), drag = smooth_abs(p_drag, eps), all = 1.0 + thrust + drag;
            const double thrust_bar = -scale * (1.0 + drag) / (all * all) * smooth_sign(p_thrust, eps),
                         drag_bar = scale * thrust / (all * all) * smooth_sign(p_drag, eps);
            Vec3 velocity_bar{};
            for (std::size_t k = 0; k < 3; ++k) {
                velocity_bar[k] = thrust_bar * state.mean_thrust[k] + drag_bar * state.mean_drag[k];
                totals_bar.mean_thrust[k] += thrust_bar * state.velocity[k];
                totals_bar.mean_drag[k] += drag_bar * state.velocity[k];
            }
            spine_mean_pullback(design, at.v.data(), state.velocity, velocity_bar, state_bar.v.data(),
                                bar.spine.data());
            break;
        }
        case ObjectiveKind::path: {
            Vec3 d = offset_of(state.centre, place_on(term.path, time), design);
            const double root = std::sqrt(dot(d, d) + eps * eps);
            for (double& x : d) x *= scale / root;
            place_pullback(design, Sensors::centre, at, d, state_bar, nowhere);
            break;
        }
        case ObjectiveKind::travel:
        case ObjectiveKind::effort:
            break;
    }
}

double travel_loss(const Design& design, const double* q_first, const double* q_last) {
    double sum = 0.0, weight = 0.0;
    for (std::size_t n = 0; n < design.spine().size(); ++n) {
        sum += design.spine()[n] * (q_last[3 * n] - q_first[3 * n]);
        weight += design.spine()[n];
    }
    return -sum / weight;
}

void travel_pullback(const Design& design, const double* q_first, const double* q_last, double scale,
                     double* q_first_bar, double* q_last_bar, double* spine_bar) {
    const double loss = travel_loss(design, q_first, q_last), weight = spine_sum(design);
    for (std::size_t n = 0; n < design.spine().size(); ++n) {
        const double w = scale * design.spine()[n] / weight;
        q_last_bar[3 * n] -= w;
        q_first_bar[3 * n] += w;
        spine_bar[n] -= scale * (q_last[3 * n] - q_first[3 * n] + loss) / weight;
    }
}

double effort_value(const std::vector<double>& actuation, double time_step) {
    double sum = 0.0;
    for (const double a : actuation) sum += a * a;
    return time_step * sum;
}

void effort_pullback(const std::vector<double>& actuation, double time_step, double scale, double* actuation_bar) {
    for (std::size_t k = 0; k < actuation.size(); ++k) actuation_bar[k] += 2.0 * scale * time_step * actuation[k];
}

}  // namespace dqa
