#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <vector>

#include "firmware/core/frame.h"
#include "firmware/core/time.h"
#include "sim/axis_motion.h"
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
        double seconds = 0;
        std::int64_t number = 0;  ///< of all frames since power-up
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
    TimeNs readout_ns() const;  ///< from the first row's exposure to the last one's
    Shot plan_shot(TimeNs true_start, std::int64_t number) const;
    /// Fills the pixels of a frame that has its size.
    void render(const Shot& shot, Frame& frame);

  private:
    void add_exposures(TimeNs begin, TimeNs end, std::vector<Exposure>& out) const;
    void render_block(const LightBlock& block, const Shot& shot, Frame& frame) const;

    std::vector<LightBlock> swept_light_;
    int swept_light_view_ = -1;
};

}  // namespace stria
