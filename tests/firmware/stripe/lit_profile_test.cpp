#include "tests/firmware/stripe/lit_profile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace stria::test {
namespace {

/// Greatest vertical distance from the corner within two beam widths of its tip, over sigma_b.
double greatest_error(const LitProfile& p, const std::vector<ProfilePoint>& points) {
    double worst = 0;
    for (const ProfilePoint& at : points) {
        if (std::abs(at.x) > 2 * p.beam_width) continue;
        const ProfileSegment& side = p.segments[at.x < 0 ? 0 : 1];
        worst = std::max(worst, std::abs(at.z - side.height_at(at.x)));
    }
    return worst / p.beam_width;
}

/// The sheet through the tip of a corner paints both sides alike, one side longer in the image than
/// the other: their lengths per x are cos(angle) +- slope sin(angle), so that the row's centre of
/// gravity is off by 2 slope sigma_b sqrt(2 / pi) in height, whatever the angle of the camera.
double tip_error(double degrees) {
    return 2 / std::tan(degrees * M_PI / 360) * std::sqrt(2 / M_PI);
}

TEST(Corner, SpacetimeErrsByTheFootprintInsteadOfTheBeam) {
    std::printf(
        "greatest height error over sigma_b, theta 30 deg\n"
        "corner       sp/sb | moments: spatial spacetime  less | cog peaks spacetime ml  less\n");
    for (const bool roof : {true, false}) {
        for (const double degrees : {170.0, 150.0, 120.0, 90.0}) {
            for (const double ratio : {0.05, 0.13, 0.2}) {
                const LitProfile p = corner_profile(degrees, roof, ratio);
                const ProfileSweep sweep(p);
                const double spatial = greatest_error(p, sweep.spatial_moments());
                const double spacetime = greatest_error(p, sweep.spacetime_moments());
                const double peaks = greatest_error(p, sweep.spatial_peaks(1));
                const double pulses = greatest_error(p, sweep.spacetime_pulses());
                std::printf("%-6s %3.0f %6.2f | %16.3f %9.3f %4.0f%% | %9.3f %12.3f %4.0f%%\n",
                            roof ? "roof" : "valley", degrees, ratio, spatial, spacetime,
                            100 * (1 - spacetime / spatial), peaks, pulses,
                            100 * (1 - pulses / peaks));
                EXPECT_NEAR(spatial, tip_error(degrees), 0.01 * spatial);  // pixels sum the light
                EXPECT_LE(spacetime, 0.4 * spatial);  // asked for at 120 degrees: 60 % less
                EXPECT_LE(pulses, 0.4 * peaks);
                EXPECT_LE(pulses, 1.15 * ratio * tip_error(degrees));  // and no outlier at all
            }
        }
    }
}

struct Curl {
    double length = 0;  ///< of the sweep (of the image) with a point more than 0.1 sigma_b off
    double worst = 0;   ///< distance from the surface
    int on_strip = 0;   ///< points on the inner part of the strip
};

/// In beam widths, mean of the rows. @param pitch  distance of the points along x
Curl curl_of(const LitProfile& p, const std::vector<ProfilePoint>& points, double pitch) {
    Curl curl;
    for (const ProfilePoint& at : points) {
        const double off = p.distance(at.x, at.z) / p.beam_width;
        if (off > 0.1) curl.length += pitch / p.beam_width / LitProfile::kRows;
        curl.worst = std::max(curl.worst, off);
        curl.on_strip += std::abs(at.x) < 0.9 * p.segments[0].x1 && std::abs(at.z) < p.beam_width;
    }
    return curl;
}

/// Four edges: two of the strip, two of its shadow.
TEST(EdgeCurl, IsFiveTimesShorterInSpacetime) {
    std::printf("sp/sb | curl over sigma_b (greatest distance): cog peaks, spacetime ml\n");
    for (const double ratio : {0.05, 0.13, 0.2}) {
        const LitProfile p = strip_profile(ratio);
        const ProfileSweep sweep(p);
        const double pixel = 1 / std::cos(p.angle);
        const Curl spatial = curl_of(p, sweep.spatial_peaks(2), p.beam_step);
        const Curl spacetime = curl_of(p, sweep.spacetime_pulses(), pixel);
        std::printf("%5.2f | %6.2f (%.2f) %6.2f (%.2f): %.1f times shorter\n", ratio,
                    spatial.length, spatial.worst, spacetime.length, spacetime.worst,
                    spatial.length / spacetime.length);
        EXPECT_LE(5 * spacetime.length, spatial.length);
        EXPECT_LE(spacetime.worst, 5 * ratio);  // of the footprint, where its light fades
        const double pixels = 2 * 0.9 * p.segments[0].x1 / pixel * LitProfile::kRows;
        EXPECT_NEAR(spacetime.on_strip, pixels, LitProfile::kRows);  // one a pixel, one more a row
    }
}

}  // namespace
}  // namespace stria::test
