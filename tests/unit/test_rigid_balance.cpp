// SPDX-License-Identifier: MIT
// The balance of the body as a whole: its motions, its pieces, and steps that keep the momentum of each piece.
#include "motion/rigid_balance.hpp"
#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;
using dqa::RigidBalance;

double mass_product(const Vector& mass, const Vector& a, const Vector& b) {
    double s = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) s += mass[i / 3] * a[i] * b[i];
    return s;
}

void test_motions() {
    Random random(5);
    const std::size_t n = 20;
    Vector q = random_vector(3 * n, random), mass(n);
    std::vector<int> piece(n);
    for (std::size_t k = 0; k < n; ++k) mass[k] = between(random, 0.1, 2.0), piece[k] = k < 8 ? 0 : 1;
    const RigidBalance all(RigidBalance::Free::space, mass, piece, q.data());
    CHECK(all.size() == 12);
    CHECK(RigidBalance(RigidBalance::Free::plane, mass, piece, q.data()).size() == 6);
    CHECK(RigidBalance(RigidBalance::Free::none, mass, piece, q.data()).size() == 0);
    for (std::size_t k = 0; k < all.size(); ++k)
        for (std::size_t l = 0; l < all.size(); ++l)
            NEAR(mass_product(mass, all.field(k), all.field(l)), k == l ? 1.0 : 0.0, 1e-12);

    // Forces between the nodes of one piece, along the lines that join them, have no sums; between pieces they have.
    const auto pull = [&](Vector& force, std::size_t a, std::size_t b) {
        for (std::size_t x = 0; x < 3; ++x) {
            const double f = q[3 * a + x] - q[3 * b + x];
            force[3 * a + x] -= f, force[3 * b + x] += f;
        }
    };
    Vector inner(3 * n, 0.0), across(3 * n, 0.0);
    for (std::size_t k = 0; k + 1 < n; ++k)
        if (piece[k] == piece[k + 1]) pull(inner, k, k + 1);
    pull(across, 2, 15);
    CHECK(norm_of(inner) > 1.0 && all.norm_of(inner.data()) <= 1e-13 * norm_of(inner));
    CHECK(all.norm_of(across.data()) > 0.1);

    // A move is rigid: it keeps the distances within each piece, also far; and it starts as its fields say.
    const Vector far = random_vector(all.size(), random, 3.0);
    Vector moved(q), nudged(q), by_fields(3 * n, 0.0);
    all.move(far, moved.data());
    double worst = 0.0, largest = 0.0;
    for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < a; ++b) {
            double before = 0.0, after = 0.0;
            for (std::size_t x = 0; x < 3; ++x) {
                before += std::pow(q[3 * a + x] - q[3 * b + x], 2);
                after += std::pow(moved[3 * a + x] - moved[3 * b + x], 2);
            }
            (piece[a] == piece[b] ? worst : largest) =
                std::max(piece[a] == piece[b] ? worst : largest, std::fabs(std::sqrt(after) - std::sqrt(before)));
        }
    CHECK(worst <= 1e-13 && largest > 0.1);
    constexpr double kSmall = 1e-5;
    Vector little(far);
    for (double& c : little) c *= kSmall;
    all.move(little, nudged.data());
    for (std::size_t k = 0; k < all.size(); ++k)
        for (std::size_t i = 0; i < 3 * n; ++i) by_fields[i] += far[k] * all.field(k)[i];
    Vector difference(3 * n);
    for (std::size_t i = 0; i < 3 * n; ++i) difference[i] = (nudged[i] - q[i]) / kSmall - by_fields[i];
    CHECK(norm_of(difference) <= 1e-3 * norm_of(by_fields));
}

void test_few_motions() {
    // On a line one turn moves nothing, in a point none does.
    const Vector mass(4, 1.0), line{0, 0, 0, 1, 2, 3, 2, 4, 6, 4, 8, 12}, point(12, 0.7);
    const std::vector<int> piece(4, 0);
    CHECK(RigidBalance(RigidBalance::Free::space, mass, piece, line.data()).size() == 5);
    CHECK(RigidBalance(RigidBalance::Free::space, mass, piece, point.data()).size() == 3);
}

void test_pieces() {
    const ActiveSet set = full_set({5, 1, 1}, 0.1);
    const auto pieces = [&](const Vector& occupancy) {
        const std::vector<int> piece = dqa::pieces_of(set, occupancy);
        CHECK(*std::min_element(piece.begin(), piece.end()) == 0);
        return *std::max_element(piece.begin(), piece.end()) + 1;
    };
    CHECK(pieces({1, 1, 1, 1, 1}) == 1);
    CHECK(pieces({1, 1, 1e-3, 1, 1}) == 2);
    CHECK(pieces({1, 1e-3, 1, 1e-3, 1}) == 3);
    CHECK(pieces({1, 1, 0.3, 1, 1}) == 1);
    CHECK(pieces({1e-3, 1e-3, 1, 1e-3, 1e-3}) == 1);
    CHECK(pieces({1e-4, 1e-4, 1e-4, 1e-4, 1e-4}) == 1);
}

// A stiff body over a long step: the nodes' residual is small against the tissue's forces and would leave the body's
// momentum open. From implicit Euler, M (q+ - q - h v) = h^2 f, whose sums are zero where f is internal: momentum, and
// angular momentum about the new positions, are those of the start.
void test_steps_keep_momentum() {
    for (const bool planar : {false, true}) {
        SceneSettings scene;
        scene.water = false;
        scene.planar = planar;
        scene.young_modulus = 1e9;
        scene.time_step = 0.5;
        const auto design = make_design(scene);
        const Vector& mass = design->mass();
        Random random(9);
        dqa::State now, next;
        now.q = design->rest(), now.v = swirl(now.q, 0.4);
        for (std::size_t i = 0; i < now.v.size(); ++i) {
            now.v[i] += i % 3 == 0 ? 0.2 : 0.0;
            if (planar && i % 3 == 2) now.v[i] = 0.0;
        }
        const Vector signals(static_cast<std::size_t>(design->n_signals()), 0.7);
        dqa::Stepper stepper(design);
        stepper.step(now, {signals.data(), {}}, 0, next);
        Vector unbalanced(now.q.size());
        double way = 0.0;
        for (std::size_t i = 0; i < now.q.size(); ++i) {
            const double d = next.q[i] - now.q[i];
            unbalanced[i] = mass[i / 3] * (d - scene.time_step * now.v[i]);
            way += mass[i / 3] * d * d;
        }
        const RigidBalance whole(planar ? RigidBalance::Free::plane : RigidBalance::Free::space, mass,
                                 dqa::pieces_of(design->set(), design->occupancy()), next.q.data());
        const double free = whole.norm_of(unbalanced.data()) / std::sqrt(way);
        print_message("%s: rigid motion left open by a step: %.1e of the way\n", planar ? "plane" : "space", free);
        CHECK(free <= 1e-5 && norm_of(unbalanced) > 0.0);
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_motions),
        TEST(test_few_motions),
        TEST(test_pieces),
        TEST(test_steps_keep_momentum),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
