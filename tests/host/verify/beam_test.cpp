#include "host/verify/beam.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/core/errors.h"
#include "tests/host/verify/synthetic_scan.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using test_support::SyntheticScan;

const Vector3d kFirst(-50, -20, -420);
const Vector3d kLine = Vector3d(0.9, 0.3, 0.2).normalized();

Artefact bar(double first_diameter, double second_diameter, double length) {
    Artefact artefact;
    artefact.diameters = {{first_diameter, 0.001}, {second_diameter, 0.001}};
    artefact.lengths = {{length, 0.002}};
    return artefact;
}

/// Spheres of those diameters at those places along the line, before a wall, on a rod.
ScanPoints scan_of(const std::vector<double>& diameters, const std::vector<double>& places,
                   double sigma_mm, unsigned seed) {
    SyntheticScan made(seed);
    for (std::size_t i = 0; i < diameters.size(); ++i)
        made.add_sphere(kFirst + places[i] * kLine, diameters[i] / 2, 2500, sigma_mm);
    made.add_rectangle({0, 0, -470}, {300, 0, 0}, {0, 240, 0}, 15000, sigma_mm);
    return made.scan;
}

MeasuredBeam measure(const ScanPoints& scan, const Artefact& artefact) {
    std::mt19937 rng(1);
    return measure_beam(scan, artefact, {}, rng);
}

std::string refusal(const ScanPoints& scan, const Artefact& artefact) {
    try {
        measure(scan, artefact);
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

TEST(Beam, SpacingIsTheDistanceOfTheCentres) {
    const Artefact artefact = bar(30, 30, 100);
    const BeamLength exact =
        centre_distance(measure(scan_of({30, 30}, {0, 100.02}, 0, 1), artefact), artefact, 0, 1);
    EXPECT_NEAR(exact.error_mm(), 0.02, 1e-8);  // mm, rounding at 400 mm
    EXPECT_NEAR(exact.expanded_mm, 0.002, 1e-6);

    double chi2 = 0;
    constexpr int kTrials = 8;
    for (unsigned trial = 0; trial < kTrials; ++trial) {
        const MeasuredBeam beam = measure(scan_of({30, 30}, {0, 100}, 0.02, 10 + trial), artefact);
        const BeamLength length = centre_distance(beam, artefact, 0, 1);
        const double fit_sigma = std::sqrt(length.expanded_mm * length.expanded_mm - 4e-6) / 2;
        chi2 += std::pow(length.error_mm() / fit_sigma, 2);
    }
    EXPECT_LT(chi2, 29.7);  // chi-square of 8, p = 0.00024
    EXPECT_GT(chi2, 0.85);  // p = 0.0007
}

TEST(Beam, LengthOverBothHoldsTheirSizes) {
    // Spheres that scan 0.03 too large: the spacing of given radii keeps, the outer length errs.
    const Artefact artefact = bar(30, 30, 100);
    const MeasuredBeam beam = measure(scan_of({30.03, 30.03}, {0, 100}, 0, 2), artefact);
    EXPECT_NEAR(length_over(beam, artefact, 0, 1).error_mm(), 0.03, 1e-8);
    EXPECT_NEAR(length_over(beam, artefact, 0, 1).calibrated_mm, 130, 1e-9);
    // Given 0.015 less, a centre is 9/7 of it nearer to the camera (60 deg caps, see FitSphere).
    const Vector3d away = (kFirst + 100 * kLine).normalized() - kFirst.normalized();
    EXPECT_NEAR(centre_distance(beam, artefact, 0, 1).error_mm(), -0.015 * 9 / 7 * away.dot(kLine),
                0.001);
}

TEST(Beam, SwappedSpheresAreToldApart) {
    const ScanPoints scan = scan_of({30, 25}, {0, 100}, 0.01, 3);
    const Artefact as_scanned = bar(30, 25, 100), swapped = bar(25, 30, 100);
    const MeasuredBeam one = measure(scan, as_scanned), other = measure(scan, swapped);
    EXPECT_NEAR(one.free[0].diameter_mm, 30, 0.02);
    EXPECT_NEAR(other.free[0].diameter_mm, 25, 0.02);
    EXPECT_NEAR(centre_distance(one, as_scanned, 0, 1).error_mm(), 0, 0.01);
    EXPECT_EQ(centre_distance(one, as_scanned, 0, 1).measured_mm,
              centre_distance(other, swapped, 0, 1).measured_mm);
}

TEST(Beam, OrdersASpheresLineByItsLengths) {
    Artefact artefact;
    artefact.diameters = {{20, 0.001}, {20, 0.001}, {20, 0.001}};
    artefact.lengths = {{40, 0.001}, {110, 0.002}};
    for (const std::vector<double>& places : {std::vector<double>{0, 40, 110}, {0, 70, 110}}) {
        const MeasuredBeam beam = measure(scan_of({20, 20, 20}, places, 0.005, 4), artefact);
        EXPECT_NEAR(centre_distance(beam, artefact, 0, 1).calibrated_mm, 40, 1e-9);
        EXPECT_NEAR(centre_distance(beam, artefact, 0, 1).error_mm(), 0, 0.01);
        EXPECT_NEAR(centre_distance(beam, artefact, 1, 2).error_mm(), 0, 0.01);
        EXPECT_NEAR(centre_distance(beam, artefact, 1, 2).calibrated_mm, 70, 1e-9);
    }
}

TEST(Beam, RefusesAnotherBar) {
    const ScanPoints scan = scan_of({30, 30}, {0, 100}, 0.01, 5);
    EXPECT_NE(refusal(scan, bar(33, 33, 100)).find("the artefact's is 33"), std::string::npos);
    EXPECT_NE(refusal(scan, bar(30, 27, 100)).find("the artefact's is 27"), std::string::npos);
    EXPECT_NE(refusal(scan, bar(30, 30, 105)).find("105"), std::string::npos);
    EXPECT_NE(refusal(scan_of({30}, {0}, 0.01, 6), bar(30, 30, 100))
                  .find("found 1, the artefact has 2; does one hide"),
              std::string::npos);
    EXPECT_NE(
        refusal(scan_of({30, 30, 30}, {0, 50, 100}, 0.01, 7), bar(30, 30, 100)).find("found 3"),
        std::string::npos);
}

}  // namespace
}  // namespace stria
