#include "calib/calibration_warnings.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <sstream>

namespace stria {
namespace {

constexpr double kDegrees = 57.29577951308232;

std::string text(double value, int digits = 3) {
    std::ostringstream out;
    out.precision(digits);
    out << value;
    return out.str();
}

double widest_angle_rad(const std::vector<Eigen::Vector3d>& directions) {
    double widest = 0;
    for (std::size_t i = 0; i < directions.size(); ++i)
        for (std::size_t j = i + 1; j < directions.size(); ++j)
            widest = std::max(widest, std::atan2(directions[i].cross(directions[j]).norm(),
                                                 directions[i].dot(directions[j])));
    return widest;
}

double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Standard deviations of points along their principal directions, largest first.
Eigen::Vector3d spreads(const std::vector<Eigen::Vector3d>& points) {
    if (points.size() < 3) return Eigen::Vector3d::Zero();
    Eigen::MatrixXd centred(3, static_cast<Eigen::Index>(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i)
        centred.col(static_cast<Eigen::Index>(i)) = points[i];
    centred.colwise() -= centred.rowwise().mean().eval();
    const Eigen::Matrix3d scatter =
        centred * centred.transpose() / static_cast<double>(points.size());
    return scatter.jacobiSvd().singularValues().cwiseSqrt();
}

void judge_boards(const CalibrationCoverage& coverage, std::vector<std::string>& warnings) {
    const double tilt = widest_angle_rad(coverage.board_normals);
    if (tilt < 15 / kDegrees)
        warnings.push_back("the boards are nearly parallel to each other (at most " +
                           text(tilt * kDegrees) +
                           " deg apart): focal length and depth are weak; tilt the board 20 to 40 "
                           "deg to different sides");
    std::vector<double> depths;
    for (const auto& p : coverage.stripe_in_camera) depths.push_back(p.z());
    const double near = quantile(depths, 0.02), far = quantile(depths, 0.98);
    if (!depths.empty() && far - near < 0.15 * near)
        warnings.push_back("the stripe was seen between " + text(near) + " and " + text(far) +
                           " mm from the camera only: place the board nearer and farther, over the "
                           "whole depth you will scan");
}

void judge_image(const ScannerCalibration& result, const CalibrationCoverage& coverage,
                 std::vector<std::string>& warnings) {
    const CameraModel& camera = result.model.channels[0].camera;
    std::vector<double> us, vs;
    for (const auto& p : coverage.corner_pixels) {
        us.push_back(p.x());
        vs.push_back(p.y());
    }
    const double wide = (quantile(us, 1) - quantile(us, 0)) / camera.width;
    const double high = (quantile(vs, 1) - quantile(vs, 0)) / camera.height;
    if (wide < 0.6 || high < 0.6)
        warnings.push_back("the board covered " + text(100 * wide, 2) +
                           " % of the image's width and " + text(100 * high, 2) +
                           " % of its height: lens distortion is a guess outside; bring the board "
                           "to the image's sides and corners");
    const double sigma_fx = std::sqrt(std::max(0.0, result.model.covariance(0, 0)));
    if (sigma_fx > 3e-3 * camera.fx)
        warnings.push_back("the focal length is known to " + text(100 * sigma_fx / camera.fx, 2) +
                           " % only: add views with the board tilted");
}

void judge_axis(const ScannerCalibration& result, const CalibrationCoverage& coverage,
                std::vector<std::string>& warnings) {
    const MachineKind kind = result.model.channels[0].axis.kind;
    if (kind == MachineKind::swept) return;
    const Eigen::Vector3d spread = spreads(coverage.stripe_in_camera);
    if (spread[1] < 0.05 * spread[0])
        warnings.push_back(
            "the stripes of all views lie nearly on one line of the laser's sheet, about which it "
            "can still turn: place the board at different depths");
    const double travel = quantile(coverage.picture_s, 1) - quantile(coverage.picture_s, 0);
    if (kind == MachineKind::turntable && travel < 60 / kDegrees)
        warnings.push_back("the board was pictured over " + text(travel * kDegrees) +
                           " deg of the table's turn only: its centre is weak below 60 deg; take "
                           "pictures at more positions (off_frames)");
    if (kind == MachineKind::rail && travel < 20)
        warnings.push_back("the board was pictured over " + text(travel) +
                           " mm of the rail only: its direction is weak; take pictures at both "
                           "ends (off_frames)");
}

}  // namespace

std::vector<std::string> calibration_warnings(const ScannerCalibration& result,
                                              const CalibrationCoverage& coverage) {
    std::vector<std::string> warnings;
    judge_boards(coverage, warnings);
    judge_image(result, coverage, warnings);
    judge_axis(result, coverage, warnings);
    if (!result.converged)
        warnings.push_back("the solver stopped before it converged: look at the views' residuals");
    if (result.stripe_sigma_factor > 2 || result.stripe_sigma_factor < 0.5)
        warnings.push_back("stripe points scatter " + text(result.stripe_sigma_factor) +
                           " times what their pulses claim");
    if (result.corner_sigma_px > 0.5)
        warnings.push_back("corners scatter by " + text(result.corner_sigma_px) +
                           " px: a bent board, blur, or a lens model that does not fit");
    const ValidVolume& volume = result.model.volume;
    const double diagonal = (volume.max - volume.min).norm();
    if (result.predicted.median_mm > 1e-4 * diagonal)
        warnings.push_back("the calibration leaves " + text(result.predicted.median_mm) +
                           " mm of uncertainty at a typical point (more than 1e-4 of the volume), "
                           "most of it with " +
                           result.predicted.weakest + ": add views");
    return warnings;
}

}  // namespace stria
