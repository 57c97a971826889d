// SPDX-License-Identifier: MIT
#include "shape/tangent.hpp"

#include <algorithm>
#include <cmath>

namespace dqa {

void Tangent::centre(std::vector<double>& z) const {
    const std::size_t n = p_.size();
    parallel_chunks(threads_, static_cast<int>(which_.size()), 1, [&](int begin, int end) {
        for (std::size_t k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
            double sum = 0.0, mass = 0.0;
            for (std::size_t c = 0; c < n; ++c) sum += p_[c] * z[k * n + c], mass += p_[c];
            for (std::size_t c = 0; c < n; ++c) z[k * n + c] -= sum / mass;
        }
    });
}

void Tangent::project(std::vector<double>& z) const {
    over_cells([&](std::size_t begin, std::size_t end) {
        std::vector<double> mean(end - begin);  // not on the stack, of which a caller's thread may have little
        mean_of(z, begin, end, mean.data());
        if (joint_)
            for (std::size_t k = 0; k < which_.size(); ++k)
                for (std::size_t c = begin; c < end; ++c) z[k * p_.size() + c] -= mean[c - begin];
        return 0.0;
    });
    centre(z);
}

std::vector<double> Tangent::mean(const std::vector<double>& z) const {
    std::vector<double> out(p_.size());
    over_cells([&](std::size_t begin, std::size_t end) {
        mean_of(z, begin, end, out.data() + begin);
        return 0.0;
    });
    return out;
}

void Tangent::solve(std::vector<double>& y, std::vector<double>& r, double target,
                    const std::function<void(double)>& tick) const {
    const std::size_t n = p_.size();
    std::vector<double> d(size()), ld(size()), m(size());
    double rm = precondition(r, m), rr = product(r, r), best = rr;
    d = m;
    for (int iteration = 1, stalled = 0; rr > target && stalled < kPatience; ++iteration) {
        laplacian(d, ld);
        const double curvature = product(d, ld);  // d is in the subspace: P makes no difference
        if (!(curvature > 0)) break;
        const double step = rm / curvature;
        const auto advance = [&](std::size_t begin, std::size_t end) {
            std::vector<double> mean(end - begin);
            mean_of(ld, begin, end, mean.data());
            for (std::size_t k = 0; k < which_.size(); ++k)
                for (std::size_t c = begin; c < end; ++c) {
                    const std::size_t at = k * n + c;
                    y[at] += step * d[at], r[at] -= step * (ld[at] - mean[c - begin]);
                }
            return product(r, r, begin, end);
        };
        rr = over_cells(advance);
        if (iteration % kRefresh == 0) project(r), rr = product(r, r);  // rounding leads out of the subspace
        const double next = precondition(r, m), beta = next / rm;
        over_cells([&](std::size_t begin, std::size_t end) {
            for (std::size_t k = 0; k < which_.size(); ++k)
                for (std::size_t at = k * n + begin; at < k * n + end; ++at) d[at] = m[at] + beta * d[at];
            return 0.0;
        });
        rm = next;
        tick(std::sqrt(rr));
        stalled = rr < 0.5 * best ? 0 : stalled + 1;
        best = std::min(best, rr);
    }
}

double Tangent::precondition(const std::vector<double>& r, std::vector<double>& z) const {
    const std::size_t n = p_.size();
    return parallel_sum(threads_, static_cast<int>(which_.size()), 1, [&](int begin, int) {
        const std::size_t k = static_cast<std::size_t>(begin);
        return weights_[k] * correction_.apply(r.data() + k * n, z.data() + k * n);
    });
}

double Tangent::product(const std::vector<double>& y, const std::vector<double>& z, std::size_t begin,
                        std::size_t end) const {
    const std::size_t n = p_.size();
    double sum = 0.0;
    for (std::size_t k = 0; k < which_.size(); ++k) {
        // Eight sums side by side, so that the additions need not wait for one another.
        double part[8] = {};
        std::size_t c = begin;
        for (; c + 8 <= end; c += 8)
            for (std::size_t l = 0; l < 8; ++l) part[l] += p_[c + l] * y[k * n + c + l] * z[k * n + c + l];
        for (; c < end; ++c) part[0] += p_[c] * y[k * n + c] * z[k * n + c];
        sum +=
            weights_[k] * (((part[0] + part[1]) + (part[2] + part[3])) + ((part[4] + part[5]) + (part[6] + part[7])));
    }
    return sum;
}

void Tangent::mean_of(const std::vector<double>& z, std::size_t begin, std::size_t end, double* mean) const {
    std::fill(mean, mean + (end - begin), 0.0);
    if (!joint_) return;
    for (std::size_t k = 0; k < which_.size(); ++k)
        for (std::size_t c = begin; c < end; ++c) mean[c - begin] += weights_[k] * z[k * p_.size() + c];
}

}  // namespace dqa
