// SPDX-License-Identifier: MIT
#include "water/current.hpp"

#include <algorithm>
#include <cmath>

#include "grid/error.hpp"

namespace dqa {

WaterCurrent::WaterCurrent(const Vec3& velocity) : times_{0.0}, velocities_{velocity} {}

WaterCurrent::WaterCurrent(std::vector<double> times, std::vector<Vec3> velocities)
    : times_(std::move(times)), velocities_(std::move(velocities)) {
    if (times_.empty() || times_.size() != velocities_.size())
        fail(Status::ERROR_ARGUMENT,
             "times has %zu entries and velocities %zu rows, expected as many, and at least one", times_.size(),
             velocities_.size());
    for (std::size_t k = 0; k < times_.size(); ++k) {
        if (!std::isfinite(times_[k]))
            fail(Status::ERROR_ARGUMENT, "times[%zu] is %g, expected a time (s)", k, times_[k]);
        if (k > 0 && !(times_[k] > times_[k - 1]))
            fail(Status::ERROR_ARGUMENT, "times[%zu] is %g, expected more than %g, the time before it", k, times_[k],
                 times_[k - 1]);
        for (const double x : velocities_[k])
            if (!std::isfinite(x))
                fail(Status::ERROR_ARGUMENT, "velocities[%zu] holds %g, expected finite numbers (m/s)", k, x);
    }
}

WaterCurrent::WaterCurrent(Function function, Pullback pullback)
    : function_(std::move(function)), pullback_(std::move(pullback)) {}

WaterCurrent::Place WaterCurrent::locate(double time) const {
    const auto after = std::upper_bound(times_.begin(), times_.end(), time);
    if (after == times_.begin()) return {0, 0.0};
    const std::size_t row = static_cast<std::size_t>(after - times_.begin()) - 1;
    if (after == times_.end()) return {row, 0.0};
    return {row, (time - times_[row]) / (times_[row + 1] - times_[row])};
}

Vec3 WaterCurrent::value(double time) const {
    if (function_) {
        const Vec3 v = function_(time);
        for (const double x : v)
            if (!std::isfinite(x))
                fail(Status::ERROR_ARGUMENT, "current: the callback gave %g at time %g s, expected finite numbers", x,
                     time);
        return v;
    }
    const Place at = locate(time);
    if (at.share == 0.0) return velocities_[at.row];
    Vec3 v{};
    for (std::size_t k = 0; k < 3; ++k)
        v[k] = (1.0 - at.share) * velocities_[at.row][k] + at.share * velocities_[at.row + 1][k];
    return v;
}

void WaterCurrent::function_pullback(double time, const Vec3& bar) const {
    if (pullback_) pullback_(time, bar);
}

void WaterCurrent::table_pullback(double time, const Vec3& bar, std::vector<Vec3>& table_bar) const {
    if (function_) return;
    const Place at = locate(time);
    for (std::size_t k = 0; k < 3; ++k) {
        table_bar[at.row][k] += (1.0 - at.share) * bar[k];
        if (at.share > 0.0) table_bar[at.row + 1][k] += at.share * bar[k];
    }
}

}  // namespace dqa
