// SPDX-License-Identifier: MIT
#include "shape/anderson.hpp"

#include <cmath>

#include "grid/symmetric_eigen.hpp"

namespace dqa {

void Anderson::step(std::vector<double>& x, const std::vector<double>& f, const std::vector<double>& weight) {
    if (have_last_) {
        std::vector<double> ex(size_), ef(size_);
        for (std::size_t c = 0; c < size_; ++c) ex[c] = x[c] - last_x_[c], ef[c] = f[c] - last_f_[c];
        if (dx_.size() == window_) {
            dx_.erase(dx_.begin()), df_.erase(df_.begin());
            const Eigen::Index keep = gram_.rows() - 1;
            gram_ = gram_.bottomRightCorner(keep, keep).eval();
        }
        dx_.push_back(std::move(ex));
        df_.push_back(std::move(ef));
        // Only the new row is formed, with the weight of now; older rows keep the weight of their time, which
        // differs little and only shapes the mixing.
        const Eigen::Index last = static_cast<Eigen::Index>(df_.size()) - 1;
        gram_.conservativeResize(last + 1, last + 1);
        for (Eigen::Index i = 0; i <= last; ++i)
            gram_(i, last) = gram_(last, i) = product(df_[static_cast<std::size_t>(i)], df_.back(), weight);
    }
    last_x_ = x, last_f_ = f, have_last_ = true;
    const Eigen::Index k = static_cast<Eigen::Index>(df_.size());
    Eigen::VectorXd gamma;
    if (k > 0) {
        Eigen::VectorXd right(k), scale(k);
        for (Eigen::Index i = 0; i < k; ++i) {
            right(i) = product(df_[static_cast<std::size_t>(i)], f, weight);
            scale(i) = gram_(i, i) > 0 ? 1.0 / std::sqrt(gram_(i, i)) : 0.0;
        }
        const Eigen::MatrixXd gram = scale.asDiagonal() * gram_ * scale.asDiagonal();
        const SymmetricEigen eigen = symmetric_eigen(gram);
        const Eigen::VectorXd projected = eigen.vectors.transpose() * scale.cwiseProduct(right);
        const double cut = 1e-14 * eigen.values.cwiseAbs().maxCoeff();
        Eigen::VectorXd scaled(k);
        for (Eigen::Index i = 0; i < k; ++i) scaled(i) = eigen.values(i) > cut ? projected(i) / eigen.values(i) : 0.0;
        gamma = scale.cwiseProduct(eigen.vectors * scaled);
    }
    for (std::size_t c = 0; c < size_; ++c) x[c] += f[c];
    for (Eigen::Index j = 0; j < k; ++j) {
        const std::vector<double>&ex = dx_[static_cast<std::size_t>(j)], &ef = df_[static_cast<std::size_t>(j)];
        const double g = gamma(j);
        for (std::size_t c = 0; c < size_; ++c) x[c] -= g * (ex[c] + ef[c]);
    }
}

double Anderson::product(const std::vector<double>& a, const std::vector<double>& b,
                         const std::vector<double>& weight) const {
    double s = 0.0;
    for (std::size_t at = 0; at < size_; at += weight.size())
        for (std::size_t c = 0; c < weight.size(); ++c) s += weight[c] * a[at + c] * b[at + c];
    return s;
}

}  // namespace dqa
