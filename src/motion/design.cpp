// SPDX-License-Identifier: MIT
#include "motion/design.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "grid/error.hpp"
#include "linalg/nested_dissection.hpp"

namespace dqa {
namespace {

constexpr double kSingle = 1e-2;  // of inertia: what single precision may lose of the stiffness

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Scalar Laplacian of a unit Q1 cube, integral of grad N_a . grad N_b, times dx afterwards; and its part along x.
// Separable: 1-D stiffness (+-1) and mass (1/3, 1/6).
double cube_laplacian(int a, int b, int axis) {
    double value = 1.0;
    for (int k = 0; k < 3; ++k) {
        const bool same = ((a >> (2 - k)) & 1) == ((b >> (2 - k)) & 1);
        value *= k == axis ? (same ? 1.0 : -1.0) : (same ? 1.0 / 3.0 : 1.0 / 6.0);
    }
    return value;
}

}  // namespace

Design::Design(std::shared_ptr<const ShapeSpace> space, const std::vector<double>& weights, const SceneSettings& scene,
               const std::function<void(int, double)>& monitor)
    : space_(std::move(space)), scene_(scene), occupancy_law_(scene.threshold, scene.occupancy_floor) {
    const auto start = std::chrono::steady_clock::now();
    point_ = space_->evaluate(weights, scene.shape_tolerance, scene.threads, monitor);
    barycenter_seconds_ = seconds_since(start);
    assemble();
}

Design::Design(const Design& other, const SceneSettings& scene)
    : space_(other.space_),
      scene_(scene),
      point_(other.point_),
      occupancy_law_(scene.threshold, scene.occupancy_floor),
      barycenter_seconds_(other.barycenter_seconds_) {
    assemble();
}

// Everything that follows from the shape and the scene.
void Design::assemble() {
    const Box& box = space_->box();
    const SceneSettings& scene = scene_;
    std::vector<char> mask(point_.p_hat.size());
    for (std::size_t c = 0; c < mask.size(); ++c) mask[c] = occupancy_law_.active(point_.p_hat[c]);
    set_ = make_active_set(box, mask);
    if (set_.n_cells() == 0)
        fail(Status::ERROR_ARGUMENT, "threshold is %g: no cell is left to simulate", scene.threshold);
    rest_ = set_.rest_positions();
    const double node_mass = scene.density * box.dx * box.dx * box.dx / 8.0;
    std::vector<double> muscle_stiffness;
    Elasticity elasticity;
    elasticity.material = scene.material, elasticity.quadrature = scene.quadrature;
    mass_.assign(static_cast<std::size_t>(n_nodes()), 0.0);
    for (int a = 0; a < set_.n_cells(); ++a) {
        const int cell = set_.cells[static_cast<std::size_t>(a)];
        const double g = occupancy_law_.value(point_.p_hat[static_cast<std::size_t>(cell)]);
        occupancy_.push_back(g);
        elasticity.mu.push_back(scene.unit_mu() * scene.young(cell) * g);
        elasticity.lambda.push_back(scene.unit_lambda() * scene.young(cell) * g);
        muscle_stiffness.push_back(scene.muscle(cell));
        for (const int n : set_.cell_nodes[static_cast<std::size_t>(a)])
            mass_[static_cast<std::size_t>(n)] += node_mass * g;
    }
    muscles_ = Muscles(*space_, point_, set_, occupancy_, muscle_stiffness);
    body_ = std::make_unique<Body>(set_, elasticity, muscles_.entries(), scene.contraction, scene.instructions);
    if (scene.water) water_ = std::make_unique<Water>(set_, occupancy_, scene.hydrodynamics, scene.instructions);
    sensors_ = Sensors(set_, point_.p_hat, space_->axis_y(), space_->axis_z());
    make_spine();
    make_constraints();
    make_diagonal();
    choose_precision();
    make_preconditioner();
    surface_ = box.dims == 2 ? extract_contour(box, point_.p_hat.data(), 0.5)
                             : extract_isosurface(box, point_.p_hat.data(), 0.5);
    for (const Vec3& x : surface_.vertices) {
        const MaterialPoint p = locate(set_, x, 1, true);
        embedding_.push_back({p.node, p.weight});
    }
}

// Rest occupancy at the nodes of the plane y = 0 (of the two nearest planes, half each, when the box has an odd number
// of cells across): hat function of width dx.
void Design::make_spine() {
    const Box& box = space_->box();
    spine_hat_.assign(static_cast<std::size_t>(n_nodes()), 0.0);
    spine_.assign(static_cast<std::size_t>(n_nodes()), 0.0);
    for (int n = 0; n < n_nodes(); ++n)
        spine_hat_[static_cast<std::size_t>(n)] =
            std::max(0.0, 1.0 - std::fabs(rest_[3 * static_cast<std::size_t>(n) + 1]) / box.dx);
    double sum = 0.0;
    for (int a = 0; a < set_.n_cells(); ++a)
        for (const int n : set_.cell_nodes[static_cast<std::size_t>(a)]) {
            const double w = spine_hat_[static_cast<std::size_t>(n)] * occupancy_[static_cast<std::size_t>(a)] / 8.0;
            spine_[static_cast<std::size_t>(n)] += w;
            sum += w;
        }
    if (!(sum > 0)) fail(Status::ERROR_ARGUMENT, "the design has no spine: no active node near the plane y = 0");
}

void Design::make_constraints() {
    std::vector<char> fixed(static_cast<std::size_t>(n_nodes()), 0);
    for (const int node : scene_.fixed_nodes) {
        const int active = set_.node_to_active[static_cast<std::size_t>(node)];
        if (active >= 0) fixed[static_cast<std::size_t>(active)] = 1;
    }
    for (int n = 0; n < n_nodes(); ++n)
        for (int axis = 0; axis < 3; ++axis)
            if (fixed[static_cast<std::size_t>(n)] || ((scene_.planar || set_.box.dims == 2) && axis == 2))
                constrained_.push_back(3 * n + axis);
}

// Diagonal of the projective-dynamics matrix.
void Design::make_diagonal() {
    const double dx = space_->box().dx;
    const std::vector<Vec3> stiffness = body_->preconditioner_stiffness();
    diagonal_.assign(mass_.size(), 0.0);
    for (std::size_t n = 0; n < mass_.size(); ++n) diagonal_[n] = mass_[n] * scene_.inertia_factor();
    // In two dimensions two corners are one node, whose row then has their coupling on the diagonal, too.
    for (std::size_t c = 0; c < stiffness.size(); ++c)
        for (std::size_t a = 0; a < 8; ++a)
            for (std::size_t b = 0; b < 8; ++b) {
                if (set_.cell_nodes[c][a] != set_.cell_nodes[c][b]) continue;
                double value = 0.0;
                for (int axis = 0; axis < 3; ++axis)
                    value += stiffness[c][static_cast<std::size_t>(axis)] *
                             cube_laplacian(static_cast<int>(a), static_cast<int>(b), axis);
                diagonal_[static_cast<std::size_t>(set_.cell_nodes[c][a])] += value * dx;
            }
}

// In single precision what stiffness loses to rounding must stay below inertia, which alone holds a free body's motion
// as a whole: else iterations come to nothing, in small or stiff bodies and over long steps.
void Design::choose_precision() {
    double whole = 0.0, inertia = 0.0;
    for (std::size_t n = 0; n < mass_.size(); ++n) {
        whole += diagonal_[n];
        inertia += mass_[n] * scene_.inertia_factor();
    }
    if (std::numeric_limits<float>::epsilon() * whole > kSingle * inertia)
        scene_.precision = Precision::double_precision;
}

// Projective-dynamics matrix (Bouaziz et al. 2014): M/b^2 + sum of weights G^T G, one scalar matrix for all three
// directions, with the stiffness that the body's terms ask for.
std::unique_ptr<PackedFactor> Design::make_factor() const {
    const double dx = space_->box().dx;
    const int n = n_nodes();
    const std::vector<Vec3> stiffness = body_->preconditioner_stiffness();
    // Lower triangle by columns on the 27-point stencil: slot of each neighbour offset with a larger node index.
    std::vector<std::vector<std::pair<int, double>>> columns(static_cast<std::size_t>(n));
    double local[3][8][8];
    for (int axis = 0; axis < 3; ++axis)
        for (int a = 0; a < 8; ++a)
            for (int b = 0; b < 8; ++b) local[axis][a][b] = cube_laplacian(a, b, axis) * dx;
    for (int c = 0; c < set_.n_cells(); ++c) {
        const Vec3& w = stiffness[static_cast<std::size_t>(c)];
        const auto& nodes = set_.cell_nodes[static_cast<std::size_t>(c)];
        for (std::size_t a = 0; a < 8; ++a)
            for (std::size_t b = 0; b < 8; ++b) {
                const int row = nodes[a], column = nodes[b];
                if (row <= column) continue;
                const double value = w[0] * local[0][a][b] + w[1] * local[1][a][b] + w[2] * local[2][a][b];
                auto& entries = columns[static_cast<std::size_t>(column)];
                const auto at =
                    std::find_if(entries.begin(), entries.end(), [&](const auto& e) { return e.first == row; });
                if (at == entries.end())
                    entries.emplace_back(row, value);
                else
                    at->second += value;
            }
    }
    for (std::size_t j = 0; j < diagonal_.size(); ++j) columns[j].emplace_back(static_cast<int>(j), diagonal_[j]);
    const SymmetricMatrix matrix = matrix_from_columns(columns);
    return std::make_unique<PackedFactor>(factorise(matrix, nested_dissection(set_.node_ijk)), scene_.precision,
                                          scene_.instructions);
}

// Inertia and body at rest, with passive muscles.
void Design::make_preconditioner() {
    const double inv_b2 = scene_.inertia_factor();
    const std::size_t size = rest_.size();
    const bool factor = scene_.preconditioner == PreconditionerKind::factor || scene_.method == Method::projective;
    with_crew(scene_.threads, [&](Threads threads) {
        BodyWorkspace body;
        std::vector<double> elastic(size), muscle(size);
        const std::vector<double> passive(static_cast<std::size_t>(n_signals()), 0.0);
        body_->gradient(body, rest_.data(), passive.data(), threads, elastic.data(), muscle.data());
        const auto apply = [&](const double* p, double* out) {
            for (std::size_t i = 0; i < size; ++i) out[i] = mass_[i / 3] * inv_b2 * p[i];
            body_->product(body, p, threads, out);
            for (const int i : constrained_) out[i] = 0.0;
        };
        preconditioner_ =
            std::make_unique<Preconditioner>(set_, occupancy_, constrained_, apply, factor ? make_factor() : nullptr,
                                             scene_.precision, scene_.instructions);
    });
}

const Isosurface& Design::surface() const {
    return surface_;
}

std::vector<Vec3> Design::carry_surface(const double* q) const {
    std::vector<Vec3> out;
    out.reserve(embedding_.size());
    for (const Embedding& e : embedding_) {
        Vec3 x{};
        for (std::size_t n = 0; n < 8; ++n)
            for (std::size_t k = 0; k < 3; ++k) x[k] += e.weight[n] * q[3 * static_cast<std::size_t>(e.node[n]) + k];
        out.push_back(x);
    }
    return out;
}

int Design::n_body_cells() const {
    return static_cast<int>(std::count_if(point_.p_hat.begin(), point_.p_hat.end(), [](double p) { return p > 0.5; }));
}

int Design::n_muscle_cells() const {
    std::vector<int> cells;
    for (const MuscleEntry& m : muscles_.entries()) cells.push_back(m.cell);
    std::sort(cells.begin(), cells.end());
    return static_cast<int>(std::unique(cells.begin(), cells.end()) - cells.begin());
}

DesignBar Design::zero_bar() const {
    DesignBar bar;
    bar.mu.assign(occupancy_.size(), 0.0);
    bar.lambda = bar.mu;
    bar.occupancy.assign(occupancy_.size(), 0.0);
    bar.mass.assign(mass_.size(), 0.0);
    bar.spine.assign(mass_.size(), 0.0);
    bar.muscle_weight.assign(muscles_.entries().size(), 0.0);
    if (muscles_.fibres_turn()) bar.muscle_direction.assign(muscles_.entries().size(), Vec3{});
    return bar;
}

MaterialBar Design::material_bar(const DesignBar& bar) const {
    MaterialBar out;
    out.young.assign(static_cast<std::size_t>(space_->box().n_cells()), 0.0);
    out.muscle = out.young;
    std::vector<double> muscle(occupancy_.size(), 0.0);
    muscles_.stiffness_pullback(bar.muscle_weight, muscle);
    for (std::size_t a = 0; a < occupancy_.size(); ++a) {
        const std::size_t c = static_cast<std::size_t>(set_.cells[a]);
        const double g = occupancy_[a], mu = g * bar.mu[a], lambda = g * bar.lambda[a];
        out.young[c] = scene_.unit_mu() * mu + scene_.unit_lambda() * lambda;
        out.muscle[c] = muscle[a];
        out.poisson +=
            scene_.young(set_.cells[a]) * (scene_.unit_mu_by_poisson() * mu + scene_.unit_lambda_by_poisson() * lambda);
        out.lame_mu += mu, out.lame_lambda += lambda;
    }
    for (std::size_t n = 0; n < mass_.size(); ++n) out.density += bar.mass[n] * mass_[n] / scene_.density;
    return out;
}

std::vector<double> Design::weights_bar(const DesignBar& bar, const std::function<void(int, double)>& monitor) const {
    const Box& box = space_->box();
    const double node_mass = scene_.density * box.dx * box.dx * box.dx / 8.0;
    std::vector<double> occupancy_bar(bar.occupancy);
    for (std::size_t a = 0; a < occupancy_.size(); ++a) {
        occupancy_bar[a] +=
            scene_.young(set_.cells[a]) * (scene_.unit_mu() * bar.mu[a] + scene_.unit_lambda() * bar.lambda[a]);
        for (const int node : set_.cell_nodes[a]) {
            const std::size_t n = static_cast<std::size_t>(node);
            occupancy_bar[a] += node_mass * bar.mass[n] + spine_hat_[n] / 8.0 * bar.spine[n];
        }
    }
    std::vector<ActuatorBar> actuators_bar(point_.actuators.size());
    muscles_.pullback(*space_, point_, set_, occupancy_, bar.muscle_weight, bar.muscle_direction, occupancy_bar,
                      actuators_bar);
    std::vector<double> p_hat_bar(point_.p_hat.size(), 0.0);
    for (std::size_t a = 0; a < occupancy_.size(); ++a) {
        const std::size_t c = static_cast<std::size_t>(set_.cells[a]);
        p_hat_bar[c] += occupancy_bar[a] * occupancy_law_.derivative(point_.p_hat[c]);
    }
    sensors_.place_pullback(bar.head_x, bar.tail_x, p_hat_bar.data());
    return space_->pullback(point_, p_hat_bar.data(), actuators_bar, scene_.shape_tolerance, scene_.threads, monitor);
}

}  // namespace dqa
