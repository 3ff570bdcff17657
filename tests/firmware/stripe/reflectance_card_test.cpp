#include "tests/firmware/stripe/reflectance_card.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "firmware/stripe/peak_methods.h"

namespace stria::test {
namespace {

void print_heading() {
    std::printf(
        "greatest error near the edge over sigma_b; spacetime over spatial centre of gravity\n"
        "  K  sp/sb | moments: spatial spacetime  ratio | spacetime ml  ratio | spatial");
    for (const PeakMethod method : kPeakMethods) std::printf(" %s", name_of(method).data());
    std::printf("\n");
}

void print(const ReflectanceCard& card, double ratio, const CardErrors& e) {
    const double b = card.beam_width;
    std::printf("%3.0f %6.2f | %16.4f %9.4f %6.4f | %12.4f %6.4f |", card.contrast, ratio,
                e.spatial_moment / b, e.spacetime_moment / b, e.spacetime_moment / e.spatial_moment,
                e.spacetime / b, e.spacetime / e.spatial_moment);
    for (const double error : e.spatial) std::printf(" %.3f", error / b);
    std::printf("\n");
}

TEST(ReflectanceCard, SpacetimeErrsByTheFootprintInsteadOfTheBeam) {
    print_heading();
    for (const double contrast : {2.0, 5.0, 10.0}) {
        for (const double ratio : {0.05, 0.13, 0.3}) {
            ReflectanceCard card;
            card.contrast = contrast;
            card.footprint = ratio * card.beam_width;
            card.beam_step = card.beam_width / 4;
            const CardErrors e = measure(card);
            print(card, ratio, e);
            // Closed form: the same shift, in beam widths and in footprints. Frames and edges are a
            // quarter of a beam width and an eighth of a pixel apart and may miss the greatest.
            const double shift = greatest_shift(contrast);
            EXPECT_NEAR(e.spatial_moment / (shift * card.beam_width), 1.0, 0.01);
            EXPECT_NEAR(e.spacetime_moment / (shift * card.footprint), 1.0, 0.03);
            EXPECT_LE(e.spacetime_moment / e.spatial_moment, 1.15 * ratio);
            EXPECT_LE(e.spacetime / e.spatial_moment, 1.15 * ratio);
            if (ratio == 0.13) {
                EXPECT_LE(e.spacetime_moment / e.spatial_moment, 0.15);
                EXPECT_LE(e.spacetime / e.spatial_moment, 0.15);
            }
            EXPECT_EQ(e.pulses, e.pixels);
            for (const double spatial : e.spatial) EXPECT_GT(spatial, 2 * e.spacetime);
        }
    }
}

/// Mean of a pixel [0, 1] that is bright up to the edge and 1 / K beyond, from its middle.
double greatest_shift_in_box(double contrast) {
    double worst = 0;
    for (double a = 0; a <= 1; a += 0.001) {
        const double light = a + (1 - a) / contrast;
        const double moment = (a * a + (1 - a * a) / contrast) / 2;
        worst = std::max(worst, std::abs(moment / light - 0.5));
    }
    return worst;
}

/// Curless & Levoy 1995, cards up to 10:1: "up to 85 %" less deviation. Laser 0.9 mm (half width at
/// 1 / e^2) under 30 degrees, 0.25 mm of the card a pixel (accuracy reference A.1), lens sharp.
TEST(ReflectanceCard, Of1995IsFlatterBy85Percent) {
    print_heading();
    ReflectanceCard card;
    card.contrast = 10;
    card.box = 1;
    card.footprint = 0;
    card.beam_width = 0.45 / std::cos(M_PI / 6) / 0.25;
    card.beam_step = card.beam_width / 4;
    const CardErrors e = measure(card);
    print(card, 1 / std::sqrt(12.0) / card.beam_width, e);
    std::printf("moments: spatial %.3f mm, spacetime %.3f mm: %.1f %% less; spacetime ml %.1f %%\n",
                0.25 * e.spatial_moment, 0.25 * e.spacetime_moment,
                100 * (1 - e.spacetime_moment / e.spatial_moment),
                100 * (1 - e.spacetime / e.spatial_moment));
    EXPECT_NEAR(e.spacetime_moment / greatest_shift_in_box(card.contrast), 1.0, 0.03);
    EXPECT_GE(1 - e.spacetime_moment / e.spatial_moment, 0.85);
    EXPECT_GE(1 - e.spacetime / e.spatial_moment, 0.85);
}

}  // namespace
}  // namespace stria::test
