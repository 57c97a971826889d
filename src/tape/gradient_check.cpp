// SPDX-License-Identifier: MIT
#include "tape/gradient_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "grid/error.hpp"
#include "grid/random.hpp"

namespace dqa {
namespace {

constexpr int kLevels = 6;           // steps of the ladder
constexpr int kShapeLevels = 5;      // of them for differences by weights: below, what is left of the barycentre's
                                     // convergence error changes faster than the loss
constexpr double kRatio = 0.25;      // between them
constexpr double kSettled = 0.02;    // of successive slopes of the remainder
constexpr double kAgreement = 1e-7;  // of neighbouring entries: smaller steps would only add rounding

// Everything a rollout depends on, so that each of it can be perturbed. actuation: added to what the controller says,
// if there is one.
struct Inputs {
    std::vector<double> weights, theta, actuation, q, v;
    std::vector<double> water;  // as Adjoint::water_bar; the uniform current is added to the others
    std::vector<double> current, current_table;
    std::vector<double> young, muscle, material, lame;  // as in WithRespectTo
};

class Rollout {
public:
    Rollout(const Simulation& simulation, const Controller* controller, const std::vector<ObjectiveTerm>& terms,
            int n_steps)
        : terms_(terms),
          n_steps_(n_steps),
          first_step_(simulation.steps()),
          origin_(simulation.shared_design()),
          source_(simulation.current()) {
        scene_ = origin_->scene();
        scene_.tolerance = 1e-13;
        scene_.adjoint_tolerance = 1e-12;
        scene_.shape_tolerance = 1e-13;
        scene_.max_newton = std::max(scene_.max_newton, 100);
        scene_.max_linear = std::max(scene_.max_linear, 5000);
        base_.weights = origin_->point().barycenter.weights;
        base_.q = simulation.q(), base_.v = simulation.v();
        const Box& box = origin_->set().box;
        for (int c = 0; c < box.n_cells(); ++c)
            base_.young.push_back(scene_.young(c)), base_.muscle.push_back(scene_.muscle(c));
        base_.material = {0.0, 0.0, scene_.poisson_ratio, scene_.density};  // the moduli are added to all cells
        base_.lame = {scene_.unit_mu() * scene_.young_modulus, scene_.unit_lambda() * scene_.young_modulus};
        const WaterSettings& water = scene_.hydrodynamics;
        base_.water = {0.0, 0.0, 0.0, water.density};
        base_.water.insert(base_.water.end(), water.drag.begin(), water.drag.end());
        base_.water.insert(base_.water.end(), water.thrust.begin(), water.thrust.end());
        for (int k = 0; k < n_steps; ++k)
            for (const double x : source_->value(time(k))) base_.current.push_back(x);
        for (const Vec3& row : source_->rows())
            base_.current_table.insert(base_.current_table.end(), row.begin(), row.end());
        if (controller) controller_ = controller->clone(), base_.theta = controller->parameters();
        const int n = origin_->n_signals();
        for (int k = 0; k < n_steps; ++k)
            for (int s = 0; s < n; ++s) base_.actuation.push_back(controller ? 0.0 : 0.5 * std::sin(0.5 * (k + 1) + s));
        design_ = design_for(base_.weights, scene_);
        // At the tight tolerance a cell at the edge of the active set may have entered or left.
        base_.q = carried(base_.q, origin_->set(), *design_, design_->rest());
        base_.v = carried(base_.v, origin_->set(), *design_, std::vector<double>(design_->rest().size(), 0.0));
    }

    const Inputs& base() const { return base_; }
    const Design& design() const { return *design_; }

    std::shared_ptr<Tape> run(const Inputs& in, WithRespectTo changed) const {
        auto design = design_;
        if (changed == WithRespectTo::weights && in.weights != base_.weights) design = design_for(in.weights, scene_);
        if (changed == WithRespectTo::water && in.water != base_.water)
            design = std::make_shared<Design>(*design_, in_water(in.water));
        if (changed >= WithRespectTo::young_modulus)
            design = std::make_shared<Design>(*design_, of_material(in, changed));
        Simulation simulation(design);
        set_state(simulation, in);
        auto tape = std::make_shared<Tape>(0);
        const std::unique_ptr<Controller> controller = controller_ ? controller_->clone() : nullptr;
        if (controller) controller->assign_parameters(in.theta), tape->set_controller(*controller);
        const std::size_t n = static_cast<std::size_t>(design->n_signals());
        for (int k = 0; k < n_steps_; ++k) {
            std::vector<double> a(in.actuation.begin() + static_cast<long>(n) * k,
                                  in.actuation.begin() + static_cast<long>(n) * (k + 1));
            if (controller) {
                const std::vector<double> said = actuation_of(*controller, simulation);
                for (std::size_t i = 0; i < n; ++i) a[i] += said[i];
            }
            Vec3 current{};
            for (std::size_t x = 0; x < 3; ++x)
                current[x] = in.current[3 * static_cast<std::size_t>(k) + x] + in.water[x];
            if (changed == WithRespectTo::current_table)
                current = source_->with_rows(rows(in.current_table)).value(time(k));
            advance(simulation, a, current, tape.get());
        }
        return tape;
    }

    double loss(const Inputs& in, WithRespectTo changed) const { return run(in, changed)->objective(terms_, nullptr); }
    // At the start of step k of the rollout (s).
    double time(int k) const { return static_cast<double>(first_step_ + k) * origin_->scene().time_step; }
    const WaterCurrent& current_source() const { return *source_; }

private:
    std::shared_ptr<const Design> design_for(const std::vector<double>& weights, const SceneSettings& scene) const {
        return std::make_shared<Design>(std::shared_ptr<const ShapeSpace>(origin_, &origin_->space()), weights, scene,
                                        nullptr);
    }

    SceneSettings in_water(const std::vector<double>& parameters) const {
        SceneSettings scene = scene_;
        scene.hydrodynamics.density = parameters[3];
        std::copy_n(parameters.begin() + 4, 4, scene.hydrodynamics.drag.begin());
        std::copy_n(parameters.begin() + 8, 4, scene.hydrodynamics.thrust.begin());
        return scene;
    }

    SceneSettings of_material(const Inputs& in, WithRespectTo changed) const {
        SceneSettings scene = scene_;
        if (changed == WithRespectTo::lame) {
            const double mu = in.lame[0], lambda = in.lame[1];
            scene.young_modulus = mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu);
            scene.poisson_ratio = 0.5 * lambda / (lambda + mu);
            return scene;
        }
        auto young = std::make_shared<std::vector<double>>(in.young),
             muscle = std::make_shared<std::vector<double>>(in.muscle);
        for (double& e : *young) e += in.material[0];
        for (double& w : *muscle) w += in.material[1];
        scene.young_of_cell = young, scene.muscle_of_cell = muscle;
        scene.poisson_ratio = in.material[2], scene.density = in.material[3];
        return scene;
    }

    static std::vector<Vec3> rows(const std::vector<double>& values) {
        std::vector<Vec3> out(values.size() / 3);
        for (std::size_t i = 0; i < values.size(); ++i) out[i / 3][i % 3] = values[i];
        return out;
    }

    // A nodal field on the nodes of another design, which may have a few more or fewer at the edge of its active set:
    // `fresh` holds the values of those that are new.
    static std::vector<double> carried(const std::vector<double>& field, const ActiveSet& from, const Design& design,
                                       std::vector<double> fresh) {
        const ActiveSet& to = design.set();
        for (std::size_t n = 0; n < to.node_ijk.size(); ++n) {
            const auto& ijk = to.node_ijk[n];
            const int old = from.node_to_active[static_cast<std::size_t>(from.box.node(ijk[0], ijk[1], ijk[2]))];
            if (old < 0) continue;
            for (std::size_t k = 0; k < 3; ++k) fresh[3 * n + k] = field[3 * static_cast<std::size_t>(old) + k];
        }
        return fresh;
    }

    void set_state(Simulation& simulation, const Inputs& in) const {
        const Design& design = simulation.design();
        const std::vector<double> q = carried(in.q, design_->set(), design, design.rest());
        const std::vector<double> v = carried(in.v, design_->set(), design, std::vector<double>(q.size(), 0.0));
        simulation.restore({q, v, {}, {}}, first_step_);
    }

    std::vector<ObjectiveTerm> terms_;
    int n_steps_;
    long first_step_;
    std::shared_ptr<const Design> origin_, design_;
    std::shared_ptr<const WaterCurrent> source_;
    SceneSettings scene_;
    std::unique_ptr<Controller> controller_;
    Inputs base_;
};

// Random direction in the simplex's plane; components at the edge point inwards.
std::vector<double> simplex_direction(const std::vector<double>& weights, Random& random, bool* one_sided) {
    std::vector<double> d(weights.size(), 0.0);
    double sum = 0.0, interior = 0.0;
    *one_sided = false;
    for (std::size_t i = 0; i < d.size(); ++i) {
        d[i] = random();
        if (weights[i] < 0.03)
            d[i] = std::fabs(d[i]) + 0.1, *one_sided = true;
        else
            interior += weights[i];
        sum += d[i];
    }
    for (std::size_t i = 0; i < d.size(); ++i)  // the interior components balance the sum
        if (!(weights[i] < 0.03)) d[i] -= sum * weights[i] / interior;
    double norm = 0.0;
    for (const double x : d) norm += x * x;
    for (double& x : d) x /= std::sqrt(norm);
    return d;
}

}  // namespace

std::vector<double> material_vector(const MaterialBar& bar) {
    return {std::accumulate(bar.young.begin(), bar.young.end(), 0.0),
            std::accumulate(bar.muscle.begin(), bar.muscle.end(), 0.0), bar.poisson, bar.density};
}

GradientCheckReport check_gradient(const Simulation& simulation, const Controller* controller,
                                   const std::vector<ObjectiveTerm>& terms, const GradientCheckSettings& settings) {
    const WithRespectTo quantity = settings.quantity;
    if (quantity == WithRespectTo::control && !controller)
        fail(Status::ERROR_ARGUMENT, "controller is NULL, expected one: with_respect_to is CONTROL");
    if (quantity == WithRespectTo::weights && simulation.design().space().bases().size() < 2)
        fail(Status::ERROR_ARGUMENT, "with_respect_to is WEIGHTS: expected at least two bases, the space has one");
    if (quantity == WithRespectTo::lame && simulation.design().scene().young_of_cell)
        fail(Status::ERROR_ARGUMENT, "with_respect_to is LAME: expected one Young's modulus for all cells");
    if (quantity == WithRespectTo::current_table && simulation.current()->rows().empty())
        fail(Status::ERROR_ARGUMENT,
             "with_respect_to is CURRENT_TABLE: expected a current from a table, not a callback");
    const Rollout rollout(simulation, controller, terms, settings.n_steps);
    Inputs direction = rollout.base();
    std::vector<double> Inputs::*field = nullptr;
    double first_step = settings.step;
    Random random{settings.seed};
    GradientCheckReport report;
    const double dx = simulation.design().space().box().dx;
    switch (quantity) {
        case WithRespectTo::weights:
            field = &Inputs::weights;
            direction.weights = simplex_direction(rollout.base().weights, random, &report.one_sided);
            if (!(first_step > 0)) first_step = 4e-3;
            break;
        case WithRespectTo::control:
            field = &Inputs::theta;
            for (double& x : direction.theta) x = random() * std::max(1.0, std::fabs(x));
            if (!(first_step > 0)) first_step = 2e-2;
            break;
        case WithRespectTo::actuation:
            field = &Inputs::actuation;
            for (double& x : direction.actuation) x = random();
            if (!(first_step > 0)) first_step = 2e-2;
            break;
        case WithRespectTo::initial_position:
            field = &Inputs::q;
            for (double& x : direction.q) x = random() * dx;
            if (!(first_step > 0)) first_step = 2e-2;
            break;
        case WithRespectTo::initial_velocity:
            field = &Inputs::v;
            for (double& x : direction.v) x = random();
            if (!(first_step > 0)) first_step = 4e-3;
            break;
        case WithRespectTo::water:
            field = &Inputs::water;
            for (double& x : direction.water) x = random() * std::max(1.0, std::fabs(x));
            if (!(first_step > 0)) first_step = 4e-3;
            break;
        case WithRespectTo::current:
        case WithRespectTo::current_table:
            field = quantity == WithRespectTo::current ? &Inputs::current : &Inputs::current_table;
            for (double& x : direction.*field) x = random();
            if (!(first_step > 0)) first_step = 4e-3;
            break;
        case WithRespectTo::young_modulus:
        case WithRespectTo::muscle_stiffness:
            field = quantity == WithRespectTo::young_modulus ? &Inputs::young : &Inputs::muscle;
            for (double& x : direction.*field) x *= random();
            if (!(first_step > 0)) first_step = 5e-3;
            break;
        case WithRespectTo::material:
            field = &Inputs::material;
            direction.material = {random() * rollout.base().young[0], random() * rollout.base().muscle[0],
                                  0.1 * random(), random() * rollout.base().material[3]};
            if (!(first_step > 0)) first_step = 1e-2;
            break;
        case WithRespectTo::lame:
            field = &Inputs::lame;
            for (double& x : direction.lame) x *= random();
            if (!(first_step > 0)) first_step = 1e-2;
            break;
    }
    // In two dimensions there is no motion along z.
    if (simulation.design().set().box.dims == 2) direction.water[2] = 0.0;
    if (simulation.design().set().box.dims == 2 &&
        (quantity == WithRespectTo::initial_position || quantity == WithRespectTo::initial_velocity ||
         quantity == WithRespectTo::current || quantity == WithRespectTo::current_table))
        for (std::size_t i = 2; i < (direction.*field).size(); i += 3) (direction.*field)[i] = 0.0;
    // Stay on the simplex over the whole stencil.
    if (quantity == WithRespectTo::weights)
        for (std::size_t i = 0; i < direction.weights.size(); ++i) {
            const double w = rollout.base().weights[i], d = direction.weights[i];
            const double room = report.one_sided ? (d < 0 ? w / -d / 4.0 : first_step) : w / std::fabs(d) / 2.0;
            first_step = std::min(first_step, room);
        }

    const auto tape = rollout.run(rollout.base(), quantity);
    const double loss = tape->objective(terms, nullptr);
    Adjoint adjoint(tape);
    adjoint.seed_objective(terms);
    adjoint.backward(0, nullptr);
    std::vector<double> gradient;
    switch (quantity) {
        case WithRespectTo::weights:
            gradient = adjoint.weights_bar();
            break;
        case WithRespectTo::control:
            gradient = adjoint.control_bar();
            break;
        case WithRespectTo::actuation:
            gradient = adjoint.actuation_bar();
            break;
        case WithRespectTo::initial_position:
            gradient = adjoint.position_bar();
            break;
        case WithRespectTo::initial_velocity:
            gradient = adjoint.velocity_bar();
            break;
        case WithRespectTo::water:
            gradient = adjoint.water_bar();
            break;
        case WithRespectTo::current:
            for (const Vec3& bar : adjoint.current_bar()) gradient.insert(gradient.end(), bar.begin(), bar.end());
            break;
        case WithRespectTo::current_table: {
            std::vector<Vec3> table_bar(rollout.current_source().rows().size());
            const std::vector<Vec3> bar = adjoint.current_bar();
            for (int k = 0; k < settings.n_steps; ++k)
                rollout.current_source().table_pullback(rollout.time(k), bar[static_cast<std::size_t>(k)], table_bar);
            for (const Vec3& row : table_bar) gradient.insert(gradient.end(), row.begin(), row.end());
            break;
        }
        case WithRespectTo::young_modulus:
            gradient = adjoint.material_bar().young;
            break;
        case WithRespectTo::muscle_stiffness:
            gradient = adjoint.material_bar().muscle;
            break;
        case WithRespectTo::material:
            gradient = material_vector(adjoint.material_bar());
            break;
        case WithRespectTo::lame:
            gradient = {adjoint.material_bar().lame_mu, adjoint.material_bar().lame_lambda};
            break;
    }
    const std::vector<double>& d = direction.*field;
    for (std::size_t i = 0; i < gradient.size(); ++i) {
        report.adjoint += gradient[i] * d[i];
        report.gradient_norm += gradient[i] * gradient[i];
    }
    report.gradient_norm = std::sqrt(report.gradient_norm);

    const auto at = [&](double e) {
        Inputs in = rollout.base();
        double sum = 0.0;
        for (std::size_t i = 0; i < d.size(); ++i) sum += ((in.*field)[i] += e * d[i]);
        if (quantity == WithRespectTo::weights)  // rounding of the sum, and of a weight that reaches 0
            for (double& w : in.weights) w = std::max(0.0, w) / sum;
        return rollout.loss(in, quantity);
    };
    // Ridders' tableau (1982): row k holds the five-point difference of step k and its extrapolations with the rows
    // before, which cancel one order of the truncation error each. The entry that its neighbours confirm best is taken,
    // without a look at the adjoint: large steps would be truncated, small ones drown in the rounding of the loss.
    double tableau[kLevels][kLevels], remainder[kLevels], step[kLevels];
    double agreement = std::numeric_limits<double>::infinity();
    int levels = 0;
    while (levels < (quantity == WithRespectTo::weights ? kShapeLevels : kLevels)) {
        const int k = levels++;
        const double e = step[k] = first_step * std::pow(kRatio, k);
        const double f1 = at(e), f2 = at(2 * e);
        if (report.one_sided)
            tableau[k][0] = (-25.0 * loss + 48.0 * f1 - 36.0 * f2 + 16.0 * at(3 * e) - 3.0 * at(4 * e)) / (12.0 * e);
        else
            tableau[k][0] = (8.0 * (f1 - at(-e)) - (f2 - at(-2 * e))) / (12.0 * e);
        if (k == 0) report.finite_difference = tableau[0][0], report.step = e;
        for (int j = 1; j <= k; ++j) {
            const int order = report.one_sided ? 3 + j : 2 + 2 * j;
            const double gain = std::pow(kRatio, -order);
            tableau[k][j] = (gain * tableau[k][j - 1] - tableau[k - 1][j - 1]) / (gain - 1.0);
            const double spread = std::max(std::fabs(tableau[k][j] - tableau[k][j - 1]),
                                           std::fabs(tableau[k][j] - tableau[k - 1][j - 1]));
            if (spread < agreement) agreement = spread, report.finite_difference = tableau[k][j], report.step = e;
        }
        remainder[k] = std::fabs(f1 - loss - e * report.adjoint);
        if (agreement <= kAgreement * std::fabs(report.finite_difference)) break;
    }
    const double error = std::fabs(report.adjoint - report.finite_difference);
    report.relative_error = error == 0.0 ? 0.0 : error / std::fabs(report.finite_difference);
    // Slope of the remainder between the smallest steps at which it stands well above the rounding of the loss; smaller
    // steps are added until it settles.
    const double rounding = 2e-14 * (std::fabs(loss) + std::fabs(report.adjoint) * step[0]) + 1e-17;
    report.taylor_slope = std::numeric_limits<double>::quiet_NaN();
    for (int k = 1; k < kLevels; ++k) {
        if (k >= levels) {
            step[k] = first_step * std::pow(kRatio, k);
            remainder[k] = std::fabs(at(step[k]) - loss - step[k] * report.adjoint);
        }
        if (!(remainder[k] > 1e3 * rounding)) break;
        const double before = report.taylor_slope;
        report.taylor_slope = std::log(remainder[k - 1] / remainder[k]) / std::log(1.0 / kRatio);
        if (k + 1 >= levels && std::fabs(report.taylor_slope - before) <= kSettled) break;
    }
    return report;
}

}  // namespace dqa
