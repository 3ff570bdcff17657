#pragma once
#include <string>
#include <vector>

#include "firmware/core/scan_plan.h"
#include "host/core/board.h"
#include "host/core/rigid3.h"

namespace stria {

/// What the demo simulates: a swept-stripe scanner with 0.27 mm pixels at 460 mm (0.4 mm for the
/// quick one), an 8-bit camera of peak SNR 60 and 5 % ambient light.
struct DemoSetup {
    Board board;
    int board_views = 0;
    int object_views = 0;
    ScanPlan board_plan;
    ScanPlan object_plan;
    double voxel_mm = 0;
};
DemoSetup make_demo_setup(bool quick);

/// Writes board.toml and object.toml, the scenes of calibration and of the scans, with their mesh
/// and texture into `folder`. Placements and the scanner's own deviation from its design follow
/// from the seed. Returns nothing that a real user would not know.
void write_demo_scenes(const DemoSetup& setup, const std::string& folder, unsigned seed,
                       bool quick);

}  // namespace stria
