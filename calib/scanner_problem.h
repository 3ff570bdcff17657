#pragma once
#include <ceres/ceres.h>

#include <array>
#include <vector>

#include "calib/scanner_calibration.h"
#include "calib/scanner_cost.h"
#include "calib/stripe_points.h"
#include "calib/valley_solve.h"

/// For calib's own .cpp files only: it shows Ceres.
namespace stria {

/// How far a mirror's m0 may turn from its drawing at the start, in the drawing's standard
/// deviations; a result near it is not called converged.
constexpr double kMostMirrorTurn = 6;

/// The joint problem of channels that share camera and axis, one a laser: camera, differences of
/// sheets and axis from base channels, the board's pose at s = 0 in each view; the corners and
/// stripe points in use.
class ScannerProblem {
  public:
    ScannerProblem(const Board& board, const std::vector<Channel>& nominal,
                   const ScannerCalibrationOptions& options);

    struct Corner {
        int id = 0;
        Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
        double s = 0;
        bool use = true;
    };
    struct Stripe {
        StripePoint point;
        std::size_t channel = 0;
        double sigma_mm = 1;  ///< of its distance from the sheet, see weigh_stripes()
        /// How the board rises there with its warp, likewise.
        Eigen::Vector2d rise = Eigen::Vector2d::Zero();
        bool use = true;
    };
    struct View {
        Vector6d pose = Vector6d::Zero();  ///< camera_from_board at s = 0
        std::vector<Corner> corners;
        std::vector<Stripe> stripes;
    };

    struct Stage {
        bool camera = true;           ///< intrinsics and poses move
        std::vector<int> sheet_free;  ///< entries of each sheet's difference
        std::vector<int> axis_free;
        bool warp = false;            ///< the board's
        bool corners = true;          ///< use their residuals
        double huber_sigmas = 0;      ///< 0: plain least squares
        int every = 1;                ///< use each n-th stripe point only
        bool mirror_bounded = false;  ///< a mirror stays near its drawing, see kMostMirrorTurn
        int max_iterations = 50;
        int valley_iterations = 0;  ///< of valley_solve(), where those do not converge
    };
    /// Everything that is ever solved: all of the sheets, and the axis without a turntable's free
    /// turn and shift; its delay only where the stripe points tell it, see sees_delay().
    Stage everything() const;
    /// True if at least a tenth of the stripe points were swept in the other direction.
    bool sees_delay() const;
    /// Parameters that everything() moves: those that mostly the corners determine (camera, poses,
    /// an axis that moves the board), and those that the stripes do.
    int corner_unknowns() const;
    int stripe_unknowns() const;

    /// Solves, then makes the result the new base (all differences 0).
    SolveEnd solve(const Stage& stage);
    /// Half the chi-square that a stage would start with.
    double cost(const Stage& stage);
    /// The channels as they stand.
    const std::vector<Channel>& channels() const { return base_; }
    /// Camera and axis for all of them; the sheets stay.
    void set_camera_and_axis(const CameraModel& camera, const AxisModel& axis);
    /// Computes sigma_mm and rise of every stripe point at the present estimate.
    void weigh_stripes();

    /// 2-D residual (px) of a corner; distance (mm) of a stripe point from its sheet.
    Eigen::Vector2d residual(const View& view, const Corner& corner) const;
    double residual_mm(const View& view, const Stripe& stripe) const;
    /// Of those in use: both coordinates (px) of the corners; the stripe points' in sigmas.
    std::vector<double> corner_residuals() const;
    std::vector<double> stripe_residuals() const;

    /// Covariance over parameter_names() of a model with these channels, priors included; held
    /// parameters have zero rows, shared ones equal rows.
    Eigen::MatrixXd covariance();

    std::array<double, 2> warp{};                             ///< Board::warp_mm
    Eigen::Vector2d warp_sigma_mm = Eigen::Vector2d::Zero();  ///< by covariance()
    std::vector<View> views;
    double corner_sigma_px = 0.1;
    double stripe_sigma_factor = 1;

  private:
    template <MachineKind kKind>
    void add_corner(ceres::Problem& problem, View& view, const Corner& corner,
                    ceres::LossFunction* loss);
    template <MachineKind kKind>
    void add_residuals(ceres::Problem& problem, const Stage& stage);
    template <MachineKind kKind>
    void add_priors(ceres::Problem& problem);
    void build(ceres::Problem& problem, const Stage& stage);
    void hold(ceres::Problem& problem, const Stage& stage);
    void bound_mirror_turn(ceres::Problem& problem);
    Eigen::MatrixXd names_from_free(const Stage& stage) const;
    void rebase();

    std::vector<BoardPoint> points_;
    BoardRise rise_;
    std::vector<Channel> base_, nominal_;
    ScannerCalibrationOptions options_;
    std::array<double, kCameraSize> camera_{};
    std::vector<std::array<double, kSheetSize>> sheets_;
    std::array<double, kMostAxisSize> axis_{};
};

}  // namespace stria
