// SPDX-License-Identifier: MIT
// Wavefront OBJ: vertices and faces. Texture coordinates, normals, groups, materials, lines and points have no part in
// a solid and are passed over, whether what they refer to exists or not.
#include "grid/error.hpp"
#include "shape/mesh_readers.hpp"
#include "shape/mesh_text.hpp"

namespace dqa {
namespace {

using namespace mesh_text;

// Lines without their comments, those that end in a backslash joined with the next.
class LogicalLines {
public:
    explicit LogicalLines(string_view text) : lines_{text} {}
    std::int64_t number() const { return first_; }
    bool next(string_view& line) {
        if (!lines_.next(line)) return false;
        first_ = lines_.number;
        line = line.substr(0, line.find('#'));
        if (!continues(line)) return true;
        joined_.clear();
        for (string_view part = line;;) {
            const bool more = continues(part);
            if (more) part = part.substr(0, part.find_last_of('\\'));
            joined_.append(part).append(1, ' ');
            if (!more || !lines_.next(part)) break;
            part = part.substr(0, part.find('#'));
        }
        line = joined_;
        return true;
    }

private:
    static bool continues(string_view line) {
        const std::size_t last = line.find_last_not_of(kBlanks);
        return last != string_view::npos && line[last] == '\\';
    }
    Lines lines_;
    std::int64_t first_ = 0;
    std::string joined_;
};

class ObjReader {
public:
    explicit ObjReader(const MeshSource& source) : source_(source), lines_(without_mark(source.content)) {}

    TriangleMesh read() {
        string_view line;
        while (lines_.next(line)) {
            source_.check(static_cast<std::size_t>(lines_.number()));
            const string_view w = word(line);
            if (is(w, "v"))
                read_vertex(line);
            else if (is(w, "f") || is(w, "fo"))
                read_face(line);
        }
        if (starts_.size() == 1)
            fail(Status::ERROR_FILE, "%s: no triangles: the OBJ file has %zu vertices and no 'f' line",
                 source_.path.c_str(), mesh_.vertices.size());
        add_faces();
        return std::move(mesh_);
    }

private:
    void read_vertex(string_view rest) {
        Vec3 x;
        for (std::size_t a = 0; a < 3; ++a) {
            const string_view w = word(rest);
            if (!parse(w, x[a]) || !std::isfinite(x[a]))
                fail(Status::ERROR_FILE, "%s: line %lld: vertex coordinate %zu is '%s'; expected a finite number",
                     source_.path.c_str(), static_cast<long long>(lines_.number()), a + 1, shown(w).c_str());
        }
        mesh_.vertices.push_back(x);
    }

    // Corners as they stand, v, v/vt, v//vn or v/vt/vn. Positive indices may refer to vertices that follow.
    void read_face(string_view rest) {
        int corners = 0;
        for (string_view corner = word(rest); !corner.empty(); corner = word(rest), ++corners) {
            const string_view field = corner.substr(0, corner.find('/'));
            std::int64_t i = 0;
            if (!parse(field, i) || i == 0) bad_index(corner, field);
            if (i < 0) i += static_cast<std::int64_t>(mesh_.vertices.size()) + 1;
            if (i <= 0 || i > std::numeric_limits<int>::max()) bad_index(corner, field);
            if (i > largest_) largest_ = i, largest_line_ = lines_.number();
            indices_.push_back(static_cast<int>(i - 1));
        }
        if (corners < 3)
            fail(Status::ERROR_FILE, "%s: line %lld: a face of %d corners; expected 3 or more (is the file truncated?)",
                 source_.path.c_str(), static_cast<long long>(lines_.number()), corners);
        starts_.push_back(indices_.size());
    }

    void add_faces() {
        if (largest_ > static_cast<std::int64_t>(mesh_.vertices.size()))
            fail(Status::ERROR_FILE, "%s: line %lld refers to vertex '%lld'; the file has %zu vertices",
                 source_.path.c_str(), static_cast<long long>(largest_line_), static_cast<long long>(largest_),
                 mesh_.vertices.size());
        std::vector<int> corners;
        for (std::size_t f = 0; f + 1 < starts_.size(); ++f) {
            source_.check(f);
            corners.assign(indices_.begin() + static_cast<std::ptrdiff_t>(starts_[f]),
                           indices_.begin() + static_cast<std::ptrdiff_t>(starts_[f + 1]));
            add_polygon(mesh_, corners);
        }
    }

    [[noreturn]] void bad_index(string_view corner, string_view field) const {
        fail(Status::ERROR_FILE,
             "%s: line %lld: '%s' refers to vertex '%s'; expected an index from 1, or a negative "
             "one that counts back over the %zu vertices so far",
             source_.path.c_str(), static_cast<long long>(lines_.number()), shown(corner).c_str(), shown(field).c_str(),
             mesh_.vertices.size());
    }

    const MeshSource& source_;
    LogicalLines lines_;
    TriangleMesh mesh_;
    std::vector<int> indices_;
    std::vector<std::size_t> starts_{0};
    std::int64_t largest_ = 0, largest_line_ = 0;
};

}  // namespace

TriangleMesh read_obj(const MeshSource& source) {
    return ObjReader(source).read();
}

}  // namespace dqa
