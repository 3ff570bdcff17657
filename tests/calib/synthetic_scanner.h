#pragma once
#include <random>

#include "calib/scanner_calibration.h"
#include "host/core/scanner_model.h"

/// Scanners, boards in front of them, and the noisy corners and pulses they give: truth for
/// calibration tests, made with host/core's own double functions and no solver.
namespace stria {

/// The machine as drawn.
ScannerModel drawn_scanner(MachineKind kind);

/// A machine built after the drawing: angles off by about a degree, places by 3 mm, focal length
/// by 1 %, a slight bow and mirror gain.
ScannerModel built_scanner(const ScannerModel& drawn, std::mt19937& rng);

struct SyntheticOptions {
    int views = 15;
    int pictures = 1;  ///< at positions spread over the sweep
    double corner_noise_px = 0.05;
    double stripe_noise_px = 0.1;  ///< across the stripe
    double max_tilt_rad = 0.6;
    double outlier_share = 0.0;  ///< pulses moved anywhere
    double travel_share = 1.0;   ///< of the pictures, about the travel's start
    int pixel_step = 8;          ///< pulses on every n-th pixel or row
    int frames = 120;            ///< of a rail's or table's sweep
};

/// One view of the board, which stands at `camera_from_board` when s = 0.
CornerView synthetic_view(const ScannerModel& truth, const Board& board,
                          const Rigid3& camera_from_board, const std::string& name,
                          const SyntheticOptions& options, std::mt19937& rng);

/// Views of the board by that scanner.
std::vector<CornerView> synthetic_views(const ScannerModel& truth, const Board& board,
                                        const SyntheticOptions& options, std::mt19937& rng);

/// Points of the volume, each triangulated by truth and by another model from the same pixel and s;
/// the root mean square and the largest distance after the best rigid motion, and the diagonal of
/// the truth's box.
struct PointError {
    double rms_mm = 0, max_mm = 0, diagonal_mm = 0;
};
PointError point_error(const ScannerModel& truth, const ScannerModel& found,
                       const std::vector<CornerView>& views);

}  // namespace stria
