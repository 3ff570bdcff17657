#include "host/verify/travel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/core/errors.h"
#include "tests/host/verify/synthetic_scan.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using test_support::SyntheticScan;

const Vector3d kNormal = Vector3d(0.1, 0.05, 1).normalized();

MeasuredPlane plane_at(double mm) {
    MeasuredPlane plane;
    plane.centre = Vector3d(0, 0, -400) + mm * kNormal;
    plane.normal = kNormal;
    plane.form.sigma_mm = 0.02;
    plane.form.points_used = 10000;
    return plane;
}

TEST(Travel, LinearityIsTheGreatestErrorOfAPlaceWithoutOffset) {
    // Errors 0, +a, 0, -a, 0 about the true places: linearity a whatever the offset, no scale.
    const std::vector<double> travelled = {-20, -10, 0, 10, 20};
    const std::vector<double> errors = {0.01, -0.03, 0.04, -0.03, 0.01};  // even: no slope, mean 0
    std::vector<MeasuredPlane> planes;
    for (std::size_t i = 0; i < errors.size(); ++i)
        planes.push_back(plane_at(5.5 + travelled[i] + errors[i]));
    const TravelFigures figures = travel_figures(planes, travelled);
    EXPECT_NEAR(figures.linearity_mm, 0.04, 1e-9);
    EXPECT_NEAR(figures.scale_error, 0, 1e-12);
    EXPECT_NEAR(figures.range_mm, 40, 1e-12);
    EXPECT_TRUE(std::isnan(figures.repeatability_mm));
    EXPECT_NEAR(figures.steps[1].error_mm, -0.03, 1e-9);
    EXPECT_NEAR(figures.steps[1].plane_sigma_mm, 0.0002, 1e-12);
}

TEST(Travel, ScaleCountsAsNonLinearity) {
    std::vector<MeasuredPlane> planes;
    const std::vector<double> travelled = {0, 10, 20, 30};
    for (const double mm : travelled) planes.push_back(plane_at(-1.001 * mm));  // away counts too
    const TravelFigures figures = travel_figures(planes, travelled);
    EXPECT_NEAR(figures.scale_error, 0.001, 1e-9);
    EXPECT_NEAR(figures.linearity_mm, 0.015, 1e-9);  // 0.001 x half the range
}

TEST(Travel, RepeatabilityIsPooledOverThePlacesScannedAgain) {
    std::vector<MeasuredPlane> planes;
    const std::vector<double> travelled = {0, 0, 10, 10, 20, 20};
    for (std::size_t i = 0; i < travelled.size(); ++i)
        planes.push_back(plane_at(travelled[i] + (i % 2 == 0 ? 0.003 : -0.003)));
    const TravelFigures figures = travel_figures(planes, travelled);
    EXPECT_EQ(figures.repeats, 3U);
    EXPECT_NEAR(figures.repeatability_mm, 0.003 * std::sqrt(2), 1e-9);  // of pairs 0.006 apart
    EXPECT_NEAR(figures.linearity_mm, 0, 1e-9);
}

TEST(Travel, OfScannedPlanesIsTheirNoise) {
    std::vector<MeasuredPlane> planes;
    const std::vector<double> travelled = {0, 15, 30, 30};
    std::mt19937 rng(1);
    for (std::size_t i = 0; i < travelled.size(); ++i) {
        SyntheticScan made(40 + static_cast<unsigned>(i));
        made.add_rectangle({0, 0, -400 - travelled[i]}, {150, 0, 0}, {0, 60, 0}, 4000, 0.02);
        planes.push_back(measure_plane(made.scan, {.size_mm = {150, 60}, .margin_mm = 2}, rng));
    }
    const TravelFigures figures = travel_figures(planes, travelled);
    EXPECT_LT(figures.linearity_mm, 0.002);  // mm: 0.02 / sqrt(4000) and the tilt's share
    EXPECT_NEAR(figures.range_mm, 30, 1e-12);
    EXPECT_LT(figures.repeatability_mm, 0.002);
}

TEST(Travel, RefusesTwoPlacesAndTilts) {
    EXPECT_THROW(travel_figures({plane_at(0), plane_at(1)}, {0, 1}), Error);
    MeasuredPlane tilted = plane_at(2);
    tilted.normal = Vector3d(0.25, 0.05, 1).normalized();
    EXPECT_THROW(travel_figures({plane_at(0), plane_at(1), tilted}, {0, 1, 2}), Error);
}

}  // namespace
}  // namespace stria
