#include "host/geometry/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace stria {
namespace {

double sum_of_inverses(std::size_t count) {
    constexpr std::size_t kGrain = 97;
    std::vector<double> partial((count + kGrain - 1) / kGrain, 0.0);
    parallel_for_blocks(count, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            partial[begin / kGrain] += 1.0 / static_cast<double>(i + 1);
    });
    double sum = 0;
    for (double value : partial) sum += value;
    return sum;
}

TEST(Parallel, VisitsEveryIndexOnceForAnyCountAndGrain) {
    for (std::size_t count : {0U, 1U, 6U, 7U, 8U, 1000U})
        for (std::size_t grain : {1U, 7U, 2000U}) {
            std::vector<std::atomic<int>> visits(count);
            parallel_for_blocks(count, grain, [&](std::size_t begin, std::size_t end) {
                ASSERT_EQ(begin % grain, 0U);
                ASSERT_LE(end - begin, grain);
                for (std::size_t i = begin; i < end; ++i) ++visits[i];
            });
            for (const auto& n : visits) ASSERT_EQ(n, 1) << count << " by " << grain;
        }
}

TEST(Parallel, SumsTheSameBitsForAnyThreadCount) {
    set_thread_count(1);
    EXPECT_EQ(thread_count(), 1);
    const double one = sum_of_inverses(100000);
    for (int threads : {2, 3, 8}) {
        set_thread_count(threads);
        EXPECT_EQ(thread_count(), threads);
        EXPECT_EQ(sum_of_inverses(100000), one);
    }
    set_thread_count(0);
    EXPECT_EQ(sum_of_inverses(100000), one);
    EXPECT_NEAR(one, std::log(1e5) + 0.5772156649015329 + 0.5e-5, 1e-10);  // Euler-Maclaurin
}

TEST(Parallel, RethrowsAndRefusesWhatMakesNoSense) {
    EXPECT_THROW(parallel_for_blocks(
                     100, 3, [](std::size_t, std::size_t) { throw std::runtime_error("body"); }),
                 std::runtime_error);
    EXPECT_THROW(parallel_for_blocks(1, 0, [](std::size_t, std::size_t) {}), std::invalid_argument);
    EXPECT_THROW(set_thread_count(-1), std::invalid_argument);
}

}  // namespace
}  // namespace stria
