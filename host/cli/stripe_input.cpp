#include "host/cli/stripe_input.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/core/errors.h"
#include "host/core/frame_image.h"
#include "host/io/number_text.h"
#include "host/io/text_lines.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

constexpr std::size_t kChannelVotes = 9;  // images that decide which channel shows the stripe

std::size_t spread(std::size_t i, std::size_t count, std::size_t total) {
    return (2 * i + 1) * total / (2 * count);
}

ColourChannel voted_channel(const std::vector<std::string>& files) {
    std::array<int, 5> votes{};
    const std::size_t count = std::min(kChannelVotes, files.size());
    for (std::size_t i = 0; i < count; ++i) {
        const LoadedImage image = read_image(files[spread(i, count, files.size())]);
        ++votes[static_cast<std::size_t>(strongest_channel(image))];
    }
    const auto best = std::max_element(votes.begin(), votes.end());
    return static_cast<ColourChannel>(best - votes.begin());
}

}  // namespace

StripeImages::StripeImages(std::vector<std::string> files, const Options& options)
    : files_(std::move(files)), columns_(options.columns) {
    if (files_.empty()) throw Error("no images given");
    channel_ = colour_channel_from(options.channel);
    if (channel_ == ColourChannel::automatic) channel_ = voted_channel(files_);
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
        std::nth_element(steps.begin(), steps.begin() + static_cast<long>(steps.size() / 2),
                         steps.end());
        ns_per_unit_ = 1e9 / steps[steps.size() / 2];
        direction_ = times[1] > times[0] ? 1 : -1;
    }
    for (const double time : times)
        starts_ns_.push_back(std::llround((time - origin_) * direction_ * ns_per_unit_));
}

Frame StripeImages::load(std::size_t i) {
    const LoadedImage image = read_image(files_[i]);
    if (width_ == 0) {
        width_ = image.pixels.width;
        height_ = image.pixels.height;
        bits_ = image.bits;
    }
    if (image.pixels.width != width_ || image.pixels.height != height_ || image.bits != bits_)
        throw FileError(
            files_[i], "",
            "expected " + std::to_string(width_) + " x " + std::to_string(height_) + " pixels of " +
                std::to_string(bits_) + " bits as in the first image, found " +
                std::to_string(image.pixels.width) + " x " + std::to_string(image.pixels.height) +
                " of " + std::to_string(image.bits));
    Frame frame = frame_from_image(select_channel(image, channel_), image.bits);
    if (columns_) frame = transposed(frame);
    frame.sequence = static_cast<std::uint32_t>(i);
    frame.exposure_start_ns = starts_ns_[i];
    return frame;
}

std::vector<Frame> StripeImages::sample(std::size_t most) {
    std::vector<Frame> frames;
    const std::size_t count = std::min(most, files_.size());
    for (std::size_t i = 0; i < count; ++i) frames.push_back(load(spread(i, count, files_.size())));
    return frames;
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
