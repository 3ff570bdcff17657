#pragma once
#include <string>
#include <vector>

#include "firmware/core/frame.h"
#include "firmware/core/sensor_noise.h"
#include "host/cli/stripe_colour.h"
#include "host/io/image_io.h"

namespace stria {

/// One photograph of a stripe: the samples to analyse, and the colours they came from.
struct StripeImage {
    Frame frame;
    LaserColour colour;
    Frame light;  ///< before other light was subtracted; empty where nothing was

    /// True if samples under the peak were at full scale before the subtraction, which hides it.
    bool clipped(const Pulse& peak) const;
};

/// Photographs of a stripe as the frames of a sweep, loaded one at a time. With images of the same
/// scene without laser their light is subtracted: a sample is then the difference plus
/// `pedestal_dn` in a frame of at least one bit more, and at full scale where the photograph is.
class StripeImages {
  public:
    struct Options {
        std::string channel = "auto";  ///< one for all images: what most of them are strongest in
        bool columns = false;          ///< one peak a column: frames are the images transposed
        std::vector<std::string> off;  ///< without laser: one for each image, or their mean for all
        std::string times_file = {};   ///< one number a line, one line an image; empty: 0, 1, 2 ...
    };
    /// Throws stria::Error if there are no images or the times do not fit them.
    StripeImages(std::vector<std::string> files, const Options& options);

    std::size_t size() const { return files_.size(); }
    const std::string& file(std::size_t i) const { return files_[i]; }
    /// Numbered i, exposed at its time. Throws FileError if it cannot be read or is of another size
    /// or depth than the first loaded one.
    StripeImage load(std::size_t i);
    /// Noise of the frames as `load` gives them, estimated from a few spread over the series.
    SensorNoise estimated_noise();
    /// The same for a known sensor: subtracted light leaves its noise, taken at its median.
    SensorNoise noise_of(const SensorNoise& sensor);
    double pedestal_dn() const;  ///< DN of no laser light; 0 without off images
    /// Device time of a frame in the unit of the times (or in frames).
    double time_of(double t_ns) const { return origin_ + direction_ * t_ns / ns_per_unit_; }
    double units_per_ns() const { return 1.0 / ns_per_unit_; }
    ColourChannel channel() const { return channel_; }

  private:
    void read_times(const std::string& path);
    void check_size(const std::string& file, const LoadedImage& image);
    Grey16Image channel_of(const std::string& file);
    Grey16Image background_of(std::size_t i);
    Frame without_background(const Grey16Image& light, std::size_t i);

    std::vector<std::string> files_, off_;
    Grey16Image mean_off_;  // where it is the same for all images
    bool columns_ = false;
    ColourChannel channel_ = ColourChannel::automatic, laser_ = ColourChannel::grey;
    std::vector<TimeNs> starts_ns_;
    double origin_ = 0, direction_ = 1, ns_per_unit_ = 1e9;
    int width_ = 0, height_ = 0, bits_ = 0;
};

/// "GAIN,READ" (electrons per DN, electrons) as a sensor; throws stria::Error on anything else.
SensorNoise parse_noise(const std::string& text);

}  // namespace stria
