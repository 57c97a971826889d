// SPDX-License-Identifier: MIT
#include "shape/refinement.hpp"

#include <limits>

#include "grid/error.hpp"

namespace dqa {

Refinement::Refinement(const Box& box, int factor) : box_(box), fine_(box), factor_(factor) {
    std::int64_t n = 1;
    for (int a = 0; a < 3; ++a) {
        if (a < box.dims) fine_.cells[static_cast<std::size_t>(a)] *= factor;
        n *= fine_.cells[static_cast<std::size_t>(a)];
    }
    if (n > std::numeric_limits<int>::max())
        fail(Status::ERROR_ARGUMENT,
             "refinement is %d: %d x %d x %d cells become %lld, expected at most %d; use a smaller one", factor,
             box.cells[0], box.cells[1], box.cells[2], static_cast<long long>(n), std::numeric_limits<int>::max());
    fine_.dx = 0.0;
}

int Refinement::holder(int fine_cell) const {
    const auto ijk = fine_.cell_ijk(fine_cell);
    return box_.cell(ijk[0] / factor_, ijk[1] / factor_, box_.dims == 3 ? ijk[2] / factor_ : ijk[2]);
}

std::vector<double> Refinement::sum(const std::vector<double>& fine) const {
    std::vector<double> out(static_cast<std::size_t>(box_.n_cells()), 0.0);
    for (int c = 0; c < fine_.n_cells(); ++c)
        out[static_cast<std::size_t>(holder(c))] += fine[static_cast<std::size_t>(c)];
    return out;
}

std::vector<double> Refinement::spread(const double* coarse) const {
    std::vector<double> out(static_cast<std::size_t>(fine_.n_cells()));
    for (int c = 0; c < fine_.n_cells(); ++c) out[static_cast<std::size_t>(c)] = coarse[holder(c)];
    return out;
}

std::vector<double> Refinement::mean(const std::vector<double>& fine) const {
    std::vector<double> out = sum(fine);
    const double per_cell = fine_.n_cells() / box_.n_cells();
    for (double& v : out) v /= per_cell;
    return out;
}

}  // namespace dqa
