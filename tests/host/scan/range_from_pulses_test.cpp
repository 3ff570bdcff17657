#include "host/scan/range_from_pulses.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <random>

#include "host/core/errors.h"
#include "host/geometry/fit.h"
#include "tests/support/synthetic_scanner.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using test_support::rail_scanner;
using test_support::swept_scanner;
using test_support::turntable_scanner;

/// s at which the ray of a pixel meets the plane n . p = d (scan frame) on the sheet; bisection.
std::optional<double> crossing(const Channel& channel, const Eigen::Vector2d& pixel,
                               const Vector3d& n, double d, double low, double high) {
    const auto miss = [&](double s) {
        const auto hit = triangulate(channel, pixel, s);
        return hit ? n.dot(hit->point_in_scan) - d : std::nan("");
    };
    double at_low = miss(low), at_high = miss(high);
    if (!(at_low * at_high <= 0)) return std::nullopt;
    for (int i = 0; i < 80; ++i) {
        const double middle = 0.5 * (low + high), at_middle = miss(middle);
        if (at_low * at_middle <= 0) {
            high = middle;
        } else {
            low = middle;
            at_low = at_middle;
        }
    }
    return 0.5 * (low + high);
}

constexpr double kSpeed = 0.5;  // rad/s
const Vector3d kNormal = Vector3d(0.2, -0.1, 1).normalized();
const double kOffset = kNormal.dot(Vector3d(0, 0, -450));

/// Pulses of a swept scan of the plane, every 16th pixel a cell, noise of sigma_s on s.
PulseMap plane_pulses(const ScannerModel& model, double sigma_s, unsigned seed) {
    const Channel& channel = model.channels.front();
    PulseMap map;
    map.width = channel.camera.width / 16;
    map.height = channel.camera.height / 16;
    map.cell_begin.push_back(0);
    std::mt19937 rng(seed);
    std::normal_distribution<double> noise;
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const Eigen::Vector2d pixel(16 * x + 5, 16 * y + 3);
            if (const auto s = crossing(channel, pixel, kNormal, kOffset, -0.15, 0.15)) {
                Pulse pulse;
                pulse.u = static_cast<float>(pixel.x());
                pulse.v = static_cast<float>(pixel.y());
                pulse.s = *s + sigma_s * noise(rng);
                pulse.ds_dt = kSpeed;
                pulse.amplitude = 100;
                pulse.sigma = static_cast<float>(sigma_s / kSpeed * 1e9);
                const auto hit = triangulate(channel, pixel, *s);
                const Vector3d normal = sheet_at(channel, *s).normal;
                const double mm_per_rad = std::abs(normal.dot(
                    scan_from_camera(channel, *s).rotation.transpose() * hit->d_point_d_s));
                pulse.width = static_cast<float>(0.5 / mm_per_rad / kSpeed * 1e9);  // beam 0.5 mm
                map.pulses.push_back(pulse);
            }
            map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
        }
    return map;
}

TEST(RangeFromPulses, PutsNoiseFreePulsesOnThePlane) {
    const auto result = range_from_pulses(plane_pulses(swept_scanner(), 0, 1), swept_scanner());
    ASSERT_GT(result.statistics.points, 800U);
    for (std::size_t i = 0; i < result.image.cell_count(); ++i)
        if (result.image.mask[i] != 0) {
            EXPECT_NEAR(kNormal.dot(result.image.points[i].position), kOffset,
                        1e-6);  // mm: bisection
        }
}

TEST(RangeFromPulses, SigmaIsTheScatterAlongTheRay) {
    const auto noisy = range_from_pulses(plane_pulses(swept_scanner(), 2e-5, 7), swept_scanner());
    double sum = 0;
    for (std::size_t i = 0; i < noisy.image.cell_count(); ++i) {
        if (!noisy.image.mask[i]) continue;
        const RangePoint& point = noisy.image.points[i];
        const Vector3d e = point.error_direction.cast<double>();
        const double along = (kNormal.dot(point.position) - kOffset) / kNormal.dot(e);
        sum += along * along / (point.sigma_mm * point.sigma_mm);
    }
    // ~1000 points: the mean of squares scatters by 0.045
    EXPECT_NEAR(sum / static_cast<double>(noisy.statistics.points), 1.0, 0.15);
}

TEST(RangeFromPulses, RejectsPulsesTooWideForTheBeam) {
    PulseMap map = plane_pulses(swept_scanner(), 0, 1);
    for (std::size_t i = 0; i < map.pulses.size(); i += 10) map.pulses[i].width *= 2;
    const auto result = range_from_pulses(map, swept_scanner());
    EXPECT_EQ(result.statistics.wrong_width, (map.pulses.size() + 9) / 10);
}

TEST(RangeFromPulses, KeepsTheOtherPulsesAsFurtherReturns) {
    PulseMap map = plane_pulses(swept_scanner(), 0, 1);
    std::size_t cell = 0;
    while (map.cell_begin[cell + 1] == map.cell_begin[cell]) ++cell;
    Pulse ghost = map.pulses[map.cell_begin[cell]];
    ghost.amplitude *= 3;
    ghost.flags = kPulseGhostSuspected;
    ghost.s += 0.001;
    map.pulses.insert(map.pulses.begin() + map.cell_begin[cell], ghost);
    for (std::size_t i = cell + 1; i < map.cell_begin.size(); ++i) ++map.cell_begin[i];
    const auto result = range_from_pulses(map, swept_scanner());
    ASSERT_EQ(result.image.further.size(), 1U);
    EXPECT_EQ(result.image.further[0].cell, cell);
    EXPECT_EQ(result.image.points[cell].flags, 0);  // the one without a warning, though weaker
}

TEST(RangeFromPulses, WhatTwoDirectionsDenyStaysFlaggedAndComesLast) {
    PulseMap map = plane_pulses(swept_scanner(), 0, 1);
    std::vector<std::size_t> cells;
    for (std::size_t cell = 0; cells.size() < 2; ++cell)
        if (map.cell_begin[cell + 1] > map.cell_begin[cell]) cells.push_back(cell);
    // The first cell holds the denied pulse beside another one, which is on no surface; the second
    // one nothing else.
    map.pulses[map.cell_begin[cells[0]]].flags = kPulseGhostSuspected;
    map.pulses[map.cell_begin[cells[1]]].flags = kPulseGhostSuspected;
    Pulse other = map.pulses[map.cell_begin[cells[0]]];
    other.flags = 0;
    other.amplitude /= 3;
    other.s += 0.01;
    map.pulses.insert(map.pulses.begin() + map.cell_begin[cells[0]], other);
    for (std::size_t i = cells[0] + 1; i < map.cell_begin.size(); ++i) ++map.cell_begin[i];
    const auto told = range_from_pulses(map, swept_scanner(), {.directions_compared = true});
    EXPECT_EQ(told.image.points[cells[0]].flags, 0);
    EXPECT_EQ(told.image.points[cells[0]].s, other.s);
    EXPECT_EQ(told.image.points[cells[1]].flags, kPulseGhostSuspected);
    EXPECT_EQ(told.statistics.contradicted, 1U);
    // By strength alone it would be no suspicion.
    const auto untold = range_from_pulses(map, swept_scanner());
    EXPECT_NE(untold.image.points[cells[0]].s, other.s);
    EXPECT_EQ(untold.image.points[cells[1]].flags, 0);
}

TEST(RangeFromPulses, RefusesALaserTheModelDoesNotKnow) {
    PulseMap map = plane_pulses(swept_scanner(), 0, 1);
    map.pulses[0].laser_id = 3;
    EXPECT_THROW((void)range_from_pulses(map, swept_scanner()), Error);
}

TEST(RangeFromPulses, AnEmptySweepGivesAnEmptyImage) {
    PulseMap map;
    map.width = 4;
    map.height = 3;
    map.cell_begin.assign(13, 0);
    const auto result = range_from_pulses(map, swept_scanner());
    EXPECT_EQ(result.statistics.points, 0U);
    EXPECT_TRUE(result.image.stations.empty());
}

TEST(RangeFromPulses, StationsFollowTheHead) {
    for (const ScannerModel& model : {rail_scanner(), turntable_scanner()}) {
        const Channel& channel = model.channels.front();
        PulseMap map;
        map.mode = StripeMode::spatial;
        map.width = 2;
        map.height = 1;
        map.cell_begin = {0, 1, 2};
        for (double s : {0.0, 0.4}) {
            Pulse pulse;
            pulse.u = 320;
            pulse.v = 250;
            pulse.s = s;
            pulse.ds_dt = 1;
            pulse.sigma = 0.1F;
            pulse.amplitude = 50;
            map.pulses.push_back(pulse);
        }
        const auto result = range_from_pulses(map, model);
        ASSERT_EQ(result.statistics.points, 2U);
        const Vector3d expected = scan_from_camera(channel, 0.2) * Vector3d::Zero();
        // mm: sagitta of 450 mm over 0.01 rad is 0.006
        EXPECT_LT((station_at(result.image, 0.2).camera_in_scan - expected).norm(), 0.01);
        // a spatial peak errs inside the sheet
        const Vector3d normal = scan_from_camera(channel, 0.0).rotation * channel.sheet.normal;
        EXPECT_NEAR(normal.dot(result.image.points[0].error_direction.cast<double>()), 0, 1e-5);
    }
}

/// Oracle: models drawn from the covariance, each scan moved back onto the first by the best
/// rigid motion of its points; the scatter along the ray against sigma_systematic.
TEST(RangeFromPulses, SystematicSigmaIsTheScatterOverCalibrations) {
    ScannerModel model = swept_scanner();
    const auto names = parameter_names(model);
    const auto n = static_cast<Eigen::Index>(names.size());
    model.covariance = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const std::string& name = names[static_cast<std::size_t>(i)];
        double sd = 0;
        if (name.ends_with(".fx") || name.ends_with(".cx")) sd = 0.5;
        if (name.ends_with("k1")) sd = 2e-3;
        if (name.ends_with("mirror.normal_a") || name.ends_with("mirror.axis_a")) sd = 2e-4;
        if (name.ends_with("mirror.g2")) sd = 2e-3;
        model.covariance(i, i) = sd * sd;
    }
    const PulseMap map = plane_pulses(model, 0, 1);
    const auto reference = range_from_pulses(map, model);
    ASSERT_GT(reference.statistics.median_systematic_mm, 1e-3);

    std::mt19937 rng(11);
    std::normal_distribution<double> noise;
    std::vector<double> squares(map.pulses.size(), 0.0);
    constexpr int kModels = 200;
    for (int k = 0; k < kModels; ++k) {
        Eigen::VectorXd delta(n);
        for (Eigen::Index i = 0; i < n; ++i)
            delta[i] = std::sqrt(model.covariance(i, i)) * noise(rng);
        const ScannerModel other = perturbed(model, delta);
        Eigen::Matrix3Xd from(3, static_cast<Eigen::Index>(map.pulses.size())), to = from;
        for (std::size_t i = 0; i < map.pulses.size(); ++i) {
            const Eigen::Vector2d pixel(map.pulses[i].u, map.pulses[i].v);
            const auto c = static_cast<Eigen::Index>(i);
            from.col(c) = triangulate(other.channels[0], pixel, map.pulses[i].s)->point_in_scan;
            to.col(c) = triangulate(model.channels[0], pixel, map.pulses[i].s)->point_in_scan;
        }
        const Eigen::Matrix4d motion = Eigen::umeyama(from, to, false);
        for (std::size_t i = 0; i < map.pulses.size(); ++i) {
            const auto c = static_cast<Eigen::Index>(i);
            const Vector3d error = (motion * from.col(c).homogeneous()).head<3>() - to.col(c);
            const Eigen::Vector2d pixel(map.pulses[i].u, map.pulses[i].v);
            const double along =
                error.dot(triangulate(model.channels[0], pixel, map.pulses[i].s)->ray_in_scan);
            squares[i] += along * along / kModels;
        }
    }
    double log_ratio = 0;
    std::size_t used = 0, at = 0;
    for (std::size_t i = 0; i < reference.image.cell_count(); ++i) {
        if (!reference.image.mask[i]) continue;
        const double predicted = reference.image.points[i].sigma_systematic_mm;
        log_ratio += std::log(predicted / std::sqrt(squares[at++]));
        ++used;
    }
    // 200 models scatter each variance by 10 %; the geometric mean over the scan by some
    // percent
    EXPECT_NEAR(std::exp(log_ratio / static_cast<double>(used)), 1.0, 0.1);
}

}  // namespace
}  // namespace stria
