// SPDX-License-Identifier: MIT
// Rows of the whole chain, from every quantity to the objectives of ten steps: dimensions, integrators, materials,
// controllers and places of the weights, each with each other one at least once.
#include "control/perceptron.hpp"
#include "objective_terms.hpp"
#include "table.hpp"
#include "tape/gradient_check.hpp"
#include "winged_space.hpp"

namespace table {
namespace {

using namespace dqa;

constexpr const char* kNames[] = {"weights",
                                  "parameters of the controller",
                                  "actuation",
                                  "initial positions",
                                  "initial velocities",
                                  "water (current, density, coefficients)",
                                  "current of each step",
                                  "current's table",
                                  "Young's modulus of each cell",
                                  "muscle stiffness of each cell",
                                  "material (E, w, ν, ρ)",
                                  "μ and λ"};

struct Case {
    std::string name;
    std::shared_ptr<const ShapeSpace> space;
    Vector weights;
    Integrator integrator;
    Material material;
    bool closed_loop, held;  // held: planar motion, and nodes that keep their place
};

std::unique_ptr<Controller> controller_of(const Case& c, const Design& design) {
    const int n = design.n_signals();
    if (!c.closed_loop) {
        auto out = std::make_unique<Sinusoid>(n, design.scene().time_step);
        Vector theta;
        for (int k = 0; k < n; ++k) theta.insert(theta.end(), {0.8 - 0.03 * k, 11.0 + 0.7 * k, 0.3 + 0.4 * k});
        out->set_parameters(theta);
        return out;
    }
    PerceptronSettings s;
    s.n_signals = n, s.dims = c.space->box().dims, s.hidden = {12, 8}, s.seed = 5, s.scale = 1.5;
    return std::make_unique<Perceptron>(s);
}

Simulation moving(const Case& c) {
    SceneSettings scene;
    scene.integrator = c.integrator, scene.material = c.material, scene.planar = c.held;
    // Almost empty cells of this material turn inside out in such a motion, and Newton's method then stops short of the
    // residual that differences need.
    if (c.material == Material::neo_hookean && c.space->box().dims == 3)
        scene.threshold = 0.3, scene.poisson_ratio = 0.3;
    else if (c.material == Material::neo_hookean)
        scene.contraction = 0.08, scene.time_step = 1.0 / 60.0;
    const Box& box = c.space->box();
    const int across = box.dims == 3 ? box.cells[2] + 1 : 1;
    for (int k = 0; c.held && k < across * (box.cells[1] + 1); ++k)
        scene.fixed_nodes.push_back(box.node(box.cells[0] / 2, k / across, k % across));
    scene.shape_tolerance = 1e-12;
    Simulation s(fixtures::make_design(scene, c.weights, c.space));
    Vector v = fixtures::swirl(s.q(), 0.1);
    for (std::size_t i = 2; box.dims == 2 && i < v.size(); i += 3) v[i] = 0.0;
    s.set_state(nullptr, v.data());
    const double z = box.dims == 3 ? 1.0 : 0.0;
    s.set_current(std::make_shared<WaterCurrent>(
        std::vector<double>{0.0, 0.15, 0.5},
        std::vector<Vec3>{{-0.5, 0.05, 0.02 * z}, {-0.6, 0.1, 0.0}, {-0.3, 0.2, 0.1 * z}}));
    return s;
}

std::vector<ObjectiveTerm> random_sum(std::uint64_t seed, bool plane) {
    derivative::Random random(seed);
    std::vector<ObjectiveTerm> out;
    for (const ObjectiveKind kind : {ObjectiveKind::travel, ObjectiveKind::position_keeping, ObjectiveKind::efficiency,
                                     ObjectiveKind::effort, ObjectiveKind::path}) {
        ObjectiveTerm term = term_of(kind);
        term.weight = random.uniform(0.3, 1.0) * (random.uniform(-1.0, 1.0) < 0 ? -1.0 : 1.0);
        if (plane) {
            term.target[2] = 0.0;
            for (ObjectiveTerm::Point& p : term.path) p.place[2] = 0.0;
        }
        out.push_back(term);
    }
    return out;
}

void rows_of(Table& t, const Case& c, const std::vector<WithRespectTo>& quantities) {
    std::unique_ptr<Simulation> simulation;
    std::unique_ptr<Controller> controller;
    const std::string stage = "whole chain, " + c.name;
    if (t.measures(stage)) {
        simulation = std::make_unique<Simulation>(moving(c));
        controller = controller_of(c, simulation->design());
        for (int k = 0; k < 2; ++k) advance(*simulation, actuation_of(*controller, *simulation), nullptr);
    }
    for (const WithRespectTo quantity : quantities)
        t.add(stage, kNames[static_cast<int>(quantity)], [&] {
            GradientCheckReport reports[2];
            for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
                GradientCheckSettings settings;
                settings.quantity = quantity;
                settings.seed = 13 + k;
                // Shorter than usual where the loss bends most.
                if (quantity == WithRespectTo::initial_position) settings.step = 1e-2;
                if (quantity == WithRespectTo::material || quantity == WithRespectTo::lame) settings.step = 3e-3;
                reports[k] = check_gradient(*simulation, controller.get(), random_sum(40 + k, c.space->box().dims == 2),
                                            settings);
            }
            Row row;
            row.slope = reports[0].taylor_slope;
            row.differences = reports[0].relative_error;
            row.dot_product = worse(reports[0].relative_error, reports[1].relative_error);
            if (reports[0].one_sided) row.note = "one-sided";
            if (!(reports[0].gradient_norm > 0.0) || !(reports[1].gradient_norm > 0.0)) row.slope = std::nan("");
            return row;
        });
}

}  // namespace

void chain_rows(Table& t) {
    constexpr Integrator euler = Integrator::implicit_euler, bdf2 = Integrator::bdf2;
    constexpr Material plain = Material::corotated, volume = Material::corotated_volume,
                       neo_hookean = Material::neo_hookean;
    const auto solid = fixtures::ellipsoid_space({14, 6, 6}, 0.07), plane = fixtures::plane_space(16, 8, 0.06);
    const Vector inside{0.6, 0.4}, vertex{0.0, 1.0};
    std::vector<WithRespectTo> all;
    for (int k = 0; k < 12; ++k) all.push_back(static_cast<WithRespectTo>(k));
    for (const Case& c :
         {Case{"3-D, implicit Euler, corotated, sinusoid, inside", solid, inside, euler, plain, false, false},
          Case{"3-D, BDF2, neo-Hookean, closed loop, inside", solid, inside, bdf2, neo_hookean, true, false},
          Case{"3-D, implicit Euler, volume term, closed loop, vertex", solid, vertex, euler, volume, true, false},
          Case{"3-D, BDF2, corotated, sinusoid, vertex, nodes held", solid, vertex, bdf2, plain, false, true},
          Case{"2-D, implicit Euler, neo-Hookean, sinusoid, vertex", plane, vertex, euler, neo_hookean, false, false},
          Case{"2-D, BDF2, corotated, closed loop, inside", plane, inside, bdf2, plain, true, false},
          Case{"2-D, BDF2, volume term, sinusoid, vertex", plane, vertex, bdf2, volume, false, false},
          Case{"2-D, implicit Euler, corotated, closed loop, inside, nodes held",
               plane,
               {0.3, 0.7},
               euler,
               plain,
               true,
               true}})
        rows_of(t, c, all);
    const std::vector<WithRespectTo> of_muscles{WithRespectTo::weights, WithRespectTo::control,
                                                WithRespectTo::actuation, WithRespectTo::muscle_stiffness};
    for (const bool bures : {false, true})
        rows_of(
            t,
            {std::string("tail and fins, ") + (bures ? "Bures" : "linear"),
             winged_space(bures ? Interpolation::bures : Interpolation::linear), inside, euler, plain, bures, false},
            of_muscles);
}

}  // namespace table
