// SPDX-License-Identifier: MIT
// Currents over time: interpolation and its ends, the table's pullback, and functions of the caller's.
#include <limits>

#include "motion_fixtures.hpp"
#include "water/current.hpp"

namespace {

using namespace fixtures;
using dqa::WaterCurrent;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();

void test_values() {
    const WaterCurrent still, uniform({0.1, -0.2, 0.3});
    CHECK(still.value(3.0) == (Vec3{}) && uniform.value(-7.0) == (Vec3{0.1, -0.2, 0.3}));
    const WaterCurrent table({0.5, 1.0, 3.0}, {{1, 0, -1}, {2, 4, 0}, {0, 0, 8}});
    CHECK(table.value(-1e9) == (Vec3{1, 0, -1}) && table.value(0.5) == (Vec3{1, 0, -1}));
    CHECK(table.value(1.0) == (Vec3{2, 4, 0}));
    CHECK(table.value(3.0) == (Vec3{0, 0, 8}) && table.value(1e9) == (Vec3{0, 0, 8}));
    CHECK(table.value(0.75) == (Vec3{1.5, 2, -0.5}) && table.value(1.5) == (Vec3{1.5, 3, 2}));
    // Continuous at the knots.
    for (const double t : {0.5, 1.0, 3.0})
        for (std::size_t k = 0; k < 3; ++k) NEAR(table.value(t - 1e-12)[k], table.value(t)[k], 1e-10);
}

void test_table_pullback() {
    Random random{1};
    const std::vector<double> times = {0.0, 0.1, 0.4, 0.45};
    std::vector<Vec3> rows(4), direction(4);
    for (auto* table : {&rows, &direction})
        for (Vec3& v : *table) v = {random(), random(), random()};
    for (const double t : {-1.0, 0.0, 0.03, 0.1, 0.22, 0.4, 0.449, 0.45, 2.0}) {
        const Vec3 bar = {random(), random(), random()};
        const auto value = [&](double e) {
            std::vector<Vec3> moved = rows;
            for (std::size_t r = 0; r < 4; ++r)
                for (std::size_t k = 0; k < 3; ++k) moved[r][k] += e * direction[r][k];
            const Vec3 v = WaterCurrent(times, rows).with_rows(moved).value(t);
            return v[0] * bar[0] + v[1] * bar[1] + v[2] * bar[2];
        };
        const WaterCurrent table(times, rows);
        std::vector<Vec3> table_bar(table.rows().size());
        table.table_pullback(t, bar, table_bar);
        double slope = 0.0;
        for (std::size_t r = 0; r < 4; ++r)
            for (std::size_t k = 0; k < 3; ++k) slope += table_bar[r][k] * direction[r][k];
        CHECK_LINEAR_DERIVATIVE(value, slope, 1.0);
    }
}

void test_functions() {
    int calls = 0;
    Vec3 got{};
    const WaterCurrent gust(
        [&](double t) {
            ++calls;
            return Vec3{t, 2 * t, t > 5 ? kNan : 0.0};
        },
        [&](double t, const Vec3& bar) {
            got = {t, bar[0], bar[1]};
        });
    CHECK(gust.value(2.0) == (Vec3{2, 4, 0}) && calls == 1 && gust.rows().empty());
    EXPECT_ERROR(ERROR_ARGUMENT, "callback", gust.value(6.0));
    std::vector<Vec3> none;
    gust.table_pullback(3.0, {7, 8, 9}, none);
    CHECK(none.empty() && got == (Vec3{}));
    gust.function_pullback(3.0, {7, 8, 9});
    CHECK(got == (Vec3{3, 7, 8}));
    WaterCurrent([](double) { return Vec3{}; }, nullptr).function_pullback(1.0, {1, 1, 1});
    WaterCurrent({1, 2, 3}).function_pullback(1.0, {1, 1, 1});
}

void test_refusals() {
    EXPECT_ERROR(ERROR_ARGUMENT, "times", WaterCurrent(std::vector<double>{}, std::vector<Vec3>{}));
    EXPECT_ERROR(ERROR_ARGUMENT, "velocities", WaterCurrent({0.0}, {{}, {}}));
    EXPECT_ERROR(ERROR_ARGUMENT, "times[1]", WaterCurrent({0.0, 0.0}, {{}, {}}));
    EXPECT_ERROR(ERROR_ARGUMENT, "times[1]", WaterCurrent({0.0, kNan}, {{}, {}}));
    EXPECT_ERROR(ERROR_ARGUMENT, "times[0]", WaterCurrent({-kInf, 0.0}, {{}, {}}));
    EXPECT_ERROR(ERROR_ARGUMENT, "velocities[1]", WaterCurrent({0.0, 1.0}, {{}, {0.0, kInf, 0.0}}));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_values),
        TEST(test_table_pullback),
        TEST(test_functions),
        TEST(test_refusals),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
