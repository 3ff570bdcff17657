// Throughput of stripe analysis, Mpixel/s, beside the rate at which memory can be read at all.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "firmware/stripe/spacetime.h"
#include "firmware/stripe/spatial.h"

namespace stria {
namespace {

constexpr int kWidth = 800, kHeight = 640;
constexpr SensorNoise kNoise = {.gain_e_per_dn = 40, .read_noise_e = 60};

/// A stripe 2 px wide at `at`, slightly bent, on ambient light of 12 DN; 8 bits, seeded.
Frame stripe_frame(int k, double at) {
    Frame frame;
    resize(frame, kWidth, kHeight, 8);
    frame.sequence = static_cast<std::uint32_t>(k);
    frame.exposure_start_ns = k * kNsPerMs;
    frame.exposure_ns = kNsPerMs / 2;
    std::minstd_rand rng(static_cast<unsigned>(k + 1));
    std::normal_distribution<float> normal(0, 1.5f);
    for (int y = 0; y < kHeight; ++y) {
        const double centre = at + 20 * std::sin(y * 0.01);
        for (int x = 0; x < kWidth; ++x) {
            const double d = (x - centre) / 2.0;
            const double mean = 12 + (std::abs(d) < 6 ? 160 * std::exp(-0.5 * d * d) : 0.0);
            frame.bytes[static_cast<std::size_t>(y * kWidth + x)] = static_cast<std::uint8_t>(
                std::clamp(mean + static_cast<double>(normal(rng)) + 0.5, 0.0, 255.0));
        }
    }
    return frame;
}

std::vector<Frame> sweep(int frames) {
    std::vector<Frame> out;
    for (int k = 0; k < frames; ++k) out.push_back(stripe_frame(k, 100 + 1.0 * k));
    return out;
}

void report_pixels(benchmark::State& state, double pixels_each) {
    state.counters["Mpixel/s"] = benchmark::Counter(
        pixels_each * 1e-6 * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

void memory_read(benchmark::State& state) {
    const std::vector<Frame> frames = sweep(64);
    for (auto _ : state) {
        std::uint64_t sum = 0;
        for (const Frame& frame : frames)
            sum = std::accumulate(frame.bytes.begin(), frame.bytes.end(), sum);
        benchmark::DoNotOptimize(sum);
    }
    report_pixels(state, 64.0 * kWidth * kHeight);
}

void spatial(benchmark::State& state) {
    const Frame frame = stripe_frame(0, 300);
    const SpatialOptions options{.threads = static_cast<int>(state.range(0))};
    for (auto _ : state) benchmark::DoNotOptimize(find_peaks(frame, kNoise, options));
    report_pixels(state, 1.0 * kWidth * kHeight);
}

void spacetime(benchmark::State& state) {
    const std::vector<Frame> frames = sweep(200);
    const SpacetimeOptions options{.threads = static_cast<int>(state.range(0))};
    std::size_t pulses = 0;
    for (auto _ : state) {
        SpacetimeAnalyser analyser(kWidth, kHeight, 8, kNoise, options);
        for (const Frame& frame : frames) analyser.add(frame);
        pulses = analyser.finish().pulses.size();
    }
    report_pixels(state, 200.0 * kWidth * kHeight);
    state.counters["pulses"] = static_cast<double>(pulses);
}

/// The same without a stripe: what the quiet pixels cost.
void spacetime_quiet(benchmark::State& state) {
    std::vector<Frame> frames;
    for (int k = 0; k < 64; ++k) frames.push_back(stripe_frame(k, -1000));
    for (auto _ : state) {
        SpacetimeAnalyser analyser(kWidth, kHeight, 8, kNoise);
        for (const Frame& frame : frames) analyser.add(frame);
        benchmark::DoNotOptimize(analyser.finish());
    }
    report_pixels(state, 64.0 * kWidth * kHeight);
}

BENCHMARK(memory_read)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(spatial)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(spacetime)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(spacetime_quiet)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace stria

BENCHMARK_MAIN();
