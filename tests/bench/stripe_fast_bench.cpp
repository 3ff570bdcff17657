// Spacetime analysis of a swept stripe by the SIMD kernels, Gpixel/s of one core (CPU time), beside
// the rate of reading memory, the reference, and the usual way: OpenCV's argmax and a centre of
// gravity over the stack of frames. One pulse in every pixel of a sweep of 200 frames of 8 bits.
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "firmware/stripe/fast_kernels.h"
#include "firmware/stripe/spacetime.h"

namespace stria {
namespace {

constexpr int kWidth = 1280, kHeight = 960, kFrames = 200;
constexpr double kPeriodNs = 2e6, kAmplitude = 150, kBackground = 16, kWidthFrames = 1.5;
constexpr SensorNoise kNoise = {.gain_e_per_dn = 1e6, .read_noise_e = 3e6};  // SNR 50

/// Frame at which the stripe's middle crosses a pixel: a slightly bent line, once over the image.
double crossing(int x, int y) {
    return 18.0 + (kFrames - 38.0) * x / kWidth + 2.0 * std::sin(0.004 * y);
}

struct Sweep {
    cv::Mat stack;  ///< a frame a row: what the usual way works on
    std::vector<Frame> frames;
};

/// 20 % jitter of the frames' times; Gaussian noise; rounded.
Sweep make_sweep() {
    std::mt19937_64 rng(3);
    std::normal_distribution<float> normal(0, 1);
    std::vector<float> noise(1u << 20);
    for (float& value : noise) value = normal(rng);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2);
    Sweep sweep;
    sweep.stack.create(kFrames, kWidth * kHeight, CV_8U);
    for (int k = 0; k < kFrames; ++k) {
        Frame frame;
        resize(frame, kWidth, kHeight, 8);
        frame.sequence = static_cast<std::uint32_t>(k);
        frame.exposure_ns = static_cast<TimeNs>(0.5 * kPeriodNs);
        frame.exposure_start_ns = static_cast<TimeNs>((k + jitter(rng)) * kPeriodNs);
        const double at = static_cast<double>(frame.row_time(0)) / kPeriodNs;
        for (int y = 0; y < kHeight; ++y) {
            const std::size_t offset = rng() % (noise.size() - kWidth);
            for (int x = 0; x < kWidth; ++x) {
                const double z = (at - crossing(x, y)) / kWidthFrames;
                const double mean =
                    kBackground + (z * z < 40 ? kAmplitude * std::exp(-0.5 * z * z) : 0.0);
                const double sigma = std::sqrt(sample_variance(kNoise, mean) - 1.0 / 12.0);
                const double value =
                    mean + sigma * double{noise[offset + static_cast<std::size_t>(x)]} + 0.5;
                frame.bytes[static_cast<std::size_t>(y * kWidth + x)] =
                    static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
            }
        }
        std::memcpy(sweep.stack.ptr(k), frame.bytes.data(), frame.bytes.size());
        sweep.frames.push_back(std::move(frame));
    }
    return sweep;
}

Sweep& sweep() {
    static Sweep one = make_sweep();
    return one;
}

void report(benchmark::State& state) {
    state.counters["Gpixel/s"] = benchmark::Counter(
        1e-9 * kFrames * kWidth * kHeight * static_cast<double>(state.iterations()),
        benchmark::Counter::kIsRate);
}

void memory_read(benchmark::State& state) {
    const cv::Mat& stack = sweep().stack;
    const auto* words = reinterpret_cast<const std::uint64_t*>(stack.data);
    const std::size_t count = stack.total() / 8;
    for (auto _ : state) {
        std::uint64_t a = 0, b = 0, c = 0, d = 0;
        for (std::size_t i = 0; i + 4 <= count; i += 4) {
            a += words[i];
            b += words[i + 1];
            c += words[i + 2];
            d += words[i + 3];
        }
        benchmark::DoNotOptimize(a + b + c + d);
    }
    report(state);
}

/// Copying the frames once, as every driver does.
void memory_copy(benchmark::State& state) {
    std::vector<std::uint8_t> to(std::size_t{kWidth} * kHeight);
    for (auto _ : state) {
        for (const Frame& frame : sweep().frames) {
            std::memcpy(to.data(), frame.bytes.data(), to.size());
            benchmark::DoNotOptimize(to.data());
            benchmark::ClobberMemory();
        }
    }
    report(state);
}

/// Rms error (frames) of pulse times against the truth of the cells that have one, times are ns.
void report_error(benchmark::State& state, const PulseMap& map) {
    double squares = 0;
    std::size_t found = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            if (map.cell(x, y).empty()) continue;
            const double error =
                static_cast<double>(map.cell(x, y)[0].t_ns) / kPeriodNs - crossing(x, y);
            squares += error * error;
            ++found;
        }
    state.counters["rms_frames"] = std::sqrt(squares / static_cast<double>(found));
    state.counters["found"] = static_cast<double>(found) / (double{kWidth} * kHeight);
}

/// Puts the frames that an analyser has taken over back into the sweep.
void take_back(SpacetimeAnalyser& analyser) {
    while (std::optional<Frame> frame = analyser.take_spare()) {
        const std::uint32_t k = frame->sequence;
        sweep().frames[k] = std::move(*frame);
    }
}

void analyse(benchmark::State& state, const SpacetimeOptions& options) {
    std::vector<Frame>& frames = sweep().frames;
    PulseMap map;
    for (auto _ : state) {
        SpacetimeAnalyser analyser(kWidth, kHeight, 8, kNoise, options);
        for (Frame& frame : frames) analyser.add(std::move(frame));
        map = analyser.finish();
        state.PauseTiming();
        take_back(analyser);
        state.counters["frames"] = static_cast<double>(analyser.most_frames());
        state.counters["by_reference"] = static_cast<double>(analyser.windows().by_reference) /
                                         static_cast<double>(analyser.windows().all);
        state.ResumeTiming();
    }
    report(state);
    report_error(state, map);
}

void fast_spacetime(benchmark::State& state, const char* set, int threads) {
    fast::use_instruction_set(set);
    analyse(state,
            {.max_pulse_frames = 32, .history_frames = 12, .threads = threads, .fast = true});
    fast::use_instruction_set("");
}

void reference(benchmark::State& state) {
    analyse(state, {.max_pulse_frames = 32, .history_frames = 12});
}

void report_centroids(benchmark::State& state, const cv::Mat& place) {
    double squares = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const double error = double{place.at<float>(0, y * kWidth + x)} - crossing(x, y);
            squares += error * error;
        }
    state.counters["rms_frames"] = std::sqrt(squares / (double{kWidth} * kHeight));
}

/// Centre of gravity of the samples within 4 frames of each pixel's greatest.
void centroids(const cv::Mat& stack, const std::vector<float>& times, const int* argmax,
               float* place) {
    constexpr int kReach = 4;
    for (int i = 0; i < stack.cols; ++i) {
        const int first = std::max(argmax[i] - kReach, 0);
        const int last = std::min(argmax[i] + kReach, kFrames - 1);
        float sum = 0, moment = 0;
        for (int k = first; k <= last; ++k) {
            const float value = stack.ptr(k)[i];
            sum += value;
            moment += value * times[static_cast<std::size_t>(k)];
        }
        place[i] = moment / sum;
    }
}

std::vector<float> frame_times() {
    std::vector<float> times;
    for (const Frame& frame : sweep().frames)
        times.push_back(static_cast<float>(static_cast<double>(frame.row_time(0)) / kPeriodNs));
    return times;
}

/// cv::reduceArgMax over the stack, then the centroids.
void usual_way_reduce(benchmark::State& state) {
    const cv::Mat& stack = sweep().stack;
    const std::vector<float> times = frame_times();
    cv::Mat argmax, place(1, stack.cols, CV_32F);
    for (auto _ : state) {
        cv::reduceArgMax(stack, argmax, 0);
        centroids(stack, times, argmax.ptr<int>(), place.ptr<float>());
    }
    report(state);
    report_centroids(state, place);
}

/// The same with OpenCV's fastest primitives, frame by frame: compare, copy where greater.
void usual_way_compare(benchmark::State& state) {
    const cv::Mat& stack = sweep().stack;
    const std::vector<float> times = frame_times();
    cv::Mat argmax(1, stack.cols, CV_32S), place(1, stack.cols, CV_32F), best, mask;
    for (auto _ : state) {
        stack.row(0).copyTo(best);
        argmax.setTo(0);
        for (int k = 1; k < kFrames; ++k) {
            cv::compare(stack.row(k), best, mask, cv::CMP_GT);
            cv::max(stack.row(k), best, best);
            argmax.setTo(k, mask);
        }
        centroids(stack, times, argmax.ptr<int>(), place.ptr<float>());
    }
    report(state);
    report_centroids(state, place);
}

void add_all() {
    for (const char* set : fast::instruction_sets())
        benchmark::RegisterBenchmark((std::string("fast_spacetime/") + set).c_str(), fast_spacetime,
                                     set, 1)
            ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark("fast_spacetime/two_threads", fast_spacetime, "", 2)
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
}

BENCHMARK(memory_read)->Unit(benchmark::kMillisecond);
BENCHMARK(memory_copy)->Unit(benchmark::kMillisecond);
BENCHMARK(usual_way_reduce)->Unit(benchmark::kMillisecond);
BENCHMARK(usual_way_compare)->Unit(benchmark::kMillisecond);
BENCHMARK(reference)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace stria

int main(int argc, char** argv) {
    cv::setNumThreads(1);
    // A scanner sweeps again and again: memory of one sweep serves the next.
    mallopt(M_MMAP_MAX, 0);
    mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
    benchmark::Initialize(&argc, argv);
    stria::add_all();
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
