// SPDX-License-Identifier: MIT
// Walks STL, OBJ and PLY content once without building anything; memory use does not depend on what a header claims.
// Numbers are read by from_chars: no locale.
#include "shape/mesh_precheck.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>
#include <vector>

#include "grid/error.hpp"

namespace dqa {
namespace {

using std::string_view;

constexpr string_view blanks = " \t\r\v\f";

struct Lines {
    string_view rest;
    std::int64_t number = 0;
    bool next(string_view& line) {
        if (rest.empty()) return false;
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        line = rest.substr(0, end);
        rest.remove_prefix(std::min(end + 1, rest.size()));
        ++number;
        return true;
    }
};

// Takes the next word off `text`; empty at the end.
string_view word(string_view& text, string_view separators = blanks) {
    const std::size_t begin = std::min(text.find_first_not_of(separators), text.size());
    text.remove_prefix(begin);
    const std::size_t end = std::min(text.find_first_of(separators), text.size());
    const string_view w = text.substr(0, end);
    text.remove_prefix(end);
    return w;
}

template <class T>
bool parse(string_view w, T& value) {
    if (!w.empty() && w[0] == '+') w.remove_prefix(1);
    const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), value);
    return error == std::errc() && end == w.data() + w.size();
}

// A bounded piece of a file for a message.
std::string shown(string_view w) {
    std::string s(w.substr(0, 40));
    for (char& c : s)
        if (c < 32 || c > 126) c = '?';
    return w.size() > 40 ? s + "..." : s;
}

// Three numbers at the start of `rest`; `what` names them.
void three_numbers(string_view rest, const char* what, bool finite, std::int64_t line, const char* path) {
    for (int a = 0; a < 3; ++a) {
        const string_view w = word(rest);
        double x = 0.0;
        if (!parse(w, x) || (finite && !std::isfinite(x)))
            fail(Status::ERROR_FILE, "%s: line %lld: %s %d is '%s'; expected a finite number", path,
                 static_cast<long long>(line), what, a + 1, shown(w).c_str());
    }
}

[[noreturn]] void unexpected_line(string_view line, std::int64_t number, const char* path) {
    fail(Status::ERROR_FILE, "%s: line %lld of the ASCII STL file is not understood: '%s'", path,
         static_cast<long long>(number), shown(line).c_str());
}

std::int64_t ascii_stl(const std::string& content, const char* path) {
    Lines lines{content};
    string_view line;
    std::int64_t facets = 0, corners = 3;
    bool ended = false;
    while (lines.next(line)) {
        string_view rest = line;
        const string_view w = word(rest);
        if (w == "vertex") {
            three_numbers(rest, "vertex coordinate", true, lines.number, path);
            ++corners;
        } else if (w == "facet" || w == "endsolid") {
            if (corners != 3)
                fail(Status::ERROR_FILE, "%s: line %lld: the facet before has %lld vertices; expected 3", path,
                     static_cast<long long>(lines.number), static_cast<long long>(corners));
            ended = w == "endsolid";
            if (ended) continue;
            ++facets, corners = 0;
            // The normal is not used, and some programs write nan for that of a degenerate triangle.
            if (word(rest) != "normal") unexpected_line(line, lines.number, path);
            three_numbers(rest, "normal component", false, lines.number, path);
        } else if (!w.empty() && w != "outer" && w != "endloop" && w != "endfacet" && w != "solid") {
            unexpected_line(line, lines.number, path);
        }
    }
    if (!ended)
        fail(Status::ERROR_FILE,
             "%s: the ASCII STL file is truncated: expected 'endsolid' at the end, after %lld facets", path,
             static_cast<long long>(facets));
    if (facets == 0) fail(Status::ERROR_FILE, "%s: no triangles in the ASCII STL file; expected at least one", path);
    return facets;
}

// ---------------------------------------------------------------- PLY

struct Property {
    bool is_list = false;
    int count_type = 0, type = 0;  // index into ply_types
    string_view name;
};
struct Element {
    string_view name;
    std::int64_t count = 0;
    std::vector<Property> properties;
};

struct PlyType {
    const char *name, *other;
    int bytes;
    char kind;  // i signed, u unsigned, f floating point
};
constexpr PlyType ply_types[] = {{"char", "int8", 1, 'i'},     {"uchar", "uint8", 1, 'u'},   {"short", "int16", 2, 'i'},
                                 {"ushort", "uint16", 2, 'u'}, {"int", "int32", 4, 'i'},     {"uint", "uint32", 4, 'u'},
                                 {"float", "float32", 4, 'f'}, {"double", "float64", 8, 'f'}};

int ply_type(string_view w) {
    for (int t = 0; t < 8; ++t)
        if (w == ply_types[t].name || w == ply_types[t].other) return t;
    return -1;
}

template <class T>
T from_bytes(const char* bytes, bool swap) {
    char b[sizeof(T)];
    std::memcpy(b, bytes, sizeof(T));
    if (swap) std::reverse(b, b + sizeof(T));
    T value;
    std::memcpy(&value, b, sizeof(T));
    return value;
}

// Reads the body of a PLY file value by value, as text or as bytes.
struct PlyBody {
    string_view rest;
    bool ascii = true, swap = false;
    const char* path = "";

    double next(int type, const Element& e, std::int64_t row) {
        const PlyType& t = ply_types[type];
        double value = 0.0;
        if (ascii) {
            const string_view w = word(rest, " \t\r\v\f\n");
            if (w.empty()) truncated(e, row);
            if (!parse(w, value))
                fail(Status::ERROR_FILE, "%s: %.*s %lld holds '%s'; expected a number", path,
                     static_cast<int>(e.name.size()), e.name.data(), static_cast<long long>(row), shown(w).c_str());
            return value;
        }
        const std::size_t bytes = static_cast<std::size_t>(t.bytes);
        if (rest.size() < bytes) truncated(e, row);
        const char* p = rest.data();
        switch (t.kind == 'f' ? 10 + t.bytes : t.kind == 'u' ? 20 + t.bytes : t.bytes) {
            case 1:
                value = from_bytes<std::int8_t>(p, swap);
                break;
            case 2:
                value = from_bytes<std::int16_t>(p, swap);
                break;
            case 4:
                value = from_bytes<std::int32_t>(p, swap);
                break;
            case 14:
                value = static_cast<double>(from_bytes<float>(p, swap));
                break;
            case 18:
                value = from_bytes<double>(p, swap);
                break;
            case 21:
                value = from_bytes<std::uint8_t>(p, swap);
                break;
            case 22:
                value = from_bytes<std::uint16_t>(p, swap);
                break;
            default:
                value = from_bytes<std::uint32_t>(p, swap);
                break;
        }
        rest.remove_prefix(bytes);
        return value;
    }

    [[noreturn]] void truncated(const Element& e, std::int64_t row) const {
        fail(Status::ERROR_FILE, "%s: the PLY file is truncated: it ends in %.*s %lld of %lld", path,
             static_cast<int>(e.name.size()), e.name.data(), static_cast<long long>(row),
             static_cast<long long>(e.count));
    }
};

std::vector<Element> ply_header(Lines& lines, PlyBody& body) {
    std::vector<Element> elements;
    string_view line;
    bool have_format = false;
    while (lines.next(line)) {
        string_view rest = line;
        const string_view w = word(rest);
        const auto bad = [&] {
            fail(Status::ERROR_FILE, "%s: line %lld of the PLY header is not understood: '%s'", body.path,
                 static_cast<long long>(lines.number), shown(line).c_str());
        };
        if (w == "format") {
            const string_view kind = word(rest);
            if (kind != "ascii" && kind != "binary_little_endian" && kind != "binary_big_endian") bad();
            body.ascii = kind == "ascii";
            body.swap = !body.ascii && (kind == "binary_big_endian") != (std::endian::native == std::endian::big);
            have_format = true;
        } else if (w == "element") {
            Element e;
            e.name = word(rest);
            if (!parse(word(rest), e.count) || e.count < 0) bad();
            elements.push_back(e);
        } else if (w == "property") {
            Property p;
            string_view type = word(rest);
            p.is_list = type == "list";
            if (p.is_list) {
                p.count_type = ply_type(word(rest));
                type = word(rest);
            }
            p.type = ply_type(type);
            p.name = word(rest);
            if (p.type < 0 || p.count_type < 0 || ply_types[p.count_type].kind == 'f' || elements.empty()) bad();
            elements.back().properties.push_back(p);
        } else if (w == "end_header") {
            if (!have_format) fail(Status::ERROR_FILE, "%s: the PLY header has no 'format' line", body.path);
            return elements;
        } else if (!w.empty() && w != "ply" && w != "comment" && w != "obj_info") {
            bad();
        }
    }
    fail(Status::ERROR_FILE, "%s: the PLY header is truncated: 'end_header' is missing", body.path);
}

// Values of one row; returns 1 when it is a face of three or more corners.
int ply_row(PlyBody& body, const Element& e, std::int64_t row, std::int64_t vertices) {
    int faces = 0;
    for (const Property& p : e.properties) {
        if (!p.is_list) {
            const double x = body.next(p.type, e, row);
            if (e.name == "vertex" && (p.name == "x" || p.name == "y" || p.name == "z") && !std::isfinite(x))
                fail(Status::ERROR_FILE, "%s: coordinate %.*s of vertex %lld is %g; expected a finite number",
                     body.path, static_cast<int>(p.name.size()), p.name.data(), static_cast<long long>(row), x);
            continue;
        }
        const double count = body.next(p.count_type, e, row);
        const bool is_face = e.name == "face" && (p.name == "vertex_indices" || p.name == "vertex_index");
        if (!(count >= 0.0 && count <= static_cast<double>(body.rest.size()))) body.truncated(e, row);
        for (double c = 0.0; c < count; c += 1.0) {
            const double i = body.next(p.type, e, row);
            if (is_face && !(i >= 0.0 && i < static_cast<double>(vertices) && i == std::floor(i)))
                fail(Status::ERROR_FILE, "%s: face %lld refers to vertex %g; expected an index in [0, %lld)", body.path,
                     static_cast<long long>(row), i, static_cast<long long>(vertices));
        }
        if (is_face && count >= 3.0) faces = 1;
    }
    return faces;
}

}  // namespace

std::int64_t precheck_stl(const std::string& content, const std::string& path) {
    if (content.size() >= 84) {
        const auto* c = reinterpret_cast<const unsigned char*>(content.data() + 80);
        const std::uint64_t count =
            c[0] | std::uint64_t{c[1]} << 8 | std::uint64_t{c[2]} << 16 | std::uint64_t{c[3]} << 24;
        const std::uint64_t expected = 84 + 50 * count;
        if (content.size() == expected) {
            if (count == 0)
                fail(Status::ERROR_FILE, "%s: no triangles in the binary STL file; expected at least one",
                     path.c_str());
            for (std::uint64_t t = 0; t < count; ++t)
                for (std::size_t x = 0; x < 9; ++x) {  // after the normal come three vertices
                    const char* p = content.data() + 84 + 50 * t + 12 + 4 * x;
                    const float value = from_bytes<float>(p, std::endian::native == std::endian::big);
                    if (!std::isfinite(value))
                        fail(Status::ERROR_FILE, "%s: triangle %llu has the coordinate %g; expected finite numbers",
                             path.c_str(), static_cast<unsigned long long>(t), static_cast<double>(value));
                }
            return static_cast<std::int64_t>(count);
        }
        const bool is_text = content.compare(0, 5, "solid") == 0 && content.find('\0') == std::string::npos;
        if (!is_text)
            fail(Status::ERROR_FILE,
                 "%s: the header of the binary STL file announces %llu triangles, so %llu bytes; the file has %llu "
                 "(truncated, or not an STL file)",
                 path.c_str(), static_cast<unsigned long long>(count), static_cast<unsigned long long>(expected),
                 static_cast<unsigned long long>(content.size()));
    }
    if (content.compare(0, 5, "solid") != 0)
        fail(Status::ERROR_FILE,
             "%s: not an STL file: its %zu bytes are too few for a binary one (84 and 50 a triangle), and it does not "
             "begin with 'solid' as an ASCII one",
             path.c_str(), content.size());
    return ascii_stl(content, path.c_str());
}

std::int64_t precheck_obj(const std::string& content, const std::string& path) {
    std::int64_t counts[3] = {0, 0, 0};  // v, vt, vn
    const auto kind_of = [](string_view w) { return w == "v" ? 0 : w == "vt" ? 1 : w == "vn" ? 2 : -1; };
    string_view line;
    for (Lines lines{content}; lines.next(line);) {
        const int kind = kind_of(word(line));
        if (kind == 0) three_numbers(line, "vertex coordinate", true, lines.number, path.c_str());
        if (kind >= 0) ++counts[kind];
    }
    std::int64_t faces = 0, so_far[3] = {0, 0, 0};
    for (Lines lines{content}; lines.next(line);) {
        string_view rest = line;
        const string_view w = word(rest);
        if (const int kind = kind_of(w); kind >= 0) ++so_far[kind];
        if (w != "f" && w != "l" && w != "p") continue;
        int corners = 0;
        for (string_view corner = word(rest); !corner.empty(); corner = word(rest), ++corners) {
            string_view fields = corner;
            for (int kind = 0; kind < 3; ++kind) {
                const std::size_t end = std::min(fields.find('/'), fields.size());
                const string_view field = fields.substr(0, end);
                const bool last = end == fields.size();
                fields.remove_prefix(std::min(end + 1, fields.size()));
                std::int64_t i = 0;
                const bool blank = field.empty() && kind > 0;
                if (!blank && (!parse(field, i) || i == 0 || i > counts[kind] || i < -so_far[kind]))
                    fail(Status::ERROR_FILE, "%s: line %lld: '%s' refers to index '%s'; the file has %lld %s",
                         path.c_str(), static_cast<long long>(lines.number), shown(corner).c_str(),
                         shown(field).c_str(), static_cast<long long>(counts[kind]),
                         kind == 0   ? "vertices"
                         : kind == 1 ? "vt"
                                     : "vn");
                if (last) break;
            }
        }
        if (w == "f" && corners < 3)
            fail(Status::ERROR_FILE, "%s: line %lld: a face of %d corners; expected 3 or more (is the file truncated?)",
                 path.c_str(), static_cast<long long>(lines.number), corners);
        if (w == "f") ++faces;
    }
    if (faces == 0)
        fail(Status::ERROR_FILE, "%s: no triangles: the OBJ file has %lld vertices and no 'f' line", path.c_str(),
             static_cast<long long>(counts[0]));
    return faces;
}

std::int64_t precheck_ply(const std::string& content, const std::string& path) {
    if (content.compare(0, 3, "ply") != 0)
        fail(Status::ERROR_FILE, "%s: not a PLY file: it does not begin with 'ply'", path.c_str());
    Lines lines{content};
    PlyBody body;
    body.path = path.c_str();
    const std::vector<Element> elements = ply_header(lines, body);
    body.rest = lines.rest;
    std::int64_t vertices = 0, faces = 0;
    for (const Element& e : elements)
        if (e.name == "vertex") vertices = e.count;
    for (const Element& e : elements) {
        // Every row takes at least a byte, so the loop below is bounded by the size of the file.
        if (e.count > 0 && (e.properties.empty() || e.count > static_cast<std::int64_t>(body.rest.size())))
            fail(Status::ERROR_FILE, "%s: the PLY header announces %lld of element '%s', and %zu bytes follow",
                 path.c_str(), static_cast<long long>(e.count), shown(e.name).c_str(), body.rest.size());
        for (std::int64_t row = 0; row < e.count; ++row) faces += ply_row(body, e, row, vertices);
    }
    if (faces == 0)
        fail(Status::ERROR_FILE, "%s: no triangles: the PLY file has %lld vertices and no face of three corners",
             path.c_str(), static_cast<long long>(vertices));
    return faces;
}

}  // namespace dqa
