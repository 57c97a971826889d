// SPDX-License-Identifier: MIT
// A built shape space as a file: magic, version, settings, bases with actuators, checksum. Little-endian doubles, so
// that a space read back is the same to the last bit.
#include <cmath>
#include <limits>

#include "grid/error.hpp"
#include "grid/sealed_file.hpp"
#include "shape/shape_space.hpp"

namespace dqa {
namespace {

constexpr char kMagic[8] = {'D', 'Q', 'A', 'S', 'P', 'A', 'C', 'E'};
constexpr std::uint32_t kVersion = 4;

}  // namespace

void ShapeSpace::save(const std::string& path) const {
    if (!built_) fail(Status::ERROR_STATE, "the shape space is not built; call dqa_shape_space_build first");
    SealedWriter w(kMagic, kVersion);
    w.integer(settings_.dims);
    for (const int n : settings_.cells) w.integer(n);
    for (const int v :
         {settings_.margin, settings_.margin_across, settings_.up, settings_.subsamples,
          static_cast<int>(settings_.peak), settings_.max_iterations, static_cast<int>(settings_.interpolation),
          static_cast<int>(settings_.automatic_fins), settings_.refinement})
        w.integer(v);
    for (const double v : {settings_.body_length, settings_.cell_size, settings_.sigma, settings_.tolerance, box_.dx})
        w.put(v);
    w.put(static_cast<std::uint32_t>(bases_.size()));
    for (const BaseShape& b : bases_) {
        w.put(static_cast<std::uint32_t>(b.name.size()));
        w.text(b.name);
        w.put(b.length_in_cells);
        w.doubles(b.fractions.data(), b.fractions.size());
        w.doubles(b.fine.data(), b.fine.size());
        w.put(static_cast<std::uint32_t>(b.actuators.size()));
        for (const Actuator& a : b.actuators) {
            for (const int v : {a.category, static_cast<int>(a.kind), static_cast<int>(a.half), a.layers}) w.integer(v);
            w.doubles(a.mean.data(), 3), w.doubles(a.variance.data(), 3), w.doubles(a.euler.data(), 3);
        }
    }
    w.save(path);
}

std::shared_ptr<ShapeSpace> ShapeSpace::load(const std::string& path) {
    SealedReader r(path, kMagic, kVersion, "a saved shape space");
    ShapeSettings s;
    s.dims = r.integer("dims", 2, 3);
    for (int& n : s.cells) n = r.integer("a number of cells", 1, 512);
    r.expect(s.dims == 3 || s.cells[2] == 1, "the number of cells along z of a plane space", s.cells[2]);
    s.margin = r.integer("margin", 0, 256), s.margin_across = r.integer("margin_across", 0, 256),
    s.up = r.integer("up", UP_AUTO, UP_Y);
    s.subsamples = r.integer("subsamples", 1, 1024);
    s.peak = static_cast<Peak>(r.integer("peak", 0, static_cast<int>(Peak::paper)));
    s.max_iterations = r.integer("max_iterations", 1, std::numeric_limits<int>::max());
    s.interpolation = static_cast<Interpolation>(r.integer("interpolation", 0, static_cast<int>(Interpolation::bures)));
    s.automatic_fins = r.integer("automatic_fins", 0, 1) != 0;
    s.refinement = r.integer("refinement", 1, kMaxRefinement);
    s.body_length = r.positive("body_length");
    s.cell_size = r.get<double>();
    r.expect(s.cell_size >= 0 && std::isfinite(s.cell_size), "cell_size", s.cell_size);
    s.sigma = r.positive("sigma"), s.tolerance = r.positive("tolerance");
    const double dx = r.positive("the edge of a cell");
    std::shared_ptr<ShapeSpace> space;
    try {
        space = std::make_shared<ShapeSpace>(s);
    } catch (const Error& e) {
        fail(Status::ERROR_FILE, "'%s': %s", path.c_str(), e.what());
    }
    space->box_.dx = dx;
    const std::size_t n_cells = static_cast<std::size_t>(space->box_.n_cells());
    const std::size_t n_fine =
        s.refinement > 1 ? static_cast<std::size_t>(space->refinement_.box().n_cells()) : 0;  // of a base in the file
    const std::uint32_t count = r.get<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) {
        BaseShape b;
        b.name = r.text(r.get<std::uint32_t>());
        b.length_in_cells = r.positive("a base's length");
        r.need((n_cells + n_fine) * sizeof(double));  // before memory is asked for
        for (auto [fractions, n] : {std::pair{&b.fractions, n_cells}, std::pair{&b.fine, n_fine}}) {
            fractions->resize(n);
            r.doubles(fractions->data(), n);
            double sum = 0.0;
            for (const double f : *fractions) r.expect(f >= 0 && f <= 1, "a covered fraction", f), sum += f;
            r.expect(n == 0 || sum > 0, "the sum of a base's fractions", sum);
        }
        std::vector<Actuator> given;
        const std::uint32_t actuators = r.get<std::uint32_t>();
        for (std::uint32_t k = 0; k < actuators; ++k) {
            Actuator a;
            a.category = r.integer("an actuator's category", 0, kMaxCategories - 1);
            a.kind =
                static_cast<ActuatorKind>(r.integer("an actuator's kind", 0, static_cast<int>(ActuatorKind::fins)));
            const bool fins = a.kind == ActuatorKind::fins;
            a.half = static_cast<ActuatorHalf>(r.integer("an actuator's half", fins ? 1 : 0, fins ? 2 : 0));
            a.layers = r.integer("an actuator's layers", 1, kMaxLayers);
            r.doubles(a.mean.data(), 3);
            for (double& v : a.variance) v = r.positive("an actuator's variance");
            r.doubles(a.euler.data(), 3);
            for (const double v : a.mean) r.expect(std::isfinite(v), "an actuator's mean", v);
            for (const double v : a.euler) r.expect(std::isfinite(v), "an actuator's angle", v);
            given.push_back(a);
        }
        space->bases_.push_back(std::move(b));
        for (const Actuator& a : given) {
            try {
                space->check_actuator(static_cast<int>(i), a);
            } catch (const Error& e) {
                fail(Status::ERROR_FILE, "'%s': %s", path.c_str(), e.what());
            }
            space->bases_.back().actuators.push_back(a);
        }
    }
    if (r.left() != 0)
        fail(Status::ERROR_FILE, "'%s' holds %zu bytes more than its bases need", path.c_str(), r.left());
    if (space->bases_.empty()) fail(Status::ERROR_FILE, "'%s' holds no bases", path.c_str());
    space->freeze();
    return space;
}

}  // namespace dqa
