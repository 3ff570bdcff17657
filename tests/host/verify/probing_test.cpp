#include "host/verify/probing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "host/core/errors.h"
#include "tests/host/verify/synthetic_scan.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using test_support::SyntheticScan;

const Vector3d kCentre(20, -10, -400);
constexpr double kDiameter = 30;

Artefact sphere_of(double diameter_mm) {
    Artefact artefact;
    artefact.diameters = {{diameter_mm, 0.001}};
    return artefact;
}

ProbingPosition probe(const ScanPoints& scan, double diameter_mm = kDiameter, unsigned seed = 1) {
    std::mt19937 rng(seed);
    return probe_sphere(scan, sphere_of(diameter_mm), {}, rng);
}

std::string refusal(const ScanPoints& scan, double diameter_mm = kDiameter) {
    try {
        probe(scan, diameter_mm);
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST(Probing, ErrsByNothingOnAPerfectSphere) {
    SyntheticScan made(1);
    made.add_sphere(kCentre, kDiameter / 2, 3000, 0);
    made.scan.noise.clear();
    const ProbingPosition position = probe(made.scan);
    EXPECT_LT(position.sphere.form.form_all_mm, 1e-9);  // mm, rounding at 400 mm
    EXPECT_NEAR(position.size_mm, 0, 1e-9);
    EXPECT_LT((position.sphere.centre - kCentre).norm(), 1e-9);
    EXPECT_TRUE(std::isnan(position.sphere.form.predicted_sigma_mm));
    // Seen up to 60 deg: a cap of (1 - cos 60) / 2 = a quarter of the sphere.
    EXPECT_NEAR(position.sphere.coverage, 0.25, 0.06);
    EXPECT_NEAR(position.sphere.cap_rad, M_PI / 3, 0.06);
    EXPECT_GT(position.sphere.region.too_flat, 1000U);
}

TEST(Probing, FormOfGaussianNoiseIsTheExpectedRange) {
    constexpr int kTrials = 24;
    constexpr double kSigma = 0.02;
    double form = 0, all = 0, d95 = 0, sigma = 0, ratio = 0, expected = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
        SyntheticScan made(100 + static_cast<unsigned>(trial));
        made.add_sphere(kCentre, kDiameter / 2, 1000, kSigma, M_PI / 3 - 0.01);
        const FormFigures f = probe(made.scan).sphere.form;
        ASSERT_EQ(f.points_used + f.rejected, 1000U);
        ASSERT_EQ(f.rejected, 3U);
        form += f.form_mm / kSigma / kTrials;
        all += f.form_all_mm / kSigma / kTrials;
        d95 += f.d95_mm / kSigma / kTrials;
        sigma += f.sigma_mm / kSigma / kTrials;
        ratio += f.sigma_ratio / kTrials;
        expected += f.expected_form_mm / kSigma / kTrials;
    }
    // Standard errors of the means of 24: the range of 1000 varies by 0.5, D95 by 0.1.
    EXPECT_NEAR(all, 6.5, 0.3);
    EXPECT_NEAR(form, 5.7, 0.2);
    EXPECT_NEAR(expected, 5.7, 0.06);
    EXPECT_NEAR(d95, 3.9, 0.1);
    EXPECT_NEAR(sigma, 0.985, 0.02);  // three in a thousand less: 1.5 % of the deviation
    EXPECT_NEAR(ratio, 1.0, 0.03);
}

TEST(Probing, SizeIsUnbiasedAndVariesAsStated) {
    constexpr int kTrials = 60;
    double sum = 0, squares = 0, stated = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
        SyntheticScan made(500 + static_cast<unsigned>(trial));
        made.add_sphere(kCentre, kDiameter / 2, 400, 0.02, M_PI / 3 - 0.01);
        const ProbingPosition position = probe(made.scan);
        sum += position.size_mm;
        squares += position.size_mm * position.size_mm;
        stated += position.sphere.diameter_sigma_mm / kTrials;
    }
    const double mean = sum / kTrials;
    const double deviation = std::sqrt(squares / kTrials - mean * mean);
    EXPECT_LT(std::abs(mean), 4 * deviation / std::sqrt(kTrials));
    EXPECT_NEAR(deviation / stated, 1, 0.3);  // 4 standard deviations of a deviation of 60
}

TEST(Probing, LooksPastBackgroundStandAndTable) {
    SyntheticScan made(3);
    made.add_sphere(kCentre, kDiameter / 2, 6000, 0.01);
    const std::size_t of_sphere = made.scan.positions.size();
    // A stand below, a table it stands on, a wall behind, a second rod close in front.
    made.add_rod(kCentre - Vector3d(0, 30, 0), 5, 31, 3000, 0.01);
    made.add_rectangle(kCentre - Vector3d(0, 46, 0), {200, 0, 0}, {0, 0, 200}, 12000, 0.01);
    made.add_rectangle(kCentre - Vector3d(0, 0, 18), {260, 0, 0}, {0, 200, 0}, 40000, 0.01);
    const ProbingPosition position = probe(made.scan);
    for (const std::uint32_t i : position.sphere.region.points) ASSERT_LT(i, of_sphere);
    EXPECT_GT(position.sphere.region.points.size(), 2500U);
    EXPECT_LT(position.sphere.form.form_mm, 7.5 * 0.01);
    EXPECT_NEAR(position.size_mm, 0, 5 * position.sphere.diameter_sigma_mm);
}

TEST(Probing, CountsOutliersBeyondThreeInAThousand) {
    for (const int outliers : {8, 40}) {
        SyntheticScan made(4);
        made.add_sphere(kCentre, kDiameter / 2, 3000, 0.01, M_PI / 3 - 0.01);
        for (int i = 0; i < outliers; ++i) {  // in front of the surface, by 1 mm
            Vector3d& place = made.scan.positions[static_cast<std::size_t>(i) * 70];
            place += (place - kCentre).normalized();
        }
        const FormFigures f = probe(made.scan).sphere.form;
        EXPECT_GT(f.form_all_mm, 0.9);
        if (outliers <= 9)  // of 3000 points
            EXPECT_LT(f.form_mm, 0.08);
        else
            EXPECT_GT(f.form_mm, 0.9);
    }
}

TEST(Probing, TakesACloudWithoutSightWhole) {
    SyntheticScan made(5);
    made.add_sphere(kCentre, kDiameter / 2, 3000, 0.01);
    made.scan.towards_camera.clear();
    made.scan.noise.clear();
    const ProbingPosition position = probe(made.scan);
    EXPECT_EQ(position.sphere.region.points.size(), 3000U);
    EXPECT_GT(position.sphere.cap_rad, 1.3);
}

TEST(Probing, DependsOnItsSeedAlone) {
    SyntheticScan made(6);
    made.add_sphere(kCentre, kDiameter / 2, 3000, 0.01);
    made.add_rectangle(kCentre - Vector3d(0, 0, 18), {130, 0, 0}, {0, 100, 0}, 5000, 0.01);
    const ProbingPosition one = probe(made.scan, kDiameter, 1),
                          again = probe(made.scan, kDiameter, 1);
    EXPECT_EQ(one.size_mm, again.size_mm);
    const ProbingPosition other = probe(made.scan, kDiameter, 2);
    EXPECT_EQ(one.sphere.region.points, other.sphere.region.points);
}

TEST(Probing, RefusesWhatIsNotTheArtefact) {
    SyntheticScan plane(7);
    plane.add_rectangle(kCentre, {100, 0, 15}, {0, 75, 0}, 5000, 0.02);
    EXPECT_TRUE(has(refusal(plane.scan), "no sphere")) << refusal(plane.scan);

    // What a sphere may make of a rod has another diameter or scatters.
    for (const double radius : {kDiameter / 2, 0.36 * kDiameter}) {
        SyntheticScan rod(8);
        rod.add_rod(kCentre, radius, 100, 3000, 0.02);
        EXPECT_FALSE(refusal(rod.scan).empty()) << radius;
    }

    SyntheticScan sphere(9);
    sphere.add_sphere(kCentre, kDiameter / 2, 3000, 0.01);
    EXPECT_TRUE(has(refusal(sphere.scan, 1.1 * kDiameter), "diameter 30")) << "10 % off";
    EXPECT_TRUE(has(refusal(sphere.scan, 0.9 * kDiameter), "diameter 30"));
    EXPECT_TRUE(has(refusal(sphere.scan, 25.4 * kDiameter), "no sphere")) << "another unit";

    SyntheticScan bar(10);
    bar.add_sphere(kCentre, kDiameter / 2, 3000, 0.01);
    bar.add_sphere(kCentre + Vector3d(80, 0, 0), kDiameter / 2, 3000, 0.01);
    EXPECT_TRUE(has(refusal(bar.scan), "two spheres"));

    SyntheticScan rough(11);
    rough.add_sphere(kCentre, kDiameter / 2, 3000, 0.4, M_PI / 3);
    EXPECT_TRUE(has(refusal(rough.scan), "scatter")) << refusal(rough.scan);

    SyntheticScan few(12);
    few.add_sphere(kCentre, kDiameter / 2, 60, 0.01);
    EXPECT_TRUE(has(refusal(few.scan), "no sphere"));
    EXPECT_TRUE(has(refusal(ScanPoints{}), "no sphere"));
}

}  // namespace
}  // namespace stria
