// SPDX-License-Identifier: MIT
// Objectives of a rollout, smooth everywhere: |x| stands for sqrt(x^2 + epsilon^2) - epsilon. Steps i = 1 ... N end at
// state i; c, h, t are the places of centre, head and tail sensors, d the dimensions.
//   travel            -(mean over the spine of x_N - x_0)                         (m; DiffAqua 2021, section 8.1)
//   position keeping  sum_i [ sum_{k < d} |c_i - target|_k - gamma (h_i - t_i).x ]  (m; section 8.2)
//   efficiency        -sum_i |P_t| / (1 + |P_t| + |P_d|),  P = (mean force).(mean velocity)  (section 8.3)
//   effort            time_step * sum_i |a_i|^2                                   (s)
//   path              sum_i |c_i - p(t_i)|, Euclidean distance                   (m)
// Mean forces of step i are drag and thrust over wet area (N/m^2), the mean velocity is that of the spine at state i
// (m/s), spine and travel are weighted by rest occupancy. p is a polyline over time, constant before its first and
// after its last point.
#pragma once

#include <vector>

#include "motion/simulation.hpp"

namespace dqa {

enum class ObjectiveKind : int { travel = 0, position_keeping = 1, efficiency = 2, effort = 3, path = 4 };

struct ObjectiveTerm {
    ObjectiveKind kind = ObjectiveKind::travel;
    double weight = 1.0;
    Vec3 target{};          // m
    double gamma = 0.01;    // of the heading
    double epsilon = 1e-4;  // m; of the efficiency W/m^2
    struct Point {
        double time = 0.0;  // s, on the simulator's clock
        Vec3 place{};       // m
    };
    std::vector<Point> path{};  // times increase
};

// What objectives need of a state; recorded with it, so that their values need no state again.
struct Observed {
    Vec3 head{}, centre{}, tail{};    // places of the sensors (m)
    Vec3 velocity{};                  // mean over the spine (m/s)
    Vec3 mean_drag{}, mean_thrust{};  // of the step that led here (N/m^2)
};
Observed observed_of(const Simulation& simulation);

// A state's share of a term (all but travel and effort); `time` of the state on the simulator's clock.
double state_value(const ObjectiveTerm& term, const Design& design, const Observed& state, double time);
// Adds `scale` times the gradient of that share: to the state's q_bar and v_bar, to `bar`, and to the cotangents of the
// mean forces of the step that led to the state.
void state_pullback(const ObjectiveTerm& term, const Design& design, const Observed& state, double time, double scale,
                    const State& at, State& state_bar, WaterTotals& totals_bar, DesignBar& bar);

double travel_loss(const Design& design, const double* q_first, const double* q_last);
// Adds `scale` times the gradient to q_first_bar, q_last_bar [n_nodes][3] and to spine_bar [n_nodes].
void travel_pullback(const Design& design, const double* q_first, const double* q_last, double scale,
                     double* q_first_bar, double* q_last_bar, double* spine_bar);

// A step's share of the effort, and its gradient times `scale` added to actuation_bar.
double effort_value(const std::vector<double>& actuation, double time_step);
void effort_pullback(const std::vector<double>& actuation, double time_step, double scale, double* actuation_bar);

}  // namespace dqa
