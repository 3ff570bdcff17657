#include "tests/host/cli/rendered_profile_trial.h"

namespace stria::test_support {
namespace {

TEST(RenderedCards, WithinTheory) {
    constexpr double kPsf = 0.3;  // px
    const double footprint = kPixelMm * std::sqrt(1.0 / 12 + kPsf * kPsf);
    for (const double contrast : {2.0, 5.0, 10.0})
        for (const double ratio : {0.05, 0.13, 0.30})
            expect_card_within_theory(contrast, footprint / ratio * std::cos(M_PI / 6), kPsf);
}

TEST(RenderedCorners, ErrByTheFootprint) {
    for (const bool roof : {true, false})
        for (const double degrees : {170.0, 150.0, 120.0, 90.0})
            for (const double ratio : {0.13, 0.2})
                expect_corner_by_the_footprint(degrees, roof, ratio);
}

TEST(RenderedStrips, CurlIsFiveTimesShorter) {
    for (const double ratio : {0.13, 0.2}) expect_shorter_curl(ratio);
}

}  // namespace
}  // namespace stria::test_support
