// SPDX-License-Identifier: MIT
#include "shape/planar_base.hpp"

#include <algorithm>
#include <cmath>

#include "grid/error.hpp"
#include "grid/number_text.hpp"

namespace dqa {
namespace {

using Point = std::array<double, 2>;

std::size_t idx(int i) {
    return static_cast<std::size_t>(i);
}

double cross(const Point& a, const Point& b, const Point& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// Whether the closed segments a-b and c-d share a point.
bool meet(const Point& a, const Point& b, const Point& c, const Point& d) {
    for (std::size_t k = 0; k < 2; ++k)
        if (std::max(a[k], b[k]) < std::min(c[k], d[k]) || std::max(c[k], d[k]) < std::min(a[k], b[k])) return false;
    const double c1 = cross(a, b, c), d1 = cross(a, b, d), a1 = cross(c, d, a), b1 = cross(c, d, b);
    return !((c1 > 0 && d1 > 0) || (c1 < 0 && d1 < 0) || (a1 > 0 && b1 > 0) || (a1 < 0 && b1 < 0));
}

void check_simple(const std::vector<Point>& p) {
    const std::size_t n = p.size();
    if (n < 3) fail(Status::ERROR_ARGUMENT, "polygon has %zu corners, expected at least 3", n);
    for (std::size_t i = 0; i < n; ++i) {
        if (!std::isfinite(p[i][0]) || !std::isfinite(p[i][1]))
            fail(Status::ERROR_ARGUMENT, "corner %zu of the polygon is (%g, %g), expected finite numbers", i, p[i][0],
                 p[i][1]);
        const std::size_t j = (i + 1) % n;
        if (p[i] == p[j])
            fail(Status::ERROR_ARGUMENT, "corners %zu and %zu of the polygon are the same point%s", i, j,
                 j == 0 ? "; the last corner is joined to the first without repeating it" : "");
        const std::size_t after = (i + 2) % n;  // an edge that runs back on its neighbour
        if (n > 2 && cross(p[i], p[j], p[after]) == 0.0 &&
            (p[j][0] - p[i][0]) * (p[after][0] - p[j][0]) + (p[j][1] - p[i][1]) * (p[after][1] - p[j][1]) < 0)
            fail(Status::ERROR_ARGUMENT, "the polygon runs back on itself at corner %zu", j);
    }
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 2; j < n; ++j)
            if ((j + 1) % n != i && meet(p[i], p[i + 1], p[j], p[(j + 1) % n]))
                fail(Status::ERROR_ARGUMENT, "edges %zu and %zu of the polygon cross or touch, expected a simple one",
                     i, j);
}

// Scale (cells per unit) that fits extents [lo, hi] into the box with `centre` at its middle.
double fit(const Point& lo, const Point& hi, const Point& centre, const Box& box, Margin margin) {
    double scale = HUGE_VAL;
    for (std::size_t a = 0; a < 2; ++a) {
        const double room = 0.5 * box.cells[a] - margin.of(a);
        if (!(room > 0))
            fail(Status::ERROR_ARGUMENT, "a margin of %d cells leaves no room in a box of %d x %d cells", margin.of(a),
                 box.cells[0], box.cells[1]);
        const double reach = std::max(hi[a] - centre[a], centre[a] - lo[a]);
        if (reach > 0) scale = std::min(scale, room / reach);
    }
    if (!std::isfinite(scale) || !(scale > 0))
        fail(Status::ERROR_ARGUMENT, "a shape of extents %g x %g cannot be scaled to the box", hi[0] - lo[0],
             hi[1] - lo[1]);
    return scale;
}

// Area of cell (i, j) below the segment a -> b (towards smaller y), signed by the direction along x: summed over the
// edges of a polygon, the area of the cell inside it. Coordinates in cells from the box's lower corner.
void add_edge(const Point& a, const Point& b, const Box& box, std::vector<double>& area) {
    if (a[0] == b[0]) return;
    const double sign = a[0] < b[0] ? -1.0 : 1.0;  // counter-clockwise: the lower edges run along +x
    const Point& l = a[0] < b[0] ? a : b;
    const Point& r = a[0] < b[0] ? b : a;
    const double slope = (r[1] - l[1]) / (r[0] - l[0]);
    const auto height = [&](double x) {
        return std::clamp(l[1] + slope * (x - l[0]), std::min(l[1], r[1]), std::max(l[1], r[1]));
    };
    const int first = std::max(0, static_cast<int>(std::floor(l[0])));
    for (int i = first; i < box.cells[0] && i < r[0]; ++i) {
        const double x0 = std::max(l[0], static_cast<double>(i)), x1 = std::min(r[0], i + 1.0);
        if (!(x1 > x0)) continue;
        const double y0 = height(x0), y1 = height(x1), low = std::min(y0, y1), high = std::max(y0, y1), width = x1 - x0;
        for (int j = 0; j < box.cells[1] && j < high; ++j) {
            // Mean over [x0, x1] of clamp(y - j, 0, 1), y linear from low to high.
            const auto integral = [&](double t) { return t <= 0 ? 0.0 : t >= 1 ? t - 0.5 : 0.5 * t * t; };
            const double mean = high - low > 1e-12 ? (integral(high - j) - integral(low - j)) / (high - low)
                                                   : std::clamp(0.5 * (low + high) - j, 0.0, 1.0);
            area[idx(box.cell(i, j, 0))] += sign * width * mean;
        }
    }
}

}  // namespace

std::vector<double> polygon_fractions(const std::vector<Point>& corners, const Box& box, Margin margin,
                                      double* length_in_cells) {
    check_simple(corners);
    const std::size_t n = corners.size();
    Point lo = corners[0], hi = lo, moment{};
    double twice_area = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        const Point &a = corners[i], &b = corners[(i + 1) % n];
        // Relative to the first corner, so that a polygon far from the origin keeps its digits.
        const Point p{a[0] - corners[0][0], a[1] - corners[0][1]}, q{b[0] - corners[0][0], b[1] - corners[0][1]};
        const double c = p[0] * q[1] - p[1] * q[0];
        twice_area += c;
        for (std::size_t k = 0; k < 2; ++k) {
            moment[k] += c * (p[k] + q[k]);
            lo[k] = std::min(lo[k], a[k]), hi[k] = std::max(hi[k], a[k]);
        }
    }
    if (!(std::fabs(twice_area) > 1e-12 * (hi[0] - lo[0]) * (hi[1] - lo[1])))
        fail(Status::ERROR_ARGUMENT, "the polygon has no area");
    Point centre;
    for (std::size_t k = 0; k < 2; ++k) centre[k] = corners[0][k] + moment[k] / (3.0 * twice_area);
    const double scale = fit(lo, hi, centre, box, margin), turn = twice_area > 0 ? 1.0 : -1.0;
    std::vector<Point> placed;
    for (const Point& c : corners) {
        Point p;
        for (std::size_t k = 0; k < 2; ++k)  // round-off must not let a touching polygon spill into the margin
            p[k] = std::clamp((c[k] - centre[k]) * scale + 0.5 * box.cells[k], double(margin.of(k)),
                              double(box.cells[k] - margin.of(k)));
        placed.push_back(p);
    }
    std::vector<double> out(idx(box.n_cells()), 0.0);
    for (std::size_t i = 0; i < n; ++i) add_edge(placed[i], placed[(i + 1) % n], box, out);
    for (double& f : out) {
        f = std::clamp(turn * f, 0.0, 1.0);
        if (f < 1e-14) f = 0.0;  // what cancelled
    }
    if (length_in_cells) *length_in_cells = (hi[0] - lo[0]) * scale;
    return out;
}

std::vector<double> image_fractions(const double* pixels, int rows, int columns, const Box& box, Margin margin,
                                    double* length_in_cells) {
    const auto at = [&](int row, int column) { return pixels[idx(row) * idx(columns) + idx(column)]; };
    Point lo{HUGE_VAL, HUGE_VAL}, hi{-HUGE_VAL, -HUGE_VAL}, moment{};
    double sum = 0.0;
    int first = columns, last = -1;
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
            const double f = at(r, c);
            if (!(f >= 0.0 && f <= 1.0))
                fail(Status::ERROR_ARGUMENT, "pixels[%d][%d] is %s, expected a grey value in [0, 1]", r, c,
                     number_text(f).c_str());
            if (!(f > 0)) continue;
            const double x = c, y = rows - 1 - r;  // lower corner of the pixel
            lo = {std::min(lo[0], x), std::min(lo[1], y)}, hi = {std::max(hi[0], x + 1), std::max(hi[1], y + 1)};
            sum += f, moment[0] += f * (x + 0.5), moment[1] += f * (y + 0.5);
            if (f >= 0.5) first = std::min(first, c), last = std::max(last, c);
        }
    if (last < 0)
        fail(Status::ERROR_ARGUMENT, "pixels: no pixel is 1/2 or more (largest %s), expected a body",
             number_text(*std::max_element(pixels, pixels + idx(rows) * idx(columns))).c_str());
    const Point centre{moment[0] / sum, moment[1] / sum};
    const double scale = fit(lo, hi, centre, box, margin);
    std::vector<double> out(idx(box.n_cells()), 0.0);
    // Overlap of the pixel [p, p + 1] with every cell along one axis.
    const auto spread = [&](double p, std::size_t axis, const auto& give) {
        const double from = (p - centre[axis]) * scale + 0.5 * box.cells[axis], to = from + scale;
        for (int i = std::max(0, static_cast<int>(std::floor(from))); i < box.cells[axis] && i < to; ++i)
            if (const double part = std::min(to, i + 1.0) - std::max(from, double(i)); part > 0) give(i, part);
    };
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
            const double f = at(r, c);
            if (!(f > 0)) continue;
            spread(c, 0, [&](int i, double wide) {
                spread(rows - 1 - r, 1, [&](int j, double high) { out[idx(box.cell(i, j, 0))] += f * wide * high; });
            });
        }
    for (double& f : out) f = std::min(f, 1.0);  // round-off above 1
    if (length_in_cells) *length_in_cells = (last + 1 - first) * scale;
    return out;
}

}  // namespace dqa
