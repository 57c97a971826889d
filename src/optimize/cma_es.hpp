// SPDX-License-Identifier: MIT
// Evolution strategy with covariance matrix adaptation: minimises f(x), x in R^n, from its values alone. Rank-one and
// rank-mu update with negative weights and all default constants of N. Hansen, "The CMA Evolution Strategy: A
// Tutorial", arXiv 1604.00772, table 1 and figure 6.
//
// Ours, although Debian has pagmo: there the algorithm calls the problem for whole generations, so that a value which
// takes seconds can be neither watched, interrupted nor had from another program; its normal numbers are those of the
// C++ library at hand and differ between libraries; and it brings Boost and TBB along.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "grid/random.hpp"

namespace dqa {

struct CmaEsSettings {
    int n = 0;           // unknowns, >= 1
    int population = 0;  // candidates a generation, >= 2; 0: 4 + floor(3 ln n)
    std::uint64_t seed = 1;
    double sigma = 0.3;  // first step size, in units of the scales
};

class CmaEs {
public:
    static constexpr int most_unknowns = 2048;
    static constexpr std::int64_t most_numbers = std::int64_t{1} << 26;  // unknowns times population
    static int default_population(int n);

    // mean [n]; scales [n] > 0: what a step of sigma = 1 means along each axis.
    CmaEs(const CmaEsSettings& settings, const double* mean, const double* scales);
    // Throws ERROR_IO, or ERROR_FILE for a file that save() did not write like this.
    static std::unique_ptr<CmaEs> load(const std::string& path);
    // All but candidates that were asked for: asking again gives the same.
    void save(const std::string& path) const;

    // The candidates [population][n] of this generation: the same until their values are told. Throws DIVERGED.
    void ask(double* candidates);
    // Their values [population]; +infinity for one that could not be evaluated. Ends the generation. Throws
    // ERROR_STATE unless they were asked for.
    void tell(const double* values);

    int n() const { return settings_.n; }
    int population() const { return settings_.population; }
    std::int64_t generation() const { return generation_; }  // finished ones
    double sigma() const { return sigma_; }
    const std::vector<double>& mean() const { return mean_; }
    const std::vector<double>& best() const { return best_; }  // empty before a finite value was told
    double best_value() const { return best_value_; }
    double axis_ratio() const;  // longest over shortest axis of the distribution
    double widest() const;      // largest standard deviation along a coordinate, relative to its scale
    bool asked() const { return asked_; }

private:
    explicit CmaEs(const CmaEsSettings& settings);
    void set_constants();
    void decompose();
    // C^(-1/2) y.
    void whiten(const double* y, double* out) const;

    CmaEsSettings settings_;
    // Constants of table 1.
    std::vector<double> weights_;  // [population], the first mu of them positive
    int mu_ = 0;
    double mu_eff_ = 0, c_c_ = 0, c_1_ = 0, c_mu_ = 0, c_sigma_ = 0, d_sigma_ = 0, norm_ = 0;
    std::int64_t decomposition_interval_ = 1;

    // The state. Coordinates are those of the caller divided by the scales.
    std::vector<double> scales_, mean_scaled_, mean_;
    double sigma_ = 0;
    std::vector<double> covariance_, axes_, lengths_;  // C [n][n]; B [n][n] by columns and D [n]: C = B D^2 B^T
    std::vector<double> path_sigma_, path_c_;
    std::int64_t generation_ = 0, decomposed_ = 0;
    Random random_{0};  // as it stood before this generation's candidates
    std::vector<double> best_;
    double best_value_;

    bool asked_ = false;
    Random random_next_{0};
    std::vector<double> steps_;  // [population][n]: y of each candidate
};

}  // namespace dqa
