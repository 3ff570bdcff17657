#include "host/cli/stripe_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "firmware/core/median.h"
#include "firmware/stripe/noise_estimate.h"
#include "host/core/errors.h"
#include "host/core/frame_image.h"
#include "host/io/number_text.h"
#include "host/io/text_lines.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

constexpr std::size_t kChannelVotes = 9;  // images that decide which channel shows the stripe
constexpr std::size_t kNoiseImages = 8;   // that the noise is estimated from
constexpr int kPedestal8 = 64, kPedestal16 = 4096;  // DN; keep differences below 0

std::size_t spread(std::size_t i, std::size_t count, std::size_t total) {
    return (2 * i + 1) * total / (2 * count);
}

/// What most of a few images say.
ColourChannel voted(const std::vector<std::string>& files,
                    ColourChannel (*choice)(const LoadedImage&)) {
    std::array<int, 5> votes{};
    const std::size_t count = std::min(kChannelVotes, files.size());
    for (std::size_t i = 0; i < count; ++i) {
        const LoadedImage image = read_image(files[spread(i, count, files.size())]);
        ++votes[static_cast<std::size_t>(choice(image))];
    }
    const auto best = std::max_element(votes.begin(), votes.end());
    return static_cast<ColourChannel>(best - votes.begin());
}

}  // namespace

StripeImages::StripeImages(std::vector<std::string> files, const Options& options)
    : files_(std::move(files)), off_(options.off), columns_(options.columns) {
    if (files_.empty()) throw Error("no images given");
    channel_ = colour_channel_from(options.channel);
    if (channel_ == ColourChannel::automatic) channel_ = voted(files_, strongest_channel);
    laser_ = voted(files_, laser_colour);
    if (options.times_file.empty()) {
        for (std::size_t i = 0; i < files_.size(); ++i)
            starts_ns_.push_back(static_cast<TimeNs>(i) * kNsPerSecond);
    } else {
        read_times(options.times_file);
    }
}

/// Times may be of any unit and may descend (an axis that travels back): they become a device clock
/// that starts at 0 and ticks a second a median step.
void StripeImages::read_times(const std::string& path) {
    const std::string text = read_whole_file(path, 64u << 20);
    TextLines lines(text, path);
    std::vector<double> times;
    while (lines.next()) {
        if (lines.rest().empty()) continue;
        times.push_back(lines.finite_number("a time"));
        if (times.size() < 2) continue;
        const double step = times.back() - times[times.size() - 2];
        if (step == 0 || step * (times[1] - times[0]) < 0)
            lines.fail("expected times that all ascend or all descend, found a step of " +
                       std::to_string(step));
    }
    if (times.size() != files_.size())
        throw FileError(path, "",
                        "expected one time for each of the " + std::to_string(files_.size()) +
                            " images, found " + std::to_string(times.size()));
    origin_ = times[0];
    std::vector<double> steps;
    for (std::size_t i = 1; i < times.size(); ++i)
        steps.push_back(std::abs(times[i] - times[i - 1]));
    if (!steps.empty()) {
        ns_per_unit_ = 1e9 / median(std::move(steps));
        direction_ = times[1] > times[0] ? 1 : -1;
    }
    for (const double time : times)
        starts_ns_.push_back(std::llround((time - origin_) * direction_ * ns_per_unit_));
}

void StripeImages::check_size(const std::string& file, const LoadedImage& image) {
    if (width_ == 0) {
        width_ = image.pixels.width;
        height_ = image.pixels.height;
        bits_ = image.bits;
    }
    if (image.pixels.width != width_ || image.pixels.height != height_ || image.bits != bits_)
        throw FileError(
            file, "",
            "expected " + std::to_string(width_) + " x " + std::to_string(height_) + " pixels of " +
                std::to_string(bits_) + " bits as in the first image, found " +
                std::to_string(image.pixels.width) + " x " + std::to_string(image.pixels.height) +
                " of " + std::to_string(image.bits));
}

Grey16Image StripeImages::channel_of(const std::string& file) {
    const LoadedImage image = read_image(file);
    check_size(file, image);
    return select_channel(image, channel_);
}

Grey16Image StripeImages::background_of(std::size_t i) {
    if (off_.size() == files_.size()) return channel_of(off_[i]);
    if (mean_off_.empty()) {
        std::vector<std::uint32_t> sum;
        for (const std::string& file : off_) {
            mean_off_ = channel_of(file);
            sum.resize(mean_off_.values.size());
            for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += mean_off_.values[k];
        }
        const auto count = static_cast<std::uint32_t>(off_.size());
        for (std::size_t k = 0; k < sum.size(); ++k)
            mean_off_.values[k] = static_cast<std::uint16_t>((sum[k] + count / 2) / count);
    }
    return mean_off_;
}

double StripeImages::pedestal_dn() const {
    if (off_.empty()) return 0;
    return bits_ > 8 ? kPedestal16 : kPedestal8;
}

/// The difference plus the pedestal, in a frame that has room for both where 16 bits allow.
Frame StripeImages::without_background(const Grey16Image& light, std::size_t i) {
    const Grey16Image dark = background_of(i);
    const int bits = std::min(bits_ + 1, 16);
    const int most = (1 << bits) - 2, pedestal = static_cast<int>(pedestal_dn());
    Grey16Image out = light;
    for (std::size_t k = 0; k < out.values.size(); ++k) {
        const int difference = light.values[k] - dark.values[k] + pedestal;
        out.values[k] = static_cast<std::uint16_t>(std::clamp(difference, 0, most));
    }
    return frame_from_image(out, bits);
}

bool StripeImage::clipped(const Pulse& peak) const {
    if (light.width == 0) return false;
    const int reach = static_cast<int>(std::ceil(2 * peak.width));
    const int x = static_cast<int>(std::lround(peak.u)), y = static_cast<int>(peak.v);
    for (int at = std::max(0, x - reach); at <= std::min(light.width - 1, x + reach); ++at)
        if (light.sample(at, y) >= light.full_scale()) return true;
    return false;
}

StripeImage StripeImages::load(std::size_t i) {
    LoadedImage image = read_image(files_[i]);
    check_size(files_[i], image);
    StripeImage out;
    const Grey16Image light = select_channel(image, channel_);
    out.frame = frame_from_image(light, bits_);
    if (columns_) out.frame = transposed(out.frame);
    if (!off_.empty()) {
        out.light = std::exchange(out.frame, without_background(light, i));
        if (columns_) out.frame = transposed(out.frame);
    }
    out.frame.sequence = static_cast<std::uint32_t>(i);
    out.frame.exposure_start_ns = starts_ns_[i];
    out.colour = LaserColour(std::move(image), laser_, columns_);
    return out;
}

SensorNoise StripeImages::estimated_noise() {
    std::vector<Frame> frames;
    const std::size_t count = std::min(kNoiseImages, files_.size());
    for (std::size_t i = 0; i < count; ++i)
        frames.push_back(load(spread(i, count, files_.size())).frame);
    SensorNoise noise = estimate_noise(frames);
    // The estimate counts light from 0 DN: what it says at the pedestal is noise without light.
    const double read_dn = noise.read_noise_e / noise.gain_e_per_dn;
    noise.read_noise_e =
        noise.gain_e_per_dn * std::sqrt(read_dn * read_dn + pedestal_dn() / noise.gain_e_per_dn);
    noise.black_dn = pedestal_dn();
    return noise;
}

SensorNoise StripeImages::noise_of(const SensorNoise& sensor) {
    if (off_.empty()) return sensor;
    SensorNoise noise = sensor;
    const double frames = off_.size() == files_.size() ? 1.0 : static_cast<double>(off_.size());
    const double light_e = median(background_of(0).values) * sensor.gain_e_per_dn;
    noise.read_noise_e =
        std::sqrt((1 + 1 / frames) * (sensor.read_noise_e * sensor.read_noise_e + light_e));
    noise.black_dn = pedestal_dn();
    return noise;
}

SensorNoise parse_noise(const std::string& text) {
    const std::size_t comma = text.find(',');
    const auto gain = parse_number(text.substr(0, comma));
    const auto read =
        comma == std::string::npos ? std::nullopt : parse_number(text.substr(comma + 1));
    if (!gain || !read || !(*gain > 0) || !(*read >= 0))
        throw Error(
            "--noise: expected GAIN,READ (electrons per DN above 0, electrons), as 40,10; "
            "found " +
            text);
    SensorNoise noise;
    noise.gain_e_per_dn = *gain;
    noise.read_noise_e = *read;
    return noise;
}

}  // namespace stria
