// SPDX-License-Identifier: MIT
// Stateless pieces of first-order optimisation.
#pragma once

#include <cstdint>

namespace dqa {

// One Adam step (Kingma & Ba 2015, algorithm 1), in place; iteration counts from 1.
void adam_step(double* x, const double* gradient, const double* rates, double* first, double* second, std::int64_t n,
               std::int64_t iteration);
// Euclidean projection onto {x >= 0, sum x = 1}, in place (Held, Wolfe & Crowder 1974).
void project_simplex(double* x, std::int64_t n);

}  // namespace dqa
