// SPDX-License-Identifier: MIT
#include "motion/stepper.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "grid/error.hpp"
#include "linalg/lbfgs.hpp"

namespace dqa {
namespace {

constexpr int kCellsPerThread = 256;  // with fewer, threads wait longer for each other than they help
constexpr std::size_t kHistory = 20;  // pairs of the quasi-Newton method
constexpr double kShort = 0.1;        // of Newton's step: less of it is a short step,
constexpr int kShortSteps = 3;        // and this many say that the energy's valley is curved
constexpr double kReach = 10.0;       // tolerances: what a linear solve leaves of them may make it the last one
constexpr double kLoose = 0.3;        // tolerances: a step that ends above takes a further iteration
constexpr double kLast = 0.03;        // tolerances that the last one leaves: gradients lose a thousandfold of them
constexpr double kOuter = 1e4;        // tolerances of inertia and water that a residual may be

// Largest distance along an axis from the first node, or one that is larger than `enough`.
double extent_of(const std::vector<double>& q, double enough) {
    double extent = 0.0;
    for (std::size_t i = 0; i < q.size() && !(extent > enough); ++i)
        extent = std::max(extent, std::fabs(q[i] - q[i % 3]));
    return extent;
}

RigidBalance::Free free_motions(const Design& design) {
    const SceneSettings& scene = design.scene();
    const bool planar = scene.planar || design.space().box().dims == 2;
    const std::size_t plane = planar ? static_cast<std::size_t>(design.n_nodes()) : 0;
    if (design.constrained().size() > plane) return RigidBalance::Free::none;  // nodes are fixed
    return planar ? RigidBalance::Free::plane : RigidBalance::Free::space;
}

}  // namespace

Stepper::Stepper(std::shared_ptr<const Design> design)
    : design_(std::move(design)),
      scene_(design_->scene()),
      free_(free_motions(*design_)),
      piece_(pieces_of(design_->set(), design_->occupancy())),
      crew_(std::clamp(design_->set().n_cells() / kCellsPerThread, 1, scene_.threads)),
      size_(3 * static_cast<std::size_t>(design_->n_nodes())),
      extent_(extent_of(design_->rest(), std::numeric_limits<double>::infinity())),
      energy_rounding_(std::numeric_limits<double>::epsilon() * design_->body().cancelling()),
      kernels_(step_kernels(scene_.instructions)) {
    for (auto* v :
         {&y_, &base_, &gradient_, &direction_, &trial_, &lambda_, &start_, &lag_q_, &lag_v_, &candidate_, &right_})
        v->assign(size_, 0.0);
    if (!design_->constrained().empty()) free_coordinate_.assign(size_, 1.0);
    for (const int i : design_->constrained()) free_coordinate_[static_cast<std::size_t>(i)] = 0.0;
    // Along the body, so that each thread finds in its cache what other loops left there for it.
    const Body& body = design_->body();
    const Water* water = design_->water();
    const int of_body = body.n_chunks();
    std::vector<std::pair<int, int>> at;
    for (int k = 0; k < of_body; ++k) at.emplace_back(body.chunk_node(k), k);
    for (int k = 0; water && k < water->n_chunks(); ++k) at.emplace_back(water->chunk_node(k), of_body + k);
    std::sort(at.begin(), at.end());
    for (const auto& chunk : at) element_order_.push_back(chunk.second);
    // Within a thread's share the dear ones first (tissue, then muscles, then faces): the cheap ones even out the end.
    const int count = static_cast<int>(element_order_.size());
    for (int k = 0; k < crew_; ++k)
        std::sort(element_order_.begin() + share_begin(k, crew_, count),
                  element_order_.begin() + share_begin(k + 1, crew_, count));
}

void Stepper::begin(const State& now, const StepInput& input) {
    two_step_ = scene_.integrator == Integrator::bdf2 && !now.q_before.empty();
    beta_ = two_step_ ? 2.0 / 3.0 * scene_.time_step : scene_.time_step;
    on_coordinates([&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            base_[i] = lag_q_[i] = now.q[i];
            double velocity = lag_v_[i] = now.v[i];
            if (two_step_) {
                base_[i] = (4.0 * now.q[i] - now.q_before[i]) / 3.0;
                velocity = (4.0 * now.v[i] - now.v_before[i]) / 3.0;
                lag_q_[i] = 2.0 * now.q[i] - now.q_before[i];
                lag_v_[i] = 2.0 * now.v[i] - now.v_before[i];
            }
            y_[i] = base_[i] + beta_ * velocity;
        }
    });
    noise_ = rounding_of(now.q.data());
    if (const Water* water = design_->water())
        water->lag(water_, lag_q_.data(), lag_v_.data(), design_->sensors().direction(lag_q_.data()), input.current,
                   threads_);
}

Stepper::Evaluation Stepper::evaluate(const double* q_new, const double* signals) {
    const Body& body = design_->body();
    const Water* water = design_->water();
    body.prepare(body_);
    on_elements([&](int k) { body.gradient_chunk(body_, q_new, signals, k); },
                [&](int k) { water->gradient_chunk(water_, q_new, base_.data(), beta_, k); });
    std::vector<NodeTerm<double>>& forces = forces_.exact;
    forces.clear();
    body.list_forces(body_, forces);
    if (water) water->list_forces(water_, forces);
    const ForceGroups groups = {body.n_elastic_terms(), body.n_terms(), static_cast<int>(forces.size())};
    const double inv_b2 = 1.0 / (beta_ * beta_);
    const ForceSums sums = parallel_total<ForceSums>(threads_, design_->n_nodes(), kNodeGrain, [&](int begin, int end) {
        ForceSums of_chunk;
        kernels_.balance(forces.data(), groups, design_->mass().data(), inv_b2, q_new, y_.data(), free_or_null(), begin,
                         end, gradient_.data(), of_chunk);
        return of_chunk;
    });
    Evaluation e;
    e.energy = body.energy(body_) + (water ? water->energy(water_) : 0.0) + sums.energy;
    e.outer = std::sqrt(sums.inertia2) + std::sqrt(sums.water2);
    e.scale = std::sqrt(sums.elastic2) + std::sqrt(sums.muscle2) + e.outer;
    e.residual = std::sqrt(sums.total2);
    e.finite = std::isfinite(e.residual) && std::isfinite(e.energy);
    return e;
}

int Stepper::worst_cell() const {
    std::size_t worst = 0;
    double largest = -1.0;
    for (std::size_t n = 0; n < size_ / 3; ++n) {
        const double r = ordered_norm(gradient_.data() + 3 * n, 3);
        if (r > largest) largest = r, worst = n;
    }
    const auto& set = design_->set();
    return set.cells[static_cast<std::size_t>(set.node_cells[static_cast<std::size_t>(set.node_cell_start[worst])])];
}

void Stepper::fail_step(Status status, long step, const std::string& why, const Evaluation& at) const {
    const double scale = at.scale > 0 ? at.scale : 1.0;
    fail(status,
         "step %ld: %s; relative force residual %.3g (%.3g wanted), worst at cell %d; a smaller time_step helps", step,
         why.c_str(), at.residual / scale, target(at) / scale, worst_cell());
}

StepReport Stepper::step(const State& now, const StepInput& input, long step, State& next) {
    StepReport report;
    with_crew(crew_, [&](Threads threads) {
        threads_ = threads;
        report = solve(now, input, step, next);
    });
    return report;
}

StepReport Stepper::solve(const State& before, const StepInput& input, long step, State& next_state) {
    StepReport report;
    check_unfolds(before, step);
    begin(before, input);
    design_->preconditioner().turn(before.q.data(), threads_, preconditioner_);
    std::vector<double> x(y_);
    for (const int i : design_->constrained()) x[static_cast<std::size_t>(i)] = before.q[static_cast<std::size_t>(i)];
    // From where inertia would carry the body, or from where it is: strong muscles stop what inertia extrapolates.
    const Evaluation there = evaluate(before.q.data(), input.signals);
    Evaluation now = evaluate(x.data(), input.signals);
    if (there.finite && !(now.finite && now.energy <= there.energy)) {
        x = before.q;
        now = evaluate(x.data(), input.signals);
    }
    if (!now.finite) fail_step(Status::DIVERGED, step, "the state is not finite", now);
    const char* why = scene_.method == Method::projective ? descend_quasi_newton(x, now, input.signals, step, report)
                                                          : descend_newton(x, now, input.signals, step, report);
    if (why && !settled(x, now, input.signals)) rescue(before, x, now, input.signals, step, why, report);
    locate(before.q, x, now, input.signals, step, report);
    check_explicit_water(x, now, input, step);
    // Where the forces themselves are at the rounding of the positions, that is what the residual is compared with.
    const double scale = std::max(now.scale, kNoise * noise_ / scene_.tolerance);
    report.residual = scale > 0 ? now.residual / scale : 0.0;
    report.inverted = body_.inverted;
    next_state.v.resize(size_);
    on_coordinates([&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) next_state.v[i] = (x[i] - base_[i]) / beta_;
    });
    for (const int i : design_->constrained()) next_state.v[static_cast<std::size_t>(i)] = 0.0;
    next_state.q.swap(x);
    if (scene_.integrator == Integrator::bdf2) next_state.q_before = before.q, next_state.v_before = before.v;
    return report;
}

// A body that lies in one point: every rotation of its cells is as good as any other, and by symmetry a solver would
// end on a saddle, where all forces balance and which nothing in a residual tells from an equilibrium.
void Stepper::check_unfolds(const State& before, long step) const {
    const double extent = extent_of(before.q, 1e-6 * extent_);
    if (!(extent > 1e-6 * extent_))
        fail(Status::DIVERGED,
             "step %ld: all nodes lie within %.3g m, expected more than 1e-6 of the body's %.3g m: a body that is one "
             "point cannot tell how to unfold",
             step, extent, extent_);
}

// A force -c v that is kept for a whole step of length h turns a mass m round once h c > m, and feeds the motion that
// it should damp: with h c = g m it does the work (g - 1) g m v^2. From g = 2 on, four times the kinetic energy that
// there was, the motion grows from step to step, and what follows is no longer that of a swimmer.
void Stepper::check_explicit_water(const std::vector<double>& x, const Evaluation& now, const StepInput& input,
                                   long step) const {
    const Water* water = design_->water();
    if (!water || !scene_.hydrodynamics.explicit_forces) return;
    double kinetic = 0.0;  // relative to the water, at the start
    for (std::size_t i = 0; i < size_; ++i) {
        const double v = lag_v_[i] - input.current[i % 3];
        kinetic += 0.5 * design_->mass()[i / 3] * v * v;
    }
    const double fed = -beta_ * water->dissipation(water_, x.data(), base_.data(), beta_);
    if (fed > 4.0 * kinetic)
        fail_step(Status::DIVERGED, step, "explicit water forces drive the motion that they should damp", now);
}

// In a stiff body the forces of tissue and muscles are far larger than what is left of them to move it: then that is
// what a residual is small against, of a state and of an adjoint. Otherwise the gradient, whose parts cancel in the
// same way, would come out wrong at a state that looks right.
double Stepper::share_of_motion(const Evaluation& now) {
    return now.scale > 0 ? std::min(1.0, kOuter * now.outer / now.scale) : 1.0;
}

// The residual to reach, with a tolerance of so many of the scene's.
double Stepper::target(const Evaluation& now, double tolerances) const {
    return std::max(tolerances * scene_.tolerance * share_of_motion(now) * now.scale, noise_);
}

bool Stepper::converged(const Evaluation& now) const {
    return now.residual <= target(now);
}

// A step that fell under the target by luck, from an iteration not meant to be the last one, may stop just below it;
// gradients lose a thousandfold of what is left.
bool Stepper::loose(const Evaluation& now) const {
    return now.residual > target(now, kLoose);
}

// How exactly a linear system is solved: as far as this iteration can use, and the last one to well below the target.
// A step that only just reaches it would carry the whole tolerance into the gradient, for two iterations less.
double Stepper::forcing(const Evaluation& now) const {
    if (!loose(now)) return 0.01;  // it is the body as a whole that is not in balance
    const double enough = target(now);
    const double usual = std::min(0.1, std::sqrt(now.residual / now.scale));
    return usual * now.residual <= kReach * enough ? kLast * enough / now.residual : usual;
}

void Stepper::check_limits(long step, const Evaluation& now, const StepReport& report) const {
    if (scene_.cancel && scene_.cancel->load()) fail(Status::CANCELLED, "cancelled in step %ld", step);
    if (report.linear_iterations >= scene_.max_products)
        fail_step(Status::NOT_CONVERGED, step,
                  format("it has taken %d products with the Hessian, and max_products is %lld",
                         report.linear_iterations, static_cast<long long>(scene_.max_products)),
                  now);
}

// Changes of the energy below this are rounding: its own, that of parts which cancel in it, and that of positions,
// which carry one that the forces turn into energy; close to rest these outweigh the first.
double Stepper::energy_noise(const std::vector<double>& x, const Evaluation& now) const {
    return 1e-13 * std::fabs(now.energy) + energy_rounding_ +
           1e-15 * now.scale * ordered_norm(x.data(), size_, threads_);
}

// Along direction_, as path_along says, with halved lengths until the energy falls enough (Armijo). On success x and
// now are the new point; otherwise they are evaluated anew where they were.
double Stepper::line_search(std::vector<double>& x, Evaluation& now, const double* signals) {
    const double slope = dot(gradient_.data(), direction_.data());
    // Near the solution the energy's change drowns in its rounding; there the residual decides.
    const double noise = energy_noise(x, now) + 1e-13 * std::fabs(slope);
    candidate_.resize(size_);
    const Path path = path_along(x);
    double t = 1.0;
    for (int k = 0; k < 30 && slope < 0; ++k, t *= 0.5) {
        move_along(path, x, t);
        const Evaluation next = evaluate(candidate_.data(), signals);
        if (!next.finite) continue;
        if (next.energy <= now.energy + 1e-4 * t * slope ||
            (next.energy <= now.energy + noise && next.residual < now.residual)) {
            x.swap(candidate_);
            now = next;
            return t;
        }
    }
    now = evaluate(x.data(), signals);
    return 0.0;
}

const char* Stepper::descend_newton(std::vector<double>& x, Evaluation& now, const double* signals, long step,
                                    StepReport& report) {
    bool force_filter = false;
    int short_steps = 0;
    double previous = std::numeric_limits<double>::infinity();
    while (!settled(x, now, signals)) {
        // At the rounding of the positions, where Newton's steps no longer help, the answer is as exact as it can be.
        if (now.residual <= kNoise * noise_ && now.residual > 0.25 * previous) break;
        previous = now.residual;
        check_limits(step, now, report);
        if (report.newton_iterations >= scene_.max_newton) return "Newton's method reached max_newton";
        ++report.newton_iterations;
        const double enough = forcing(now);
        const bool found = !force_filter && newton_direction(enough, report);
        const bool filtered = !found;
        if (filtered) {
            design_->body().filter(body_);
            ++report.filtered;
            if (!newton_direction(enough, report)) return "no descent direction was found";
        }
        const double share = line_search(x, now, signals);
        if (share > 0) {
            if (share < kShort && ++short_steps == kShortSteps) return "the line search takes short steps";
            force_filter = false;
            continue;
        }
        if (now.residual <= kNoise * noise_) break;
        if (filtered) return "the line search is exhausted";
        force_filter = true;  // once more from here with the filtered Hessian
    }
    return nullptr;
}

// L-BFGS on the projective-dynamics matrix (Liu et al. 2017), the paper's solver; the history starts anew at each step,
// so that a step is a function of its state alone.
const char* Stepper::descend_quasi_newton(std::vector<double>& x, Evaluation& now, const double* signals, long step,
                                          StepReport& report) {
    Lbfgs history(kHistory);
    const auto initial = [&](const double* in, double* out) { precondition(in, out); };
    while (!settled(x, now, signals)) {
        check_limits(step, now, report);
        if (report.newton_iterations >= scene_.max_linear) return "the quasi-Newton method reached max_linear";
        ++report.newton_iterations, ++report.linear_iterations;
        history.direction(gradient_.data(), initial, direction_);
        std::vector<double> move(x), change(gradient_);
        if (line_search(x, now, signals) > 0) {
            for (std::size_t i = 0; i < size_; ++i) move[i] = x[i] - move[i], change[i] = gradient_[i] - change[i];
            history.remember(move, change);
            continue;
        }
        if (now.residual <= kNoise * noise_) break;
        if (history.empty()) return "the line search is exhausted";
        history.clear();
    }
    return nullptr;
}

}  // namespace dqa
