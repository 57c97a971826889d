// SPDX-License-Identifier: MIT
// Triangle meshes of base shapes: checking (closed, consistently oriented, finite), welding, topology, volume, centre
// of mass, and the choice of the vertical axis. Lengths in the unit of the caller's mesh; no unit is assumed.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "grid/box.hpp"

namespace dqa {

struct TriangleMesh {
    std::vector<Vec3> vertices;                 // unit of the mesh
    std::vector<std::array<int, 3>> triangles;  // counter-clockwise seen from outside
};

// What clean_and_check found; filled as far as the check came, also when it throws.
struct MeshReport {
    int boundary_edges = 0;        // edges with a missing neighbour: the mesh is open there
    int flipped_edges = 0;         // edges whose triangles run along them the same way
    int non_manifold_edges = 0;    // edges of more than two triangles whose directions balance
    int degenerate_triangles = 0;  // triangles with a repeated vertex, dropped
    int duplicate_vertices_merged = 0;
    int components = 0;            // connected across edges
    int genus = 0;                 // sum over components; meaningful for a closed manifold only
    int euler_characteristic = 0;  // vertices - edges + triangles, sum over components
    double volume = 0.0;           // signed, before any flip; unit of the mesh cubed
    double length_x = 0.0, length_y = 0.0, length_z = 0.0;  // extents, unit of the mesh
};

// Up direction of a mesh file; the numbers are those of DQA_UP_* in the ABI.
enum MeshUp : int { UP_AUTO = 0, UP_Z = 1, UP_Y = 2 };

// Signed volume (positive when triangles are counter-clockwise from outside) and centre of mass of the enclosed solid;
// overlapping components count once each. Both need a closed mesh.
double mesh_volume(const TriangleMesh& mesh);
Vec3 mesh_centre_of_mass(const TriangleMesh& mesh);

// Welded, non-degenerate, closed, outward-oriented copy of `in`, or Error with Status::ERROR_MESH. Vertices within 1e-6
// of the extent are merged, too, where only that closes the mesh. `name` appears in messages. `report` may be null.
TriangleMesh clean_and_check(const TriangleMesh& in, const std::string& name, MeshReport* report);

// How far a closed mesh is from its mirror image across the plane through its centre of mass normal to `axis` (1 or 2):
// 2-norm of its dimensionless moments up to order three that are odd in that axis and even in the other. 0: symmetric.
double mirror_asymmetry(const TriangleMesh& mesh, int axis);

// Turns a closed mesh so that z is up: UP_Z leaves it, UP_Y maps (x, y, z) to (x, -z, y), UP_AUTO decides by
// mirror_asymmetry: it turns only a mesh that mirrors clearly better across z than across y.
void orient_up(TriangleMesh& mesh, int up);

}  // namespace dqa
