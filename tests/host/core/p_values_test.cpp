#include "host/core/p_values.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stria {
namespace {

/// Closed form for even degrees of freedom: the first dof / 2 terms of a Poisson sum.
double even_tail(double x, int dof) {
    double term = std::exp(-x / 2), sum = 0;
    for (int k = 0; k < dof / 2; ++k) {
        sum += term;
        term *= x / 2 / (k + 1);
    }
    return sum;
}

TEST(PValues, ChiSquareHasItsClosedFormForEvenDegrees) {
    for (int dof = 2; dof <= 60; dof += 2)
        for (double x = 0.1; x < 150; x *= 1.3) {
            const double wanted = even_tail(x, dof);
            EXPECT_NEAR(chi_square_tail(x, dof), wanted, 1e-12 + 1e-9 * wanted) << dof << ' ' << x;
        }
}

TEST(PValues, OneDegreeIsTwoNormalTails) {
    for (double z = 0.05; z < 8; z += 0.25) {
        const double wanted = 2 * normal_tail(z);
        EXPECT_NEAR(chi_square_tail(z * z, 1), wanted, 1e-13 + 1e-9 * wanted) << z;
    }
    EXPECT_NEAR(normal_tail(1.6448536269514722), 0.05, 1e-12);  // tables
}

TEST(PValues, NothingToTestProvesNothing) {
    EXPECT_EQ(chi_square_tail(0, 3), 1);
    EXPECT_EQ(chi_square_tail(5, 0), 1);
    EXPECT_EQ(chi_square_tail(-1, 3), 1);
    EXPECT_LT(chi_square_tail(1e6, 10), 1e-300);
}

}  // namespace
}  // namespace stria
