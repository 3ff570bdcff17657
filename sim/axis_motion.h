#pragma once
#include <vector>

#include "firmware/core/axis_log.h"
#include "firmware/core/time.h"

namespace stria {

/// Where a simulated axis is at any time: at rest, or on straight pieces of constant speed.
class AxisMotion {
  public:
    /// At rest at s from time 0 on.
    explicit AxisMotion(double s) : pieces_{{0, 0, s, s}} {}

    /// Drops what was to happen after `now` and rests there.
    void halt(TimeNs now);
    /// Appends a piece after the last one: from where that ends to `s` at `speed`.
    /// @param earliest  the piece begins no sooner
    void then_move(TimeNs earliest, double s, double speed);

    double position(TimeNs time) const;
    TimeNs end_time() const { return pieces_.back().end; }
    bool is_moving(TimeNs now) const;
    /// Times in (begin, end) where the speed changes.
    std::vector<TimeNs> corners(TimeNs begin, TimeNs end) const;
    /// What an encoder logs in [begin, end]: every `period` while moving, every 100 periods at
    /// rest, at each change of speed and at both ends; true positions, ascending in time.
    std::vector<AxisSample> samples(TimeNs begin, TimeNs end, TimeNs period) const;

  private:
    struct Piece {
        TimeNs begin, end;
        double s_begin, s_end;
    };
    std::vector<Piece> pieces_;  ///< ascending; between them and after the last the axis rests
};

}  // namespace stria
