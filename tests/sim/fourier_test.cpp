#include "sim/fourier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace stria {
namespace {

std::vector<std::complex<double>> noise(std::size_t count) {
    std::mt19937 rng(3);
    std::normal_distribution<double> normal;
    std::vector<std::complex<double>> values(count);
    for (auto& value : values) value = {normal(rng), normal(rng)};
    return values;
}

TEST(Fourier, EqualsTheDirectSum) {
    for (const std::size_t n : {1u, 2u, 8u, 12u, 64u}) {
        const auto input = noise(n);
        auto forward = input, inverse = input;
        Fourier(n).forward(forward);
        Fourier(n).inverse(inverse);
        for (std::size_t f = 0; f < n; ++f) {
            std::complex<double> plus = 0, minus = 0;
            for (std::size_t x = 0; x < n; ++x) {
                const double turn =
                    2 * std::numbers::pi * static_cast<double>(f * x % n) / static_cast<double>(n);
                minus += input[x] * std::polar(1.0, -turn);
                plus += input[x] * std::polar(1.0, turn);
            }
            EXPECT_LT(std::abs(forward[f] - minus), 1e-12) << n << ", " << f;  // rounding
            EXPECT_LT(std::abs(inverse[f] - plus), 1e-12) << n << ", " << f;
        }
    }
}

TEST(Fourier, ComesBackTimesItsLength) {
    constexpr std::size_t kLength = 4096;
    const auto input = noise(kLength);
    auto values = input;
    const Fourier fourier(kLength);
    fourier.forward(values);
    fourier.inverse(values);
    for (std::size_t i = 0; i < kLength; ++i)
        EXPECT_LT(std::abs(values[i] / double{kLength} - input[i]), 1e-12);
}

TEST(Fourier, RefusesOtherLengths) {
    EXPECT_THROW(Fourier(0), std::invalid_argument);
    EXPECT_THROW(Fourier((std::size_t{1} << 24) + 1), std::invalid_argument);
    auto values = noise(4);
    EXPECT_THROW(Fourier(8).forward(values), std::invalid_argument);
}

}  // namespace
}  // namespace stria
