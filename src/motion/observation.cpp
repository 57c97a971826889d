// SPDX-License-Identifier: MIT
#include "motion/observation.hpp"

namespace dqa {
namespace {

constexpr int kOrder[] = {Sensors::head, Sensors::centre, Sensors::tail};

}  // namespace

double reading_by_place(const MaterialPoint& point, const double* field, const Vec3& bar) {
    double sum = 0.0;
    for (std::size_t n = 0; n < 8; ++n)
        for (std::size_t k = 0; k < 3; ++k)
            sum += point.weight_by_x[n] * field[3 * static_cast<std::size_t>(point.node[n]) + k] * bar[k];
    return sum;
}

int n_observed(const Design& design) {
    return 5 * design.set().box.dims;
}

std::vector<double> observe(const Design& design, const double* q, const double* v) {
    const Sensors& sensors = design.sensors();
    const std::size_t dims = static_cast<std::size_t>(design.set().box.dims);
    std::vector<double> out;
    for (const int which : kOrder) {
        const Vec3 u = sensors.read(which, v);
        for (std::size_t k = 0; k < dims; ++k) out.push_back(u[k]);
    }
    const Vec3 c = sensors.read(Sensors::centre, q);
    for (const int which : {Sensors::head, Sensors::tail}) {
        const Vec3 x = sensors.read(which, q);
        for (std::size_t k = 0; k < dims; ++k) out.push_back(x[k] - c[k]);
    }
    return out;
}

void observe_pullback(const Design& design, const double* q, const double* v, const double* observation_bar,
                      double* q_bar, double* v_bar, DesignBar& bar) {
    const Sensors& sensors = design.sensors();
    const std::size_t dims = static_cast<std::size_t>(design.set().box.dims);
    const auto part = [&](std::size_t k) {
        Vec3 out{};
        for (std::size_t a = 0; a < dims; ++a) out[a] = observation_bar[dims * k + a];
        return out;
    };
    for (std::size_t k = 0; k < 3; ++k) sensors.read_pullback(kOrder[k], part(k), v_bar);
    const Vec3 head = part(3), tail = part(4);
    sensors.read_pullback(Sensors::head, head, q_bar);
    sensors.read_pullback(Sensors::tail, tail, q_bar);
    sensors.read_pullback(Sensors::centre, {-head[0] - tail[0], -head[1] - tail[1], -head[2] - tail[2]}, q_bar);
    const MaterialPoint &h = sensors.point(Sensors::head), &t = sensors.point(Sensors::tail);
    bar.head_x += reading_by_place(h, v, part(0)) + reading_by_place(h, q, head);
    bar.tail_x += reading_by_place(t, v, part(2)) + reading_by_place(t, q, tail);
}

std::vector<double> actuation_of(const Controller& controller, const Simulation& simulation) {
    std::vector<double> actuation(static_cast<std::size_t>(controller.n_signals()));
    std::vector<double> seen;
    if (controller.n_sensors() > 0) seen = observe(simulation.design(), simulation.q().data(), simulation.v().data());
    controller.evaluate(simulation.steps(), seen.data(), actuation.data());
    return actuation;
}

}  // namespace dqa
