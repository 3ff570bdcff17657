#include "host/verify/drift.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <iostream>

#include "host/core/errors.h"
#include "tests/host/verify/synthetic_range.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using test_support::make_range;
using test_support::SyntheticRange;

constexpr double kBallMm = 60;

SyntheticRange small_image() {
    SyntheticRange scene;
    scene.width = 200;
    scene.height = 150;
    scene.focal_px = 300;
    return scene;
}

SyntheticRange sphere_scene() {
    SyntheticRange scene = small_image();
    scene.balls = {{Vector3d(15, -10, -350), kBallMm / 2}};
    return scene;
}

SyntheticRange plane_scene() {
    SyntheticRange scene = small_image();
    scene.tiles = {{Vector3d(0, 5, -400), Vector3d(150, 10, 20), Vector3d(-4, 60, 15)}};
    return scene;
}

/// Along the ray, mm, by one standard deviation: the range's scale, its bend over the image either
/// way, and a shear of depth by height.
std::array<float, 4> sensitivities(const Vector3d& p) {
    const double u = p.x() / -p.z(), v = p.y() / -p.z();
    return {static_cast<float>(0.02 * p.norm() / 400), static_cast<float>(0.2 * u * u),
            static_cast<float>(0.3 * v * v), static_cast<float>(0.25 * u * v)};
}

/// The scan by a scanner whose calibration is off by that many standard deviations in each mode.
ScanPoints scan_off_by(const SyntheticRange& scene, const std::array<double, 4>& off,
                       unsigned seed) {
    RangeImage image = make_range(scene, seed);
    image.sensitivity_count = 4;
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell) {
        const auto by =
            sensitivities(image.points[cell].position.isZero() ? Vector3d(0, 0, -400)
                                                               : image.points[cell].position);
        image.sensitivity.insert(image.sensitivity.end(), by.begin(), by.end());
        RangePoint& point = image.points[cell];
        for (std::size_t k = 0; k < 4; ++k)
            point.position += off[k] * double(by[k]) * point.error_direction.cast<double>();
    }
    return scan_points(image);
}

Artefact sphere_artefact(double expanded_mm = 0) {
    Artefact artefact;
    artefact.diameters = {{kBallMm, expanded_mm}};
    return artefact;
}

Artefact plane_artefact() {
    Artefact artefact;
    artefact.size_mm = {151.6, 62};
    artefact.margin_mm = 3;
    return artefact;
}

ShapeCheck check(const SyntheticRange& scene, const std::array<double, 4>& off, unsigned seed) {
    std::mt19937 rng(seed);
    const ScanPoints scan = scan_off_by(scene, off, seed);
    return scene.balls.empty() ? check_plane(scan, plane_artefact(), rng)
                               : check_sphere(scan, sphere_artefact(), {}, rng);
}

class DriftOf : public testing::TestWithParam<bool> {
  protected:
    SyntheticRange scene() const { return GetParam() ? sphere_scene() : plane_scene(); }
};

/// Calibrations as far off as they say: the alarm is as rare as it says, and p is uniform.
TEST_P(DriftOf, WhatTheCalibrationExpectsIsNoDrift) {
    constexpr int kTrials = 80;
    double p = 0, squares = 0, count = 0;
    int alarms = 0;
    std::mt19937 rng(5);
    std::normal_distribution<double> unit(0, 1);
    for (unsigned trial = 0; trial < kTrials; ++trial) {
        const std::array<double, 4> off = {unit(rng), unit(rng), unit(rng), unit(rng)};
        const Drift drift = judge_drift(check(scene(), off, 50 + trial));
        p += drift.p_value / kTrials;
        alarms += drift.has_drifted();
        for (std::size_t i = 0; i < drift.off_mm.size(); ++i) {
            squares += std::pow(drift.off_mm[i] / drift.expected_mm[i], 2);
            ++count;
        }
    }
    std::cout << "p " << p << " on average, " << alarms << " alarms in " << kTrials
              << ", off over expected " << std::sqrt(squares / count) << " rms" << std::endl;
    EXPECT_NEAR(p, 0.5, 3 * 0.289 / std::sqrt(kTrials));
    EXPECT_LE(alarms, 10);  // 3.6 expected; 10 or more once in 200
    EXPECT_NEAR(std::sqrt(squares / count), 1, 3 / std::sqrt(2.0 * kTrials));
}

TEST_P(DriftOf, ADriftOfManySigmasIsSeen) {
    int seen = 0;
    for (unsigned trial = 0; trial < 10; ++trial)
        seen += judge_drift(check(scene(), {GetParam() ? 20.0 : 0, 0, GetParam() ? 0 : 8.0, 0},
                                  400 + trial))
                    .has_drifted();
    EXPECT_EQ(seen, 10);
}

/// What noise alone does to the figures, over many scans, against what the check says of it.
TEST_P(DriftOf, NoiseIsAsStated) {
    constexpr int kTrials = 60;
    Eigen::MatrixXd stated;
    Eigen::VectorXd squares, mean;
    for (unsigned trial = 0; trial < kTrials; ++trial) {
        const ShapeCheck found = check(scene(), {0, 0, 0, 0}, 900 + trial);
        const auto count = static_cast<Eigen::Index>(found.figures.size());
        if (trial == 0) squares = mean = Eigen::VectorXd::Zero(count);
        stated = found.noise;
        for (Eigen::Index i = 0; i < count; ++i) {
            const double off = found.figures[static_cast<std::size_t>(i)].off_mm;
            squares[i] += off * off / kTrials;
            mean[i] += off / kTrials;
        }
    }
    for (Eigen::Index i = 0; i < mean.size(); ++i) {
        const double sigma = std::sqrt(stated(i, i));
        EXPECT_NEAR(mean[i], 0, 4 * sigma / std::sqrt(kTrials)) << i;
        EXPECT_NEAR(std::sqrt(squares[i]), sigma, 4 * sigma / std::sqrt(2.0 * kTrials)) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Artefacts, DriftOf, testing::Bool(),
                         [](const auto& sphere) { return sphere.param ? "sphere" : "plane"; });

TEST(Drift, AReferenceTakesOutWhatTheArtefactIsOff) {
    SyntheticRange scene = sphere_scene();
    scene.balls[0].radius_mm += 0.1;  // the certificate is wrong, or light goes into the sphere
    const ShapeCheck first = check(scene, {0, 0, 0, 0}, 1), second = check(scene, {0, 0, 0, 0}, 2);
    EXPECT_NEAR(first.figures[0].off_mm, 0.2, 0.005);
    EXPECT_TRUE(judge_drift(first).has_drifted());
    const Drift since = judge_drift(second, &first);
    EXPECT_FALSE(since.has_drifted());
    EXPECT_NEAR(since.off_mm[0], 0, 0.005);
    EXPECT_GT(since.expected_mm[0], judge_drift(second).expected_mm[0]);
    EXPECT_TRUE(judge_drift(check(scene, {20, 0, 0, 0}, 3), &first).has_drifted());
}

TEST(Drift, TheArtefactsOwnUncertaintyCounts) {
    const ScanPoints scan = scan_off_by(sphere_scene(), {0, 0, 0, 0}, 1);
    std::mt19937 rng(1), again(1);
    const ShapeCheck sure = check_sphere(scan, sphere_artefact(), {}, rng);
    const ShapeCheck vague = check_sphere(scan, sphere_artefact(0.2), {}, again);
    EXPECT_NEAR(std::pow(judge_drift(vague).expected_mm[0], 2) -
                    std::pow(judge_drift(sure).expected_mm[0], 2),
                0.01, 1e-9);
}

TEST(Drift, ABentPlateIsMeasuredAsBent) {
    RangeImage image = make_range(plane_scene(), 1);
    const Vector3d along = Vector3d(150, 10, 20).normalized();
    const Vector3d normal = Vector3d(150, 10, 20).cross(Vector3d(-4, 60, 15)).normalized();
    image.sensitivity_count = 1;
    image.sensitivity.assign(image.cell_count(), 0.001F);
    // 0.15 mm where the patch inside the margin ends.
    const double half = 0.5 * (Vector3d(150, 10, 20).norm() - 6);
    for (RangePoint& point : image.points) {
        const double a = (point.position - plane_scene().tiles[0].centre).dot(along) / half;
        point.position += 0.15 * a * a * normal;
    }
    std::mt19937 rng(1);
    const ShapeCheck found = check_plane(scan_points(image), plane_artefact(), rng);
    const double sign = found.figures[0].off_mm > 0 ? 1 : -1;  // the normal points to the camera
    EXPECT_NEAR(sign * found.figures[0].off_mm, 0.15, 0.01);   // the patch's size is measured
    EXPECT_NEAR(found.figures[1].off_mm, 0, 0.02);
    EXPECT_NEAR(found.figures[2].off_mm, 0, 0.02);
    EXPECT_TRUE(judge_drift(found).has_drifted());
}

TEST(Drift, IsNotToldWithoutACalibrationsExpectations) {
    std::mt19937 rng(1);
    const ScanPoints scan = scan_points(make_range(sphere_scene(), 1));
    try {
        check_sphere(scan, sphere_artefact(), {}, rng);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("covariance"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace stria
