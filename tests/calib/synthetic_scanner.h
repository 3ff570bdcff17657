#pragma once
#include <random>

#include "calib/predicted_sigma.h"
#include "calib/scanner_calibration.h"
#include "host/core/scanner_model.h"

/// Scanners, boards in front of them, and the noisy corners and pulses they give: truth for
/// calibration tests, made with host/core's own double functions and no solver.
namespace stria {

/// The machine as drawn.
ScannerModel drawn_scanner(MachineKind kind);

/// The same with a second laser on that camera and axis: from the other side; on a swept machine
/// onto the same mirror, 0.1 rad apart.
ScannerModel drawn_with_two_lasers(MachineKind kind);

/// Standard deviations by which built_scanner() leaves the drawing, one a parameter name.
Eigen::VectorXd building_sigma(const ScannerModel& drawn);

/// A machine built after the drawing: angles off by about a degree, places by 3 mm, focal length
/// by 1 %, a slight bow and mirror gain. Channels share camera and axis as in the drawing.
ScannerModel built_scanner(const ScannerModel& drawn, std::mt19937& rng);

struct SyntheticOptions {
    int views = 15;
    int pictures = 1;  ///< at positions spread over the sweep
    double corner_noise_px = 0.05;
    double stripe_noise_px = 0.1;  ///< across the stripe
    double max_tilt_rad = 0.6;
    double outlier_share = 0.0;    ///< pulses moved anywhere
    double travel_share = 1.0;     ///< of the pictures, about the travel's start
    double turn_rad = 1.4;         ///< of a turntable
    int pixel_step = 8;            ///< pulses on every n-th pixel or row
    int frames = 120;              ///< of a rail's or table's sweep
    bool both_directions = false;  ///< a pass back after each pass
    bool noisy = true;             ///< false: the same sigmas claimed, no noise added
};

/// One view of the board, which stands at `camera_from_board` when s = 0. Stamps are wrong by the
/// axis' delay. Boards steeper than 75 deg against the line of sight are not seen.
CornerView synthetic_view(const ScannerModel& truth, const Board& board,
                          const Rigid3& camera_from_board, const std::string& name,
                          const SyntheticOptions& options, std::mt19937& rng);

/// Views of the board by that scanner.
/// @param poses  where given: receives camera_from_board of each view at s = 0
std::vector<CornerView> synthetic_views(const ScannerModel& truth, const Board& board,
                                        const SyntheticOptions& options, std::mt19937& rng,
                                        std::vector<Rigid3>* poses = nullptr);

/// Views with noise added: corner_noise_px to corners, its claimed sigma to each pulse.
std::vector<CornerView> with_noise(std::vector<CornerView> views, double corner_noise_px,
                                   std::mt19937& rng);

/// Options whose priors are the distribution of built_scanner().
ScannerCalibrationOptions options_of_built_scanners();

/// One pulse of each voxel (edge: 1/24 of the diagonal) and laser that the sweeps crossed on a
/// board.
std::vector<VolumeSample> volume_voxels(const ScannerModel& truth,
                                        const std::vector<CornerView>& views);

/// Points of the volume, each triangulated by truth and by another model from the same pixel and s;
/// the root mean square and the largest distance after the best rigid motion, and the diagonal of
/// the truth's box. The axis (of a table, or a rail's direction) as the same kind of motion of the
/// camera's frame leaves it: its angle, and its distance at the volume's middle.
struct PointError {
    double rms_mm = 0, max_mm = 0, diagonal_mm = 0;
    double axis_deg = 0, axis_mm = 0;
};
PointError point_error(const ScannerModel& truth, const ScannerModel& found,
                       const std::vector<VolumeSample>& samples);
PointError point_error(const ScannerModel& truth, const ScannerModel& found,
                       const std::vector<CornerView>& views);

}  // namespace stria
