// SPDX-License-Identifier: MIT
// The textbook method's answer to a trial: plain projective dynamics of the full box, as the public code of DiffAqua
// runs it (bench/reference.hpp).
#include <cmath>

#include "../bench/reference.hpp"
#include "trial.hpp"

namespace stability {
namespace {

using bench::Field;
using bench::FieldState;

Field field_of(const Vector& a) {
    return Eigen::Map<const Field>(a.data(), 3, static_cast<Eigen::Index>(a.size() / 3));
}

Vector flat(const Field& f) {
    return {f.data(), f.data() + f.size()};
}

// The rollout; its backward sweep starts from the travel, minus the mean of the spine along x.
struct Rollout {
    bench::Reference reference;
    std::vector<FieldState> states{};
    std::vector<Vector> signals{};

    Rollout(const Trial& trial, const dqa::SceneSettings& scene) : reference(*trial.space, trial.weights, scene) {}
    Gradient gradient() {
        const Field zero = Field::Zero(3, reference.rest().cols());
        FieldState bar{zero, zero}, before;
        bar.q.row(0) = -reference.spine().transpose();
        Gradient out;
        for (std::size_t k = signals.size(); k-- > 0;) {
            Vector by_signal(signals[k].size(), 0.0);
            reference.adjoint(states[k], signals[k], states[k + 1], bar, before, by_signal);
            out.actuation.insert(out.actuation.begin(), by_signal.begin(), by_signal.end());
            std::swap(bar, before);
        }
        out.velocity = flat(bar.v);
        return out;
    }
};

}  // namespace

Answer answer_of_reference(const Trial& trial, Result& out) {
    Answer answer;
    try {
        dqa::SceneSettings scene = trial.scene;
        scene.threshold = 0.0;
        answer.design = std::make_shared<dqa::Design>(trial.space, trial.weights, scene, nullptr);
        const dqa::State start = trial.start_of(*answer.design);
        const auto rollout = std::make_shared<Rollout>(trial, scene);
        rollout->states.push_back({field_of(start.q), field_of(start.v)});
        answer.gradient = [rollout] { return rollout->gradient(); };
        dqa::BodyWorkspace workspace;
        Vector elastic(start.q.size()), muscle(start.q.size());
        for (int k = 0; k < trial.steps; ++k) {
            rollout->signals.push_back(trial.signals(*answer.design, k));
            FieldState next;
            const bench::ReferenceReport report =
                rollout->reference.step(rollout->states.back(), rollout->signals.back(), next);
            out.residual = std::max(out.residual, report.residual);
            out.max_speed = std::max(out.max_speed, next.v.colwise().norm().maxCoeff());
            answer.q.push_back(flat(next.q));
            answer.design->body().gradient(workspace, answer.q.back().data(), rollout->signals.back().data(), 1,
                                           elastic.data(), muscle.data());
            out.inverted = std::max(out.inverted, workspace.inverted);
            rollout->states.push_back(std::move(next));
        }
        out.outcome = Outcome::accurate;
    } catch (const dqa::Error& e) {
        report_error(e, out);
    }
    return answer;
}

}  // namespace stability
