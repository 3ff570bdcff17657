#pragma once
#include <Eigen/Core>
#include <random>
#include <vector>

#include "calib/scanner_problem.h"
#include "tests/calib/synthetic_scanner.h"

/// A joint problem linearised once at the truth, by central differences of host/core's own
/// functions and normal equations written out again: an oracle for calib's covariance and a quick
/// stand-in for many calibrations. Shows Ceres.
namespace stria {

/// The problem that calibrate_scanner() ends with, at the truth: sigmas as they are.
ScannerProblem problem_at_truth(const ScannerModel& truth, const Board& board,
                                const std::vector<CornerView>& views,
                                const std::vector<Rigid3>& poses, double corner_noise_px,
                                const ScannerCalibrationOptions& options);

class LinearisedCalibration {
  public:
    /// Sheet and axis have the priors of building_sigma(), the camera none.
    LinearisedCalibration(const ScannerModel& truth, const Board& board,
                          const ScannerProblem& at_truth, const ScannerCalibrationOptions& options);

    /// Errors of the free parameters of a calibration with fresh noise on every corner and stripe
    /// point and a machine drawn anew around the truth.
    Eigen::VectorXd errors_of_a_trial(std::mt19937& rng) const;
    /// Their covariance.
    const Eigen::MatrixXd& covariance() const { return covariance_; }
    /// The free ones among parameter_names(): not the delay, nor a table's rz and tz.
    const std::vector<Eigen::Index>& free() const { return free_; }

  private:
    Eigen::VectorXd residuals(const ScannerProblem& problem,
                              const ScannerProblem::View& view) const;

    ScannerProblem problem_;
    std::vector<Eigen::Index> free_;
    Eigen::VectorXd prior_weight_;          ///< 1 / sigma of the free ones, 0: no prior
    std::vector<Eigen::MatrixXd> reduced_;  ///< of each view, its pose eliminated: rows x free
    Eigen::MatrixXd covariance_;
};

}  // namespace stria
