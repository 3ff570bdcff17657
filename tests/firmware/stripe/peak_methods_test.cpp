#include "firmware/stripe/peak_methods.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "firmware/stripe/spatial.h"
#include "tests/firmware/stripe/method_trials.h"
#include "tests/firmware/stripe/row_frames.h"

namespace stria::test {
namespace {

TEST(PeakMethods, HaveTheNamesOfTheCommandLine) {
    for (const PeakMethod method : kPeakMethods)
        EXPECT_EQ(peak_method_from(name_of(method)), method);
    EXPECT_EQ(peak_method_from("fir"), PeakMethod::matched_fir);
    EXPECT_FALSE(peak_method_from(""));
    EXPECT_FALSE(peak_method_from("FIR"));
    EXPECT_FALSE(peak_method_from("gauss"));
}

TEST(PeakMethods, HaveNoMoreBiasThanPublished) {
    // Accuracy reference A.3, greatest over the phases; half a unit of the last digit given.
    struct Row {
        double width, cog, log_parabola, blais_rioux;
    };
    for (const Row& row :
         {Row{0.6, 0.00115, 0.0025, 0.0175}, Row{0.8, 0.00035, 0.00055, 0.0155},
          Row{1.5, 0.00225, 0.00005, 0.0075}, Row{2.5, 0.00455, 0.00005, 0.0055}}) {
        EXPECT_LE(noise_free_bias(PeakMethod::centre_of_gravity, row.width), row.cog);
        EXPECT_LE(noise_free_bias(PeakMethod::log_parabola, row.width), row.log_parabola);
        EXPECT_LE(noise_free_bias(PeakMethod::blais_rioux, row.width), row.blais_rioux);
    }
    for (const double width : {0.6, 0.8, 1.0, 1.5, 2.0, 2.5}) {
        EXPECT_LE(noise_free_bias(PeakMethod::maximum_likelihood, width), 0.002) << width;
        EXPECT_LE(noise_free_bias(PeakMethod::matched_fir, width), 0.002) << width;
    }
}

/// A Gaussian smoothed by itself has the width S = sqrt(2 w^2); the Taylor step from a pixel d away
/// from its top is d / (1 - d^2 / S^2), and the pixel chosen is at most half a pixel away.
TEST(PeakMethods, StegerHasTheBiasOfItsTaylorPolynomial) {
    for (const double width : {1.5, 2.0, 2.5}) {  // narrower ones the pixels under-sample
        const double s2 = 2.0 * (width * width + 1.0 / 12.0);
        const double expected = 0.5 / (1.0 - 0.25 / s2) - 0.5;
        EXPECT_NEAR(noise_free_bias(PeakMethod::steger, width), expected, 0.02 * expected) << width;
    }
}

TEST(PeakMethods, ReachWhatIsPublishedIn1000Trials) {
    expect_methods_reach_published(1000, {10, 20, 50, 200});
}

TEST(PeakMethods, SayTheirOwnSigma) { expect_honest_sigmas(1000); }

TEST(PeakMethods, PlaceTheSamePeaks) {
    const SensorNoise noise = sensor_for(150, 40, true);
    const Frame frame = frame_of(300, 60, 8, {{150, 100.3, 2, 20}, {90, 200.6, 1, 0}}, noise, 9);
    const auto reference = find_peaks(frame, noise);
    ASSERT_EQ(reference.size(), 120u);
    for (const PeakMethod method : kPeakMethods) {
        const auto peaks = find_peaks(frame, noise, {.method = method});
        ASSERT_EQ(peaks.size(), reference.size()) << name_of(method);
        for (std::size_t i = 0; i < peaks.size(); ++i) {
            EXPECT_EQ(peaks[i].v, reference[i].v);
            EXPECT_EQ(peaks[i].width, reference[i].width);
            EXPECT_EQ(peaks[i].amplitude, reference[i].amplitude);
            EXPECT_EQ(peaks[i].flags, reference[i].flags);
            EXPECT_NEAR(peaks[i].u, reference[i].u,
                        0.1 + 5 * (peaks[i].sigma + reference[i].sigma))  // px
                << name_of(method);
        }
    }
}

/// Two stripes 3.5 widths apart: without the removal of the neighbour's light a centre of gravity
/// would lie between them.
TEST(PeakMethods, RemoveTheNeighboursLight) {
    const SensorNoise noise = sensor_for(2000, 100, false);
    const TruePulse strong{2000, 40.2, 1.5, 100}, weak{1200, 40.2 + 3.5 * 1.5, 1.5, 0};
    const Frame frame = frame_of(100, 20, 12, {strong, weak}, noise, 7);
    for (const PeakMethod method : kPeakMethods) {
        const auto peaks = find_peaks(frame, noise, {.method = method});
        ASSERT_EQ(peaks.size(), 40u) << name_of(method);
        for (std::size_t i = 0; i < peaks.size(); i += 2) {
            EXPECT_NEAR(peaks[i].u, strong.position, 0.25) << name_of(method);  // px, 5 sigma
            EXPECT_NEAR(peaks[i + 1].u, weak.position, 0.4) << name_of(method);
        }
    }
}

TEST(PeakMethods, OfAnyImageAreFiniteAndInside) {
    std::mt19937_64 rng(21);
    for (int trial = 0; trial < 300; ++trial) {
        Frame frame;
        resize(frame, 40 + static_cast<int>(rng() % 90), 4, trial % 2 ? 8 : 12);
        int level = 0;
        for (int y = 0; y < frame.height; ++y) {
            for (int x = 0; x < frame.width; ++x) {
                if (trial % 3 == 0) level = rng() % 3 ? 0 : frame.full_scale();
                if (trial % 3 == 1 && rng() % 5 == 0) level = static_cast<int>(rng() % 4096);
                if (trial % 3 == 2) level += static_cast<int>(rng() % 41) - 20;
                set_sample(frame, x, y, std::clamp(level, 0, frame.full_scale()));
            }
        }
        const SensorNoise noise = {.gain_e_per_dn = trial % 3 ? 40.0 : 1e9,
                                   .read_noise_e = trial % 5 ? 10.0 : 0.0};
        const std::size_t found = find_peaks(frame, noise).size();
        for (const PeakMethod method : kPeakMethods) {
            const auto peaks = find_peaks(frame, noise, {.method = method});
            EXPECT_LE(peaks.size(), found) << name_of(method);
            for (const Pulse& p : peaks) {
                EXPECT_GE(p.u, -0.5f) << name_of(method) << " " << trial;
                EXPECT_LE(p.u, static_cast<float>(frame.width) - 0.5f) << name_of(method);
                EXPECT_GT(p.sigma, 0.0f) << name_of(method);
                EXPECT_TRUE(std::isfinite(p.sigma)) << name_of(method);
            }
        }
    }
}

/// Fourfold over-exposed: what is symmetric stays unbiased, and flagged.
TEST(PeakMethods, StayUnbiasedOnSaturatedStripes) {
    const SensorNoise noise = sensor_for(4095, 60, false);
    for (const PeakMethod method : kPeakMethods) {
        std::mt19937_64 rng(5);
        std::uniform_real_distribution<double> place(30.0, 31.0);
        double sum = 0;
        int found = 0;
        for (int trial = 0; trial < 400; ++trial) {
            const TruePulse truth{4 * 4095, place(rng), 1.5, 100};
            const auto peaks = find_peaks(frame_of(64, 1, 12, {truth}, noise, 1000 + trial), noise,
                                          {.method = method});
            if (peaks.size() != 1) continue;
            EXPECT_TRUE(peaks[0].flags & kPulseSaturated);
            sum += peaks[0].u - truth.position;
            ++found;
        }
        EXPECT_GE(found, 392) << name_of(method);
        EXPECT_LT(std::abs(sum / found), 0.03) << name_of(method);  // px; sampling: 0.01
    }
}

}  // namespace
}  // namespace stria::test
