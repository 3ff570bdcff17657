#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "calib/corner_noise.h"
#include "firmware/core/pulse.h"
#include "host/core/board.h"
#include "host/core/image.h"
#include "host/core/rigid3.h"
#include "host/core/scanner_model.h"

namespace stria {

struct CameraView;

/// The board without laser, and where the axis was.
struct BoardImage {
    GreyImage image;
    double s = 0;  ///< mm or rad, as the model's axis
};

/// One placement of the board: pictures with the laser off, and the stripe sweeping over it, `s` of
/// the pulses assigned. Swept machine: axis and board at rest in the camera's eyes. Rail: the board
/// lies still while the head moves. Turntable: the board is fixed on the table and turns with it.
struct CalibrationView {
    std::string name;
    std::vector<BoardImage> images;
    PulseMap pulses;
    std::vector<PulseMap> further_passes = {};  ///< of other lasers, directions or exposures
};

/// Board corners of one picture.
struct BoardCorners {
    std::string name;
    double s = 0;
    std::vector<int> ids;  ///< into board_points()
    std::vector<Eigen::Vector2d> pixels;
};

/// A view whose corners are known. `refusal`: why pictures were not used, one line each.
struct CornerView {
    std::string name;
    std::vector<BoardCorners> corners;
    PulseMap pulses;
    std::vector<std::string> refusals = {};
    std::vector<PulseMap> further_passes = {};
};

/// Finds the board in every picture of a view. Of the pulses an even lattice of cells is kept, so
/// that many views fit in memory: make CornerViews one by one where recordings are large.
CornerView find_corners(const CalibrationView& view, const Board& board);

/// Every picture of the views as the camera's own calibration takes it (camera_calibration.h).
std::vector<CameraView> pictures_of(const std::vector<CornerView>& views);

struct ScannerCalibrationOptions {
    /// Of each laser. With 600, 1 of 20 simulated calibrations had a point off by over 1e-4 of the
    /// diagonal.
    int stripe_points_per_view = 1000;
    /// How far the machine may be from its drawing (one standard deviation). Directions that the
    /// data do not see stay at the drawing; the others do not notice.
    double nominal_angle_sigma_rad = 0.05;
    double nominal_length_sigma_mm = 10;
    double bow_sigma =
        2e-3;  ///< rad per rad^2 (and rad^3): line lasers bend their sheet by about 1 mrad
    double gain_sigma = 0.05;     ///< g2 per rad, g3 per rad^2: about 1 % of the angle at 0.2 rad
    double delay_sigma_ns = 5e6;  ///< of the clocks: a frame of a slow camera
    bool board_warp = false;      ///< also solve how far the board bulges (Board::warp_mm)
    double warp_sigma_mm = 2;     ///< how far it may: a board of 300 mm leaning against a wall
};

struct ScannerViewResult {
    std::string name;
    std::string rejected;  ///< why the view was not used; empty if it was
    int images_used = 0;
    int corners_used = 0;
    int corners_rejected = 0;  ///< farther than 6 sigma from their place
    int stripe_points_used = 0;
    int stripe_points_rejected = 0;  ///< farther than 5 sigma from the sheet
    double rms_px = 0;               ///< corners
    double stripe_rms = 0;           ///< in standard deviations
    Rigid3 camera_from_board;        ///< at s = 0
    std::vector<std::string> notes;  ///< pictures not used and why
};

struct PredictedSigma {
    double median_mm = 0;  ///< 3-D: sqrt of the trace of a point's covariance
    double p95_mm = 0;
    double rms_mm = 0;
    std::string weakest;  ///< parameter that contributes most
};

struct ScannerCalibration {
    ScannerModel model;  ///< covariance, volume and provenance.rms_px filled in
    bool converged = false;
    double rms_px = 0;              ///< sqrt(sum of squared 2-D corner residuals / corners)
    double chi_square_per_dof = 0;  ///< with the sigmas as estimated: near 1
    double corner_sigma_px = 0;     ///< of a coordinate, estimated
    /// How the corners err, from the camera's own fit; independently (shared 0) unless refuted.
    CornerNoise corner_noise;
    /// Estimated sigma of the stripe points over what the pulses claim.
    double stripe_sigma_factor = 0;
    Eigen::Vector2d board_warp_mm = Eigen::Vector2d::Zero();        ///< of the board as used
    Eigen::Vector2d board_warp_sigma_mm = Eigen::Vector2d::Zero();  ///< 0: not solved
    PredictedSigma predicted;  ///< from the covariance, rigid motion removed
    std::vector<ScannerViewResult> views;
    int views_used = 0;
    std::vector<std::string> warnings;  ///< what is weak and what would help
};

/// Everything of a scanner from views of a board, in one least-squares problem: camera, board pose
/// of each view, the sheet of each laser (with bow), and mirror, rail direction or table axis. The
/// channels are lasers that share one camera and one axis. `nominal` gives kind of machine, lens
/// model, apex, fan and beam, and a start within about 2 deg and 5 mm.
/// Corner residuals in px; stripe residuals are distances of the stripe's point on the board from
/// the sheet over their sigma: sigma_t x speed across the sheet for spacetime pulses, sigma_u
/// across it for spatial peaks. Robust passes first, plain least squares at the end; covariance
/// from the final Jacobian in perturbed()'s parameters, weak priors from the nominal included;
/// where neighbouring corners err alike (corner_noise), with what that adds (the sandwich).
/// axis.delay is solved where the passes of the views went both ways, else held at the nominal (one
/// direction cannot tell it from the start angle); the pulses' s are at their stamps, no delay
/// applied. Held too: a turntable's rz and tz, the free turn about and shift along the axis.
/// Turntables and rails need a board that does not look the same turned (looks_same_turned()).
/// Throws stria::Error when the views do not suffice, saying what is missing. Deterministic.
/// Sources: Zhang 2000 (camera), Manakov et al. (mirror with offset), Ceres.
ScannerCalibration calibrate_scanner(const std::vector<CornerView>& views, const Board& board,
                                     const ScannerModel& nominal,
                                     const ScannerCalibrationOptions& options = {});

/// The same, finding the corners first.
ScannerCalibration calibrate_scanner(const std::vector<CalibrationView>& views, const Board& board,
                                     const ScannerModel& nominal,
                                     const ScannerCalibrationOptions& options = {});

}  // namespace stria
