// SPDX-License-Identifier: MIT
// The shape space as a whole: weights -> normalised density and actuators and back, what a vertex gives back, building,
// cancelling, and what it refuses. Its file is the subject of test_space_file.cpp.
#include "density_fixtures.hpp"
#include "derivative_checks.hpp"
#include "grid/number_text.hpp"
#include "shape/mesh_file.hpp"
#include "shape/shape_space.hpp"
#include "shape_fixtures.hpp"

namespace {

using namespace fixtures;
using derivative::Vector;

const Cells small{18, 8, 10};

ShapeSettings settings_of(const Cells& cells) {
    ShapeSettings s;
    s.cells = cells;
    return s;
}

// Three ellipsoids with muscles of their own; the second has a placed one, in another position and turned.
ShapeSpace three_bodies(double sigma, Peak peak = Peak::smooth, Interpolation interpolation = Interpolation::linear) {
    ShapeSettings s = settings_of(small);
    s.sigma = sigma, s.peak = peak, s.max_iterations = 20000, s.cell_size = 0.05;
    s.interpolation = interpolation;
    ShapeSpace space(s);
    space.add_fractions("long", soft_ellipsoid(small, {9, 4, 5}, {7.2, 1.7, 2.3}).data());
    space.add_fractions("round", soft_ellipsoid(small, {9.3, 4.2, 4.6}, {5.4, 2.4, 2.9}).data());
    space.add_fractions("high", soft_ellipsoid(small, {8.6, 3.9, 5.3}, {6.2, 1.5, 3.4}).data());
    Actuator a;
    a.mean = {-0.12, 0, 0.02}, a.variance = {0.01, 0.004, 0.007}, a.euler = {0.1, 0.2, -0.1};
    space.add_actuator(1, a);
    space.build(nullptr);
    return space;
}

template <class Point, class F>  // an ActuatorPoint or ActuatorBar
void each_entry(Point& a, const F& f) {
    for (std::size_t k = 0; k < 3; ++k) {
        f(a.mean[k]), f(a.half[k]);
        for (std::size_t j = 0; j < 3; ++j) f(a.normal[k][j]), f(a.edge[k][j]);
    }
    f(a.strength);
}

Vector row(const ShapePoint& p) {
    Vector out = p.p_hat;
    for (const ActuatorPoint& a : p.actuators) each_entry(a, [&](double x) { out.push_back(x); });
    return out;
}

void check_gradient(const ShapeSpace& space, const Vector& alpha, const std::vector<Vector>& directions,
                    bool one_sided) {
    derivative::Options options;
    options.noise = 1e-12, options.step = 0.04, options.taylor_step = 0.02;
    options.directions = directions, options.one_sided = one_sided;
    derivative::check_pullback(
        "shape space", [&](const Vector& a) { return row(space.evaluate(a, 1e-13, 1, nullptr)); },
        [&](const Vector& a, const Vector& bar) {
            const ShapePoint p = space.evaluate(a, 1e-13, 1, nullptr);
            std::vector<ActuatorBar> actuators(p.actuators.size());
            std::size_t at = p.p_hat.size();
            for (ActuatorBar& q : actuators) each_entry(q, [&](double& x) { x = bar[at++]; });
            CHECK(at == bar.size());
            const Vector g = space.pullback(p, bar.data(), actuators, 1e-13, 1, nullptr);
            NEAR(sum(g), 0, 1e-13 * derivative::norm(g));
            return g;
        },
        alpha, options);
}

void test_gradient_inside() {
    for (const double sigma : {0.6, 1.0})
        check_gradient(three_bodies(sigma, Peak::smooth, sigma < 1 ? Interpolation::linear : Interpolation::bures),
                       {0.5, 0.2, 0.3}, {{1, -1, 0}, {0.2, 0.5, -0.7}}, false);
}

void test_gradient_at_the_boundary() {
    const ShapeSpace space = three_bodies(0.8);
    check_gradient(space, {0, 1, 0}, {{0.4, -1, 0.6}}, true);
    check_gradient(space, {0.6, 0, 0.4}, {{-0.4, 0.9, -0.5}}, true);
}

void test_pullback_takes_parts() {
    const ShapeSpace space = three_bodies(0.8);
    const ShapePoint p = space.evaluate({0.5, 0.2, 0.3}, 1e-12, 1, nullptr);
    derivative::Random random(31);
    const Vector bar = random.vector(p.p_hat.size());
    ActuatorBar by_actuator;
    by_actuator.mean = {1, 2, 3}, by_actuator.half = {-4, 5, 6}, by_actuator.normal[1] = {0.1, -0.2, 0.3};
    const Vector zero(bar.size(), 0.0);
    const Vector density = space.pullback(p, bar.data(), {}, 1e-12, 1, nullptr);
    const Vector muscle = space.pullback(p, zero.data(), {by_actuator}, 1e-12, 1, nullptr);
    const Vector both = space.pullback(p, bar.data(), {by_actuator}, 1e-12, 1, nullptr);
    CHECK(derivative::norm(density) > 1e-3 && derivative::norm(muscle) > 1e-3);
    for (std::size_t i = 0; i < 3; ++i) NEAR(both[i], density[i] + muscle[i], 1e-12 * derivative::norm(both));
    CHECK(space.pullback(p, bar.data(), {by_actuator}, 1e-12, 3, nullptr) == both);
}

void test_evaluate() {
    for (const Peak peak : {Peak::smooth, Peak::paper}) {
        const ShapeSpace space = three_bodies(0.8, peak);
        const ShapePoint p = space.evaluate({0.5, 0.2, 0.3}, 0, 0, nullptr);
        CHECK(p.barycenter.marginal_error <= 1e-9);
        const double top = *std::max_element(p.p_hat.begin(), p.p_hat.end());
        if (peak == Peak::paper) NEAR(top, 1, 1e-15);
        if (peak == Peak::smooth) CHECK(top > 1 && top < 1.1);
        for (std::size_t c = 0; c < p.p_hat.size(); ++c) NEAR(p.p_hat[c] * p.peak, p.barycenter.p[c], 1e-16);
        CHECK(p.actuators.size() == 1 && p.actuators[0].strength == 1);
        const ShapePoint threaded = space.evaluate({0.5, 0.2, 0.3}, 0, 4, nullptr);
        CHECK(threaded.p_hat == p.p_hat);
    }
}

// How far the set p_hat > 1/2 at the vertex of a base is from the base: intersection over union.
double overlap(const ShapeSpace& space, std::size_t i) {
    Vector alpha(space.bases().size(), 0.0);
    alpha[i] = 1;
    const ShapePoint p = space.evaluate(alpha, 0, 0, nullptr);
    double both = 0, either = 0;
    for (std::size_t c = 0; c < p.p_hat.size(); ++c) {
        const bool here = p.p_hat[c] > 0.5, there = space.bases()[i].fractions[c] > 0.5;
        both += here && there, either += here || there;
    }
    return both / either;
}

void check_overlaps(const std::string& folder, const std::vector<std::string>& names, const Cells& cells) {
    ShapeSpace space(settings_of(cells));
    for (const std::string& name : names) space.add_mesh(name, read_mesh_file(folder + "/" + name + ".stl"));
    space.build(nullptr);
    std::string bad;
    for (std::size_t i = 0; i < names.size(); ++i) {
        const double value = overlap(space, i);
        print_message("%s at %d x %d x %d: intersection over union %.4f\n", names[i].c_str(), cells[0], cells[1],
                      cells[2], value);
        if (!(value >= 0.97)) bad += format("%s %.4f ", names[i].c_str(), value);
    }
    if (!bad.empty()) throw std::runtime_error("less than 0.97: " + bad);
}

void test_vertices_give_back_the_shipped_shapes() {
    check_overlaps(DQA_SHAPES_DIR, {"clownfish", "tuna", "eel_vertical", "eel_horizontal"}, {40, 12, 20});
}

void test_vertices_give_back_real_animals() {
    const char* folder = std::getenv("DQA_TEST_DATA");
    if (!folder || !*folder) {
        print_message("DQA_TEST_DATA is not set: vertices of the Orca and the Great White Shark are not tested\n");
        throw Skipped{};
    }
    check_overlaps(folder, {"Orca", "GreatWhiteShark"}, {60, 16, 26});
}

void test_cancelled_build_leaves_the_space_usable() {
    const auto filled = [] {
        auto space = std::make_unique<ShapeSpace>(settings_of(small));
        space->add_fractions("long", soft_ellipsoid(small, {9, 4, 5}, {7.2, 1.7, 2.3}).data());
        space->add_fractions("round", soft_ellipsoid(small, {9, 4, 5}, {5.4, 2.4, 2.9}).data());
        return space;
    };
    for (int stop = 0; stop <= 2; ++stop) {
        const auto space = filled();
        const auto cancel = [&](int done, int total) {
            CHECK(total == 2);
            if (done == stop) throw Error(Status::CANCELLED, "enough");
        };
        EXPECT_ERROR(CANCELLED, "enough", space->build(cancel));
        CHECK(!space->built() && space->box().dx == 0);
        for (const BaseShape& b : space->bases()) CHECK(b.actuators.empty());
        EXPECT_ERROR(ERROR_STATE, "not built", space->evaluate({0.5, 0.5}, 0, 0, nullptr));
        // It can still be filled, and built as if nothing had happened.
        const auto other = filled();
        for (ShapeSpace* s : {space.get(), other.get()}) {
            s->add_fractions("high", soft_ellipsoid(small, {9, 4, 5}, {6.2, 1.5, 3.4}).data());
            s->build(nullptr);
        }
        CHECK(space->built() && space->box().dx == other->box().dx && space->box().dx > 0);
        CHECK(row(space->evaluate({0.3, 0.3, 0.4}, 0, 0, nullptr)) ==
              row(other->evaluate({0.3, 0.3, 0.4}, 0, 0, nullptr)));
    }
}

void test_refusals() {
    const ShapeSpace space = three_bodies(0.8);
    EXPECT_ERROR(ERROR_ARGUMENT, "m is 2, expected 3", space.check_weights({0.5, 0.5}));
    EXPECT_ERROR(ERROR_ARGUMENT, "weights[1] is -0.1", space.check_weights({0.6, -0.1, 0.5}));
    EXPECT_ERROR(ERROR_ARGUMENT, "weights[2] is nan", space.check_weights({0.6, 0.4, std::nan("")}));
    EXPECT_ERROR(ERROR_ARGUMENT, "weights[0] is inf", space.check_weights({INFINITY, 0.4, 0}));
    EXPECT_ERROR(ERROR_ARGUMENT, "weights sum to 1.00000001", space.check_weights({0.6, 0.4, 1e-8}));
    EXPECT_ERROR(ERROR_ARGUMENT, "weights sum to 0,", space.check_weights({0, 0, 0}));
    space.check_weights({0.6, 0.4, 1e-10});
    EXPECT_ERROR(ERROR_ARGUMENT, "weights[1] is -0.1", space.evaluate({0.6, -0.1, 0.5}, 0, 0, nullptr));

    ShapeSpace open(settings_of(small));
    EXPECT_ERROR(ERROR_STATE, "no bases", open.build(nullptr));
    Vector cells = soft_ellipsoid(small, {9, 4, 5}, {7.2, 1.7, 2.3});
    cells[77] = 1.5;
    EXPECT_ERROR(ERROR_ARGUMENT, "cells[77] is 1.5", open.add_fractions("x", cells.data()));
    cells[77] = std::nan("");
    EXPECT_ERROR(ERROR_ARGUMENT, "cells[77] is nan", open.add_fractions("x", cells.data()));
    cells[77] = 1.0000001192092896;  // a sum in single precision
    EXPECT_ERROR(ERROR_ARGUMENT, "base 0 ('x'): cells[77] is 1.0000001192092896, expected a covered fraction in [0, 1]",
                 open.add_fractions("x", cells.data()));
    EXPECT_ERROR(ERROR_ARGUMENT, "base 0 ('x'): no cell is covered by half or more (largest of cells 0.1, sum",
                 open.add_fractions("x", Vector(cells.size(), 0.1).data()));
    CHECK(open.bases().empty());
    cells[77] = 0;
    CHECK(open.add_fractions("x", cells.data()) == 0);
    EXPECT_ERROR(ERROR_STATE, "cell size", open.add_actuator(0, Actuator{}));
    open.build(nullptr);
    EXPECT_ERROR(ERROR_STATE, "already built", open.build(nullptr));
    EXPECT_ERROR(ERROR_STATE, "frozen", open.add_fractions("y", cells.data()));
}

// Which of several bases cannot be built, and why: one that no cell holds half of, and one with a gap where its muscle
// would be.
void test_errors_name_the_base() {
    ShapeSpace space(settings_of(small));
    space.add_fractions("whole", soft_ellipsoid(small, {9, 4, 5}, {7.2, 1.7, 2.3}).data());
    CHECK(space.add_mesh("sheet", cuboid({-3, -0.02, -1}, {6, 0.04, 2})) == 1);
    CHECK(space.bases()[1].fractions != Vector(space.bases()[1].fractions.size(), 0.0));
    EXPECT_ERROR(ERROR_ARGUMENT, "base 1 ('sheet') is too thin for this grid: no cell is covered by half or more",
                 space.build(nullptr));
    CHECK(!space.built());

    ShapeSpace apart(settings_of(small));
    Vector ends = soft_ellipsoid(small, {9, 4, 5}, {7.2, 1.7, 2.3});
    apart.add_fractions("whole", ends.data());
    for (int c = 0; c < apart.box().n_cells(); ++c) {
        const int i = apart.box().cell_ijk(c)[0];
        if (i > 3 && i < 15) ends[static_cast<std::size_t>(c)] = 0.0;
    }
    apart.add_fractions("ends", ends.data());
    EXPECT_ERROR(ERROR_ARGUMENT, "build: base 1 ('ends'): no body found where its caudal muscle should be",
                 apart.build(nullptr));
}

void test_number_text() {
    CHECK(number_text(1.0000001192092896) == "1.0000001192092896" && number_text(0.1) == "0.1");
    CHECK(number_text(1.0) == "1" && number_text(-2.5e-300) == "-2.5e-300");
    CHECK(number_text(-std::nan("")) == "nan" && number_text(-INFINITY) == "-inf");
}

// Numbers, kinds and halves over the bases become categories, slots and signals.
void test_categories() {
    ShapeSettings s = settings_of(small);
    s.cell_size = 0.05;
    ShapeSpace space(s);
    for (const char* name : {"a", "b", "c"})
        space.add_fractions(name, soft_ellipsoid(small, {9, 4, 5}, {7.2, 1.7, 2.3}).data());
    Actuator fins;
    fins.kind = ActuatorKind::fins, fins.category = 1, fins.layers = 4;
    fins.mean = {0.1, 0.1, 0}, fins.variance = {0.01, 0.01, 0.002}, fins.euler = {0.1, 0, 0.2};
    space.add_actuator(0, fins);
    Actuator other = fins;
    other.category = 9, other.layers = 2, other.half = ActuatorHalf::left;
    space.add_actuator(0, other);
    EXPECT_ERROR(ERROR_STATE, "base 0 ('a') already has an actuator of category 1 in its left half",
                 space.add_actuator(0, fins));
    Actuator thick = fins;
    thick.variance = {0.01, 0.01, 0.010000001};
    EXPECT_ERROR(ERROR_ARGUMENT,
                 "base 2 ('c'): variance[2] is 0.010000001, expected the smallest of the three (0.01, 0.01)",
                 space.add_actuator(2, thick));
    EXPECT_ERROR(ERROR_ARGUMENT,
                 "base 1 ('b'): layers is 3, expected 2, which actuators of category 9 have in base 0 ('a')",
                 (other.layers = 3, space.add_actuator(1, other)));
    Actuator tail;
    tail.variance = {0.01, 0.01, 0.01};
    EXPECT_ERROR(ERROR_ARGUMENT, "kind is 0, expected 1", (tail.category = 9, space.add_actuator(2, tail)));
    tail.category = 4;
    space.add_actuator(1, tail);
    fins.euler = {0.1, 0, 0.2};
    space.add_actuator(1, fins);
    CHECK(space.n_signals() == 0);
    {
        ShapeSpace other_use(s);
        other_use.add_fractions("a", soft_ellipsoid(small, {9, 4, 5}, {7.2, 1.7, 2.3}).data());
        other_use.add_fractions("b", soft_ellipsoid(small, {9, 4, 5}, {7.2, 1.7, 2.3}).data());
        Actuator zero = fins;
        zero.category = 0;
        other_use.add_actuator(0, zero);
        EXPECT_ERROR(ERROR_STATE,
                     "base 1 ('b') names no actuator and gets automatic tail muscles of category 0, which has another "
                     "kind in base 0 ('a')",
                     other_use.build(nullptr));
        CHECK(!other_use.built() && other_use.bases()[1].actuators.empty());
    }
    space.build(nullptr);  // the third base gets a caudal one, number 0
    CHECK(space.n_signals() == 1 + 16 + 1 + 8);
    CHECK((space.categories() == std::vector<ActuatorCategory>{{0, ActuatorKind::caudal, 1, 0, 1},
                                                               {1, ActuatorKind::fins, 4, 1, 16},
                                                               {4, ActuatorKind::caudal, 1, 17, 1},
                                                               {9, ActuatorKind::fins, 2, 18, 8}}));
    using enum ActuatorHalf;
    CHECK((space.slots() == std::vector<ActuatorSlot>{{0, whole}, {1, left}, {1, right}, {2, whole}, {3, left}}));
    CHECK(!space.fibres_turn());  // the frames of the two bases agree
    const ShapePoint p = space.evaluate({0.6, 0.38, 0.02}, 0, 0, nullptr);
    CHECK(p.actuators.size() == 5 && p.actuators[1].share == 0.98 && p.actuators[0].strength < 0.5);
    NEAR(p.actuators[2].mean[1], -p.actuators[1].mean[1], 0);
}

// The sensor line: the x axis where bodies are, else the nearest parallel that runs through all of them.
void test_axis() {
    CHECK(three_bodies(0.8).axis_y() == 0 && three_bodies(0.8).axis_z() == 0);
    ShapeSpace space(settings_of({22, 12, 16}));
    space.add_fractions("a", soft_ellipsoid({22, 12, 16}, {11, 6, 11}, {8.6, 2.1, 2.0}).data());
    space.add_fractions("b", soft_ellipsoid({22, 12, 16}, {11, 6, 11.5}, {8.6, 2.6, 2.5}).data());
    space.build(nullptr);
    const double z = space.axis_z() / space.box().dx;  // the bodies reach down to 1 cell above the axis
    CHECK(space.axis_y() == 0 && z > 1 && z < 3.5);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_gradient_inside),
        TEST(test_gradient_at_the_boundary),
        TEST(test_pullback_takes_parts),
        TEST(test_evaluate),
        TEST(test_vertices_give_back_the_shipped_shapes),
        TEST(test_vertices_give_back_real_animals),
        TEST(test_cancelled_build_leaves_the_space_usable),
        TEST(test_refusals),
        TEST(test_errors_name_the_base),
        TEST(test_number_text),
        TEST(test_categories),
        TEST(test_axis),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
