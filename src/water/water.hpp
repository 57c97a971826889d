// SPDX-License-Identifier: MIT
// Hydrodynamics on the diffuse surface: drag and thrust of DiffAqua (2021) summed over all faces between cells of
// different occupancy, each weighted by sqrt(dG^2 + eps^2) - eps, normal from fuller to emptier.
//
// Per face, with u = mean corner velocity - current, area vector a, A = |a|, n = a/A, spine direction s:
//   lagged (start of the step):  U = sqrt(|u|^2 + eps_v^2), x = n.u/U, L = |u|^2 - (s.u)^2,
//     c_d = rho W A Cd(x) U / 2,  c_t = rho W A L T(x) / (2 U),  T(x) = (Ct(Phi) - Ct(0)) / x,  k = rho W A L Ct(0) / 2
//   force on the swimmer at the new velocity u+:  -(c_d u+ + c_t n (n.u+) + k n),  a quarter to each corner.
// The first two terms are the gradient of the convex dissipation h/2 (c_d |u+|^2 + c_t (n.u+)^2): with explicit forces
// the light nodes of the surface blow up.
//
// Two variants for comparison, as the public code of DiffAqua evaluates the force: `explicit_forces` puts the lagged
// velocity in the place of u+ (the force is then that of the paper, constant during the step), and
// `windward_only` counts only faces that move into the water (n.u > 0). The latter jumps at Phi = 0: its pullback is
// that of the side on which a face lies.
#pragma once

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "grid/active_set.hpp"
#include "grid/node_gather.hpp"
#include "grid/parallel.hpp"
#include "water/kernels.hpp"
#include "water/laws.hpp"

namespace dqa {

struct WaterSettings {
    double density = 1000.0;  // kg/m^3
    Vec3 current{};           // m/s
    std::array<double, 4> drag{0.05, 0.05, 1.85, 2.05};
    std::array<double, 4> thrust{-0.8, -0.5, 0.1, 2.5};
    double speed_smoothing = 1e-2;  // m/s
    double angle_smoothing = 0.02;  // rad
    double surface_smoothing = 1e-2;
    bool explicit_forces = false;
    bool windward_only = false;
};

// What products need of every face, with room for whole blocks of 8, zero beyond the last; n as [block][3][8].
template <class T>
struct WaterResistance {
    std::vector<T> cd, ct, n;
    std::vector<T> force;  // of the chunks, scratch of gradient and product
};

// Lagged coefficients of every face, and the state they came from. In single precision a copy is kept.
struct WaterWorkspace : InBothPrecisions<WaterResistance> {
    std::vector<double> k, u;    // u: lagged relative velocity; both with the room of the others
    std::vector<double> area;    // |a|, [n_faces]
    std::vector<double> energy;  // of the chunks, at the last gradient
    // Scratch of the pullbacks, by face: cotangents of the new and the lagged velocity and of the two diagonals,
    // [n_faces][4][4], and of the occupancy jump.
    std::vector<double> face_bar, jump_bar;

    Vec3 normal(std::size_t face) const { return in_blocks(exact.n, face); }
    Vec3 lagged(std::size_t face) const { return in_blocks(u, face); }
    static Vec3 in_blocks(const std::vector<double>& vectors, std::size_t face) {
        const double* at = vectors.data() + face / 8 * 24 + face % 8;
        return {at[0], at[8], at[16]};
    }
    Vec3 spine{}, current{};
};

// Cotangents of the water's parameters.
struct WaterParameterBar {
    double density = 0.0;
    LawsBar laws;  // WaterLaws::ordinates_pullback takes them to the settings' drag and thrust
    void operator+=(const WaterParameterBar& o);
};

struct WaterTotals {
    Vec3 drag{}, thrust{};                  // N, on the swimmer
    Vec3 mean_drag{}, mean_thrust{};        // divided by the wet area (N/m^2)
    double wet_area = 0.0;                  // m^2
    void operator+=(const WaterTotals& o);  // of the sums; the means are left
};

class Water {
public:
    // occupancy [n_active_cells]; cells outside the active set count as 0.
    Water(const ActiveSet& set, const std::vector<double>& occupancy, const WaterSettings& settings,
          InstructionSet instructions = InstructionSet::automatic);

    int n_faces() const { return static_cast<int>(faces_.size()); }
    const WaterSettings& settings() const { return settings_; }

    // Coefficients of the lagged state q, v [n_nodes][3] with its spine direction (unit), in water that moves with
    // `current` (m/s) during the step.
    void lag(WaterWorkspace& ws, const double* q, const double* v, const Vec3& spine, const Vec3& current,
             Threads threads) const;
    // Value of the incremental potential, and out += its gradient with respect to q_new. The new velocity is
    // (q_new - q_base) / h.
    double gradient(WaterWorkspace& ws, const double* q_new, const double* q_base, double h, Threads threads,
                    double* out) const;
    // out += H p.
    template <class T>
    void product(WaterWorkspace& ws, const T* p, double h, Threads threads, T* out) const;
    // Both in two parts that other terms' may run beside: forces of chunk k of n_chunks(), then list_forces tells their
    // sums on the nodes. energy() adds up what all chunks of a gradient have left.
    int n_chunks() const { return (n_faces() + kChunk - 1) / kChunk; }
    int chunk_node(int k) const { return faces_[static_cast<std::size_t>(k) * kChunk].nodes[0] / 3; }
    void gradient_chunk(WaterWorkspace& ws, const double* q_new, const double* q_base, double h, int k) const;
    double energy(const WaterWorkspace& ws) const;
    template <class T>
    void product_chunk(WaterWorkspace& ws, const T* p, double h, int k) const;
    template <class T>
    void list_forces(const WaterWorkspace& ws, std::vector<NodeTerm<T>>& out) const {
        out.push_back(sums_.gather().term(ws.in(T()).force.data()));
    }
    // Forces of the lagged velocity do not change with the new one: their product is zero.
    bool has_product() const { return !settings_.explicit_forces; }
    // Cotangents of lambda . gradient (q_new held): added to q_base_bar, those of the lagged state (lag_q its
    // positions) q_bar, v_bar and spine_bar, current_bar, parameter_bar, and occupancy_bar [n_active_cells].
    void pullback(WaterWorkspace& ws, const double* q_new, const double* q_base, const double* lag_q,
                  const double* lambda, double h, Threads threads, double* q_base_bar, double* q_bar, double* v_bar,
                  Vec3& spine_bar, Vec3& current_bar, WaterParameterBar& parameter_bar, double* occupancy_bar) const;
    // Power that drag and the part of thrust that resists motion take from the swimmer (W): never negative, except
    // where explicit forces turn a face round within the step.
    double dissipation(const WaterWorkspace& ws, const double* q_new, const double* q_base, double h) const;
    WaterTotals totals(const WaterWorkspace& ws, const double* q_new, const double* q_base, double h,
                       Threads threads = 1) const;
    // Cotangents of the totals, wet_area excepted: added to those of q_new, and to the others as by pullback.
    void totals_pullback(WaterWorkspace& ws, const double* q_new, const double* q_base, const double* lag_q,
                         const WaterTotals& totals_bar, double h, Threads threads, double* q_new_bar,
                         double* q_base_bar, double* q_bar, double* v_bar, Vec3& spine_bar, Vec3& current_bar,
                         WaterParameterBar& parameter_bar, double* occupancy_bar) const;

private:
    template <class T>
    void add_forces(const WaterWorkspace& ws, Threads threads, T* out) const;
    // Blocks of chunk k.
    int first_of(int k) const { return k * (kChunk / 8); }
    int last_of(int k) const { return std::min(first_of(k) + kChunk / 8, (n_faces() + 7) / 8); }
    struct Face {
        std::array<int, 4> nodes{};         // 3 * active node, counter-clockwise about the +axis
        int axis = 0;                       // that it is across
        int cell_low = -1, cell_high = -1;  // active cells on both sides along the axis, -1 outside
        double span_1 = 0.0, span_2 = 0.0;  // z of the diagonals that nodes do not span: the slab's thickness in 2-D
        double weight = 0.0;                // signed: > 0 if the low side is fuller
        double weight_derivative = 0.0;     // d|weight| / d(dG), dG = G_low - G_high
    };
    static Vec3 new_velocity(const WaterWorkspace& ws, const Face& f, const double* q_new, const double* q_base,
                             double inv_h);
    static std::pair<Vec3, Vec3> diagonals(const Face& f, const double* q);
    // The velocity that the force of face i is taken at: u+, or the lagged one of explicit forces.
    Vec3 force_velocity(const WaterWorkspace& ws, std::size_t i, const double* q_new, const double* q_base,
                        double inv_h) const;
    // Factor of the lagged coefficients: 0 for a face that does not count.
    double counted(double x) const { return settings_.windward_only && !(x > 0.0) ? 0.0 : 1.0; }
    // Cotangents of the sum over faces of c_d l.u+ + c_t (n.m)(n.u+) + k n.m + wet_bar |weight| A, where (l, m) are
    // what `vectors` gives for a face; q_new_bar may be null.
    template <class F>
    void pull_back(WaterWorkspace& ws, const double* q_new, const double* q_base, const double* lag_q, F&& vectors,
                   double wet_bar, double h, Threads threads, double* q_new_bar, double* q_base_bar, double* q_bar,
                   double* v_bar, Vec3& spine_bar, Vec3& current_bar, WaterParameterBar& parameter_bar,
                   double* occupancy_bar) const;
    struct SharedBar {
        Vec3 spine{}, current{};
        WaterParameterBar parameters;
        void operator+=(const SharedBar& o);
    };
    // Those of one face: into the workspace, and added to `shared`.
    void face_pullback(WaterWorkspace& ws, std::size_t i, const Vec3& un, const Vec3& l, const Vec3& m, double wet_bar,
                       const double* lag_q, SharedBar& shared) const;

    WaterSettings settings_;
    WaterLaws laws_;
    static constexpr int kChunk = 256;  // faces a chunk
    std::vector<Face> faces_;
    const WaterKernels& kernels_;
    std::vector<int> nodes_;  // of the faces, [block][4][8]
    ChunkedGather sums_;      // of the faces
    NodeGather corners_;      // of their corners: 4 face + corner
};

}  // namespace dqa
