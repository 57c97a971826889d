// SPDX-License-Identifier: MIT
// Smooth peak, Schlick gain and the occupancy of a cell: values, edges and derivatives.
#include "derivative_checks.hpp"
#include "shape/occupancy.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Random;
using derivative::Vector;

// Fourth-order difference of a function of one variable.
template <class F>
double slope_of(F&& f, double t, double h) {
    return (8 * (f(t + h) - f(t - h)) - (f(t + 2 * h) - f(t - 2 * h))) / (12 * h);
}

void test_gain() {
    NEAR(gain(0), 0, 0);
    NEAR(gain(0.5), 0.5, 0);
    NEAR(gain(1), 1, 0);
    // Of the full stiffness at the edges of active sets.
    NEAR(gain(0.1), 0.0135, 5e-5);
    NEAR(gain(0.02), 0.0023, 5e-5);
    NEAR(gain(0.01), 0.0011, 5e-5);
    for (int k = 0; k <= 100; ++k) NEAR(gain(0.01 * k) + gain(1 - 0.01 * k), 1, 1e-15);  // point-symmetric about 1/2
    for (int k = 0; k < 120; ++k) CHECK(gain(0.01 * (k + 1)) > gain(0.01 * k));          // and above 1 it goes on
}

void test_gain_derivative() {
    for (const double t : {0.01, 0.1, 0.3, 0.45, 0.55, 0.7, 0.9, 0.99, 1.0, 1.05})
        NEAR(gain_derivative(t) / slope_of(gain, t, 1e-4), 1, 1e-8);
    // The branches meet with one slope, 9, and across t = 1 nothing happens.
    NEAR(gain_derivative(0.5), 9, 1e-14);
    NEAR(gain_derivative(std::nextafter(0.5, 0.0)), 9, 1e-12);
    NEAR(gain_derivative(1 - 1e-12), gain_derivative(1 + 1e-12), 1e-10);
}

// A plateau with small ripples, a rim and empty cells, as bodies have.
Vector body(std::uint64_t seed) {
    Random random(seed);
    Vector p = random.vector(40, 0.97, 1.0);
    for (const double x : random.vector(30, 0.0, 0.9)) p.push_back(x);
    p.resize(100, 0.0);
    for (double& x : p) x *= 1e-3;
    return p;
}

void test_peak() {
    const Vector p = body(1);
    const double top = *std::max_element(p.begin(), p.end());
    NEAR(peak_of(p, Peak::paper), top, 0);
    const double smooth = peak_of(p, Peak::smooth);
    CHECK(smooth < top && smooth > 0.98 * top);
    // By the definition.
    double upper = 0, lower = 0;
    for (const double x : p) upper += std::pow(1e3 * x, 65), lower += std::pow(1e3 * x, 64);
    NEAR(smooth * 1e3, upper / lower, 1e-13);
    // A uniform interior gives its value, and so does one cell; the unit does not matter, however small.
    NEAR(peak_of(Vector(50, 0.25), Peak::smooth), 0.25, 1e-16);
    NEAR(peak_of({0, 0.25, 0}, Peak::smooth), 0.25, 1e-16);
    Vector tiny = p;
    for (double& x : tiny) x *= 1e-200;
    NEAR(peak_of(tiny, Peak::smooth) / smooth * 1e200, 1, 1e-13);
    NEAR(peak_of(Vector(3, 0.0), Peak::smooth), 0, 0);
}

void check_normalisation(const Vector& p, Peak kind, const std::string& name) {
    const derivative::Map f = [&](const Vector& x) {
        Vector out = x;
        for (double& v : out) v /= peak_of(x, kind);
        return out;
    };
    derivative::Options options;
    options.step = options.taylor_step = 1e-4;  // of 1e-3
    derivative::check_pullback(
        name, f,
        [&](const Vector& x, const Vector& bar) { return normalise_pullback(x, peak_of(x, kind), kind, bar.data()); },
        p, options);
}

void test_normalisation_derivative() {
    check_normalisation(body(2), Peak::smooth, "smooth peak");
    Vector p = body(3);
    p[7] = 1.5e-3;  // the maximum has a derivative where it is reached once, by a margin
    check_normalisation(p, Peak::paper, "paper's peak");
    check_normalisation(p, Peak::smooth, "smooth peak over one cell");
    // p / M does not change with the scale of p: the pullback is orthogonal to p.
    p = body(4);
    Random random(5);
    const Vector bar = random.vector(p.size());
    for (const Peak kind : {Peak::smooth, Peak::paper}) {
        const Vector g = normalise_pullback(p, peak_of(p, kind), kind, bar.data());
        NEAR(derivative::dot(g, p) / (derivative::norm(g) * derivative::norm(p)), 0, 1e-13);
    }
}

void test_paper_peak_and_ties() {
    // Near-ties: the hard maximum puts its whole derivative on one cell, the smooth one spreads it evenly.
    const Vector p(200, 0.01), bar(200, 1.0);
    const Vector smooth = normalise_pullback(p, peak_of(p, Peak::smooth), Peak::smooth, bar.data());
    const Vector paper = normalise_pullback(p, peak_of(p, Peak::paper), Peak::paper, bar.data());
    for (const double g : smooth) NEAR(g, 0, 1e-9);
    NEAR(*std::min_element(paper.begin(), paper.end()), 100.0 - 200 * 100.0, 1e-8);
}

void test_occupancy_edges() {
    for (const double threshold : {0.1, 0.02, 0.01})
        for (const double floor : {1e-6, 1e-3}) {
            const Occupancy o(threshold, floor);
            CHECK(!o.active(threshold) && o.active(std::nextafter(threshold, 1.0)) && !o.active(0));
            // Outside of the active set a cell counts nothing: the jump is the floor, and the slope begins at zero.
            NEAR(o.value(std::nextafter(threshold, 1.0)), floor, 1e-15);
            NEAR(o.derivative(std::nextafter(threshold, 1.0)), 0, 1e-9);
            CHECK(o.derivative(threshold * 1.01) > 0);
            NEAR(o.value(1), 1, 1e-15);
            double last = 0;
            for (int k = 0; k <= 1000; ++k) {
                const double p = threshold + (1.1 - threshold) * k / 1000, value = o.value(p);
                CHECK(value >= floor && (k == 0 || value > last));
                last = value;
                // The gain's second derivative jumps at 1/2, where its branches meet; differences stay on one side.
                const double h = 1e-3 * (p - threshold);
                if (k > 0 && std::fabs(p - 0.5) > 2 * h)
                    NEAR(o.derivative(p) / slope_of([&](double t) { return o.value(t); }, p, h), 1, 1e-7);
            }
            const double share = (0.5 - gain(threshold)) / (1 - gain(threshold));
            NEAR(o.value(0.5), floor + (1 - floor) * 2 * share * share, 1e-14);  // nearly 1/2: the surface
        }
}

void test_occupancy_of_all_cells() {
    const double floor = 1e-6;
    const Occupancy o(0, floor);
    CHECK(o.active(0) && o.active(1e-300));
    for (int k = 0; k <= 100; ++k) {
        const double p = 0.01 * k;
        NEAR(o.value(p), floor + (1 - floor) * gain(p), 1e-15);
        NEAR(o.derivative(p), (1 - floor) * gain_derivative(p), 1e-12);
    }
    NEAR(o.derivative(0), (1 - floor) / 9, 1e-12);  // an empty cell that fills up is felt
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_gain),
        TEST(test_gain_derivative),
        TEST(test_peak),
        TEST(test_normalisation_derivative),
        TEST(test_paper_peak_and_ties),
        TEST(test_occupancy_edges),
        TEST(test_occupancy_of_all_cells),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
