#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "firmware/stripe/fast_kernels.h"
#include "firmware/stripe/fast_planes.h"
#include "firmware/stripe/frame_store.h"
#include "firmware/stripe/pixel_window.h"

namespace stria::fast {

/// The frames at hand, as the fits read them.
class FrameTable {
  public:
    /// @param period_ns  unit of the times
    FrameTable(const FrameStore& frames, double period_ns);

    int first() const { return first_; }
    int end() const { return first_ + static_cast<int>(pixels_.size()); }
    const std::uint8_t* const* pixels(int frame) const { return pixels_.data() + at(frame); }
    const double* times(int frame) const { return times_.data() + at(frame); }
    /// Times of the frames from `frame` on, counted from frame `middle`'s.
    const float* times(int frame, int middle) const {
        return relative_.data() + at(middle) * times_.size() + at(frame);
    }
    double widest_gap() const { return widest_gap_; }
    /// Half the time between the frames before and behind.
    const float* intervals(int frame) const { return intervals_.data() + at(frame); }
    float half_aperture(int frame) const { return half_apertures_[at(frame)]; }

  private:
    std::size_t at(int frame) const { return static_cast<std::size_t>(frame - first_); }

    int first_;
    std::vector<const std::uint8_t*> pixels_;
    std::vector<double> times_;  ///< of row 0, from the first frame on
    std::vector<float> intervals_, half_apertures_;
    std::vector<float> relative_;  ///< a row for each frame that they are counted from
    double widest_gap_ = 0;        ///< between successive frames
};

/// What the fits of a band of rows are about, the same for all of its windows.
struct FitSetting {
    const FrameStore& frames;
    const SensorNoise& noise;
    const SpacetimeOptions& options;
    double period_ns;  ///< unit of the kernels' times
    int width, height;
    int fresh;                              ///< first of the frames whose rows have just been read
    std::uint8_t laser_id, exposure_index;  ///< of the pulses in the planes
};

/// Fits windows that have closed, kLanes neighbouring pixels together.
class GroupFits {
  public:
    GroupFits(const FitSetting& setting, PulsePlanes& planes, std::vector<RowFinds>& rows);

    /// Takes row y's groups of pixels that wait for no neighbour any more, or have waited long
    /// (`all`: all that wait), and asks memory for their samples. Says in the row's finds which
    /// frames the others need.
    void queue(int y, const RowPlanes& row, bool all);
    /// A window that has no place in the planes.
    void queue(int y, const RowPlanes& row, const Closed& window);
    /// Fits what was queued before the last flip(): memory has had the time to bring it.
    void fit_queued();
    void flip() { std::swap(queue_, next_); }
    /// Leaves a window to the reference's fit.
    void take_plainly(const PixelWindow& window);
    /// Adds how many effective samples the pulses had that the kernels judged.
    void add_effective(SampleHistogram& sum) const;

  private:
    /// A group that is being fitted.
    struct Work {
        FitTask task;
        int middle = 0;  ///< frame from which its times count
        std::vector<std::uint8_t> copies;
        std::vector<const std::uint8_t*> copied;
    };

    /// Frames whose samples memory was asked for last, about a line of the cache.
    struct Asked {
        std::uintptr_t line = 0;
        int first = 0, past = 0;
    };

    void prepare(GroupWindows& group);
    void prefetch(const GroupWindows& group, std::size_t at);
    void fit(const GroupWindows& group, const GroupWindows* other);
    void fill(Work& work, const GroupWindows& group) const;
    static void copy_samples(Work& work, std::size_t size);
    void doubt_pulses_in_gaps(FitTask& task) const;
    void settle(const Work& work);
    void store(const Work& work, TimeNs middle);
    Pulse pulse_of(const Work& work, int lane, TimeNs t_ns) const;

    FitSetting setting_;
    WindowLimits limits_;
    FrameTable table_;
    PulsePlanes& planes_;
    std::vector<RowFinds>& rows_;
    std::vector<GroupWindows> queue_, next_;
    Asked asked_;
    Work one_, other_;
    /// Of the lanes by turns: neighbours have the same number, and would wait for each other.
    std::array<std::array<std::uint32_t, kSampleBins + 1>, 4> effective_{};
};

}  // namespace stria::fast
