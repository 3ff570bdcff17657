// Throughput of the spatial methods on one core, Mpixel/s, with the accuracy of each beside it: the
// whole way from frame to peaks, and the placing of a found peak alone. For comparison the rate at
// which memory can be read, and the usual way: greatest sample of a row, centre of gravity about
// it.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "firmware/stripe/peak_methods.h"
#include "firmware/stripe/spatial.h"

namespace stria {
namespace {

constexpr int kWidth = 1440, kHeight = 1080, kFrames = 16;
constexpr double kStripeWidth = 1.5, kAmplitude = 160, kNoiseDn = 3, kAmbient = 12;
constexpr SensorNoise kNoise = {.gain_e_per_dn = 1e6, .read_noise_e = kNoiseDn * 1e6};

struct Scene {
    std::vector<Frame> frames;
    std::vector<std::vector<double>> truth;  ///< of frame and row, px
};

/// Stripes with pixel integration and additive noise, SNR 53, 8 bits; a slow bend gives every
/// sub-pixel phase.
const Scene& scene() {
    static const Scene made = [] {
        Scene out;
        std::minstd_rand rng(1);
        std::normal_distribution<double> normal(0, kNoiseDn);
        for (int k = 0; k < kFrames; ++k) {
            Frame frame;
            resize(frame, kWidth, kHeight, 8);
            std::vector<double> truth;
            for (int y = 0; y < kHeight; ++y) {
                const double at = 300 + 50 * k + 40 * std::sin(y * 0.013);
                truth.push_back(at);
                for (int x = 0; x < kWidth; ++x) {
                    const double root = kStripeWidth * std::sqrt(2.0);
                    const double light =
                        kAmplitude * kStripeWidth * std::sqrt(M_PI / 2) *
                        (std::erf((x + 0.5 - at) / root) - std::erf((x - 0.5 - at) / root));
                    const double value = kAmbient + light + normal(rng);
                    frame
                        .bytes[static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x)] =
                        static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
                }
            }
            out.frames.push_back(std::move(frame));
            out.truth.push_back(std::move(truth));
        }
        return out;
    }();
    return made;
}

void report(benchmark::State& state, const std::vector<double>& errors) {
    state.counters["Mpixel/s"] =
        benchmark::Counter(1e-6 * kWidth * kHeight * static_cast<double>(state.iterations()),
                           benchmark::Counter::kIsRate);
    if (errors.empty()) return;  // nothing is located
    double sum = 0;
    for (const double e : errors) sum += e * e;
    state.counters["rms_px"] = std::sqrt(sum / static_cast<double>(errors.size()));
    state.counters["rows"] = static_cast<double>(errors.size()) / (kFrames * kHeight);
}

void memory_read(benchmark::State& state) {
    const std::vector<Frame>& frames = scene().frames;
    std::size_t k = 0;
    for (auto _ : state) {
        const auto& bytes = frames[k++ % kFrames].bytes;
        benchmark::DoNotOptimize(std::accumulate(bytes.begin(), bytes.end(), std::uint64_t{0}));
    }
    report(state, {});
}

/// The usual way: greatest sample of the row, then the centre of gravity of the `kReach` samples on
/// either side, above a fixed threshold; no background, no test of what was found, no sigma.
void usual_way_row(const std::uint8_t* row, std::optional<double>& found) {
    constexpr int kReach = 5, kThreshold = 30;
    const auto top = static_cast<int>(std::max_element(row, row + kWidth) - row);
    found.reset();
    if (row[top] < kThreshold) return;
    int sum = 0, moment = 0;
    for (int x = std::max(top - kReach, 0); x <= std::min(top + kReach, kWidth - 1); ++x) {
        sum += row[x];
        moment += (x - top) * row[x];
    }
    found = top + static_cast<double>(moment) / sum;
}

void usual_way(benchmark::State& state) {
    std::vector<std::optional<double>> found(kHeight);
    std::size_t k = 0;
    for (auto _ : state) {
        const Frame& frame = scene().frames[k++ % kFrames];
        for (int y = 0; y < kHeight; ++y)
            usual_way_row(frame.view8().row(y), found[static_cast<std::size_t>(y)]);
        benchmark::DoNotOptimize(found.data());
    }
    std::vector<double> errors;
    for (std::size_t f = 0; f < kFrames; ++f) {
        for (int y = 0; y < kHeight; ++y) {
            std::optional<double> at;
            usual_way_row(scene().frames[f].view8().row(y), at);
            if (at) errors.push_back(*at - scene().truth[f][static_cast<std::size_t>(y)]);
        }
    }
    report(state, errors);
}

/// From frame to peaks, one thread.
void whole(benchmark::State& state, PeakMethod method) {
    const SpatialOptions options{.max_peaks_per_row = 1, .method = method};
    std::size_t k = 0;
    for (auto _ : state)
        benchmark::DoNotOptimize(find_peaks(scene().frames[k++ % kFrames], kNoise, options));
    std::vector<double> errors;
    for (std::size_t f = 0; f < kFrames; ++f)
        for (const Pulse& p : find_peaks(scene().frames[f], kNoise, options))
            errors.push_back(p.u - scene().truth[f][static_cast<std::size_t>(p.v)]);
    report(state, errors);
}

/// Placing the peaks of a frame that are already found; the rate is that of rows of 1440 px.
void place_only(benchmark::State& state, PeakMethod method) {
    const Frame& frame = scene().frames[0];
    std::vector<float> rows(frame.bytes.begin(), frame.bytes.end());
    std::vector<GaussianFit> fits;
    for (const Pulse& p : find_peaks(frame, kNoise, {.max_peaks_per_row = 1})) {
        GaussianFit fit;
        fit.position[0] = static_cast<double>(p.u);
        fit.amplitude[0] = static_cast<double>(p.amplitude);
        fit.width = static_cast<double>(p.width);
        fit.background = static_cast<double>(p.background);
        fit.degrees_of_freedom = 1;
        fits.push_back(fit);
    }
    for (auto _ : state) {
        for (std::size_t y = 0; y < fits.size(); ++y)
            benchmark::DoNotOptimize(
                place_peak(method, {&rows[y * kWidth], kWidth}, kNoise, 255, fits[y], 0));
    }
    report(state, {});
    state.counters["time/peak"] = benchmark::Counter(
        static_cast<double>(fits.size()) * static_cast<double>(state.iterations()),
        benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void register_all() {
    const auto add = [](const std::string& name, auto function, auto... arguments) {
        benchmark::RegisterBenchmark(name.c_str(), function, arguments...)
            ->Unit(benchmark::kMillisecond);
    };
    add("memory_read", memory_read);
    add("usual_way", usual_way);
    for (const PeakMethod method : kPeakMethods)
        add("frame_to_peaks/" + std::string(name_of(method)), whole, method);
    for (const PeakMethod method : kPeakMethods)
        if (method != PeakMethod::maximum_likelihood)
            add("place_only/" + std::string(name_of(method)), place_only, method);
}

}  // namespace
}  // namespace stria

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    stria::register_all();
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
