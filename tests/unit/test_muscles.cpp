// SPDX-License-Identifier: MIT
// Muscles of a design: which fibres there are, and the derivative of their weights and directions by the weights alpha
// of the shape space, alone and through a rollout.
#include "body/fibre_turn.hpp"
#include "derivative_checks.hpp"
#include "motion_fixtures.hpp"
#include "shape/mesh_file.hpp"
#include "tape/adjoint.hpp"

namespace {

using namespace fixtures;

Actuator fin(const Vec3& mean, const Vec3& half, const Vec3& euler, int layers) {
    Actuator a;
    a.kind = ActuatorKind::fins, a.category = 1, a.layers = layers;
    a.mean = mean, a.euler = euler;
    for (std::size_t k = 0; k < 3; ++k) a.variance[k] = half[k] * half[k] / kTwoLn2;
    return a;
}

// Two flat bodies with a tail and fins that differ in place, size and tilt.
std::shared_ptr<const ShapeSpace> winged_space(Interpolation interpolation, bool tilted, int layers = 4) {
    const std::array<int, 3> cells{16, 12, 8};
    ShapeSettings s;
    s.cells = cells, s.cell_size = 0.05, s.sigma = 0.7, s.interpolation = interpolation;
    auto space = std::make_shared<ShapeSpace>(s);
    space->add_fractions("disc", ellipsoid_fractions(cells, {6.5, 5.2, 2.2}).data());
    space->add_fractions("ball", ellipsoid_fractions(cells, {5.2, 4.6, 2.8}, {0.5, 0, 0.2}).data());
    const double tilt = tilted ? 1.0 : 0.0;
    space->add_actuator(0, fin({0.05, 0.13, 0}, {0.15, 0.12, 0.08}, {0.2 * tilt, 0, 0.1 * tilt}, layers));
    space->add_actuator(1, fin({0.0, 0.11, 0.02}, {0.12, 0.13, 0.1}, {-0.1 * tilt, 0.15 * tilt, 0}, layers));
    Actuator tail;
    tail.mean = {-0.15, 0, 0}, tail.variance = {0.01, 0.008, 0.008};
    space->add_actuator(0, tail);
    tail.mean[0] = -0.12;
    space->add_actuator(1, tail);
    space->build(nullptr);
    return space;
}

void test_fibres() {
    const auto space = winged_space(Interpolation::linear, true);
    CHECK(space->n_signals() == 17 && space->fibres_turn());
    const auto design = make_design(tight_scene(), {0.6, 0.4}, space);
    const auto& muscles = design->muscles().entries();
    std::vector<double> by_signal(17, 0.0), left(17, 0.0);
    for (const MuscleEntry& m : muscles) {
        NEAR(m.direction[0] * m.direction[0] + m.direction[1] * m.direction[1] + m.direction[2] * m.direction[2], 1,
             1e-14);
        const Vec3 x = space->box().cell_centre(design->set().cells[static_cast<std::size_t>(m.cell)]);
        by_signal[static_cast<std::size_t>(m.signal)] += m.weight;
        if (m.signal == 0) CHECK(m.direction == (Vec3{1, 0, 0}) && (m.sign > 0 ? x[1] > -0.03 : x[1] < 0.03));
        if (m.signal > 0) CHECK(m.sign == 1.0);
        if (x[1] > 0) left[static_cast<std::size_t>(m.signal)] += m.weight;
    }
    for (std::size_t k = 0; k < 17; ++k) CHECK(by_signal[k] > 0);
    // Both halves alike.
    for (std::size_t k = 0; k < 17; ++k) NEAR(left[k], 0.5 * by_signal[k], 1e-9 * by_signal[k]);
    // In the direction of fibres of one half the other one is its mirror image.
    CHECK(winged_space(Interpolation::linear, true, 2)->n_signals() == 9);
}

// Weighted sums of weights and directions of the muscles as functions of alpha; cells and groups by what they are,
// since entries come and go.
void test_derivative_by_alpha() {
    for (const Interpolation way : {Interpolation::linear, Interpolation::bures}) {
        const auto space = winged_space(way, true);
        SceneSettings scene = tight_scene();
        scene.threshold = 0.3;
        scene.shape_tolerance = 1e-13;
        const auto weight_of = [&](const Design& d, const MuscleEntry& m) {
            const int cell = d.set().cells[static_cast<std::size_t>(m.cell)];
            return std::sin(1.7 * cell + 0.9 * m.signal + m.sign);
        };
        const auto value = [&](double w) {
            const auto d = make_design(scene, {w, 1 - w}, space);
            double total = 0;
            for (const MuscleEntry& m : d->muscles().entries())
                total +=
                    weight_of(*d, m) * (1e-6 * m.weight + 1e-12 * m.weight * m.weight +
                                        1e-6 * m.weight * (0.3 * m.direction[0] + m.direction[1] * m.direction[2]));
            return total;
        };
        const auto d = make_design(scene, {0.6, 0.4}, space);
        DesignBar bar = d->zero_bar();
        for (std::size_t e = 0; e < d->muscles().entries().size(); ++e) {
            const MuscleEntry& m = d->muscles().entries()[e];
            const double c = weight_of(*d, m);
            bar.muscle_weight[e] =
                c * (1e-6 + 2e-12 * m.weight + 1e-6 * (0.3 * m.direction[0] + m.direction[1] * m.direction[2]));
            const double s = 1e-6 * c * m.weight;
            bar.muscle_direction[e] = {0.3 * s, s * m.direction[2], s * m.direction[1]};
        }
        const Vector g = d->weights_bar(bar, nullptr);
        CHECK_DERIVATIVE([&](double e) { return value(0.6 + e); }, g[0] - g[1], 2e-3);
    }
    report_worst("muscles by alpha");
}

// The derivative of the muscles' forces by the directions of their fibres.
void test_fibre_turn() {
    const auto d = make_design(tight_scene(), {0.6, 0.4}, winged_space(Interpolation::linear, true));
    Random random{11};
    const std::size_t n = d->rest().size();
    const Vector q = plus(d->rest(), 1.0, random_vector(n, random, 0.004)), lambda = random_vector(n, random);
    const Vector signals = random_vector(17, random, 0.8);
    std::vector<MuscleEntry> muscles = d->muscles().entries();
    std::vector<Vec3> turn(muscles.size());
    for (Vec3& t : turn) t = {random(), random(), random()};
    const auto work = [&](double e) {
        std::vector<MuscleEntry> turned = muscles;
        for (std::size_t k = 0; k < turned.size(); ++k)
            for (std::size_t j = 0; j < 3; ++j) turned[k].direction[j] += e * turn[k][j];
        const Body body(d->set(), {Material::corotated, Vector(static_cast<std::size_t>(d->set().n_cells()), 0.0), {}},
                        turned, d->scene().contraction, d->scene().instructions);
        BodyWorkspace ws;
        Vector elastic(n), muscle(n);
        body.gradient(ws, q.data(), signals.data(), 1, elastic.data(), muscle.data());
        return dot_of(muscle, lambda);
    };
    std::vector<Vec3> bar(muscles.size(), Vec3{});
    add_direction_bar(d->set(), muscles, d->scene().contraction, q.data(), lambda.data(), signals.data(), bar);
    double slope = 0;
    for (std::size_t k = 0; k < bar.size(); ++k)
        for (std::size_t j = 0; j < 3; ++j) slope += bar[k][j] * turn[k][j];
    CHECK_DERIVATIVE(work, slope, 0.01);
    report_worst("forces by fibre directions");
}

// Fibres that are crushed to a point, with their cell or alone, have no direction; the others keep theirs.
void test_fibre_turn_of_crushed_cells() {
    const auto d = make_design(tight_scene(), {0.6, 0.4}, winged_space(Interpolation::linear, true));
    Random random{12};
    const std::size_t n = d->rest().size();
    const Vector lambda = random_vector(n, random), signals = random_vector(17, random, 0.8);
    const std::vector<MuscleEntry>& muscles = d->muscles().entries();
    const auto bar_at = [&](const Vector& q) {
        std::vector<Vec3> bar(muscles.size(), Vec3{});
        add_direction_bar(d->set(), muscles, d->scene().contraction, q.data(), lambda.data(), signals.data(), bar);
        return bar;
    };
    for (const Vec3& v : bar_at(Vector(n, 0.25))) CHECK(v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0);
    Vector one = d->rest();
    for (const int node : d->set().cell_nodes[static_cast<std::size_t>(muscles[0].cell)])
        for (std::size_t k = 0; k < 3; ++k) one[3 * static_cast<std::size_t>(node) + k] = 0.1;
    const std::vector<Vec3> bar = bar_at(one);
    CHECK(bar[0][0] == 0.0 && bar[0][1] == 0.0 && bar[0][2] == 0.0);
    double others = 0;
    for (const Vec3& v : bar)
        for (const double x : v) CHECK(std::isfinite(x)), others += std::fabs(x);
    CHECK(others > 0);
    Vector flat = d->rest();  // no lengths along x, which caudal fibres have
    for (std::size_t i = 0; i < n; i += 3) flat[i] = 0.0;
    for (const Vec3& v : bar_at(flat))
        for (const double x : v) CHECK(std::isfinite(x));
}

// The same as winged_space in the plane.
std::shared_ptr<const ShapeSpace> winged_plane(Interpolation interpolation) {
    ShapeSettings s;
    s.dims = 2, s.cells = {18, 12, 1}, s.cell_size = 0.05, s.sigma = 0.7, s.interpolation = interpolation;
    auto space = std::make_shared<ShapeSpace>(s);
    space->add_fractions("disc", ellipsoid_fractions(s.cells, {7.2, 4.7, 1e6}).data());
    space->add_fractions("ball", ellipsoid_fractions(s.cells, {5.9, 4.2, 1e6}, {0.5, 0, 0}).data());
    space->add_actuator(0, fin({0.05, 0.13, 0}, {0.15, 0.08, 1}, {0, 0, 0.3}, 1));
    space->add_actuator(1, fin({0.0, 0.11, 0}, {0.1, 0.12, 1}, {0, 0, -0.1}, 1));
    space->build(nullptr);
    return space;
}

// Travel of a short rollout with all signals, by alpha.
void test_rollout_by_alpha() {
    for (const int k : {0, 1, 2, 3}) {
        const Interpolation way = k % 2 ? Interpolation::bures : Interpolation::linear;
        const auto space = k < 2 ? winged_space(way, true) : winged_plane(way);
        SceneSettings scene = tight_scene();
        scene.tolerance = 1e-14;
        scene.shape_tolerance = 1e-13;
        scene.threshold = 0.3;
        scene.muscle_stiffness = 2e7;
        const auto rollout = [&](double w, double* slope) {
            const auto design = make_design(scene, {w, 1 - w}, space);
            Simulation simulation(design);
            const auto tape = std::make_shared<Tape>(0);
            for (int step = 0; step < 3; ++step) {
                Vector signals;
                for (int j = 0; j < space->n_signals(); ++j)
                    signals.push_back(0.9 * std::sin(0.7 * step + 0.8 * j + 0.5));
                advance(simulation, signals, tape.get());
            }
            const std::vector<ObjectiveTerm> terms{{ObjectiveKind::travel, 1.0}};
            if (slope) {
                Adjoint adjoint(tape);
                adjoint.seed_objective(terms);
                adjoint.backward(0, nullptr);
                *slope = adjoint.weights_bar()[0] - adjoint.weights_bar()[1];
            }
            return tape->objective(terms, nullptr);
        };
        double slope = 0;
        rollout(0.6, &slope);
        CHECK_DERIVATIVE([&](double e) { return rollout(0.6 + e, nullptr); }, slope, 2e-3);
    }
    report_worst("travel by alpha");
}

// Automatic muscles make the shipped eels swim head first.
void test_eels_swim_head_first() {
    for (const char* name : {"eel_vertical", "eel_horizontal"}) {
        ShapeSettings s;
        s.cells = {34, 8, 10}, s.sigma = 0.7;
        auto space = std::make_shared<ShapeSpace>(s);
        space->add_mesh(name, read_mesh_file(std::string(DQA_SHAPES_DIR "/") + name + ".stl"));
        space->build(nullptr);
        SceneSettings scene;
        scene.tolerance = 1e-4;
        Simulation simulation(make_design(scene, {1.0}, space));
        const Vector start(simulation.q());
        for (int step = 0; step < 36; ++step) {  // three periods
            const double signal = std::sin(pi / 6 * step);
            simulation.step({&signal, {}});
        }
        const Vector& spine = simulation.design().spine();
        double travel = 0;
        for (std::size_t n = 0; n < spine.size(); ++n) travel += spine[n] * (simulation.q()[3 * n] - start[3 * n]);
        travel /= sum(spine);
        print_message("%s travels %.1f mm\n", name, 1e3 * travel);
        CHECK(travel > 0.005);
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_fibres),           TEST(test_derivative_by_alpha),
        TEST(test_fibre_turn),       TEST(test_fibre_turn_of_crushed_cells),
        TEST(test_rollout_by_alpha), TEST(test_eels_swim_head_first),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
