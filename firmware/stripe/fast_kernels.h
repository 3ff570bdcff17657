#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "firmware/stripe/detection_levels.h"

/// The inner loops of the fast analysis of swept stripes, written once with Highway and compiled
/// for every instruction set; the best one that the processor has is chosen at run time. They use
/// integers, and single precision without fused operations, a pixel in a lane and never across
/// lanes: every instruction set gives the same bits.
namespace stria::fast {

constexpr int kBatch = 8;     ///< frames between two updates of the backgrounds
constexpr int kLanes = 16;    ///< pixels fitted together, whatever a register holds
constexpr int kPadding = 64;  ///< planes of a row are a multiple of that long

/// A pixel's light rose and fell: it was above the threshold, with gaps, for `last` + 1 frames.
struct Closed {
    std::int32_t x;
    std::uint16_t background;  ///< 1/256 DN
    std::uint8_t threshold, last;
    std::uint8_t end;  ///< low byte of the number of the frame behind the window
};

/// What a row's flags say about kLanes pixels.
enum GroupFlag : std::uint8_t {
    kOpen = 1,     ///< there is light at one of them, or there was in the last batch
    kWaiting = 2,  ///< a window of one of them waits
    kFound = 4,    ///< a window of one of them has been fitted
};

/// What is known about each pixel of one row; planes of padded width.
struct RowPlanes {
    std::uint8_t* background_high;  ///< background in 1/256 DN, high and low byte
    std::uint8_t* background_low;
    std::uint8_t* age;    ///< frames since the light rose, the first one included; 0: no light
    std::uint8_t* quiet;  ///< frames since the light was last above the threshold
    // The pixel's window that closed and waits for its neighbours', as Closed.
    std::uint8_t* waiting;  ///< last + 1; 0: none
    std::uint8_t* waiting_end;
    std::uint8_t* waiting_high;  ///< background
    std::uint8_t* waiting_low;
    std::uint8_t* waiting_threshold;
    std::uint8_t* flags;  ///< of groups
    static constexpr std::size_t kCount = 10;

    /// Planes of `stride` bytes, one behind the other.
    static RowPlanes at(std::uint8_t* first, std::size_t stride) {
        const auto plane = [&](std::size_t i) { return first + i * stride; };
        return {plane(0), plane(1), plane(2), plane(3), plane(4),
                plane(5), plane(6), plane(7), plane(8), plane(9)};
    }
    void raise(int x, GroupFlag flag) const { flags[x / kLanes] |= flag; }
    void lower(int x, GroupFlag flag) const {
        flags[x / kLanes] &= static_cast<std::uint8_t>(~flag);
    }
    std::uint32_t background(int x) const {
        return (std::uint32_t{background_high[x]} << 8) | background_low[x];
    }
    void set_background(int x, std::uint32_t level) const {
        background_high[x] = static_cast<std::uint8_t>(level >> 8);
        background_low[x] = static_cast<std::uint8_t>(level);
    }
    /// The pixel's window has closed: true if it waits now, false if another one does.
    bool let_wait(int x, std::uint32_t threshold, int last, std::uint8_t end) const {
        if (waiting[x] != 0) return false;
        waiting[x] = static_cast<std::uint8_t>(last + 1);
        waiting_end[x] = end;
        waiting_high[x] = background_high[x];
        waiting_low[x] = background_low[x];
        waiting_threshold[x] = static_cast<std::uint8_t>(threshold);
        raise(x, kWaiting);
        return true;
    }
    Closed closed(int x, std::uint32_t threshold, int last, std::uint8_t end) const {
        return {x, static_cast<std::uint16_t>(background(x)), static_cast<std::uint8_t>(threshold),
                static_cast<std::uint8_t>(last), end};
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

/// Takes kBatch rows of `width` samples of 8 bits, the first of the frame whose number has the low
/// byte `number`. Windows that close wait in the planes; where one waits already, the second one is
/// appended to `others`.
RowState advance_row(const std::uint8_t* const* rows, int width, const RowPlanes& planes,
                     const DetectionLevels& levels, const WindowLimits& limits, std::uint8_t number,
                     std::vector<Closed>& others);
/// The same for any number of rows, one pixel after the other.
RowState advance_row_plainly(const std::uint8_t* const* rows, int count, int width,
                             const RowPlanes& planes, const DetectionLevels& levels,
                             const WindowLimits& limits, std::uint8_t number,
                             std::vector<Closed>& others);
/// Backgrounds of a row from its first kBatch samples, or any number of them.
void set_backgrounds(const std::uint8_t* const* rows, int width, const RowPlanes& planes,
                     const DetectionLevels& levels);
void set_backgrounds_plainly(const std::uint8_t* const* rows, int count, int begin, int end,
                             const RowPlanes& planes, const DetectionLevels& levels);

/// Windows of kLanes neighbouring pixels, a lane each; frames by their numbers.
struct GroupWindows {
    int x, y;                                 ///< of lane 0
    bool found;                               ///< pixels of it may have a pulse already
    int first, past;                          ///< frames [first, past) hold all of the windows,
    int inner_first, inner_past;              ///< and all of the windows hold these
    std::int32_t begin[kLanes], end[kLanes];  ///< of each window; equal where there is none
    float background[kLanes];                 ///< DN, as tracked
    float level[kLanes];                      ///< DN, the least that counted as light
};

/// Appends the groups of a row whose windows wait for no open neighbour, or one of them for
/// `patience` frames, and takes them off the planes; x is set, y is not. Returns how many of the
/// latest frames the other ones need. `now`: number of frames so far.
int collect_groups(const RowPlanes& planes, int width, int now, int patience,
                   const WindowLimits& limits, std::vector<GroupWindows>& groups);

constexpr int kSampleBins = 128;  ///< of SampleHistogram

/// A group and its fits; see fit_groups().
struct FitTask {
    // In. Times in any unit, from any frame on.
    const GroupWindows* windows = nullptr;
    const std::uint8_t* const* samples = nullptr;  ///< lane l of frame first + i: [i][offset + l]
    std::size_t offset = 0;
    const float* x = nullptr;         ///< times of the frames from `first` on
    const float* interval = nullptr;  ///< half the time between the frames before and behind
    float period = 1;                 ///< mean time between frames
    float widest_gap = 1;             ///< between frames of the sweep
    float period_ns = 1;              ///< the unit
    float half_aperture = 0;          ///< of an exposure
    float variance_floor = 0, variance_gain = 0, black = 0;   ///< DN^2; DN^2 per DN; DN
    float min_snr = 0, min_amplitude_dn = 0, max_misfit = 0;  ///< of SpacetimeOptions
    float max_width = 0;                                      ///< where a fit may start
    // Out.
    std::uint32_t lanes;                 ///< bits of those that hold a window
    std::uint32_t pulses;                ///< bits of the lanes that hold a single clean pulse
    std::uint32_t unsure;                ///< those that the reference has to judge
    std::int32_t effective_bin[kLanes];  ///< as note_effective_samples(); kSampleBins: not counted
    float position[kLanes];
    float sigma[kLanes], width[kLanes];  ///< ns
    float amplitude[kLanes];             ///< DN, before the aperture blurs it
    float level[kLanes];                 ///< DN, the fitted background
    float chi_square[kLanes];            ///< per degree of freedom
};

/// Fits a Gaussian over a constant background to every window of a group, or of two (`other`: the
/// second, or null): Fisher scoring of the likelihood of gaussian_fit.h, whose aperture integral is
/// developed to the fourth moment. Sigma is inflated as sigma_inflation() says.
void fit_groups(FitTask& task, FitTask* other);

/// Instruction sets that can run here, best first: their names, and a way to choose one for tests
/// (empty: the best). Throws std::invalid_argument for one that is not in the list.
std::vector<const char*> instruction_sets();
void use_instruction_set(const char* name);

}  // namespace stria::fast
