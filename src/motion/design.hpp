// SPDX-License-Identifier: MIT
// One design, ready to simulate: everything that follows from the weights alpha and stays fixed during a rollout
// (active cells, occupancy, mass, muscles, faces, spine, sensors, preconditioner), and the way back from cotangents of
// these to dL/dalpha. Immutable; shared by simulator and tapes.
#pragma once

#include <memory>
#include <vector>

#include "body/body.hpp"
#include "grid/active_set.hpp"
#include "motion/muscles.hpp"
#include "motion/preconditioner.hpp"
#include "motion/scene.hpp"
#include "motion/sensors.hpp"
#include "shape/isosurface.hpp"
#include "shape/shape_space.hpp"
#include "water/water.hpp"

namespace dqa {

// Cotangents of what a design provides; zero-initialised by Design::zero_bar.
struct DesignBar {
    std::vector<double> mu, lambda;      // [n_cells] Lame's parameters
    std::vector<double> mass;            // [n_nodes]
    std::vector<double> muscle_weight;   // [n_muscles]
    std::vector<Vec3> muscle_direction;  // [n_muscles], or empty where fibres do not turn with the weights
    std::vector<double> occupancy;       // [n_cells] through the water's faces
    std::vector<double> spine;           // [n_nodes]
    double head_x = 0.0, tail_x = 0.0;   // sensors
    WaterParameterBar water;
};

// Cotangents of a scene's material. Of solid moduli: cells scale them by their occupancy.
struct MaterialBar {
    std::vector<double> young, muscle;    // [n_box_cells] by Young's modulus (Poisson's ratio held), muscle stiffness
    double poisson = 0.0, density = 0.0;  // Young's modulus held
    double lame_mu = 0.0, lame_lambda = 0.0;  // of all cells together, the other one held
};

class Design {
public:
    Design(std::shared_ptr<const ShapeSpace> space, const std::vector<double>& weights, const SceneSettings& scene,
           const std::function<void(int, double)>& monitor);
    // The same shape in another scene: no new barycentre.
    Design(const Design& other, const SceneSettings& scene);

    const ShapeSpace& space() const { return *space_; }
    const SceneSettings& scene() const { return scene_; }
    const ShapePoint& point() const { return point_; }
    const ActiveSet& set() const { return set_; }
    int n_nodes() const { return set_.n_nodes(); }
    int n_signals() const { return space_->n_signals(); }
    const std::vector<double>& rest() const { return rest_; }            // [n_nodes][3] m
    const std::vector<double>& occupancy() const { return occupancy_; }  // [n_cells]
    const std::vector<double>& mass() const { return mass_; }            // [n_nodes] kg
    const std::vector<double>& spine() const { return spine_; }          // [n_nodes], sums to 1 only after division
    const Body& body() const { return *body_; }
    const Water* water() const { return water_.get(); }  // null without water
    const Preconditioner& preconditioner() const { return *preconditioner_; }
    const std::vector<double>& stiffness_diagonal() const { return diagonal_; }  // of the factorised matrix, [n_nodes]
    const std::vector<int>& constrained() const { return constrained_; }  // coordinates 3 node + axis that stay put
    const Sensors& sensors() const { return sensors_; }
    const Isosurface& surface() const;  // of p_hat = 1/2, at rest
    // Vertices of the surface carried by nodal positions q.
    std::vector<Vec3> carry_surface(const double* q) const;
    double barycenter_seconds() const { return barycenter_seconds_; }
    const Muscles& muscles() const { return muscles_; }
    int n_body_cells() const;    // density above 1/2
    int n_muscle_cells() const;  // cells with at least one fibre

    DesignBar zero_bar() const;
    // dL/dalpha, mean-free.
    MaterialBar material_bar(const DesignBar& bar) const;
    std::vector<double> weights_bar(const DesignBar& bar, const std::function<void(int, double)>& monitor) const;

private:
    void assemble();
    void make_preconditioner();
    void make_diagonal();
    void choose_precision();
    std::unique_ptr<PackedFactor> make_factor() const;
    void make_spine();
    void make_constraints();

    std::shared_ptr<const ShapeSpace> space_;
    SceneSettings scene_;
    ShapePoint point_;
    Occupancy occupancy_law_;
    ActiveSet set_;
    std::vector<double> rest_, occupancy_, mass_, spine_, spine_hat_, diagonal_;
    Muscles muscles_;
    std::unique_ptr<Body> body_;
    std::unique_ptr<Water> water_;
    std::unique_ptr<Preconditioner> preconditioner_;
    std::vector<int> constrained_;
    Sensors sensors_;
    double barycenter_seconds_ = 0.0;
    struct Embedding {
        std::array<int, 8> node;
        std::array<double, 8> weight;
    };
    Isosurface surface_;
    std::vector<Embedding> embedding_;
};

}  // namespace dqa
