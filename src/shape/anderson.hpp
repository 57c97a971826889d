// SPDX-License-Identifier: MIT
// Anderson mixing (type II) of x <- T(x): minimises the weighted residual over the affine span of the last iterates.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace dqa {

class Anderson {
public:
    Anderson(std::size_t size, int window) : size_(size), window_(static_cast<std::size_t>(window)) {}

    void restart() { dx_.clear(), df_.clear(), gram_.resize(0, 0), have_last_ = false; }

    // x: iterate, f = T(x) - x; weight [size / k], the same for all k blocks; overwrites x with the next iterate.
    void step(std::vector<double>& x, const std::vector<double>& f, const std::vector<double>& weight);

private:
    double product(const std::vector<double>& a, const std::vector<double>& b, const std::vector<double>& weight) const;

    std::size_t size_, window_;
    bool have_last_ = false;
    std::vector<double> last_x_, last_f_;
    std::vector<std::vector<double>> dx_, df_;
    Eigen::MatrixXd gram_{0, 0};
};

}  // namespace dqa
