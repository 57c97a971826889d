// SPDX-License-Identifier: MIT
// Densities on cells for the tests of the shape space: soft-edged ellipsoids, and sums that count.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "grid/box.hpp"

namespace fixtures {

using Cells = std::array<int, 3>;

// Covered fractions of an ellipsoid, edges softened over about a cell; centre in cells from the corner of the box.
inline std::vector<double> soft_ellipsoid(const Cells& cells, const dqa::Vec3& centre, const dqa::Vec3& radius) {
    const dqa::Box box{cells, 1.0};
    std::vector<double> out;
    for (int c = 0; c < box.n_cells(); ++c) {
        const auto ijk = box.cell_ijk(c);
        double r2 = 0.0, least = 1e300;
        for (std::size_t k = 0; k < 3; ++k) {
            const double d = (ijk[k] + 0.5 - centre[k]) / radius[k];
            r2 += d * d, least = std::fmin(least, radius[k]);
        }
        out.push_back(std::fmin(1.0, std::fmax(0.0, 0.5 + (1.0 - std::sqrt(r2)) * least)));
    }
    return out;
}

inline std::vector<double> normalised(std::vector<double> v) {
    double sum = 0.0;
    for (const double x : v) sum += x;
    for (double& x : v) x /= sum;
    return v;
}

// Moved along x by a whole number of cells; what leaves the box is lost.
inline std::vector<double> shifted(const Cells& cells, const std::vector<double>& v, int by) {
    const int slab = cells[1] * cells[2];
    std::vector<double> out(v.size(), 0.0);
    for (int i = 0; i < cells[0]; ++i)
        if (i - by >= 0 && i - by < cells[0])
            for (int c = 0; c < slab; ++c)
                out[static_cast<std::size_t>(i * slab + c)] = v[static_cast<std::size_t>((i - by) * slab + c)];
    return out;
}

inline double distance_1(const std::vector<double>& a, const std::vector<double>& b) {
    double d = 0.0;
    for (std::size_t c = 0; c < a.size(); ++c) d += std::fabs(a[c] - b[c]);
    return d;
}

}  // namespace fixtures
