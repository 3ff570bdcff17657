// A sweep of 8-bit frames: options, noise and times from the first bytes, samples from the others.
// The fast analysis must find what the reference finds, within the bounds of fast_spacetime.h, and
// the same bytes on every instruction set.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "firmware/stripe/fast_kernels.h"
#include "firmware/stripe/spacetime.h"

namespace stria {
namespace {

/// Reads numbers off the input; zeros behind its end.
class Bytes {
  public:
    Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
    int next() { return at_ < size_ ? data_[at_++] : 0; }
    /// Evenly in [low, high].
    double within(double low, double high) { return low + (high - low) * next() / 255.0; }
    bool empty() const { return at_ >= size_; }

  private:
    const std::uint8_t* data_;
    std::size_t size_, at_ = 0;
};

struct Sweep {
    SpacetimeOptions options;
    SensorNoise noise;
    std::vector<Frame> frames;
    double period_ns = 1e6;
};

/// A pixel's samples: pulses over a background, and what the input says of each sample.
void paint(Sweep& sweep, int x, int y, Bytes& bytes) {
    const double background = bytes.within(0, 120);
    const double height = bytes.within(0, 300), width = bytes.within(0.3, 8);
    const double place = bytes.within(0, static_cast<double>(sweep.frames.size()));
    const double second = bytes.within(0, 1), apart = bytes.within(0, 20);
    const double rough = bytes.within(0, 12);
    std::uint32_t state = static_cast<std::uint32_t>(bytes.next()) * 2654435761u + 12345u;
    for (Frame& frame : sweep.frames) {
        const double t = static_cast<double>(frame.row_time(0)) / sweep.period_ns - 100.0;
        const double a = (t - place) / width, b = (t - place - apart) / width;
        double noise = 0;
        for (int i = 0; i < 4; ++i) {
            state = state * 1664525u + 1013904223u;
            noise += (state >> 8) / 16777216.0 - 0.5;
        }
        const double value = background + height * std::exp(-0.5 * a * a) +
                             second * height * std::exp(-0.5 * b * b) + rough * 1.73 * noise;
        frame.bytes[static_cast<std::size_t>(y * frame.width + x)] =
            static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
    }
}

Sweep make_sweep(Bytes& bytes) {
    Sweep sweep;
    sweep.options.min_snr = bytes.within(3, 12);
    sweep.options.min_amplitude_dn = bytes.within(0, 8);
    sweep.options.max_pulses_per_cell = 1 + bytes.next() % 4;
    sweep.options.max_pulse_frames = 4 + bytes.next() % 100;
    sweep.options.history_frames = 4 + bytes.next() % 30;
    sweep.options.max_misfit = bytes.within(0.05, 0.5);
    sweep.noise = {bytes.within(1, 200), 0, bytes.within(0, 20)};
    sweep.noise.read_noise_e = bytes.within(0, 12) * sweep.noise.gain_e_per_dn;
    const int width = 1 + bytes.next() % 70, height = 1 + bytes.next() % 3;
    const int count = 1 + bytes.next() % 120;
    const double jitter = bytes.within(0, 0.45), exposure = bytes.within(0.001, 1.0);
    std::uint32_t state = static_cast<std::uint32_t>(bytes.next()) + 77u;
    for (int k = 0; k < count; ++k) {
        Frame frame;
        resize(frame, width, height, 8);
        state = state * 1664525u + 1013904223u;
        const double early = jitter * ((state >> 8) / 8388608.0 - 1.0);
        frame.sequence = static_cast<std::uint32_t>(k);
        frame.exposure_ns = static_cast<TimeNs>(exposure * sweep.period_ns);
        frame.exposure_start_ns = static_cast<TimeNs>((100 + k + early) * sweep.period_ns);
        frame.row_time_ns = 1000;
        sweep.frames.push_back(std::move(frame));
    }
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) paint(sweep, x, y, bytes);
    for (std::size_t i = 0; !bytes.empty(); ++i) {  // single samples as the input has them
        Frame& frame = sweep.frames[static_cast<std::size_t>(bytes.next()) % sweep.frames.size()];
        frame.bytes[(i * 7 + static_cast<std::size_t>(bytes.next())) % frame.bytes.size()] =
            static_cast<std::uint8_t>(bytes.next());
    }
    return sweep;
}

struct Result {
    PulseMap map;
    WindowCounts windows;
    double samples_per_pulse;
};

Result analyse(const Sweep& sweep, bool fast) {
    SpacetimeOptions options = sweep.options;
    options.fast = fast;
    const Frame& first = sweep.frames.front();
    SpacetimeAnalyser analyser(first.width, first.height, 8, sweep.noise, options);
    for (const Frame& frame : sweep.frames) analyser.add(frame);
    PulseMap map = analyser.finish();
    return {std::move(map), analyser.windows(), analyser.sampling().samples_per_pulse};
}

void require(bool holds, const char* what, const Pulse& a, const Pulse& b) {
    if (holds) return;
    std::fprintf(
        stderr,
        "%s at (%g, %g): reference t %lld A %g w %g b %g s %g chi %g flags %d, fast t %lld "
        "A %g w %g b %g s %g chi %g flags %d\n",
        what, double{a.u}, double{a.v}, static_cast<long long>(a.t_ns), double{a.amplitude},
        double{a.width}, double{a.background}, double{a.sigma}, double{a.chi_square}, int{a.flags},
        static_cast<long long>(b.t_ns), double{b.amplitude}, double{b.width}, double{b.background},
        double{b.sigma}, double{b.chi_square}, int{b.flags});
    std::abort();
}

void require_close(const Sweep& sweep, const Pulse& a, const Pulse& b) {
    const double time = static_cast<double>(a.t_ns - b.t_ns);
    const double noise = std::sqrt(sample_variance(sweep.noise, a.background + a.amplitude));
    require(std::abs(time) <= 0.1 * a.sigma + 0.002 * sweep.period_ns, "time", a, b);
    require(std::abs(b.sigma / a.sigma - 1) <= 0.05, "sigma", a, b);
    require(std::abs(b.width / a.width - 1) <= 0.05, "width", a, b);
    require(std::abs(a.amplitude - b.amplitude) <= 0.2 * noise + 0.015 * a.amplitude, "amplitude",
            a, b);
    require(std::abs(a.chi_square - b.chi_square) <= 0.03 * std::max(a.chi_square, 1.0f),
            "chi-square", a, b);
    // A width is flagged by its ratio to the median, a ghost by the strongest pulse's height, which
    // both know to a few per cent only.
    require(((a.flags ^ b.flags) & ~(kPulseWidthOutOfRange | kPulseGhostSuspected)) == 0, "flags",
            a, b);
}

}  // namespace
}  // namespace stria

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stria;
    Bytes bytes(data, size);
    const Sweep sweep = make_sweep(bytes);
    const Result reference = analyse(sweep, false);
    const auto sets = fast::instruction_sets();
    Result first;
    for (const char* set : {sets.front(), sets.back()}) {
        fast::use_instruction_set(set);
        const Result fast = analyse(sweep, true);
        fast::use_instruction_set("");
        if (fast.windows.all != reference.windows.all ||
            fast.samples_per_pulse != reference.samples_per_pulse ||
            fast.map.saturated_samples != reference.map.saturated_samples ||
            fast.map.undersampled != reference.map.undersampled)
            std::abort();
        for (int y = 0; y < fast.map.height; ++y)
            for (int x = 0; x < fast.map.width; ++x) {
                const auto a = reference.map.cell(x, y), b = fast.map.cell(x, y);
                if (a.size() != b.size())
                    require(false, "number of pulses", a.empty() ? Pulse{} : a[0],
                            b.empty() ? Pulse{} : b[0]);
                // Pulses of equal strength may stand in either order.
                for (const Pulse& one : a)
                    require_close(
                        sweep, one,
                        *std::min_element(b.begin(), b.end(), [&](const Pulse& p, const Pulse& q) {
                            return std::abs(p.t_ns - one.t_ns) < std::abs(q.t_ns - one.t_ns);
                        }));
            }
        if (set == sets.front()) {
            first = fast;
            continue;
        }
        for (std::size_t i = 0; i < fast.map.pulses.size(); ++i) {
            const Pulse &a = first.map.pulses[i], &b = fast.map.pulses[i];
            require(a.t_ns == b.t_ns && a.amplitude == b.amplitude && a.sigma == b.sigma &&
                        a.width == b.width && a.background == b.background &&
                        a.chi_square == b.chi_square,
                    "instruction sets differ", a, b);
        }
    }
    return 0;
}
