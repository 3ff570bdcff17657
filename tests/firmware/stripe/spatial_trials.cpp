#include "tests/firmware/stripe/spatial_trials.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "firmware/stripe/spatial.h"
#include "tests/firmware/stripe/localisation.h"

namespace stria::test {
namespace {

struct Condition {
    double width_px;
    double snr;
    bool shot;
    int saturation = 1;  ///< the pulse is this many times full scale high
};

/// Rows of 48 px with one stripe each at a random sub-pixel place, 12 bits.
LocalisationCell measure(const Condition& c, int trials, unsigned seed) {
    constexpr int kWidth = 48, kRows = 500;
    std::mt19937_64 rng(seed);
    std::uniform_real_distribution<double> place(20.0, 28.0);
    TruePulse truth{2000.0, 0, c.width_px, 200.0};
    const SensorNoise noise = sensor_for(truth.amplitude, c.snr, c.shot);
    std::vector<double> x(kWidth);
    for (int i = 0; i < kWidth; ++i) x[i] = i;

    LocalisationTally tally;
    Frame frame;
    resize(frame, kWidth, kRows, 12);
    std::vector<TruePulse> truths(kRows);
    const SpatialOptions options{.min_snr = 4.0, .max_peaks_per_row = 1};
    for (int done = 0; done < trials; done += kRows) {
        for (int y = 0; y < kRows; ++y) {
            truth.position = place(rng);
            truths[y] = truth;
            for (int i = 0; i < kWidth; ++i)
                set_sample(frame, i, y,
                           noisy_sample(expected_sample(truth, i, 0.5), noise, 4095, rng));
        }
        std::vector<const Pulse*> of_row(kRows, nullptr);
        const std::vector<Pulse> peaks = find_peaks(frame, noise, options);
        for (const Pulse& p : peaks) of_row[static_cast<int>(p.v)] = &p;
        for (int y = 0; y < kRows; ++y) {
            if (of_row[y] == nullptr) {
                tally.add_missing();
                continue;
            }
            tally.add(of_row[y]->u - truths[y].position, of_row[y]->sigma,
                      cramer_rao_bound(truths[y], x, 0.5, noise));
        }
    }
    return tally.cell();
}

}  // namespace

void expect_spatial_reaches_bound(int trials, const std::vector<double>& snrs) {
    std::printf("sigma_px   snr noise     bound_px  rms/bound    mean_px  sigma_ratio  found\n");
    unsigned seed = 1;
    for (const bool shot : {false, true}) {
        for (const double width : {0.6, 0.8, 1.0, 1.5, 2.0, 2.5}) {
            for (const double snr : snrs) {
                const LocalisationCell cell = measure({width, snr, shot}, trials, seed++);
                std::printf("%8.1f %5.0f %-8s %9.5f %10.4f %10.5f %12.4f %6.4f\n", width, snr,
                            shot ? "shot" : "additive", cell.bound, cell.ratio(), cell.mean,
                            cell.sigma_ratio, cell.found);
                const double sampling = 3.0 / std::sqrt(2.0 * trials);  // 3 sd of an rms
                const double limit = width < 0.8 ? 1.10 : 1.05;
                EXPECT_LE(cell.ratio(), trials >= 20000 ? limit : limit + sampling)
                    << "sigma " << width << " px, SNR " << snr << (shot ? ", shot noise" : "");
                EXPECT_GT(cell.sigma_ratio, 0.9);
                EXPECT_LT(cell.sigma_ratio, 1.1);
                EXPECT_GE(cell.found, 0.998);
            }
        }
    }
}

}  // namespace stria::test
