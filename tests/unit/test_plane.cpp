// SPDX-License-Identifier: MIT
// Two dimensions: against a layer of three-dimensional cells that does not move along z, against geometry, and the
// gradient of the whole chain against finite differences.
#include <map>

#include "motion_fixtures.hpp"
#include "tape/gradient_check.hpp"

namespace {

using namespace fixtures;

const std::shared_ptr<const ShapeSpace>& space() {
    static const auto s = plane_space();
    return s;
}

ActiveSet layer(int dims) {
    Box box{{5, 4, 1}, 0.1};
    box.dims = dims;
    std::vector<char> mask(static_cast<std::size_t>(box.n_cells()), 1);
    mask[0] = mask[7] = 0;
    return make_active_set(box, mask);
}

// Every node of the layer has its node of the plane.
std::vector<std::size_t> shadows(const ActiveSet& solid, const ActiveSet& plane) {
    std::vector<std::size_t> out;
    for (const auto& ijk : solid.node_ijk)
        out.push_back(static_cast<std::size_t>(
            plane.node_to_active[static_cast<std::size_t>(plane.box.node(ijk[0], ijk[1], 0))]));
    return out;
}

void test_body_is_a_layer() {
    const ActiveSet plane = layer(2), solid = layer(3);
    CHECK(solid.n_nodes() == 2 * plane.n_nodes() && plane.n_cells() == solid.n_cells());
    const auto shadow = shadows(solid, plane);
    Random random{1};
    Vector mu(static_cast<std::size_t>(plane.n_cells()));
    for (double& m : mu) m = between(random, 1e5, 1e6);
    std::vector<MuscleEntry> muscles;
    for (int c = 0; c < 6; ++c) muscles.push_back({2 * c, 0, c % 2 ? 1.0 : -1.0, {0.8, c % 2 ? 0.6 : -0.6, 0.0}, 3e5});
    const Body flat(plane, {Material::corotated, mu, {}}, muscles, 0.2, InstructionSet::automatic),
        thick(solid, {Material::corotated, mu, {}}, muscles, 0.2, InstructionSet::automatic);
    Vector q = plane.rest_positions();
    for (std::size_t i = 0; i < q.size(); ++i)
        if (i % 3 != 2) q[i] += 0.02 * random();
    Vector Q = solid.rest_positions(), p(q.size(), 0.0), P(Q.size(), 0.0);
    for (std::size_t i = 0; i < p.size(); ++i)
        if (i % 3 != 2) p[i] = random();
    for (std::size_t n = 0; n < shadow.size(); ++n)
        for (std::size_t a = 0; a < 2; ++a) Q[3 * n + a] = q[3 * shadow[n] + a], P[3 * n + a] = p[3 * shadow[n] + a];
    BodyWorkspace wf, wt;
    const double signal = 0.7;
    Vector ef(q.size()), mf(q.size()), et(Q.size()), mt(Q.size()), hf(q.size(), 0.0), ht(Q.size(), 0.0);
    const double energy = flat.gradient(wf, q.data(), &signal, 1, ef.data(), mf.data());
    NEAR(energy, thick.gradient(wt, Q.data(), &signal, 1, et.data(), mt.data()), 1e-12 * energy);
    flat.product(wf, p.data(), 1, hf.data());
    thick.product(wt, P.data(), 1, ht.data());
    const auto gathered = [&](const Vector& from) {
        Vector out(q.size(), 0.0);
        for (std::size_t n = 0; n < shadow.size(); ++n)
            for (std::size_t a = 0; a < 2; ++a) out[3 * shadow[n] + a] += from[3 * n + a];
        return out;
    };
    NEAR(relative_difference(ef, gathered(et)), 0.0, 1e-12);
    NEAR(relative_difference(mf, gathered(mt)), 0.0, 1e-12);
    NEAR(relative_difference(hf, gathered(ht)), 0.0, 1e-12);
}

// A rectangle of full cells: the wet surface is its outline times the thickness of the slab, and a uniform drag law
// gives the textbook force on it.
void test_water_sees_edges() {
    Box box{{6, 3, 1}, 0.1};
    box.dims = 2;
    const ActiveSet set = make_active_set(box, std::vector<char>(18, 1));
    WaterSettings w;
    w.surface_smoothing = 1e-9;
    w.drag = {1.0, 1.0, 1.0, 1.0};
    w.thrust = {0.0, 0.0, 0.0, 0.0};
    w.speed_smoothing = 1e-9;
    const Water water(set, Vector(18, 1.0), w);
    WaterWorkspace ws;
    const Vector q = set.rest_positions();
    Vector v(q.size(), 0.0), q_new(q);
    const double h = 0.01, speed = 0.5;
    for (std::size_t i = 0; i < q.size(); i += 3) v[i] = speed, q_new[i] += h * speed;
    water.lag(ws, q.data(), v.data(), {1.0, 0.0, 0.0}, {}, 1);
    const WaterTotals t = water.totals(ws, q_new.data(), q.data(), h);
    const double outline = 2.0 * (0.6 + 0.3) * 0.1;
    NEAR(t.drag[0], -0.5 * 1000.0 * outline * speed * speed, 1e-6 * 22.5);
    NEAR(t.mean_drag[0], t.drag[0] / outline, 1e-6);
    CHECK(std::fabs(t.drag[1]) < 1e-9 && t.drag[2] == 0.0);
    Vector force(q.size(), 0.0);
    water.gradient(ws, q_new.data(), q.data(), h, 1, force.data());
    double sum = 0.0;
    for (std::size_t i = 0; i < force.size(); i += 3) sum += force[i];
    NEAR(sum, -t.drag[0], 1e-9 * std::fabs(sum));
}

// Closed polygons with the body to their left, of the body's area.
void test_contour() {
    const auto design = make_design({}, {0.5, 0.5}, space());
    const Isosurface& s = design->surface();
    CHECK(s.triangles.empty() && s.segments.size() == s.vertices.size() && s.segments.size() > 20);
    std::map<int, int> starts, ends;
    double area = 0.0;
    for (const auto& [a, b] : s.segments) {
        ++starts[a], ++ends[b];
        const Vec3 &x = s.vertices[static_cast<std::size_t>(a)], &y = s.vertices[static_cast<std::size_t>(b)];
        area += 0.5 * (x[0] * y[1] - x[1] * y[0]);
    }
    for (const auto& [vertex, count] : starts) CHECK(count == 1 && ends[vertex] == 1);
    const double dx = space()->box().dx, body = design->n_body_cells() * dx * dx;
    NEAR(area, body, 0.06 * body);
    CHECK(design->carry_surface(design->rest().data()).size() == s.vertices.size());
}

void test_swims_in_its_plane() {
    SceneSettings scene;
    for (const Integrator integrator : {Integrator::implicit_euler, Integrator::bdf2}) {
        scene.integrator = integrator;
        Simulation s(make_design(scene, {0.5, 0.5}, space()));
        double mass = 0.0;
        for (const double m : s.design().mass()) mass += m;
        for (int k = 0; k < 20; ++k) {
            const double a = std::sin(0.5 * k);
            const StepReport r = s.step({&a, {}});
            CHECK(r.residual <= scene.tolerance && r.inverted == 0);
        }
        for (std::size_t i = 2; i < s.q().size(); i += 3) CHECK(s.q()[i] == 0.0 && s.v()[i] == 0.0);
        double x = 0.0;
        for (std::size_t n = 0; n < s.design().mass().size(); ++n)
            x += s.design().mass()[n] / mass * (s.q()[3 * n] - s.design().rest()[3 * n]);
        CHECK(std::fabs(x) > 1e-5 && std::fabs(x) < 0.5);
    }
}

void test_methods_agree() {
    SceneSettings scene = tight_scene();
    Simulation pcg(make_design(scene, {0.4, 0.6}, space()));
    scene.method = Method::newton_direct;
    Simulation direct(make_design(scene, {0.4, 0.6}, space()));
    for (int k = 0; k < 3; ++k) {
        const double a = 0.9 - 0.4 * k;
        pcg.step({&a, {}}), direct.step({&a, {}});
    }
    NEAR(relative_difference(plus(pcg.q(), -1.0, pcg.design().rest()), plus(direct.q(), -1.0, pcg.design().rest())),
         0.0, 1e-7);
}

void test_gradient() {
    static constexpr const char* names[] = {"weights",          "control", "actuation", "initial position",
                                            "initial velocity", "water",   "current",   "current table"};
    for (const Integrator integrator : {Integrator::implicit_euler, Integrator::bdf2}) {
        SceneSettings scene;
        scene.integrator = integrator;
        scene.hydrodynamics.current = {-0.3, 0.0, 0.0};
        Simulation s(make_design(scene, {0.35, 0.65}, space()));
        Sinusoid controller(1, scene.time_step);
        controller.set_parameters({0.8, 11.0, 0.3});
        for (int quantity = 0; quantity < 8; ++quantity) {
            GradientCheckSettings settings;
            settings.quantity = static_cast<WithRespectTo>(quantity);
            settings.n_steps = 5;
            const GradientCheckReport r = check_gradient(s, quantity < 2 ? &controller : nullptr, {{}}, settings);
            print_message("%-17s %-5s: adjoint % .6e, error %.1e, slope %.3f\n", names[quantity],
                          integrator == Integrator::bdf2 ? "bdf2" : "euler", r.adjoint, r.relative_error,
                          r.taylor_slope);
            CHECK(r.gradient_norm > 0 && r.relative_error <= 1e-6);
            NEAR(r.taylor_slope, 2.0, 0.1);
        }
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_body_is_a_layer),    TEST(test_water_sees_edges), TEST(test_contour),
        TEST(test_swims_in_its_plane), TEST(test_methods_agree),    TEST(test_gradient),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
