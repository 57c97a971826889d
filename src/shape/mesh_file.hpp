// SPDX-License-Identifier: MIT
// Triangle meshes from STL (binary or ASCII), Wavefront OBJ and PLY files, by the readers of mesh_readers.hpp. Unit:
// whatever the file is in; coordinates are kept in double precision.
#pragma once

#include <functional>
#include <string>

#include "shape/mesh.hpp"

namespace dqa {

// All triangles of the file, polygons triangulated, objects merged; neither welded nor checked for closedness (that is
// clean_and_check). poll is called now and then, and may throw to end the reading; empty: none. Throws Error: ERROR_IO
// when the file cannot be read, ERROR_FILE when its content is not a complete mesh of the kind its extension says.
TriangleMesh read_mesh_file(const std::string& path, const std::function<void()>& poll = {});

}  // namespace dqa
