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
constexpr double kLast = 0.03;        // tolerances that the last one leaves: gradients lose a thousandfold of them
constexpr double kOuter = 1e4;        // tolerances of inertia and water that a residual may be

// Largest distance along an axis from the first node, or one that is larger than `enough`.
double extent_of(const std::vector<double>& q, double enough) {
    double extent = 0.0;
    for (std::size_t i = 0; i < q.size() && !(extent > enough); ++i)
        extent = std::max(extent, std::fabs(q[i] - q[i % 3]));
    return extent;
}

// Sums over the nodes of an evaluation.
struct ForceSums {
    double inertia = 0.0;  // energy
    double inertia2 = 0.0, water2 = 0.0, elastic2 = 0.0, muscle2 = 0.0, total2 = 0.0;
    void operator+=(const ForceSums& o) {
        inertia += o.inertia, inertia2 += o.inertia2, water2 += o.water2;
        elastic2 += o.elastic2, muscle2 += o.muscle2, total2 += o.total2;
    }
};

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
      energy_rounding_(std::numeric_limits<double>::epsilon() * design_->body().cancelling()) {
    for (auto* v : {&y_, &base_, &gradient_, &elastic_, &muscle_, &direction_, &trial_, &lambda_, &lag_q_, &lag_v_,
                    &candidate_, &right_})
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
    for (const auto& chunk : at) product_order_.push_back(chunk.second);
    // Within a thread's share the dear ones first (tissue, then muscles, then faces): the cheap ones even out the end.
    const int count = static_cast<int>(product_order_.size());
    for (int k = 0; k < crew_; ++k)
        std::sort(product_order_.begin() + share_begin(k, crew_, count),
                  product_order_.begin() + share_begin(k + 1, crew_, count));
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

template <class T>
double Stepper::rounding_of(const T* x) const {
    const double* diagonal = design_->stiffness_diagonal().data();
    const double square = parallel_sum(threads_, design_->n_nodes(), kNodeGrain, [&](int begin, int end) {
        double sum = 0.0;
        for (std::size_t i = 3 * static_cast<std::size_t>(begin); i < 3 * static_cast<std::size_t>(end); ++i) {
            const double force = diagonal[i / 3] * static_cast<double>(x[i]);
            sum += force * force;
        }
        return sum;
    });
    return 0.25 * static_cast<double>(std::numeric_limits<T>::epsilon()) * std::sqrt(square);
}

template <class T>
void Stepper::mask(T* field) const {
    for (const int i : design_->constrained()) field[i] = T(0);
}

Stepper::Evaluation Stepper::evaluate(const double* q_new, const double* signals) {
    Evaluation e;
    e.energy = design_->body().gradient(body_, q_new, signals, threads_, elastic_.data(), muscle_.data());
    const Water* water = design_->water();
    if (water) e.energy += water->gradient_of_faces(water_, q_new, base_.data(), beta_, threads_);
    const double inv_h2 = 1.0 / (beta_ * beta_);
    const double* mass = design_->mass().data();
    const bool all_free = free_coordinate_.empty();
    const ForceSums sums = parallel_total<ForceSums>(threads_, design_->n_nodes(), kNodeGrain, [&](int begin, int end) {
        ForceSums s;
        const std::size_t first = 3 * static_cast<std::size_t>(begin), last = 3 * static_cast<std::size_t>(end);
        std::fill(trial_.begin() + 3 * begin, trial_.begin() + 3 * end, 0.0);
        if (water) water->add_gradient(water_, begin, end, trial_.data());
        for (std::size_t i = first; i < last; ++i) {
            const double d = q_new[i] - y_[i], f = mass[i / 3] * inv_h2 * d;
            s.inertia += 0.5 * f * d, s.inertia2 += f * f, s.water2 += trial_[i] * trial_[i];
            s.elastic2 += elastic_[i] * elastic_[i], s.muscle2 += muscle_[i] * muscle_[i];
            const double sum = f + trial_[i] + elastic_[i] + muscle_[i];
            gradient_[i] = all_free ? sum : free_coordinate_[i] * sum;
            s.total2 += gradient_[i] * gradient_[i];
        }
        return s;
    });
    e.energy += sums.inertia;
    e.outer = std::sqrt(sums.inertia2) + std::sqrt(sums.water2);
    e.scale = std::sqrt(sums.elastic2) + std::sqrt(sums.muscle2) + e.outer;
    e.residual = std::sqrt(sums.total2);
    e.finite = std::isfinite(e.residual) && std::isfinite(e.energy);
    return e;
}

template <class T>
double Stepper::apply_hessian(const T* p, T* out) {
    if (design_->constrained().empty()) return full_product(p, out);
    std::vector<T>& masked = masked_.in(T());
    masked.resize(size_ + 1);
    std::copy(p, p + size_, masked.begin());
    mask(masked.data());
    double product = full_product(masked.data(), out);
    for (const int i : design_->constrained()) out[i] = p[i], product += static_cast<double>(p[i] * p[i]);
    return product;
}
template double Stepper::apply_hessian(const double*, double*);

void Stepper::precondition(const double* in, double* out) {
    design_->preconditioner().solve(in, out, threads_, preconditioner_);
    mask(out);
}

template <class T>
PcgProducts<T> Stepper::system() {
    // r, p and ap are zero on the constrained coordinates.
    return {[this](const T* p, T* out) { return apply_hessian(p, out); },
            [this](const T* r, double norm, bool descended, const T* ap, T* z) {
                const auto products =
                    design_->preconditioner().solve(r, norm, descended, ap, z, threads_, preconditioner_);
                mask(z);
                return products;
            },
            [this](const T* z, T beta, T* p, T* ap) { return direct(z, beta, p, ap); },
            [this](T step, const T* p, const T* ap, T* x, T* r, double norm) {
                return design_->preconditioner().descend(step, p, ap, x, r, norm, threads_, preconditioner_);
            }};
}

PcgResult Stepper::solve_hessian(const double* b, double* x, double tolerance, bool indefinite) {
    if (!design_->preconditioner().has_single())
        return pcg(size_, b, x, tolerance, scene_.max_linear, system<double>(), threads_, krylov_, indefinite);
    design_->body().to_single(body_, threads_);
    const auto rounding = [this](const float* p) { return rounding_of(p); };
    return mixed_pcg(size_, b, x, tolerance, scene_.max_linear, system<double>(), system<float>(), rounding, threads_,
                     krylov_, indefinite);
}

// Products come in two parallel loops: the forces of cells, fibres and faces, then their sums on the nodes.
template <class T>
void Stepper::element_products(const T* p) {
    const Body& body = design_->body();
    const int of_body = body.n_chunks();
    parallel_chunks(threads_, static_cast<int>(product_order_.size()), 1, [&](int place, int) {
        const int k = product_order_[static_cast<std::size_t>(place)];
        if (k < of_body)
            body.product_chunk(body_, p, k);
        else
            design_->water()->product_chunk(water_, p, beta_, k - of_body);
    });
}

template <class T>
void Stepper::sum_products(const T* p, T kept, int begin, int end, T* out) const {
    const double inv_h2 = 1.0 / (beta_ * beta_);
    const double* mass = design_->mass().data();
    if (kept == T(0)) std::fill(out + 3 * begin, out + 3 * end, T(0));
    for (int n = begin; n < end; ++n) {
        const T inertia = static_cast<T>(mass[n] * inv_h2);
        for (int i = 3 * n; i < 3 * n + 3; ++i) out[i] = kept * out[i] + inertia * p[i];
    }
    design_->body().add_forces(body_, begin, end, out);
    if (const Water* water = design_->water()) water->add_product(water_, begin, end, out);
}

template <class T>
double Stepper::full_product(const T* p, T* out) {
    element_products(p);
    return parallel_sum(threads_, design_->n_nodes(), kNodeGrain, [&](int begin, int end) {
        sum_products(p, T(0), begin, end, out);
        return ordered_dot(p + 3 * begin, out + 3 * begin, 3 * static_cast<std::size_t>(end - begin));
    });
}
template double Stepper::full_product(const double*, double*);

template <class T>
double Stepper::direct(const T* z, T beta, T* p, T* ap) {
    element_products(z);
    const bool all_free = free_coordinate_.empty();
    return parallel_sum(threads_, design_->n_nodes(), kNodeGrain, [&](int begin, int end) {
        const int from = 3 * begin, to = 3 * end;
        sum_products(z, beta, begin, end, ap);
        for (int i = from; !all_free && i < to; ++i)
            ap[i] *= static_cast<T>(free_coordinate_[static_cast<std::size_t>(i)]);
        if (beta == T(0)) std::fill(p + from, p + to, T(0));
        for (int i = from; i < to; ++i) p[i] = z[i] + beta * p[i];
        return ordered_dot(p + from, ap + from, static_cast<std::size_t>(to - from));
    });
}

// The exact Hessian as a matrix, by probing: nodes of equal coordinates modulo 3 are not coupled, so 27 x 3 products
// yield all of it, from the same kernel that the iterative solver uses.
SymmetricMatrix Stepper::assemble() {
    const auto& nodes = design_->set().node_ijk;
    const Box& box = design_->space().box();
    std::vector<std::vector<std::pair<int, double>>> columns(size_);
    std::vector<double> probe(size_), out(size_);
    for (int colour = 0; colour < 27; ++colour) {
        const auto of_colour = [&](const std::array<int, 3>& ijk) {
            return (ijk[0] % 3) * 9 + (ijk[1] % 3) * 3 + ijk[2] % 3 == colour;
        };
        if (std::none_of(nodes.begin(), nodes.end(), of_colour)) continue;
        for (int axis = 0; axis < 3; ++axis) {
            std::fill(probe.begin(), probe.end(), 0.0);
            for (std::size_t n = 0; n < nodes.size(); ++n)
                if (of_colour(nodes[n])) probe[3 * n + static_cast<std::size_t>(axis)] = 1.0;
            apply_hessian(probe.data(), out.data());
            for (std::size_t n = 0; n < nodes.size(); ++n) {
                if (!of_colour(nodes[n])) continue;
                const int column = static_cast<int>(3 * n) + axis;
                for (int o = 0; o < 27; ++o) {
                    const int i = nodes[n][0] + o / 9 - 1, j = nodes[n][1] + o / 3 % 3 - 1, k = nodes[n][2] + o % 3 - 1;
                    if (i < 0 || j < 0 || k < 0 || i > box.cells[0] || j > box.cells[1] || k >= box.node_planes())
                        continue;
                    const int other = design_->set().node_to_active[static_cast<std::size_t>(box.node(i, j, k))];
                    if (other < 0) continue;
                    for (int a = 0; a < 3; ++a) {
                        const int row = 3 * other + a;
                        if (row >= column)
                            columns[static_cast<std::size_t>(column)].emplace_back(row,
                                                                                   out[static_cast<std::size_t>(row)]);
                    }
                }
            }
        }
    }
    return matrix_from_columns(columns);
}

// direction_ <- -H^-1 gradient_. Returns false if no descent direction came of it (negative curvature at once).
bool Stepper::newton_direction(double forcing, StepReport& report) {
    std::vector<double>& b = right_;
    on_coordinates([&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) b[i] = -gradient_[i];
    });
    if (scene_.method == Method::newton_direct) {
        // An indefinite Hessian is shifted, as little as will do: filtering all cells would cost Newton's convergence.
        SymmetricMatrix h = assemble();
        double shifted = 0.0;
        for (const double shift : {0.0, 1e-6, 1e-4, 1e-2}) {
            for (std::size_t j = 0; j < size_; ++j)
                h.value[static_cast<std::size_t>(h.start[j])] +=
                    (shift - shifted) * design_->stiffness_diagonal()[j / 3];
            shifted = shift;
            std::vector<double> x(b);
            if (!solve_positive(h, x)) continue;
            direction_ = x;
            ++report.linear_iterations;
            return true;
        }
        return false;
    }
    const PcgResult r = solve_hessian(b.data(), direction_.data(), forcing, false);
    report.linear_iterations += r.iterations;
    // An iterate before the negative curvature, or at the iteration limit, is still a descent direction.
    return r.iterations > 0 && std::isfinite(r.relative_residual);
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

void Stepper::fail_step(Status status, long step, const char* why, double relative) const {
    fail(status,
         "step %ld: %s; relative force residual %.3g (expected <= %.3g), worst at cell %d; a smaller time_step helps",
         step, why, relative, scene_.tolerance, worst_cell());
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
    if (!now.finite) fail_step(Status::DIVERGED, step, "the state is not finite", now.residual);
    const char* why = scene_.method == Method::projective ? descend_quasi_newton(x, now, input.signals, step, report)
                                                          : descend_newton(x, now, input.signals, step, report);
    if (why) rescue(before, x, now, input.signals, step, why, report);
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
    if (fed > 4.0 * kinetic) {
        const double relative = now.scale > 0 ? now.residual / now.scale : 0.0;
        fail_step(Status::DIVERGED, step, "explicit water forces drive the motion that they should damp", relative);
    }
}

// In a stiff body the forces of tissue and muscles are far larger than what is left of them to move it: then that is
// what a residual is small against, of a state and of an adjoint. Otherwise the gradient, whose parts cancel in the
// same way, would come out wrong at a state that looks right.
double Stepper::share_of_motion(const Evaluation& now) {
    return now.scale > 0 ? std::min(1.0, kOuter * now.outer / now.scale) : 1.0;
}

// The residual to reach.
double Stepper::target(const Evaluation& now) const {
    return std::max(scene_.tolerance * share_of_motion(now) * now.scale, noise_);
}

bool Stepper::converged(const Evaluation& now) const {
    return now.residual <= target(now);
}

// How exactly a linear system is solved: as far as this iteration can use, and the last one to well below the target.
// A step that only just reaches it would carry the whole tolerance into the gradient, for two iterations less.
double Stepper::forcing(const Evaluation& now) const {
    const double enough = target(now);
    if (now.residual <= enough) return 0.01;  // it is the body as a whole that is not in balance
    const double usual = std::min(0.1, std::sqrt(now.residual / now.scale));
    return usual * now.residual <= kReach * enough ? kLast * enough / now.residual : usual;
}

void Stepper::check_cancelled(long step) const {
    if (scene_.cancel && scene_.cancel->load()) fail(Status::CANCELLED, "cancelled in step %ld", step);
}

// Changes of the energy below this are rounding: its own, that of parts which cancel in it, and that of positions,
// which carry one that the forces turn into energy; close to rest these outweigh the first.
double Stepper::energy_noise(const std::vector<double>& x, const Evaluation& now) const {
    return 1e-13 * std::fabs(now.energy) + energy_rounding_ +
           1e-15 * now.scale * ordered_norm(x.data(), size_, threads_);
}

// Along direction_ with halved lengths until the energy falls enough (Armijo). On success x and now are the new point;
// otherwise they are evaluated anew where they were.
double Stepper::line_search(std::vector<double>& x, Evaluation& now, const double* signals) {
    const double slope = dot(gradient_.data(), direction_.data());
    // Near the solution the energy's change drowns in its rounding; there the residual decides.
    const double noise = energy_noise(x, now) + 1e-13 * std::fabs(slope);
    candidate_.resize(size_);
    double t = 1.0;
    for (int k = 0; k < 30 && slope < 0; ++k, t *= 0.5) {
        on_coordinates([&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) candidate_[i] = x[i] + t * direction_[i];
        });
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
        check_cancelled(step);
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
        check_cancelled(step);
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
