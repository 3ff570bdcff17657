#include "tests/firmware/stripe/byte_sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <span>

#include "firmware/stripe/fast_kernels.h"

namespace stria::test {
namespace {

constexpr double kEqualStrength = 1.03;  // ratio up to which two pulses are equally strong
constexpr double kNoShotNoise = 196;     // gain in the input from which on there is none
constexpr double kManyElectrons = 1e6;   // a DN, so that light brings no noise

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

/// The same numbers on every machine.
class Noise {
  public:
    explicit Noise(std::uint32_t seed) : state_(seed) {}
    double uniform() {  // [0, 1)
        state_ = state_ * 1664525u + 1013904223u;
        return (state_ >> 8) / 16777216.0;
    }
    /// Nearly normal, of unit variance: four uniform numbers together.
    double normal() {
        double sum = 0;
        for (int i = 0; i < 4; ++i) sum += uniform() - 0.5;
        return 1.7320508 * sum;
    }

  private:
    std::uint32_t state_;
};

struct Flicker {
    double share, period;
    double at(double t) const { return 1.0 + share * std::sin(6.2831853 * t / period); }
};

void paint(ByteSweep& sweep, int x, int y, const Flicker& flicker, Bytes& bytes) {
    const double background = bytes.within(0, 120);
    const double height = bytes.within(0, 300), width = bytes.within(0.3, 8);
    const double place = bytes.within(0, static_cast<double>(sweep.frames.size()));
    const double second = bytes.within(0, 1), apart = bytes.within(0, 20);
    const int rough = bytes.next();
    Noise noise(static_cast<std::uint32_t>(bytes.next()) * 2654435761u + 12345u);
    for (Frame& frame : sweep.frames) {
        const double t = static_cast<double>(frame.row_time(y)) / sweep.period_ns - 100.0;
        const double a = (t - place) / width, b = (t - place - apart) / width;
        const double value = background * flicker.at(t) + height * std::exp(-0.5 * a * a) +
                             second * height * std::exp(-0.5 * b * b);
        const double sigma =
            rough < 255 ? 12.0 * rough / 254.0 : std::sqrt(sample_variance(sweep.noise, value));
        frame.bytes[static_cast<std::size_t>(y * frame.width + x)] = static_cast<std::uint8_t>(
            std::clamp(std::floor(value + sigma * noise.normal() + 0.5), 0.0, 255.0));
    }
}

/// Frames without samples yet, of which some may be missing.
void lay_out_frames(ByteSweep& sweep, Bytes& bytes) {
    const int width = 1 + bytes.next() % 70, height = 1 + bytes.next() % 3;
    const int count = 1 + bytes.next() % 120;
    const double jitter = bytes.within(0, 0.45), exposure = bytes.within(0.001, 1.0);
    Noise noise(static_cast<std::uint32_t>(bytes.next()) + 77u);
    const double dropped = bytes.within(0, 0.1);
    for (int k = 0; k < count; ++k) {
        Frame frame;
        resize(frame, width, height, 8);
        const double early = jitter * (2.0 * noise.uniform() - 1.0);
        if (noise.uniform() < dropped && !sweep.frames.empty()) continue;
        frame.sequence = static_cast<std::uint32_t>(k);
        frame.exposure_ns = static_cast<TimeNs>(exposure * sweep.period_ns);
        frame.exposure_start_ns = static_cast<TimeNs>((100 + k + early) * sweep.period_ns);
        frame.row_time_ns = 1000;
        sweep.frames.push_back(std::move(frame));
    }
}

/// Frames come twice, or with a number of long ago: both are to be left out.
void repeat_frames(ByteSweep& sweep, double repeated, double late, std::uint32_t seed) {
    Noise noise(seed);
    std::vector<Frame> frames;
    for (Frame& frame : sweep.frames) {
        frames.push_back(frame);
        if (noise.uniform() < repeated) frames.push_back(frame);
        if (noise.uniform() < late) {
            frames.push_back(frame);
            frames.back().exposure_start_ns -= static_cast<TimeNs>(2 * sweep.period_ns);
            ++frames.back().sequence;
        }
    }
    sweep.frames = std::move(frames);
}

struct Result {
    PulseMap map;
    WindowCounts windows;
    SweepSampling sampling;
    int ignored;
};

Result analyse(const ByteSweep& sweep, bool fast) {
    SpacetimeOptions options = sweep.options;
    options.fast = fast;
    const Frame& first = sweep.frames.front();
    SpacetimeAnalyser analyser(first.width, first.height, 8, sweep.noise, options);
    for (const Frame& frame : sweep.frames) analyser.add(frame);
    PulseMap map = analyser.finish();
    return {std::move(map), analyser.windows(), analyser.sampling(), analyser.frames_ignored()};
}

bool same_sweep(const Result& a, const Result& b) {
    return a.windows.all == b.windows.all &&
           a.sampling.samples_per_pulse == b.sampling.samples_per_pulse &&
           a.map.saturated_samples == b.map.saturated_samples &&
           a.map.undersampled == b.map.undersampled && a.map.frames == b.map.frames &&
           a.map.frames_dropped == b.map.frames_dropped && a.ignored == b.ignored;
}

double strength(const Pulse& p) { return p.amplitude * std::sqrt(p.width); }

/// Relative bound of an amplitude.
double amplitude_bound(const ByteSweep& sweep, const Pulse& p) {
    return 0.2 * std::sqrt(sample_variance(sweep.noise, p.background + p.amplitude)) / p.amplitude +
           0.015;
}

/// Flags that may differ, because the ratio that they are about is at its limit within the bounds
/// of what it is of: a width over the median width (both 5 %), a ghost's height over that of the
/// strongest pulse of its cell, which is either one of two equally strong.
int flags_at_their_limit(const ByteSweep& sweep, const Pulse& p, std::span<const Pulse> cell,
                         double median_width) {
    int flags = 0;
    const double ratio = p.width / median_width, limit = sweep.options.width_ratio;
    for (const double at : {limit, 1.0 / limit})
        if (std::abs(ratio / at - 1.0) <= 0.11) flags |= kPulseWidthOutOfRange;
    for (const Pulse& strongest : cell) {
        if (kEqualStrength * strength(strongest) < strength(cell.front())) continue;
        const double share = p.amplitude / strongest.amplitude;
        const double bound = amplitude_bound(sweep, p) + amplitude_bound(sweep, strongest);
        const bool either = &strongest != &cell.front();  // its partner may stand first
        if (either || kEqualStrength * strength(p) >= strength(cell.front()) ||
            std::abs(2.0 * share - 1.0) <= bound)
            flags |= kPulseGhostSuspected;
    }
    return flags;
}

double median_width(const PulseMap& map) {
    std::vector<float> widths = {1};
    for (const Pulse& pulse : map.pulses) widths.push_back(pulse.width);
    const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
    std::nth_element(widths.begin(), middle, widths.end());
    return *middle;
}

/// The bound that the two break, or null.
const char* broken_bound(const ByteSweep& sweep, const Pulse& a, const Pulse& b, int may_differ) {
    const double time = static_cast<double>(a.t_ns - b.t_ns);
    if (!(std::abs(time) <= 0.1 * a.sigma + 0.002 * sweep.period_ns)) return "time";
    if (!(std::abs(b.sigma / a.sigma - 1) <= 0.05)) return "sigma";
    if (!(std::abs(b.width / a.width - 1) <= 0.05)) return "width";
    if (!(std::abs(b.amplitude / a.amplitude - 1) <= amplitude_bound(sweep, a))) return "amplitude";
    if (!(std::abs(a.chi_square - b.chi_square) <= 0.03 * std::max(a.chi_square, 1.0f)))
        return "chi-square";
    if (((a.flags ^ b.flags) & ~may_differ) != 0) return "flags";
    return nullptr;
}

/// Where a pixel has more pulses than are kept, those of equal strength may be kept either way.
bool may_be_left_out(const ByteSweep& sweep, const Pulse& pulse, std::span<const Pulse> others) {
    double weakest = 1e300;
    for (const Pulse& other : others) weakest = std::min(weakest, strength(other));
    return static_cast<int>(others.size()) == sweep.options.max_pulses_per_cell &&
           strength(pulse) <= kEqualStrength * weakest;
}

/// The bound that pulse `one` of the reference breaks in the fast map's cell; pulses of equal
/// strength may stand in either order.
const char* broken_bound(const ByteSweep& sweep, const Pulse& one, std::span<const Pulse> fast,
                         int may_differ, Pulse& nearest) {
    nearest = *std::min_element(fast.begin(), fast.end(), [&](const Pulse& p, const Pulse& q) {
        return std::abs(p.t_ns - one.t_ns) < std::abs(q.t_ns - one.t_ns);
    });
    const char* what = broken_bound(sweep, one, nearest, may_differ);
    return what != nullptr && may_be_left_out(sweep, one, fast) ? nullptr : what;
}

void compare_cells(const ByteSweep& sweep, const Result& reference, const Result& fast,
                   std::vector<Disagreement>& out) {
    const double usual_width = median_width(reference.map);
    for (int y = 0; y < fast.map.height; ++y)
        for (int x = 0; x < fast.map.width; ++x) {
            const auto a = reference.map.cell(x, y), b = fast.map.cell(x, y);
            if (a.size() != b.size()) {
                out.push_back({"number of pulses " + std::to_string(a.size()) + ", " +
                                   std::to_string(b.size()),
                               x, y, a.empty() ? Pulse{} : a[0], b.empty() ? Pulse{} : b[0]});
                continue;
            }
            for (const Pulse& one : a) {
                Pulse nearest;
                const int may_differ = flags_at_their_limit(sweep, one, a, usual_width);
                if (const char* what = broken_bound(sweep, one, b, may_differ, nearest))
                    out.push_back({what, x, y, one, nearest});
            }
        }
}

bool same_bits(const Pulse& a, const Pulse& b) {
    return a.u == b.u && a.v == b.v && a.t_ns == b.t_ns && a.amplitude == b.amplitude &&
           a.sigma == b.sigma && a.width == b.width && a.background == b.background &&
           a.chi_square == b.chi_square && a.flags == b.flags;
}

}  // namespace

ByteSweep sweep_from_bytes(const std::uint8_t* data, std::size_t size) {
    Bytes bytes(data, size);
    ByteSweep sweep;
    sweep.options.min_snr = bytes.within(3, 12);
    sweep.options.min_amplitude_dn = bytes.within(0, 8);
    sweep.options.max_pulses_per_cell = 1 + bytes.next() % kMaxPulsesPerCell;
    sweep.options.max_pulse_frames = 4 + bytes.next() % 100;
    sweep.options.history_frames = 4 + bytes.next() % 30;
    sweep.options.max_misfit = bytes.within(0.05, 0.5);
    const double gain = bytes.within(1, 200);
    sweep.noise = {gain < kNoShotNoise ? gain : kManyElectrons, 0, bytes.within(0, 20)};
    sweep.noise.read_noise_e = bytes.within(0, 12) * sweep.noise.gain_e_per_dn;
    lay_out_frames(sweep, bytes);
    const double repeated = bytes.within(0, 0.1), late = bytes.within(0, 0.05);
    const Flicker flicker = {bytes.within(0, 0.5), bytes.within(1.5, 20)};
    const Frame& first = sweep.frames.front();
    const int width = first.width, height = first.height;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) paint(sweep, x, y, flicker, bytes);
    for (std::size_t i = 0; !bytes.empty(); ++i) {  // single samples as the input has them
        Frame& frame = sweep.frames[static_cast<std::size_t>(bytes.next()) % sweep.frames.size()];
        frame.bytes[(i * 7 + static_cast<std::size_t>(bytes.next())) % frame.bytes.size()] =
            static_cast<std::uint8_t>(bytes.next());
    }
    repeat_frames(sweep, repeated, late, 4711u);
    return sweep;
}

std::vector<std::uint8_t> random_sweep_bytes(std::uint64_t seed) {
    std::mt19937_64 rng(seed);
    std::vector<std::uint8_t> bytes(30 + rng() % (rng() % 8 == 0 ? 1700 : 250));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(rng() >> 56);
    for (const std::size_t fault : {15, 16, 17, 18})  // half of the sweeps without each
        if (rng() % 2 == 0) bytes[fault] = 0;
    // Half of the sweeps with the noise that the sensor's parameters say.
    if (rng() % 2 == 0)
        for (std::size_t i = 20 + 6; i < bytes.size(); i += 8) bytes[i] = 255;
    return bytes;
}

std::string text_of(const Disagreement& of) {
    const Pulse &a = of.reference, &b = of.fast;
    std::array<char, 400> text;
    std::snprintf(text.data(), text.size(),
                  "%s at (%d, %d): reference t %lld A %g w %g b %g s %g chi %g flags %d, fast t "
                  "%lld A %g w %g b %g s %g chi %g flags %d",
                  of.what.c_str(), of.x, of.y, static_cast<long long>(a.t_ns), double{a.amplitude},
                  double{a.width}, double{a.background}, double{a.sigma}, double{a.chi_square},
                  int{a.flags}, static_cast<long long>(b.t_ns), double{b.amplitude},
                  double{b.width}, double{b.background}, double{b.sigma}, double{b.chi_square},
                  int{b.flags});
    return text.data();
}

std::vector<Disagreement> disagreements(const ByteSweep& sweep, std::size_t* pulses) {
    std::vector<Disagreement> out;
    const Result reference = analyse(sweep, false);
    if (pulses != nullptr) *pulses += reference.map.pulses.size();
    const auto sets = fast::instruction_sets();
    Result first;
    for (const char* set : {sets.front(), sets.back()}) {
        if (set != sets.front() && sweep.frames.size() % 4 != 0) continue;  // the time it takes
        fast::use_instruction_set(set);
        Result fast = analyse(sweep, true);
        fast::use_instruction_set("");
        if (set == sets.front()) {
            if (!same_sweep(reference, fast)) out.push_back({"sweep", 0, 0, {}, {}});
            compare_cells(sweep, reference, fast, out);
            first = std::move(fast);
        } else if (!std::equal(first.map.pulses.begin(), first.map.pulses.end(),
                               fast.map.pulses.begin(), fast.map.pulses.end(), same_bits)) {
            out.push_back({std::string("instruction sets differ: ") + set, 0, 0, {}, {}});
        }
    }
    return out;
}

}  // namespace stria::test
