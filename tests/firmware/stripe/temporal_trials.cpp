#include "tests/firmware/stripe/temporal_trials.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "firmware/stripe/spacetime.h"

namespace stria::test {
namespace {

constexpr TimeNs kPeriodNs = 5'000'000;
constexpr int kFrames = 56;

Frame blank_frame(int rows, int columns, int k, const TemporalCondition& c, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> jitter(-c.jitter, c.jitter);
    Frame frame;
    resize(frame, columns, rows, c.fast ? 8 : 12);
    frame.sequence = static_cast<std::uint32_t>(k);
    frame.exposure_ns = static_cast<TimeNs>(c.exposure * static_cast<double>(kPeriodNs));
    frame.exposure_start_ns =
        1'000'000'000 + static_cast<TimeNs>((k + jitter(rng)) * static_cast<double>(kPeriodNs));
    frame.row_time_ns = 7'000;
    return frame;
}

}  // namespace

LocalisationCell measure_temporal(const TemporalCondition& c, int trials, unsigned seed) {
    constexpr int kColumns = 100;
    const int rows = trials / kColumns;
    const double period = static_cast<double>(kPeriodNs);
    std::mt19937_64 rng(seed);
    std::uniform_real_distribution<double> place(26.0, 30.0);
    const int bits = c.fast ? 8 : 12, full = (1 << bits) - 1;
    const double height = c.saturation > 0 ? c.saturation * full : c.fast ? 200 : 2000;
    TruePulse truth{height, 0, c.width_frames * period, c.fast ? 20.0 : 200.0};
    const SensorNoise noise = sensor_for(std::min(height, double(full)), c.snr, c.shot);

    std::vector<TruePulse> truths(static_cast<std::size_t>(rows) * kColumns, truth);
    for (TruePulse& t : truths) t.position = 1e9 + place(rng) * period;
    SpacetimeAnalyser analyser(kColumns, rows, bits, noise, {.min_snr = 4.0, .fast = c.fast});
    std::vector<Frame> frames;
    for (int k = 0; k < kFrames; ++k) {
        Frame frame = blank_frame(rows, kColumns, k, c, rng);
        const double h = 0.5 * static_cast<double>(frame.exposure_ns);
        for (int y = 0; y < rows; ++y) {
            for (int x = 0; x < kColumns; ++x) {
                const TruePulse& t = truths[static_cast<std::size_t>(y) * kColumns + x];
                const double mean = expected_sample(t, static_cast<double>(frame.row_time(y)), h);
                set_sample(frame, x, y, noisy_sample(mean, noise, full, rng));
            }
        }
        analyser.add(frame);
        frames.push_back(std::move(frame));
    }

    const PulseMap map = analyser.finish();
    LocalisationTally tally;
    std::vector<double> times(kFrames);
    for (int y = 0; y < rows; ++y) {
        for (int k = 0; k < kFrames; ++k) times[k] = static_cast<double>(frames[k].row_time(y));
        for (int x = 0; x < kColumns; ++x) {
            const auto cell = map.cell(x, y);
            if (cell.empty()) {
                tally.add_missing();
                continue;
            }
            const TruePulse& t = truths[static_cast<std::size_t>(y) * kColumns + x];
            const double bound =
                cramer_rao_bound(t, times, 0.5 * c.exposure * period, noise, full - 0.5);
            tally.add((static_cast<double>(cell[0].t_ns) - t.position) / period,
                      cell[0].sigma / period, bound / period);
        }
    }
    return tally.cell();
}

namespace {

struct TableLimits {
    bool fast;
    double (*greatest_ratio)(double width, double snr);
};

void expect_table(int trials, const std::vector<double>& snrs, const TableLimits& limits) {
    std::printf("sigma_fr   snr noise     bound_fr  rms/bound    mean_fr  sigma_ratio  found\n");
    unsigned seed = 1001;
    for (const bool shot : {false, true}) {
        for (const double width : {0.6, 0.8, 1.0, 1.5, 2.0, 2.5}) {
            for (const double snr : snrs) {
                const LocalisationCell cell = measure_temporal(
                    {.width_frames = width, .snr = snr, .shot = shot, .fast = limits.fast}, trials,
                    seed++);
                std::printf("%8.1f %5.0f %-8s %9.5f %10.4f %10.5f %12.4f %6.4f\n", width, snr,
                            shot ? "shot" : "additive", cell.bound, cell.ratio(), cell.mean,
                            cell.sigma_ratio, cell.found);
                const double sampling = 3.0 / std::sqrt(2.0 * trials);  // 3 sd of an rms
                const double limit = limits.greatest_ratio(width, snr);
                EXPECT_LE(cell.ratio(), trials >= 20000 ? limit : limit + sampling)
                    << "sigma " << width << " frames, SNR " << snr << (shot ? ", shot noise" : "");
                EXPECT_GT(cell.sigma_ratio, 0.9);
                EXPECT_LT(cell.sigma_ratio, 1.1);
                EXPECT_GE(cell.found, 0.998);
            }
        }
    }
}

}  // namespace

void expect_temporal_reaches_bound(int trials, const std::vector<double>& snrs) {
    expect_table(trials, snrs,
                 {false, [](double width, double) { return width < 0.8 ? 1.10 : 1.05; }});
}

void expect_fast_reaches_bound(int trials, const std::vector<double>& snrs) {
    expect_table(trials, snrs, {true, [](double width, double snr) {
                                    return width < 0.8 || snr < 20 || snr > 50 ? 1.2 : 1.10;
                                }});
}

}  // namespace stria::test
