// SPDX-License-Identifier: MIT
// The smooth laws of drag and thrust against the Bezier curves over the exact angle.
#include "motion_fixtures.hpp"
#include "water/laws.hpp"

namespace {

using namespace fixtures;
using Ordinates = std::array<double, 4>;

constexpr Ordinates kDrag{0.05, 0.05, 1.85, 2.05}, kThrust{-0.8, -0.5, 0.1, 2.5};

double bezier(const Ordinates& b, double t) {
    const double s = 1 - t;
    return s * s * s * b[0] + 3 * s * s * t * b[1] + 3 * s * t * t * b[2] + t * t * t * b[3];
}
double exact_drag(const Ordinates& b, double x) {
    return bezier(b, std::fabs(std::asin(x)) / (0.5 * pi));
}
double exact_thrust(const Ordinates& b, double x) {
    return bezier(b, std::asin(x) / pi + 0.5);
}
double thrust(const WaterLaws& laws, double x) {
    return laws.thrust_rest() + x * laws.thrust_slope(x).value;
}

const double kPlaces[] = {0.0, 1e-12, 1e-3, 0.009, 0.0101, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.9999, 1 - 1e-9, 1.0};

void test_known_values() {
    const WaterLaws laws(kDrag, kThrust, 0.02);
    NEAR(laws.drag(0.0).value, 0.05, 1e-15);
    NEAR(laws.drag(1.0).value, 2.05, 1e-3);  // |t|^3 is rounded: eps^2 / 2 of the cubic term
    NEAR(laws.drag(-1.0).value, laws.drag(1.0).value, 1e-14);
    NEAR(thrust(laws, 0.0), bezier(kThrust, 0.5), 1e-15);
    NEAR(thrust(laws, 1.0), 2.5, 1e-13);  // exact at +-pi/2 by the rescaled angle
    NEAR(thrust(laws, -1.0), -0.8, 1e-13);
}

// The largest difference from the exact curve is of the order of epsilon: proportional to it, and small for it.
void test_difference_of_order_epsilon() {
    Random random{1};
    for (int round = 0; round < 20; ++round) {
        Ordinates drag{}, push{};
        for (double& b : drag) b = between(random, 0, 2);
        push[0] = random();
        for (std::size_t k = 1; k < 4; ++k) push[k] = push[k - 1] + between(random, 0, 1);
        if (round == 0) drag = kDrag, push = kThrust;
        double difference[2][2] = {{0, 0}, {0, 0}};
        for (int k = 0; k < 2; ++k) {
            const double epsilon = k ? 0.01 : 0.02;
            const WaterLaws laws(drag, push, epsilon);
            for (int i = -4000; i <= 4000; ++i) {
                const double x = std::sin(i * pi / 8000);
                difference[0][k] = std::max(difference[0][k], std::fabs(laws.drag(x).value - exact_drag(drag, x)));
                difference[1][k] = std::max(difference[1][k], std::fabs(thrust(laws, x) - exact_thrust(push, x)));
            }
            // Slopes of the curves are at most 3 * the largest step between ordinates, over pi/2 and over pi.
            CHECK(difference[0][k] <= 12.0 * epsilon && difference[1][k] <= 6.0 * epsilon);
        }
        CHECK(difference[0][1] <= 0.65 * difference[0][0] && difference[0][1] > 0);
        CHECK(difference[1][1] <= 0.65 * difference[1][0] && difference[1][1] > 0);
    }
}

void test_derivatives() {
    const Ordinates odd{0.3, 0.9, 0.2, 1.4};  // a drag curve with a slope at 0
    for (const Ordinates& drag : {kDrag, odd}) {
        const WaterLaws laws(drag, kThrust, 0.02);
        for (const double place : kPlaces)
            for (const double x : {place, -place}) {
                const LawValue d = laws.drag(x), t = laws.thrust_slope(x);
                CHECK(std::isfinite(d.value) && std::isfinite(d.derivative));
                CHECK(std::isfinite(t.value) && std::isfinite(t.derivative));
                if (std::fabs(x) > 0.9999) continue;  // no room for a stencil; see below
                const double step = 0.02 * (1 - std::fabs(x));
                if (std::fabs(x) > 1e-6)
                    CHECK_DERIVATIVE([&](double e) { return laws.drag(x + e).value; }, d.derivative, step);
                else
                    NEAR(five_point([&](double e) { return laws.drag(x + e).value; }, 1e-3), d.derivative, 1e-9);
                NEAR(five_point([&](double e) { return laws.thrust_slope(x + e).value; }, step), t.derivative,
                     1e-6 * std::max(0.1, std::fabs(t.derivative)));
            }
        // One-sided at the ends, where the unrounded laws have infinite slope.
        for (const double end : {1.0, -1.0}) {
            const double e = -1e-7 * end;
            const auto one_sided = [&](auto&& f) {
                return (-25 * f(end) + 48 * f(end + e) - 36 * f(end + 2 * e) + 16 * f(end + 3 * e) -
                        3 * f(end + 4 * e)) /
                       (12 * e);
            };
            const double d = one_sided([&](double x) { return laws.drag(x).value; });
            const double t = one_sided([&](double x) { return laws.thrust_slope(x).value; });
            NEAR(laws.drag(end).derivative, d, 1e-6 * std::fabs(d));
            NEAR(laws.thrust_slope(end).derivative, t, 1e-6 * std::fabs(t));
        }
    }
    report_worst("laws");
}

// Around the switch from the series to the quotient both say the same.
void test_series_of_the_slope() {
    const WaterLaws laws(kDrag, kThrust, 0.02);
    const double x = 0.01 / std::cos(0.02);
    for (const double sign : {1.0, -1.0}) {
        const LawValue in = laws.thrust_slope(sign * x * (1 - 1e-9)), out = laws.thrust_slope(sign * x * (1 + 1e-9));
        NEAR(in.value, out.value, 1e-10);
        NEAR(in.derivative, out.derivative, 1e-8);
    }
}

// A monotone curve gives T >= 0: the dissipation is convex.
void test_slope_is_not_negative() {
    Random random{2};
    for (int round = 0; round < 200; ++round) {
        Ordinates push{random(), 0, 0, 0};
        for (std::size_t k = 1; k < 4; ++k)
            push[k] = push[k - 1] + (round % 4 == static_cast<int>(k) ? 0.0 : between(random, 0, 2));
        const WaterLaws laws(kDrag, push, round % 2 ? 0.02 : 1e-4);
        for (int i = -200; i <= 200; ++i) CHECK(laws.thrust_slope(i / 200.0).value >= 0.0);
    }
    const WaterLaws flat(kDrag, {0.7, 0.7, 0.7, 0.7}, 0.02);
    for (const double x : kPlaces) NEAR(flat.thrust_slope(x).value, 0.0, 1e-15);
}

// Linear in the ordinates: the pullback gives each law back exactly, and its directional derivatives.
void test_ordinates_pullback() {
    Random random{10};
    for (int round = 0; round < 60; ++round) {
        Ordinates drag, push, ddrag, dpush;
        for (std::size_t k = 0; k < 4; ++k)
            drag[k] = random(), push[k] = random(), ddrag[k] = random(), dpush[k] = random();
        const double x = round < 14 ? kPlaces[round] : random(), epsilon = round % 2 ? 0.02 : 0.2;
        const double bars[3] = {random(), random(), random()};
        dqa::LawsBar bar;
        WaterLaws(drag, push, epsilon).pullback(x, bars[0], bars[1], bars[2], bar);
        Ordinates drag_bar{}, push_bar{};
        WaterLaws::ordinates_pullback(bar, drag_bar, push_bar);
        const auto value = [&](double e) {
            Ordinates d = drag, p = push;
            for (std::size_t k = 0; k < 4; ++k) d[k] += e * ddrag[k], p[k] += e * dpush[k];
            const WaterLaws laws(d, p, epsilon);
            return bars[0] * laws.drag(x).value + bars[1] * laws.thrust_slope(x).value + bars[2] * laws.thrust_rest();
        };
        double slope = 0.0, here = 0.0;
        for (std::size_t k = 0; k < 4; ++k) {
            slope += drag_bar[k] * ddrag[k] + push_bar[k] * dpush[k];
            here += drag_bar[k] * drag[k] + push_bar[k] * push[k];
        }
        NEAR(here, value(0.0), 1e-13);
        CHECK_LINEAR_DERIVATIVE(value, slope, 1.0);
    }
    report_worst("ordinates");
}

// The curves are judged, not their ordinates: against a fine sampling of the rounded laws.
void test_curves_are_checked() {
    Random random{9};
    int refused = 0, negative_ordinate = 0;
    for (int round = 0; round < 4000; ++round) {
        Ordinates drag, push;
        for (double& b : drag) b = between(random, -0.25, 1.0);
        for (double& b : push) b = random();
        if (round % 2) std::sort(push.begin(), push.end());
        if (round % 4 == 1) std::swap(push[1], push[2]);  // may still rise
        const double epsilon = round % 3 ? 0.02 : 0.3;
        const WaterLaws laws(drag, push, epsilon);
        double least = 1e9, fall = 0.0;
        for (int i = 0; i <= 2000; ++i) {
            const double angle = i * pi / 4000;
            least = std::min(least, laws.drag(std::sin(angle)).value);
            fall = std::min(fall, bezier(push, (i + 1) / 2001.0) - bezier(push, i / 2001.0));
        }
        const auto accepted = [&](const Ordinates& d, const Ordinates& t) {
            try {
                dqa::check_water_curves(d, t, epsilon);
                return true;
            } catch (const dqa::Error& e) {
                CHECK(e.status() == dqa::Status::ERROR_ARGUMENT);
                return false;
            }
        };
        if (std::fabs(least) > 1e-5) {
            CHECK(accepted(drag, kThrust) == (least > 0));
            refused += least < 0;
            negative_ordinate += least > 0 && *std::min_element(drag.begin(), drag.end()) < 0;
        }
        if (fall < -1e-6) CHECK(!accepted(kDrag, push));
        if (fall == 0.0) CHECK(accepted(kDrag, push));
    }
    CHECK(refused > 500 && negative_ordinate > 500);
    dqa::check_water_curves({0, 0, 0, 0}, {0.3, 0.3, 0.3, 0.3}, 0.02);
    dqa::check_water_curves({0, 0, 0, 1}, {0.0, 1.0, 0.0, 1.0 + 1e-12}, 0.02);  // slope (1 - 2 s)^2: touches 0
    // Ordinates >= 0, but rounding |t| takes 3 eps off a curve that ends in 0.
    EXPECT_ERROR(ERROR_ARGUMENT, "angle_smoothing", dqa::check_water_curves({0, 1, 0, 0}, kThrust, 0.02));
    EXPECT_ERROR(ERROR_ARGUMENT, "drag_coefficients", dqa::check_water_curves({0, 1, std::nan(""), 0}, kThrust, 0.02));
    EXPECT_ERROR(ERROR_ARGUMENT, "thrust_coefficients", dqa::check_water_curves(kDrag, {0, 1, 2, std::nan("")}, 0.02));
    EXPECT_ERROR(ERROR_ARGUMENT, "thrust_coefficients", dqa::check_water_curves(kDrag, {0, 1, 0, 1 - 1e-9}, 0.02));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_known_values),        TEST(test_difference_of_order_epsilon), TEST(test_derivatives),
        TEST(test_series_of_the_slope), TEST(test_slope_is_not_negative),       TEST(test_ordinates_pullback),
        TEST(test_curves_are_checked),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
