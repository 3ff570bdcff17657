#include "firmware/stripe/deconvolution.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "firmware/stripe/option_check.h"

namespace stria {
namespace {

constexpr int kReach = 32;             // taps on either side, at most
constexpr int kFrequencies = 512;      // the filter's frequency response is sampled at
constexpr double kSmallestTap = 1e-5;  // of the middle one: the rest is cut
constexpr double kMostGain = 4;        // of the noise; beyond, 32 taps no longer hold the filter

double sum_of(const std::vector<double>& half) {
    double sum = half[0];
    for (std::size_t n = 1; n < half.size(); ++n) sum += 2 * half[n];
    return sum;
}

/// Half a symmetric filter, sum 1, from its frequency response: the inverse transform, cut where it
/// no longer counts.
std::vector<double> half_filter(const DeconvolutionOptions& options) {
    const double narrowed =
        options.footprint_px * options.footprint_px - options.target_px * options.target_px;
    std::vector<double> taps(kReach + 1, 0.0);
    for (int n = 0; n <= kReach; ++n) {
        double sum = 0;
        for (int k = 0; k < kFrequencies; ++k) {
            const double w = M_PI * (k + 0.5) / kFrequencies;
            sum += std::exp(0.5 * narrowed * w * w) * std::cos(w * n);
        }
        // The response has a kink at pi, whose taps fade slowly: cut off, they would ripple.
        const double window = 0.5 * (1 + std::cos(M_PI * n / (kReach + 1)));
        taps[static_cast<std::size_t>(n)] = window * sum / kFrequencies;
    }
    while (taps.size() > 1 && std::abs(taps.back()) < kSmallestTap * taps[0]) taps.pop_back();
    const double sum = sum_of(taps);
    for (double& tap : taps) tap /= sum;
    return taps;
}

double noise_gain_of(const std::vector<double>& half) {
    double squares = half[0] * half[0];
    for (std::size_t n = 1; n < half.size(); ++n) squares += 2 * half[n] * half[n];
    return std::sqrt(squares);
}

/// Filtered sample of a row; beyond its ends the outermost samples go on.
template <typename Taps>
double filtered(const std::vector<float>& row, int x, const Taps& half) {
    const int last = static_cast<int>(row.size()) - 1;
    double sum = half[0] * row[static_cast<std::size_t>(x)];
    for (int n = 1; n < static_cast<int>(half.size()); ++n)
        sum += half[static_cast<std::size_t>(n)] *
               (static_cast<double>(row[static_cast<std::size_t>(std::max(0, x - n))]) +
                row[static_cast<std::size_t>(std::min(last, x + n))]);
    return sum;
}

std::vector<float> row_of(const Frame& frame, int y) {
    std::vector<float> row(static_cast<std::size_t>(frame.width));
    for (int x = 0; x < frame.width; ++x)
        row[static_cast<std::size_t>(x)] = static_cast<float>(frame.sample(x, y));
    return row;
}

}  // namespace

void DeconvolutionOptions::validate() const {
    const OptionCheck require{"DeconvolutionOptions"};
    require(footprint_px >= 0.3 && footprint_px <= 3, "footprint_px", footprint_px, "0.3 to 3 px");
    require(target_px >= 0.3 && target_px < footprint_px, "target_px", target_px,
            "0.3 px to below footprint_px");
    const double gain = noise_gain_of(half_filter(*this));
    require(gain <= kMostGain, "target_px", target_px,
            "a target so near footprint_px that noise grows at most fourfold");
}

RowDeconvolver::RowDeconvolver(const DeconvolutionOptions& options, int bits) : bits_(bits) {
    options.validate();
    if (bits < 8 || bits > 16)
        throw std::invalid_argument("RowDeconvolver: bits = " + std::to_string(bits) +
                                    ": expected 8 to 16");
    const std::vector<double> taps = half_filter(options);
    taps_.assign(taps.begin(), taps.end());
    noise_gain_ = noise_gain_of(taps);
    // Half of the 16 bits for the light, half for what the filter swings below none.
    scale_ = std::ldexp(1.0, 15 - bits);
    pedestal_ = 65535 - scale_ * ((1 << bits) - 1);
}

Frame RowDeconvolver::operator()(const Frame& frame) const {
    if (frame.bits != bits_)
        throw std::invalid_argument("RowDeconvolver: frame of " + std::to_string(frame.bits) +
                                    " bits: expected " + std::to_string(bits_));
    Frame out = frame;
    resize(out, frame.width, frame.height, 16);
    auto* samples = reinterpret_cast<std::uint16_t*>(out.bytes.data());
    for (int y = 0; y < frame.height; ++y) {
        const std::vector<float> row = row_of(frame, y);
        for (int x = 0; x < frame.width; ++x) {
            const bool clipped = frame.sample(x, y) >= frame.full_scale();
            const double value = pedestal_ + scale_ * filtered(row, x, taps_);
            *samples++ =
                clipped ? 65535
                        : static_cast<std::uint16_t>(std::clamp(std::lround(value), 0L, 65534L));
        }
    }
    return out;
}

SensorNoise RowDeconvolver::noise_of(const SensorNoise& sensor) const {
    const double gain2 = noise_gain_ * noise_gain_;
    const double read_dn = sensor.read_noise_e / sensor.gain_e_per_dn;
    SensorNoise noise;
    noise.gain_e_per_dn = sensor.gain_e_per_dn / (gain2 * scale_);
    // The frames' own rounding is filtered with the rest.
    noise.read_noise_e =
        noise.gain_e_per_dn * scale_ * noise_gain_ * std::sqrt(read_dn * read_dn + 1.0 / 12.0);
    noise.black_dn = pedestal_ + scale_ * sensor.black_dn;
    return noise;
}

}  // namespace stria
