#include "tests/firmware/stripe/robustness_trials.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "firmware/stripe/spacetime.h"

namespace stria::test {
namespace {

constexpr double kPeriod_ns = 5e6;
constexpr int kFrames = 56, kColumns = 20, kRows = 10;
constexpr int kFullScale = 4095;
constexpr double kHeight = 1500, kExposedShare = 0.8;

struct Tallies {
    LocalisationTally all, hit;
};

/// One sweep: the frames that arrive, and the pulses that passed.
class DisturbedSweep {
  public:
    DisturbedSweep(const Disturbance& disturbance, double width_frames, const SensorNoise& noise,
                   std::mt19937_64& rng)
        : disturbance_(disturbance), noise_(noise) {
        std::uniform_real_distribution<double> place(26.0, 30.0);
        const TruePulse pulse{kHeight, 0, width_frames * kPeriod_ns,
                              100.0 + disturbance.ambient * kFullScale};
        pulses_.assign(static_cast<std::size_t>(kColumns) * kRows, pulse);
        for (TruePulse& p : pulses_) p.position = 1e9 + place(rng) * kPeriod_ns;
    }

    /// Draws the frames, shows those that arrive to the analyser and compares its pulses.
    void run(std::mt19937_64& rng, RobustnessCell& cell, Tallies& tallies) {
        SpacetimeAnalyser analyser(kColumns, kRows, 12, noise_, {.min_snr = 4.0});
        std::bernoulli_distribution drops(disturbance_.drop_probability);
        for (int k = 0; k < kFrames; ++k) {
            const Frame frame = make_frame(k, rng);
            // A loss before the first or after the last frame leaves no gap to be seen.
            if (drops(rng) && k > 0 && k + 1 < kFrames) {
                ++cell.frames_lost;
                lost_.push_back(frame.row_time(0));
                continue;
            }
            analyser.add(frame);
            arrived_.push_back(frame);
            arrived_.back().bytes.clear();  // only its times are needed
        }
        const PulseMap map = analyser.finish();
        cell.frames_reported_lost += static_cast<int>(map.frames_dropped);
        compare(map, tallies);
    }

  private:
    Frame make_frame(int k, std::mt19937_64& rng) const {
        std::uniform_real_distribution<double> jitter(-disturbance_.jitter, disturbance_.jitter);
        Frame frame;
        resize(frame, kColumns, kRows, 12);
        frame.sequence = static_cast<std::uint32_t>(k);
        frame.exposure_ns = static_cast<TimeNs>(kExposedShare * kPeriod_ns);
        frame.exposure_start_ns =
            1'000'000'000 + static_cast<TimeNs>((k + jitter(rng)) * kPeriod_ns);
        frame.row_time_ns = 7'000;
        for (int y = 0; y < kRows; ++y)
            for (int x = 0; x < kColumns; ++x) {
                const double mean =
                    expected_sample(pulse_at(x, y), static_cast<double>(frame.row_time(y)),
                                    0.5 * kExposedShare * kPeriod_ns);
                set_sample(frame, x, y, noisy_sample(mean, noise_, kFullScale, rng));
            }
        return frame;
    }

    const TruePulse& pulse_at(int x, int y) const {
        return pulses_[static_cast<std::size_t>(y) * kColumns + static_cast<std::size_t>(x)];
    }

    void compare(const PulseMap& map, Tallies& tallies) const {
        for (int y = 0; y < kRows; ++y) {
            std::vector<double> times;
            for (const Frame& frame : arrived_)
                times.push_back(static_cast<double>(frame.row_time(y)));
            for (int x = 0; x < kColumns; ++x) {
                const TruePulse& truth = pulse_at(x, y);
                const bool hit = is_hit(truth);
                const auto found = map.cell(x, y);
                if (found.empty()) {
                    tallies.all.add_missing();
                    if (hit) tallies.hit.add_missing();
                    continue;
                }
                const double bound = cramer_rao_bound(
                    truth, times, 0.5 * kExposedShare * kPeriod_ns, noise_, kFullScale - 0.5);
                const double error =
                    (static_cast<double>(found[0].t_ns) - truth.position) / kPeriod_ns;
                const double sigma = static_cast<double>(found[0].sigma) / kPeriod_ns;
                tallies.all.add(error, sigma, bound / kPeriod_ns);
                if (hit) tallies.hit.add(error, sigma, bound / kPeriod_ns);
            }
        }
    }

    bool is_hit(const TruePulse& pulse) const {
        for (const TimeNs lost_ns : lost_)
            if (std::abs(static_cast<double>(lost_ns) - pulse.position) < 2 * pulse.width)
                return true;
        return false;
    }

    Disturbance disturbance_;
    SensorNoise noise_;
    std::vector<TruePulse> pulses_;
    std::vector<Frame> arrived_;
    std::vector<TimeNs> lost_;
};

}  // namespace

RobustnessCell measure_robustness(const Disturbance& disturbance, double width_frames, double snr,
                                  int trials, unsigned seed) {
    std::mt19937_64 rng(seed);
    const SensorNoise noise = sensor_for(kHeight, snr, true);
    RobustnessCell cell;
    Tallies tallies;
    const int sweeps = std::max(2, trials / (kColumns * kRows));
    for (int i = 0; i < sweeps; ++i)
        DisturbedSweep(disturbance, width_frames, noise, rng).run(rng, cell, tallies);
    cell.found = tallies.all.cell();
    if (tallies.hit.trials() > 0) cell.hit = tallies.hit.cell();
    return cell;
}

void expect_robust(int trials) {
    const Disturbance disturbances[] = {
        {.name = "none"},
        {.name = "1 % dropped", .drop_probability = 0.01},
        {.name = "20 % jitter", .jitter = 0.2},
        {.name = "30 % ambient", .ambient = 0.3},
        {.name = "all three", .drop_probability = 0.01, .jitter = 0.2, .ambient = 0.3},
    };
    std::printf(
        "%-13s width snr   bound_fr rms/bound bias/width bias/sigma sigma_ratio  found "
        "lost reported   hit rms/bound\n",
        "");
    unsigned seed = 4001;
    for (const Disturbance& disturbance : disturbances)
        for (const double width : {0.8, 1.5, 2.5})
            for (const double snr : {20.0, 100.0}) {
                const RobustnessCell cell =
                    measure_robustness(disturbance, width, snr, trials, seed++);
                const LocalisationCell& f = cell.found;
                std::printf(
                    "%-13s %5.1f %3.0f %10.5f %9.4f %10.5f %10.4f %11.4f %6.4f %4d %8d %5d %9.4f\n",
                    disturbance.name, width, snr, f.bound, f.ratio(), f.mean / width,
                    f.mean / f.rms, f.sigma_ratio, f.found, cell.frames_lost,
                    cell.frames_reported_lost, cell.hit.trials,
                    cell.hit.trials > 0 ? cell.hit.ratio() : 0.0);
                const auto label = [&] {
                    return std::string(disturbance.name) + ", width " + std::to_string(width) +
                           " frames, SNR " + std::to_string(snr);
                };
                const double sampling = trials >= 20000 ? 0 : 3.0 / std::sqrt(2.0 * f.trials);
                EXPECT_LE(f.ratio(), 1.1 + sampling) << label();
                const double of_mean = 3 * f.rms / std::sqrt(static_cast<double>(f.trials));
                EXPECT_LT(std::abs(f.mean), 0.02 * width) << label();
                EXPECT_LT(std::abs(f.mean), 0.02 * f.rms + of_mean) << label();
                EXPECT_EQ(cell.frames_reported_lost, cell.frames_lost) << label();
                EXPECT_GE(f.found, 0.998) << label();
                EXPECT_GT(f.sigma_ratio, 0.9) << label();
                EXPECT_LT(f.sigma_ratio, 1.1) << label();
                if (disturbance.drop_probability > 0 && trials >= 20000) {
                    ASSERT_GT(cell.hit.trials, 100) << label();
                    // Few: two standard deviations of sampling are granted. At 0.8 frames a loss
                    // leaves two or three samples of a pulse, too few at SNR 20 for any estimate to
                    // come near the bound (measured 1.17 and 1.23): printed only.
                    if (width > 1 || snr > 50) {
                        EXPECT_LE(cell.hit.ratio(), 1.1 + 2 / std::sqrt(2.0 * cell.hit.trials))
                            << label();
                    }
                }
            }
}

}  // namespace stria::test
