// SPDX-License-Identifier: MIT
// Mesh files through Assimp. The file is read into memory once, checked (mesh_precheck), and only then handed to
// Assimp, which therefore opens no other file (material libraries, textures). Unit: that of the file.
#include "shape/mesh_file.hpp"

#ifdef DQA_HAVE_ASSIMP
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cerrno>
#include <cmath>
#include <system_error>

#include "shape/mesh_precheck.hpp"
#endif

#include "grid/error.hpp"

namespace dqa {

#ifndef DQA_HAVE_ASSIMP

TriangleMesh read_mesh_file(const std::string& path) {
    fail(Status::ERROR_UNSUPPORTED,
         "%s: this build cannot read mesh files; it was configured with DQA_WITH_ASSIMP=OFF. Pass vertices and "
         "triangles",
         path.c_str());
}

#else

namespace {

constexpr long long max_bytes = 1LL << 30;

[[noreturn]] void io_error(const std::string& path, int number) {
    fail(Status::ERROR_IO, "%s: %s", path.c_str(), std::generic_category().message(number).c_str());
}

class Descriptor {
public:
    explicit Descriptor(int fd) : fd_(fd) {}
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int get() const { return fd_; }

private:
    int fd_;
};

std::string read_all(const std::string& path) {
    // Non-blocking, so that a named pipe cannot hang the caller before it is recognised.
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    struct stat info;
    if (file.get() < 0 || ::fstat(file.get(), &info) != 0) io_error(path, errno);
    if (S_ISDIR(info.st_mode)) io_error(path, EISDIR);
    if (!S_ISREG(info.st_mode)) fail(Status::ERROR_IO, "%s: not a regular file", path.c_str());
    if (info.st_size == 0)
        fail(Status::ERROR_FILE, "%s: the file is empty; expected an STL, OBJ or PLY mesh", path.c_str());
    if (info.st_size > max_bytes)
        fail(Status::ERROR_FILE, "%s: %lld bytes; mesh files of up to %lld bytes are supported", path.c_str(),
             static_cast<long long>(info.st_size), max_bytes);
    std::string content(static_cast<std::size_t>(info.st_size), '\0');
    std::size_t have = 0;
    while (have < content.size()) {
        const ssize_t got = ::read(file.get(), content.data() + have, content.size() - have);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) io_error(path, errno);
        if (got == 0) fail(Status::ERROR_IO, "%s: the file became shorter while it was read", path.c_str());
        have += static_cast<std::size_t>(got);
    }
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

// Triangles of all meshes of a scene, one after the other. STL, OBJ and PLY carry no transformations.
TriangleMesh merge(const aiScene& scene, const std::string& path) {
    TriangleMesh mesh;
    for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
        const aiMesh& part = *scene.mMeshes[m];
        const int base = static_cast<int>(mesh.vertices.size());
        for (unsigned i = 0; i < part.mNumVertices; ++i) {
            const aiVector3D& v = part.mVertices[i];
            if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
                fail(Status::ERROR_FILE, "%s: vertex %u of part %u is (%g, %g, %g); expected finite numbers",
                     path.c_str(), i, m, static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z));
            mesh.vertices.push_back({v.x, v.y, v.z});
        }
        for (unsigned f = 0; f < part.mNumFaces; ++f) {
            const aiFace& face = part.mFaces[f];
            if (face.mNumIndices != 3) continue;  // points and lines
            std::array<int, 3> t{};
            for (unsigned p = 0; p < 3; ++p) {
                if (face.mIndices[p] >= part.mNumVertices)
                    fail(Status::ERROR_FILE, "%s: face %u of part %u refers to vertex %u of %u", path.c_str(), f, m,
                         face.mIndices[p], part.mNumVertices);
                t[p] = base + static_cast<int>(face.mIndices[p]);
            }
            mesh.triangles.push_back(t);
        }
    }
    return mesh;
}

// Only checked content arrives here; what Assimp may still throw becomes an ERROR_FILE.
TriangleMesh import(const std::string& content, const std::string& extension, const std::string& path) {
    std::string reason;
    try {
        Assimp::Importer importer;
        const aiScene* scene =
            importer.ReadFileFromMemory(content.data(), content.size(), aiProcess_Triangulate, extension.c_str());
        if (scene) return merge(*scene, path);
        reason = importer.GetErrorString();
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        reason = e.what();
    } catch (...) {
        reason = "unknown exception";
    }
    // Assimp's reasons may quote the rest of the file.
    fail(Status::ERROR_FILE, "%s: not readable as %s: %.200s", path.c_str(), extension.c_str(), reason.c_str());
}

}  // namespace

TriangleMesh read_mesh_file(const std::string& path) {
    const std::string extension = extension_of(path);
    std::string content = read_all(path);
    std::int64_t faces = 0;
    if (extension == "stl") {
        faces = precheck_stl(content, path);
    } else if (extension == "obj") {
        // A backslash joins lines; with blanks in its place all readers agree on that.
        for (std::size_t i = 0; (i = content.find('\\', i)) != std::string::npos; ++i) {
            const std::size_t end = content.compare(i + 1, 1, "\r") == 0 ? i + 2 : i + 1;
            if (end < content.size() && content[end] == '\n') content.replace(i, end + 1 - i, end + 1 - i, ' ');
        }
        faces = precheck_obj(content, path);
    } else if (extension == "ply") {
        faces = precheck_ply(content, path);
    } else {
        fail(Status::ERROR_FILE, "%s: the extension is '%s'; expected stl, obj or ply", path.c_str(),
             extension.c_str());
    }
    TriangleMesh mesh = import(content, extension, path);
    if (static_cast<std::int64_t>(mesh.triangles.size()) < faces)
        fail(Status::ERROR_FILE, "%s: only %zu triangles could be read of %lld faces in the file", path.c_str(),
             mesh.triangles.size(), static_cast<long long>(faces));
    return mesh;
}

#endif

}  // namespace dqa
