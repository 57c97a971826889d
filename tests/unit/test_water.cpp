// SPDX-License-Identifier: MIT
// Drag and thrust on the diffuse surface: against the paper's law for sharp surfaces, potential and derivatives. States
// that make an unrounded law undefined are in test_water_states.cpp.
#include <Eigen/Core>

#include "grid/symmetric_eigen.hpp"
#include "water_fixtures.hpp"

namespace {

using namespace fixtures;

double bezier(const std::array<double, 4>& b, double t) {
    const double s = 1 - t;
    return s * s * s * b[0] + 3 * s * s * t * b[1] + 3 * s * t * t * b[2] + t * t * t * b[3];
}

// ---------------------------------------------------------------- against the paper

// One full cell: six faces with outward normals, evaluated by the paper's equations at q_old and u = v - current.
void test_one_cell_against_the_law() {
    Random random{3};
    double worst[2] = {0, 0};
    for (int round = 0; round < 200; ++round) {
        Sample s({1, 1, 1}, 20);
        s.set = full_set({1, 1, 1}, 0.1);
        s.occupancy = {1.0};
        s.rest = s.set.rest_positions();
        s.q = plus(mapped(s.rest, random_rotation(random)), 0.02, random_vector(24, random));
        s.v = random_vector(24, random);
        s.spine = {0.6, 0.0, -0.8};
        Vec3 drag{}, thrust{};
        double size = 0.0;
        constexpr int corners[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                       {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
        for (const auto& face : corners) {
            Vec3 u{}, x[4];
            for (std::size_t c = 0; c < 4; ++c)
                for (std::size_t a = 0; a < 3; ++a) {
                    const std::size_t i = 3 * static_cast<std::size_t>(face[c]) + a;
                    x[c][a] = s.q[i], u[a] += 0.25 * s.v[i];
                }
            for (std::size_t a = 0; a < 3; ++a) u[a] -= s.settings.current[a];
            Vec3 n = cross_of({x[2][0] - x[0][0], x[2][1] - x[0][1], x[2][2] - x[0][2]},
                              {x[3][0] - x[1][0], x[3][1] - x[1][1], x[3][2] - x[1][2]});
            const double area = 0.5 * std::sqrt(dot3(n, n));
            for (double& c : n) c /= 2 * area;
            const double speed = std::sqrt(dot3(u, u)), phi = std::asin(dot3(n, u) / speed);
            Vec3 lateral{};
            for (std::size_t a = 0; a < 3; ++a) lateral[a] = u[a] - dot3(s.spine, u) * s.spine[a];
            const double cd = bezier(s.settings.drag, std::fabs(phi) / (0.5 * pi));
            const double ct = bezier(s.settings.thrust, phi / pi + 0.5);
            for (std::size_t a = 0; a < 3; ++a) {
                drag[a] -= 500 * area * cd * speed * u[a];
                thrust[a] -= 500 * area * ct * dot3(lateral, lateral) * n[a];
            }
            size += 500 * area * speed * speed;
        }
        const double epsilons[2] = {0.02, 1e-4};
        for (std::size_t k = 0; k < 2; ++k) {
            s.settings.angle_smoothing = epsilons[k];
            s.settings.surface_smoothing = 0.5 * epsilons[k];
            s.settings.speed_smoothing = 0.1 * epsilons[k];
            const Water w = s.water();
            CHECK(w.n_faces() == 6);
            WaterWorkspace ws;
            w.lag(ws, s.q.data(), s.v.data(), s.spine, w.settings().current, 1);
            const Vector q_new = plus(s.q, kStep, s.v);
            const WaterTotals t = w.totals(ws, q_new.data(), s.q.data(), kStep);
            Vector force(24, 0.0);
            w.gradient(ws, q_new.data(), s.q.data(), kStep, 1, force.data());
            for (std::size_t a = 0; a < 3; ++a) {
                worst[k] = std::max(
                    {worst[k], std::fabs(t.drag[a] - drag[a]) / size, std::fabs(t.thrust[a] - thrust[a]) / size});
                double sum = 0.0;
                for (std::size_t n = 0; n < 8; ++n) sum -= force[3 * n + a];
                NEAR(sum, t.drag[a] + t.thrust[a], 1e-12 * size);
            }
        }
    }
    print_message("one cell against the law: %.1e at eps 0.02, %.1e at 1e-4\n", worst[0], worst[1]);
    CHECK(worst[0] <= 4 * 0.02 && worst[1] <= 4 * 1e-4);
}

// Binary occupancy: the wet area is the number of quadrilaterals between full and empty cells, or the box's end.
void test_binary_surface_area() {
    Sample s({7, 6, 5}, 4);
    Random random{5};
    for (double& g : s.occupancy) g = random() > 0.3 ? 1.0 : 0.0;
    const double eps = 1e-7;
    s.settings.surface_smoothing = eps;
    const auto full = [&](int i, int j, int k) {
        const Box& b = s.set.box;
        if (i < 0 || j < 0 || k < 0 || i >= b.cells[0] || j >= b.cells[1] || k >= b.cells[2]) return false;
        const int a = s.set.cell_to_active[static_cast<std::size_t>(b.cell(i, j, k))];
        return a >= 0 && s.occupancy[static_cast<std::size_t>(a)] == 1.0;
    };
    int quadrilaterals = 0;
    for (int i = 0; i <= 7; ++i)
        for (int j = 0; j <= 6; ++j)
            for (int k = 0; k <= 5; ++k)
                quadrilaterals += (full(i, j, k) != full(i - 1, j, k)) + (full(i, j, k) != full(i, j - 1, k)) +
                                  (full(i, j, k) != full(i, j, k - 1));
    const Water w = s.water();
    WaterWorkspace ws;
    const Vector v(s.rest.size(), 1.0);
    w.lag(ws, s.rest.data(), v.data(), s.spine, w.settings().current, 1);
    const WaterTotals t = w.totals(ws, plus(s.rest, kStep, v).data(), s.rest.data(), kStep);
    CHECK(quadrilaterals > 100 && t.drag[0] < 0);
    NEAR(t.drag[0] / t.mean_drag[0], quadrilaterals * 0.01, quadrilaterals * 0.01 * 2 * eps);
}

// ---------------------------------------------------------------- derivatives

void test_potential_and_hessian() {
    const Sample s;
    const Water w = s.water();
    WaterWorkspace ws;
    Random random{7};
    w.lag(ws, s.q.data(), s.v.data(), s.spine, w.settings().current, 1);
    const Vector q_new = plus(s.q, kStep, random_vector(s.q.size(), random));
    const Vector p = random_vector(s.q.size(), random, 0.01), r = random_vector(s.q.size(), random, 0.01);
    Vector g(s.q.size(), 0.0), scratch(g), hp(g), hr(g);
    w.gradient(ws, q_new.data(), s.q.data(), kStep, 1, g.data());
    CHECK_DERIVATIVE(
        [&](double e) { return w.gradient(ws, plus(q_new, e, p).data(), s.q.data(), kStep, 1, scratch.data()); },
        dot_of(g, p), 1.0);
    w.product(ws, p.data(), kStep, 1, hp.data());
    w.product(ws, r.data(), kStep, 1, hr.data());
    const Vector moved = s.gradient(plus(q_new, 1.0, p), s.q, s.v, s.spine, s.occupancy);
    NEAR(relative_difference(hp, plus(moved, -1.0, g)), 0.0, 1e-10);
    NEAR(dot_of(r, hp), dot_of(p, hr), 1e-13 * norm_of(r) * norm_of(hp));
    // In single precision the same, whatever stands behind the last coordinate.
    std::vector<float> single(p.begin(), p.end()), single_hp(p.size(), 0.0f);
    single.push_back(std::numeric_limits<float>::quiet_NaN());
    w.product(ws, single.data(), kStep, 1, single_hp.data());
    const double error = relative_difference(Vector(single_hp.begin(), single_hp.end()), hp);
    CHECK(error > 1e-9 && error < 3e-7);
    // Positive semidefinite, whatever the state.
    const Eigen::Index n = static_cast<Eigen::Index>(s.q.size());
    Eigen::MatrixXd h(n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
        Vector unit(s.q.size(), 0.0), column(s.q.size(), 0.0);
        unit[static_cast<std::size_t>(j)] = 1.0;
        w.product(ws, unit.data(), kStep, 1, column.data());
        h.col(j) = Eigen::Map<const Eigen::VectorXd>(column.data(), n);
    }
    const Eigen::VectorXd eigenvalues = dqa::symmetric_eigen(h).values;
    CHECK(eigenvalues(n - 1) > 1.0);
    CHECK(eigenvalues(0) >= -1e-12 * eigenvalues(n - 1));
    report_worst("potential");
}

void check_pullback(const Sample& s, const Vector& v, bool velocity_matters, std::uint64_t seed) {
    Random random{seed};
    const Water w = s.water();
    WaterWorkspace ws;
    const Vector q_new = plus(plus(s.q, kStep, v), kStep, random_vector(s.q.size(), random, 0.4));
    const Vector lambda = random_vector(s.q.size(), random);
    w.lag(ws, s.q.data(), v.data(), s.spine, w.settings().current, 1);
    Vector q_bar(s.q.size(), 0.0), v_bar(q_bar), g_bar(s.occupancy.size(), 0.0);
    Vec3 spine_bar{}, current_bar{};
    WaterParameterBar parameter_bar;
    w.pullback(ws, q_new.data(), s.q.data(), s.q.data(), lambda.data(), kStep, 1, q_bar.data(), q_bar.data(),
               v_bar.data(), spine_bar, current_bar, parameter_bar, g_bar.data());
    const auto value = [&](const Vector& q_old, const Vector& vel, const Vec3& spine, const Vector& g) {
        return dot_of(lambda, s.gradient(q_new, q_old, vel, spine, g));
    };
    const Vector dq = random_vector(s.q.size(), random, 0.1), dv = random_vector(s.q.size(), random),
                 dg = random_vector(s.occupancy.size(), random, 0.2);
    const Vec3 ds = {0.3, -0.5, 0.2};
    CHECK_DERIVATIVE([&](double e) { return value(plus(s.q, e, dq), v, s.spine, s.occupancy); }, dot_of(q_bar, dq),
                     1e-2);
    CHECK_DERIVATIVE([&](double e) { return value(s.q, v, s.spine, plus(s.occupancy, e, dg)); }, dot_of(g_bar, dg),
                     1e-3);
    const auto by_v = [&](double e) { return value(s.q, plus(v, e, dv), s.spine, s.occupancy); };
    if (!velocity_matters) {
        // At rest in still water every lagged coefficient is stationary.
        CHECK(norm_of(v_bar) == 0.0);
        NEAR(five_point(by_v, 1e-4), 0.0, 1e-6 * norm_of(q_bar));
        return;
    }
    CHECK_DERIVATIVE(by_v, dot_of(v_bar, dv), 1e-3);
    CHECK_DERIVATIVE(
        [&](double e) {
            return value(s.q, v, {s.spine[0] + e * ds[0], s.spine[1] + e * ds[1], s.spine[2] + e * ds[2]}, s.occupancy);
        },
        dot3(spine_bar, ds), 1e-2);
    const Vec3 dc = {0.2, 0.3, -0.4};
    CHECK_DERIVATIVE(
        [&](double e) {
            Sample moved = s;
            for (std::size_t k = 0; k < 3; ++k) moved.settings.current[k] += e * dc[k];
            return dot_of(lambda, moved.gradient(q_new, s.q, v, s.spine, s.occupancy));
        },
        dot3(current_bar, dc), 1e-3);
    const ParameterDirection dp;
    CHECK_DERIVATIVE(
        [&](double e) {
            Sample moved = s;
            moved.settings = dp.moved(s.settings, e);
            return dot_of(lambda, moved.gradient(q_new, s.q, v, s.spine, s.occupancy));
        },
        dp.slope(parameter_bar), 0.1);
}

void test_pullback() {
    Sample s;
    const Vector rest(s.q.size(), 0.0);
    check_pullback(s, s.v, true, 11);
    check_pullback(s, rest, true, 12);  // from rest in a current
    s.settings.current = {};
    check_pullback(s, s.v, true, 13);
    check_pullback(s, rest, false, 14);
    // Head-on at an undeformed body: every face normal is along or across the current, where the plain angle has no
    // slope.
    s.q = s.rest;
    s.settings.current = {-1.0, 0.0, 0.0};
    s.spine = {1.0, 0.0, 0.0};
    const Vector uniform = [&] {
        Vector u(s.q.size(), 0.0);
        for (std::size_t i = 0; i < u.size(); i += 3) u[i] = 0.5;
        return u;
    }();
    s.spine = {0.6, 0.8, 0.0};  // along x the lateral velocity and with it the spine's derivative would vanish
    check_pullback(s, rest, true, 15);
    check_pullback(s, uniform, true, 16);
    report_worst("water pullback");
}

// Totals, and everything that both pullbacks give, in one list: the same bits for any number of threads.
void test_threads() {
    const Sample s({11, 9, 8}, 5);
    const Water w = s.water();
    CHECK(w.n_faces() > 1500);  // several chunks, and a last one that is not full
    Random random{17};
    const Vector q_new = plus(plus(s.q, kStep, s.v), kStep, random_vector(s.q.size(), random, 0.4));
    const Vector lambda = random_vector(s.q.size(), random);
    const auto all = [&](int threads) {
        WaterWorkspace ws;
        w.lag(ws, s.q.data(), s.v.data(), s.spine, w.settings().current, threads);
        WaterTotals t = w.totals(ws, q_new.data(), s.q.data(), kStep, threads);
        Vector out{t.wet_area};
        for (const Vec3& x : {t.drag, t.thrust, t.mean_drag, t.mean_thrust}) out.insert(out.end(), x.begin(), x.end());
        Vector fields(4 * s.q.size(), 0.0), g_bar(s.occupancy.size(), 0.0);
        double *new_bar = fields.data(), *base_bar = new_bar + s.q.size(), *q_bar = base_bar + s.q.size(),
               *v_bar = q_bar + s.q.size();
        Vec3 spine_bar{}, current_bar{};
        WaterParameterBar parameter_bar;
        w.pullback(ws, q_new.data(), s.q.data(), s.q.data(), lambda.data(), kStep, threads, base_bar, q_bar, v_bar,
                   spine_bar, current_bar, parameter_bar, g_bar.data());
        w.totals_pullback(ws, q_new.data(), s.q.data(), s.q.data(), t, kStep, threads, new_bar, base_bar, q_bar, v_bar,
                          spine_bar, current_bar, parameter_bar, g_bar.data());
        for (const Vector* x : {&fields, &g_bar}) out.insert(out.end(), x->begin(), x->end());
        for (const Vec3& x : {spine_bar, current_bar}) out.insert(out.end(), x.begin(), x.end());
        for (const auto& x : {parameter_bar.laws.drag, parameter_bar.laws.thrust})
            out.insert(out.end(), x.begin(), x.end());
        out.push_back(parameter_bar.density);
        return out;
    };
    const Vector one = all(1);
    CHECK(norm_of(one) > 0);
    for (const int threads : {2, 3, 7}) CHECK(all(threads) == one);
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_one_cell_against_the_law),
        TEST(test_binary_surface_area),
        TEST(test_potential_and_hessian),
        TEST(test_pullback),
        TEST(test_threads),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
