// SPDX-License-Identifier: MIT
// STL, binary and ASCII. A file whose size is that of its announced triangles is binary, even where its header begins
// with "solid". Normals are not read: some programs write nan, or nothing that is a number, for those of slivers.
#include <bit>
#include <cstring>

#include "grid/error.hpp"
#include "grid/log.hpp"
#include "shape/mesh_readers.hpp"
#include "shape/mesh_text.hpp"

namespace dqa {
namespace {

using namespace mesh_text;

constexpr std::size_t kHeader = 84;  // 80 bytes and the number of triangles
constexpr std::size_t kRecord = 50;  // normal, three corners, two more bytes

std::uint32_t little_endian(const char* p) {
    std::uint32_t value = 0;
    for (std::size_t k = 4; k-- > 0;) value = value << 8 | static_cast<unsigned char>(p[k]);
    return value;
}

TriangleMesh read_binary(const MeshSource& source, std::uint64_t count) {
    TriangleMesh mesh;
    mesh.vertices.reserve(3 * count), mesh.triangles.reserve(count);
    for (std::uint64_t t = 0; t < count; ++t) {
        source.check(t);
        const char* record = source.content.data() + kHeader + kRecord * t;
        const int first = static_cast<int>(3 * t);
        for (std::size_t corner = 0; corner < 3; ++corner) {
            Vec3 x;
            for (std::size_t a = 0; a < 3; ++a) {
                x[a] = std::bit_cast<float>(little_endian(record + 12 + 12 * corner + 4 * a));
                if (!std::isfinite(x[a]))
                    fail(Status::ERROR_FILE, "%s: triangle %llu has the coordinate %g; expected finite numbers",
                         source.path.c_str(), static_cast<unsigned long long>(t), x[a]);
            }
            mesh.vertices.push_back(x);
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

// The words of an ASCII file, with the line that each stands in.
class Words {
public:
    explicit Words(string_view text) : lines_{text} { advance_line(); }
    std::int64_t line() const { return lines_.number; }
    string_view whole_line() const { return line_; }
    // Empty at the end of the file.
    string_view next() {
        for (;;) {
            const string_view w = word(rest_);
            if (!w.empty() && w[0] != '#') return w;
            if (!advance_line()) return {};
        }
    }
    string_view peek() const {
        Words copy(*this);
        return copy.next();
    }
    void skip_line() { rest_ = {}; }
    // The name after "solid" may hold any words, and ends with its line, or before the first facet of that line.
    void skip_name() {
        while (!rest_.empty()) {
            string_view after = rest_;
            const string_view w = word(after);
            string_view further = after;
            if (is(w, "facet") && is(word(further), "normal")) return;
            rest_ = after;
        }
    }

private:
    bool advance_line() {
        if (!lines_.next(line_)) return false;
        rest_ = line_;
        return true;
    }
    Lines lines_;
    string_view line_, rest_;
};

class AsciiStl {
public:
    explicit AsciiStl(const MeshSource& source) : source_(source), words_(without_mark(source.content)) {}

    TriangleMesh read() {
        bool ended = false;
        for (string_view w = words_.next(); !w.empty(); w = words_.next()) {
            source_.check(mesh_.vertices.size());
            if (is(w, "facet")) {
                read_facet();
            } else if (is(w, "solid") || is(w, "endsolid")) {
                words_.skip_name();
                ended = is(w, "endsolid");
            } else if (is(w, "color") || is(w, "colour")) {
                words_.skip_line();
            } else {
                unexpected(w, "'facet' or 'endsolid'");
            }
        }
        if (mesh_.triangles.empty())
            fail(Status::ERROR_FILE, "%s: no triangles in the ASCII STL file%s; expected at least one",
                 source_.path.c_str(), ended ? "" : " (is it truncated?)");
        if (!ended)
            log_message(LogLevel::warning, "%s: the ASCII STL file has no 'endsolid' at its end", source_.path.c_str());
        return std::move(mesh_);
    }

private:
    [[noreturn]] void unexpected(string_view w, const char* expected) const {
        if (w.empty())
            fail(Status::ERROR_FILE, "%s: the ASCII STL file is truncated: expected %s after %zu facets",
                 source_.path.c_str(), expected, mesh_.triangles.size());
        fail(Status::ERROR_FILE, "%s: line %lld: '%s' in the ASCII STL file, expected %s", source_.path.c_str(),
             static_cast<long long>(words_.line()), shown(w).c_str(), expected);
    }

    void read_facet() {
        if (is(words_.peek(), "normal")) {
            words_.next();
            for (int a = 0; a < 3 && !is(words_.peek(), "outer") && !is(words_.peek(), "vertex"); ++a) words_.next();
        }
        int corners = 0;
        for (string_view w = words_.next(); !is(w, "endfacet"); w = words_.next()) {
            if (is(w, "vertex")) {
                read_vertex();
                ++corners;
            } else if (!is(w, "outer") && !is(w, "loop") && !is(w, "endloop")) {
                unexpected(w, "'vertex' or 'endfacet'");
            }
        }
        if (corners != 3)
            fail(Status::ERROR_FILE, "%s: line %lld: the facet has %d vertices; expected 3", source_.path.c_str(),
                 static_cast<long long>(words_.line()), corners);
        const int first = static_cast<int>(mesh_.vertices.size()) - 3;
        mesh_.triangles.push_back({first, first + 1, first + 2});
    }

    void read_vertex() {
        Vec3 x;
        for (std::size_t a = 0; a < 3; ++a) {
            const string_view w = words_.next();
            if (w.empty()) unexpected(w, "a coordinate");
            if (!parse(w, x[a]) || !std::isfinite(x[a]))
                fail(Status::ERROR_FILE, "%s: line %lld: vertex coordinate %zu is '%s'; expected a finite number",
                     source_.path.c_str(), static_cast<long long>(words_.line()), a + 1, shown(w).c_str());
        }
        for (double more; parse(words_.peek(), more);) words_.next();  // colours of some programs
        mesh_.vertices.push_back(x);
    }

    const MeshSource& source_;
    Words words_;
    TriangleMesh mesh_;
};

}  // namespace

TriangleMesh read_stl(const MeshSource& source) {
    const string_view content = source.content;
    const string_view text = without_preamble(content);
    const bool begins_as_text = is(text.substr(0, 5), "solid");
    const bool is_text = begins_as_text && content.find('\0') == string_view::npos;
    if (content.size() < kHeader || is_text) {
        const std::uint64_t count = content.size() < kHeader ? 0 : little_endian(content.data() + 80);
        if (content.size() < kHeader || content.size() != kHeader + kRecord * count) {
            if (begins_as_text) return AsciiStl(source).read();
            fail(Status::ERROR_FILE,
                 "%s: not an STL file: its %zu bytes are too few for a binary one (84 and 50 a triangle), and it does "
                 "not begin with 'solid' as an ASCII one",
                 source.path.c_str(), content.size());
        }
    }
    const std::uint64_t count = little_endian(content.data() + 80), room = (content.size() - kHeader) / kRecord;
    const std::uint64_t expected = kHeader + kRecord * count;
    if (content.size() < expected || (count < room && (content.size() - kHeader) % kRecord == 0))
        fail(Status::ERROR_FILE,
             "%s: the header of the binary STL file announces %llu triangles, so %llu bytes; the file has %zu "
             "(truncated, or not an STL file)",
             source.path.c_str(), static_cast<unsigned long long>(count), static_cast<unsigned long long>(expected),
             content.size());
    if (count == 0)
        fail(Status::ERROR_FILE, "%s: no triangles in the binary STL file; expected at least one", source.path.c_str());
    if (content.size() > expected)
        log_message(LogLevel::warning, "%s: %zu bytes follow the %llu triangles of the binary STL file",
                    source.path.c_str(), content.size() - static_cast<std::size_t>(expected),
                    static_cast<unsigned long long>(count));
    return read_binary(source, count);
}

}  // namespace dqa
