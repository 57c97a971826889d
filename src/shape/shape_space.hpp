// SPDX-License-Identifier: MIT
// The shape space: box, base shapes with actuators, and the map alpha -> (normalised density, actuators) with its
// pullback. Filled, then frozen by build(); immutable and shareable afterwards.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "grid/box.hpp"
#include "shape/actuator.hpp"
#include "shape/barycenter.hpp"
#include "shape/gaussian_kernel.hpp"
#include "shape/mesh.hpp"
#include "shape/occupancy.hpp"
#include "shape/refinement.hpp"
#include "shape/voxelize.hpp"

namespace dqa {

struct ShapeSettings {
    int dims = 3;
    std::array<int, 3> cells{60, 16, 26};  // cells[2] is 1 in two dimensions
    int margin = 2;                        // empty cells ahead and behind
    int margin_across = 0;                 // and to the sides
    int up = 0;
    int subsamples = 8;  // of earlier versions, kept in files; fractions are exact now
    int refinement = 1;  // finer cells along the edge of a cell, between which mass moves
    Peak peak = Peak::smooth;
    int max_iterations = 5000;
    int threads = 1;
    double body_length = 1.0;  // m
    double cell_size = 0.0;    // m; 0: from body_length
    double sigma = 0.4;        // cells
    double tolerance = 1e-9;
    Interpolation interpolation = Interpolation::linear;  // of actuators
    bool automatic_fins = false;
};

struct BaseShape {
    std::string name;
    std::vector<double> fractions;  // covered fraction of each cell
    std::vector<double> fine;       // of each finer cell; empty without refinement
    std::vector<double> density;    // of each finer cell: its fraction / sum
    double length_in_cells = 0.0;
    std::vector<Actuator> actuators;  // fins: one for each half
};

// What the actuators of one number are, over all bases, and where their signals stand.
struct ActuatorCategory {
    int number = 0;
    ActuatorKind kind = ActuatorKind::caudal;
    int layers = 1;  // of fins
    int first_signal = 0, n_signals = 1;
    bool operator==(const ActuatorCategory&) const = default;
};
// A box of muscle that interpolates by itself: a caudal actuator, or one half of a pair of fins.
struct ActuatorSlot {
    int category = 0;  // index into categories()
    ActuatorHalf half = ActuatorHalf::whole;
    bool operator==(const ActuatorSlot&) const = default;
};

// A design's geometry.
struct ShapePoint {
    Barycenter barycenter;  // on the finer cells
    double peak = 0.0;
    std::vector<double> p_hat;             // [n_cells]
    std::vector<ActuatorPoint> actuators;  // one per slot of the space
};

class ShapeSpace {
public:
    explicit ShapeSpace(const ShapeSettings& settings);

    int add_mesh(const std::string& name, const TriangleMesh& mesh);
    int add_fractions(const std::string& name, const double* cells);
    // Of a plane space: see planar_base.hpp.
    int add_polygon(const std::string& name, const std::vector<std::array<double, 2>>& corners);
    int add_image(const std::string& name, const double* pixels, int rows, int columns);
    // Of fins: half `whole` gives both halves, the left one as described and the right one as its mirror image.
    void add_actuator(int base, const Actuator& actuator);
    // progress(done, total) may throw to cancel; the space is then still unbuilt.
    void build(const std::function<void(int, int)>& progress);

    bool built() const { return built_; }
    const Box& box() const { return box_; }
    const ShapeSettings& settings() const { return settings_; }
    const std::vector<BaseShape>& bases() const { return bases_; }
    // By number; their signals follow one another in this order.
    const std::vector<ActuatorCategory>& categories() const { return categories_; }
    const std::vector<ActuatorSlot>& slots() const { return slots_; }
    int n_signals() const {
        return categories_.empty() ? 0 : categories_.back().first_signal + categories_.back().n_signals;
    }
    // Whether the directions of fibres depend on the weights.
    bool fibres_turn() const { return fibres_turn_; }
    // Straight line parallel to x that runs through every base: where sensors sit (m).
    double axis_y() const { return axis_y_; }
    double axis_z() const { return axis_z_; }

    // tolerance <= 0: that of the settings. threads <= 0: likewise. monitor(iteration, error) may throw to cancel.
    ShapePoint evaluate(const std::vector<double>& weights, double tolerance, int threads,
                        const std::function<void(int, double)>& monitor) const;
    // Mean-free weights_bar from cotangents of p_hat [n_cells] and of the actuators [n_slots] (may be empty).
    std::vector<double> pullback(const ShapePoint& point, const double* p_hat_bar,
                                 const std::vector<ActuatorBar>& actuators_bar, double tolerance, int threads,
                                 const std::function<void(int, double)>& monitor) const;

    void save(const std::string& path) const;
    static std::shared_ptr<ShapeSpace> load(const std::string& path);

    // weights on the simplex or an ERROR_ARGUMENT that says which entry is off.
    void check_weights(const std::vector<double>& weights) const;

private:
    std::string title(int base) const;  // number and name, for messages
    void require_open(const char* what) const;
    void require_plane(const char* what) const;
    Margin fine_margin() const;
    int add_fine(BaseShape base);  // with what was found on the finer cells as its fractions and length
    int add_base(BaseShape base);
    void freeze();  // everything that follows from bases and cell size
    void choose_axis();
    void list_actuators();
    void check_thickness() const;
    void place_actuators(int base);
    void check_actuator(int base, const Actuator& actuator) const;
    std::vector<const Actuator*> actuators_of(const ActuatorSlot& slot) const;
    BarycenterSettings barycenter_settings(double tolerance, int threads,
                                           const std::function<void(int, double)>& monitor) const;

    ShapeSettings settings_;
    Box box_;
    Refinement refinement_;
    GaussianKernel kernel_;
    std::vector<BaseShape> bases_;
    std::vector<std::vector<double>> densities_;
    std::vector<ActuatorCategory> categories_;
    std::vector<ActuatorSlot> slots_;
    bool fibres_turn_ = false;
    double axis_y_ = 0.0, axis_z_ = 0.0;
    bool built_ = false;
};

}  // namespace dqa
