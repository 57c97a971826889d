// SPDX-License-Identifier: MIT
// A cell of the stability map for the barycentre: two ellipses, `separation` cells between their centres, in a plane
// box of 32 x 8 cells under a kernel of width sigma. Accurate: the density within 1e-4 of the oracle's (sum of
// differences; a density sums to 1) and the derivative of a linear functional of it by the weights within 1e-3.
//
// The oracle minimises the dual of the problem, sum_i alpha_i <p_i, log K exp x_i> over sum_i alpha_i x_i = 0, which is
// convex (e.g. Cuturi & Peyre 2016, "A smoothed dual approach for variational Wasserstein problems"), by Newton's
// method with dense logarithmic kernels and a dense factorisation; its derivative is a difference of its own answers.
// The textbook method is Solomon et al. 2015, algorithm 2, with the linear kernel, until the density changes by less
// than 1e-9; as in the public code of DiffAqua, the last density that is finite counts as the answer.
#pragma once

#include "trial.hpp"

namespace stability {

struct BarycenterTrial {
    double sigma = 0.4, separation = 0.0;  // cells
    bool reference = false;
};

Result run(const BarycenterTrial& trial);
// Largest difference between the oracle's marginals, for its test; infinity where it does not converge.
double check_oracle(const BarycenterTrial& trial);

}  // namespace stability
