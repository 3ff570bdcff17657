#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/host/cli/rendered_profile.h"

namespace stria::test_support {

/// Theory: greatest spacetime error over greatest spatial centre-of-gravity error is
/// sigma_p / sigma_b. accuracy.md A.1, finding 6.
inline void expect_card_within_theory(double contrast, double beam_mm, double psf_sigma_px) {
    const RenderedProfile card = rendered_card(contrast, beam_mm, psf_sigma_px);
    const LocatedProfile at = located(card);
    ASSERT_GT(at.greatest_dn, 5000);
    ASSERT_LT(at.greatest_dn, 65535);
    const double within = 3.5 * card.beam_mm, ratio = card.footprint_mm / card.beam_mm;
    const double spatial = greatest_error(card, at.row_moments, within);
    const double peaks = greatest_error(card, at.peaks, within);
    const double moments = greatest_error(card, at.pixel_moments, within);
    const double pulses = greatest_error(card, at.pulses, within);
    const double centred = greatest_error(card, at.centred, within);
    std::printf(
        "%4.0f:1 %6.3f | spatial %.3f mm (peaks %.3f) | moments %.4f, ml %.4f, centred %.4f mm | "
        "over spatial %.3f, %.3f, %.3f | %.1f, %.1f %% less\n",
        contrast, ratio, spatial * card.beam_mm, peaks * card.beam_mm, moments * card.beam_mm,
        pulses * card.beam_mm, centred * card.beam_mm, moments / spatial, pulses / spatial,
        centred / spatial, 100 * (1 - pulses / spatial), 100 * (1 - centred / spatial));
    EXPECT_LE(moments / spatial, 1.15 * ratio);
    EXPECT_LE(pulses / spatial, 1.15 * ratio);
    EXPECT_LE(centred, 0.6 * pulses);
    if (ratio < 0.1305) {
        EXPECT_LE(pulses, 0.15 * spatial);
        EXPECT_LE(centred, 0.1 * spatial);
    }
}

/// The row's centre of gravity at the tip of a corner: 2 slope sigma_b sqrt(2 / pi) in height.
inline double tip_error(double degrees) {
    return 2 / std::tan(degrees * M_PI / 360) * std::sqrt(2 / M_PI);
}

inline void expect_corner_by_the_footprint(double degrees, bool roof, double ratio) {
    const RenderedProfile corner = rendered_corner(degrees, roof, ratio);
    const LocatedProfile at = located(corner);
    ASSERT_GT(at.greatest_dn, 5000);
    ASSERT_LT(at.greatest_dn, 65535);
    const double within = 2 * corner.beam_mm;
    const double spatial = greatest_error(corner, at.row_moments, within);
    const double peaks = greatest_error(corner, at.peaks, within);
    const double pulses = greatest_error(corner, at.pulses, within);
    const double centred = greatest_error(corner, at.centred, within);
    std::printf(
        "%-6s %3.0f %5.2f | rows %.3f (theory %.3f), peaks %.3f | ml %.3f, centred %.3f | %.0f %% "
        "less\n",
        roof ? "roof" : "valley", degrees, ratio, spatial, tip_error(degrees), peaks, pulses,
        centred, 100 * (1 - pulses / peaks));
    // Beam and lines of sight are not parallel over the stripe, and frames 0.25 apart pass the tip.
    EXPECT_NEAR(spatial, tip_error(degrees), 0.012 + 0.03 * spatial);
    EXPECT_LE(pulses, 0.4 * peaks);  // asked for at 120 degrees: 60 % less
    EXPECT_LE(pulses, 1.15 * ratio * tip_error(degrees) + 0.01);  // and no outlier at all
}

inline void expect_shorter_curl(double ratio) {
    const RenderedProfile strip = rendered_strip(ratio);
    const LocatedProfile at = located(strip, 2);
    ASSERT_GT(at.greatest_dn, 5000);
    ASSERT_LT(at.greatest_dn, 65535);
    const Curl spatial = curl_of(strip, at.peaks, strip.pitch_mm);
    const Curl spacetime = curl_of(strip, at.pulses, kPixelMm / std::cos(M_PI / 6));
    const Curl centred = curl_of(strip, at.centred, kPixelMm / std::cos(M_PI / 6));
    std::printf(
        "strip %5.2f | curl over sigma_b: peaks %.2f (%.2f), ml %.2f (%.2f): %.1f times, centred "
        "%.2f (%.2f)\n",
        ratio, spatial.length, spatial.worst, spacetime.length, spacetime.worst,
        spatial.length / spacetime.length, centred.length, centred.worst);
    EXPECT_LE(5 * spacetime.length, spatial.length);
}

}  // namespace stria::test_support
