// SPDX-License-Identifier: MIT
#include "shape/shape_space.hpp"

#include <algorithm>
#include <cmath>

#include "grid/axis_line.hpp"
#include "grid/error.hpp"
#include "grid/number_text.hpp"
#include "shape/actuator_placement.hpp"
#include "shape/planar_base.hpp"

namespace dqa {
namespace {

constexpr std::size_t kMaxBases = 256;

// Whether the frames of two halves of fins differ, after mirroring one if they are on different sides.
bool turned(const Actuator& a, const Actuator& b) {
    return (a.half == b.half ? a : mirrored(a)).euler != b.euler;
}

std::string title_of(std::size_t number, const std::string& name) {
    return format("base %zu ('%s')", number, name.c_str());
}

// work(), whose errors then begin with what they are about.
template <class F>
void about(const std::string& subject, const F& work) {
    try {
        work();
    } catch (const Error& e) {
        fail(e.status(), "%s: %s", subject.c_str(), e.what());
    }
}

}  // namespace

ShapeSpace::ShapeSpace(const ShapeSettings& settings)
    : settings_(settings),
      box_{settings.cells, settings.cell_size, settings.dims},
      refinement_(box_, settings.refinement),
      kernel_(refinement_.box().cells, settings.sigma * settings.refinement) {}

std::string ShapeSpace::title(int base) const {
    const auto number = static_cast<std::size_t>(base);
    return title_of(number, bases_[number].name);
}

void ShapeSpace::require_open(const char* what) const {
    if (built_) fail(Status::ERROR_STATE, "%s: the shape space is already built; it is frozen from then on", what);
    if (bases_.size() >= kMaxBases)
        fail(Status::ERROR_ARGUMENT, "%s: at most %zu bases are supported", what, kMaxBases);
}

int ShapeSpace::add_mesh(const std::string& name, const TriangleMesh& mesh) {
    require_open("add_mesh");
    if (settings_.dims == 2)
        fail(Status::ERROR_ARGUMENT, "add_mesh: the space has dims = 2, expected a density, polygon or image");
    MeshReport report;
    TriangleMesh cleaned = clean_and_check(mesh, name, &report);
    orient_up(cleaned, settings_.up);
    BaseShape base;
    base.name = name;
    about(title_of(bases_.size(), name), [&] {
        base.fractions =
            covered_fractions(cleaned, refinement_.box(), fine_margin(), settings_.threads, &base.length_in_cells);
    });
    return add_fine(std::move(base));
}

int ShapeSpace::add_fractions(const std::string& name, const double* cells) {
    require_open("add_density");
    const std::size_t n = static_cast<std::size_t>(box_.n_cells());
    const int per_slab = box_.cells[1] * box_.cells[2];
    BaseShape base;
    base.name = name;
    base.fractions.assign(cells, cells + n);
    double sum = 0.0;
    int first = box_.cells[0], last = -1;
    for (std::size_t c = 0; c < n; ++c) {
        if (!(cells[c] >= 0.0 && cells[c] <= 1.0))
            fail(Status::ERROR_ARGUMENT, "%s: cells[%zu] is %s, expected a covered fraction in [0, 1]",
                 title_of(bases_.size(), name).c_str(), c, number_text(cells[c]).c_str());
        sum += cells[c];
        const int i = static_cast<int>(c) / per_slab;
        if (cells[c] >= 0.5) first = std::min(first, i), last = std::max(last, i);
    }
    if (last < 0)
        fail(Status::ERROR_ARGUMENT,
             "%s: no cell is covered by half or more (largest of cells %s, sum %s), expected a body",
             title_of(bases_.size(), name).c_str(), number_text(*std::max_element(cells, cells + n)).c_str(),
             number_text(sum).c_str());
    base.length_in_cells = last - first + 1;
    if (settings_.refinement > 1) base.fine = refinement_.spread(cells);
    return add_base(std::move(base));
}

void ShapeSpace::require_plane(const char* what) const {
    require_open(what);
    if (settings_.dims != 2)
        fail(Status::ERROR_ARGUMENT, "%s: the space has dims = 3, expected 2; add meshes or densities here", what);
}

Margin ShapeSpace::fine_margin() const {
    return {settings_.margin * settings_.refinement, settings_.margin_across * settings_.refinement};
}

int ShapeSpace::add_base(BaseShape base) {
    bases_.push_back(std::move(base));
    return static_cast<int>(bases_.size()) - 1;
}

int ShapeSpace::add_fine(BaseShape base) {
    if (settings_.refinement > 1) {
        base.fine = std::move(base.fractions);
        base.fractions = refinement_.mean(base.fine);
        base.length_in_cells /= settings_.refinement;
    }
    return add_base(std::move(base));
}

int ShapeSpace::add_polygon(const std::string& name, const std::vector<std::array<double, 2>>& corners) {
    require_plane("add_polygon");
    BaseShape base;
    base.name = name;
    about(title_of(bases_.size(), name), [&] {
        base.fractions = polygon_fractions(corners, refinement_.box(), fine_margin(), &base.length_in_cells);
    });
    return add_fine(std::move(base));
}

int ShapeSpace::add_image(const std::string& name, const double* pixels, int rows, int columns) {
    require_plane("add_image");
    BaseShape base;
    base.name = name;
    about(title_of(bases_.size(), name), [&] {
        base.fractions =
            image_fractions(pixels, rows, columns, refinement_.box(), fine_margin(), &base.length_in_cells);
    });
    return add_fine(std::move(base));
}

void ShapeSpace::add_actuator(int base, const Actuator& actuator) {
    require_open("add_actuator");
    if (base < 0 || base >= static_cast<int>(bases_.size()))
        fail(Status::ERROR_ARGUMENT, "base is %d, expected an index in [0, %zu)", base, bases_.size());
    if (!(settings_.cell_size > 0))
        fail(Status::ERROR_STATE,
             "add_actuator: lengths in metres need a known cell size; set options.cell_size > 0 at creation");
    const bool fins = actuator.kind == ActuatorKind::fins;
    std::vector<Actuator> added{actuator};
    if (settings_.dims == 2) {
        // A plane has no heights and no thickness.
        if (actuator.euler[0] != 0.0 || actuator.euler[1] != 0.0)
            fail(Status::ERROR_ARGUMENT, "%s: euler is (%g, %g, %g), expected (0, 0, angle): the space has dims = 2",
                 title(base).c_str(), actuator.euler[0], actuator.euler[1], actuator.euler[2]);
        if (fins && actuator.layers != 1)
            fail(Status::ERROR_ARGUMENT, "%s: layers is %d, expected 1: the space has dims = 2", title(base).c_str(),
                 actuator.layers);
        added[0].mean[2] = 0.0, added[0].variance[2] = box_.dx * box_.dx / kTwoLn2;
    } else if (fins && actuator.variance[2] > std::min(actuator.variance[0], actuator.variance[1])) {
        fail(Status::ERROR_ARGUMENT,
             "%s: variance[2] is %s, expected the smallest of the three (%s, %s): a fin's third axis goes through its "
             "thickness (turn its frame with euler)",
             title(base).c_str(), number_text(actuator.variance[2]).c_str(), number_text(actuator.variance[0]).c_str(),
             number_text(actuator.variance[1]).c_str());
    }
    if (fins && actuator.half == ActuatorHalf::whole) {
        added[0].half = ActuatorHalf::left;
        added.push_back(mirrored(added[0]));
    }
    for (const Actuator& a : added) check_actuator(base, a);
    auto& own = bases_[static_cast<std::size_t>(base)].actuators;
    own.insert(own.end(), added.begin(), added.end());
}

// A category means the same in all bases, and no base has one twice.
void ShapeSpace::check_actuator(int base, const Actuator& actuator) const {
    const int number = actuator.category;
    for (std::size_t i = 0; i < bases_.size(); ++i)
        for (const Actuator& a : bases_[i].actuators) {
            if (a.category != number) continue;
            if (a.kind != actuator.kind)
                fail(Status::ERROR_ARGUMENT, "%s: kind is %d, expected %d, which actuators of category %d have in %s",
                     title(base).c_str(), static_cast<int>(actuator.kind), static_cast<int>(a.kind), number,
                     title(static_cast<int>(i)).c_str());
            if (a.kind == ActuatorKind::fins && a.layers != actuator.layers)
                fail(Status::ERROR_ARGUMENT, "%s: layers is %d, expected %d, which actuators of category %d have in %s",
                     title(base).c_str(), actuator.layers, a.layers, number, title(static_cast<int>(i)).c_str());
            if (static_cast<int>(i) == base && a.half == actuator.half)
                fail(Status::ERROR_STATE, "%s already has an actuator of category %d%s", title(base).c_str(), number,
                     a.half == ActuatorHalf::left    ? " in its left half"
                     : a.half == ActuatorHalf::right ? " in its right half"
                                                     : "");
        }
}

// What a base that names no actuator gets.
void ShapeSpace::place_actuators(int base) {
    BaseShape& b = bases_[static_cast<std::size_t>(base)];
    std::vector<Actuator> placed;
    about("build: " + title(base), [&] { placed.push_back(place_caudal(box_, b.fractions)); });
    auto fins = settings_.automatic_fins ? place_fins(box_, b.fractions) : std::nullopt;
    if (fins) {
        for (const BaseShape& other : bases_)
            for (const Actuator& a : other.actuators)
                if (a.category == fins->category) fins->layers = a.layers;  // as someone has said
        placed.push_back(*fins), placed.push_back(mirrored(*fins));
    }
    for (const Actuator& a : placed) {
        for (std::size_t i = 0; i < bases_.size(); ++i)
            for (const Actuator& other : bases_[i].actuators)
                if (other.category == a.category && other.kind != a.kind)
                    fail(Status::ERROR_STATE,
                         "build: %s names no actuator and gets automatic %s of category %d, which has another kind in "
                         "%s; give base %d its own or use another category there",
                         title(base).c_str(), a.kind == ActuatorKind::fins ? "fins" : "tail muscles", a.category,
                         title(static_cast<int>(i)).c_str(), base);
        b.actuators.push_back(a);
    }
}

// A density is its base's fractions divided by their peak: of a base without a cell that is half covered the body would
// be several times as thick as the shape.
void ShapeSpace::check_thickness() const {
    for (std::size_t i = 0; i < bases_.size(); ++i) {
        const auto& f = bases_[i].fractions;
        const double largest = *std::max_element(f.begin(), f.end());
        if (largest >= 0.5) continue;
        fail(Status::ERROR_ARGUMENT,
             "build: %s is too thin for this grid: no cell is covered by half or more, the largest covered fraction is "
             "%.3g; use more cells (up to %.2g times as many along each axis), a smaller margin, or a thicker shape",
             title(static_cast<int>(i)).c_str(), largest, largest > 0 ? 0.5 / largest : HUGE_VAL);
    }
}

void ShapeSpace::build(const std::function<void(int, int)>& progress) {
    require_open("build");
    if (bases_.empty()) fail(Status::ERROR_STATE, "build: the shape space has no bases; add at least one");
    check_thickness();
    const int total = static_cast<int>(bases_.size());
    const Box before = box_;
    if (progress) progress(0, total);
    if (!(settings_.cell_size > 0)) {
        double longest = 0.0;
        for (const BaseShape& b : bases_) longest = std::max(longest, b.length_in_cells);
        box_.dx = settings_.body_length / longest;
    }
    std::vector<std::vector<Actuator>> given;
    for (const BaseShape& b : bases_) given.push_back(b.actuators);
    try {
        for (int i = 0; i < total; ++i) {
            BaseShape& b = bases_[static_cast<std::size_t>(i)];
            if (b.actuators.empty()) place_actuators(i);
            if (progress) progress(i + 1, total);
        }
        freeze();
    } catch (...) {  // a cancelled or failed build leaves the space as it was
        for (std::size_t i = 0; i < bases_.size(); ++i) bases_[i].actuators = given[i];
        box_ = before;
        throw;
    }
}

void ShapeSpace::freeze() {
    densities_.clear();
    for (BaseShape& b : bases_) {
        double sum = 0.0;
        b.density = settings_.refinement > 1 ? b.fine : b.fractions;
        for (const double f : b.density) sum += f;
        for (double& f : b.density) f /= sum;
        densities_.push_back(b.density);
    }
    list_actuators();
    choose_axis();
    built_ = true;
}

void ShapeSpace::list_actuators() {
    categories_.clear(), slots_.clear();
    fibres_turn_ = false;
    int signals = 0;
    for (int number = 0; number < kMaxCategories; ++number) {
        const Actuator* any = nullptr;
        bool has[3] = {false, false, false};
        for (const BaseShape& b : bases_)
            for (const Actuator& a : b.actuators) {
                if (a.category != number) continue;
                // Fibres of fins lie in the fin's plane, which turns where the bases' frames differ.
                fibres_turn_ = fibres_turn_ || (any && a.kind == ActuatorKind::fins && turned(a, *any));
                has[static_cast<int>(a.half)] = true, any = &a;
            }
        if (!any) continue;
        ActuatorCategory c{number, any->kind, 1, signals, 1};
        if (c.kind == ActuatorKind::fins) c.layers = any->layers, c.n_signals = kBands * c.layers;
        signals += c.n_signals;
        for (const auto half : {ActuatorHalf::whole, ActuatorHalf::left, ActuatorHalf::right})
            if (has[static_cast<int>(half)]) slots_.push_back({static_cast<int>(categories_.size()), half});
        categories_.push_back(c);
    }
}

// The x axis where it runs through every base; else the nearest parallel line that does best, fixed for the space.
void ShapeSpace::choose_axis() {
    const auto worst_cover = [&](double y, double z) {
        const AxisLine line(box_, y, z);
        double worst = 1e300;
        for (const BaseShape& b : bases_) {
            double longest = 0.0;
            for (int i = 0; i < box_.cells[0]; ++i) longest += line.value(b.fractions.data(), i) > 0.5;
            worst = std::min(worst, longest / b.length_in_cells);
        }
        return worst;
    };
    axis_y_ = axis_z_ = 0.0;
    double best = worst_cover(0.0, 0.0);
    if (best >= 0.5) return;
    const int reach = std::max(box_.cells[1], box_.cells[2]);  // in half cells
    double best_distance = 0.0;
    for (int a = -reach; a <= reach; ++a)
        for (int b = -reach; b <= reach; ++b) {
            const double y = 0.5 * a * box_.dx, z = 0.5 * b * box_.dx;
            if (std::fabs(y) > 0.25 * box_.cells[1] * box_.dx || std::fabs(z) > 0.25 * box_.cells[2] * box_.dx)
                continue;
            const double cover = std::min(0.75, worst_cover(y, z)), distance = y * y + z * z;
            if (cover > best + 1e-12 || (cover > best - 1e-12 && distance < best_distance))
                best = cover, best_distance = distance, axis_y_ = y, axis_z_ = z;
        }
}

std::vector<const Actuator*> ShapeSpace::actuators_of(const ActuatorSlot& slot) const {
    const int number = categories_[static_cast<std::size_t>(slot.category)].number;
    std::vector<const Actuator*> out(bases_.size(), nullptr);
    for (std::size_t i = 0; i < bases_.size(); ++i)
        for (const Actuator& a : bases_[i].actuators)
            if (a.category == number && a.half == slot.half) out[i] = &a;
    return out;
}

void ShapeSpace::check_weights(const std::vector<double>& weights) const {
    if (weights.size() != bases_.size())
        fail(Status::ERROR_ARGUMENT, "m is %zu, expected %zu: one weight per base", weights.size(), bases_.size());
    double sum = 0.0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        if (!(weights[i] >= 0.0 && std::isfinite(weights[i])))
            fail(Status::ERROR_ARGUMENT, "weights[%zu] is %g, expected a finite number >= 0", i, weights[i]);
        sum += weights[i];
    }
    if (!(std::fabs(sum - 1.0) <= 1e-9))
        fail(Status::ERROR_ARGUMENT, "weights sum to %.12g, expected 1 within 1e-9 (see dqa_project_simplex)", sum);
}

BarycenterSettings ShapeSpace::barycenter_settings(double tolerance, int threads,
                                                   const std::function<void(int, double)>& monitor) const {
    BarycenterSettings s;
    s.tolerance = tolerance > 0 ? tolerance : settings_.tolerance;
    s.max_iterations = settings_.max_iterations;
    s.threads = threads > 0 ? threads : settings_.threads;
    s.monitor = monitor;
    return s;
}

ShapePoint ShapeSpace::evaluate(const std::vector<double>& weights, double tolerance, int threads,
                                const std::function<void(int, double)>& monitor) const {
    if (!built_) fail(Status::ERROR_STATE, "the shape space is not built; call dqa_shape_space_build first");
    check_weights(weights);
    const BarycenterSettings s = barycenter_settings(tolerance, threads, monitor);
    ShapePoint point;
    point.barycenter = solve_barycenter(kernel_, densities_, weights, s);
    point.p_hat = refinement_.sum(point.barycenter.p);
    point.peak = peak_of(point.p_hat, settings_.peak);
    for (double& v : point.p_hat) v /= point.peak;
    for (const ActuatorSlot& slot : slots_)
        point.actuators.push_back(interpolate_actuator(actuators_of(slot), weights, settings_.interpolation));
    return point;
}

std::vector<double> ShapeSpace::pullback(const ShapePoint& point, const double* p_hat_bar,
                                         const std::vector<ActuatorBar>& actuators_bar, double tolerance, int threads,
                                         const std::function<void(int, double)>& monitor) const {
    const BarycenterSettings s = barycenter_settings(tolerance, threads, monitor);
    const std::vector<double> p_bar = refinement_.spread(
        normalise_pullback(refinement_.sum(point.barycenter.p), point.peak, settings_.peak, p_hat_bar).data());
    std::vector<double> bar = barycenter_pullback(kernel_, densities_, point.barycenter, p_bar.data(), s);
    for (std::size_t k = 0; k < actuators_bar.size(); ++k)
        interpolate_actuator_pullback(actuators_of(slots_[k]), point.actuators[k], settings_.interpolation,
                                      actuators_bar[k], bar);
    double mean = 0.0;
    for (const double b : bar) mean += b / static_cast<double>(bar.size());
    for (double& b : bar) b -= mean;
    return bar;
}

}  // namespace dqa
