// SPDX-License-Identifier: MIT
// The velocity of the water over time: uniform, a table, or a function of the caller's. It is read once a step, at the
// step's start, and held during the step; whoever records the step records the value with it, so that recomputation
// and the adjoint need no second call.
#pragma once

#include <functional>
#include <vector>

#include "grid/box.hpp"

namespace dqa {

class WaterCurrent {
public:
    using Function = std::function<Vec3(double time)>;
    using Pullback = std::function<void(double time, const Vec3& bar)>;

    // The same at all times.
    explicit WaterCurrent(const Vec3& velocity = {});
    // Linear between velocities[k] at times[k], constant before the first and after the last. Throws ERROR_ARGUMENT
    // unless the times (s) increase strictly.
    WaterCurrent(std::vector<double> times, std::vector<Vec3> velocities);
    // pullback may be empty.
    WaterCurrent(Function function, Pullback pullback);

    // Velocity (m/s) at a time (s). Throws ERROR_ARGUMENT if the caller's function gives something not finite.
    Vec3 value(double time) const;
    // From a cotangent of value(time): added to table_bar [rows().size()] of a table, nothing for a function; and
    // handed to the caller's pullback of a function, nothing for a table.
    void table_pullback(double time, const Vec3& bar, std::vector<Vec3>& table_bar) const;
    void function_pullback(double time, const Vec3& bar) const;

    const std::vector<Vec3>& rows() const { return velocities_; }  // one of a uniform current, none of a function
    // The same table with other velocities.
    WaterCurrent with_rows(std::vector<Vec3> velocities) const { return WaterCurrent(times_, std::move(velocities)); }

private:
    struct Place {
        std::size_t row = 0;
        double share = 0.0;  // of the row after it
    };
    Place locate(double time) const;

    std::vector<double> times_;
    std::vector<Vec3> velocities_;
    Function function_;
    Pullback pullback_;
};

}  // namespace dqa
