#pragma once
#include <Eigen/Core>
#include <vector>

#include "calib/scanner_calibration.h"
#include "calib/stripe_points.h"

/// Views of a board linearised about a model: what a view measures, or would measure, about it.
namespace stria {

/// Columns r of perturbed()'s parameters with covariance = sum of r r': independent modes of what
/// is not known, each of one standard deviation. Held parameters (zero rows) and ones that copy
/// others cost no mode.
Eigen::MatrixXd covariance_modes(const Eigen::MatrixXd& covariance);

/// Covariance of a machine of which only the drawing is known: the calibration's own priors for
/// sheet and axis, focal length 3 %, centre 3 % of the image, distortion 0.2; held parameters 0.
Eigen::MatrixXd drawing_covariance(const ScannerModel& drawn,
                                   const ScannerCalibrationOptions& options = {});

/// What a view of the board holds for the first channel.
struct ViewData {
    struct Corner {
        Eigen::Vector3d on_board;
        Eigen::Vector2d pixel;
        double s = 0;
        double sigma_px = 0.1;
    };
    struct Stripe {
        Eigen::Vector2d pixel;
        double s = 0;
        double sigma_mm = 0.1;  ///< of its distance from the sheet
        double height_mm = 0;   ///< of the board's surface there above its plane
    };
    Rigid3 camera_from_board;  ///< at s = 0
    std::vector<Corner> corners;
    std::vector<Stripe> stripes;
};

/// Rows: corners (two each), then stripes; all over their sigma, so that noise has unit covariance.
struct ViewRows {
    Eigen::VectorXd residual;  ///< predicted - measured
    Eigen::MatrixXd by_mode;   ///< for the model moved along each mode
    Eigen::MatrixXd by_pose;   ///< for camera_from_board moved by exp(delta), 6 columns
};

/// Where on the board (mm) each stripe point of the view lies.
std::vector<Eigen::Vector2d> stripes_on_board(const Channel& channel, const ViewData& view);

/// Central differences of a twentieth of each mode. Rows of points that leave the camera's sight
/// are zero.
ViewRows view_rows(const ScannerModel& model, const Eigen::MatrixXd& modes, const ViewData& view);

/// Information about the modes that rows hold, the board's pose free.
Eigen::MatrixXd information_of(const ViewRows& rows);

/// Where and how a view would be taken.
struct ViewPlan {
    std::vector<double> picture_s = {0};  ///< axis positions of pictures with the laser off
    double sweep_from = 0, sweep_to = 0;
    double corner_sigma_px = 0.1;
    double stripe_sigma_px = 0.1;              ///< along the row
    double stripe_sigma_mm = 0;                ///< if above 0, instead: from the sheet
    double least_facing = 0.45;                ///< cosine between board normal and line of sight
    int most_corners = 16, most_stripes = 20;  ///< each stands for its share of all
};

/// The view that the model expects of a board there: corners in the pictures and stripe points of
/// the sweep, sigmas made smaller where one stands for several. Fewer than `least_seen` of the
/// corners in all pictures (of boards without markers only pictures that show all of it count), or
/// no stripe: empty lists. Stripe points are taken as one per
/// square of the board.
ViewData expected_view(const ScannerModel& model, const Board& board,
                       const Rigid3& camera_from_board, const ViewPlan& plan,
                       double least_seen = 0.6);

/// A view as measured, its pose found by PnP and its stripe points as the calibration takes them;
/// empty lists if no picture shows the board. Stripe sigmas are the pulses' own times
/// `stripe_sigma_factor`.
ViewData measured_view(const ScannerModel& model, const Board& board, const CornerView& view,
                       double corner_sigma_px, double stripe_sigma_factor, int most_stripes = 600);

}  // namespace stria
