#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "tests/sim/speckle_trials.h"

// The tables of tests/bench/README.md: what coherent speckle does to a stripe's place. Errors are
// transverse to the line of sight, over the Dorsch limit C lambda / (2 pi sin u).
namespace stria {
namespace {

constexpr double kWavelengthMm = 650e-6, kSinU = 0.005, kRhoMm = kWavelengthMm / (2 * kSinU);

SpeckleTrials trials_of(double pixel_rhos, double sigma_mm, int rows, int pixels) {
    SpeckleTrials trials{.view = {.wavelength_nm = kWavelengthMm * 1e6,
                                  .sin_u = kSinU,
                                  .pixel_mm = pixel_rhos * kRhoMm,
                                  .rows = rows},
                         .line = {.sigma_mm = sigma_mm},
                         .seed = 11};
    const double columns = (20 * sigma_mm / kRhoMm + 24) / pixel_rhos;  // run() takes as many
    trials.surfaces = 1 + static_cast<int>(pixels / (columns * rows));
    return trials;
}

void print(const char* name, const SpeckleResult& r, double unit_mm) {
    std::printf("%-22s %6d %6.3f %6.3f | %5.2f %5.2f | %5.2f %5.2f | %5.2f %5.2f | %5.2f %5.2f\n",
                name, r.pixels, r.contrast, r.claimed, r.spacetime.weighted_mm / unit_mm,
                r.spacetime.unweighted_mm / unit_mm, r.centred.weighted_mm / unit_mm,
                r.centred.unweighted_mm / unit_mm, r.moments.weighted_mm / unit_mm,
                r.moments.unweighted_mm / unit_mm, r.spatial.weighted_mm / unit_mm,
                r.spatial.unweighted_mm / unit_mm);
    std::fflush(stdout);
}

void print_head() {
    std::printf("%-22s %6s %6s %6s | %-11s | %-11s | %-11s | %-11s\n", "edge, pixel, sigma_b",
                "pixels", "C", "found", "max. likel.", "centred", "moments", "spatial");
    std::printf("%-22s %20s | by l., even | by l., even | by l., even | by l., even\n", "", "");
}

TEST(SpeckleTable, TheCrossSectionModelOverTheDorschLimit) {
    print_head();
    for (const double sigma : {0.5, 1.0, 2.0, 4.0, 8.0}) {
        SpeckleTrials trials = trials_of(1.5, sigma * kRhoMm, 64, 24000);
        trials.view.cross_section = true;
        const SpeckleResult result = run(trials);
        char name[64];
        std::snprintf(name, sizeof name, "section, 1.5 rho, %.1f rho", sigma);
        print(name, result, result.dorsch_mm);
        if (sigma >= 1) {
            EXPECT_LT(result.centred.weighted_mm, 0.97 * result.spacetime.weighted_mm);
        }
        if (sigma >= 2) {
            ASSERT_FALSE(result.footprint_rhos.empty());
        }
        for (const double footprint : result.footprint_rhos)
            EXPECT_NEAR(footprint, kFootprintRhos,
                        0.03);  // a surface of 4000 pixels scatters 0.013
    }
}

TEST(SpeckleTable, FrozenSpeckleOverTheDorschLimit) {
    print_head();
    for (const double soft : {0.0, 0.25, 0.5})
        for (const double sigma : {0.5, 1.0, 2.0, 4.0, 8.0}) {
            SpeckleTrials trials = trials_of(1.5, sigma * kRhoMm, 16, 12000);
            trials.view.soft_edge = soft;
            const SpeckleResult result = run(trials);
            char name[64];
            std::snprintf(name, sizeof name, "%.2f, 1.5 rho, %.1f rho", soft, sigma);
            print(name, result, result.dorsch_mm);
            const RowSpeckle row = row_speckle(kRhoMm, trials.view.pixel_mm);
            const double spatial_mm =
                0.37556 * row.contrast * std::sqrt(row.length_mm * trials.line.sigma_mm);
            if (soft == 0 && sigma >= 1) {
                EXPECT_NEAR(result.spatial.weighted_mm, spatial_mm, 0.1 * spatial_mm) << sigma;
            }
            if (sigma >= 2) {
                EXPECT_LT(result.spacetime.weighted_mm, result.spatial.weighted_mm) << sigma;
            }
            EXPECT_GT(result.claimed, 0.99);
        }
}

TEST(SpeckleTable, APointAgainstTheClosedForm) {
    std::printf("sigma_b / rho: first moment weighted by the light's square, over rho / pi\n");
    for (const double sigma : {0.5, 1.0, 2.0, 4.0, 8.0}) {
        const SpeckleResult result = run(trials_of(0.25, sigma * kRhoMm, 64, 60000));
        const double theory_mm = kRhoMm * point_moment_by_square(sigma);
        print("point", result, result.dorsch_mm);
        std::printf("%4.1f: %.3f, theory %.3f\n", sigma,
                    result.moments_by_square_mm * std::numbers::pi / kRhoMm,
                    theory_mm * std::numbers::pi / kRhoMm);
        EXPECT_NEAR(result.moments_by_square_mm, theory_mm, 0.1 * theory_mm)  // chance: 4 %
            << sigma;
    }
}

// Where along the beam the waist should lie when a mirror turns it: accuracy.md finding 5.
TEST(SpeckleTable, WaistAtTheMirrorAgainstFocusAtTheTarget) {
    struct Case {
        double distance_mm, waist_mm;
    };
    std::printf(
        "D mm, waist um, sigma_b um: frozen, waist at mirror, focus at target | spatial; um\n");
    for (const auto& [distance_mm, waist_mm] :
         {Case{150, 0.1}, Case{200, 0.1}, Case{300, 0.1}, Case{400, 0.1}, Case{500, 0.1},
          Case{150, 0.07}, Case{200, 0.07}}) {
        const double rayleigh_mm = 4 * std::numbers::pi * waist_mm * waist_mm / kWavelengthMm;
        const double ratio = distance_mm / rayleigh_mm;
        const double sigma_mm = waist_mm * std::hypot(1.0, ratio);
        SpeckleTrials trials = trials_of(1.5, sigma_mm, 16, 12000);
        const SpeckleResult frozen = run(trials);
        trials.line.turning_mm = distance_mm;
        const SpeckleResult focused = run(trials);
        trials.line.wavefront_mm = distance_mm * (1 + 1 / (ratio * ratio));
        const SpeckleResult waisted = run(trials);
        const double kept = (frozen.spatial.weighted_mm - waisted.spacetime.weighted_mm) /
                            (frozen.spatial.weighted_mm - frozen.spacetime.weighted_mm);
        std::printf(
            "%3.0f, %3.0f, %3.0f: %5.1f, %5.1f, %5.1f | %5.1f (C %.2f, Dorsch %.1f) kept %.2f\n",
            distance_mm, waist_mm * 1e3, sigma_mm * 1e3, frozen.spacetime.weighted_mm * 1e3,
            waisted.spacetime.weighted_mm * 1e3, focused.spacetime.weighted_mm * 1e3,
            frozen.spatial.weighted_mm * 1e3, frozen.contrast, frozen.dorsch_mm * 1e3, kept);
        std::fflush(stdout);
        EXPECT_LT(waisted.spacetime.weighted_mm, focused.spacetime.weighted_mm);
        if (distance_mm > 1.5 * rayleigh_mm) {
            EXPECT_GT(kept, 0.8);  // nearer the wavefront's centre is not yet the mirror
        }
    }
}

}  // namespace
}  // namespace stria
