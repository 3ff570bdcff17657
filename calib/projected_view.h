#pragma once
#include <Eigen/Core>
#include <vector>

#include "calib/corner_noise.h"
#include "calib/linear_view.h"

namespace stria {

/// A view's rows with the board's pose projected out: what is left speaks of the model alone. Rows
/// of strays (farther than 8 times what is usual in their view, and than 8 sigma) are zero.
struct ProjectedView {
    ViewData data;
    Eigen::VectorXd residual;       ///< in sigmas, the pose fitted
    Eigen::MatrixXd by_mode;        ///< the same, for the model moved along each mode
    Eigen::MatrixXd pose_basis;     ///< orthonormal, 6 columns: what the pose can take up
    std::vector<std::uint8_t> use;  ///< of each row

    Eigen::MatrixXd information() const { return by_mode.transpose() * by_mode; }
    Eigen::VectorXd gradient() const { return by_mode.transpose() * residual; }
    /// Covariance of gradient() where corners err like that and stripe points independently: the
    /// middle of the sandwich. information() where corners err independently too.
    Eigen::MatrixXd scatter(const CornerNoise& noise, double pitch_mm) const;
};

/// What corners that err like that add to rows' x rows over the view's corners (rows in sigmas, two
/// a corner), for it to be the covariance of rows' x errors. 0 where they err independently.
Eigen::MatrixXd excess_of_shared(const ViewData& data, const Eigen::MatrixXd& rows,
                                 const CornerNoise& noise, double pitch_mm);

ProjectedView projected_view(const ScannerModel& model, const Eigen::MatrixXd& modes,
                             ViewData data);

}  // namespace stria
