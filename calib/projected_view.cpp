#include "calib/projected_view.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "firmware/core/median.h"

namespace stria {
namespace {

constexpr double kStraySigmas = 8;

/// Orthonormal basis of the columns.
Eigen::MatrixXd basis_of(const Eigen::MatrixXd& columns) {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
    return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
}

/// Limit for strays among rows [from, to): a view whose rows are all far off has none.
double stray_limit(const Eigen::VectorXd& residual, Eigen::Index from, Eigen::Index to) {
    std::vector<double> sizes;
    for (Eigen::Index row = from; row < to; ++row) sizes.push_back(std::abs(residual[row]));
    return kStraySigmas * (sizes.empty() ? 1.0 : std::max(1.0, 1.4826 * median(sizes)));
}

}  // namespace

Eigen::MatrixXd excess_of_shared(const ViewData& data, const Eigen::MatrixXd& rows,
                                 const CornerNoise& noise, double pitch_mm) {
    Eigen::MatrixXd excess = Eigen::MatrixXd::Zero(rows.cols(), rows.cols());
    if (noise.shared == 0) return excess;
    const auto& corners = data.corners;
    for (std::size_t first = 0, last = 0; first < corners.size(); first = last) {
        std::vector<Eigen::Vector2d> on_board;
        for (last = first; last < corners.size() && corners[last].s == corners[first].s; ++last)
            on_board.push_back(corners[last].on_board.head<2>() / pitch_mm);
        const auto count = static_cast<Eigen::Index>(on_board.size());
        const double variance = std::pow(noise.sigma_px / corners[first].sigma_px, 2);
        const Eigen::MatrixXd beyond = variance * corner_correlation(on_board, noise) -
                                       Eigen::MatrixXd::Identity(count, count);
        for (Eigen::Index c = 0; c < 2; ++c) {
            const Eigen::MatrixXd own =
                rows(Eigen::seqN(2 * static_cast<Eigen::Index>(first) + c, count, 2), Eigen::all);
            excess += own.transpose() * beyond * own;
        }
    }
    return excess;
}

Eigen::MatrixXd ProjectedView::scatter(const CornerNoise& noise, double pitch_mm) const {
    return information() + excess_of_shared(data, by_mode, noise, pitch_mm);
}

ProjectedView projected_view(const ScannerModel& model, const Eigen::MatrixXd& modes,
                             ViewData data) {
    ViewRows rows = view_rows(model, modes, data);
    ProjectedView view;
    view.use.assign(static_cast<std::size_t>(rows.residual.size()), 1);
    for (int round = 0; round < 3; ++round) {
        view.pose_basis = basis_of(rows.by_pose);
        view.residual =
            rows.residual - view.pose_basis * (view.pose_basis.transpose() * rows.residual);
        const auto corner_rows = 2 * static_cast<Eigen::Index>(data.corners.size());
        const double corner_limit = stray_limit(view.residual, 0, corner_rows);
        const double stripe_limit = stray_limit(view.residual, corner_rows, view.residual.size());
        bool clean = true;
        for (Eigen::Index row = 0; row < view.residual.size(); ++row) {
            const double limit = row < corner_rows ? corner_limit : stripe_limit;
            if (std::abs(view.residual[row]) < limit || round == 2) continue;
            rows.residual[row] = 0;
            rows.by_mode.row(row).setZero();
            rows.by_pose.row(row).setZero();
            view.use[static_cast<std::size_t>(row)] = 0;
            clean = false;
        }
        if (clean) break;
    }
    view.by_mode = rows.by_mode - view.pose_basis * (view.pose_basis.transpose() * rows.by_mode);
    view.data = std::move(data);
    return view;
}

}  // namespace stria
