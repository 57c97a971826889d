// SPDX-License-Identifier: MIT
#include "tape/reader.hpp"

#include <algorithm>

#include "tape/tape.hpp"

namespace dqa {
namespace {

// How many states s slots can give back when no step is computed more than r times: C(s + 1 + r, r) - 1, as far as
// `enough`.
long reach(long s, long r, long enough) {
    if (s < 0 || r < 0) return 0;
    double c = 1.0;
    for (long k = 1; k <= r; ++k) {
        c *= static_cast<double>(s + 1 + k) / static_cast<double>(k);
        if (c - 1.0 >= static_cast<double>(enough)) return enough;
    }
    return static_cast<long>(c + 0.5) - 1;
}

}  // namespace

long checkpoint_after(long n, long s) {
    long r = 1;
    while (reach(s, r, n) < n) ++r;
    // The left part has one repetition less to spend, the right part one slot less.
    const long least = std::max(0L, n - 1 - reach(s - 1, r, n)), most = std::min(n - 2, reach(s, r - 1, n));
    return 1 + std::clamp(n - 1 - reach(s - 1, r - 1, n), least, most);
}

void TapeReader::reset() {
    simulation_.reset();
    held_.clear();
    given_ = {};
    given_step_ = -1;
}

const State& TapeReader::state(long step) {
    if (given_step_ == step) return given_;
    while (!held_.empty() && held_.back().step > step) held_.pop_back();
    if (tape_->keeps(step)) {
        given_ = tape_->kept_state(step);
        given_step_ = step;
        return given_;
    }
    if (!held_.empty() && held_.back().step == step) {
        given_ = std::move(held_.back().state);
        given_step_ = step;
        held_.pop_back();  // its slot serves the states before it
        return given_;
    }
    long at = step;
    while (!tape_->keeps(at)) --at;
    const bool from_held = !held_.empty() && held_.back().step > at;
    if (from_held) at = held_.back().step;
    if (!simulation_) simulation_ = std::make_unique<Simulation>(tape_->shared_design());
    const long stands = simulation_->steps() - tape_->first_step();
    if (stands > at && stands < step)
        at = stands;  // reading forwards
    else
        simulation_->restore(from_held ? held_.back().state : tape_->kept_state(at), tape_->first_step() + at);
    given_step_ = -1;
    for (long slots = tape_->reader_slots() - static_cast<long>(held_.size()); at < step; --slots) {
        const long stop = slots > 0 && step - at > 1 ? at + checkpoint_after(step - at, slots) : step;
        for (; at < stop; ++at) {
            simulation_->step({tape_->actuation(at).data(), tape_->current(at)});
            tape_->count_recomputed();
        }
        if (at < step) held_.push_back({at, simulation_->state()});
    }
    given_ = simulation_->state();
    given_step_ = step;
    return given_;
}

}  // namespace dqa
