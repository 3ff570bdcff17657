#pragma once
#include <string>
#include <vector>

#include "firmware/core/frame.h"
#include "host/cli/command.h"
#include "host/cli/demo/demo_measure.h"
#include "host/cli/stage_clock.h"
#include "host/core/range_image.h"
#include "host/core/scan_pose.h"

namespace stria {

struct DemoOptions {
    std::string folder;
    bool quick = false;
    bool fast = false;  ///< the scanner's SIMD kernels analyse the sweeps
};

/// One step of joint registration, for the convergence plot.
struct DemoConvergence {
    std::vector<double> rms_mm;
    std::vector<double> move_mm;
};

/// All that the demo measured and made; the report shows it.
struct DemoResult {
    StageClock clock;
    double calibration_rms_px = 0;
    double calibration_point_rms_mm = 0;  ///< calibrated against true model over the volume
    double calibration_diagonal_mm = 0;   ///< of that volume
    std::vector<std::string> calibration_warnings;
    std::vector<Frame> stripe_frames;  ///< a few, for people to look at
    std::vector<RangeImage> scans;
    std::vector<ScanPose> poses;
    double overlap_rms_mm = 0;
    DemoConvergence convergence;
    std::vector<double> pose_error_rad,
        pose_error_mm;               ///< of each scan after the best common motion
    std::vector<SigmaTruth> sigma;   ///< of each scan
    double sigma_ratio = 0;          ///< median of the scans'
    double median_sigma_mm = 0;      ///< predicted, of all scans' points
    TriMesh open_mesh, filled_mesh;  ///< attribute "error" (1), mm
    double voxel_mm = 0;
    MeshTruth truth;
    ErrorFigures filled;  ///< the filled parts of filled_mesh
};

/// The main job on the simulator, from nothing to a measured mesh: makes the scenes, calibrates on
/// a board, scans from unknown directions, registers, fuses and compares with the truth. Files go
/// to options.folder. Same seed, same files.
DemoResult run_demo(const Context& context, const DemoOptions& options);

}  // namespace stria
