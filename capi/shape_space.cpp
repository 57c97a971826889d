// SPDX-License-Identifier: MIT
// The shape space's handle.
#include <cinttypes>

#include "internal.hpp"
#include "shape/mesh_file.hpp"

using namespace dqa::capi;
using dqa::fail;
using dqa::Status;

namespace {

dqa_shape_space_options default_options() {
    const dqa::ShapeSettings s;
    dqa_shape_space_options o{};
    o.struct_size = sizeof o;
    o.dims = 3;
    o.cells_x = s.cells[0], o.cells_y = s.cells[1], o.cells_z = s.cells[2];
    o.margin = s.margin, o.margin_across = s.margin_across;
    o.up = DQA_UP_AUTO;
    o.subsamples = s.subsamples;
    o.peak = DQA_PEAK_SMOOTH;
    o.max_iterations = s.max_iterations;
    o.threads = s.threads;
    o.body_length = s.body_length;
    o.cell_size = s.cell_size;
    o.sigma = s.sigma;
    o.tolerance = s.tolerance;
    o.interpolation = DQA_INTERPOLATION_LINEAR;
    o.automatic_fins = s.automatic_fins;
    o.refinement = s.refinement;
    return o;
}

dqa::ShapeSettings settings_from(const dqa_shape_space_options& o) {
    require_range(o.flags, o.flags == 0, "flags", "0");
    require_range(o.dims, o.dims == 2 || o.dims == 3, "dims", "2 or 3");
    const int cells_z = o.dims == 2 ? 1 : o.cells_z;
    require_range(o.cells_x, o.cells_x >= 8 && o.cells_x <= 512, "cells_x", "a number of cells in [8, 512]");
    require_range(o.cells_y, o.cells_y >= 8 && o.cells_y <= 512, "cells_y", "a number of cells in [8, 512]");
    if (o.dims == 3)
        require_range(o.cells_z, o.cells_z >= 8 && o.cells_z <= 512, "cells_z", "a number of cells in [8, 512]");
    require_range(o.margin, o.margin >= 1 && o.margin <= 256 && 2 * o.margin < o.cells_x, "margin",
                  "at least 1 and less than half of cells_x");
    require_range(o.margin_across,
                  o.margin_across >= 0 && o.margin_across <= 256 && 2 * o.margin_across < o.cells_y &&
                      (o.dims == 2 || 2 * o.margin_across < o.cells_z),
                  "margin_across", "at least 0 and less than half of cells_y and cells_z");
    require_range(o.padding, o.padding == 0, "padding", "0");
    require_range(o.up, o.up >= DQA_UP_AUTO && o.up <= DQA_UP_Y, "up", "one of DQA_UP_AUTO, DQA_UP_Z, DQA_UP_Y");
    require_range(o.subsamples, o.subsamples >= 1 && o.subsamples <= 16, "subsamples", "a number in [1, 16]");
    require_range(o.peak, o.peak == DQA_PEAK_SMOOTH || o.peak == DQA_PEAK_PAPER, "peak",
                  "DQA_PEAK_SMOOTH or DQA_PEAK_PAPER");
    require_range(o.max_iterations, o.max_iterations >= 1, "max_iterations", "at least 1");
    require_range(o.threads, o.threads >= 1 && o.threads <= 1024, "threads", "a number in [1, 1024]");
    const auto is_length = [](double x) { return x >= 1e-9 && x <= 1e9; };
    require_range(o.body_length, is_length(o.body_length), "body_length", "a length in [1e-9, 1e9] (m)");
    require_range(o.cell_size, o.cell_size == 0.0 || is_length(o.cell_size), "cell_size",
                  "a length in [1e-9, 1e9] (m), or 0 for automatic");
    require_range(o.sigma, o.sigma >= 0.2 && o.sigma <= 16, "sigma", "a width in [0.2, 16] cells");
    require_range(o.tolerance, o.tolerance > 0, "tolerance", "a number > 0");
    require_range(o.interpolation,
                  o.interpolation == DQA_INTERPOLATION_LINEAR || o.interpolation == DQA_INTERPOLATION_BURES,
                  "interpolation", "DQA_INTERPOLATION_LINEAR or DQA_INTERPOLATION_BURES");
    require_range(o.automatic_fins, o.automatic_fins == 0 || o.automatic_fins == 1, "automatic_fins", "0 or 1");
    require_range(static_cast<double>(o.refinement), o.refinement >= 1 && o.refinement <= dqa::kMaxRefinement,
                  "refinement", "a number in [1, 4]");
    dqa::ShapeSettings s;
    s.dims = o.dims;
    s.interpolation = static_cast<dqa::Interpolation>(o.interpolation), s.automatic_fins = o.automatic_fins == 1;
    s.cells = {o.cells_x, o.cells_y, cells_z};
    s.margin = o.margin, s.margin_across = o.margin_across, s.up = o.up, s.subsamples = o.subsamples;
    s.refinement = static_cast<int>(o.refinement);
    s.peak = static_cast<dqa::Peak>(o.peak);
    s.max_iterations = o.max_iterations, s.threads = o.threads;
    s.body_length = o.body_length, s.cell_size = o.cell_size, s.sigma = o.sigma, s.tolerance = o.tolerance;
    return s;
}

dqa_actuator_options default_actuator() {
    dqa_actuator_options o{};
    o.struct_size = sizeof o;
    o.kind = DQA_ACTUATOR_CAUDAL;
    for (double& v : o.variance) v = 1e-2;
    o.side = DQA_SIDE_BOTH;
    o.layers = dqa::kMaxLayers;
    return o;
}

void require_side(int32_t side) {
    require_range(side, side >= DQA_SIDE_BOTH && side <= DQA_SIDE_RIGHT, "side",
                  "DQA_SIDE_BOTH, DQA_SIDE_LEFT or DQA_SIDE_RIGHT");
}

void require_category(int32_t category) {
    require_range(category, category >= 0 && category < dqa::kMaxCategories, "category", "a number in [0, 15]");
}

dqa::Actuator actuator_from(const dqa_actuator_options& o) {
    require_range(o.flags, o.flags == 0, "flags", "0");
    require_category(o.category);
    require_range(o.kind, o.kind == DQA_ACTUATOR_CAUDAL || o.kind == DQA_ACTUATOR_FINS, "kind",
                  "DQA_ACTUATOR_CAUDAL or DQA_ACTUATOR_FINS");
    require_side(o.side);
    require_range(o.side, o.kind == DQA_ACTUATOR_FINS || o.side == DQA_SIDE_BOTH, "side",
                  "DQA_SIDE_BOTH for a caudal actuator");
    require_range(o.layers, o.layers >= 1 && o.layers <= dqa::kMaxLayers, "layers", "a number in [1, 4]");
    dqa::Actuator a;
    for (std::size_t k = 0; k < 3; ++k) {
        require_range(o.mean[k], true, "mean", "finite lengths (m)");
        require_range(o.variance[k], o.variance[k] > 0, "variance", "numbers > 0 (m^2)");
        require_range(o.euler[k], true, "euler", "finite angles (rad)");
        a.mean[k] = o.mean[k], a.variance[k] = o.variance[k], a.euler[k] = o.euler[k];
    }
    a.category = o.category, a.layers = o.layers;
    a.kind = static_cast<dqa::ActuatorKind>(o.kind);
    a.half = static_cast<dqa::ActuatorHalf>(o.side);
    return a;
}

void require_built(const dqa_shape_space* space) {
    require(space, "space");
    if (!space->core->built())
        fail(Status::ERROR_STATE, "the shape space is not built; call dqa_shape_space_build first");
}

const dqa::BaseShape& base_of(const dqa_shape_space* space, int32_t base) {
    require(space, "space");
    const auto& bases = space->core->bases();
    if (base < 0 || base >= static_cast<int32_t>(bases.size()))
        fail(Status::ERROR_ARGUMENT, "base is %d, expected an index in [0, %zu)", base, bases.size());
    return bases[static_cast<std::size_t>(base)];
}

}  // namespace

namespace dqa::capi {

std::vector<double> read_weights(const ShapeSpace& space, const double* weights, std::int64_t m) {
    require(weights, "weights");
    require_count(m, static_cast<std::int64_t>(space.bases().size()), "m", "weights [n_bases]");
    std::vector<double> out(weights, weights + m);
    space.check_weights(out);
    return out;
}

}  // namespace dqa::capi

extern "C" {

dqa_status dqa_shape_space_options_init(dqa_shape_space_options* options, uint64_t size) {
    return guard([&] { init_options(options, size, default_options(), "options"); });
}

dqa_status dqa_shape_space_create(const dqa_shape_space_options* options, dqa_shape_space** space) {
    return guard([&] {
        begin_create(space, "space");
        const auto o = read_options(options, default_options(), "options");
        auto made = std::make_unique<dqa_shape_space>();
        made->core = std::make_shared<dqa::ShapeSpace>(settings_from(o));
        if (o.cancel) made->cancel = o.cancel->flag;
        *space = made.release();
    });
}

void dqa_shape_space_free(dqa_shape_space* space) {
    free_handle(space);
}

dqa_status dqa_shape_space_add_mesh(dqa_shape_space* space, const char* name, const double* vertices,
                                    int64_t n_vertices, const int32_t* triangles, int64_t n_triangles, int32_t* base) {
    return guard([&] {
        const Change change(space, "space");
        require(name, "name"), require(vertices, "vertices"), require(triangles, "triangles");
        constexpr int64_t most = INT32_MAX / 4;
        if (n_vertices < 0 || n_vertices > most)
            fail(Status::ERROR_ARGUMENT, "n_vertices is %" PRId64 ", expected a number in [0, %" PRId64 "]", n_vertices,
                 most);
        if (n_triangles < 0 || n_triangles > most)
            fail(Status::ERROR_ARGUMENT, "n_triangles is %" PRId64 ", expected a number in [0, %" PRId64 "]",
                 n_triangles, most);
        dqa::TriangleMesh mesh;
        for (int64_t k = 0; k < n_vertices; ++k)
            mesh.vertices.push_back({vertices[3 * k], vertices[3 * k + 1], vertices[3 * k + 2]});
        for (int64_t k = 0; k < n_triangles; ++k)
            mesh.triangles.push_back({triangles[3 * k], triangles[3 * k + 1], triangles[3 * k + 2]});
        const int index = space->core->add_mesh(name, mesh);
        if (base) *base = index;
    });
}

dqa_status dqa_shape_space_add_mesh_file(dqa_shape_space* space, const char* path, int32_t* base) {
    return guard([&] {
        const Change change(space, "space");
        require(path, "path");
        const std::string file(path);
        if (space->core->built())
            fail(Status::ERROR_STATE, "add_mesh_file: the shape space is already built; it is frozen from then on");
        const std::size_t slash = file.find_last_of('/'), dot = file.find_last_of('.');
        const std::size_t first = slash == std::string::npos ? 0 : slash + 1;
        const std::string name =
            file.substr(first, dot == std::string::npos || dot < first ? std::string::npos : dot - first);
        const int index = space->core->add_mesh(name, dqa::read_mesh_file(file, [&] { check_cancel(space->cancel); }));
        if (base) *base = index;
    });
}

dqa_status dqa_shape_space_add_density(dqa_shape_space* space, const char* name, const double* cells, int64_t n,
                                       int32_t* base) {
    return guard([&] {
        const Change change(space, "space");
        require(name, "name"), require(cells, "cells");
        require_count(n, space->core->box().n_cells(), "n", "cells [cells_x][cells_y][cells_z]");
        const int index = space->core->add_fractions(name, cells);
        if (base) *base = index;
    });
}

dqa_status dqa_shape_space_add_polygon(dqa_shape_space* space, const char* name, const double* corners,
                                       int64_t n_corners, int32_t* base) {
    return guard([&] {
        const Change change(space, "space");
        require(name, "name"), require(corners, "corners");
        require_range(static_cast<double>(n_corners), n_corners >= 3 && n_corners <= 16384, "n_corners",
                      "a number in [3, 16384]");
        std::vector<std::array<double, 2>> points;
        for (int64_t k = 0; k < n_corners; ++k) points.push_back({corners[2 * k], corners[2 * k + 1]});
        const int index = space->core->add_polygon(name, points);
        if (base) *base = index;
    });
}

dqa_status dqa_shape_space_add_image(dqa_shape_space* space, const char* name, const double* pixels, int64_t n_rows,
                                     int64_t n_columns, int32_t* base) {
    return guard([&] {
        const Change change(space, "space");
        require(name, "name"), require(pixels, "pixels");
        require_range(static_cast<double>(n_rows), n_rows >= 1 && n_rows <= 32768, "n_rows", "a number in [1, 32768]");
        require_range(static_cast<double>(n_columns), n_columns >= 1 && n_columns <= 32768, "n_columns",
                      "a number in [1, 32768]");
        const int index = space->core->add_image(name, pixels, static_cast<int>(n_rows), static_cast<int>(n_columns));
        if (base) *base = index;
    });
}

dqa_status dqa_actuator_options_init(dqa_actuator_options* options, uint64_t size) {
    return guard([&] { init_options(options, size, default_actuator(), "options"); });
}

dqa_status dqa_shape_space_add_actuator(dqa_shape_space* space, int32_t base, const dqa_actuator_options* options) {
    return guard([&] {
        const Change change(space, "space");
        require(options, "options");
        space->core->add_actuator(base, actuator_from(read_options(options, default_actuator(), "options")));
    });
}

dqa_status dqa_shape_space_get_actuator(const dqa_shape_space* space, int32_t base, int32_t category, int32_t side,
                                        dqa_actuator_options* options) {
    return guard([&] {
        require(space, "space"), require(options, "options");
        const dqa::BaseShape& b = base_of(space, base);
        require_category(category), require_side(side);
        for (const dqa::Actuator& a : b.actuators) {
            if (a.category != category || static_cast<int32_t>(a.half) != side) continue;
            // The caller's struct_size says how much of the struct there is room for.
            auto o = read_options(options, default_actuator(), "options");
            const uint32_t size = options->struct_size;
            o.category = category, o.side = side, o.layers = a.layers;
            o.kind = static_cast<int32_t>(a.kind);
            for (std::size_t k = 0; k < 3; ++k)
                o.mean[k] = a.mean[k], o.variance[k] = a.variance[k], o.euler[k] = a.euler[k];
            o.struct_size = size;
            std::memcpy(options, &o, size < sizeof o ? size : sizeof o);
            return;
        }
        fail(Status::ERROR_STATE, "base %d has no actuator of category %d and side %d (automatic ones appear at build)",
             base, category, side);
    });
}

dqa_status dqa_shape_space_build(dqa_shape_space* space, dqa_progress progress, void* user_data) {
    return guard([&] {
        const Change change(space, "space");
        space->core->build([&](int done, int total) {
            check_cancel(space->cancel);
            if (progress && progress(done, total, user_data))
                fail(Status::CANCELLED, "cancelled by the progress callback");
        });
    });
}

dqa_status dqa_shape_space_get_info(const dqa_shape_space* space, dqa_shape_space_info* info, uint64_t size) {
    return guard([&] {
        require(space, "space");
        const dqa::ShapeSpace& core = *space->core;
        dqa_shape_space_info i{};
        i.dims = core.box().dims;
        i.cells_x = core.box().cells[0], i.cells_y = core.box().cells[1], i.cells_z = core.box().cells[2];
        i.n_bases = static_cast<int32_t>(core.bases().size());
        i.n_signals = core.n_signals();
        i.is_built = core.built() ? 1 : 0;
        i.n_cells = core.box().n_cells();
        i.cell_size = core.box().dx;
        write_struct(info, size, i, "info");
    });
}

dqa_status dqa_shape_space_signal(const dqa_shape_space* space, int32_t signal, dqa_signal_info* info, uint64_t size) {
    return guard([&] {
        require_built(space);
        const dqa::ShapeSpace& core = *space->core;
        if (signal < 0 || signal >= core.n_signals())
            fail(Status::ERROR_ARGUMENT, "signal is %d, expected an index in [0, %d)", signal, core.n_signals());
        dqa_signal_info i{};
        for (const dqa::ActuatorCategory& c : core.categories()) {
            const int32_t within = signal - c.first_signal;
            if (within < 0 || within >= c.n_signals) continue;
            i.category = c.number, i.kind = static_cast<int32_t>(c.kind);
            i.layer = within / dqa::kBands, i.group = within % dqa::kBands;
        }
        write_struct(info, size, i, "info");
    });
}

const char* dqa_shape_space_base_name(const dqa_shape_space* space, int32_t base) {
    if (!space || base < 0 || base >= static_cast<int32_t>(space->core->bases().size())) return "";
    return space->core->bases()[static_cast<std::size_t>(base)].name.c_str();
}

dqa_status dqa_shape_space_get_base(const dqa_shape_space* space, int32_t base, double* cells, int64_t n) {
    return guard([&] {
        const dqa::BaseShape& b = base_of(space, base);
        require(cells, "cells");
        copy_out(b.fractions.data(), b.fractions.size(), cells, n, "n", "cells [cells_x][cells_y][cells_z]");
    });
}

dqa_status dqa_shape_space_density(const dqa_shape_space* space, const double* weights, int64_t m, double* density,
                                   int64_t n) {
    return guard([&] {
        require_built(space);
        const auto w = read_weights(*space->core, weights, m);
        require(density, "density");
        require_count(n, space->core->box().n_cells(), "n", "density [cells_x][cells_y][cells_z]");
        const auto point = space->core->evaluate(w, 0.0, 0, shape_monitor(nullptr, nullptr, 1.0, space->cancel));
        std::memcpy(density, point.p_hat.data(), point.p_hat.size() * sizeof *density);
    });
}

dqa_status dqa_shape_space_pullback(const dqa_shape_space* space, const double* weights, int64_t m,
                                    const double* density_bar, int64_t n, double* weights_bar) {
    return guard([&] {
        require_built(space);
        const auto w = read_weights(*space->core, weights, m);
        require(density_bar, "density_bar"), require(weights_bar, "weights_bar");
        require_count(n, space->core->box().n_cells(), "n", "density_bar [cells_x][cells_y][cells_z]");
        require_finite(density_bar, n, "density_bar");
        const auto monitor = shape_monitor(nullptr, nullptr, 1.0, space->cancel);
        const auto point = space->core->evaluate(w, 0.0, 0, monitor);
        const auto bar = space->core->pullback(point, density_bar, {}, 0.0, 0, monitor);
        std::memcpy(weights_bar, bar.data(), bar.size() * sizeof *weights_bar);
    });
}

dqa_status dqa_shape_space_save(const dqa_shape_space* space, const char* path) {
    return guard([&] {
        require(space, "space"), require(path, "path");
        space->core->save(path);
    });
}

dqa_status dqa_shape_space_load(const char* path, dqa_shape_space** space) {
    return guard([&] {
        begin_create(space, "space");
        require(path, "path");
        auto made = std::make_unique<dqa_shape_space>();
        made->core = dqa::ShapeSpace::load(path);
        *space = made.release();
    });
}

}  // extern "C"
