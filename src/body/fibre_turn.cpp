// SPDX-License-Identifier: MIT
#include "body/fibre_turn.hpp"

#include <cmath>

namespace dqa {
namespace {

// As in the kernels of the muscle energy: the square of a fibre's relative length below which it has no direction, and
// what is added to the square to keep the length away from zero.
constexpr double kCrushed = 1e-22, kRounding = 1e-24;

using Gradients = std::array<std::array<Vec3, 8>, 8>;  // [Gauss point][corner], of a unit cell

Gradients shape_gradients() {
    const double g = 0.5 / std::sqrt(3.0);
    Gradients out;
    for (int p = 0; p < 8; ++p)
        for (int c = 0; c < 8; ++c)
            for (int axis = 0; axis < 3; ++axis) {
                double value = 1.0;
                for (int k = 0; k < 3; ++k) {
                    const double at = (p >> (2 - k) & 1) ? 0.5 + g : 0.5 - g;
                    const bool upper = c >> (2 - k) & 1;
                    value *= k == axis ? (upper ? 1.0 : -1.0) : (upper ? at : 1.0 - at);
                }
                out[static_cast<std::size_t>(p)][static_cast<std::size_t>(c)][static_cast<std::size_t>(axis)] = value;
            }
    return out;
}

// (sum over corners of x_c (grad N_c)^T) as a matrix.
void gradient_of(const double* x, const std::array<int, 8>& nodes, const std::array<Vec3, 8>& grad, double inv_dx,
                 double out[3][3]) {
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            double s = 0.0;
            for (std::size_t c = 0; c < 8; ++c) s += x[3 * static_cast<std::size_t>(nodes[c]) + i] * grad[c][j];
            out[i][j] = s * inv_dx;
        }
}

}  // namespace

// Per Gauss point, a = F m, b = (grad lambda) m, n = |a|, kept away from zero as in the energy: lambda . dE/dq is w (1
// - r/n) a.b, whose derivative by m is w [(1 - r/n) (F^T b + grad lambda^T a) + r (a.b) / n^3 F^T a].
void add_direction_bar(const ActiveSet& set, const std::vector<MuscleEntry>& muscles, double contraction,
                       const double* q, const double* lambda, const double* signals, std::vector<Vec3>& direction_bar) {
    static const Gradients gradients = shape_gradients();
    const double dx = set.box.dx, volume = dx * dx * dx / 8.0;
    for (std::size_t e = 0; e < muscles.size(); ++e) {
        const MuscleEntry& m = muscles[e];
        const auto& nodes = set.cell_nodes[static_cast<std::size_t>(m.cell)];
        const double rest = 1.0 - m.sign * contraction * signals[m.signal], w = m.weight * volume;
        for (const auto& grad : gradients) {
            double f[3][3], l[3][3];
            gradient_of(q, nodes, grad, 1.0 / dx, f);
            gradient_of(lambda, nodes, grad, 1.0 / dx, l);
            Vec3 a{}, b{};
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t j = 0; j < 3; ++j) a[i] += f[i][j] * m.direction[j], b[i] += l[i][j] * m.direction[j];
            const double square = a[0] * a[0] + a[1] * a[1] + a[2] * a[2], n = std::sqrt(square + kRounding);
            if (square < kCrushed) continue;
            const double ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            const double both = w * (1.0 - rest / n), turn = w * rest * ab / (n * n * n);
            for (std::size_t j = 0; j < 3; ++j)
                for (std::size_t i = 0; i < 3; ++i)
                    direction_bar[e][j] += both * (f[i][j] * b[i] + l[i][j] * a[i]) + turn * f[i][j] * a[i];
        }
    }
}

}  // namespace dqa
