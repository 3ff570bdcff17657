#include "tests/firmware/stripe/spatial_trials.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "firmware/stripe/spatial.h"
#include "tests/firmware/stripe/localisation.h"

namespace stria::test {
namespace {

constexpr int kWidth = 48, kRows = 500;

void tally_peaks(const std::vector<Pulse>& peaks, const std::vector<double>& references,
                 const std::vector<double>& bounds, LocalisationTally& tally) {
    std::vector<const Pulse*> of_row(references.size(), nullptr);
    for (const Pulse& p : peaks) of_row[static_cast<std::size_t>(p.v)] = &p;
    for (std::size_t y = 0; y < references.size(); ++y) {
        if (of_row[y] == nullptr)
            tally.add_missing();
        else
            tally.add(of_row[y]->u - references[y], of_row[y]->sigma, bounds[y]);
    }
}

/// Where the method puts the same stripes without noise, 16 bits.
std::vector<double> noise_free_answers(std::vector<TruePulse> truths, SpatialOptions options) {
    constexpr SensorNoise kSilent = {.gain_e_per_dn = 1e9, .read_noise_e = 0};
    constexpr double kBrighter = 20.0;
    Frame frame;
    resize(frame, kWidth, kRows, 16);
    std::mt19937_64 rng(1);
    std::vector<double> answers;
    for (int y = 0; y < kRows; ++y) {
        TruePulse& truth = truths[static_cast<std::size_t>(y)];
        truth.amplitude *= kBrighter;
        answers.push_back(truth.position);
        for (int i = 0; i < kWidth; ++i)
            set_sample(frame, i, y,
                       noisy_sample(expected_sample(truth, i, 0.5), kSilent, 65535, rng));
    }
    for (const Pulse& p : find_peaks(frame, kSilent, options))
        answers[static_cast<std::size_t>(p.v)] = p.u;
    return answers;
}

}  // namespace

std::vector<LocalisationCell> measure_spatial(const SpatialCondition& c,
                                              std::span<const PeakMethod> methods, int trials,
                                              unsigned seed, ErrorFrom from) {
    std::mt19937_64 rng(seed);
    std::uniform_real_distribution<double> place(20.0, 28.0);
    TruePulse truth{2000.0, 0, c.width_px, 200.0};
    const SensorNoise noise = sensor_for(truth.amplitude, c.snr, c.shot);
    std::vector<double> x(kWidth);
    for (int i = 0; i < kWidth; ++i) x[i] = i;

    std::vector<LocalisationTally> tallies(methods.size());
    Frame frame;
    resize(frame, kWidth, kRows, 12);
    std::vector<TruePulse> truths(kRows);
    std::vector<double> references(kRows), bounds(kRows);
    SpatialOptions options{.min_snr = 4.0, .max_peaks_per_row = 1};
    for (int done = 0; done < trials; done += kRows) {
        for (int y = 0; y < kRows; ++y) {
            truth.position = place(rng);
            truths[y] = truth;
            references[y] = truth.position;
            bounds[y] = cramer_rao_bound(truth, x, 0.5, noise);
            for (int i = 0; i < kWidth; ++i)
                set_sample(frame, i, y,
                           noisy_sample(expected_sample(truth, i, 0.5), noise, 4095, rng));
        }
        for (std::size_t m = 0; m < methods.size(); ++m) {
            options.method = methods[m];
            if (from == ErrorFrom::noise_free_answer)
                references = noise_free_answers(truths, options);
            tally_peaks(find_peaks(frame, noise, options), references, bounds, tallies[m]);
        }
    }
    std::vector<LocalisationCell> cells;
    for (LocalisationTally& tally : tallies) cells.push_back(tally.cell());
    return cells;
}

void expect_spatial_reaches_bound(int trials, const std::vector<double>& snrs) {
    std::printf("sigma_px   snr noise     bound_px  rms/bound    mean_px  sigma_ratio  found\n");
    unsigned seed = 1;
    for (const bool shot : {false, true}) {
        for (const double width : {0.6, 0.8, 1.0, 1.5, 2.0, 2.5}) {
            for (const double snr : snrs) {
                const LocalisationCell cell =
                    measure_spatial({width, snr, shot}, {kPeakMethods.data(), 1}, trials, seed++)
                        .front();
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
