// SPDX-License-Identifier: MIT
// The body's answer does not depend on how cells fill blocks, on the instruction set, or on the number of threads.
#include "body_fixtures.hpp"

namespace {

using namespace fixtures;

// Any number of cells and muscles, full blocks or not: the sum of the cells one by one.
void test_padding() {
    for (const int n : {1, 2, 7, 8, 9, 13, 16, 64, 65, 130}) {  // a chunk is of 64
        const Sample s({n, 1, 1}, n + 3);
        const Vector q = s.displaced(n % 2 ? 0.2 : 0.5);
        BodyWorkspace ws;
        const Body body = s.body();
        const Result all = evaluate(body, ws, q, s.signals);
        Random random{8};
        const Vector p = random_vector(q.size(), random), hp = product(body, ws, p);
        double energy = 0.0;
        int inverted = 0;
        Vector total(q.size(), 0.0), sum_hp(q.size(), 0.0);
        for (int c = 0; c < n; ++c) {
            Sample one({1, 1, 1}, 0);
            one.mu = {s.mu[static_cast<std::size_t>(c)]};
            for (MuscleEntry m : s.muscles)
                if (m.cell == c) m.cell = 0, one.muscles.push_back(m);
            const auto gather = [&](const Vector& from) {
                Vector local;
                for (const int node : s.set.cell_nodes[static_cast<std::size_t>(c)])
                    local.insert(local.end(), from.begin() + 3 * node, from.begin() + 3 * node + 3);
                return local;
            };
            const auto scatter = [&](const Vector& local, Vector& to) {
                for (std::size_t k = 0; k < 24; ++k)
                    to[3 * static_cast<std::size_t>(s.set.cell_nodes[static_cast<std::size_t>(c)][k / 3]) + k % 3] +=
                        local[k];
            };
            const Body single = one.body();
            const Result r = evaluate(single, ws, gather(q), s.signals);
            energy += r.energy, inverted += ws.inverted;
            scatter(r.total, total);
            scatter(product(single, ws, gather(p)), sum_hp);
        }
        NEAR(all.energy, energy, 1e-13 * energy);
        NEAR(relative_difference(all.total, total), 0.0, 1e-13);
        NEAR(relative_difference(hp, sum_hp), 0.0, 1e-12);
        BodyWorkspace again;
        evaluate(body, again, q, s.signals);
        CHECK(again.inverted == inverted);
    }
}

void test_instruction_sets_agree() {
    const Sample s({5, 4, 3});
    for (const double part : {0.1, 0.5}) {
        const Vector q = s.displaced(part);
        Random random{9};
        const Vector p = random_vector(q.size(), random);
        Vector reference[4];
        int tried = 0;
        for (const InstructionSet wanted : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
            if (choose_instruction_set(wanted) != wanted) continue;
            const Body body = s.body(wanted);
            BodyWorkspace ws;
            const Result r = evaluate(body, ws, q, s.signals);
            Vector mu_bar(s.mu.size(), 0.0), weight_bar(s.muscles.size(), 0.0), signal_bar(2, 0.0);
            body.parameter_pullback(ws, q.data(), p.data(), 1,
                                    {mu_bar.data(), nullptr, weight_bar.data(), signal_bar.data()});
            const Vector values[4] = {r.total, product(body, ws, p), mu_bar, signal_bar};
            for (std::size_t k = 0; k < 4; ++k) {
                if (!tried) reference[k] = values[k];
                NEAR(relative_difference(values[k], reference[k]), 0.0, part < 0.2 ? 1e-13 : 1e-9);
            }
            ++tried;
        }
        CHECK(tried >= 1);
    }
}

void test_threads_give_the_same_bits() {
    const Sample s({12, 9, 7}, 301);
    const Body body = s.body();
    Random random{10};
    for (const double part : {0.1, 0.5}) {
        const Vector q = s.displaced(part), p = random_vector(q.size(), random);
        const auto run = [&](int threads) {
            BodyWorkspace ws;
            const Result r = evaluate(body, ws, q, s.signals, threads);
            Vector out(r.total), mu_bar(s.mu.size(), 0.0), weight_bar(s.muscles.size(), 0.0), signal_bar(2, 0.0);
            body.parameter_pullback(ws, q.data(), p.data(), threads,
                                    {mu_bar.data(), nullptr, weight_bar.data(), signal_bar.data()});
            for (const Vector& v : {product(body, ws, p, threads), mu_bar, weight_bar, signal_bar})
                out.insert(out.end(), v.begin(), v.end());
            out.push_back(r.energy), out.push_back(ws.inverted);
            return out;
        };
        const Vector one = run(1);
        CHECK(all_finite(one));
        for (const int threads : {2, 3, 4}) CHECK(run(threads) == one);
    }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_padding),
        TEST(test_instruction_sets_agree),
        TEST(test_threads_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
