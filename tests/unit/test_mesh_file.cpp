// SPDX-License-Identifier: MIT
// Mesh files: the formats that are read, what damaged ones answer, and the two animals of the paper's experiment from
// the folder DQA_TEST_DATA (skipped when it is not set).
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <limits>

#include "shape/mesh_file.hpp"
#include "shape/voxelize.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;

#ifdef DQA_HAVE_ASSIMP
// ---------------------------------------------------------------- files

class Folder {
public:
    Folder() {
        const char* base = std::getenv("TMPDIR");
        path_ = std::string(base && *base ? base : "/tmp") + "/dqa_geometry_XXXXXX";
        if (!mkdtemp(path_.data())) throw std::runtime_error("mkdtemp failed");
    }
    ~Folder() {
        for (const std::string& f : files_) ::unlink(f.c_str());
        ::rmdir(path_.c_str());
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    const std::string& path() const { return path_; }
    std::string write(const std::string& name, const std::string& content) {
        const std::string file = path_ + "/" + name;
        std::ofstream(file, std::ios::binary) << content;
        files_.push_back(file);
        return file;
    }

private:
    std::string path_;
    std::vector<std::string> files_;
};

template <class T>
std::string bytes(T value) {
    std::string s(sizeof(T), '\0');
    std::memcpy(s.data(), &value, sizeof(T));
    return s;
}

std::string binary_stl(const TriangleMesh& m, std::uint32_t count) {
    std::string s(80, ' ');
    s.replace(0, 5, "solid");  // as some programs do even in binary files
    s += bytes(count);
    for (const auto& t : m.triangles) {
        s += std::string(12, '\0');
        for (const int i : t)
            for (const double x : m.vertices[static_cast<std::size_t>(i)]) s += bytes(static_cast<float>(x));
        s += std::string(2, '\0');
    }
    return s;
}

std::string ascii_stl(const TriangleMesh& m) {
    std::string s = "solid a vertex in the name\n";
    for (const auto& t : m.triangles) {
        s += "  facet normal 0 0 0\n    outer loop\n";
        for (const int i : t) {
            const Vec3& v = m.vertices[static_cast<std::size_t>(i)];
            s += format("      vertex %.9g %.9g %.9g\n", v[0], v[1], v[2]);
        }
        s += "    endloop\n  endfacet\n";
    }
    return s + "endsolid a vertex in the name\n";
}

std::string obj(const TriangleMesh& m) {
    std::string s = "# comment\nmtllib missing.mtl\no part\n";
    for (const Vec3& v : m.vertices) s += format("v %.9g %.9g %.9g\n", v[0], v[1], v[2]);
    for (const auto& t : m.triangles) s += format("f %d %d \\\n %d\n", t[0] + 1, t[1] + 1, t[2] + 1);
    return s;
}

std::string ply(const TriangleMesh& m, bool binary) {
    std::string s = format(
        "ply\nformat %s 1.0\ncomment made by a test\nelement vertex %zu\nproperty float x\nproperty float y\n"
        "property float z\nelement face %zu\nproperty list uchar int vertex_indices\nend_header\n",
        binary ? "binary_little_endian" : "ascii", m.vertices.size(), m.triangles.size());
    for (const Vec3& v : m.vertices) {
        if (!binary) s += format("%.9g %.9g %.9g\n", v[0], v[1], v[2]);
        for (const double x : v)
            if (binary) s += bytes(static_cast<float>(x));
    }
    for (const auto& t : m.triangles) {
        if (!binary) s += format("3 %d %d %d\n", t[0], t[1], t[2]);
        if (binary) s += bytes(std::uint8_t{3}) + bytes(t[0]) + bytes(t[1]) + bytes(t[2]);
    }
    return s;
}

void test_good_files() {
    Folder folder;
    const TriangleMesh cube = cuboid({-1.5, 0, 0.25}, {3, 1, 2});
    const std::string files[] = {
        folder.write("binary.stl", binary_stl(cube, 12)),
        folder.write("ascii.STL", ascii_stl(cube)),
        folder.write("cube.obj", obj(cube)),
        folder.write("ascii.ply", ply(cube, false)),
        folder.write("binary.Ply", ply(cube, true)),
        folder.write("quads.obj",
                     "v 0 0 0\nv 3 0 0\nv 3 2 0\nv 0 2 0\nv 0 0 1\nv 3 0 1\nv 3 2 1\nv 0 2 1\n"
                     "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf -4 -1 -5 -8\nl 1 2\n")};
    for (const std::string& file : files) {
        MeshReport r;
        const TriangleMesh m = clean_and_check(read_mesh_file(file), file, &r);
        CHECK(m.triangles.size() == 12 && m.vertices.size() == 8);
        NEAR(r.volume, 6, 1e-6);
        NEAR(r.length_x, 3, 1e-6);
    }
}

void test_bad_stl() {
    Folder folder;
    const TriangleMesh cube = cuboid({0, 0, 0}, {1, 1, 1});
    const std::string good = binary_stl(cube, 12), text = ascii_stl(cube);
    const auto read = [&](const std::string& content) { return read_mesh_file(folder.write("bad.stl", content)); };
    EXPECT_ERROR(ERROR_FILE, "empty", read(""));
    std::string other = good;
    other.replace(0, 5, "other");
    EXPECT_ERROR(ERROR_FILE, "announces 12 triangles", read(other.substr(0, other.size() - 20)));
    std::string huge = other;
    huge.replace(80, 4, bytes(std::uint32_t{1000000000}));
    EXPECT_ERROR(ERROR_FILE, "announces 1000000000 triangles, so 50000000084 bytes", read(huge));
    EXPECT_ERROR(ERROR_FILE, "no triangles", read(binary_stl({}, 0)));
    EXPECT_ERROR(ERROR_FILE, "not an STL file", read("hello"));
    EXPECT_ERROR(ERROR_FILE, "not an STL file", read(std::string(83, '\0')));
    EXPECT_ERROR(ERROR_FILE, "truncated", read(good.substr(0, good.size() - 20)));  // begins with "solid"
    EXPECT_ERROR(ERROR_FILE, "truncated", read(text.substr(0, text.size() / 2)));
    EXPECT_ERROR(ERROR_FILE, "truncated", read("solid"));
    EXPECT_ERROR(ERROR_FILE, "no triangles", read("solid x\nendsolid x\n"));
    std::string nan = text;
    nan.replace(nan.find("vertex 0"), 8, "vertex nan");
    EXPECT_ERROR(ERROR_FILE, "expected a finite number", read(nan));
    std::string word = text;
    word.replace(word.find("vertex 0"), 8, "vertex 0,5");
    EXPECT_ERROR(ERROR_FILE, "'0,5'", read(word));
    std::string infinite = good;
    infinite.replace(84 + 12, 4, bytes(std::numeric_limits<float>::infinity()));
    EXPECT_ERROR(ERROR_FILE, "triangle 0", read(infinite));
    std::string four = text;
    four.insert(four.find("    endloop"), "vertex 1 2 3\n");
    EXPECT_ERROR(ERROR_FILE, "has 4 vertices", read(four));
}

void test_bad_obj_and_ply() {
    Folder folder;
    const TriangleMesh cube = cuboid({0, 0, 0}, {1, 1, 1});
    const auto as_obj = [&](const std::string& content) { return read_mesh_file(folder.write("bad.obj", content)); };
    const auto as_ply = [&](const std::string& content) { return read_mesh_file(folder.write("bad.ply", content)); };
    EXPECT_ERROR(ERROR_FILE, "no triangles", as_obj("v 0 0 0\nv 1 0 0\n"));
    EXPECT_ERROR(ERROR_FILE, "line 2", as_obj("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n"));
    EXPECT_ERROR(ERROR_FILE, "'4'", as_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"));
    EXPECT_ERROR(ERROR_FILE, "'-4'", as_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n"));
    EXPECT_ERROR(ERROR_FILE, "'0'", as_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n"));
    EXPECT_ERROR(ERROR_FILE, "vt", as_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/9 2/9 3/9\n"));
    EXPECT_ERROR(ERROR_FILE, "face of 2 corners", as_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n"));
    for (const bool binary : {false, true}) {
        const std::string good = ply(cube, binary);
        EXPECT_ERROR(ERROR_FILE, "truncated", as_ply(good.substr(0, good.size() - 9)));
        EXPECT_ERROR(ERROR_FILE, "truncated", as_ply(good.substr(0, good.find("end_header"))));
        std::string huge = good;
        huge.replace(huge.find("vertex 8"), 8, "vertex 4000000000");
        EXPECT_ERROR(ERROR_FILE, "announces 4000000000", as_ply(huge));
        std::string faces = good;
        faces.replace(faces.find("face 12"), 7, "face 0");
        EXPECT_ERROR(ERROR_FILE, "no triangles", as_ply(faces));
    }
    std::string index = ply(cube, false);
    index.replace(index.find("3 0 1 3"), 7, "3 0 1 8");
    EXPECT_ERROR(ERROR_FILE, "refers to vertex 8", as_ply(index));
    std::string list = ply(cube, true);
    list[list.find("end_header\n") + 11 + 8 * 12] = '\xff';  // the first face claims 255 corners
    EXPECT_ERROR(ERROR_FILE, "", as_ply(list));
    EXPECT_ERROR(ERROR_FILE, "not a PLY", as_ply("hello"));
    EXPECT_ERROR(ERROR_FILE, "line 2", as_ply("ply\nformat strange 1.0\nend_header\n"));
    EXPECT_ERROR(ERROR_FILE, "face", as_ply("ply\nformat ascii 1.0\nelement face 9999999\nend_header\n1\n"));
}

void test_bad_paths() {
    Folder folder;
    EXPECT_ERROR(ERROR_IO, "No such file", read_mesh_file(folder.path() + "/missing.stl"));
    EXPECT_ERROR(ERROR_IO, "Is a directory", read_mesh_file(folder.path()));
    EXPECT_ERROR(ERROR_IO, "", read_mesh_file(""));
    EXPECT_ERROR(ERROR_IO, "not a regular file", read_mesh_file("/dev/null"));
    EXPECT_ERROR(ERROR_FILE, "'gltf'", read_mesh_file(folder.write("mesh.gltf", "{}")));
    EXPECT_ERROR(ERROR_FILE, "extension is ''", read_mesh_file(folder.write("stl", "solid")));
    if (::geteuid() != 0) {
        const std::string locked = folder.write("locked.stl", "solid");
        ::chmod(locked.c_str(), 0);
        EXPECT_ERROR(ERROR_IO, "Permission denied", read_mesh_file(locked));
    }
}

// Every prefix of a file, and every byte of it changed: an answer or an Error, never anything else.
void test_damaged_files() {
    Folder folder;
    const TriangleMesh cube = cuboid({0, 0, 0}, {1, 1, 1});
    const std::pair<const char*, std::string> good[] = {{"damaged.stl", binary_stl(cube, 12)},
                                                        {"damaged.stl", ascii_stl(cube)},
                                                        {"damaged.obj", obj(cube)},
                                                        {"damaged.ply", ply(cube, false)},
                                                        {"damaged.ply", ply(cube, true)}};
    const auto survive = [&](const char* name, const std::string& content) {
        try {
            clean_and_check(read_mesh_file(folder.write(name, content)), name, nullptr);
        } catch (const Error& e) {
            CHECK(e.status() == Status::ERROR_FILE || e.status() == Status::ERROR_MESH);
        }
    };
    std::uint32_t state = 7;
    for (const auto& [name, content] : good)
        for (std::size_t at = 0; at < content.size(); at += 3) {
            survive(name, content.substr(0, at));
            std::string changed = content;
            state = state * 1664525u + 1013904223u;
            changed[at] = static_cast<char>(state >> 24);
            survive(name, changed);
        }
}

// ---------------------------------------------------------------- real meshes

void test_real_meshes() {
    const char* folder = std::getenv("DQA_TEST_DATA");
    if (!folder || !*folder) {
        print_message("DQA_TEST_DATA is not set: the meshes of the Orca and the Great White Shark are not tested\n");
        throw Skipped{};
    }
    for (const char* name : {"Orca", "GreatWhiteShark"}) {
        MeshReport r;
        TriangleMesh m = clean_and_check(read_mesh_file(std::string(folder) + "/" + name + ".stl"), name, &r);
        CHECK(r.components == 1 && r.genus == 0 && r.non_manifold_edges == 0);
        const TriangleMesh before = m;
        orient_up(m, UP_AUTO);  // both files have y up
        for (std::size_t i = 0; i < m.vertices.size(); ++i) {
            const Vec3& v = before.vertices[i];
            CHECK((m.vertices[i] == Vec3{v[0], -v[2], v[1]}));
        }
        const TriangleMesh turned = m;
        orient_up(m, UP_AUTO);
        CHECK(m.vertices == turned.vertices);
        const Box box{{60, 16, 26}, 1.0};
        double length = 0;
        const auto f = covered_fractions(m, box, 2, 2, &length);
        const double scale = length / r.length_x;
        NEAR(sum(f) / (r.volume * scale * scale * scale), 1, 0.01);
        NEAR(largest_difference(f, mirrored(box, f, 1)), 0, 0.05);  // the meshes themselves mirror to a few 1e-3
        CHECK(surface_report(box, f, 0.5).volume > 0.9 * sum(f));
    }
}
#else

void test_without_assimp() {
    EXPECT_ERROR(ERROR_UNSUPPORTED, "DQA_WITH_ASSIMP", read_mesh_file("any.stl"));
}
#endif

}  // namespace

int main() {
    const CMUnitTest tests[] = {
#ifdef DQA_HAVE_ASSIMP
        TEST(test_good_files), TEST(test_bad_stl),       TEST(test_bad_obj_and_ply),
        TEST(test_bad_paths),  TEST(test_damaged_files), TEST(test_real_meshes),
#else
        TEST(test_without_assimp),
#endif
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
