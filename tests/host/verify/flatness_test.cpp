#include "host/verify/flatness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/core/errors.h"
#include "tests/host/verify/synthetic_scan.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using test_support::SyntheticScan;

const Vector3d kMiddle(10, 5, -400);
const Vector3d kLong = 150 * Vector3d(0.95, 0, 0.3).normalized();
const Vector3d kShort(0, 60, 0);

MeasuredPlane measure(const ScanPoints& scan, double margin_mm = 2) {
    std::mt19937 rng(1);
    return measure_plane(scan, {.size_mm = {150, 60}, .margin_mm = margin_mm}, rng);
}

std::string refusal(const ScanPoints& scan) {
    try {
        measure(scan);
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

TEST(Flatness, OfNoiseIsTheExpectedRange) {
    constexpr int kTrials = 6;
    constexpr double kSigma = 0.02;
    double form = 0, expected = 0, d95 = 0, ratio = 0;
    for (unsigned trial = 0; trial < kTrials; ++trial) {
        SyntheticScan made(20 + trial);
        made.add_rectangle(kMiddle, kLong, kShort, 10000, kSigma);
        const FormFigures f = measure(made.scan, 0).form;
        form += f.form_mm / kSigma / kTrials;
        expected += f.expected_form_mm / kSigma / kTrials;
        d95 += f.d95_mm / kSigma / kTrials;
        ratio += f.sigma_ratio / kTrials;
    }
    EXPECT_NEAR(form, 5.9, 0.15);  // the range of 1e4 after rejection varies by 0.1
    EXPECT_NEAR(expected, 5.9, 0.06);
    EXPECT_NEAR(d95, 3.92, 0.05);
    EXPECT_NEAR(ratio, 1, 0.02);
}

TEST(Flatness, OfASaddleIsItsDepth) {
    // z = h x y / (a b / 4), orthogonal to 1, x and y over the rectangle: the fit leaves it whole.
    constexpr double kDepth = 0.1;
    SyntheticScan made(2);
    for (int i = 0; i <= 100; ++i)
        for (int k = 0; k <= 40; ++k) {
            const double x = i / 100.0 - 0.5, y = k / 40.0 - 0.5;
            made.add_at({150 * x, 60 * y, -400 + kDepth * 4 * x * y}, 0.01);
        }
    const MeasuredPlane plane = measure(made.scan, 0);
    EXPECT_NEAR(plane.form.form_all_mm, 2 * kDepth, 1e-4);  // mm: slopes of 1e-3 rad
    EXPECT_GT(plane.form.form_mm, 1.8 * kDepth);            // three in a thousand: the corners
    EXPECT_NEAR(plane.size_mm.x(), 150, 0.1);
    EXPECT_NEAR(plane.size_mm.y(), 60, 0.1);
}

TEST(Flatness, LooksPastWallTableAndWhatLiesOnIt) {
    SyntheticScan made(3);
    made.add_rectangle(kMiddle, kLong, kShort, 8000, 0.01);
    const std::size_t of_plane = made.scan.positions.size();
    made.add_rectangle({0, 0, -460}, {400, 0, 0}, {0, 300, 0}, 40000, 0.01);
    made.add_rectangle({0, -60, -400}, {300, 0, 0}, {0, 0, 120}, 10000, 0.01);
    // A coin on it, 1.7 mm thick.
    const Vector3d normal = kLong.cross(kShort).normalized();
    const Vector3d coin = kMiddle + 0.2 * kLong + (normal.z() > 0 ? 1.7 : -1.7) * normal;
    made.add_rectangle(coin, 15 * kLong.normalized(), {0, 15, 0}, 400, 0.01);
    const MeasuredPlane plane = measure(made.scan);
    EXPECT_LT(plane.form.form_mm, 7.5 * 0.01);
    EXPECT_GT(plane.form.points_used, 6000U);
    EXPECT_LE(plane.form.points_used, of_plane);
    EXPECT_GT(plane.beside, 400U);
    EXPECT_NEAR(std::abs(plane.normal.dot(normal)), 1, 1e-6);
    EXPECT_GT(plane.normal.z(), 0) << "towards the camera";
}

TEST(Flatness, CountsABurrButNotWhatLiesOutsideTheMargin) {
    SyntheticScan made(4);
    made.add_rectangle(kMiddle, kLong, kShort, 8000, 0.01);
    const Vector3d normal = kLong.cross(kShort).normalized();
    SyntheticScan curled = made;
    int moved = 0;
    for (Vector3d& p : curled.scan.positions)
        if (p.y() - kMiddle.y() > 29) p += 0.15 * normal;  // the last millimetre
    EXPECT_GT(measure(curled.scan, 0).form.form_mm, 0.14);
    EXPECT_LT(measure(curled.scan, 2).form.form_mm, 0.08);
    for (Vector3d& p : made.scan.positions)
        if ((p - kMiddle).norm() < 5 && ++moved <= 27) p += 0.4 * normal;
    ASSERT_GE(moved, 27) << "more than three in a thousand of 8000";
    EXPECT_GT(measure(made.scan).form.form_mm, 0.35);
}

TEST(Flatness, RefusesAnotherPlane) {
    SyntheticScan wall(5);
    wall.add_rectangle({0, 0, -460}, {400, 0, 0}, {0, 300, 0}, 20000, 0.01);
    const std::string larger = refusal(wall.scan);
    EXPECT_NE(larger.find("found no plane of 150 x 60 mm; planes found: "), std::string::npos);
    EXPECT_EQ(larger.find("none"), std::string::npos) << larger;
    SyntheticScan sphere(6);
    sphere.add_sphere(kMiddle, 30, 5000, 0.01);
    EXPECT_NE(refusal(sphere.scan).find("found no plane"), std::string::npos);
    EXPECT_NE(refusal(ScanPoints{}).find("planes found: none"), std::string::npos);
}

}  // namespace
}  // namespace stria
