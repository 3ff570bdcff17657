#pragma once
#include <string>
#include <vector>

#include "host/core/scanner_model.h"

namespace stria {

/// Board poses of one view at several axis positions.
struct PosesAlongAxis {
    std::vector<double> s;
    std::vector<Rigid3> camera_from_board;
};

/// What the board's motion from picture to picture says about the axis.
struct AxisStart {
    AxisModel axis;
    bool from_views = false;  ///< false: no view moved enough, the nominal stands
    /// Motion seen over motion stated (mm per mm, rad per rad); 1 when not from_views.
    double scale = 1;
};

/// Rail direction or table axis from the board's motion; a table keeps the nominal's turn about and
/// place along its axis as nearly as the axis allows. A mirror moves no board: nominal returned.
AxisStart start_axis(const AxisModel& nominal, const std::vector<PosesAlongAxis>& views);

}  // namespace stria
