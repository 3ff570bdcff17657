#pragma once
#include <functional>
#include <vector>

#include "firmware/core/frame.h"
#include "firmware/core/pulse.h"
#include "firmware/core/sensor_noise.h"
#include "firmware/stripe/frame_follower.h"
#include "firmware/stripe/peak_methods.h"

namespace stria {

/// What counts as a stripe in an image row.
struct SpatialOptions {
    double min_snr = 6.0;         ///< height in the samples over the noise of the background
    double min_amplitude_dn = 3;  ///< DN; keeps quantisation steps of dark images out
    int max_peaks_per_row = 2;    ///< 1..kMaxPulsesPerCell; the strongest are kept
    double min_width_px = 0.4;    ///< Gaussian standard deviation; fits that end there are flagged
    double max_width_px = 12.0;   ///< above is a shape of the scene, not a stripe
    double max_misfit = 0.2;      ///< rms residual over amplitude above which it is no stripe
    int min_run_rows = 1;         ///< above 1: of a row the peaks on the longest chains through
                                  ///< neighbouring rows are kept, none on a shorter chain
    /// Peaks it denies are dropped before runs are looked at; empty: all count. Called from
    /// threads.
    std::function<bool(const Pulse&)> accept = nullptr;
    /// Where a peak is put; the peaks found, and all else about them, are the same.
    PeakMethod method = PeakMethod::maximum_likelihood;
    int threads = 1;        ///< bands of rows; the result does not depend on it
    int sequence_step = 1;  ///< analyser: its frames are every so-manieth of the camera

    /// Throws std::invalid_argument naming field, value and bound.
    void validate() const;
};

/// Stripe crossings of a frame, row after row, strongest (most light) first within a row:
/// maximum-likelihood fit of a pixel-integrated Gaussian over a constant background. u fractional,
/// v = row; width and sigma in px; t_ns the row's time; s and ds_dt 0. The background may vary
/// along the row: each peak has its own, taken from within five widths of it. Rows without a stripe
/// give nothing. Peaks closer than their widths allow to separate are fitted together and flagged.
/// Saturated samples count as "at least full scale". Sigma is the square root of the Cramer-Rao
/// bound at the solution, raised by sqrt(chi-square) where chi-square is significantly above 1.
/// With another options.method u is that method's, sigma what the noise of the samples makes of it
/// (raised likewise), and a peak for which the method has no answer is left out.
std::vector<Pulse> find_peaks(const Frame& frame, const SensorNoise& noise,
                              const SpatialOptions& options = {});

/// Collects the peaks of a sweep: grid width = frames (k, in the order added), height = rows.
/// Duplicates and frames that are not later than the last one are ignored and counted.
class SpatialAnalyser {
  public:
    /// @param height  rows of every frame
    SpatialAnalyser(int height, const SensorNoise& noise, const SpatialOptions& options = {});

    /// Throws std::invalid_argument if the frame has another height.
    void add(const Frame& frame);
    /// The map of all frames so far; the analyser is empty afterwards.
    PulseMap finish();
    int frames_ignored() const { return follower_.ignored(); }

  private:
    int height_ = 0;
    SensorNoise noise_;
    SpatialOptions options_;
    std::vector<std::vector<Pulse>> peaks_of_frame_;
    PulseMap counts_;
    FrameFollower follower_;
};

}  // namespace stria
