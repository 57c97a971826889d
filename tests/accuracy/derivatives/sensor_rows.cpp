// SPDX-License-Identifier: MIT
// Rows of the sensors and of what controllers observe.
#include "density_fixtures.hpp"
#include "motion/observation.hpp"
#include "motion_fixtures.hpp"
#include "table.hpp"

namespace table {
namespace {

using namespace dqa;

void place_rows(Table& t) {
    const Box box{{24, 6, 8}, 0.1};
    derivative::Random random(8);
    Vector density = fixtures::soft_ellipsoid(box.cells, {12.2, 3.1, 3.8}, {8.3, 2.2, 2.9});
    std::vector<char> mask;
    for (double& p : density) mask.push_back((p *= random.uniform(0.85, 1.0)) > 0.02);
    const ActiveSet set = make_active_set(box, mask);
    const Vector rest = set.rest_positions();
    const Vector q = derivative::along(rest, 0.03, random.vector(rest.size()));
    const auto sensors_of = [&](const Vector& p) { return Sensors(set, p, 0.02, -0.03); };
    t.prove(
        "sensors, places of head and tail", {{"normalised density", density, 3e-3}},
        [&](const Inputs& x) {
            const Sensors s = sensors_of(x[0]);
            return Vector{s.point(Sensors::head).rest[0], s.point(Sensors::tail).rest[0]};
        },
        [&](const Inputs& x, const Vector& bar) {
            Vector out(x[0].size(), 0.0);
            sensors_of(x[0]).place_pullback(bar[0], bar[1], out.data());
            return Inputs{out};
        });
    t.prove(
        "spine direction", {{"state", q, 0.05}, {"normalised density", density, 3e-3}},
        [&](const Inputs& x) {
            const Vec3 d = sensors_of(x[1]).direction(x[0].data());
            return Vector(d.begin(), d.end());
        },
        [&](const Inputs& x, const Vector& bar) {
            const Sensors s = sensors_of(x[1]);
            Vector q_bar(x[0].size(), 0.0), p_bar(x[1].size(), 0.0);
            double head = 0.0, tail = 0.0;
            s.direction_pullback(x[0].data(), {bar[0], bar[1], bar[2]}, q_bar.data(), head, tail);
            s.place_pullback(head, tail, p_bar.data());
            return Inputs{q_bar, p_bar};
        });
}

void observation_rows(Table& t, const std::string& name, const std::shared_ptr<const ShapeSpace>& space) {
    const auto design = fixtures::make_design({}, {0.6, 0.4}, space);
    const Vector q = derivative::along(design->rest(), 0.01, fixtures::swirl(design->rest(), 1.0));
    const auto back = [&](const Vector& at, const Vector& v, const Vector& bar) {
        DesignBar design_bar = design->zero_bar();
        Inputs out{Vector(at.size(), 0.0), Vector(v.size(), 0.0)};
        observe_pullback(*design, at.data(), v.data(), bar.data(), out[0].data(), out[1].data(), design_bar);
        out.push_back({design_bar.head_x, design_bar.tail_x});
        return out;
    };
    t.prove(
        name, {{"positions", q, 0.05, true}, {"velocities", fixtures::swirl(q, 0.5), 0.1, true}},
        [&](const Inputs& x) { return observe(*design, x[0].data(), x[1].data()); },
        [&](const Inputs& x, const Vector& bar) { return back(x[0], x[1], bar); });
    // The same fields read at other places of head and tail within their cells, where readings are linear.
    const Vector v = fixtures::swirl(q, 0.5);
    const std::size_t dims = static_cast<std::size_t>(space->box().dims);
    const Vec3 centre = design->sensors().read(Sensors::centre, q.data());
    const Vector places{design->sensors().point(Sensors::head).rest[0], design->sensors().point(Sensors::tail).rest[0]};
    t.prove(
        name,
        {{"places of head and tail", places, 1e-3, true, "within a cell; through the weights in the whole chain"}},
        [&](const Inputs& x) {
            Vector out = observe(*design, q.data(), v.data());
            for (const std::size_t end : {std::size_t{0}, std::size_t{1}}) {
                Vec3 rest = design->sensors().point(end ? Sensors::tail : Sensors::head).rest;
                rest[0] = x[0][end];
                const MaterialPoint p = locate(design->set(), rest, 1, true);
                for (std::size_t a = 0; a < dims; ++a) {
                    double speed = 0.0, offset = -centre[a];
                    for (std::size_t n = 0; n < 8; ++n) {
                        const std::size_t at = 3 * static_cast<std::size_t>(p.node[n]) + a;
                        speed += p.weight[n] * v[at], offset += p.weight[n] * q[at];
                    }
                    out[2 * end * dims + a] = speed, out[(3 + end) * dims + a] = offset;
                }
            }
            return out;
        },
        [&](const Inputs&, const Vector& bar) { return Inputs{back(q, v, bar)[2]}; });
}

}  // namespace

void sensor_rows(Table& t) {
    place_rows(t);
    observation_rows(t, "observation", fixtures::ellipsoid_space({12, 6, 6}, 0.08));
    observation_rows(t, "observation, 2-D", fixtures::plane_space(16, 8, 0.06));
}

}  // namespace table
