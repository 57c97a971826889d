// SPDX-License-Identifier: MIT
// A design in motion: current state (q, v), clock, and the totals of the last step. Copyable: a copy continues alone.
#pragma once

#include <memory>
#include <vector>

#include "motion/stepper.hpp"

namespace dqa {

class Simulation {
public:
    explicit Simulation(std::shared_ptr<const Design> design);

    const Design& design() const { return stepper_.design(); }
    std::shared_ptr<const Design> shared_design() const { return design_; }
    const std::vector<double>& q() const { return q_; }  // [n_nodes][3] m
    const std::vector<double>& v() const { return v_; }  // [n_nodes][3] m/s
    long steps() const { return steps_; }
    double time() const { return static_cast<double>(steps_) * design().scene().time_step; }
    const WaterTotals& forces() const { return forces_; }

    // Sets the state and the clock to 0; sizes and finiteness are the caller's to check.
    void set_state(const double* q, const double* v);
    // One step; on an exception the state is that before the call.
    StepReport step(const double* signals);

private:
    std::shared_ptr<const Design> design_;
    Stepper stepper_;
    std::vector<double> q_, v_, q_new_;
    long steps_ = 0;
    WaterTotals forces_;
};

}  // namespace dqa
