// SPDX-License-Identifier: MIT
// Mesh files: the formats that are read, what damaged ones answer, and the two animals of the paper's experiment from
// the folder DQA_TEST_DATA (skipped when it is not set).
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <limits>

#include "shape/mesh_file.hpp"
#include "shape/mesh_readers.hpp"
#include "shape/voxelize.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;

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

// ---------------------------------------------------------------- what is clear is read

TriangleMesh read_as(const char* extension, const std::string& content) {
    const MeshSource source{content, std::string("mesh.") + extension};
    return extension[0] == 's' ? read_stl(source) : extension[0] == 'o' ? read_obj(source) : read_ply(source);
}

double volume_as(const char* extension, const std::string& content) {
    return mesh_volume(clean_and_check(read_as(extension, content), extension, nullptr));
}

std::string replaced(std::string s, const std::string& from, const std::string& to) {
    for (std::size_t i = 0; (i = s.find(from, i)) != std::string::npos; i += to.size()) s.replace(i, from.size(), to);
    return s;
}

template <class T>
std::string ordered(T value, bool big) {
    std::string s = bytes(value);
    if (big) std::reverse(s.begin(), s.end());
    return s;
}

// With x, y, z as `type` (a name and a number of bytes), properties and elements around them that are not wanted, and
// the faces before the vertices.
std::string rich_ply(const TriangleMesh& m, bool big, bool doubles) {
    std::string s = format(
        "ply\nformat binary_%s_endian 1.0\nelement camera 2\nproperty short id\nproperty list ushort double poses\n"
        "element face %zu\nproperty uint8 flags\nproperty list uint8 uint32 vertex_index\nproperty list int8 float uv\n"
        "element vertex %zu\nproperty uchar red\nproperty %s z\nproperty %s x\nproperty int16 group\nproperty %s y\n"
        "element edge 1\nproperty int a\nproperty int b\nend_header\n",
        big ? "big" : "little", m.triangles.size(), m.vertices.size(), doubles ? "float64" : "float",
        doubles ? "double" : "float", doubles ? "double" : "float32");
    for (int k = 0; k < 2; ++k) {
        s += ordered(std::int16_t{-3}, big) + ordered(std::uint16_t{2}, big);
        s += ordered(1.5, big) + ordered(-2.5, big);
    }
    for (const auto& t : m.triangles) {
        s += '\x0a' + bytes(std::uint8_t{3});
        for (const int i : t) s += ordered(static_cast<std::uint32_t>(i), big);
        s += bytes(std::int8_t{1}) + ordered(0.25f, big);
    }
    const auto coordinate = [&](double x) { return doubles ? ordered(x, big) : ordered(static_cast<float>(x), big); };
    for (const Vec3& v : m.vertices)
        s += '\xff' + coordinate(v[2]) + coordinate(v[0]) + ordered(std::int16_t{7}, big) + coordinate(v[1]);
    return s + ordered(std::int32_t{0}, big) + ordered(std::int32_t{1}, big);
}

// A tetrahedron far from the origin, whose coordinates no float holds.
TriangleMesh far_tetrahedron() {
    TriangleMesh m;
    m.vertices = {{1024199.6000000001, 6280752.7999999998, 0.90000000000000002},
                  {1024199.7, 6280752.8000000007, 0.9},
                  {1024199.6, 6280752.9123456789, 0.9},
                  {1024199.6, 6280752.8, 1.0123456789012345}};
    m.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    return m;
}

// The same vertices and triangles from every format, to the last bit where the format holds doubles.
void test_same_doubles() {
    const TriangleMesh m = far_tetrahedron();
    std::string text_obj,
        text_ply = format(
            "ply\nformat ascii 1.0\nelement vertex %zu\nproperty double x\nproperty "
            "double y\nproperty double z\nelement face %zu\nproperty list uchar int "
            "vertex_indices\nend_header\n",
            m.vertices.size(), m.triangles.size()),
        text_stl = "solid far\n";
    for (const Vec3& v : m.vertices) {
        const std::string numbers = format("%.17g %.17g %.17g", v[0], v[1], v[2]);
        text_obj += "v " + numbers + "\n", text_ply += numbers + "\n";
    }
    for (const auto& t : m.triangles) {
        text_obj += format("f %d %d %d\n", t[0] + 1, t[1] + 1, t[2] + 1);
        text_ply += format("3 %d %d %d\n", t[0], t[1], t[2]);
        text_stl += "facet normal nan nan nan\nouter loop\n";
        for (const int i : t) {
            const Vec3& v = m.vertices[static_cast<std::size_t>(i)];
            text_stl += format("vertex %.17g %.17g %.17g\n", v[0], v[1], v[2]);
        }
        text_stl += "endloop\nendfacet\n";
    }
    for (const bool big : {false, true}) {
        const TriangleMesh got = read_as("ply", rich_ply(m, big, true));
        CHECK(got.vertices == m.vertices && got.triangles == m.triangles);
        const TriangleMesh floats = read_as("ply", rich_ply(cuboid({0, 0, 0}, {2, 1, 1}), big, false));
        CHECK(floats.vertices == cuboid({0, 0, 0}, {2, 1, 1}).vertices);
    }
    const TriangleMesh o = read_as("obj", text_obj), p = read_as("ply", text_ply),
                       l = clean_and_check(read_as("stl", text_stl + "endsolid far\n"), "far", nullptr);
    CHECK(o.vertices == m.vertices && o.triangles == m.triangles);
    CHECK(p.vertices == m.vertices && p.triangles == m.triangles);
    CHECK(l.vertices.size() == 4 && l.triangles.size() == 4);
    NEAR(mesh_volume(l), mesh_volume(m), 1e-12 * mesh_volume(m));
}

void test_tolerant_stl() {
    const TriangleMesh cube = cuboid({0, 0, 0}, {3, 1, 2});
    const std::string text = ascii_stl(cube), binary = binary_stl(cube, 12);
    std::string capitals = text;
    for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    std::string one_line = replaced(text, "\n", " ");
    const std::string good[] = {
        " " + text,
        "\n\r\n\t" + text,
        "\xef\xbb\xbf" + text,
        capitals,
        replaced(text, "\n", "\r\n"),
        replaced(text, "\n", "\r"),
        one_line,
        replaced(text, "normal 0 0 0", "normal -nan(ind) -1.#IND 1.#QNAN"),
        replaced(text, "normal 0 0 0", "normal nan nan nan"),
        replaced(text, "    outer loop", "outer\tloop"),
        replaced(text, "facet normal 0 0 0", "facet"),
        replaced(replaced(text, "vertex 3", "vertex +3."), " 1 ", " 1.e0 "),
        text.substr(0, text.find("endsolid")),  // no end
        replaced(text, "endsolid a vertex in the name", "endsolid other\n\n\n"),
        text.substr(0, text.size() - 1),
        binary,
        binary + "further",  // bytes after the last triangle
    };
    for (const std::string& s : good) NEAR(volume_as("stl", s), 6, 1e-6);
    // Two solids in one file.
    NEAR(volume_as("stl", text + ascii_stl(cuboid({9, 9, 9}, {1, 1, 1}))), 7, 1e-6);
    // Whole triangles beyond the announced ones are no accident.
    EXPECT_ERROR(ERROR_FILE, "announces 11 triangles", read_as("stl", binary_stl(cube, 11)));
}

void test_tolerant_obj() {
    const TriangleMesh cube = cuboid({0, 0, 0}, {3, 1, 2});
    const std::string plain = replaced(obj(cube), "\\\n", "");
    const auto each_face = [&](const char* after) {  // every corner i becomes i and this
        std::string s = plain.substr(0, plain.find("f "));
        for (const auto& t : cube.triangles)
            s += format("f %d%s %d%s %d%s\n", t[0] + 1, after, t[1] + 1, after, t[2] + 1, after);
        return s;
    };
    const std::string good[] = {
        obj(cube),
        replaced(plain, "\n", "\r\n"),
        replaced(plain, "\n", "\r"),
        replaced(plain, "\n", "  # a comment with f 1 2 99\n"),
        replaced(plain, "v 3 ", "v 3.0e+00 "),
        replaced(plain, "v 0 ", "v .0 "),
        replaced(plain, "v 0 ", "v -0. "),
        replaced(plain, "v 3 ", "v 3e0 "),
        replaced(plain, "v ", "v\t "),
        each_face("/9/9"),
        each_face("//1"),
        each_face("/"),
        each_face("/x"),
        replaced(plain, "f ", "f   "),
        "mtllib nothing.mtl\nusemtl\nvn nan nan nan\nvt x\ncurv 0 1 2\n" + plain + "l 1 999\np 5000\n",
        plain.substr(plain.find("f ")) + plain.substr(0, plain.find("f ")),  // faces before vertices
    };
    for (const std::string& s : good) NEAR(volume_as("obj", s), 6, 1e-6);
    const std::string colours = replaced(plain, "v 0 0 0\n", "v 0 0 0 1 0.5 0.5 0.5\n");
    NEAR(volume_as("obj", colours), 6, 1e-6);
}

void test_tolerant_ply() {
    const TriangleMesh cube = cuboid({0, 0, 0}, {3, 1, 2});
    const std::string text = ply(cube, false), binary = ply(cube, true);
    const std::size_t body = text.find("end_header\n") + 11;
    const std::string header = text.substr(0, body), rows = text.substr(body);
    std::size_t faces = 0;
    for (int k = 0; k < 8; ++k) faces = rows.find('\n', faces) + 1;
    const std::string good[] = {
        replaced(text, "\n", "\r\n"),
        replaced(text, "\n", "\r"),
        header + replaced(rows, "\n", " 255 0 7\n"),  // further columns
        header + replaced(rows, "\n", " "),           // rows not on lines of their own
        header + replaced(rows, " ", "\n"),
        replaced(text, "end_header", "END_HEADER  "),
        replaced(text, "property float x", "property FLOAT32 X"),
        replaced(header, "element face",
                 "obj_info by hand\nelement user 1\nproperty list uchar float values\nelement face") +
            rows.substr(0, faces) + "0\n" + rows.substr(faces),
        binary,
        binary + "further",
    };
    for (const std::string& s : good) NEAR(volume_as("ply", s), 6, 1e-6);
    // A header with CR LF before data that begin with a byte of either.
    for (const char* mark : {"\n", "\r\n", "\r"}) {
        std::string s = replaced(binary.substr(0, binary.find("end_header\n") + 11), "\n", mark);
        TriangleMesh shifted = cube;
        const float first = std::bit_cast<float>(std::uint32_t{0x3f000a0a});  // 0.5: its bytes are 0a 0a 00 3f
        shifted.vertices[0][0] = static_cast<double>(first);
        s += ply(shifted, true).substr(binary.find("end_header\n") + 11);
        CHECK(read_as("ply", s).vertices[0][0] == static_cast<double>(first));
    }
    EXPECT_ERROR(ERROR_FILE, "properties x, y and z",
                 read_as("ply", replaced(text, "property float z", "property float w")));
}

// A concave polygon, an L with its step up; a fan from its first corner would fold.
void test_polygons() {
    const double x[] = {0, 2, 2, 1, 1, 0}, y[] = {0, 0, 1, 1, 2, 2};
    for (int first = 0; first < 6; ++first) {
        std::string s = "";
        for (int z = 0; z < 2; ++z)
            for (int k = 0; k < 6; ++k) s += format("v %g %g %d\n", x[k], y[k], z);
        std::string bottom = "f", top = "f";
        for (int k = 0; k < 6; ++k) {
            bottom += format(" %d", 1 + (first + 5 - k) % 6);
            top += format(" %d", 7 + (first + k) % 6);
        }
        s += bottom + "\n" + top + "\n";
        for (int k = 0; k < 6; ++k) s += format("f %d %d %d %d\n", k + 1, (k + 1) % 6 + 1, (k + 1) % 6 + 7, k + 7);
        const TriangleMesh m = clean_and_check(read_as("obj", s), "L", nullptr);
        NEAR(mesh_volume(m), 3.0, 1e-12);
        CHECK(m.triangles.size() == 20);
        // No triangle of the caps is turned over, or reaches out of the L.
        double area = 0.0;
        for (const auto& t : m.triangles) {
            const Vec3 &a = m.vertices[static_cast<std::size_t>(t[0])], &b = m.vertices[static_cast<std::size_t>(t[1])],
                       &c = m.vertices[static_cast<std::size_t>(t[2])];
            if (a[2] == 1.0 && b[2] == 1.0 && c[2] == 1.0)
                area += std::fabs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0;
        }
        NEAR(area, 3.0, 1e-12);
    }
    // A polygon of very many corners: linear, and closed.
    std::string many, rim = "f", back = "f";
    const int n = 20000;
    for (int k = 0; k < 2 * n; ++k) {
        const double angle = 6.283185307179586 * (k % n) / n, r = k % 2 ? 1.0 : 0.9;
        many += format("v %.17g %.17g %d\n", r * std::cos(angle), r * std::sin(angle), k / n);
    }
    for (int k = 0; k < n; ++k) {
        rim += format(" %d", n + 1 + k), back += format(" %d", n - k);
        many += format("f %d %d %d %d\n", k + 1, (k + 1) % n + 1, (k + 1) % n + n + 1, k + n + 1);
    }
    NEAR(volume_as("obj", many + rim + "\n" + back + "\n"), 0.5 * n * 0.9 * std::sin(6.283185307179586 / n), 1e-9);
}

void test_strips() {
    // A tetrahedron as one strip and, after -1, as separate pieces.
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement "
        "tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
    NEAR(std::fabs(volume_as("ply", header + "6 0 1 2 3 0 1\n")), 1.0 / 6.0, 1e-12);
    NEAR(std::fabs(volume_as("ply", header + "15 0 2 1 -1 0 1 3 -1 1 2 3 -1 2 0 3\n")), 1.0 / 6.0, 1e-12);
    EXPECT_ERROR(ERROR_FILE, "tristrips 0 refers to vertex 4", read_as("ply", header + "6 0 1 2 4 0 1\n"));
    EXPECT_ERROR(ERROR_FILE, "refers to vertex -2", read_as("ply", header + "6 0 1 -2 3 0 1\n"));
}

// Corners that differ in the seventh digit are one; in the fifth they are not.
void test_seams() {
    const TriangleMesh cube = cuboid({0, 0, 0}, {3, 1, 2});
    for (const double size : {1e-7, 1e-5}) {
        std::string s = "solid\n";
        std::uint32_t state = 1;
        for (const auto& t : cube.triangles) {
            s += "facet normal 0 0 0\nouter loop\n";
            for (const int i : t) {
                s += "vertex";
                for (const double x : cube.vertices[static_cast<std::size_t>(i)]) {
                    state = state * 1664525u + 1013904223u;
                    s += format(" %.12g", x + 3.0 * size * (static_cast<double>(state >> 8) / 8388608.0 - 1.0));
                }
                s += "\n";
            }
            s += "endloop\nendfacet\n";
        }
        s += "endsolid\n";
        if (size < 1e-6) {
            MeshReport r;
            const TriangleMesh m = clean_and_check(read_as("stl", s), "noisy", &r);
            CHECK(m.vertices.size() == 8 && m.triangles.size() == 12);
            NEAR(r.volume, 6, 1e-5);
        } else {
            EXPECT_ERROR(ERROR_MESH, "is open", clean_and_check(read_as("stl", s), "noisy", nullptr));
        }
    }
}

// Reading can be stopped from within.
void test_poll() {
    std::string big = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (int k = 0; k < 100000; ++k) big += "f 1 2 3\n";
    int calls = 0;
    const MeshSource source{big, "big.obj", [&] {
                                if (++calls == 3) throw Error(Status::CANCELLED, "stopped");
                            }};
    EXPECT_ERROR(CANCELLED, "stopped", read_obj(source));
    CHECK(calls == 3);
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
    const std::size_t middle = text.find("  facet", text.size() / 2);
    EXPECT_ERROR(ERROR_FILE, "truncated", read(text.substr(0, middle + 60)));
    EXPECT_ERROR(ERROR_FILE, "vertex coordinate",
                 read(text.substr(0, text.find("vertex", middle) + 7) + "1 2\nendloop"));
    EXPECT_ERROR(ERROR_MESH, "is open", clean_and_check(read(text.substr(0, middle)), "half", nullptr));
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
    EXPECT_ERROR(ERROR_FILE, "line 4: 'x/1'", as_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x/1\n"));
    EXPECT_ERROR(ERROR_FILE, "'99999999999'", as_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999\n"));
    EXPECT_ERROR(ERROR_FILE, "coordinate 3 is ''", as_obj("v 0 0\nf 1 1 1\n"));
    EXPECT_ERROR(ERROR_FILE, "coordinate 2 is '1e999'", as_obj("v 0 1e999 0\nf 1 1 1\n"));
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
    const TriangleMesh cube = cuboid({0, 0, 0}, {1, 1, 1});
    const std::pair<const char*, std::string> good[] = {{"damaged.stl", binary_stl(cube, 12)},
                                                        {"damaged.stl", ascii_stl(cube)},
                                                        {"damaged.obj", obj(cube)},
                                                        {"damaged.ply", ply(cube, false)},
                                                        {"damaged.ply", ply(cube, true)},
                                                        {"damaged.ply", rich_ply(cube, true, true)}};
    const auto survive = [&](const char* name, const std::string& content) {
        try {
            clean_and_check(read_as(name + 8, content), name, nullptr);
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

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_good_files),    TEST(test_same_doubles),    TEST(test_tolerant_stl), TEST(test_tolerant_obj),
        TEST(test_tolerant_ply),  TEST(test_polygons),        TEST(test_strips),       TEST(test_seams),
        TEST(test_bad_stl),       TEST(test_bad_obj_and_ply), TEST(test_bad_paths),    TEST(test_poll),
        TEST(test_damaged_files), TEST(test_real_meshes),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
