#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "firmware/core/axis_log.h"
#include "firmware/core/frame.h"
#include "firmware/core/image_paths.h"
#include "firmware/core/pulse.h"
#include "firmware/core/sensor_noise.h"
#include "firmware/stripe/frame_follower.h"
#include "firmware/stripe/frame_store.h"
#include "firmware/stripe/gaussian_fit.h"
#include "firmware/stripe/spatial.h"

namespace stria {

/// What counts as a pulse along an image path.
struct PathOptions {
    SpatialOptions seeds;       ///< the spatial peaks that paths are laid through
    double reach_widths = 3.5;  ///< samples are taken so many expected widths before and after
    double min_path_px = 2;     ///< a shorter path over 4 widths falls back to the spatial peak
    double max_misfit = 0.2;    ///< rms residual over amplitude above which it is no pulse
    int max_pulse_frames = 96;  ///< bounds the frames that are held; a longer pulse is cut
    int threads = 1;            ///< the result does not depend on it

    /// Throws std::invalid_argument naming field, value and bound.
    void validate() const;
};

/// Spacetime analysis of a rail or turntable sweep. A seed is a spatial peak at (u, v) of frame k;
/// the light is followed along the image path of the point that the sheet's centre crosses there
/// (PathTable), fitted as a pulse over the axis travel by maximum likelihood, and the path is laid
/// anew through the place found until it stands. The grid is (k, v) of the seeds; u and v of a
/// pulse are fractional; width and sigma are ns, t_ns device time. Seeds that lead to one pulse are
/// merged. Where there is no path, or one shorter than min_path_px, the spatial peak stands,
/// flagged kPulseSpatialFallback. Frames are held only as long as a pulse lasts. Sources: Curless
/// and Levoy 1995; paths instead of a rotated spacetime image: DESIGN.
class PathAnalyser {
  public:
    /// Throws std::invalid_argument if the table or the options are not usable.
    PathAnalyser(PathTable table, int bits, const SensorNoise& noise,
                 const PathOptions& options = {});

    /// Laser-on frames in time order, with the axis at the middle of row 0's exposure. A frame that
    /// repeats a sequence number or is not later than the last one is ignored and counted. Throws
    /// std::invalid_argument on another size or depth.
    void add(const Frame& frame, const AxisState& at_row_0);
    /// The map of all frames so far. Call once, at the end. Empty with `undersampled` set where the
    /// step exceeds the beam's width.
    PulseMap finish();
    int frames_ignored() const { return follower_.ignored(); }

  private:
    /// A pulse, whose seed it came from, and how far from that it was found.
    struct Found {
        Pulse pulse;
        int frame = 0, row = 0;
        double s = 0, off_seed = 0;  ///< unit of s
    };
    /// A point on its way through the sheet: pixel and axis position of the crossing.
    struct Crossing {
        double u = 0, v = 0, s = 0;
    };
    /// A fit along a path, which of its pulses is meant, and where that one crosses.
    struct Fitted {
        GaussianFit fit;
        int which = 0;
        Crossing at;
    };

    double position(int frame, double v) const;
    void analyse_ready(bool at_end);
    std::optional<Found> refine(const Pulse& seed, int k) const;
    std::optional<FitSamples> samples_along(const ImagePath& path, const Crossing& crossing, int k,
                                            double step) const;
    bool is_long_enough(const ImagePath& path) const;
    std::optional<Fitted> fit_along(const ImagePath& path, const Crossing& crossing,
                                    const Pulse& seed, int k, double step) const;
    Pulse as_pulse(const Pulse& seed, const GaussianFit& fit, int which, const Crossing& crossing,
                   int k, double step) const;
    void merge_twins();
    double step_at(int k) const;

    PathTable table_;
    int bits_;
    SensorNoise noise_;
    PathOptions options_;
    FrameFollower follower_;
    FrameStore frames_;
    std::vector<AxisState> axis_;            ///< of every frame, at row 0
    std::vector<std::vector<Pulse>> seeds_;  ///< of every frame
    std::vector<Found> found_;
    std::vector<double> steps_per_width_;  ///< of the seeds
    double widest_ = 0;                    ///< of the table, unit of s
    int analysed_ = 0;
    std::uint8_t camera_id_ = 0;
    std::uint32_t saturated_samples_ = 0;
};

}  // namespace stria
