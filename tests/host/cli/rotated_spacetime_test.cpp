#include "tests/host/cli/rotated_spacetime.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/host/cli/rotated_spacetime_trial.h"

namespace stria::test_support {
namespace {

// The closed form of case 2: along the line u = u0 + m (k - k0) the light is a Gaussian of k.
TEST(RotatedSpacetime, FindsTheCrossingsOfAnOrthographicCamera) {
    constexpr double kSlope = 0.8, kWidth = 2.5, kPlane = 40.3;
    std::vector<Frame> frames(60);
    for (std::size_t k = 0; k < frames.size(); ++k) {
        Frame& frame = frames[k];
        resize(frame, 80, 1, 16);
        for (int u = 0; u < frame.width; ++u) {
            // the point seen at u now is seen at kPlane when the sheet crosses it
            const double crossing = static_cast<double>(k) + (kPlane - u) / kSlope;
            const double d = (static_cast<double>(k) - crossing) / kWidth;
            const auto dn = static_cast<std::uint16_t>(std::lround(60000 * std::exp(-0.5 * d * d)));
            std::memcpy(&frame.bytes[2 * static_cast<std::size_t>(u)], &dn, sizeof dn);
        }
    }
    const auto means = rotated_spacetime_means(
        frames, 0, {.slope_px = kSlope, .width_frames = kWidth, .least_dn = 30000});
    std::size_t inside = 0;
    for (const SpacetimeMean& mean : means) {
        if (mean.frame < 12 || mean.frame > 47) continue;
        EXPECT_NEAR(mean.u, kPlane, 0.003);  // px: cubic convolution of a Gaussian of 2 px
        ++inside;
    }
    EXPECT_GT(inside, 20U);
}

TEST(RotatedSpacetime, ExactPathsBeatItAndSpatialPeaksOnARail) {
    expect_exact_paths_win(edge_cards(MachineKind::rail, 36, 0));
}

}  // namespace
}  // namespace stria::test_support
