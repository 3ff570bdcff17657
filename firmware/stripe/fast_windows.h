#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "firmware/stripe/fast_kernels.h"
#include "firmware/stripe/frame_store.h"
#include "firmware/stripe/pixel_window.h"

namespace stria::fast {

/// What the fits of a band of rows are about, the same for all of its windows.
struct FitSetting {
    const FrameStore& frames;
    const SensorNoise& noise;
    const SpacetimeOptions& options;
};

/// What one row has found.
struct RowFinds {
    std::vector<Pulse> pulses;
    SampleHistogram effective{};
    std::uint32_t saturated_samples = 0;
    int oldest = 0;  ///< greatest age of a pixel's light, frames
    WindowCounts windows;
};

/// Gathers closed windows of a band of rows by their frames, and fits them when kLanes of the same
/// frames are together or at flush().
class WindowBins {
  public:
    /// Windows end with one of the frames [begin, end); `rows` gets what the fits find.
    WindowBins(const FitSetting& setting, int begin, int end, std::vector<RowFinds>& rows);

    /// A window of row y that closed with frame `last_frame`.
    void take(int y, int last_frame, const Closed& closed);
    /// Asks memory for the samples of windows of row y that closed in a batch from `begin` on.
    void prefetch(int y, int begin, const std::vector<Closed>& windows) const;
    void flush();
    /// Leaves a window to the reference's fit.
    void take_plainly(const PixelWindow& window);

  private:
    struct Bin {
        int begin = 0, length = 0, count = 0;
        std::array<PixelWindow, kLanes> windows;
        std::vector<std::uint8_t> samples;  ///< length x kLanes
    };
    Bin& bin_of(int last_frame, int last);
    static void fill(Bin& bin);
    void fit(Bin& bin);
    void settle(const PixelWindow& window, const PulseLevels& levels, const FitTask& task, int lane,
                TimeNs middle, double period);

    FitSetting setting_;
    int first_;
    std::vector<RowFinds>& rows_;
    std::vector<const std::uint8_t*> frames_;  ///< pixels of the store's frames
    int first_frame_;                          ///< of those
    std::size_t width_;
    std::vector<std::unique_ptr<Bin>> bins_;
    std::vector<Bin*> by_frame_and_last_;
};

}  // namespace stria::fast
