// SPDX-License-Identifier: MIT
// Checks of mesh files before an import library sees them: complete, counts that fit the size, finite coordinates,
// indices in range. They make the messages precise (line numbers, counts), and keep damaged or hostile files away from
// the importer.
#pragma once

#include <cstdint>
#include <string>

namespace dqa {

// Each checks the whole content of a file, throws Error with Status::ERROR_FILE, and returns the number of faces with
// three or more corners that an importer must find (at least 1). `path` appears in messages.
std::int64_t precheck_stl(const std::string& content, const std::string& path);
std::int64_t precheck_obj(const std::string& content, const std::string& path);
std::int64_t precheck_ply(const std::string& content, const std::string& path);

}  // namespace dqa
