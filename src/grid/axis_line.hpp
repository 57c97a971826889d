// SPDX-License-Identifier: MIT
// A straight line parallel to x through a box: the 2 x 2 cells around it and their bilinear weights.
#pragma once

#include <cmath>

#include "grid/box.hpp"

namespace dqa {

class AxisLine {
public:
    // y, z: the line's place (m).
    AxisLine(const Box& box, double y, double z) : box_(box) {
        const double gy = y / box.dx + 0.5 * box.cells[1] - 0.5, gz = z / box.dx + 0.5 * box.cells[2] - 0.5;
        j_ = static_cast<int>(std::floor(gy)), k_ = static_cast<int>(std::floor(gz));
        wy_[1] = gy - j_, wy_[0] = 1.0 - wy_[1];
        wz_[1] = gz - k_, wz_[0] = 1.0 - wz_[1];
    }

    // f(cell, weight) for the cells whose value counts at cell centre i along x.
    template <class F>
    void for_each_cell(int i, F&& f) const {
        for (int a = 0; a < 2; ++a)
            for (int b = 0; b < 2; ++b) {
                const int j = j_ + a, k = k_ + b;
                if (j < 0 || j >= box_.cells[1] || k < 0 || k >= box_.cells[2]) continue;
                const double w = wy_[a] * wz_[b];
                if (w > 0) f(box_.cell(i, j, k), w);
            }
    }
    // Cell-centred data on the line, at cell centre i.
    double value(const double* cells, int i) const {
        double sum = 0.0;
        for_each_cell(i, [&](int cell, double w) { sum += w * cells[cell]; });
        return sum;
    }

private:
    const Box& box_;
    int j_, k_;
    double wy_[2], wz_[2];
};

}  // namespace dqa
