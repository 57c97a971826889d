// SPDX-License-Identifier: MIT
// Loops over threads: every chunk once, ordered sums, exceptions, and crews that come and go without a hitch however
// the threads are scheduled.
#include "grid/parallel.hpp"
#include "motion_fixtures.hpp"

namespace {

using namespace fixtures;

void test_every_chunk_once() {
    for (const int threads : {1, 2, 3, 8})
        for (const int n : {0, 1, 7, 8, 9, 1000}) {
            std::vector<int> seen(static_cast<std::size_t>(n), 0);
            parallel_chunks(threads, n, 8, [&](int begin, int end) {
                CHECK(begin % 8 == 0 && end > begin && end <= begin + 8 && end <= n);
                for (int k = begin; k < end; ++k) ++seen[static_cast<std::size_t>(k)];
            });
            CHECK(std::all_of(seen.begin(), seen.end(), [](int k) { return k == 1; }));
        }
}

// Loops of all lengths one after the other by more threads than there are cores, so that many come late for a loop; and
// more chunks than a share's number holds.
void test_many_loops() {
    for (const int threads : {2, 3, 8})
        with_crew(threads, [&](Threads t) {
            for (int round = 0; round < 3000; ++round) {
                const int n = 1 + round % 40;
                std::vector<int> seen(static_cast<std::size_t>(n), 0);
                parallel_chunks(t, n, 1, [&](int k, int) { ++seen[static_cast<std::size_t>(k)]; });
                CHECK(std::all_of(seen.begin(), seen.end(), [](int k) { return k == 1; }));
            }
            std::vector<int> seen(200001, 0);
            parallel_chunks(t, 200001, 1, [&](int k, int) { ++seen[static_cast<std::size_t>(k)]; });
            CHECK(std::all_of(seen.begin(), seen.end(), [](int k) { return k == 1; }));
        });
}

void test_ordered_sum() {
    Random random{1};
    Vector terms(5000);
    for (double& t : terms) t = std::pow(10.0, between(random, -12, 12)) * random();  // any other order shows
    const auto total = [&](Threads threads) {
        return parallel_sum(threads, 5000, 16, [&](int begin, int end) {
            double s = 0.0;
            for (int k = begin; k < end; ++k) s += terms[static_cast<std::size_t>(k)];
            return s;
        });
    };
    const double expected = total(1);
    for (const int threads : {2, 3, 8}) {
        CHECK(total(threads) == expected);
        with_crew(threads, [&](Threads t) {
            for (int k = 0; k < 200; ++k) CHECK(total(t) == expected);
        });
    }
}

// Short crews, most of whose helpers wake up when the work is done or the crew is about to go: none may sleep on.
void test_short_crews() {
    int sum = 0;
    for (int round = 0; round < 1000; ++round) {
        std::atomic<int> chunks{0};
        with_crew(2 + round % 3, [&](Threads t) {
            for (int k = 0; k < round % 4; ++k) parallel_chunks(t, 3, 1, [&](int, int) { ++chunks; });
        });
        CHECK(chunks.load() == 3 * (round % 4));
        sum += chunks.load();
    }
    CHECK(sum == 3 * 6 * 250);
}

void test_exceptions() {
    for (const int threads : {1, 2, 4})
        for (int round = 0; round < 20; ++round) {
            const auto thrower = [&](int begin, int) {
                if (begin == 40) throw Error(Status::CANCELLED, "chunk 40");
            };
            EXPECT_ERROR(CANCELLED, "chunk 40", (parallel_chunks(threads, 100, 10, thrower), 0));
            // Within a crew the loop throws, and the crew works on.
            int after = 0;
            with_crew(threads, [&](Threads t) {
                EXPECT_ERROR(CANCELLED, "chunk 40", (parallel_chunks(t, 100, 10, thrower), 0));
                std::atomic<int> done{0};
                parallel_chunks(t, 100, 10, [&](int, int) { ++done; });
                after = done.load();
            });
            CHECK(after == 10);
            EXPECT_ERROR(ERROR_STATE, "outside",
                         (with_crew(threads, [](Threads) { throw Error(Status::ERROR_STATE, "outside a loop"); }), 0));
        }
}

}  // namespace

int main() {
    const CMUnitTest tests[] = {
        TEST(test_every_chunk_once), TEST(test_many_loops), TEST(test_ordered_sum),
        TEST(test_short_crews),      TEST(test_exceptions),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
