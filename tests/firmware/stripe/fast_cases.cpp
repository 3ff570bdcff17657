#include "tests/firmware/stripe/fast_cases.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stria::test {
namespace {

constexpr double kPeriodNs = 4e6;

std::vector<TruePulse> pulses_of_pixel(const FastCase& of, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> place(12.0, of.frames - 12.0), share(0.0, 1.0);
    TruePulse pulse{of.height_dn, place(rng), of.width_frames, 0};
    if (share(rng) > of.odd_pixels) return {pulse};
    switch (static_cast<int>(share(rng) * 6.0)) {
        case 0:
            return {};
        case 1:
            pulse.amplitude = 400;
            return {pulse};
        case 2:
            pulse.amplitude = 6.0 * of.height_dn / of.snr * share(rng) * 2.0;
            return {pulse};
        case 3:
            pulse.width *= 1.0 + 4.0 * share(rng);
            return {pulse};
        case 4:
            pulse.position = of.frames * share(rng);
            return {pulse};
        default: {
            TruePulse other = pulse;
            other.position += of.width_frames * 6.0 * share(rng);
            other.amplitude *= share(rng);
            return {pulse, other};
        }
    }
}

}  // namespace

FastSweep make_sweep(const FastCase& of) {
    FastSweep sweep;
    sweep.noise = sensor_for(of.height_dn, of.snr, true);
    std::mt19937_64 rng(of.seed);
    std::uniform_real_distribution<double> jitter(-of.jitter, of.jitter);
    std::vector<std::vector<TruePulse>> pulses;
    for (int i = 0; i < of.width * of.height; ++i) pulses.push_back(pulses_of_pixel(of, rng));
    for (int k = 0; k < of.frames; ++k) {
        Frame frame;
        resize(frame, of.width, of.height, 8);
        frame.sequence = static_cast<std::uint32_t>(k);
        frame.laser_id = 1;
        frame.exposure_ns = static_cast<TimeNs>(of.exposure * kPeriodNs);
        frame.exposure_start_ns = static_cast<TimeNs>((100 + k + jitter(rng)) * kPeriodNs);
        frame.row_time_ns = 9'000;
        const double middle = static_cast<double>(frame.row_time(0)) / kPeriodNs - 100;
        for (int y = 0; y < of.height; ++y)
            for (int x = 0; x < of.width; ++x) {
                double mean = of.background_dn;
                for (const TruePulse& p : pulses[static_cast<std::size_t>(y * of.width + x)])
                    mean += expected_sample(p, middle, 0.5 * of.exposure);
                set_sample(frame, x, y, noisy_sample(mean, sweep.noise, 255, rng));
            }
        sweep.frames.push_back(std::move(frame));
    }
    return sweep;
}

Analysed analyse(const FastSweep& sweep, const SpacetimeOptions& options) {
    const Frame& first = sweep.frames.front();
    SpacetimeAnalyser analyser(first.width, first.height, first.bits, sweep.noise, options);
    for (const Frame& frame : sweep.frames) analyser.add(frame);
    Analysed out;
    out.map = analyser.finish();
    out.sampling = analyser.sampling();
    out.windows = analyser.windows();
    out.most_frames = analyser.most_frames();
    return out;
}

Differences compare(const PulseMap& reference, const PulseMap& fast, const SensorNoise& noise,
                    double period_ns) {
    Differences out;
    const auto raise = [](double& greatest, double value) {
        if (!(value <= greatest)) greatest = value;
    };
    for (int y = 0; y < reference.height; ++y) {
        for (int x = 0; x < reference.width; ++x) {
            const auto a = reference.cell(x, y), b = fast.cell(x, y);
            if (a.size() != b.size()) {
                ++out.cells;
                out.worst = "count at " + std::to_string(x) + ", " + std::to_string(y);
                continue;
            }
            for (std::size_t i = 0; i < a.size(); ++i) {
                ++out.pulses;
                const double dt = std::abs(static_cast<double>(a[i].t_ns - b[i].t_ns));
                const double peak =
                    std::sqrt(sample_variance(noise, a[i].background + a[i].amplitude));
                const double base = std::sqrt(sample_variance(noise, a[i].background));
                if (dt / a[i].sigma > out.time_sigmas)
                    out.worst = "time at " + std::to_string(x) + ", " + std::to_string(y);
                raise(out.time_sigmas, dt / a[i].sigma);
                raise(out.time_frames, dt / period_ns);
                raise(out.width, std::abs(b[i].width / a[i].width - 1.0));
                raise(out.sigma, std::abs(b[i].sigma / a[i].sigma - 1.0));
                raise(out.amplitude_sigmas, std::abs(a[i].amplitude - b[i].amplitude) / peak);
                raise(out.background_sigmas, std::abs(a[i].background - b[i].background) / base);
                raise(out.chi_square, std::abs(a[i].chi_square - b[i].chi_square) /
                                          std::max(a[i].chi_square, 1.0f));
                out.flags += a[i].flags != b[i].flags || a[i].laser_id != b[i].laser_id ||
                             a[i].exposure_index != b[i].exposure_index;
            }
        }
    }
    return out;
}

void expect_equal(const Differences& found) {
    EXPECT_EQ(found.cells, 0u) << found.worst;
    EXPECT_EQ(found.flags, 0u);
    EXPECT_LE(found.time_sigmas, 0.1) << found.worst;
    EXPECT_LE(found.sigma, 0.05);
    EXPECT_LE(found.amplitude_sigmas, 0.2);
    EXPECT_LE(found.background_sigmas, 0.1);
    EXPECT_LE(found.chi_square, 0.02);
}

}  // namespace stria::test
