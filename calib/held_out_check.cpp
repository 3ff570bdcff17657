#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "calib/certify.h"
#include "calib/projected_view.h"
#include "host/core/p_values.h"

namespace stria {
namespace {

constexpr int kStripePoints = 400;  ///< a view
constexpr int kRegions = 3;         ///< each way over the board
constexpr std::size_t kLeastPoints = 5;
constexpr double kLeastSeen = 0.01;  ///< information in a direction, over the calibration's own

/// Sums over views.
struct Sums {
    double corners = 0, corner_freedom = 0, stripes = 0, stripe_freedom = 0;
    double scatter = 0, scatter_freedom = 0, means = 0, expected = 0, regions = 0;
};

void add_residuals(const ProjectedView& view, Sums& sums) {
    const auto corner_rows = 2 * static_cast<Eigen::Index>(view.data.corners.size());
    for (Eigen::Index i = 0; i < view.residual.size(); ++i) {
        if (view.use[static_cast<std::size_t>(i)] == 0) continue;
        const double freedom = 1 - view.pose_basis.row(i).squaredNorm();
        const double square = view.residual[i] * view.residual[i];
        (i < corner_rows ? sums.corners : sums.stripes) += square;
        (i < corner_rows ? sums.corner_freedom : sums.stripe_freedom) += freedom;
    }
}

/// Along the ray: distance from the board's plane over distance from the sheet.
double plane_over_sheet(const Channel& channel, const ViewData& data,
                        const ViewData::Stripe& stripe) {
    const Rigid3 pose = board_motion(channel, stripe.s) * data.camera_from_board;
    const Eigen::Vector3d ray = ray_through(channel.camera, stripe.pixel);
    return std::abs(pose.rotation.col(2).dot(ray) / sheet_at(channel, stripe.s).normal.dot(ray));
}

/// Distances of the stripe points from the board as its corners alone place it.
void add_distances(const ScannerCalibration& solved, double pitch_mm, const Eigen::MatrixXd& modes,
                   const ProjectedView& view, Sums& sums) {
    const ScannerModel& model = solved.model;
    const ViewData& data = view.data;
    ViewRows rows = view_rows(model, modes, data);
    const auto first = 2 * static_cast<Eigen::Index>(data.corners.size());
    for (Eigen::Index row = 0; row < first; ++row)
        if (view.use[static_cast<std::size_t>(row)] == 0) {
            rows.residual[row] = 0;
            rows.by_mode.row(row).setZero();
            rows.by_pose.row(row).setZero();
        }
    const Eigen::MatrixXd corner_pose = rows.by_pose.topRows(first);
    const Eigen::LDLT<Matrix6d> own(Matrix6d(corner_pose.transpose() * corner_pose));
    const Eigen::VectorXd shift = -own.solve(corner_pose.transpose() * rows.residual.head(first));
    const Matrix6d own_inverse = own.solve(Matrix6d::Identity());
    const Matrix6d pose_covariance =
        own_inverse + own_inverse *
                          excess_of_shared(data, corner_pose, solved.corner_noise, pitch_mm) *
                          own_inverse;
    const Eigen::MatrixXd shift_by_mode =
        -own.solve(corner_pose.transpose() * rows.by_mode.topRows(first));

    struct Region {
        std::vector<double> distances;
        Eigen::RowVectorXd by_mode;
        Eigen::Matrix<double, 1, 6> by_pose = Eigen::Matrix<double, 1, 6>::Zero();
    };
    std::array<Region, std::size_t{kRegions} * kRegions> regions;
    const auto points = stripes_on_board(model.channels.front(), data);
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300), high = -low;
    for (const auto& p : points) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Index row = first + static_cast<Eigen::Index>(i);
        if (view.use[static_cast<std::size_t>(row)] == 0) continue;
        const Eigen::Vector2d share = (points[i] - low).cwiseQuotient(high - low);
        const auto cell = [](double x) { return std::clamp(int(kRegions * x), 0, kRegions - 1); };
        Region& region =
            regions[static_cast<std::size_t>(kRegions * cell(share.y()) + cell(share.x()))];
        const double mm = data.stripes[i].sigma_mm *
                          plane_over_sheet(model.channels.front(), data, data.stripes[i]);
        region.distances.push_back(mm * (rows.residual[row] + rows.by_pose.row(row).dot(shift)));
        if (region.by_mode.size() == 0) region.by_mode = Eigen::RowVectorXd::Zero(modes.cols());
        region.by_mode += mm * (rows.by_mode.row(row) + rows.by_pose.row(row) * shift_by_mode);
        region.by_pose += mm * rows.by_pose.row(row);
    }
    for (const Region& region : regions) {
        if (region.distances.size() < kLeastPoints) continue;
        const double count = static_cast<double>(region.distances.size());
        double mean = 0, squares = 0;
        for (double d : region.distances) mean += d / count;
        for (double d : region.distances) squares += (d - mean) * (d - mean);
        sums.scatter += squares;
        sums.scatter_freedom += count - 1;
        sums.means += mean * mean - squares / (count - 1) / count;
        const Eigen::Matrix<double, 6, 1> pose = region.by_pose.transpose() / count;
        sums.expected += (region.by_mode / count).squaredNorm() + pose.dot(pose_covariance * pose);
        ++sums.regions;
    }
}

/// Gradient of the held-out views by the modes: under the model its covariance is S + H H, S their
/// scatter and H their information, modes being of unit variance.
double score_p_value(const Eigen::MatrixXd& information, const Eigen::MatrixXd& scatter,
                     const Eigen::VectorXd& gradient) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
    const auto seen = (eigen.eigenvalues().array() >= kLeastSeen).count();
    const Eigen::MatrixXd basis = eigen.eigenvectors().rightCols(seen);
    const Eigen::VectorXd along = basis.transpose() * gradient;
    Eigen::MatrixXd covariance = basis.transpose() * scatter * basis;
    covariance.diagonal() += eigen.eigenvalues().tail(seen).cwiseAbs2();
    return chi_square_tail(along.dot(covariance.ldlt().solve(along)), static_cast<int>(seen));
}

double root_mean(double sum, double count) {
    return count > 0 ? std::sqrt(std::max(0.0, sum) / count) : 0;
}

}  // namespace

HeldOutCheck check_held_out(const std::vector<CornerView>& views, const Board& board,
                            const ScannerCalibration& solved) {
    const Board bent = with_warp(board, solved.board_warp_mm);
    const Eigen::MatrixXd modes = covariance_modes(solved.model.covariance);
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(modes.cols(), modes.cols());
    Eigen::MatrixXd scatter = information;
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(modes.cols());
    HeldOutCheck check;
    Sums sums;
    for (const CornerView& view : views) {
        ViewData data = measured_view(solved.model, bent, view, solved.corner_sigma_px,
                                      solved.stripe_sigma_factor, kStripePoints);
        if (data.corners.empty() || data.stripes.empty()) continue;
        const ProjectedView projected = projected_view(solved.model, modes, std::move(data));
        information += projected.information();
        scatter += projected.scatter(solved.corner_noise, board.pitch_mm);
        gradient += projected.gradient();
        add_residuals(projected, sums);
        add_distances(solved, board.pitch_mm, modes, projected, sums);
        ++check.views;
    }
    if (check.views == 0) return check;
    check.corner_rms = root_mean(sums.corners, sums.corner_freedom);
    check.stripe_rms = root_mean(sums.stripes, sums.stripe_freedom);
    check.precision_mm = root_mean(sums.scatter, sums.scatter_freedom);
    check.trueness_mm = root_mean(sums.means, sums.regions);
    check.expected_trueness_mm = root_mean(sums.expected, sums.regions);
    check.p_value = score_p_value(information, scatter, gradient);
    return check;
}

}  // namespace stria
