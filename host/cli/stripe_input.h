#pragma once
#include <string>
#include <vector>

#include "firmware/core/frame.h"
#include "firmware/core/sensor_noise.h"
#include "host/io/image_io.h"

namespace stria {

/// Photographs of a stripe as the frames of a sweep, loaded one at a time.
class StripeImages {
  public:
    struct Options {
        std::string channel = "auto";  ///< one for all images: what most of them are strongest in
        bool columns = false;          ///< one peak a column: frames are the images transposed
        std::string times_file;        ///< one number a line, one line an image; empty: 0, 1, 2 ...
    };
    /// Throws stria::Error if there are no images or the times do not fit them.
    StripeImages(std::vector<std::string> files, const Options& options);

    std::size_t size() const { return files_.size(); }
    const std::string& file(std::size_t i) const { return files_[i]; }
    /// Numbered i, exposed at its time. Throws FileError if it cannot be read or is of another size
    /// or depth than the first loaded one.
    Frame load(std::size_t i);
    /// A few of them, spread over the series, to learn the noise from.
    std::vector<Frame> sample(std::size_t most);
    /// Device time of a frame in the unit of the times (or in frames).
    double time_of(double t_ns) const { return origin_ + direction_ * t_ns / ns_per_unit_; }
    double units_per_ns() const { return 1.0 / ns_per_unit_; }
    ColourChannel channel() const { return channel_; }

  private:
    void read_times(const std::string& path);

    std::vector<std::string> files_;
    bool columns_ = false;
    ColourChannel channel_ = ColourChannel::automatic;
    std::vector<TimeNs> starts_ns_;
    double origin_ = 0, direction_ = 1, ns_per_unit_ = 1e9;
    int width_ = 0, height_ = 0, bits_ = 0;
};

/// "GAIN,READ" (electrons per DN, electrons) as a sensor; throws stria::Error on anything else.
SensorNoise parse_noise(const std::string& text);

}  // namespace stria
