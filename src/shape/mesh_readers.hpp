// SPDX-License-Identifier: MIT
// Readers of mesh files from their bytes. What people and programs write is taken where its meaning is clear; what is
// not clear, or not complete, is an Error with Status::ERROR_FILE that names the place and what was expected there.
// Time and memory grow with the number of bytes, whatever a header claims. Nothing else is opened: no material, no
// texture.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "shape/mesh.hpp"

namespace dqa {

struct MeshSource {
    std::string_view content;
    std::string path;                    // for messages
    std::function<void()> poll = {};     // called now and then; what it throws ends the reading. May be empty
    void check(std::size_t item) const;  // polls once in some thousand items
};

// Triangles in the order of the file, polygons cut into triangles; neither welded nor checked for closedness.
TriangleMesh read_stl(const MeshSource& source);
TriangleMesh read_obj(const MeshSource& source);
TriangleMesh read_ply(const MeshSource& source);

// Appends the triangles of a polygon with these corners, indices of mesh.vertices: a fan, or where that would fold over
// itself, ears of its projection along its mean normal (O'Rourke 1998, Computational Geometry in C, sec. 1.6).
void add_polygon(TriangleMesh& mesh, const std::vector<int>& corners);

}  // namespace dqa
