#pragma once
#include <ceres/ceres.h>

#include <array>
#include <vector>

#include "calib/scanner_calibration.h"
#include "calib/scanner_cost.h"
#include "calib/stripe_points.h"

/// For calib's own .cpp files only: it shows Ceres.
namespace stria {

/// The joint problem of one channel: camera, differences of sheet and axis from a base channel, the
/// board's pose at s = 0 in each view; the corners and stripe points in use.
class ScannerProblem {
  public:
    ScannerProblem(const Board& board, const Channel& nominal,
                   const ScannerCalibrationOptions& options);

    struct Corner {
        int id = 0;
        Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
        double s = 0;
        bool use = true;
    };
    struct Stripe {
        StripePoint point;
        double sigma_mm = 1;  ///< of its distance from the sheet, see weigh_stripes()
        bool use = true;
    };
    struct View {
        Vector6d pose = Vector6d::Zero();  ///< camera_from_board at s = 0
        std::vector<Corner> corners;
        std::vector<Stripe> stripes;
    };

    struct Stage {
        bool camera = true;           ///< intrinsics and poses move
        std::vector<int> sheet_free;  ///< entries of the sheet's difference
        std::vector<int> axis_free;
        bool corners = true;      ///< use their residuals
        double huber_sigmas = 0;  ///< 0: plain least squares
        int every = 1;            ///< use each n-th stripe point only
        int max_iterations = 50;
    };
    /// Everything that is ever solved: all of the sheet, and the axis without a turntable's free
    /// turn and shift.
    Stage everything() const;

    /// Solves, then makes the result the new base (all differences 0).
    ceres::Solver::Summary solve(const Stage& stage);
    /// The channel as it stands.
    const Channel& channel() const { return base_; }
    void set_channel(const Channel& channel);
    /// Computes sigma_mm of every stripe point at the present estimate.
    void weigh_stripes();

    /// 2-D residual (px) of a corner; distance (mm) of a stripe point from its sheet.
    Eigen::Vector2d residual(const View& view, const Corner& corner) const;
    double residual_mm(const View& view, const Stripe& stripe) const;

    /// Covariance over parameter_names() of a model with this one channel, priors included; held
    /// parameters have zero rows.
    Eigen::MatrixXd covariance();

    std::vector<View> views;
    double corner_sigma_px = 0.1;
    double stripe_sigma_factor = 1;

  private:
    template <MachineKind kKind>
    void add_residuals(ceres::Problem& problem, const Stage& stage);
    template <MachineKind kKind>
    void add_prior(ceres::Problem& problem);
    void build(ceres::Problem& problem, const Stage& stage);
    void hold(ceres::Problem& problem, const Stage& stage);
    void damp_mirror_turn(ceres::Problem& problem);
    void rebase();

    std::vector<Eigen::Vector3d> points_;
    Channel base_;
    Channel nominal_;
    ScannerCalibrationOptions options_;
    std::array<double, kCameraSize> camera_{};
    std::array<double, kSheetSize> sheet_{};
    std::array<double, 9> axis_{};
};

}  // namespace stria
