// SPDX-License-Identifier: MIT
#include "shape/actuator_placement.hpp"

#include <algorithm>
#include <cmath>

#include "grid/error.hpp"

namespace dqa {
namespace {

constexpr double kTrace = 0.02;     // of the largest section: less is not body
constexpr double kWidening = 1.05;  // of the widest section behind a peduncle over the peduncle's

std::size_t idx(int i) {
    return static_cast<std::size_t>(i);
}

// Cross-sections in cells, and the run of those that are more than a trace.
struct Sections {
    std::vector<double> area;
    int tail = 0, head = 0, length = 0;
};

Sections sections_of(const Box& box, const std::vector<double>& fractions) {
    const int nx = box.cells[0], slab = box.cells[1] * box.cells[2];
    Sections s;
    s.area.assign(idx(nx), 0.0);
    for (int c = 0; c < nx * slab; ++c) s.area[idx(c / slab)] += fractions[idx(c)];
    const double largest = *std::max_element(s.area.begin(), s.area.end());
    s.head = nx - 1;
    while (s.tail < s.head && s.area[idx(s.tail)] < kTrace * largest) ++s.tail;
    while (s.head > s.tail && s.area[idx(s.head)] < kTrace * largest) --s.head;
    s.length = s.head - s.tail + 1;
    return s;
}

// First and last section (last exclusive) of the caudal muscle.
std::pair<int, int> caudal_reach(const Sections& s) {
    const auto at = [&](double share) { return s.tail + static_cast<int>(share * s.length); };
    // The peduncle is the narrowest section, if a wider one lies behind it. The rim of a tail fin can be as narrow: of
    // sections that hardly differ one with a wider one behind it counts.
    const double narrowest = *std::min_element(s.area.begin() + at(0.08), s.area.begin() + at(0.40) + 1);
    int peduncle = -1;
    for (int i = at(0.08); i <= at(0.40); ++i) {
        const double area = s.area[idx(i)], behind = *std::max_element(s.area.begin() + s.tail, s.area.begin() + i + 1);
        if (area <= kWidening * narrowest && behind >= kWidening * area &&
            (peduncle < 0 || area < s.area[idx(peduncle)]))
            peduncle = i;
    }
    if (peduncle >= 0) return {peduncle, std::max(peduncle + 2, at(0.55))};
    // Bent in one piece, a slender body goes towards the end that holds the muscle: the passive rear trails behind the
    // beat and pushes. Of stretches tried on eels (sine of 12 and 24 steps, whole lengths to single thirds) this one
    // swims fastest; muscles in the rear half swim tail first.
    return {at(0.40), std::max(at(0.40) + 2, at(0.90))};
}

// First section that is not part of the tail fin.
int tail_fin_end(const Sections& s) {
    return s.tail + static_cast<int>(0.25 * s.length);
}

// Rows of cells from the mid-plane to the side of the trunk in a section. With t(y) the covered height of a column, the
// trunk is where t is at least 0.59 of its mean over the section's volume, which in an ellipse is half the height at
// the middle and 0.87 of the half width: thin fins do not reach it. No trunk is wider than it is high.
int trunk_reach(const Box& box, const std::vector<double>& fractions, int i) {
    const int ny = box.cells[1], nz = box.cells[2];
    std::vector<double> column(idx(ny), 0.0);
    double sum = 0.0, squares = 0.0;
    for (int j = 0; j < ny; ++j) {
        for (int k = 0; k < nz; ++k) column[idx(j)] += fractions[idx(box.cell(i, j, k))];
        sum += column[idx(j)], squares += column[idx(j)] * column[idx(j)];
    }
    if (!(sum > 0)) return 0;
    const double mean = squares / sum;
    int thick = 0;
    for (int j = ny / 2; j < ny && column[idx(j)] >= 0.59 * mean; ++j) ++thick;
    const double wide = thick / 0.87, high = 0.5 * mean / 0.85;
    return static_cast<int>(std::ceil(std::min(wide, high)));
}

// The same for a body in the plane, which has no heights: twice the median half width of its sections.
int plane_reach(const Sections& s) {
    std::vector<double> width(s.area.begin() + s.tail, s.area.begin() + s.head + 1);
    std::nth_element(width.begin(), width.begin() + s.length / 2, width.end());
    return static_cast<int>(std::ceil(width[idx(s.length / 2)] - 1e-9));
}

Vec3 variance_of(const Vec3& half) {
    return {half[0] * half[0] / kTwoLn2, half[1] * half[1] / kTwoLn2, half[2] * half[2] / kTwoLn2};
}

}  // namespace

Actuator place_caudal(const Box& box, const std::vector<double>& fractions) {
    const int nx = box.cells[0];
    const Sections sections = sections_of(box, fractions);
    const auto [first, last] = caudal_reach(sections);
    double mass = 0.0, mean_z = 0.0, mean_zz = 0.0, mean_yy = 0.0;
    for (int i = first; i < last && i < nx; ++i)
        for (int j = 0; j < box.cells[1]; ++j)
            for (int k = 0; k < box.cells[2]; ++k) {
                const int c = box.cell(i, j, k);
                const double f = fractions[idx(c)];
                const Vec3 x = box.cell_centre(c);
                mass += f, mean_z += f * x[2], mean_zz += f * x[2] * x[2], mean_yy += f * x[1] * x[1];
            }
    if (!(mass > 0))
        fail(Status::ERROR_ARGUMENT,
             "no body found where its caudal muscle should be: it reaches over sections %d to %d of %d along x, of "
             "which "
             "%d to %d are empty; give it an actuator with dqa_shape_space_add_actuator",
             sections.tail + 1, sections.head + 1, nx, first + 1, std::min(last, nx));
    mean_z /= mass, mean_zz /= mass, mean_yy /= mass;
    // A uniform section of half-width H has variance H^2/4 (ellipse): twice the deviation spans it. At least one cell.
    const double half_y = std::max(box.dx, 2.0 * std::sqrt(mean_yy));
    const double half_z = std::max(box.dx, 2.0 * std::sqrt(std::max(0.0, mean_zz - mean_z * mean_z)));
    const double x0 = (first - 0.5 * nx) * box.dx, x1 = (std::min(last, nx) - 0.5 * nx) * box.dx;
    Actuator out;
    out.mean = {0.5 * (x0 + x1), 0.0, mean_z};
    out.variance = variance_of({0.5 * (x1 - x0), half_y, half_z});
    return out;
}

std::optional<Actuator> place_fins(const Box& box, const std::vector<double>& fractions) {
    const int nx = box.cells[0], ny = box.cells[1], nz = box.cells[2];
    const Sections s = sections_of(box, fractions);
    // What lies on the left where the right has it too.
    const auto paired = [&](int i, int j, int k) {
        return std::min(fractions[idx(box.cell(i, j, k))], fractions[idx(box.cell(i, ny - 1 - j, k))]);
    };
    const int in_plane = plane_reach(s);
    std::vector<double> area(idx(nx), 0.0);  // beyond the trunk, in sections where that is two cells or more
    std::vector<int> inner(idx(nx), ny);     // first row of cells beyond the trunk
    std::vector<int> tip(idx(nx), 0);        // and beyond the last one that is at least half a cell high
    for (int i = tail_fin_end(s); i < nx; ++i) {
        inner[idx(i)] = ny / 2 + (nz > 1 ? trunk_reach(box, fractions, i) : in_plane);
        double sum = 0.0;
        for (int j = inner[idx(i)]; j < ny; ++j) {
            double column = 0.0;
            for (int k = 0; k < nz; ++k) column += paired(i, j, k);
            if (column >= 0.5) tip[idx(i)] = j + 1;
            sum += column;
        }
        if (tip[idx(i)] - inner[idx(i)] >= 2) area[idx(i)] = sum;
    }
    // The run of such sections with the most volume.
    int first = 0, last = 0;
    double volume = 0.0;
    for (int i = 0; i < nx; ++i) {
        const int begin = i;
        double sum = 0.0;
        for (; i < nx && area[idx(i)] > 0; ++i) sum += area[idx(i)];
        if (sum > volume) volume = sum, first = begin, last = i;
    }
    if (!(volume > 0)) return std::nullopt;
    double fin = 0.0, body = 0.0, root = 0.0, mean_z = 0.0, mean_zz = 0.0;
    const int end = *std::max_element(tip.begin() + first, tip.begin() + last);
    for (const double f : fractions) body += f;
    for (int i = first; i < last; ++i)
        for (int j = inner[idx(i)]; j < ny; ++j)
            for (int k = 0; k < nz; ++k) {
                const double f = paired(i, j, k), z = box.cell_centre(box.cell(i, j, k))[2];
                fin += f, root += f * inner[idx(i)], mean_z += f * z, mean_zz += f * z * z;
            }
    root /= fin, mean_z /= fin, mean_zz /= fin;
    const int chord = last - first;
    if (chord < 2 || 3 * chord > 2 * s.length || 2.0 * fin < 0.01 * body) return std::nullopt;
    Vec3 half{0.5 * chord * box.dx, 0.5 * (end - root) * box.dx,
              std::max(box.dx, 2.0 * std::sqrt(std::max(0.0, mean_zz - mean_z * mean_z)))};
    half[2] = std::min({half[0], half[1], half[2]});  // the thickness is the smallest, also of a fin that hangs down
    Actuator out;
    out.kind = ActuatorKind::fins, out.half = ActuatorHalf::left, out.category = 1;
    out.layers = nz > 1 ? kMaxLayers : 1;
    out.mean = {(0.5 * (first + last) - 0.5 * nx) * box.dx, (0.5 * (root + end) - 0.5 * ny) * box.dx,
                nz > 1 ? mean_z : 0.0};
    out.variance = variance_of(half);
    return out;
}

}  // namespace dqa
