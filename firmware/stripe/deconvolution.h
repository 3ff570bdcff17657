#pragma once
#include <span>
#include <vector>

#include "firmware/core/frame.h"
#include "firmware/core/sensor_noise.h"

namespace stria {

/// How much of the camera's blur is taken back out of the rows of frames.
struct DeconvolutionOptions {
    /// Standard deviation of what a pixel sees of the scene (lens and pixel together), px, 0.3
    /// to 3.
    double footprint_px = 0.8;
    /// What is left of it: at least 0.3 px, below footprint_px, and not so far below that noise
    /// grows more than fourfold.
    double target_px = 0.55;

    /// Throws std::invalid_argument naming field, value and bound.
    void validate() const;
};

/// Regularised deconvolution along the rows, across the stripe (Curless and Levoy 1995 sharpen the
/// recorded images before spacetime analysis). A pulse over time is drawn at an edge of reflectance
/// by what its pixel sees besides its middle: its greatest error over that of a spatial moment is
/// footprint over beam, so that less blur draws less. The blur, a Gaussian, is replaced by a
/// narrower Gaussian: F(w) = exp(w^2 (footprint^2 - target^2) / 2), w up to pi radians per px. That
/// never rings, which a Tikhonov or Wiener filter does: beside a 10:1 edge its undershoot is as
/// large as the dark side's light. The price is noise: `noise_gain`. The rows must be across the
/// stripe, and the blur no narrower than stated: too strong a filter sharpens what is sharp.
class RowDeconvolver {
  public:
    /// Of frames of `bits` (8 to 16).
    RowDeconvolver(const DeconvolutionOptions& options, int bits);

    /// Standard deviation of the noise of a sample after the filter over that before.
    double noise_gain() const { return noise_gain_; }
    /// DN of the filtered frame per DN of the given one.
    double scale() const { return scale_; }
    /// The filter from its middle on, the other half mirrored; sums to 1 over both halves.
    std::span<const float> taps() const { return taps_; }

    /// A frame of 16 bits: no light at `noise_of(sensor).black_dn`, full scale where it was; beyond
    /// the image's borders the outermost samples go on. A clipped sample counts as full scale to
    /// its neighbours and stays at full scale itself. Throws std::invalid_argument on another
    /// depth.
    Frame operator()(const Frame& frame) const;
    /// The sensor of the filtered frames.
    SensorNoise noise_of(const SensorNoise& sensor) const;

  private:
    int bits_ = 8;
    double noise_gain_ = 1, scale_ = 1, pedestal_ = 0;
    std::vector<float> taps_;
};

}  // namespace stria
