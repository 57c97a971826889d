// SPDX-License-Identifier: MIT
// The estimate of what a threshold leaves out: against its definition, monotone, above the measured error, and the
// threshold that it suggests.
#include "motion/threshold.hpp"
#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;

Vector density_of(const std::shared_ptr<const ShapeSpace>& space) {
    return space->evaluate({0.6, 0.4}, 0.0, 1, nullptr).p_hat;
}

// Two sections of two cells: of full density and faint, and a section of two full cells.
void test_against_the_definition() {
    const Box box{{2, 2, 1}, 0.1};
    const Vector p{1.0, 0.05, 1.0, 1.0};
    SceneSettings scene;
    scene.planar = true;
    const double g = gain(0.05), taken = g;  // tau = 0.1: the faint cell goes, full cells stay as they are
    const double axis = g / (1.0 + g), near = axis * axis + 1.0 / 12.0, far = (1.0 - axis) * (1.0 - axis) + 1.0 / 12.0;
    const double d = taken * far / (near + g * far), mass = 1.0 + g;
    const double expected = std::sqrt(mass * d * d / (mass + 2.0));
    const double eta = ThresholdError(box, p, scene)(0.1);
    CHECK(eta >= expected && eta <= 2.0 * expected);  // the margin
    // Moduli count: a faint cell of stiffer material takes more with it.
    scene.young_of_cell = std::make_shared<const Vector>(Vector{1e6, 4e6, 1e6, 1e6});
    CHECK(ThresholdError(box, p, scene)(0.1) > 1.2 * eta);
    // One modulus for all does not.
    scene.young_of_cell = std::make_shared<const Vector>(Vector(4, 7e4));
    NEAR(ThresholdError(box, p, scene)(0.1) / eta, 1.0, 1e-14);
}

void test_grows_with_the_threshold() {
    for (const auto& space : {ellipsoid_space(), plane_space()}) {
        const ThresholdError error(space->box(), density_of(space), SceneSettings{});
        NEAR(error(0.0), 0.0, 0.0);
        double before = 0.0;
        for (double tau = 1e-5; tau < 0.5; tau *= 1.1) {
            const double eta = error(tau);
            CHECK(eta >= before && std::isfinite(eta));
            before = eta;
        }
        CHECK(before > 0.05 && before < 1.2);
    }
}

void test_suggestions() {
    const auto space = ellipsoid_space();
    const ThresholdError error(space->box(), density_of(space), SceneSettings{});
    double before = 0.0;
    for (double tolerance = 2e-4; tolerance < 0.3; tolerance *= 2.0) {
        const SuggestedThreshold s = suggest_threshold(error, tolerance);
        CHECK(s.error <= tolerance && s.error == error(s.threshold));
        CHECK(s.threshold >= before && s.threshold <= kMostThreshold);
        if (s.threshold > 0.0 && s.threshold < kMostThreshold) CHECK(error(1.0001 * s.threshold) > tolerance);
        before = s.threshold;
    }
    CHECK(before > 0.05);
    const SuggestedThreshold full = suggest_threshold(error, 1e-9), most = suggest_threshold(error, 0.999);
    CHECK(full.threshold == 0.0 && full.error == 0.0);
    CHECK(most.threshold == kMostThreshold && most.error == error(kMostThreshold));
}

// Displacements after ten steps, weighted by mass, against those of the full box.
void test_bounds_the_measured_error() {
    for (const auto& space : {ellipsoid_space(), plane_space()}) {
        SceneSettings scene;
        scene.tolerance = 1e-8;
        const auto swim = [&](double threshold) {
            scene.threshold = threshold;
            Simulation s(make_design(scene, {0.6, 0.4}, space));
            for (int step = 1; step <= 10; ++step) {
                const double ramp = std::min(1.0, step / 3.0);
                const Vector signals(static_cast<std::size_t>(space->n_signals()), ramp * std::sin(0.5 * step + 0.5));
                s.step({signals.data(), {}});
            }
            return s;
        };
        const Simulation exact = swim(0.0);
        const ThresholdError error(space->box(), exact.design().point().p_hat, scene);
        for (const double tau : {0.1, 0.02, 0.004}) {
            const Simulation got = swim(tau);
            const Design& d = got.design();
            double difference = 0.0, size = 0.0;
            for (std::size_t n = 0; n < d.set().node_ijk.size(); ++n) {
                const auto& at = d.set().node_ijk[n];
                const int box_node = d.set().box.node(at[0], at[1], at[2]);
                const std::size_t there =
                    3 *
                    static_cast<std::size_t>(exact.design().set().node_to_active[static_cast<std::size_t>(box_node)]);
                for (std::size_t a = 0; a < 3; ++a) {
                    const double u = got.q()[3 * n + a] - d.rest()[3 * n + a];
                    const double u_exact = exact.q()[there + a] - exact.design().rest()[there + a];
                    difference += d.mass()[n] * (u - u_exact) * (u - u_exact), size += d.mass()[n] * u_exact * u_exact;
                }
            }
            const double measured = std::sqrt(difference / size), eta = error(tau);
            print_message("%dD, threshold %g: %d cells, estimate %.2e, measured %.2e\n", space->box().dims, tau,
                          d.set().n_cells(), eta, measured);
            CHECK(measured <= eta && measured >= 0.1 * eta);
        }
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_against_the_definition),
        TEST(test_grows_with_the_threshold),
        TEST(test_suggestions),
        TEST(test_bounds_the_measured_error),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
