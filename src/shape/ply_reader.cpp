// SPDX-License-Identifier: MIT
// PLY: ASCII and binary in both byte orders, all types of numbers, elements and properties in any order. Of them the
// coordinates of `vertex`, the polygons of `face` and the strips of `tristrips` make the mesh; the rest is passed over.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "grid/error.hpp"
#include "shape/mesh_readers.hpp"
#include "shape/mesh_text.hpp"

namespace dqa {
namespace {

using namespace mesh_text;

struct PlyType {
    const char *name, *other;
    std::size_t bytes;
    char kind;  // i signed, u unsigned, f floating point
};
constexpr std::array<PlyType, 8> kTypes{{{"char", "int8", 1, 'i'},
                                         {"uchar", "uint8", 1, 'u'},
                                         {"short", "int16", 2, 'i'},
                                         {"ushort", "uint16", 2, 'u'},
                                         {"int", "int32", 4, 'i'},
                                         {"uint", "uint32", 4, 'u'},
                                         {"float", "float32", 4, 'f'},
                                         {"double", "float64", 8, 'f'}}};

const PlyType* type_of(string_view w) {
    const auto at =
        std::find_if(kTypes.begin(), kTypes.end(), [&](const PlyType& t) { return is(w, t.name) || is(w, t.other); });
    return at == kTypes.end() ? nullptr : &*at;
}

enum class Role { passed_over, x, y, z, polygon, strip };

struct Property {
    string_view name;
    const PlyType* type = nullptr;
    const PlyType* count_type = nullptr;  // null: a number, not a list
    Role role = Role::passed_over;
};

struct Element {
    string_view name;
    std::int64_t count = 0;
    std::vector<Property> properties;
    // Bytes that a row takes at least.
    std::size_t least_bytes(bool ascii) const {
        std::size_t sum = 0;
        for (const Property& p : properties) sum += ascii ? 1 : p.count_type ? p.count_type->bytes : p.type->bytes;
        return std::max<std::size_t>(sum, 1);
    }
};

struct Header {
    bool ascii = true, swap = false;
    std::vector<Element> elements;
    string_view body;
};

template <class T>
double number_from(const char* bytes, bool swap) {
    std::array<char, sizeof(T)> b;
    std::memcpy(b.data(), bytes, sizeof(T));
    if (swap) std::reverse(b.begin(), b.end());
    return static_cast<double>(std::bit_cast<T>(b));
}

double binary_number(const PlyType& t, const char* p, bool swap) {
    switch (t.bytes * 256 + static_cast<unsigned char>(t.kind)) {
        case 256 + 'i':
            return number_from<std::int8_t>(p, swap);
        case 256 + 'u':
            return number_from<std::uint8_t>(p, swap);
        case 512 + 'i':
            return number_from<std::int16_t>(p, swap);
        case 512 + 'u':
            return number_from<std::uint16_t>(p, swap);
        case 1024 + 'i':
            return number_from<std::int32_t>(p, swap);
        case 1024 + 'u':
            return number_from<std::uint32_t>(p, swap);
        case 1024 + 'f':
            return number_from<float>(p, swap);
        default:
            return number_from<double>(p, swap);
    }
}

// ---------------------------------------------------------------- header

class HeaderReader {
public:
    explicit HeaderReader(const MeshSource& source) : source_(source), rest_(without_preamble(source.content)) {
        // Lines end as the first one does: a data byte after "end_header" may look like a further line end.
        const std::size_t end = rest_.find_first_of("\r\n");
        if (end != string_view::npos)
            mark_ = rest_.substr(end, 2) == "\r\n" ? "\r\n" : rest_[end] == '\r' ? "\r" : "\n";
    }

    Header read() {
        bool have_format = false;
        string_view line;
        if (!next(line) || !is(word(line), "ply"))
            fail(Status::ERROR_FILE, "%s: not a PLY file: it does not begin with 'ply'", source_.path.c_str());
        while (next(line)) {
            string_view rest = line;
            const string_view w = word(rest);
            if (is(w, "format")) {
                read_format(line, rest);
                have_format = true;
            } else if (is(w, "element")) {
                read_element(line, rest);
            } else if (is(w, "property")) {
                read_property(line, rest);
            } else if (is(w, "end_header")) {
                if (!have_format)
                    fail(Status::ERROR_FILE, "%s: the PLY header has no 'format' line", source_.path.c_str());
                header_.body = rest_;
                assign_roles();
                return std::move(header_);
            } else if (!w.empty() && !is(w, "comment") && !is(w, "obj_info")) {
                bad(line);
            }
        }
        fail(Status::ERROR_FILE, "%s: the PLY header is truncated: 'end_header' is missing", source_.path.c_str());
    }

private:
    bool next(string_view& line) {
        if (rest_.empty()) return false;
        const std::size_t end = std::min(rest_.find(mark_), rest_.size());
        line = rest_.substr(0, end);
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        rest_.remove_prefix(std::min(end + mark_.size(), rest_.size()));
        ++number_;
        return true;
    }
    [[noreturn]] void bad(string_view line) const {
        fail(Status::ERROR_FILE, "%s: line %lld of the PLY header is not understood: '%s'", source_.path.c_str(),
             static_cast<long long>(number_), shown(line).c_str());
    }
    void read_format(string_view line, string_view rest) {
        const string_view kind = word(rest);
        const bool big = is(kind, "binary_big_endian");
        header_.ascii = is(kind, "ascii");
        if (!header_.ascii && !big && !is(kind, "binary_little_endian")) bad(line);
        header_.swap = !header_.ascii && big != (std::endian::native == std::endian::big);
    }
    void read_element(string_view line, string_view rest) {
        Element e;
        e.name = word(rest);
        if (!parse(word(rest), e.count) || e.count < 0) bad(line);
        for (const Element& other : header_.elements)
            if (is(e.name, "vertex") && is(other.name, "vertex")) bad(line);
        header_.elements.push_back(e);
    }
    void read_property(string_view line, string_view rest) {
        Property p;
        string_view type = word(rest);
        if (is(type, "list")) {
            p.count_type = type_of(word(rest));
            if (!p.count_type || p.count_type->kind == 'f') bad(line);
            type = word(rest);
        }
        p.type = type_of(type);
        p.name = word(rest);
        if (!p.type || header_.elements.empty()) bad(line);
        header_.elements.back().properties.push_back(p);
    }
    void assign_roles() {
        constexpr std::array<const char*, 3> axes{"x", "y", "z"};
        for (Element& e : header_.elements) {
            int coordinates = 0;
            for (Property& p : e.properties) {
                for (std::size_t a = 0; a < 3 && is(e.name, "vertex") && !p.count_type; ++a)
                    if (is(p.name, axes[a])) p.role = static_cast<Role>(1 + a), ++coordinates;
                const bool corners = p.count_type && (is(p.name, "vertex_indices") || is(p.name, "vertex_index"));
                if (corners && is(e.name, "face")) p.role = Role::polygon;
                if (corners && is(e.name, "tristrips")) p.role = Role::strip;
            }
            if (is(e.name, "vertex") && coordinates != 3)
                fail(Status::ERROR_FILE,
                     "%s: the PLY header gives 'vertex' %d of the properties x, y and z; expected "
                     "each once",
                     source_.path.c_str(), coordinates);
        }
    }

    const MeshSource& source_;
    string_view rest_, mark_ = "\n";
    std::int64_t number_ = 0;
    Header header_;
};

// ---------------------------------------------------------------- body

class PlyReader {
public:
    explicit PlyReader(const MeshSource& source)
        : source_(source), header_(HeaderReader(source).read()), rest_(header_.body) {
        // Rows of text stand on lines of their own, maybe with further columns. Some writers break or join lines as
        // they like: then numbers follow each other.
        if (!header_.ascii) return;
        std::int64_t rows = 0, lines = 0;
        for (const Element& e : header_.elements)
            if (e.count < std::numeric_limits<std::int64_t>::max() - rows) rows += e.count;
        string_view line;
        for (Lines all{rest_}; all.next(line);) lines += !word(line).empty();
        row_a_line_ = lines >= rows;
    }

    TriangleMesh read() {
        for (const Element& e : header_.elements) {
            if (e.count > 0 &&
                (e.properties.empty() || static_cast<std::uint64_t>(e.count) > left() / e.least_bytes(header_.ascii)))
                fail(Status::ERROR_FILE, "%s: the PLY header announces %lld of element '%s', and %zu bytes follow",
                     source_.path.c_str(), static_cast<long long>(e.count), shown(e.name).c_str(), left());
            if (is(e.name, "vertex")) mesh_.vertices.reserve(static_cast<std::size_t>(e.count));
            for (row_ = 0; row_ < e.count; ++row_) {
                source_.check(static_cast<std::size_t>(row_));
                read_row(e);
            }
        }
        add_faces();
        if (mesh_.triangles.empty())
            fail(Status::ERROR_FILE,
                 "%s: no triangles: the PLY file has %zu vertices and no face or strip of three "
                 "corners",
                 source_.path.c_str(), mesh_.vertices.size());
        return std::move(mesh_);
    }

private:
    [[noreturn]] void truncated(const Element& e) const {
        fail(Status::ERROR_FILE, "%s: the PLY file is truncated: it ends in %s %lld of %lld", source_.path.c_str(),
             shown(e.name).c_str(), static_cast<long long>(row_), static_cast<long long>(e.count));
    }

    std::size_t left() const { return line_.size() + rest_.size(); }

    double next(const PlyType& type, const Element& e) {
        if (!header_.ascii) {
            if (rest_.size() < type.bytes) truncated(e);
            const double value = binary_number(type, rest_.data(), header_.swap);
            rest_.remove_prefix(type.bytes);
            return value;
        }
        string_view w = word(line_);
        while (w.empty()) {
            if (!next_line()) truncated(e);
            w = word(line_);
        }
        double value = 0.0;
        if (!parse(w, value))
            fail(Status::ERROR_FILE, "%s: %s %lld holds '%s'; expected a number", source_.path.c_str(),
                 shown(e.name).c_str(), static_cast<long long>(row_), shown(w).c_str());
        return value;
    }

    bool next_line() {
        Lines lines{rest_};
        if (!lines.next(line_)) return false;
        rest_ = lines.rest;
        return true;
    }

    void read_row(const Element& e) {
        Vec3 x{};
        for (const Property& p : e.properties) {
            if (p.count_type) {
                read_list(e, p);
                continue;
            }
            const double value = next(*p.type, e);
            if (p.role == Role::passed_over) continue;
            if (!std::isfinite(value))
                fail(Status::ERROR_FILE, "%s: coordinate %s of vertex %lld is %g; expected a finite number",
                     source_.path.c_str(), shown(p.name).c_str(), static_cast<long long>(row_), value);
            x[static_cast<std::size_t>(p.role) - 1] = value;
        }
        if (is(e.name, "vertex")) mesh_.vertices.push_back(x);
        if (row_a_line_) line_ = {};
    }

    void read_list(const Element& e, const Property& p) {
        const double count = next(*p.count_type, e);
        if (!(count >= 0.0 && count == std::floor(count)))
            fail(Status::ERROR_FILE, "%s: %s %lld has a list of %g numbers; expected a whole number from 0",
                 source_.path.c_str(), shown(e.name).c_str(), static_cast<long long>(row_), count);
        if (count > static_cast<double>(left())) truncated(e);
        const bool wanted = p.role != Role::passed_over;
        for (double k = 0.0; k < count; k += 1.0) {
            const double i = next(*p.type, e);
            if (!wanted) continue;
            const bool restart = p.role == Role::strip && i == -1.0;
            if (!restart && !(i >= 0.0 && i < 2147483647.0 && i == std::floor(i))) bad_index(e.name, row_, i);
            indices_.push_back(static_cast<int>(i));
        }
        if (wanted) faces_.push_back({indices_.size(), row_, p.role == Role::strip});
    }

    [[noreturn]] void bad_index(string_view element, std::int64_t row, double i) const {
        fail(Status::ERROR_FILE, "%s: %s %lld refers to vertex %.17g; expected an index in [0, %lld)",
             source_.path.c_str(), shown(element).c_str(), static_cast<long long>(row), i,
             static_cast<long long>(n_vertices()));
    }
    std::int64_t n_vertices() const {
        for (const Element& e : header_.elements)
            if (is(e.name, "vertex")) return e.count;
        return 0;
    }

    // Faces may have come before the vertices that they refer to.
    void add_faces() {
        std::size_t begin = 0;
        std::vector<int> corners;
        for (const Face& face : faces_) {
            source_.check(begin);
            for (std::size_t k = begin; k < face.end; ++k)
                if (indices_[k] >= static_cast<std::int64_t>(mesh_.vertices.size()))
                    bad_index(face.strip ? "tristrips" : "face", face.row, indices_[k]);
            if (face.strip) {
                add_strips(begin, face.end);
            } else if (face.end - begin >= 3) {  // fewer corners bound nothing
                corners.assign(indices_.begin() + static_cast<std::ptrdiff_t>(begin),
                               indices_.begin() + static_cast<std::ptrdiff_t>(face.end));
                add_polygon(mesh_, corners);
            }
            begin = face.end;
        }
    }

    // Every second triangle of a strip runs the other way; -1 starts another strip.
    void add_strips(std::size_t begin, std::size_t end) {
        std::size_t length = 0;
        for (std::size_t k = begin; k < end; ++k) {
            if (indices_[k] < 0) {
                length = 0;
                continue;
            }
            if (++length < 3) continue;
            const int a = indices_[k - 2], b = indices_[k - 1], c = indices_[k];
            if (length % 2 == 1)
                mesh_.triangles.push_back({a, b, c});
            else
                mesh_.triangles.push_back({b, a, c});
        }
    }

    struct Face {
        std::size_t end;  // of its indices
        std::int64_t row;
        bool strip;
    };
    const MeshSource& source_;
    Header header_;
    string_view rest_, line_;
    bool row_a_line_ = false;
    std::int64_t row_ = 0;
    TriangleMesh mesh_;
    std::vector<int> indices_;
    std::vector<Face> faces_;
};

}  // namespace

TriangleMesh read_ply(const MeshSource& source) {
    return PlyReader(source).read();
}

}  // namespace dqa
