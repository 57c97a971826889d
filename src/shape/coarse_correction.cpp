// SPDX-License-Identifier: MIT
#include "shape/coarse_correction.hpp"

#include <algorithm>
#include <cmath>

namespace dqa {
namespace {

constexpr int kSpacing = 3;
constexpr double kLeastMass = 1e-8;  // of a cell at the peak: nodes with less carry nothing
constexpr double kAnchor = 1e-6;     // of a node's mass, added to its diagonal: constants have no energy

}  // namespace

CoarseCorrection::CoarseCorrection(const std::array<int, 3>& cells, double sigma, const std::vector<double>& p)
    : cells_(cells), p_(p) {
    for (std::size_t a = 0; a < 3; ++a) {
        nodes_[a] = (cells[a] - 1 + kSpacing - 1) / kSpacing + 1;
        for (int i = 0; i < cells[a]; ++i) {
            const int low = std::min(i / kSpacing, std::max(0, nodes_[a] - 2));
            lines_[a].push_back({low, static_cast<double>(i - low * kSpacing) / kSpacing});
        }
    }
    const int ny = cells[1], nz = cells[2], step[3] = {ny * nz, nz, 1};
    // Every pair of neighbours lies within one element of 2 x 2 x 2 nodes: their shares there, and the element
    // matrices.
    const int elements[3] = {std::max(1, nodes_[0] - 1), std::max(1, nodes_[1] - 1), std::max(1, nodes_[2] - 1)};
    std::vector<std::array<double, 64>> energy(static_cast<std::size_t>(elements[0]) *
                                               static_cast<std::size_t>(elements[1] * elements[2]));
    std::vector<std::array<double, 8>> masses(energy.size());
    const auto shares = [](const std::array<double, 3>& high) {
        std::array<double, 8> out;
        for (std::size_t k = 0; k < 8; ++k)
            out[k] =
                (k & 1 ? high[0] : 1 - high[0]) * (k & 2 ? high[1] : 1 - high[1]) * (k & 4 ? high[2] : 1 - high[2]);
        return out;
    };
    std::size_t c = 0;
    for (int x = 0; x < cells[0]; ++x)
        for (int y = 0; y < ny; ++y)
            for (int z = 0; z < nz; ++z, ++c) {
                if (p[c] < kLeastMass) continue;
                const Line &lx = lines_[0][static_cast<std::size_t>(x)], &ly = lines_[1][static_cast<std::size_t>(y)],
                           &lz = lines_[2][static_cast<std::size_t>(z)];
                const std::array<double, 3> high{lx.high_share, ly.high_share, lz.high_share};
                const std::array<double, 8> here = shares(high);
                const std::size_t element =
                    static_cast<std::size_t>((lx.low * elements[1] + ly.low) * elements[2] + lz.low);
                for (std::size_t k = 0; k < 8; ++k) masses[element][k] += p[c] * here[k];
                const int place[3] = {x, y, z};
                for (std::size_t a = 0; a < 3; ++a) {
                    if (place[a] + 1 >= cells[a]) continue;
                    const double q = p[c + static_cast<std::size_t>(step[a])];
                    if (q < kLeastMass) continue;
                    std::array<double, 3> moved = high;
                    moved[a] += 1.0 / kSpacing;
                    std::array<double, 8> difference = shares(moved);
                    for (std::size_t k = 0; k < 8; ++k) difference[k] -= here[k];
                    const double conductance = sigma * sigma * std::sqrt(p[c] * q);
                    for (std::size_t i = 0; i < 8; ++i)
                        for (std::size_t j = 0; j < 8; ++j)
                            energy[element][8 * i + j] += conductance * difference[i] * difference[j];
                }
            }
    const auto node = [&](int i, int j, int l, std::size_t k) {
        const int ni = std::min(i + static_cast<int>(k & 1), nodes_[0] - 1),
                  nj = std::min(j + static_cast<int>(k >> 1 & 1), nodes_[1] - 1),
                  nl = std::min(l + static_cast<int>(k >> 2), nodes_[2] - 1);
        return static_cast<std::size_t>((ni * nodes_[1] + nj) * nodes_[2] + nl);
    };
    std::vector<double> mass(static_cast<std::size_t>(nodes_[0] * nodes_[1] * nodes_[2]), 0.0);
    const auto for_elements = [&](auto&& f) {
        std::size_t e = 0;
        for (int i = 0; i < elements[0]; ++i)
            for (int j = 0; j < elements[1]; ++j)
                for (int l = 0; l < elements[2]; ++l, ++e) f(i, j, l, e);
    };
    for_elements([&](int i, int j, int l, std::size_t e) {
        for (std::size_t k = 0; k < 8; ++k) mass[node(i, j, l, k)] += masses[e][k];
    });
    number_.assign(mass.size(), -1);
    for (std::size_t k = 0; k < mass.size(); ++k)
        if (mass[k] >= kLeastMass) number_[k] = static_cast<int>(unknowns_++);
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t k = 0; k < mass.size(); ++k)
        if (number_[k] >= 0) entries.emplace_back(number_[k], number_[k], kAnchor * mass[k]);
    for_elements([&](int i, int j, int l, std::size_t e) {
        for (std::size_t s = 0; s < 8; ++s)
            for (std::size_t t = 0; t < 8; ++t) {
                const int row = number_[node(i, j, l, s)], column = number_[node(i, j, l, t)];
                if (row >= column && column >= 0 && energy[e][8 * s + t] != 0.0)
                    entries.emplace_back(row, column, energy[e][8 * s + t]);
            }
    });
    Eigen::SparseMatrix<double> matrix(unknowns_, unknowns_);  // its lower triangle
    matrix.setFromTriplets(entries.begin(), entries.end());
    factor_.compute(matrix);
    if (factor_.info() != Eigen::Success) unknowns_ = 0;  // conjugate gradients go on without
}

double CoarseCorrection::apply(const double* r, double* z) const {
    const int ny = cells_[1], nz = cells_[2], across = nodes_[2];
    std::vector<double> nodal(number_.size(), 0.0), line(static_cast<std::size_t>(across) + 1);
    // f(row, first of four lines of nodes, their shares), row by row along z.
    const auto for_rows = [&](auto&& f) {
        for (int x = 0; x < cells_[0]; ++x)
            for (int y = 0; y < ny; ++y) {
                const Line &lx = lines_[0][static_cast<std::size_t>(x)], &ly = lines_[1][static_cast<std::size_t>(y)];
                const int i = std::min(lx.low + 1, nodes_[0] - 1), j = std::min(ly.low + 1, nodes_[1] - 1);
                const double hx = lx.high_share, hy = ly.high_share;
                f(static_cast<std::size_t>((x * ny + y) * nz),
                  std::array<double*, 4>{nodal.data() + (lx.low * nodes_[1] + ly.low) * across,
                                         nodal.data() + (lx.low * nodes_[1] + j) * across,
                                         nodal.data() + (i * nodes_[1] + ly.low) * across,
                                         nodal.data() + (i * nodes_[1] + j) * across},
                  std::array<double, 4>{(1 - hx) * (1 - hy), (1 - hx) * hy, hx * (1 - hy), hx * hy});
            }
    };
    const Line* along = lines_[2].data();
    double product = 0.0;
    for_rows([&](std::size_t row, const std::array<double*, 4>& to, const std::array<double, 4>& share) {
        std::fill(line.begin(), line.end(), 0.0);
        for (int l = 0; l < nz; ++l) {
            const double t = p_[row + static_cast<std::size_t>(l)] * r[row + static_cast<std::size_t>(l)];
            double* at = line.data() + along[l].low;
            at[0] += (1 - along[l].high_share) * t, at[1] += along[l].high_share * t;
        }
        for (std::size_t k = 0; k < 4; ++k)
            for (int l = 0; l < across; ++l) to[k][l] += share[k] * line[static_cast<std::size_t>(l)];
    });
    Eigen::VectorXd b(unknowns_);
    for (std::size_t k = 0; k < number_.size(); ++k)
        if (number_[k] >= 0) b[number_[k]] = nodal[k];
    const Eigen::VectorXd y = unknowns_ > 0 ? Eigen::VectorXd(factor_.solve(b)) : b;
    for (std::size_t k = 0; k < number_.size(); ++k) nodal[k] = number_[k] >= 0 ? y[number_[k]] : 0.0;
    for_rows([&](std::size_t row, const std::array<double*, 4>& from, const std::array<double, 4>& share) {
        for (int l = 0; l < across; ++l)
            line[static_cast<std::size_t>(l)] =
                (share[0] * from[0][l] + share[1] * from[1][l]) + (share[2] * from[2][l] + share[3] * from[3][l]);
        for (int l = 0; l < nz; ++l) {
            const double* at = line.data() + along[l].low;
            const std::size_t c = row + static_cast<std::size_t>(l);
            z[c] = r[c] + ((1 - along[l].high_share) * at[0] + along[l].high_share * at[1]);
            product += p_[c] * r[c] * z[c];
        }
    });
    return product;
}

}  // namespace dqa
