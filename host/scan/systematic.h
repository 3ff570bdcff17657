#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "host/core/scanner_model.h"

namespace stria {

/// Where a point of a scan came from.
struct ScanSample {
    Eigen::Vector2d pixel;
    double s = 0;
    Eigen::Vector3d error_direction;  ///< unit, scan frame
};

/// How calibration errors move the points of one scan: per leading error (one standard deviation of
/// an independent combination of parameters) a cubic polynomial in (u, v, s) that gives the
/// displacement along error_direction, mm. The rigid motion that all points share is removed,
/// because the place of the scan frame is nobody's error (accuracy.md B.3).
class SystematicErrors {
  public:
    /// No errors: an unknown covariance.
    SystematicErrors() = default;
    /// @param samples  points spread over the scan, at least 40 to be of use
    SystematicErrors(const ScannerModel& model, const Channel& channel,
                     std::span<const ScanSample> samples);

    int mode_count() const { return static_cast<int>(coefficients_.cols()); }
    /// Displacement (mm) by each mode at a point, strongest mode first.
    Eigen::VectorXd displacements(const Eigen::Vector2d& pixel, double s) const;

  private:
    Eigen::VectorXd basis(const Eigen::Vector2d& pixel, double s) const;
    Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d scale_ = Eigen::Vector3d::Ones();
    Eigen::MatrixXd coefficients_;  ///< basis x modes
};

}  // namespace stria
