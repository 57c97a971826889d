// SPDX-License-Identifier: MIT
// The interpolation on cells finer than the box's: the sums and their transposes, what a finer space keeps, the comb
// that a kernel narrower than its cells makes and finer ones do not, its derivative, and what it refuses.
#include "density_fixtures.hpp"
#include "derivative_checks.hpp"
#include "shape/refinement.hpp"
#include "shape/shape_space.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Vector;

const Cells small{14, 8, 9};

ShapeSettings settings_of(const Cells& cells, int refinement, double sigma) {
    ShapeSettings s;
    s.cells = cells, s.refinement = refinement, s.sigma = sigma, s.max_iterations = 20000;
    return s;
}

ShapeSpace two_bodies(int refinement, double sigma, Peak peak = Peak::smooth) {
    ShapeSettings s = settings_of(small, refinement, sigma);
    s.peak = peak;
    ShapeSpace space(s);
    space.add_fractions("long", soft_ellipsoid(small, {7, 4, 4.5}, {5.6, 1.7, 2.3}).data());
    space.add_fractions("high", soft_ellipsoid(small, {6.7, 3.9, 4.8}, {4.2, 1.5, 3.4}).data());
    space.build(nullptr);
    return space;
}

// <sum x, y> = <x, spread y>, in three dimensions and in the plane; sums keep the total.
void test_transposes() {
    derivative::Random random(3);
    for (const Box& box : {Box{{5, 4, 3}, 0.1, 3}, Box{{5, 4, 1}, 0.1, 2}})
        for (const int factor : {1, 2, 3}) {
            const Refinement r(box, factor);
            CHECK(r.box().n_cells() == box.n_cells() * (box.dims == 3 ? factor * factor * factor : factor * factor));
            const Vector x = random.vector(static_cast<std::size_t>(r.box().n_cells()));
            const Vector y = random.vector(static_cast<std::size_t>(box.n_cells()));
            const Vector down = r.sum(x), up = r.spread(y.data());
            CHECK(down.size() == y.size() && up.size() == x.size());
            NEAR(derivative::dot(down, y), derivative::dot(x, up), 1e-13);
            const Vector back = r.mean(up);
            for (std::size_t c = 0; c < y.size(); ++c) NEAR(back[c], y[c], 1e-15);
            if (factor == 1) CHECK(down == x && back == y);
        }
    // The cells that are summed are those within the cell.
    const Refinement r({{2, 2, 2}, 1.0, 3}, 2);
    Vector x(64, 0.0);
    x[static_cast<std::size_t>(r.box().cell(3, 0, 1))] = 5.0;
    CHECK((r.sum(x) == Vector{0, 0, 0, 0, 5, 0, 0, 0}));
}

// A mesh keeps its place, its length and its covered fractions; so does a polygon.
void test_bases() {
    const TriangleMesh body = ellipsoid({1.3, 0.4, 0.7});
    ShapeSettings s = settings_of({24, 10, 16}, 1, 0.5), fine = s;
    fine.refinement = 2;
    ShapeSpace one(s), two(fine);
    for (ShapeSpace* space : {&one, &two}) space->add_mesh("body", body), space->build(nullptr);
    const BaseShape &a = one.bases()[0], &b = two.bases()[0];
    NEAR(b.length_in_cells, a.length_in_cells, 1e-12);
    NEAR(two.box().dx, one.box().dx, 1e-14);
    CHECK(a.fine.empty() && b.fine.size() == 8 * a.fractions.size());
    for (std::size_t c = 0; c < a.fractions.size(); ++c) NEAR(b.fractions[c], a.fractions[c], 1e-6);
    NEAR(sum(b.density), 1, 1e-12);

    s.dims = fine.dims = 2, s.cells[2] = fine.cells[2] = 1, fine.refinement = 3;
    ShapeSpace plane(s), fine_plane(fine);
    for (ShapeSpace* space : {&plane, &fine_plane})
        space->add_polygon("kite", {{-1.2, 0}, {0.3, -0.4}, {0.9, 0.1}, {0.2, 0.5}}), space->build(nullptr);
    const Vector &f = plane.bases()[0].fractions, &g = fine_plane.bases()[0].fractions;
    for (std::size_t c = 0; c < f.size(); ++c) NEAR(g[c], f[c], 1e-12);
}

// Two bars of one cross-section, one half as long again as the other: between them the density is uniform along the
// middle of the body, but for the ripple of a kernel that its cells do not resolve.
double ripple(int refinement, double sigma) {
    const Cells cells{34, 8, 8};
    ShapeSpace space(settings_of(cells, refinement, sigma));
    for (const int half : {8, 14}) {
        Vector bar(static_cast<std::size_t>(34 * 8 * 8), 0.0);
        for (int i = 17 - half; i < 17 + half; ++i)
            for (int j = 2; j < 6; ++j)
                for (int k = 2; k < 6; ++k) bar[static_cast<std::size_t>((i * 8 + j) * 8 + k)] = 1.0;
        space.add_fractions("bar", bar.data());
    }
    space.build(nullptr);
    const Vector p = space.evaluate({0.55, 0.45}, 0, 0, nullptr).p_hat;
    double least = HUGE_VAL, most = 0.0;
    for (int i = 17 - 6; i < 17 + 6; ++i) {
        const double value = p[static_cast<std::size_t>((i * 8 + 3) * 8 + 3)];
        least = std::min(least, value), most = std::max(most, value);
    }
    return (most - least) / (most + least);
}

void test_comb() {
    const double narrow = ripple(1, 0.4), wider = ripple(1, 0.5), finer = ripple(2, 0.4);
    print_message("ripple of a stretched bar: %.4f at sigma = 0.4 cells, %.4f at 0.5, %.1e at 0.4 on finer cells\n",
                  narrow, wider, finer);
    // 2 exp(-2 pi^2 sigma^2) is 0.085 at 0.4, 0.014 at 0.5 and 7e-6 at 0.8.
    CHECK(narrow > 0.04 && narrow < 0.12);
    CHECK(wider > 0.005 && wider < 0.025);
    CHECK(finer < 2e-4);
}

void test_evaluate() {
    for (const Peak peak : {Peak::smooth, Peak::paper}) {
        const ShapeSpace space = two_bodies(2, 0.5, peak);
        const ShapePoint p = space.evaluate({0.4, 0.6}, 0, 0, nullptr);
        CHECK(p.barycenter.p.size() == 8 * p.p_hat.size() && p.barycenter.marginal_error <= 1e-9);
        NEAR(sum(p.p_hat) * p.peak, 1, 1e-8);
        CHECK(space.evaluate({0.4, 0.6}, 0, 3, nullptr).p_hat == p.p_hat);
    }
    // Without finer cells it is the barycentre's own density, to the last bit.
    const ShapePoint p = two_bodies(1, 0.5).evaluate({0.4, 0.6}, 0, 0, nullptr);
    CHECK(p.p_hat.size() == p.barycenter.p.size());
    for (std::size_t c = 0; c < p.p_hat.size(); ++c) CHECK(p.p_hat[c] == p.barycenter.p[c] / p.peak);
}

void test_gradient() {
    for (const int refinement : {2, 3}) {
        const ShapeSpace space = two_bodies(refinement, 0.5);
        derivative::Options options;
        options.noise = 1e-12, options.step = 0.04, options.taylor_step = 0.02;
        options.directions = {{1, -1}};
        derivative::check_pullback(
            "refined shape space", [&](const Vector& a) { return space.evaluate(a, 1e-13, 1, nullptr).p_hat; },
            [&](const Vector& a, const Vector& bar) {
                return space.pullback(space.evaluate(a, 1e-13, 1, nullptr), bar.data(), {}, 1e-13, 1, nullptr);
            },
            {0.4, 0.6}, options);
    }
}

void test_refusals() {
    EXPECT_ERROR(ERROR_ARGUMENT, "refinement is 4: 512 x 512 x 512 cells become 8589934592",
                 Refinement({{512, 512, 512}, 1.0, 3}, 4));
    Refinement({{512, 512, 1}, 1.0, 2}, 4);
    ShapeSpace space(settings_of(small, 2, 0.5));
    Vector cells = soft_ellipsoid(small, {7, 4, 4.5}, {5.6, 1.7, 2.3});
    cells[77] = 1.5;
    EXPECT_ERROR(ERROR_ARGUMENT, "cells[77] is 1.5", space.add_fractions("x", cells.data()));
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_transposes), TEST(test_bases),    TEST(test_comb),
        TEST(test_evaluate),   TEST(test_gradient), TEST(test_refusals),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
