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
