// SPDX-License-Identifier: MIT
// A mesh file is read into memory at once and handed to the reader that its extension names.
#include "shape/mesh_file.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "grid/error.hpp"
#include "grid/file.hpp"
#include "shape/mesh_readers.hpp"

namespace dqa {
namespace {

constexpr long long max_bytes = 1LL << 30;
constexpr std::size_t kItems = 1 << 14;  // vertices, faces or lines between two

[[noreturn]] void io_error(const std::string& path, int number) {
    fail(Status::ERROR_IO, "%s: %s", path.c_str(), std::generic_category().message(number).c_str());
}

std::string read_all(const std::string& path, const std::function<void()>& poll) {
    const Descriptor file = open_to_read(path);
    struct stat info;
    if (file.number() < 0 || ::fstat(file.number(), &info) != 0) io_error(path, errno);
    if (S_ISDIR(info.st_mode)) io_error(path, EISDIR);
    if (!S_ISREG(info.st_mode)) fail(Status::ERROR_IO, "%s: not a regular file", path.c_str());
    if (info.st_size == 0)
        fail(Status::ERROR_FILE, "%s: the file is empty; expected an STL, OBJ or PLY mesh", path.c_str());
    if (info.st_size > max_bytes)
        fail(Status::ERROR_FILE, "%s: %lld bytes; mesh files of up to %lld bytes are supported", path.c_str(),
             static_cast<long long>(info.st_size), max_bytes);
    std::string content(static_cast<std::size_t>(info.st_size), '\0');
    const int error = read_into(file, content, poll);
    if (error) io_error(path, error);
    if (content.size() < static_cast<std::size_t>(info.st_size))
        fail(Status::ERROR_IO, "%s: the file became shorter while it was read", path.c_str());
    return content;
}

std::string extension_of(const std::string& path) {
    const std::size_t slash = path.find_last_of('/'), dot = path.find_last_of('.');
    if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) return "";
    std::string extension = path.substr(dot + 1);
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return extension;
}

}  // namespace

void MeshSource::check(std::size_t item) const {
    if (poll && item % kItems == kItems - 1) poll();
}

TriangleMesh read_mesh_file(const std::string& path, const std::function<void()>& poll) {
    const std::string extension = extension_of(path), content = read_all(path, poll);
    const MeshSource source{content, path, poll};
    if (extension == "stl") return read_stl(source);
    if (extension == "obj") return read_obj(source);
    if (extension == "ply") return read_ply(source);
    fail(Status::ERROR_FILE, "%s: the extension is '%.40s'; expected stl, obj or ply", path.c_str(), extension.c_str());
}

}  // namespace dqa
