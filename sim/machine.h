#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "firmware/core/frame.h"
#include "firmware/core/time.h"
#include "sim/axis_motion.h"
#include "sim/lens.h"
#include "sim/pixel_pattern.h"
#include "sim/scene.h"
#include "sim/scene_geometry.h"
#include "sim/stripe_light.h"
#include "sim/view_light.h"

namespace stria {

constexpr int kQueuedFrames = 16;  ///< frame periods after which an unfetched frame is lost

inline TimeNs ns_from_us(double us) { return static_cast<TimeNs>(std::llround(us * 1000.0)); }

/// What the simulated devices share: virtual time, axis, laser, camera settings, and the picture.
/// Device calls hold `mutex`; render() does not need it and belongs to one thread.
struct Machine {
    struct PowerChange {
        TimeNs time;
        float power;
    };
    /// What one frame needs to be rendered, taken under the lock.
    struct Shot {
        std::vector<Exposure> exposures;  ///< of all rows alike, or of each row in turn
        int rows_apart = 0;               ///< 0: alike; else the number of rows
        double s_middle = 0, travel = 0;
        std::vector<float> ambient_seconds;  ///< of steady light; of all rows alike, or of each row
        double seconds = 0;                  ///< the exposure
        std::int64_t number = 0;             ///< of all frames since power-up
    };

    Machine(const Scene& given, std::uint64_t mixed_seed);

    const Scene scene;
    const std::uint64_t seed;
    SceneGeometry geometry;
    ViewLight light;
    int view = 0;

    std::mutex mutex;
    TimeNs now = 0;
    AxisMotion motion;
    TimeNs logged_until = 0;
    std::uint64_t logged_samples = 0;
    std::vector<PowerChange> powers{{0, 0.0F}};
    TimeNs exposure_ns, period_ns;
    bool running = false;
    TimeNs started_at = 0;
    std::int64_t next_sequence = 0;     ///< since the camera's start
    std::int64_t frames_of_before = 0;  ///< of earlier runs, for numbers that never repeat

    TimeNs interlock_opens_ns() const;  ///< the far future if it never does
    float power_at(TimeNs time) const;
    /// Where the axis really is, the errors that its log does not know included.
    double true_position(TimeNs time) const;
    TimeNs readout_ns() const;  ///< from the first row's exposure to the last one's
    Shot plan_shot(TimeNs true_start, std::int64_t number) const;
    /// How far a frame's axis positions are off, all of them alike.
    double wobble_of(std::int64_t number) const;
    /// Fills the pixels of a frame that has its size.
    void render(const Shot& shot, Frame& frame);

  private:
    void add_exposures(TimeNs begin, TimeNs end, std::vector<Exposure>& out) const;
    std::vector<float> ambient_seconds(TimeNs true_start) const;
    /// Light of the laser in a block's pixels, electrons, added to `electrons`.
    void add_laser(const LightBlock& block, const Shot& shot, int width,
                   std::span<float> electrons) const;
    void render_sharp(const LightBlock& block, const Shot& shot, Frame& frame) const;
    void render_blurred(const std::vector<LightBlock>& blocks, const Shot& shot, Frame& frame);
    /// Multiplies the laser's light by the screen's speckle.
    void grain(std::span<float> laser, int row_begin, int width) const;
    /// Electrons of rows from row_begin on, the pattern still to come, to pixels of the frame.
    void convert(std::span<float> electrons, int row_begin, const Shot& shot, Frame& frame) const;

    /// A picture of the light before and after the lens's spread.
    struct Blur {
        SpotSpread spread;
        std::vector<std::uint16_t> spots;
        std::vector<float> ambient;  ///< electrons a second, spread
        std::vector<float> laser;    ///< electrons of one frame, not yet spread
    };

    const PixelPattern pattern_;
    std::vector<float> laser_gain_;  ///< speckle of SpeckleModel::screen; empty: none
    std::vector<LightBlock> swept_light_, reflected_light_;
    int swept_light_view_ = -1;
    std::unique_ptr<Blur> blur_;  ///< null for a sharp lens
    void spread_ambient(const std::vector<LightBlock>& blocks, int width, int height);
};

}  // namespace stria
