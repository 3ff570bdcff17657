#include "calib/calibration_summary.h"

#include <algorithm>
#include <cmath>

#include "calib/calibration_warnings.h"
#include "calib/predicted_sigma.h"
#include "calib/projected_view.h"
#include "calib/stripe_points.h"

namespace stria {
namespace {

constexpr std::size_t kStripesForPose = 200;  ///< a view, where its board's pose is projected out

void summarise_views(const ScannerProblem& problem, const std::vector<std::size_t>& source,
                     ScannerCalibration& result) {
    double all = 0;
    int corners = 0;
    for (std::size_t i = 0; i < source.size(); ++i) {
        const auto& view = problem.views[i];
        ScannerViewResult& out = result.views[source[i]];
        out.camera_from_board = rigid_from_block(view.pose.data());
        double sum = 0, stripe_sum = 0;
        for (const auto& corner : view.corners) {
            if (!corner.use) {
                ++out.corners_rejected;
                continue;
            }
            sum += problem.residual(view, corner).squaredNorm();
            ++out.corners_used;
        }
        for (const auto& stripe : view.stripes) {
            if (!stripe.use) {
                ++out.stripe_points_rejected;
                continue;
            }
            const double r = problem.residual_mm(view, stripe) / stripe.sigma_mm;
            stripe_sum += r * r;
            ++out.stripe_points_used;
        }
        out.rms_px = out.corners_used > 0 ? std::sqrt(sum / out.corners_used) : 0;
        out.stripe_rms =
            out.stripe_points_used > 0 ? std::sqrt(stripe_sum / out.stripe_points_used) : 0;
        all += sum;
        corners += out.corners_used;
        ++result.views_used;
    }
    result.rms_px = corners > 0 ? std::sqrt(all / corners) : 0;
}

std::vector<VolumeSample> volume_samples(const ScannerProblem& problem) {
    std::vector<VolumeSample> samples;
    for (const auto& view : problem.views)
        for (const auto& stripe : view.stripes)
            if (stripe.use)
                samples.push_back({stripe.point.pixel,
                                   axis_position(stripe.point, problem.channels().front().axis),
                                   stripe.channel});
    return samples;
}

CalibrationCoverage coverage_of(const ScannerProblem& problem) {
    CalibrationCoverage seen;
    for (const auto& view : problem.views) {
        const Rigid3 pose = rigid_from_block(view.pose.data());
        seen.board_normals.push_back(pose.rotation.col(2));
        for (const auto& corner : view.corners) {
            seen.corner_pixels.push_back(corner.pixel);
            seen.picture_s.push_back(corner.s);
        }
        for (const auto& stripe : view.stripes) {
            const Channel& channel = problem.channels()[stripe.channel];
            const Rigid3 at_s =
                board_motion(channel, axis_position(stripe.point, channel.axis)) * pose;
            const Eigen::Vector3d ray = ray_through(channel.camera, stripe.point.pixel);
            const Eigen::Vector3d normal = at_s.rotation.col(2);
            seen.stripe_in_camera.push_back(ray * (normal.dot(at_s.translation) / normal.dot(ray)));
        }
    }
    return seen;
}

/// A view as linear_view takes it; few stripe points of the first channel stand for all.
ViewData view_data(const ScannerProblem& problem, const ScannerProblem::View& view,
                   const std::vector<Eigen::Vector3d>& points) {
    ViewData data;
    data.camera_from_board = rigid_from_block(view.pose.data());
    for (const auto& corner : view.corners)
        if (corner.use)
            data.corners.push_back({points[static_cast<std::size_t>(corner.id)], corner.pixel,
                                    corner.s, problem.corner_sigma_px});
    std::vector<ViewData::Stripe> stripes;
    for (const auto& stripe : view.stripes)
        if (stripe.use && stripe.channel == 0)
            stripes.push_back({stripe.point.pixel,
                               axis_position(stripe.point, problem.channels().front().axis),
                               stripe.sigma_mm * problem.stripe_sigma_factor,
                               stripe.rise.dot(Eigen::Vector2d(problem.warp[0], problem.warp[1]))});
    const std::size_t every = 1 + stripes.size() / kStripesForPose;
    for (std::size_t i = every / 2; i < stripes.size(); i += every) {
        data.stripes.push_back(stripes[i]);
        data.stripes.back().sigma_mm /= std::sqrt(static_cast<double>(every));
    }
    return data;
}

/// Adds to the covariance of a solve that took corners as independent what their shared errors do.
void widen(ScannerModel& model, const ScannerProblem& problem, const Board& board,
           const CornerNoise& noise) {
    const Eigen::MatrixXd modes = covariance_modes(model.covariance);
    const auto points = board_points(board);
    Eigen::MatrixXd excess = Eigen::MatrixXd::Zero(modes.cols(), modes.cols());
    for (const auto& view : problem.views) {
        const auto projected = projected_view(model, modes, view_data(problem, view, points));
        excess += projected.scatter(noise, board.pitch_mm) - projected.information();
    }
    model.covariance += modes * excess * modes.transpose();
}

}  // namespace

void summarise(ScannerProblem& problem, const std::vector<std::size_t>& source,
               const ScannerModel& nominal, const Board& board, const CornerNoise& noise,
               ScannerCalibration& result) {
    summarise_views(problem, source, result);
    result.model = nominal;
    result.model.channels = problem.channels();
    result.model.covariance = problem.covariance();
    result.model.provenance.rms_px = result.rms_px;
    result.corner_sigma_px = problem.corner_sigma_px;
    result.board_warp_mm = {problem.warp[0], problem.warp[1]};
    result.board_warp_sigma_mm = problem.warp_sigma_mm;
    // No less than the joint problem's residuals, which hold what camera and axis do not agree on.
    result.corner_noise = noise.refutes_independence() ? noise : CornerNoise{};
    result.corner_noise.sigma_px = std::max(result.corner_noise.sigma_px, result.corner_sigma_px);
    result.stripe_sigma_factor = problem.stripe_sigma_factor;
    if (result.corner_noise.shared > 0)
        widen(result.model, problem, with_warp(board, result.board_warp_mm), result.corner_noise);

    double chi_square = 0, rows = 0;
    for (double r : problem.corner_residuals()) {
        chi_square += r * r / (problem.corner_sigma_px * problem.corner_sigma_px);
        ++rows;
    }
    for (double r : problem.stripe_residuals()) {
        chi_square += r * r / (problem.stripe_sigma_factor * problem.stripe_sigma_factor);
        ++rows;
    }
    result.chi_square_per_dof =
        chi_square / std::max(1.0, rows - problem.corner_unknowns() - problem.stripe_unknowns());

    std::vector<VolumeSample> samples = volume_samples(problem);
    ValidVolume& volume = result.model.volume;
    bool first = true;
    for (const VolumeSample& sample : samples)
        if (const auto spot =
                triangulate(problem.channels()[sample.channel], sample.pixel, sample.s)) {
            volume.min = first ? spot->point_in_scan : volume.min.cwiseMin(spot->point_in_scan);
            volume.max = first ? spot->point_in_scan : volume.max.cwiseMax(spot->point_in_scan);
            first = false;
        }
    std::vector<VolumeSample> few;
    for (std::size_t i = 0; i < 400 && !samples.empty(); ++i)
        few.push_back(samples[i * samples.size() / 400]);
    result.predicted = predict_sigma(result.model, few);
    const auto warnings = calibration_warnings(result, coverage_of(problem));
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
}

}  // namespace stria
