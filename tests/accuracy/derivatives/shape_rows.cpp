// SPDX-License-Identifier: MIT
// Rows of the shape: barycentre, peak, occupancy, actuators and their regions.
#include "actuator_vector.hpp"
#include "density_fixtures.hpp"
#include "shape/actuator_region.hpp"
#include "shape/barycenter.hpp"
#include "shape/occupancy.hpp"
#include "shape_fixtures.hpp"
#include "table.hpp"

namespace table {
namespace {

using namespace dqa;

void barycenter_rows(Table& t) {
    const fixtures::Cells cells{8, 8, 10};
    const std::vector<Vector> bases{
        fixtures::normalised(fixtures::soft_ellipsoid(cells, {3.6, 4.0, 5.0}, {2.2, 1.5, 2.9})),
        fixtures::normalised(fixtures::soft_ellipsoid(cells, {4.5, 4.3, 4.4}, {1.5, 2.3, 1.8})),
        fixtures::normalised(fixtures::soft_ellipsoid(cells, {4.2, 3.6, 6.0}, {2.6, 1.7, 1.4}))};
    const GaussianKernel kernel(cells, 1.0);
    for (const bool logarithmic : {false, true}) {
        BarycenterSettings s;
        s.tolerance = 1e-13, s.max_iterations = 20000, s.force_log = logarithmic;
        const Map f = [&](const Inputs& x) { return solve_barycenter(kernel, bases, x[0], s).p; };
        const Pullback back = [&](const Inputs& x, const Vector& bar) {
            return Inputs{barycenter_pullback(kernel, bases, solve_barycenter(kernel, bases, x[0], s), bar.data(), s)};
        };
        const char* stage = logarithmic ? "barycentre, in logarithms" : "barycentre";
        Field inside{"weights", {0.5, 0.3, 0.2}, 0.05}, edge{"weights, at an edge", {0.4, 0.0, 0.6}},
            vertex{"weights, at a vertex", {0.0, 1.0, 0.0}};
        inside.simplex = true;
        edge.direction = {-0.02, 0.05, -0.03}, vertex.direction = {0.02, -0.05, 0.03};
        for (const Field& field : {inside, edge, vertex}) t.prove(stage, {field}, f, back);
    }
}

// A plateau with small ripples, a rim and empty cells, as bodies have.
Vector plateau() {
    derivative::Random random(1);
    Vector p = random.vector(40, 0.97, 1.0);
    for (const double x : random.vector(30, 0.05, 0.9)) p.push_back(x);
    return p;
}

void density_rows(Table& t) {
    for (const Peak peak : {Peak::smooth, Peak::paper}) {
        Field density{"density", plateau(), peak == Peak::smooth ? 1e-2 : 1e-4};
        if (peak == Peak::paper) density.note = "away from ties of the maximum, where it has no derivative";
        t.prove(
            peak == Peak::smooth ? "normalised density" : "normalised density, hard maximum", {density},
            [&](const Inputs& x) {
                Vector out = x[0];
                const double top = peak_of(x[0], peak);
                for (double& p : out) p /= top;
                return out;
            },
            [&](const Inputs& x, const Vector& bar) {
                return Inputs{normalise_pullback(x[0], peak_of(x[0], peak), peak, bar.data())};
            });
    }
    const Occupancy law(0.02, 1e-10);
    const auto entrywise = [&](const char* stage, const auto& value, const auto& slope) {
        t.prove(
            stage, {{"normalised density", plateau(), 5e-3}},
            [&](const Inputs& x) {
                Vector out;
                for (const double p : x[0]) out.push_back(value(p));
                return out;
            },
            [&](const Inputs& x, const Vector& bar) {
                Vector out;
                for (std::size_t k = 0; k < bar.size(); ++k) out.push_back(bar[k] * slope(x[0][k]));
                return Inputs{out};
            });
    };
    entrywise("gain", gain, gain_derivative);
    entrywise(
        "occupancy", [&](double p) { return law.value(p); }, [&](double p) { return law.derivative(p); });
}

Actuator actuator(const Vec3& mean, const Vec3& half, const Vec3& euler) {
    Actuator a;
    a.mean = mean, a.euler = euler;
    for (std::size_t k = 0; k < 3; ++k) a.variance[k] = half[k] * half[k] / kTwoLn2;
    return a;
}

void actuator_rows(Table& t) {
    const Actuator first = actuator({0.1, 0.0, -0.05}, {0.3, 0.1, 0.15}, {0.2, -0.3, 0.4}),
                   second = actuator({-0.2, 0.05, 0.1}, {0.2, 0.15, 0.1}, {-0.1, 0.25, 0.6});
    const std::vector<const Actuator*> bases{&first, nullptr, &second};
    for (const Interpolation way : {Interpolation::linear, Interpolation::bures}) {
        const std::string kind = way == Interpolation::linear ? "linear" : "Bures";
        const Map f = [&](const Inputs& x) { return actuator_vector(interpolate_actuator(bases, x[0], way)); };
        const Pullback back = [&](const Inputs& x, const Vector& bar) {
            Vector out(3, 0.0);
            interpolate_actuator_pullback(bases, interpolate_actuator(bases, x[0], way), way,
                                          actuator_of<ActuatorBar>(bar), out);
            return Inputs{out};
        };
        Field edge{"weights, at an edge", {0.0, 0.97, 0.03}};
        edge.direction = {2e-3, -3e-3, 1e-3};
        for (const Field& field : {Field{"weights", {0.2, 0.5, 0.3}, 0.02},
                                   Field{"weights, a fading share", {0.01, 0.97, 0.02}, 1e-3}, edge})
            t.prove("actuator, " + kind, {field}, f, back);

        const double ramp = 0.1;
        const ActuatorPoint point = interpolate_actuator({&first, &second}, {0.4, 0.6}, way);
        derivative::Random random(21);
        std::vector<Vec3> places;
        while (places.size() < 100) {
            Vec3 x = point.mean;
            for (double& c : x) c += random.uniform(-0.35, 0.35);
            const double member = ActuatorRegion(point, ramp).membership(x);
            if (member > 0.01 && member < 0.99) places.push_back(x);
        }
        const auto region_row = [&](const char* stage, const auto& value, const auto& pull) {
            t.prove(
                std::string(stage) + ", " + kind, {{"box of the actuator", actuator_vector(point), 1e-3 * ramp}},
                [&](const Inputs& in) {
                    const ActuatorPoint p = actuator_of(in[0], point);
                    Vector out;
                    for (const Vec3& x : places) out.push_back(value(ActuatorRegion(p, ramp), x));
                    return out;
                },
                [&](const Inputs& in, const Vector& bar) {
                    const ActuatorPoint p = actuator_of(in[0], point);
                    ActuatorBar sum;
                    for (std::size_t k = 0; k < places.size(); ++k)
                        pull(ActuatorRegion(p, ramp), places[k], bar[k], sum);
                    return Inputs{actuator_vector(sum)};
                });
        };
        region_row(
            "region membership", [](const ActuatorRegion& r, const Vec3& x) { return r.membership(x); },
            [](const ActuatorRegion& r, const Vec3& x, double bar, ActuatorBar& sum) {
                r.membership_pullback(x, bar, sum);
            });
        region_row(
            "fibre groups",
            [](const ActuatorRegion& r, const Vec3& x) { return r.group_share(x, ActuatorHalf::left, 3, 1, 2); },
            [](const ActuatorRegion& r, const Vec3& x, double bar, ActuatorBar& sum) {
                r.group_share_pullback(x, ActuatorHalf::left, 3, 1, 2, bar, sum);
            });
        t.prove(
            "fibre direction, " + kind, {{"box of the actuator", actuator_vector(point), 0.05}},
            [&](const Inputs& in) {
                const Vec3 d = fibre_direction(actuator_of(in[0], point), ActuatorHalf::right);
                return Vector(d.begin(), d.end());
            },
            [&](const Inputs& in, const Vector& bar) {
                ActuatorBar out;
                fibre_direction_pullback(actuator_of(in[0], point), ActuatorHalf::right, {bar[0], bar[1], bar[2]}, out);
                return Inputs{actuator_vector(out)};
            });
    }
}

}  // namespace

void shape_rows(Table& t) {
    barycenter_rows(t);
    density_rows(t);
    actuator_rows(t);
}

}  // namespace table
