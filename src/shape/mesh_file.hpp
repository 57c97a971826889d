// SPDX-License-Identifier: MIT
// Reads triangle meshes from STL (binary or ASCII), Wavefront OBJ and PLY files. Unit: whatever the file is in.
#pragma once

#include <string>

#include "shape/mesh.hpp"

namespace dqa {

// All triangles of the file, polygons triangulated, objects merged; neither welded nor checked for closedness (that is
// clean_and_check). Throws Error: ERROR_IO when the file cannot be read, ERROR_FILE when its content is not a complete
// mesh of the kind its name says, ERROR_UNSUPPORTED in builds without DQA_WITH_ASSIMP.
TriangleMesh read_mesh_file(const std::string& path);

}  // namespace dqa
