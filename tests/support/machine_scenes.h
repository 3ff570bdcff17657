#pragma once
#include <string>

#include "firmware/core/scan_plan.h"
#include "host/core/board.h"
#include "host/core/scanner_model.h"
#include "sim/scene.h"

/// Scenes of the three kinds of machine, for tests from end to end: a board in several placements,
/// and a sphere of radius 25 mm.
namespace stria::test_support {

constexpr double kSphereRadiusMm = 25;

struct MachineScenes {
    Board board;
    Scene board_scene;  ///< one view a placement
    Scene sphere_scene;
    ScanPlan board_plan;  ///< with off frames
    ScanPlan sphere_plan;
};

/// @param seed  of the scanner's deviation from its design, of the placements and of all noise
MachineScenes machine_scenes(MachineKind kind, unsigned seed);

}  // namespace stria::test_support
