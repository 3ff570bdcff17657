#pragma once
#include <cstdint>
#include <vector>

#include "firmware/stripe/detection_levels.h"

/// The inner loops of the fast analysis of swept stripes, written once with Highway and compiled
/// for every instruction set; the best one that the processor has is chosen at run time. They use
/// integers, and single precision without fused operations, a pixel in a lane and never across
/// lanes: every instruction set gives the same bits.
namespace stria::fast {

constexpr int kBatch = 8;     ///< frames between two updates of the backgrounds
constexpr int kLanes = 16;    ///< windows fitted together, whatever a register holds
constexpr int kPadding = 64;  ///< planes of a row are a multiple of that long

/// Pixel x's window closed at the batch's frame `at`; its light was above the threshold, with gaps,
/// for `last` + 1 frames.
struct Closed {
    std::int32_t x;
    std::uint16_t background;  ///< 1/256 DN
    std::uint8_t threshold, at, last;
};

/// What is known about each pixel of one row; planes of padded width.
struct RowPlanes {
    std::uint8_t* background_high;  ///< background in 1/256 DN, high and low byte
    std::uint8_t* background_low;
    std::uint8_t* threshold;
    std::uint8_t* age;    ///< frames since the light rose, the first one included; 0: no light
    std::uint8_t* quiet;  ///< frames since the light was last above the threshold

    std::uint32_t background(int x) const {
        return (std::uint32_t{background_high[x]} << 8) | background_low[x];
    }
    void set_background(int x, std::uint32_t level) const {
        background_high[x] = static_cast<std::uint8_t>(level >> 8);
        background_low[x] = static_cast<std::uint8_t>(level);
    }
    Closed closed(int x, int at, int last) const {
        return {x, static_cast<std::uint16_t>(background(x)), threshold[x],
                static_cast<std::uint8_t>(at), static_cast<std::uint8_t>(last)};
    }
};

/// How long a window may get.
struct WindowLimits {
    int max_pulse_frames;
    int history_frames;
};

/// Frames a window reaches beyond its first and last sample above the threshold.
int margin_frames(int last, const WindowLimits& limits);

/// What a row's samples had besides closing windows.
struct RowState {
    std::uint32_t saturated_samples = 0;
    int oldest = 0;  ///< greatest age of a pixel's light, frames
};

/// Takes kBatch rows of `width` samples of 8 bits; appends the windows that close.
RowState advance_row(const std::uint8_t* const* rows, int width, const RowPlanes& planes,
                     const DetectionLevels& levels, const WindowLimits& limits,
                     std::vector<Closed>& closed);
/// The same for any number of rows, one pixel after the other.
RowState advance_row_plainly(const std::uint8_t* const* rows, int count, int width,
                             const RowPlanes& planes, const DetectionLevels& levels,
                             const WindowLimits& limits, std::vector<Closed>& closed);

/// Up to kLanes windows of the same frames, and their fits; see fit_windows().
struct FitTask {
    // In. Lanes without a window hold copies of one.
    int length = 0;                   ///< samples of a window
    const float* x = nullptr;         ///< their times, mean periods from the window's middle
    const std::uint8_t* y = nullptr;  ///< length x kLanes samples
    float half_aperture = 0;          ///< of an exposure, periods
    float variance_floor = 0, variance_gain = 0, black = 0;  ///< DN^2; DN^2 per DN; DN
    float min_width = 0;       ///< of the exposed pulse, sqrt(w^2 + h^2 / 3), periods; held there
    float max_width = 0;       ///< where a fit may start, periods
    float background[kLanes];  ///< DN, as tracked
    float least[kLanes];       ///< DN above it from which a sample counts as the pulse's
    // Out. Times in periods, of what the fit is of.
    float effective[kLanes];  ///< effective samples of the pulse
    float peak[kLanes];       ///< DN, greatest sample above the tracked background
    float pair[kLanes];       ///< DN, greatest sum of two successive samples above it
    float position[kLanes], sigma[kLanes], width[kLanes];  ///< sigma not inflated
    float height[kLanes];                                  ///< DN, as the samples show it
    float amplitude[kLanes];                               ///< DN, before the aperture blurs it
    float height_sigma[kLanes];
    float level[kLanes];             ///< DN, the fitted background
    float chi_square[kLanes];        ///< sum, not per degree of freedom
    float squares[kLanes];           ///< sum of the squared residuals, DN^2
    std::int32_t converged[kLanes];  ///< 1 or 0
};

/// Fits a Gaussian over a constant background to every window: Fisher scoring of the likelihood of
/// gaussian_fit.h, whose aperture integral is developed to the fourth moment.
void fit_windows(FitTask& task);

/// Instruction sets that can run here, best first: their names, and a way to choose one for tests
/// (empty: the best). Throws std::invalid_argument for one that is not in the list.
std::vector<const char*> instruction_sets();
void use_instruction_set(const char* name);

}  // namespace stria::fast
